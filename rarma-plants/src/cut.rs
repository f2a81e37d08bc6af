//! A whole cut as a scenario: machine, microphone, length; and the samples it
//! gives. What is true of it is in the truth module.

use super::converter::Reading;
use super::error::{PlantError, positive};
use super::milling::{MillSample, Milling, MillingConfig};
use super::modal::ShapedMode;
use super::process::Schedule;
use super::sound::{Microphone, MicrophoneConfig};
use super::turning::{Turning, TurningConfig};
use super::variation::SpeedVariation;

/// What is cut, and by what.
#[derive(Clone, Debug, PartialEq)]
pub enum Process {
    /// A milling cutter.
    Milling(Box<MillingConfig>),
    /// A turning tool.
    Turning(Box<TurningConfig>),
}

impl Process {
    /// Spindle frequency, Hz; the nominal one if it changes.
    #[must_use]
    pub fn spindle_hz(&self) -> f64 {
        match self {
            Self::Milling(c) => c.spindle_hz,
            Self::Turning(c) => c.spindle_hz,
        }
    }

    /// Number of teeth; 1 in turning.
    #[must_use]
    pub fn teeth(&self) -> usize {
        match self {
            Self::Milling(c) => c.teeth,
            Self::Turning(_) => 1,
        }
    }

    /// Axial depth or chip width over time.
    #[must_use]
    pub fn depth(&self) -> &Schedule {
        match self {
            Self::Milling(c) => &c.depth,
            Self::Turning(c) => &c.width,
        }
    }

    /// The same cut at another depth.
    #[must_use]
    pub fn at_depth(&self, depth: Schedule) -> Self {
        let mut out = self.clone();
        match &mut out {
            Self::Milling(c) => c.depth = depth,
            Self::Turning(c) => c.width = depth,
        }
        out
    }

    /// The same cut at another constant spindle frequency.
    #[must_use]
    pub fn at_spindle_hz(&self, spindle_hz: f64) -> Self {
        let mut out = self.clone();
        match &mut out {
            Self::Milling(c) => {
                c.spindle_hz = spindle_hz;
                c.speed = None;
                c.variation = None;
            }
            Self::Turning(c) => {
                c.spindle_hz = spindle_hz;
                c.variation = None;
            }
        }
        out
    }

    /// Swing of its speed, if any.
    #[must_use]
    pub fn variation(&self) -> Option<SpeedVariation> {
        match self {
            Self::Milling(c) => c.variation,
            Self::Turning(c) => c.variation,
        }
    }

    /// The same cut with a speed that swings, or one that does not.
    #[must_use]
    pub fn with_variation(&self, variation: Option<SpeedVariation>) -> Self {
        let mut out = self.clone();
        match &mut out {
            Self::Milling(c) => c.variation = variation,
            Self::Turning(c) => c.variation = variation,
        }
        out
    }

    /// All modes; those of turning along x.
    #[must_use]
    pub fn modes(&self) -> Vec<ShapedMode> {
        match self {
            Self::Milling(c) => c.shaped_modes(),
            Self::Turning(c) => c.modes.iter().map(|m| ShapedMode::along_x(*m)).collect(),
        }
    }
}

/// Everything a simulated recording is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name it is known by.
    pub name: String,
    /// The machine and what it cuts.
    pub process: Process,
    /// What listens.
    pub microphone: MicrophoneConfig,
    /// Length of the recording, s, > 0.
    pub duration_s: f64,
}

impl Scenario {
    /// The same with other seeds everywhere.
    #[must_use]
    pub fn seeded(mut self, seed: u64) -> Self {
        match &mut self.process {
            Process::Milling(c) => c.seed = seed,
            Process::Turning(c) => c.seed = seed,
        }
        self.microphone.seed = seed.wrapping_add(1);
        self
    }
}

/// A machine of either kind, stepped alike.
#[derive(Clone, Debug)]
pub enum Machine {
    /// Milling.
    Milling(Box<Milling>),
    /// Turning; its motion is along x.
    Turning(Box<Turning>),
}

