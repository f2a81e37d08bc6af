//! A population of machines that nobody has heard: cuts drawn at random, by seed, each
//! with the truth of what it does.
//!
//! Verdicts are judged on it, never made with it: rules are tuned on some seeds and
//! published on others. The truth has three parts, none of which asks a detector:
//! *state* of the cut over time, by the root of its delay equation ([`state`]); *when
//! chatter can be heard*, by playing the cut beside the forces of a rigid tool
//! ([`heard`]); *what else there is* ([`room`], [`sensor`]). The ranges are in [`ranges`].
//!
//! Slow path: one cut takes tenths of a second.

pub mod before;
pub mod course;
pub mod heard;
mod line;
mod machine;
mod play;
pub mod ranges;
pub mod room;
pub mod sensor;
pub mod state;

use crate::PlantError;
use crate::cut::Process;
use crate::variation::SpeedVariation;
use course::{Course, Planned};
use heard::Heard;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use room::Room;
use sensor::Sensor;
pub use state::SAFE_PART;
use state::Stretch;

/// An alarm this long before chatter can be heard, or after it, is none out of nothing, s.
pub const SLACK_S: f64 = 0.3;

/// Draws before a seed is given up.
const TRIES: usize = 10;

/// One cut of the population.
#[derive(Clone, Debug)]
pub struct Cut {
    /// Its seed.
    pub seed: u64,
    planned: Planned,
    /// What else is to be heard.
    pub room: Room,
    /// What listens.
    pub sensor: Sensor,
    /// How wrong a told speed is, −1 to 1 of what the telling allows.
    pub error: f64,
    /// How late a control tells the speed, s.
    pub delay_s: f64,
}

/// What a cut is, in words for tables.
pub type Kind = &'static str;

