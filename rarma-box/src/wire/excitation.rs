//! Excitation, on the wire: what runs, the response line by line, how it ended.

use rarma_rigs::cers::{ExcitationJob, LineResponse};
use serde::{Deserialize, Serialize};

/// From the box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ExcitationMessage {
    /// A signal has started.
    Started(ExcitationJob),
    /// A line of a stepped sine has been measured.
    Line(LineMessage),
    /// The signal has ended.
    Ended(EndMessage),
}

/// Response of the structure to the force of one axis at one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LineMessage {
    /// Driven axis, 0 is x.
    pub axis: u8,
    /// Line, from 0.
    pub line: u16,
    /// Frequency, Hz.
    pub f_hz: f32,
    /// Amplitude of the force, N.
    pub force_n: f32,
    /// Receptance of x and y, m/N, real and imaginary part, e^{+jωt}.
    pub receptance: [(f32, f32); 2],
    /// Standard deviation of either part of each, m/N.
    pub sd: [f32; 2],
    /// Every force could be relied upon.
    pub trusted: bool,
}

/// How a signal ended.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EndMessage {
    /// Before its time: told to, or the outputs went down.
    pub early: bool,
    /// Periods of the current loop it lasted.
    pub periods: u32,
    /// Of them, with a current that the supply held back.
    pub limited: u32,
    /// Lines measured.
    pub lines: u16,
}

impl From<&LineResponse> for LineMessage {
    fn from(line: &LineResponse) -> Self {
        Self {
            axis: line.axis,
            line: line.line,
            f_hz: line.f_hz,
            force_n: line.force_n,
            receptance: line.receptance.map(|h| (h.re, h.im)),
            sd: line.sd,
            trusted: line.trusted,
        }
    }
}
