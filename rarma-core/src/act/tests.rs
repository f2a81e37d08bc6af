//! Every fault, played to the policy; in rooms of their own what is still on its way, and events in any order.

mod any_order;
mod on_its_way;

use super::*;

const STEP_S: f64 = 0.02;
const LIMITS: (f64, f64) = (0.8, 1.2);

/// A controller that counts in whole percent and takes one step's time for an order.
#[derive(Debug, Clone)]
struct Controller {
    program_hz: f64,
    /// Measured over commanded.
    slip: f64,
    overrides: Overrides,
    /// The operator's own, where it is kept apart.
    own: Option<f64>,
    running: bool,
    stopped: bool,
    /// It takes no override beyond these.
    clamp: (f64, f64),
    answers: bool,
}

impl Controller {
    fn new() -> Self {
        Self {
            program_hz: 150.0,
            slip: 1.0,
            overrides: both(1.0),
            own: None,
            running: true,
            stopped: false,
            clamp: (0.1, 2.0),
            answers: true,
        }
    }

    fn take(&mut self, order: ActOrder) {
        match order {
            _ if !self.answers => {}
            ActOrder::Set(to) | ActOrder::GiveBack(to) => {
                let step = |x: f64| (100.0 * x).round() / 100.0;
                self.overrides = Overrides {
                    spindle: step(to.spindle).clamp(self.clamp.0, self.clamp.1),
                    feed: step(to.feed),
                };
            }
            ActOrder::Leave => {
                if let Some(own) = self.own {
                    self.overrides.spindle = own;
                }
            }
        }
    }

    fn reading(&self) -> Reading {
        Reading {
            program_hz: self.program_hz,
            actual_hz: Some(self.slip * self.program_hz * self.overrides.spindle),
            overrides: self.overrides,
            operator: self.own,
            running: self.running,
            stopped: self.stopped,
        }
    }
}

fn both(x: f64) -> Overrides {
    Overrides {
        spindle: x,
        feed: x,
    }
}

/// Policy and controller together.
struct Play {
    policy: Policy,
    controller: Controller,
    t_s: f64,
    chatters: bool,
    sounds: bool,
    proposes: Vec<f64>,
    /// The chatter is believed.
    believes: bool,
    said: Vec<Said>,
    ordered: Vec<ActOrder>,
}

impl Play {
    fn new(act: bool) -> Self {
        let config = ActConfig::limits(act, LIMITS.0, LIMITS.1);
        Self {
            policy: Policy::new(config).expect("in range"),
            controller: Controller::new(),
            t_s: 0.0,
            chatters: false,
            sounds: true,
            proposes: vec![0.92],
            believes: true,
            said: Vec::new(),
            ordered: Vec::new(),
        }
    }

    fn go(&mut self, seconds: f64) -> &mut Self {
        for _ in 0..(seconds / STEP_S).round() as usize {
            self.t_s += STEP_S;
            if self.controller.answers {
                self.policy.reading(self.t_s, &self.controller.reading());
            }
            if self.sounds {
                self.policy.heard(self.t_s, self.chatters);
            }
            if self.policy.asks(self.t_s) {
                let proposes = self.proposes.clone();
                if self.believes {
                    self.policy.advised(self.t_s, &proposes);
                } else {
                    self.policy.disbelieved(self.t_s);
                }
            }
            let step = self.policy.step(self.t_s);
            self.said.extend(step.said);
            if let Some(order) = step.order {
                self.ordered.push(order);
                self.controller.take(order);
            }
        }
        self
    }

    /// Chatter, an order, and it has arrived.
    fn holding() -> Self {
        let mut play = Self::new(true);
        play.go(0.1).chatters = true;
        play.go(0.5).chatters = false;
        play.go(0.5);
        let now = play.controller.overrides;
        assert_eq!(now, both(0.92), "{:?}", play.said);
        assert!(play.said.contains(&Said::Quiet), "{:?}", play.said);
        play.said.clear();
        play.ordered.clear();
        play
    }

    fn ends(&self, why: Why) {
        assert!(self.said.contains(&Said::Ends(why)), "{:?}", self.said);
    }

