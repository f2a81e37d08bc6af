//! What the policy is told, and what it answers.

/// Overrides of speed and feed, 1 = as programmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overrides {
    /// Of the spindle's speed.
    pub spindle: f64,
    /// Of the feed.
    pub feed: f64,
}

/// What a controller reports of itself at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Speed as the program has it, without any override, turns a second; 0: none.
    pub program_hz: f64,
    /// Speed that is measured, turns a second, where it is.
    pub actual_hz: Option<f64>,
    /// In force: the operator's and ours together.
    pub overrides: Overrides,
    /// The operator's own override of the speed, where the controller keeps it apart from
    /// ours; else any change that was not ordered is his.
    pub operator: Option<f64>,
    /// A program runs, or is held.
    pub running: bool,
    /// Emergency stop, or an alarm of the controller.
    pub stopped: bool,
}

impl Reading {
    /// The speed that turns, turns a second: measured, else as commanded; none if it stands.
    pub fn spindle_hz(&self) -> Option<f64> {
        let commanded = self.program_hz * self.overrides.spindle;
        let hz = self.actual_hz.unwrap_or(commanded);
        (hz > 0.0 && hz.is_finite()).then_some(hz)
    }

    /// Every number is one.
    pub(super) fn is_sound(&self) -> bool {
        let operator = self.operator.unwrap_or(1.0);
        let all = [
            self.program_hz,
            self.actual_hz.unwrap_or(0.0),
            self.overrides.spindle,
            self.overrides.feed,
            operator,
        ];
        all.iter().all(|x| x.is_finite() && *x >= 0.0)
    }
}

/// What the controller is to be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ActOrder {
    /// Set these. Said again and again while it stands, for the controller's dead man.
    Set(Overrides),
    /// Go back to these, which were in force before the first order.
    GiveBack(Overrides),
    /// Let go, and change nothing: the operator has set what is in force.
    Leave,
}

/// Why an order ended, or is not given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Why {
    /// The operator has turned an override.
    Operator,
    /// The program has ended.
    ProgramEnd,
    /// The program asks for another speed than the one that the order was made for.
    NewSpeed,
    /// Emergency stop, or an alarm of the controller.
    Stopped,
    /// The controller does not report any more.
    Link,
    /// No sound comes any more, so that nobody listens.
    Deaf,
    /// The controller did not take the override: it stayed at this.
    Refused(f64),
    /// The speed that is measured is not the one that is commanded: measured over commanded.
    Speed(f64),
    /// It chatters at every speed that was tried.
    NotStable,
    /// The listening was ended.
    Ended,
}

/// What has happened, to be logged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Said {
    /// This would be ordered, if orders were allowed: from, to.
    Would(Overrides, Overrides),
    /// An order begins: from, to.
    Ordered(Overrides, Overrides),
    /// The controller reports what was ordered.
    Arrived(Overrides),
    /// The chatter has ended at the ordered speed.
    Quiet,
    /// Chatter, but no proposed speed lies within the limits.
    NoSpeed,
    /// Chatter, but not by what is known of the machine: nothing is ordered.
    NotBelieved,
    /// Chatter, but the override in force lies outside the limits: it is the operator's.
    OutOfLimits(f64),
    /// The order ends, and what was before is ordered; or, of [`Why::Operator`], left.
    Ends(Why),
    /// What was before is in force again.
    Returned,
    /// What was before could not be brought back: the controller reports this override.
    NotReturned(f64),
}

/// What one step comes to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Step {
    /// To be sent.
    pub order: Option<ActOrder>,
    /// To be logged.
    pub said: Option<Said>,
}
