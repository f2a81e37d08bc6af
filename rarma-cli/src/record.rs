//! What a monitoring run says, as the JSON of `rarma monitor` spells it.
//!
//! The same records come from the host run, from decoded wire frames of a box,
//! and from the firmware image on the emulated chip; reports and tests read
//! nothing else.

mod advice;

pub(crate) use advice::known;
pub use advice::{
    AdviceRecord, HelpRecord, KnownRecord, LobesRecord, MachineRecord, SpeedRecord, VariationRecord,
};

pub use rarma_core::condition::{Fault, TachoFault};
pub use rarma_core::decide::{Amplitude, Label, Origin, Reason, State};
pub use rarma_core::monitor::SpeedSource;

use rarma_core::decide::{Agreement, Histogram};
use rarma_core::named::ByName;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// What is known of the spindle at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpindleRecord {
    /// Speed, 1/min; where nobody told it, this may be the teeth's.
    pub rpm: Option<f64>,
    /// Who says so.
    #[serde(with = "rarma_core::named")]
    pub source: SpeedSource,
    /// The multiples of the speed are being removed.
    pub locked: bool,
    /// Half-width around each removed multiple in which nothing can be heard, Hz.
    pub notch_hz: f64,
}

/// The amplitude of the followed mode.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AmplitudeRecord {
    /// Frequency of the mode, Hz.
    pub f: f64,
    /// Scintillation S of the squared amplitude: 1 for noise, 0 for a steady tone.
    pub s: f64,
    /// What that means.
    #[serde(with = "rarma_core::named")]
    pub verdict: Amplitude,
    /// How far S is from noise's, in standard deviations of ln S.
    pub z: f64,
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
    #[serde(with = "rarma_core::named")]
    pub label: Label,
    /// Multiple of the spindle frequency it sits on, if it does.
    pub harmonic: Option<u32>,
    /// What else explains it.
    #[serde(with = "rarma_core::named")]
    pub origin: Origin,
    /// Until its damping is gone at the present rate, s; none where that rate is uncertain.
    pub time_left: Option<f64>,
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
    #[serde(with = "rarma_core::named")]
    pub state: State,
    /// Why.
    #[serde(with = "rarma_core::named")]
    pub reason: Reason,
    /// Modes sorted by frequency.
    pub modes: Vec<ModeRecord>,
    /// What is known of the spindle.
    pub spindle: SpindleRecord,
    /// The amplitude of the followed mode; none while none is followed.
    pub amplitude: Option<AmplitudeRecord>,
    /// Who hears the mode in question. With two channels only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub agreement: Option<Agreement>,
    /// What to turn instead, in the first line after an alarm was called. Where speed and teeth are told only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<Box<AdviceRecord>>,
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
    /// Median of the damping ratio of its mode in the lines while it stood, 1; none of fewer
    /// than three lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zeta_median: Option<f64>,
    /// Deviation of those readings: 1.48 times their median distance from the median, 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zeta_deviation: Option<f64>,
    /// What to turn instead, of the first 1000. Where speed and teeth are told only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<Box<AdviceRecord>>,
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
    /// Alarms in order of time, the first 10 000.
    pub alarms: Vec<Alarm>,
    /// Alarms beyond those; not there if there are none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub alarms_left_out: u64,
    /// Seconds spent in each state.
    #[serde(serialize_with = "write_seconds", deserialize_with = "read_seconds")]
    pub state_seconds: BTreeMap<State, f64>,
    /// What was wrong with what is known of the spindle, in order of time, the first 1000.
    pub notices: Vec<NoticeRecord>,
    /// Notices beyond those; not there if there are none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub notices_left_out: u64,
    /// The spindle over the whole run.
    pub spindle: SpindleSummary,
    /// Energy of the removed lines over that of the band, the whole run, dB; none if
    /// nothing was removed.
    pub removed_db: Option<f64>,
    /// What was wrong with each channel. With two channels only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<Vec<ChannelRecord>>,
    /// What the user noted of the run (`--note KEY=VALUE`).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub notes: BTreeMap<String, String>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_zero(n: &u64) -> bool {
    *n == 0
}

fn write_seconds<S: Serializer>(of: &BTreeMap<State, f64>, to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(of.iter().map(|(state, s)| (ByName(*state), s)))
}

fn read_seconds<'de, D: Deserializer<'de>>(from: D) -> Result<BTreeMap<State, f64>, D::Error> {
    let of = BTreeMap::<ByName<State>, f64>::deserialize(from)?;
    Ok(of.into_iter().map(|(state, s)| (state.0, s)).collect())
}

/// Something the user should know of the spindle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoticeRecord {
    /// Noticed at, s.
    pub t: f64,
    /// What.
    #[serde(flatten)]
    pub what: NoticeKind,
}

/// See [`NoticeRecord`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "notice", rename_all = "lowercase")]
pub enum NoticeKind {
    /// The lines in the sound are not those of the told speed.
    Contradiction {
        /// Speed that was told, 1/min.
        told_rpm: f64,
        /// Speed in the sound, 1/min.
        found_rpm: f64,
    },
    /// A fault of the tacho began.
    Tacho {
        /// Which.
        #[serde(with = "rarma_core::named")]
        fault: TachoFault,
    },
}

/// The spindle over the whole run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpindleSummary {
    /// First speed read off the sound or the tacho, 1/min; none if it never was.
    pub rpm_first: Option<f64>,
    /// Last speed read off them, 1/min.
    pub rpm_last: Option<f64>,
    /// Seconds for which the multiples of the speed were removed.
    pub locked_s: f64,
    /// Half-width around each multiple that was declared blind, Hz, the widest of the
    /// lines of this run; none if nothing was removed.
    pub notch_hz: Option<f64>,
}

/// One of two channels over the whole run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChannelRecord {
    /// Channel of the file, from 0.
    pub channel: usize,
    /// The stretches for which it was left out, in order of time, the first 1000.
    pub faults: Vec<FaultRecord>,
    /// Stretches beyond those; not there if there are none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub faults_left_out: u64,
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
    /// How the followed mode's amplitude was distributed, once a second. For pictures.
    pub histograms: Vec<HistogramRecord>,
}

/// Counts of the squared amplitude of one mode.
#[derive(Debug, Clone, PartialEq)]
pub struct HistogramRecord {
    /// Told at, s.
    pub t: f64,
    /// Frequency of the mode, Hz.
    pub f: f64,
    /// The counts; squared input units.
    pub counts: Histogram<f64>,
}
