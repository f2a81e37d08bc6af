//! What a test has to say: a run may start, is over, or why the test has ended.

use super::reversals::Reversals;
use super::schedule::Run;
use super::trace::AngleMap;
use serde::{Deserialize, Serialize};

/// Why a test ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum RunFault {
    /// The machine did not start.
    NoOnTrigger,
    /// The machine did not move out when the arc should have been over.
    NoOffTrigger,
    /// The machine moved out long before; value: part of the arc's time that had passed.
    EndedEarly(f32),
    /// The feed was off; value: measured over programmed.
    Feed(f32),
    /// The run fits the one before it when it is turned round.
    WrongDirection,
    /// The machine started before the pressure had settled.
    StartedEarly,
    /// The pressure does not settle; value: Pa.
    NotSettled(f32),
    /// The pressure left its set point during a run; value: Pa.
    PressureMoved(f32),
    /// The force no longer holds the bar while the machine moves; value: Pa.
    NotHeld(f32),
    /// The gauge is beyond its limit; value: m.
    GaugeRange(f32),
    /// A reading that is not a number.
    NotFinite,
    /// The feed was right on average and not within the run; value: greatest angle by which
    /// a reversal of an axis came early or late, rad.
    FeedWithin(f32),
    /// The run before it was run the wrong way round: this one fits it when that one is
    /// turned round, or is proven right by its reversals and does not fit it.
    WrongDirectionBefore,
}

/// What proves the direction of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Proof {
    /// Nothing: it is what the schedule says.
    #[default]
    None,
    /// It fits the run before it as it is four times better than turned round: as sure as that one.
    LikeBefore,
    /// The reversals of its own axes stand where they should.
    Reversals,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// The machine may start this run.
    Ready(Run),
    /// A run is over; after the last one the stage is [`Stage::Finished`](super::Stage::Finished).
    Done(RunDone),
    /// The test has ended.
    Failed(RunFault),
}

/// A run that is over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunDone {
    /// Which.
    pub run: Run,
    /// Time to angle, counted from the programmed beginning of the arc.
    pub map: AngleMap<f32>,
    /// Off-trigger, s after the on-trigger.
    pub off_s: f32,
    /// Mean pressure, Pa.
    pub pressure_pa: f32,
    /// Feed by the triggers, m/s.
    pub feed_m_s: f32,
    /// What proves its direction. One run proven by its reversals proves those before it that
    /// are like each other.
    pub proof: Proof,
    /// What its reversals say.
    pub reversals: Reversals,
}
