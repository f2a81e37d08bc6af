//! What the page is told as it goes.

use rarma_cli::record::{Alarm, Line, ModeRecord, SpindleRecord, State};
use rarma_cli::report::reason_words;
use rarma_cli::sound_card::{Level, dbfs};
use rarma_core::named::ByName;
use serde::{Serialize, Serializer};

/// What is missing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Gaps {
    /// Stretches.
    pub gaps: u64,
    /// Samples in all of them.
    pub samples: u64,
    #[serde(skip)]
    open: bool,
}

impl Gaps {
    /// So many samples are missing; without sound since the ones before it is the same gap.
    pub fn missing(&mut self, samples: u64) {
        self.gaps += u64::from(!self.open);
        self.samples += samples;
        self.open = true;
    }

    /// Sound has come.
    pub fn sound(&mut self) {
        self.open = false;
    }
}

/// A run in a line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct InWords {
    /// How bad the news is: `bad`, `careful`, `good`, `unknown`.
    pub tone: &'static str,
    /// The line, without a full stop.
    pub text: String,
}

/// The scales of the pictures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scale {
    /// Values of a column.
    pub rows: usize,
    /// Frequency at its top, Hz.
    pub top_hz: f64,
    /// Seconds from column to column.
    pub step_s: f64,
    /// The band that is analysed, Hz.
    pub band_hz: (f64, f64),
    /// Damping ratio below which a mode counts as undamped, 1.
    pub threshold: f64,
    /// What the rate of live sound means, where it is one of telephones.
    pub warning: Option<String>,
}

/// The modes at one instant, for the pictures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Seconds since the first sample.
    pub t: f64,
    /// The modes.
    pub modes: Vec<ModeRecord>,
    /// The verdict.
    #[serde(with = "rarma_core::named")]
    pub state: State,
}

/// The level in the last second.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelView {
    /// Root mean square, dB over full scale.
    pub rms_dbfs: f64,
    /// Largest magnitude, dB over full scale.
    pub peak_dbfs: f64,
    /// Samples at full scale.
    pub clipped: u64,
    /// Muted, or not connected.
    pub silent: bool,
    /// What is wrong with it, and what to do.
    pub warnings: Vec<String>,
}

impl From<Level> for LevelView {
    fn from(level: Level) -> Self {
        Self {
            rms_dbfs: dbfs(level.rms),
            peak_dbfs: dbfs(level.peak),
            clipped: level.clipped,
            silent: level.is_silent(),
            warnings: level.warnings(),
        }
    }
}

/// All that the page shows in words.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Heard {
    /// Seconds heard, missing samples included.
    pub t: f64,
    /// Sound has come.
    pub begun: bool,
    /// The verdict of the last line.
    #[serde(serialize_with = "by_name")]
    pub state: Option<State>,
    /// Why, in words.
    pub reason: Option<&'static str>,
    /// What is known of the spindle.
    pub spindle: Option<SpindleRecord>,
    /// What is missing.
    pub missing: Gaps,
    /// Alarms, the last ones.
    pub alarms: Vec<Alarm>,
    /// Alarms in all.
    pub alarms_so_far: u64,
    /// The level, where it is measured.
    pub level: Option<LevelView>,
    /// What has been drawn since it was asked for last.
    pub points: Vec<Point>,
}

#[allow(clippy::ref_option, reason = "as serde calls it")]
fn by_name<S: Serializer>(state: &Option<State>, to: S) -> Result<S::Ok, S::Error> {
    state.map(ByName).serialize(to)
}

impl Heard {
    /// With the words of a line.
    pub(crate) fn of(line: Option<&Line>) -> Self {
        Self {
            t: 0.0,
            begun: false,
            state: line.map(|line| line.state),
            reason: line.map(|line| reason_words(line.state, line.reason)),
            spindle: line.map(|line| line.spindle),
            missing: Gaps::default(),
            alarms: Vec::new(),
            alarms_so_far: 0,
            level: None,
            points: Vec::new(),
        }
    }
}