impl Cut {
    /// Draws the cut of this seed.
    ///
    /// # Errors
    /// What the plant refuses: a defect of the ranges.
    pub fn draw(seed: u64) -> Result<Self, PlantError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut tries = 0..TRIES;
        let planned = loop {
            let planned = machine::draw(&mut rng).and_then(|m| course::plan(&mut rng, &m));
            match planned {
                // Whose roots cannot be told has no truth: another is drawn.
                Err(PlantError::Unsettled) if tries.next().is_some() => {}
                other => break other?,
            }
        };
        Ok(Self {
            seed,
            room: Room::draw(&mut rng, planned.length_s),
            sensor: Sensor::draw(&mut rng),
            error: ranges::Span::even(-1.0, 1.0).draw(&mut rng),
            delay_s: ranges::CONTROL_DELAY_S.draw(&mut rng),
            planned,
        })
    }

    /// The same machine, room and sensor in a steady cut: half a second of air, then full depth
    /// to the end, with the nominal speed constant or swinging about it.
    ///
    /// # Errors
    /// What the plant refuses; `Unsettled` where the truth of the swing cannot be told.
    pub fn steady(
        &self,
        variation: Option<SpeedVariation>,
        length_s: f64,
    ) -> Result<Self, PlantError> {
        Ok(Self {
            planned: course::steady(&self.planned, variation, length_s)?,
            ..self.clone()
        })
    }

    /// Plays it.
    ///
    /// # Errors
    /// As [`Cut::draw`].
    pub fn hear(&self) -> Result<Heard, PlantError> {
        heard::hear(self)
    }

    /// Nominal spindle speed, Hz.
    #[must_use]
    pub fn spindle_hz(&self) -> f64 {
        self.planned.process.spindle_hz()
    }

    /// Teeth.
    #[must_use]
    pub fn teeth(&self) -> usize {
        self.planned.process.teeth()
    }

    /// The machine and what it cuts.
    #[must_use]
    pub fn process(&self) -> &Process {
        &self.planned.process
    }

    /// How it comes and goes.
    #[must_use]
    pub fn course(&self) -> Course {
        self.planned.course
    }

    /// Length, s.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.planned.length_s
    }

    /// Spindle speed over time, straight between points: (s, Hz).
    #[must_use]
    pub fn speeds(&self) -> Vec<(f64, f64)> {
        self.planned.speeds()
    }

    /// Spindle speed at a time, s, Hz.
    #[must_use]
    pub fn speed_at(&self, t_s: f64) -> f64 {
        self.planned.speed_at(t_s)
    }

    /// Depth over the limit at the nominal speed, 1.
    #[must_use]
    pub fn limit_part(&self) -> f64 {
        self.planned.limit_part
    }

    /// Stretches in which an alarm is neither right nor false, from and to, s: near the
    /// limit or beyond it, whatever can be heard.
    #[must_use]
    pub fn either_s(&self) -> Vec<(f64, f64)> {
        state::either_s(&self.planned.stretches, self.length_s())
    }

    /// State of the cut over time, by its delay equation.
    #[must_use]
    pub fn stretches(&self) -> &[Stretch] {
        &self.planned.stretches
    }

    /// Operational frequency, Hz, and damping ratio of the least damped root at full
    /// depth and nominal speed.
    #[must_use]
    pub fn operational(&self) -> (f64, f64) {
        self.planned.operational
    }

    /// Seconds of clearly stable cutting between two times, s, away from chatter.
    #[must_use]
    pub fn quiet_s(&self, heard: &Heard, from_s: f64, to_s: f64) -> f64 {
        let within = (from_s.max(0.0), to_s.min(self.length_s()));
        heard::quiet_s(&self.planned.stretches, &heard.chatter_s, within)
    }

    /// Whether nothing is cut at a time, s, nor was a moment before.
    #[must_use]
    pub fn in_air(&self, t_s: f64) -> bool {
        let air = |t| state::state_at(&self.planned.stretches, t) == state::Cutting::Air;
        air(t_s) && air(t_s - SLACK_S)
    }

    /// Whether an alarm between two times, s, is neither right nor false: the cut was
    /// near its limit or beyond it there, unheard.
    #[must_use]
    pub fn excuses(&self, from_s: f64, to_s: f64) -> bool {
        self.either_s()
            .iter()
            .any(|(from, to)| from - SLACK_S < to_s && to + SLACK_S > from_s)
    }

    /// Whether nobody could tell, see [`ranges::UNDECIDABLE_DB`].
    #[must_use]
    pub fn undecidable(&self) -> bool {
        heard::undecidable(self)
    }

    /// What there is in it, for tables by kind.
    #[must_use]
    pub fn kinds(&self) -> Vec<Kind> {
        let mut out = vec![self.planned.course.name()];
        let mut note = |there: bool, kind: Kind| {
            if there {
                out.push(kind);
            }
        };
        let milling = match self.process() {
            Process::Milling(c) => Some(c),
            Process::Turning(_) => None,
        };
        note(milling.is_none(), "turning");
        note(milling.is_some(), "milling");
        note(
            milling.is_some_and(|c| !c.pitch_rad.is_empty()),
            "unequal pitch",
        );
        note(self.planned.exits, "exit");
        note(self.planned.on_multiple, "chatter on a multiple");
        let changes = self.planned.changes;
        note(changes.steps, "override in steps");
        note(changes.ramps, "override in ramps");
        note(changes.run_up, "run-up");
        note(!self.room.tones.is_empty(), "fan or pump");
        note(self.room.mains.is_some(), "mains");
        note(!self.room.knocks.is_empty(), "knocks");
        note(self.room.jet.is_some(), "compressed air");
        note(self.room.speech.is_some(), "speech");
        note(self.room.neighbour.is_some(), "neighbour chatters");
        note(self.sensor.accelerometer(), "accelerometer");
        note(!self.sensor.accelerometer(), "microphone");
        note(self.sensor.folds > 1, "no anti-alias filter");
        note(self.sensor.fs_hz < 2000.0, "1.65 kHz logger");
        note(self.sensor.clips.is_some(), "clips");
        out
    }
}

#[cfg(test)]
mod tests;
