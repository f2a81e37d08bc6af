//! An order takes its time: what arrives when the giving back has begun is not the operator's hand.

use super::*;
use std::collections::VecDeque;

#[test]
fn an_order_that_is_given_back_on_its_way_is_not_taken_for_the_operators_hand() {
    for (first, second) in [(0.88, 0.94), (0.88, 1.12), (1.1, 0.85)] {
        for part_s in [0.02, 0.1, 0.2, 0.3, 0.4] {
            let mut play = Play::new(true);
            (play.chatters, play.proposes) = (true, vec![first]);
            play.go(1.0).chatters = false;
            play.go(0.5).proposes = vec![second];
            play.chatters = true;
            play.go(part_s);
            play.policy.end(play.t_s);
            play.chatters = false;
            play.go(1.0).ends(Why::Ended);
            assert!(
                !play.said.contains(&Said::Ends(Why::Operator)),
                "{:?}",
                play.said
            );
            assert_eq!(play.controller.overrides, both(1.0));
        }
    }
}

/// What was ordered last arrives when the giving back has begun already: that is no operator's hand.
#[test]
fn what_is_still_on_its_way_when_it_is_given_back_is_not_the_operators() {
    for late in 1..=4 {
        // From before the first step of the order to after the last.
        for at in 0..20 {
            let mut play = Play::new(true);
            play.go(0.1);
            play.chatters = true;
            play.go(0.02 * f64::from(at));
            let mut on_its_way = VecDeque::new();
            for k in 0..200 {
                play.t_s += STEP_S;
                play.policy.reading(play.t_s, &play.controller.reading());
                play.policy.heard(play.t_s, false);
                if k == 2 {
                    play.policy.end(play.t_s);
                }
                let step = play.policy.step(play.t_s);
                play.said.extend(step.said);
                on_its_way.extend(step.order);
                if on_its_way.len() > late {
                    let order = on_its_way.pop_front().expect("one");
                    play.controller.take(order);
                }
                // Nothing more is ordered: the rest arrives.
                if step.order.is_none() && k > 2 {
                    on_its_way
                        .drain(..)
                        .for_each(|order| play.controller.take(order));
                }
            }
            let turned = |said: &Said| matches!(said, Said::Ends(Why::Operator));
            assert!(
                !play.said.iter().any(turned),
                "{late} {at}: {:?}",
                play.said
            );
            assert_eq!(
                play.controller.overrides,
                both(1.0),
                "{late} {at}: {:?}",
                play.said
            );
        }
    }
}

/// The same with a controller that is told of steps of a percent, one after the other, as Grbl is.
#[test]
fn a_step_that_is_still_on_its_way_is_given_back_too() {
    for at in 0..40 {
        let mut play = Play::new(true);
        play.go(0.1);
        play.chatters = true;
        let mut last: Option<Overrides> = None;
        let mut step_on_its_way: Option<(f64, u32)> = None;
        for k in 0..300 {
            play.t_s += STEP_S;
            let reading = play.controller.reading();
            // It arrives after 60 ms; the next one waits for a report that shows it.
            let waits = step_on_its_way.is_some();
            step_on_its_way = match step_on_its_way {
                Some((by, 0)) => {
                    play.controller.overrides.spindle += by;
                    play.controller.overrides.feed += by;
                    None
                }
                Some((by, left)) => Some((by, left - 1)),
                None => None,
            };
            play.policy.reading(play.t_s, &reading);
            play.policy.heard(play.t_s, play.chatters);
            if play.policy.asks(play.t_s) {
                play.policy.advised(play.t_s, &[0.92]);
            }
            if k == at {
                play.policy.end(play.t_s);
                play.chatters = false;
            }
            let step = play.policy.step(play.t_s);
            play.said.extend(step.said);
            last = match step.order {
                Some(ActOrder::Set(to) | ActOrder::GiveBack(to)) => Some(to),
                Some(ActOrder::Leave) => None,
                None if play.policy.holds() => last,
                None => None,
            };
            let off = last.map_or(0.0, |to| to.spindle - reading.overrides.spindle);
            if off.abs() > 0.005 && !waits {
                step_on_its_way = Some((0.01 * off.signum(), 2));
            }
        }
        let turned = |said: &Said| matches!(said, Said::Ends(Why::Operator));
        let now = play.controller.overrides.spindle;
        assert!(!play.said.iter().any(turned), "{at}: {:?}", play.said);
        assert!((now - 1.0).abs() < 1e-9, "{at}: {now} {:?}", play.said);
    }
}