    /// Nothing is ordered any more, though it chatters on.
    fn is_barred(&mut self) {
        self.ordered.clear();
        self.chatters = true;
        self.go(3.0);
        assert_eq!(self.ordered, []);
    }

    /// The next program is acted on again.
    fn next_program_acts(&mut self) {
        self.controller.running = false;
        self.controller.stopped = false;
        self.chatters = false;
        self.go(0.2).controller.running = true;
        self.chatters = true;
        self.said.clear();
        self.go(0.5);
        let begun = |s: &Said| matches!(s, Said::Ordered(..));
        assert!(self.said.iter().any(begun), "{:?}", self.said);
    }
}

#[test]
fn chatter_is_answered_with_a_speed_and_it_is_held() {
    let mut play = Play::holding();
    play.go(20.0);
    assert!(play.ordered.iter().all(|o| *o == ActOrder::Set(both(0.92))));
    assert_eq!(play.ordered.len(), 1000, "said again for the dead man");
    play.policy.end(play.t_s);
    play.go(0.5).ends(Why::Ended);
    assert_eq!(play.controller.overrides, both(1.0));
    assert!(!play.policy.holds());
}

#[test]
fn the_override_changes_no_faster_than_the_rate() {
    let mut play = Play::new(true);
    play.chatters = true;
    play.go(0.5);
    let mut last = 1.0;
    for order in &play.ordered {
        let ActOrder::Set(to) = order else {
            panic!("{order:?}")
        };
        assert!((to.spindle - last).abs() <= 0.5 * STEP_S + 1e-9);
        assert!((to.feed - to.spindle).abs() < 1e-9);
        last = to.spindle;
    }
    assert!((last - 0.92).abs() < 1e-9);
}

#[test]
fn without_leave_it_only_says_what_it_would_do() {
    let mut play = Play::new(false);
    play.chatters = true;
    play.go(5.0);
    assert_eq!(play.said, [Said::Would(both(1.0), both(0.92))]);
    assert_eq!(play.ordered, []);
}

#[test]
fn a_speed_outside_the_limits_is_passed_over_not_clamped() {
    let mut play = Play::new(true);
    (play.chatters, play.proposes) = (true, vec![0.7, 1.3, 1.1]);
    play.go(0.5);
    assert!(play.said.contains(&Said::Ordered(both(1.0), both(1.1))));
    for none in [vec![], vec![0.79, 1.21, f64::NAN], vec![1.005]] {
        let mut play = Play::new(true);
        (play.chatters, play.proposes) = (true, none);
        play.go(5.0);
        assert_eq!(
            (&play.said[..], &play.ordered[..]),
            (&[Said::NoSpeed][..], &[][..])
        );
    }
}

#[test]
fn an_override_that_the_operator_has_outside_the_limits_is_left() {
    let mut play = Play::new(true);
    play.controller.overrides.spindle = 1.5;
    play.chatters = true;
    play.go(3.0);
    assert_eq!(
        (&play.said[..], &play.ordered[..]),
        (&[Said::OutOfLimits(1.5)][..], &[][..])
    );
}

#[test]
fn a_controller_that_is_gone_is_told_to_go_back_and_bars() {
    let mut play = Play::holding();
    play.controller.answers = false;
    play.go(1.0).ends(Why::Link);
    // What is lost is not seen to be back.
    play.go(2.0);
    assert!(matches!(play.said.last(), Some(Said::NotReturned(_))));
    play.controller.answers = true;
    play.is_barred();
    play.controller.overrides = both(1.0);
    play.next_program_acts();
}

#[test]
fn a_link_that_is_cut_on_the_way_and_comes_back_gives_back() {
    let mut play = Play::new(true);
    play.chatters = true;
    play.go(0.1).controller.answers = false;
    assert!(play.controller.overrides.spindle < 1.0);
    play.go(0.6).ends(Why::Link);
    play.controller.answers = true;
    play.go(0.2);
    assert_eq!(play.controller.overrides, both(1.0));
    assert_eq!(play.said.last(), Some(&Said::Returned));
    play.is_barred();
}

