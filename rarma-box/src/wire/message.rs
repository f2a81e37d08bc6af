//! What the box and the host tell each other.

use crate::wire::circle::CircleMessage;
use crate::wire::command::{ControlMessage, FaultMessage, Health, Identity, Raw, Reply, Status};
use crate::wire::excitation::ExcitationMessage;
use heapless::Vec;
use rarma_core::condition::{HealthCounts, TachoFault};
use rarma_core::decide::{Amplitude, BINS, Histogram, Label, Mode, Origin, Reason, State};
use rarma_core::monitor::{
    AmplitudeReport, MAX_MODES, MonitorConfig, Report, SpeedSource, SpindleReport,
};
use rarma_core::real::Real;
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
    /// How the amplitude of the followed mode is distributed, once a second.
    Amplitude(HistogramMessage),
    /// Something is wrong with what is known of the spindle, sent at once.
    Notice(NoticeMessage),
    /// The answer to a command.
    Reply(Reply),
    /// A fault, sent at once.
    Fault(FaultMessage),
    /// How things stand, at the rate asked for.
    Status(Status),
    /// Counts, at the rate asked for.
    Health(Health),
    /// Raw samples, while a stream is asked for.
    Raw(Raw),
    /// The box has just started: who it is, and why it started.
    Hello(Identity),
    /// A circle under load.
    Circle(CircleMessage),
    /// Excitation of a spindle.
    Excitation(ExcitationMessage),
    /// Control has changed hands, sent at once.
    Control(ControlMessage),
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
    /// What is known of the spindle.
    pub spindle: SpindleMessage,
    /// What the amplitude of the followed mode says; none while none is followed.
    pub amplitude: Option<AmplitudeMessage>,
}

/// What is known of the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpindleMessage {
    /// Rotations per second, Hz.
    pub hz: Option<f32>,
    /// Who says so.
    pub source: SpeedSource,
    /// Its lines are being removed.
    pub locked: bool,
    /// Half-width of the notch around each removed line, Hz; 0 while none is.
    pub notch_hz: f32,
    /// Power removed, input units squared.
    pub removed_power: f32,
}

/// What the amplitude of the followed mode says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AmplitudeMessage {
    /// Frequency of the mode, Hz.
    pub frequency: f32,
    /// S = Var V/E²V of the squared amplitude V: 1 for noise on a linear mode, 0 for a
    /// steady tone.
    pub scintillation: f32,
    /// What that means.
    pub verdict: Amplitude,
    /// How far S is from a linear mode's, standard deviations of ln S.
    pub z: f32,
}

/// Counts of the squared amplitude of the followed mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HistogramMessage {
    /// Input samples taken.
    pub sample: u64,
    /// Frequency of the mode, Hz.
    pub frequency: f32,
    /// Counts per bin, from 0 up.
    pub counts: [u16; BINS],
    /// Values beyond the last bin.
    pub beyond: u16,
    /// Width of a bin, input units squared.
    pub bin_width: f32,
}

/// A notice and when it came.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NoticeMessage {
    /// Input samples taken.
    pub sample: u64,
    /// What there is to notice.
    pub notice: Notice,
}

/// What the host should know of the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Notice {
    /// The lines in the sound are not those of the speed in the settings. Once a run.
    Contradiction {
        /// Speed in the settings, Hz.
        told_hz: f32,
        /// Speed in the sound, Hz.
        found_hz: f32,
    },
    /// A fault of the tacho has begun.
    Tacho(TachoFault),
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
    /// What else explains it.
    pub origin: Origin,
    /// Time until the damping ratio reaches zero at the present rate, s, where that rate
    /// is certain.
    pub time_left_s: Option<f32>,
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
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Finished {
    /// Input samples taken.
    pub samples: u64,
    /// Samples spent in each state, in the order of [`State`].
    pub state_samples: [u64; 6],
    /// Bad samples.
    pub health: HealthCounts,
    /// Samples for which the spindle's lines were being removed.
    pub locked_samples: u64,
    /// Energy of the removed lines over that of the band, the whole run; 0 to about 1.
    pub removed_fraction: f32,
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
            let _ = modes.push(ModeMessage::from(mode));
        }
        Self {
            sample: report.sample,
            state: report.state,
            reason: report.reason,
            level: report.level.to_f32(),
            modes,
            spindle: SpindleMessage::from(&report.spindle),
            amplitude: report.amplitude.as_ref().map(AmplitudeMessage::from),
        }
    }
}

impl<T: Real> From<&Mode<T>> for ModeMessage {
    fn from(mode: &Mode<T>) -> Self {
        Self {
            frequency: mode.frequency.to_f32(),
            frequency_sd: mode.frequency_sd.to_f32(),
            damping: mode.damping.to_f32(),
            damping_sd: mode.damping_sd.to_f32(),
            amplitude: mode.amplitude.to_f32(),
            gradient: mode.gradient.to_f32(),
            label: mode.label,
            harmonic: mode.harmonic,
            origin: mode.origin,
            time_left_s: mode.time_left_s.map(Real::to_f32),
        }
    }
}

impl<T: Real> From<&SpindleReport<T>> for SpindleMessage {
    fn from(spindle: &SpindleReport<T>) -> Self {
        Self {
            hz: spindle.spindle_hz.map(Real::to_f32),
            source: spindle.source,
            locked: spindle.locked,
            notch_hz: spindle.notch_hz.to_f32(),
            removed_power: spindle.removed_power.to_f32(),
        }
    }
}

impl<T: Real> From<&AmplitudeReport<T>> for AmplitudeMessage {
    fn from(amplitude: &AmplitudeReport<T>) -> Self {
        Self {
            frequency: amplitude.frequency.to_f32(),
            scintillation: amplitude.reading.scintillation.to_f32(),
            verdict: amplitude.reading.verdict,
            z: amplitude.reading.z.to_f32(),
        }
    }
}

impl HistogramMessage {
    /// The histogram of the mode at `frequency` (Hz) as it is sent.
    pub fn new<T: Real>(sample: u64, frequency: T, histogram: &Histogram<T>) -> Self {
        Self {
            sample,
            frequency: frequency.to_f32(),
            counts: histogram.counts,
            beyond: histogram.beyond,
            bin_width: histogram.bin_width.to_f32(),
        }
    }
}

#[cfg(test)]
#[path = "message_tests.rs"]
mod tests;
