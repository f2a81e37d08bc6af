//! The state machine that decides which override of the spindle's speed is ordered, when it is kept,
//! and when it is given back.

use super::config::{ActConfig, ActError};
use super::lever::{Lever, SAME, Seen};
use super::told::{ActOrder, Overrides, Reading, Said, Step, Why};

/// Without a report for so long the link is lost, s: ten reports of a controller that is asked
/// twenty times a second. Half would take a busy computer for a cut cable.
const STALE_S: f64 = 0.5;
/// Without sound for so long nobody listens, s: twice what a slow pipe holds back.
const DEAF_S: f64 = 1.0;
/// A controller has reached what it was last told after so long, s; else it has refused.
/// LinuxCNC takes 21 ms, Grbl some tens of milliseconds and a report: ten a second.
const ARRIVE_S: f64 = 1.0;
/// Chatter that still stands so long after the new speed was reached is chatter at that speed,
/// s: an alarm is released 0.6 s after the cut has become stable; twice that.
const LISTEN_S: f64 = 1.2;
/// A measured speed may be off the commanded one by this part: the slip of an asynchronous
/// motor under load is up to 3 %, and half a step of the override.
const SLIP: f64 = 0.04;
/// The measured speed may be further off than [`SLIP`] for this long, s: a spindle of some kW takes
/// half a second to change its speed by 20 %; twice that.
const SLIP_S: f64 = 1.0;
/// A programmed speed that changes by less than this part is the same.
const SAME_SPEED: f64 = 0.01;
/// An order on its way has arrived after so long, s: a byte of Grbl takes 60 ms, a slow report twice as long. With 0 a
/// percent of an order that has just begun can stay; half of it is enough for such bytes; twice of it only tells the
/// return later.
const ARRIVES_S: f64 = 0.3;
/// A try to give back ends so long after it should be there by the rate, s.
const RETURN_S: f64 = 2.0;
/// A proposal this near to what is in force is none.
const LEAST_CHANGE: f64 = 2.0 * SAME;

#[derive(Debug, Clone, Copy, PartialEq)]
struct StandingOverride {
    /// In force before the first order; and the operator's own then.
    before: Overrides,
    operator: Option<f64>,
    /// Programmed then, turns a second.
    program_hz: f64,
    to: Overrides,
    /// Ordered so far on the way.
    sent: Overrides,
    spindle: Lever,
    feed: Option<Lever>,
    /// When the whole of it had been sent.
    sent_s: Option<f64>,
    arrived_s: Option<f64>,
    /// Since when the measured speed has been off.
    slips_s: Option<f64>,
    quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Watching,
    Ordered(StandingOverride),
    Returning {
        to: Overrides,
        spindle: Lever,
        feed: Option<Lever>,
        /// Orders before it have arrived by then.
        settled_s: f64,
        until_s: f64,
        why: Why,
    },
    Barred,
}

/// Decides what is ordered. See the [module](super).
///
/// ```
/// use rarma_core::act::{ActConfig, ActOrder, Overrides, Policy, Reading};
/// let mut policy = Policy::new(ActConfig::limits(true, 0.8, 1.2)).unwrap();
/// let as_programmed = Overrides { spindle: 1.0, feed: 1.0 };
/// let reading = Reading {
///     program_hz: 150.0, actual_hz: None, overrides: as_programmed, operator: None,
///     running: true, stopped: false,
/// };
/// policy.reading(0.0, &reading);
/// policy.heard(0.0, true);
/// assert!(policy.asks(0.0));
/// policy.advised(0.0, &[1.4, 0.9]);
/// // 1.4 lies outside the limits; 0.9 is approached at 0.5 a second.
/// policy.step(0.0);
/// let Some(ActOrder::Set(overrides)) = policy.step(0.02).order else { panic!() };
/// assert!((overrides.spindle - 0.99).abs() < 1e-9);
/// ```
#[derive(Debug, Clone)]
pub struct Policy {
    config: ActConfig,
    state: State,
    /// The last report and its time, s.
    reading: Option<(f64, Reading)>,
    /// Time of the last sound, s.
    sound_s: Option<f64>,
    /// Since when it chatters, s.
    chatter_s: Option<f64>,
    /// Speeds were proposed for the chatter that is heard now, and none was ordered: they are not asked
    /// for again.
    answered: bool,
    /// The chatter that is heard now was not believed, at this time, s.
    disbelieved_s: Option<f64>,
    tries: u32,
    /// To be logged with the next step.
    said: Option<Said>,
    now_s: f64,
}