#[test]
fn an_order_that_is_refused_or_clamped_is_given_back() {
    for (clamp, got) in [((1.0, 2.0), 1.0), ((0.95, 2.0), 0.95)] {
        let mut play = Play::new(true);
        play.controller.clamp = clamp;
        play.chatters = true;
        play.go(2.0).ends(Why::Refused(got));
        assert_eq!(play.controller.overrides, both(1.0));
        play.is_barred();
    }
}

#[test]
fn the_operator_wins_wherever_he_turns_it() {
    for spindle in [1.0, 0.91, 0.93, 0.6, 1.5] {
        let mut play = Play::holding();
        play.controller.overrides.spindle = spindle;
        play.go(0.1).ends(Why::Operator);
        assert_eq!(play.ordered.last(), Some(&ActOrder::Leave));
        assert_eq!(play.controller.overrides.spindle, spindle);
        play.is_barred();
        assert_eq!(play.controller.overrides.spindle, spindle);
    }
    let mut play = Play::holding();
    play.controller.overrides.feed = 0.5;
    play.go(0.1).ends(Why::Operator);
    assert_eq!(play.controller.overrides.feed, 0.5);
}

#[test]
fn the_operator_wins_on_the_way_too() {
    let mut play = Play::new(true);
    play.chatters = true;
    play.go(0.1);
    assert!(play.controller.overrides.spindle < 0.97);
    play.controller.overrides = both(1.0);
    play.go(0.06).ends(Why::Operator);
    play.is_barred();
    assert_eq!(play.controller.overrides, both(1.0));
    play.next_program_acts();
}

#[test]
fn the_operator_wins_where_his_override_is_kept_apart() {
    let mut play = Play::new(true);
    play.controller.own = Some(1.0);
    play.chatters = true;
    play.go(0.5).controller.own = Some(1.05);
    play.controller.overrides.spindle *= 1.05;
    play.go(0.1).ends(Why::Operator);
    assert_eq!(play.controller.overrides.spindle, 1.05);
    play.is_barred();
    // Its own dead man has let go: nobody turned anything, and it is not as ordered.
    let mut play = Play::new(true);
    play.controller.own = Some(1.0);
    play.chatters = true;
    play.go(0.5).controller.overrides.spindle = 1.0;
    play.go(0.1).ends(Why::Refused(1.0));
}

#[test]
fn a_measured_speed_that_is_not_the_ordered_one_is_given_back() {
    let mut play = Play::holding();
    play.controller.slip = 0.97;
    play.go(3.0);
    assert_eq!(play.said, []);
    play.controller.slip = 0.94;
    play.go(0.9);
    assert_eq!(play.said, []);
    play.go(0.4);
    let speed = |s: &Said| matches!(s, Said::Ends(Why::Speed(r)) if (r - 0.94).abs() < 1e-9);
    assert!(play.said.iter().any(speed), "{:?}", play.said);
    assert_eq!(play.controller.overrides, both(1.0));
    play.is_barred();
}

#[test]
fn an_alarm_during_the_change_waits_until_the_new_speed_was_heard() {
    let mut play = Play::new(true);
    play.chatters = true;
    play.go(0.06).chatters = false;
    play.go(0.04).chatters = true;
    play.proposes = vec![1.1];
    play.go(1.2);
    let orders = |play: &Play| {
        let begun = |s: &&Said| matches!(s, Said::Ordered(..));
        play.said.iter().filter(begun).count()
    };
    assert_eq!(orders(&play), 1, "{:?}", play.said);
    play.go(0.5);
    assert_eq!(orders(&play), 2, "{:?}", play.said);
    // What is given back in the end is what was before the first.
    play.controller.running = false;
    play.go(0.5).ends(Why::ProgramEnd);
    assert_eq!(play.controller.overrides, both(1.0));
}

