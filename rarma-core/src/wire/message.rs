//! What the box and the host tell each other.

use crate::condition::HealthCounts;
use crate::decide::{Label, Reason, State};
use crate::monitor::{MAX_MODES, MonitorConfig, Report};
use crate::real::Real;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// From the host: what to listen to, and how.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MonitorJob {
    /// Settings of the monitor.
    pub monitor: MonitorConfig,
    /// Channel of the source, from 0.
    pub channel: u16,
    /// A verdict is sent this often, s.
    pub every_s: f64,
}

/// From the box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Telemetry {
    /// First message of a run: what is being listened to.
    Started {
        /// Sampling rate of the input, Hz.
        fs_hz: f64,
        /// Model order p.
        p: u8,
        /// Model order q.
        q: u8,
    },
    /// The verdict at one instant, at the rate asked for.
    Verdict(Verdict),
    /// An alarm was called or released, sent at once.
    Alarm(AlarmMessage),
    /// Last message of a run.
    Finished(Finished),
    /// The run cannot go on.
    Refused(Refusal),
}

/// The verdict at one instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Input samples taken; divided by the rate, the time.
    pub sample: u64,
    /// The verdict.
    pub state: State,
    /// Why.
    pub reason: Reason,
    /// Root mean square of the band, input units.
    pub level: f32,
    /// Modes sorted by frequency.
    pub modes: Vec<ModeMessage, MAX_MODES>,
}

/// One mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModeMessage {
    /// Undamped natural frequency, Hz.
    pub frequency: f32,
    /// Standard deviation of it, Hz.
    pub frequency_sd: f32,
    /// Operational damping ratio.
    pub damping: f32,
    /// Standard deviation of it.
    pub damping_sd: f32,
    /// Peak amplitude, input units.
    pub amplitude: f32,
    /// Change of the damping ratio per second.
    pub gradient: f32,
    /// Where the vibration comes from.
    pub label: Label,
    /// Multiple of the spindle frequency it sits on.
    pub harmonic: Option<u32>,
}

/// An alarm was called or released.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AlarmMessage {
    /// Input samples taken.
    pub sample: u64,
    /// Called (true) or released (false).
    pub on: bool,
    /// Frequency of the mode, Hz: at the call, its value; at the release, its
    /// power-weighted mean while the alarm stood.
    pub frequency: f32,
    /// Damping ratio: at the call, its value; at the release, the lowest.
    pub damping: f32,
}

/// Totals of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// Input samples taken.
    pub samples: u64,
    /// Samples spent in each state, in the order of [`State`].
    pub state_samples: [u64; 6],
    /// Bad samples.
    pub health: HealthCounts,
    /// The alarm that still stands: mean frequency (Hz) and lowest damping ratio.
    pub standing: Option<(f32, f32)>,
    /// Longest time one block took, µs by the box's clock.
    pub longest_block_us: u32,
    /// Blocks that took longer than the signal in them lasts.
    pub late_blocks: u32,
    /// Frames the link did not take.
    pub dropped_frames: u32,
}

/// Why a run was refused or broken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The job is out of range; the host checks it beforehand and knows the field.
    Settings,
    /// The job could not be read.
    Job,
    /// The source could not be opened, or is not of a kind the board reads.
    Source,
    /// The source has no such channel.
    Channel,
    /// The source broke off.
    SourceLost,
}

impl Verdict {
    /// A report of the monitor as it is sent.
    pub fn from_report<T: Real>(report: &Report<T>) -> Self {
        let mut modes = Vec::new();
        for mode in report.modes.iter().flatten() {
            // Both hold MAX_MODES: the push cannot fail.
            let _ = modes.push(ModeMessage {
                frequency: mode.frequency.to_f32(),
                frequency_sd: mode.frequency_sd.to_f32(),
                damping: mode.damping.to_f32(),
                damping_sd: mode.damping_sd.to_f32(),
                amplitude: mode.amplitude.to_f32(),
                gradient: mode.gradient.to_f32(),
                label: mode.label,
                harmonic: mode.harmonic,
            });
        }
        Self {
            sample: report.sample,
            state: report.state,
            reason: report.reason,
            level: report.level.to_f32(),
            modes,
        }
    }
}
