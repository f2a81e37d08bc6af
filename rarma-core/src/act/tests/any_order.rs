//! Events in any order: nothing is ever ordered outside the limits, and what was ordered is given back.

use super::*;
use proptest::prelude::*;

/// What may happen, in any order.
#[derive(Debug, Clone)]
enum Event {
    Chatter(bool),
    Sound(bool),
    Propose(Vec<f64>),
    Operator(f64, f64),
    Own(Option<f64>),
    Running(bool),
    Stopped(bool),
    Answers(bool),
    Slip(f64),
    Clamp(f64),
    Ends,
}

fn event() -> impl Strategy<Value = Event> {
    let odd = prop_oneof![0.0..3.0f64, Just(f64::NAN), Just(f64::INFINITY), Just(-1.0)];
    prop_oneof![
        4 => any::<bool>().prop_map(Event::Chatter),
        1 => any::<bool>().prop_map(Event::Sound),
        3 => prop::collection::vec(odd.clone(), 0..5).prop_map(Event::Propose),
        1 => (odd.clone(), odd.clone()).prop_map(|(a, b)| Event::Operator(a, b)),
        1 => prop::option::of(odd.clone()).prop_map(Event::Own),
        2 => any::<bool>().prop_map(Event::Running),
        1 => any::<bool>().prop_map(Event::Stopped),
        2 => any::<bool>().prop_map(Event::Answers),
        1 => odd.clone().prop_map(Event::Slip),
        1 => odd.prop_map(|x| Event::Clamp(if x.is_finite() && x > 0.1 { x.min(2.0) } else { 2.0 })),
        1 => Just(Event::Ends),
    ]
}

proptest! {
    #[test]
    fn nothing_is_ever_ordered_outside_the_limits(
        act in any::<bool>(),
        events in prop::collection::vec((event(), 0.02..1.5f64), 1..40),
    ) {
        let mut play = Play::new(act);
        for (event, seconds) in events {
            match event {
                Event::Chatter(on) => play.chatters = on,
                Event::Sound(on) => play.sounds = on,
                Event::Propose(all) => play.proposes = all,
                Event::Operator(spindle, feed) => {
                    play.controller.overrides = Overrides { spindle, feed };
                }
                Event::Own(own) => play.controller.own = own,
                Event::Running(on) => play.controller.running = on,
                Event::Stopped(on) => play.controller.stopped = on,
                Event::Answers(on) => play.controller.answers = on,
                Event::Slip(slip) => play.controller.slip = slip,
                Event::Clamp(most) => play.controller.clamp.1 = most,
                Event::Ends => play.policy.end(play.t_s),
            }
            let first = play.ordered.len();
            play.go(seconds);
            for order in &play.ordered[first..] {
                let to = match order {
                    ActOrder::Set(to) | ActOrder::GiveBack(to) => *to,
                    ActOrder::Leave => continue,
                };
                prop_assert!(act, "{order:?}");
                let inside = to.spindle >= LIMITS.0 && to.spindle <= LIMITS.1;
                prop_assert!(inside && to.feed.is_finite() && to.feed >= 0.0, "{order:?}");
            }
        }
    }

    #[test]
    fn what_was_ordered_is_given_back_or_left_to_the_operator(
        events in prop::collection::vec((event(), 0.02..1.5f64), 1..20),
    ) {
        let mut play = Play::new(true);
        for (event, seconds) in events {
            match event {
                Event::Chatter(on) => play.chatters = on,
                Event::Propose(all) => play.proposes = all,
                Event::Answers(on) => play.controller.answers = on,
                Event::Sound(on) => play.sounds = on,
                _ => {}
            }
            play.go(seconds);
        }
        play.controller.answers = true;
        play.policy.end(play.t_s);
        play.chatters = false;
        play.go(3.0);
        prop_assert!(!play.policy.holds());
        let lost = play.said.iter().any(|s| matches!(s, Said::NotReturned(_)));
        prop_assert!(lost || play.controller.overrides == both(1.0), "{:?}", play.said);
    }
}