#[test]
fn chatter_at_every_speed_is_given_back_after_the_tries() {
    let mut play = Play::new(true);
    play.chatters = true;
    // The next is asked for 1.4, 3.0 and 4.7 s after the beginning.
    for to in [0.92, 1.1, 0.85, 1.15] {
        play.proposes = vec![to];
        play.go(1.3);
    }
    play.ends(Why::NotStable);
    let begun = |s: &&Said| matches!(s, Said::Ordered(..));
    assert_eq!(play.said.iter().filter(begun).count(), 3);
    assert_eq!(play.controller.overrides, both(1.0));
    play.is_barred();
}

#[test]
fn the_end_of_the_program_gives_back_and_the_next_one_acts() {
    let mut play = Play::holding();
    play.controller.running = false;
    play.go(0.5).ends(Why::ProgramEnd);
    assert_eq!(play.controller.overrides, both(1.0));
    assert_eq!(play.said.last(), Some(&Said::Returned));
    play.next_program_acts();
}

#[test]
fn another_programmed_speed_gives_back_and_is_acted_on_anew() {
    let mut play = Play::holding();
    play.controller.program_hz = 120.0;
    play.go(0.5).ends(Why::NewSpeed);
    assert_eq!(play.controller.overrides, both(1.0));
    play.chatters = true;
    play.go(0.5);
    assert_eq!(play.controller.overrides, both(0.92));
}

#[test]
fn an_emergency_stop_gives_back() {
    let mut play = Play::holding();
    play.controller.stopped = true;
    play.go(0.5).ends(Why::Stopped);
    assert_eq!(play.controller.overrides, both(1.0));
    play.is_barred();
    play.next_program_acts();
}

#[test]
fn nobody_who_listens_is_a_reason_to_give_back() {
    let mut play = Play::holding();
    play.sounds = false;
    play.go(1.5).ends(Why::Deaf);
    assert_eq!(play.controller.overrides, both(1.0));
}

#[test]
fn chatter_that_is_not_believed_turns_nothing_until_it_is() {
    let mut play = Play::new(true);
    play.believes = false;
    play.chatters = true;
    play.go(5.0);
    // Said once, though it is asked again.
    assert_eq!(play.said, [Said::NotBelieved]);
    assert_eq!(play.ordered, []);
    assert!(play.policy.disbelieves());
    play.believes = true;
    play.go(2.0);
    assert!(matches!(play.said[1], Said::Ordered(..)), "{:?}", play.said);
    assert!(!play.policy.disbelieves());

    // An order that stands is kept.
    let mut play = Play::holding();
    play.believes = false;
    play.chatters = true;
    play.go(3.0);
    assert_eq!(play.said, [Said::NotBelieved]);
    assert_eq!(play.controller.overrides, both(0.92));
    // The next chatter is another.
    play.chatters = false;
    play.go(0.5);
    assert!(!play.policy.disbelieves());
}

#[test]
fn nothing_is_ordered_where_nothing_is_cut() {
    for change in [
        (|c: &mut Controller| c.running = false) as fn(&mut Controller),
        |c| c.stopped = true,
        |c| c.program_hz = 0.0,
        |c| c.answers = false,
        |c| c.slip = f64::NAN,
    ] {
        let mut play = Play::new(true);
        change(&mut play.controller);
        play.chatters = true;
        play.go(3.0);
        assert_eq!((&play.said[..], &play.ordered[..]), (&[][..], &[][..]));
    }
}

#[test]
fn settings_that_are_none_are_refused() {
    for (least, most) in [
        (0.05, 1.2),
        (0.8, 2.1),
        (1.1, 1.2),
        (0.8, 0.9),
        (1.0, 1.0),
        (f64::NAN, 1.2),
    ] {
        let refused = Policy::new(ActConfig::limits(true, least, most)).err();
        assert_eq!(refused, Some(ActError::Limits), "{least} {most}");
    }
    let usual = ActConfig::limits(true, 0.8, 1.2);
    let rate = Policy::new(ActConfig {
        rate_per_s: 0.0,
        ..usual
    })
    .err();
    assert_eq!(rate, Some(ActError::Rate));
    let tries = Policy::new(ActConfig { tries: 0, ..usual }).err();
    assert_eq!(tries, Some(ActError::Tries));
}