impl Policy {
    /// Nothing is ordered yet.
    ///
    /// # Errors
    /// The first setting that is out of range.
    pub fn new(config: ActConfig) -> Result<Self, ActError> {
        config.validate()?;
        Ok(Self {
            config,
            state: State::Watching,
            reading: None,
            sound_s: None,
            chatter_s: None,
            answered: false,
            disbelieved_s: None,
            tries: 0,
            said: None,
            now_s: 0.0,
        })
    }

    /// The controller has reported. A report with a number that is none is passed over.
    pub fn reading(&mut self, t_s: f64, reading: &Reading) {
        if reading.is_sound() {
            self.reading = Some((t_s, *reading));
        }
    }

    /// The link has failed: what was reported counts no more.
    pub fn lost(&mut self) {
        self.reading = None;
    }

    /// Sound was heard until now, and it chatters, or does not.
    pub fn heard(&mut self, t_s: f64, chatters: bool) {
        self.sound_s = Some(t_s);
        if !chatters {
            self.chatter_s = None;
            self.answered = false;
            self.disbelieved_s = None;
        } else if self.chatter_s.is_none() {
            self.chatter_s = Some(t_s);
        }
    }

    /// Whether speeds are to be proposed now, see [`advised`](Self::advised).
    pub fn asks(&self, t_s: f64) -> bool {
        let Some(since_s) = self.chatter_s else {
            return false;
        };
        let Some(reading) = self.fresh(t_s) else {
            return false;
        };
        let cuts = reading.running && !reading.stopped && reading.spindle_hz().is_some();
        if self.answered || !cuts || !self.hears(t_s) {
            return false;
        }
        if self.disbelieved_s.is_some_and(|at_s| t_s - at_s < LISTEN_S) {
            return false;
        }
        match &self.state {
            State::Watching => true,
            State::Ordered(order) => order
                .arrived_s
                .is_some_and(|arrived_s| since_s > arrived_s || t_s - arrived_s >= LISTEN_S),
            State::Returning { .. } | State::Barred => false,
        }
    }

    /// These overrides are proposed, the best first; none: no stable speed. What was not
    /// [asked](Self::asks) for is passed over.
    pub fn advised(&mut self, t_s: f64, overrides: &[f64]) {
        if !self.asks(t_s) {
            return;
        }
        let Some(reading) = self.fresh(t_s).copied() else {
            return;
        };
        self.answered = true;
        self.disbelieved_s = None;
        let now = reading.overrides;
        if !self.config.allows(now.spindle) {
            self.said = Some(Said::OutOfLimits(now.spindle));
            return;
        }
        let fits =
            |to: &&f64| self.config.allows(**to) && (**to - now.spindle).abs() > LEAST_CHANGE;
        let to = overrides.iter().find(fits).copied();
        let standing = match self.state {
            State::Ordered(standing) => Some(standing),
            _ => None,
        };
        let spent = self.tries >= self.config.tries;
        let Some(spindle) = to.filter(|_| !spent) else {
            match standing {
                Some(standing) => self.give_up(&standing, t_s, Why::NotStable),
                None => self.said = Some(Said::NoSpeed),
            }
            return;
        };
        let before = standing.map_or(now, |s| s.before);
        let to = self.with_feed(before, spindle);
        if !self.config.act {
            self.said = Some(Said::Would(now, to));
            return;
        }
        self.tries += 1;
        self.answered = false;
        self.said = Some(Said::Ordered(now, to));
        self.now_s = t_s;
        self.state = State::Ordered(StandingOverride {
            before,
            operator: standing.map_or(reading.operator, |s| s.operator),
            program_hz: standing.map_or(reading.program_hz, |s| s.program_hz),
            to,
            sent: self.with_feed(before, now.spindle),
            spindle: Lever::new(now.spindle, spindle),
            feed: self.feed_lever(&reading, to.feed),
            sent_s: None,
            arrived_s: None,
            slips_s: None,
            quiet: false,
        });
    }

    /// The chatter that is heard is not believed: nothing is ordered, and an order that stands is kept. It is asked again
    /// while it stands, for its frequency may become another. What was not [asked](Self::asks) for is passed over.
    pub fn disbelieved(&mut self, t_s: f64) {
        if !self.asks(t_s) {
            return;
        }
        if !self.disbelieves() {
            self.said = Some(Said::NotBelieved);
        }
        self.disbelieved_s = Some(t_s);
    }

