//! The delay equation of a cut whose spindle speed swings.
//!
//! Taken on a grid of angles the delay is a whole number of steps at every moment, and
//! it is the length of the steps that swings. The period is the common one of the swing
//! and of the teeth: so many swings in so many tooth passes (turns where the pitch is
//! unequal). RVF is moved to the next such fraction, by 0.3 % at most if one of
//! [`MOST_SWINGS`] swings or fewer is that near; turning has no teeth to meet and is
//! moved by a step in a swing.
//!
//! A step depends on the angle and on its own length. It is solved at [`KNOTS`] lengths
//! and taken for straight between them.

use super::step::StepMap;
use super::{DelaySystem, MOST_NUMBERS, Seen, StepLaw};
use crate::error::{PlantError, require};
use crate::variation::SpeedVariation;

/// Swings in a common period at most.
pub(super) const MOST_SWINGS: usize = 8;
/// Lengths at which the steps of a tooth pass are solved. With RVA 0.2 and 60 steps a period
/// the straight line between two is off by 2e-7 of a step; half as many: four times that.
pub(super) const KNOTS: usize = 33;
/// The same of turning, all of whose steps share them.
pub(super) const KNOTS_TURNED: usize = 129;
/// Steps of a common period at most: a second or so for each use of the map.
pub const MOST_VARIED_STEPS: usize = 2_000_000;

/// Steps that are not alike in length.
#[derive(Clone, Debug)]
pub(super) struct Swinging {
    /// Steps after which the cut is the same again but for their length.
    phases: usize,
    /// Maps: phase by phase, of rising length.
    knots: Vec<StepMap>,
    /// Maps of a phase.
    count: usize,
    /// For each step of the period its place among the maps of its phase.
    places: Vec<f64>,
    /// When each step begins, s.
    pub times_s: Vec<f64>,
}

impl Swinging {
    pub(super) fn steps(&self) -> usize {
        self.places.len()
    }

    /// The two maps around step `k`, and how far it lies from the first to the second.
    #[inline]
    pub(super) fn around(&self, k: usize) -> (&StepMap, &StepMap, f64) {
        let place = self.places[k];
        let below = (place as usize).min(self.count - 2);
        let first = (k % self.phases) * self.count + below;
        (
            &self.knots[first],
            &self.knots[first + 1],
            place - below as f64,
        )
    }
}

/// What a grid of angles needs to know.
pub(super) struct Grid {
    pub(super) mean_hz: f64,
    pub(super) variation: SpeedVariation,
    /// Steps in a turn, in a tooth's (or turn's) law, and in the period.
    pub(super) per_turn: usize,
    pub(super) phases: usize,
    pub(super) steps: usize,
    pub(super) knots: usize,
}

impl Grid {
    /// The law of a phase at a speed, Hz, to maps.
    fn swinging(
        &self,
        seen: &[Seen],
        scale: f64,
        law: impl Fn(usize, f64) -> StepLaw,
    ) -> Result<Swinging, PlantError> {
        let cell = 1.0 / self.per_turn as f64;
        let a = self.variation.amplitude;
        // The mean of a step's speed never leaves the range of the speed.
        let shortest = cell / (self.mean_hz * (1.0 + a));
        let longest = cell / (self.mean_hz * (1.0 - a));
        let width = (longest - shortest).max(1e-9 * longest) / (self.knots - 1) as f64;
        let mut knots = Vec::with_capacity(self.phases * self.knots);
        for phase in 0..self.phases {
            for k in 0..self.knots {
                let dt = shortest + width * k as f64;
                knots.push(StepMap::new(seen, &law(phase, cell / dt), dt, scale)?);
            }
        }
        let swing_hz = self.variation.frequency_hz(self.mean_hz);
        let (mut places, mut times_s) = (Vec::new(), Vec::new());
        let mut t = 0.0;
        for _ in 0..self.steps {
            let dt = self.variation.time_for_s(self.mean_hz, swing_hz, t, cell);
            places.push(((dt - shortest) / width).clamp(0.0, (self.knots - 1) as f64));
            times_s.push(t);
            t += dt;
        }
        Ok(Swinging {
            phases: self.phases,
            knots,
            count: self.knots,
            places,
            times_s,
        })
    }

    pub(super) fn system(
        &self,
        seen: Vec<Seen>,
        history: usize,
        law: impl Fn(usize, f64) -> StepLaw,
    ) -> Result<DelaySystem, PlantError> {
        require(!seen.is_empty(), "modes")?;
        for s in &seen {
            s.mode.validate()?;
        }
        let maps = self.phases * self.knots;
        let most = MOST_NUMBERS / (4 * seen.len() * seen.len()).max(1);
        if self.steps > MOST_VARIED_STEPS || maps > most {
            return Err(PlantError::TooLarge {
                name: "spindle_hz",
                most: MOST_VARIED_STEPS.min(most / self.knots),
            });
        }
        let scale = seen.iter().map(|s| s.mode.omega()).fold(0.0, f64::max);
        let swinging = self.swinging(&seen, scale, law)?;
        Ok(DelaySystem {
            maps: Vec::new(),
            period_s: self.steps as f64 / (self.per_turn as f64 * self.mean_hz),
            seen,
            history,
            scale,
            swinging: Some(swinging),
        })
    }
}

/// Steps in so long a time, of at least `steps_per_period` in a period of the fastest mode
/// where the spindle is slowest.
pub(super) fn steps_in(time_s: f64, seen: &[Seen], steps_per_period: f64, amplitude: f64) -> usize {
    let highest = seen.iter().map(|s| s.mode.f_hz).fold(0.0, f64::max);
    let steps = steps_per_period * highest * time_s / (1.0 - amplitude);
    steps.ceil().max(40.0) as usize
}