impl Machine {
    /// Builds the machine at rest.
    ///
    /// # Errors
    /// As [`Milling::new`] and [`Turning::new`].
    pub fn new(process: &Process) -> Result<Self, PlantError> {
        Ok(match process {
            Process::Milling(c) => Self::Milling(Box::new(Milling::new((**c).clone())?)),
            Process::Turning(c) => Self::Turning(Box::new(Turning::new((**c).clone())?)),
        })
    }

    /// Steps per second at the highest speed there will be, Hz.
    #[must_use]
    pub fn step_rate_hz(&self) -> f64 {
        match self {
            Self::Milling(m) => m.fastest_step_rate_hz(),
            Self::Turning(m) => m.fastest_step_rate_hz(),
        }
    }

    /// Whether the step rate changes.
    #[must_use]
    pub fn changes_speed(&self) -> bool {
        match self {
            Self::Milling(m) => m.config().speed.is_some() || m.config().variation.is_some(),
            Self::Turning(m) => m.config().variation.is_some(),
        }
    }

    /// Advances by one step and returns the state after it.
    #[inline]
    pub fn step(&mut self) -> MillSample {
        match self {
            Self::Milling(m) => m.step(),
            Self::Turning(m) => {
                let s = m.step();
                MillSample {
                    t: s.t,
                    position_m: [s.position_m, 0.0],
                    velocity_m_s: [s.velocity_m_s, 0.0],
                    acceleration_m_s2: [s.acceleration_m_s2, 0.0],
                    sensor: [
                        [s.position_m, 0.0],
                        [s.velocity_m_s, 0.0],
                        [s.acceleration_m_s2, 0.0],
                    ],
                    force_n: [s.force_n, 0.0],
                    depth_m: s.width_m,
                    chip_m: s.chip_m,
                    spindle_hz: s.spindle_hz,
                    feed_m: s.feed_m,
                }
            }
        }
    }
}

/// A scenario being played: an iterator over converted samples.
#[derive(Clone, Debug)]
pub struct VirtualCut {
    machine: Machine,
    microphone: Microphone,
    state: MillSample,
    length: u64,
}

impl VirtualCut {
    /// Builds machine and microphone.
    ///
    /// # Errors
    /// As [`Machine::new`] and [`Microphone::new`].
    pub fn new(scenario: &Scenario) -> Result<Self, PlantError> {
        positive(scenario.duration_s, "duration_s")?;
        let length = (scenario.duration_s * scenario.microphone.sample_rate_hz).round() as u64;
        let machine = Machine::new(&scenario.process)?;
        let (config, rate) = (scenario.microphone.clone(), machine.step_rate_hz());
        let microphone = if machine.changes_speed() {
            Microphone::timed(config, rate)?
        } else {
            Microphone::new(config, rate)?
        };
        Ok(Self {
            machine,
            microphone,
            state: MillSample::default(),
            length,
        })
    }

    /// Samples per second, Hz.
    #[must_use]
    pub fn sample_rate_hz(&self) -> f64 {
        self.microphone.config().sample_rate_hz
    }

    /// The machine at its latest step, about half a millisecond ahead of the sound.
    #[must_use]
    pub fn machine(&self) -> &MillSample {
        &self.state
    }

    /// From its next revolution on a milling spindle turns at this, Hz; see [`Milling::turn`].
    pub fn turn(&mut self, spindle_hz: f64) {
        if let Machine::Milling(milling) = &mut self.machine {
            milling.turn(spindle_hz);
        }
    }

    /// The microphone, for its converter and its count of clipped samples.
    #[must_use]
    pub fn microphone(&self) -> &Microphone {
        &self.microphone
    }
}

impl Iterator for VirtualCut {
    type Item = Reading;

    fn next(&mut self) -> Option<Reading> {
        if self.microphone.samples() >= self.length {
            return None;
        }
        let (machine, state) = (&mut self.machine, &mut self.state);
        Some(self.microphone.next_reading(|| {
            *state = machine.step();
            *state
        }))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.length - self.microphone.samples()) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for VirtualCut {}

#[cfg(test)]
#[path = "cut_tests.rs"]
mod tests;