    /// The chatter that is heard now was not believed, and nothing has been ordered for it.
    pub fn disbelieves(&self) -> bool {
        self.disbelieved_s.is_some()
    }

    /// One step: to be made some fifty times a second, whatever has happened.
    pub fn step(&mut self, t_s: f64) -> Step {
        let dt_s = (t_s - self.now_s).max(0.0);
        self.now_s = t_s;
        let reading = self.fresh(t_s).copied();
        if reading.is_some_and(|r| !r.running) && matches!(self.state, State::Barred) {
            self.state = State::Watching;
        }
        if reading.is_some_and(|r| !r.running) {
            self.tries = 0;
        }
        // What was said between two steps goes first, alone.
        if let Some(said) = self.said.take() {
            return Step {
                order: self.standing_order(),
                said: Some(said),
            };
        }
        match self.state {
            State::Watching | State::Barred => Step::default(),
            State::Ordered(standing) => self.ordered(standing, reading.as_ref(), t_s, dt_s),
            State::Returning { .. } => self.returning(reading.as_ref(), t_s),
        }
    }

    /// An order stands, or is being given back.
    pub fn holds(&self) -> bool {
        matches!(self.state, State::Ordered(_) | State::Returning { .. })
    }

    /// Gives back, if something is ordered: the listening ends.
    pub fn end(&mut self, t_s: f64) {
        if let State::Ordered(standing) = self.state {
            self.give_up(&standing, t_s, Why::Ended);
        }
    }

    fn ordered(
        &mut self,
        mut standing: StandingOverride,
        reading: Option<&Reading>,
        t_s: f64,
        dt_s: f64,
    ) -> Step {
        let Some(reading) = reading else {
            return self.given_up(&standing, t_s, Why::Link);
        };
        if reading.stopped {
            return self.given_up(&standing, t_s, Why::Stopped);
        }
        if !reading.running {
            return self.given_up(&standing, t_s, Why::ProgramEnd);
        }
        let change_hz = (reading.program_hz - standing.program_hz).abs();
        if change_hz > SAME_SPEED * standing.program_hz {
            return self.given_up(&standing, t_s, Why::NewSpeed);
        }
        let spindle = standing.spindle.see(reading.overrides.spindle);
        let feed = standing
            .feed
            .as_mut()
            .map(|f| f.see(reading.overrides.feed));
        let turned = match (standing.operator, reading.operator) {
            (Some(then), Some(now)) => (now - then).abs() > SAME,
            _ => spindle == Seen::Away || feed == Some(Seen::Away),
        };
        if turned {
            self.state = State::Barred;
            return Step {
                order: Some(ActOrder::Leave),
                said: Some(Said::Ends(Why::Operator)),
            };
        }
        // The operator has not moved, and yet it is not what was ordered.
        if spindle == Seen::Away {
            return self.given_up(&standing, t_s, Why::Refused(reading.overrides.spindle));
        }
        if !self.hears(t_s) {
            return self.given_up(&standing, t_s, Why::Deaf);
        }
        let mut said = None;
        if standing.arrived_s.is_none() {
            let there = spindle == Seen::There && feed.is_none_or(|f| f == Seen::There);
            if there && standing.sent_s.is_some() {
                standing.arrived_s = Some(t_s);
                said = Some(Said::Arrived(reading.overrides));
            } else if standing
                .sent_s
                .is_some_and(|sent_s| t_s - sent_s > ARRIVE_S)
            {
                let got = reading.overrides.spindle;
                return self.given_up(&standing, t_s, Why::Refused(got));
            }
        } else if let Some(ratio) = slip(reading) {
            let since_s = *standing.slips_s.get_or_insert(t_s);
            if t_s - since_s > SLIP_S {
                return self.given_up(&standing, t_s, Why::Speed(ratio));
            }
        } else {
            standing.slips_s = None;
            if self.chatter_s.is_none() && !standing.quiet {
                standing.quiet = true;
                said = Some(Said::Quiet);
            }
        }
        let reach = self.config.rate_per_s * dt_s;
        let left = standing.to.spindle - standing.sent.spindle;
        let spindle = standing.sent.spindle + left.clamp(-reach, reach);
        standing.sent = self.with_feed(standing.before, spindle);
        if left.abs() <= reach {
            standing.sent = standing.to;
            standing.sent_s.get_or_insert(t_s);
        }
        self.state = State::Ordered(standing);
        Step {
            order: Some(ActOrder::Set(standing.sent)),
            said,
        }
    }

