//! What a box says, in the words of records.

use crate::record::{Mode, Name};
use rarma_box::wire::ModeMessage;

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

pub fn mode(m: &ModeMessage) -> Mode {
    Mode {
        f_hz: decimal(m.frequency),
        f_sd_hz: decimal(m.frequency_sd).max(0.0),
        zeta: decimal(m.damping),
        zeta_sd: decimal(m.damping_sd).max(0.0),
        amplitude: decimal(m.amplitude).max(0.0),
        label: m.label,
    }
}
