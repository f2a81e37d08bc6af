//! What a record says: kinds.

use super::capability::{Limits, Modes, OdrStatistics, Stiffness};
use super::name::Name;
use rarma_core::decide::{Label, State};
use serde::{Deserialize, Serialize};

/// What is said.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "body", rename_all = "kebab-case")]
pub enum Body {
    /// What the monitor believed over a stretch of time.
    Verdict(Verdict),
    /// An alarm was called.
    AlarmCalled(AlarmCalled),
    /// An alarm was released.
    AlarmReleased(AlarmReleased),
    /// What to turn instead.
    Advice(Advice),
    /// What came of an advice.
    Outcome(Outcome),
    /// Stiffness by direction, of the loaded ball bar.
    Stiffness(Stiffness),
    /// Modes of the structure, at rest or turning, of the exciter or a hammer.
    Modes(Modes),
    /// Widest stable cut by direction, of the elastic linked system.
    Limits(Limits),
    /// Operational damping over many cuts with one tool at one speed.
    OdrStatistics(OdrStatistics),
}

/// The kinds of a [`Body`], to ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs, reason = "as in `Body`")]
pub enum Kind {
    Verdict,
    AlarmCalled,
    AlarmReleased,
    Advice,
    Outcome,
    Stiffness,
    Modes,
    Limits,
    OdrStatistics,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Verdict,
        Self::AlarmCalled,
        Self::AlarmReleased,
        Self::Advice,
        Self::Outcome,
        Self::Stiffness,
        Self::Modes,
        Self::Limits,
        Self::OdrStatistics,
    ];

    /// As JSON spells it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Verdict => "verdict",
            Self::AlarmCalled => "alarm-called",
            Self::AlarmReleased => "alarm-released",
            Self::Advice => "advice",
            Self::Outcome => "outcome",
            Self::Stiffness => "stiffness",
            Self::Modes => "modes",
            Self::Limits => "limits",
            Self::OdrStatistics => "odr-statistics",
        }
    }
}

impl Body {
    /// Which kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Verdict(_) => Kind::Verdict,
            Self::AlarmCalled(_) => Kind::AlarmCalled,
            Self::AlarmReleased(_) => Kind::AlarmReleased,
            Self::Advice(_) => Kind::Advice,
            Self::Outcome(_) => Kind::Outcome,
            Self::Stiffness(_) => Kind::Stiffness,
            Self::Modes(_) => Kind::Modes,
            Self::Limits(_) => Kind::Limits,
            Self::OdrStatistics(_) => Kind::OdrStatistics,
        }
    }
}

/// One mode with its deviations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// Natural frequency, Hz.
    pub f_hz: f64,
    /// Its standard deviation, Hz.
    pub f_sd_hz: f64,
    /// Operational damping ratio, 1; negative: growing.
    pub zeta: f64,
    /// Its standard deviation, 1.
    pub zeta_sd: f64,
    /// Peak amplitude, units of the input.
    pub amplitude: f64,
    /// Where it comes from.
    #[serde(with = "rarma_core::named")]
    pub label: Label,
}

/// What the monitor believed over a stretch of time that begins at the record's time. A verdict of one
/// instant is a stretch of the time between two verdicts; a stretch of one state over hours is one
/// record, which is what keeps a store small.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The state.
    #[serde(with = "rarma_core::named")]
    pub state: State,
    /// Why, in the words of the monitor's JSON. An open list: a box of a later version may have others.
    pub reason: Name,
    /// How long it was so, s.
    pub seconds: f64,
    /// Root mean square of the band, input units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Spindle speed, 1/min.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpm: Option<f64>,
    /// The modes where the least damped of them was lowest, sorted by frequency, at most 8.
    #[serde(default)]
    pub modes: Vec<Mode>,
}

/// An alarm was called, at the record's time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlarmCalled {
    /// Frequency of the mode that raised it, Hz.
    pub f_hz: f64,
    /// Its damping ratio then, 1.
    pub zeta: f64,
    /// Spindle speed, 1/min.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpm: Option<f64>,
    /// Teeth of the tool.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub teeth: Option<u32>,
}

/// An alarm was released, at the record's time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlarmReleased {
    /// `seq` of the record of the call, of the same box and session.
    pub called: u64,
    /// How long it stood, s.
    pub seconds: f64,
    /// Frequency of its mode, power-weighted mean, Hz.
    pub f_hz: f64,
    /// Lowest damping ratio while it stood, 1.
    pub zeta_lowest: f64,
    /// Median of its damping ratio while it stood, 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zeta_median: Option<f64>,
    /// Spindle speed at the call, 1/min.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpm: Option<f64>,
}

/// A speed to turn instead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// The speed, 1/min.
    pub rpm: f64,
    /// Its standard deviation, 1/min; none where it was not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpm_sd: Option<f64>,
    /// Chance that the cut is stable there, 0 to 1; none where it was not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chance: Option<f64>,
    /// How many times deeper the cut may be there; none where it was not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
}

impl Speed {
    /// A speed of which nothing else is told.
    #[must_use]
    pub fn of_rpm(rpm: f64) -> Self {
        Self {
            rpm,
            rpm_sd: None,
            chance: None,
            margin: None,
        }
    }
}

/// What to turn instead, of one alarm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Advice {
    /// `seq` of the record of the alarm's call, of the same box and session; none in what tells of no alarm (the log of
    /// `rarma act`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub called: Option<u64>,
    /// Speed at which the alarm was called, 1/min.
    pub rpm: f64,
    /// The mode that chatters, Hz.
    pub f_hz: f64,
    /// Speeds within reach, the best first, at most 8; empty: none.
    pub speeds: Vec<Speed>,
    /// What helps where no speed does, in the words of the monitor's JSON.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub helps: Vec<Name>,
}

/// What came of an advice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// `seq` of the record of the advice, of the same box and session.
    pub advice: u64,
    /// Was one of the speeds turned?
    pub followed: bool,
    /// The speed that was turned, 1/min.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rpm: Option<f64>,
    /// Did the chatter end? None where it cannot be told (the cut ended before).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub helped: Option<bool>,
    /// Why an order ended, in the words of `rarma act`'s log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<Name>,
}