    fn returning(&mut self, reading: Option<&Reading>, t_s: f64) -> Step {
        let State::Returning {
            to,
            mut spindle,
            mut feed,
            settled_s,
            until_s,
            why,
        } = self.state
        else {
            return Step::default();
        };
        let give_back = Some(ActOrder::GiveBack(to));
        let seen = reading.map(|reading| {
            let feed = feed.as_mut().map(|f| f.see(reading.overrides.feed));
            (spindle.see(reading.overrides.spindle), feed)
        });
        let next = if matches!(why, Why::ProgramEnd | Why::NewSpeed) {
            State::Watching
        } else {
            State::Barred
        };
        match seen {
            Some((Seen::There, None | Some(Seen::There))) if t_s >= settled_s => {
                self.state = next;
                Step {
                    order: None,
                    said: Some(Said::Returned),
                }
            }
            Some((Seen::Away, _) | (_, Some(Seen::Away))) => {
                self.state = State::Barred;
                Step {
                    order: Some(ActOrder::Leave),
                    said: Some(Said::Ends(Why::Operator)),
                }
            }
            _ if t_s > until_s => {
                self.state = State::Barred;
                let last = self.reading.map_or(f64::NAN, |(_, r)| r.overrides.spindle);
                Step {
                    order: give_back,
                    said: Some(Said::NotReturned(last)),
                }
            }
            _ => {
                self.state = State::Returning {
                    to,
                    spindle,
                    feed,
                    settled_s,
                    until_s,
                    why,
                };
                Step {
                    order: give_back,
                    said: None,
                }
            }
        }
    }

    fn given_up(&mut self, standing: &StandingOverride, t_s: f64, why: Why) -> Step {
        self.give_up(standing, t_s, why);
        Step {
            order: self.standing_order(),
            said: self.said.take(),
        }
    }

    /// From now on what was before is ordered.
    fn give_up(&mut self, standing: &StandingOverride, t_s: f64, why: Why) {
        let to = standing.before;
        let now = self.reading.map_or(standing.sent, |(_, r)| r.overrides);
        let watched = standing.feed.is_some();
        let in_flight = (now.spindle - standing.sent.spindle).abs() > SAME
            || (watched && (now.feed - standing.sent.feed).abs() > SAME);
        self.state = State::Returning {
            to,
            settled_s: if in_flight { t_s + ARRIVES_S } else { t_s },
            spindle: Lever::back(now.spindle, standing.sent.spindle, to.spindle),
            feed: watched.then(|| Lever::back(now.feed, standing.sent.feed, to.feed)),
            until_s: t_s + RETURN_S + (now.spindle - to.spindle).abs() / self.config.rate_per_s,
            why,
        };
        self.said = Some(Said::Ends(why));
    }

    /// The order as it stands.
    fn standing_order(&self) -> Option<ActOrder> {
        match &self.state {
            State::Ordered(standing) => Some(ActOrder::Set(standing.sent)),
            State::Returning { to, .. } => Some(ActOrder::GiveBack(*to)),
            State::Watching | State::Barred => None,
        }
    }

    /// The feed follows the speed from what was before.
    fn with_feed(&self, before: Overrides, spindle: f64) -> Overrides {
        let ratio = if self.config.keeps_feed {
            spindle / before.spindle
        } else {
            1.0
        };
        Overrides {
            spindle,
            feed: before.feed * ratio,
        }
    }

    /// The feed is watched where ours and the operator's are one number.
    fn feed_lever(&self, reading: &Reading, to: f64) -> Option<Lever> {
        let watched = self.config.keeps_feed && reading.operator.is_none();
        watched.then(|| Lever::new(reading.overrides.feed, to))
    }

    fn fresh(&self, t_s: f64) -> Option<&Reading> {
        let (at_s, reading) = self.reading.as_ref()?;
        (t_s - at_s <= STALE_S).then_some(reading)
    }

    fn hears(&self, t_s: f64) -> bool {
        self.sound_s.is_some_and(|at_s| t_s - at_s <= DEAF_S)
    }
}

/// Measured over commanded speed, where they differ.
fn slip(reading: &Reading) -> Option<f64> {
    let commanded = reading.program_hz * reading.overrides.spindle;
    let ratio = reading.actual_hz? / commanded;
    (commanded > 0.0 && !((ratio - 1.0).abs() <= SLIP)).then_some(ratio)
}
