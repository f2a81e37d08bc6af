//! What a monitoring run says, as the JSON of `rarma monitor` spells it.
//!
//! The same records come from the host run, from decoded wire frames of a box,
//! and from the firmware image on the emulated chip; reports and tests read
//! nothing else.

use rarma_core::decide::Agreement;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What the monitor believes at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// The estimator has not seen enough signal yet.
    Starting,
    /// Nothing is being cut.
    Idle,
    /// Cutting, every mode damped.
    Stable,
    /// A mode is losing its damping, or is undamped for too short a time to be called.
    Warning,
    /// A self-excited mode has been called.
    Chatter,
    /// The samples cannot be trusted; nothing is concluded from them.
    Invalid,
}

/// Where a mode's vibration comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Label {
    /// Undamped, and no multiple of the spindle or tooth frequency.
    SelfExcited,
    /// A damped resonance of the structure.
    Structural,
    /// At a multiple of the spindle or tooth frequency.
    Forced,
}

/// One mode at one instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModeRecord {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Its standard deviation, Hz.
    pub f_sd: f64,
    /// Operational damping ratio, 1.
    pub zeta: f64,
    /// Its standard deviation, 1.
    pub zeta_sd: f64,
    /// Peak amplitude of the vibration in the mode, units of the input.
    pub amplitude: f64,
    /// Where the vibration comes from.
    pub label: Label,
    /// Multiple of the spindle frequency it sits on, if it does.
    pub harmonic: Option<u32>,
    /// What the process adds to the damping of the structural mode, 1; null inside
    /// where no structural mode is there. With a structure only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zeta_process: Option<Option<f64>>,
    /// Its standard deviation, 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zeta_process_sd: Option<Option<f64>>,
}

/// One line of telemetry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// Seconds since the first sample.
    pub t: f64,
    /// The verdict at that instant.
    pub state: State,
    /// Modes sorted by frequency.
    pub modes: Vec<ModeRecord>,
    /// Who hears the mode in question. With two channels only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub agreement: Option<Agreement>,
}

/// One alarm, from call to release.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alarm {
    /// Called at, s.
    pub on: f64,
    /// Released at, s; absent while it still stands at the end of the input.
    pub off: Option<f64>,
    /// Frequency of the mode that raised it, Hz.
    pub f: f64,
    /// Lowest damping ratio seen while it stood, 1.
    pub zeta: f64,
}

/// The whole run in one record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Sampling rate of the input, Hz.
    pub fs: f64,
    /// Samples analysed.
    pub samples: u64,
    /// Model order `[p, q]`.
    pub order: [usize; 2],
    /// Alarms in order of time.
    pub alarms: Vec<Alarm>,
    /// Seconds spent in each state.
    pub state_seconds: BTreeMap<State, f64>,
    /// What was wrong with each channel. With two channels only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<ChannelRecord>>,
}

/// One of two channels over the whole run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelRecord {
    /// Channel of the file, from 0.
    pub channel: usize,
    /// The stretches for which it was left out, in order of time.
    pub faults: Vec<FaultRecord>,
    /// Seconds for which it was left out.
    pub dropped_s: f64,
}

/// A stretch for which a channel was left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// Why: `not-finite`, `missing`, `stuck`, `clipped`, `silent` or `contradicts`.
    pub fault: String,
    /// From, s.
    pub on: f64,
    /// To, s; none if it was never taken back.
    pub off: Option<f64>,
}

/// Everything a run said.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Telemetry lines in order of time.
    pub lines: Vec<Line>,
    /// Closing record.
    pub summary: Summary,
}
