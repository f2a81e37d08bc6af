//! What a box says, in the words of records.

use crate::record::{Label, Mode, Name, State};
use rarma_box::wire::ModeMessage;
use rarma_core::condition::Fault;
use rarma_core::decide;

/// A single as the double with the same shortest digits: 0.02 stays 0.02. What is no number is 0.
pub fn decimal(x: f32) -> f64 {
    if x.is_finite() {
        x.to_string().parse().unwrap_or(0.0)
    } else {
        0.0
    }
}

/// A text from outside, short enough for a line.
pub fn shortened(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(80).collect()
}

/// A name that is written in this program.
pub fn name(text: &str) -> Name {
    Name::new(text).expect("a name of letters")
}

pub fn state(state: decide::State) -> State {
    match state {
        decide::State::Starting => State::Starting,
        decide::State::Idle => State::Idle,
        decide::State::Stable => State::Stable,
        decide::State::Warning => State::Warning,
        decide::State::Chatter => State::Chatter,
        decide::State::Invalid => State::Invalid,
    }
}

/// As the monitor's JSON spells a reason.
pub fn reason(reason: decide::Reason) -> Name {
    name(match reason {
        decide::Reason::None => "none",
        decide::Reason::EstimatorStarting => "estimator-starting",
        decide::Reason::RootsLost => "roots-lost",
        decide::Reason::LevelAtIdle => "level-at-idle",
        decide::Reason::Excited => "excited",
        decide::Reason::Undamped => "undamped",
        decide::Reason::LosingDamping => "losing-damping",
        decide::Reason::ForcedOnly => "forced-only",
        decide::Reason::OriginUnknown => "origin-unknown",
        decide::Reason::Entering => "entering",
        decide::Reason::BlindAtMultiple => "blind-at-multiple",
        decide::Reason::Samples(fault) => match fault {
            Fault::NotFinite => "samples-not-finite",
            Fault::Missing => "samples-missing",
            Fault::Stuck => "samples-stuck",
            Fault::Clipped => "samples-clipped",
        },
    })
}

pub fn mode(m: &ModeMessage) -> Mode {
    Mode {
        f_hz: decimal(m.frequency),
        f_sd_hz: decimal(m.frequency_sd).max(0.0),
        zeta: decimal(m.damping),
        zeta_sd: decimal(m.damping_sd).max(0.0),
        amplitude: decimal(m.amplitude).max(0.0),
        label: match m.label {
            decide::Label::SelfExcited => Label::SelfExcited,
            decide::Label::Structural => Label::Structural,
            decide::Label::Forced => Label::Forced,
        },
    }
}
