//! Who is judged on the population, each over a range of its one threshold.
//!
//! Another detector is a file beside these that has the trait [`Detector`], and a line in
//! [`ALL`].

mod bare;
mod monitor;
mod plain;
mod verdict;

use crate::Defect;
use rarma_core::Order;
use rarma_core::verdict::VerdictConfig;
use rarma_plants::population::heard::Heard;

/// One alarm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alarm {
    /// Called, s.
    pub on_s: f64,
    /// Released, s.
    pub off_s: f64,
    /// Frequency, Hz.
    pub f_hz: f64,
}

/// What one setting of one detector said.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Said {
    /// Alarms.
    pub alarms: Vec<Alarm>,
    /// Warnings, from and to, s.
    pub warnings_s: Vec<(f64, f64)>,
}

/// Alarms closer than this are one, s.
const JOINED_S: f64 = 0.5;

impl Said {
    /// There is chatter between two times, s: the last alarm goes on, or another begins.
    fn calls(&mut self, from_s: f64, to_s: f64, f_hz: f64) {
        match self.alarms.last_mut() {
            Some(last) if from_s - last.off_s < JOINED_S => last.off_s = to_s,
            _ => self.alarms.push(Alarm {
                on_s: from_s,
                off_s: to_s,
                f_hz,
            }),
        }
    }

    /// Time begins so much later, s.
    pub(crate) fn begin_later(&mut self, by_s: f64) {
        for alarm in &mut self.alarms {
            alarm.on_s -= by_s;
            alarm.off_s -= by_s;
        }
        for warning in &mut self.warnings_s {
            warning.0 -= by_s;
            warning.1 -= by_s;
        }
    }

    /// There may be chatter between two times, s.
    fn warns(&mut self, from_s: f64, to_s: f64) {
        match self.warnings_s.last_mut() {
            Some(last) if from_s - last.1 < JOINED_S => last.1 = to_s,
            _ => self.warnings_s.push((from_s, to_s)),
        }
    }
}

/// What is told of the spindle's speed.
#[derive(Debug, Clone, PartialEq)]
pub enum Speed {
    /// Nothing.
    Unknown,
    /// This, before the first sample, Hz.
    Told(f64),
    /// As the control tells it meanwhile: when it arrives, s, and what it says, Hz. The
    /// first is there before the first sample.
    Live(Vec<(f64, f64)>),
}

impl Speed {
    /// What is known before the first sample, Hz.
    pub fn first_hz(&self) -> Option<f64> {
        match self {
            Self::Unknown => None,
            Self::Told(hz) => Some(*hz),
            Self::Live(course) => course.first().map(|p| p.1),
        }
    }

    /// What is known at a time, s, Hz.
    pub fn known_hz(&self, t_s: f64) -> Option<f64> {
        match self {
            Self::Live(course) => {
                let after = course.partition_point(|p| p.0 <= t_s);
                course.get(after.saturating_sub(1)).map(|p| p.1)
            }
            _ => self.first_hz(),
        }
    }

    /// The same for a recording that begins so much later, s.
    pub fn later(&self, by_s: f64) -> Self {
        match self {
            Self::Live(course) => Self::Live(course.iter().map(|p| (p.0 - by_s, p.1)).collect()),
            other => other.clone(),
        }
    }
}

/// What a detector is given.
#[derive(Debug, Clone)]
pub struct Recording<'a> {
    /// The samples. Their truth is not for detectors.
    heard: &'a Heard,
    /// Speed.
    pub speed: Speed,
    /// Teeth, told together with a speed.
    pub teeth: Option<u32>,
    /// The sampler has no anti-alias filter: lines of the rotation may be folded.
    pub aliased: bool,
    /// Numbers of the verdict.
    pub numbers: VerdictConfig,
    /// Order of the model.
    pub order: Order,
}

impl<'a> Recording<'a> {
    /// Of a cut that was played.
    pub fn new(heard: &'a Heard, speed: Speed, teeth: usize, aliased: bool) -> Self {
        Self {
            teeth: speed.first_hz().map(|_| teeth as u32),
            heard,
            speed,
            aliased,
            numbers: VerdictConfig::default(),
            order: Order::O87,
        }
    }

    /// Other samples, and all else that is told.
    pub fn of<'b>(&self, heard: &'b Heard) -> Recording<'b> {
        Recording {
            heard,
            speed: self.speed.clone(),
            ..*self
        }
    }

    /// Samples, parts of full scale.
    pub fn samples(&self) -> &[f32] {
        &self.heard.samples
    }

    /// Sampling rate, Hz.
    pub fn fs_hz(&self) -> f64 {
        self.heard.fs_hz
    }

    /// Length, s.
    pub fn length_s(&self) -> f64 {
        self.samples().len() as f64 / self.fs_hz()
    }
}

/// One that says when there is chatter.
pub trait Detector: Sync {
    /// Name in tables.
    fn name(&self) -> &'static str;

    /// What its threshold is, with its unit.
    fn threshold(&self) -> &'static str;

    /// The thresholds, the usual one first.
    fn thresholds(&self) -> &'static [f64];

    /// Whether it has to listen anew for every threshold.
    fn listens_anew(&self) -> bool {
        false
    }

    /// Whether what is told of the speed makes a difference to it.
    fn asks_speed(&self) -> bool {
        true
    }

    /// What it says of a recording at each of these thresholds.
    ///
    /// # Errors
    /// The recording does not suit it: a defect of the population.
    fn listen(&self, recording: &Recording, thresholds: &[f64]) -> Result<Vec<Said>, Defect>;
}

/// All of them.
pub const ALL: [&dyn Detector; 4] = [
    &monitor::Monitor,
    &verdict::Lines,
    &plain::Plain,
    &bare::BareDamping,
];

/// The detector of a name as tables have it, or with `-` for blanks: its place in [`ALL`].
pub fn named(name: &str) -> Option<usize> {
    ALL.iter()
        .position(|d| d.name() == name || d.name().replace(' ', "-") == name)
}
