//! Spindle speed variation: a speed that swings all the time, so that the wave which
//! a tooth leaves is met with another phase at every pass.
//!
//! Everything of it is in *turns*: the angle that the spindle has turned through. In
//! angle the delay between two teeth is a constant, 1/N turn, whatever the speed does;
//! in time it is τ(t), the solution of ∫ n dt = 1/N from t - τ to t. So a simulation and
//! a delay equation on a grid of angles have the delay exactly, and only the length of
//! their steps swings.
//!
//! Glossary (the field's names): *RVA*, ratio of the amplitude of the speed to its mean;
//! *RVF*, ratio of the frequency of the variation to the spindle's.

use super::error::{PlantError, require};
use core::f64::consts::{PI, TAU};

/// RVA at most: beyond it a spindle all but stops.
pub const MOST_AMPLITUDE: f64 = 0.5;
/// RVF from and to.
pub const FREQUENCY_RATIOS: (f64, f64) = (1e-4, 2.0);
/// Steps of Newton's method; it halves nothing, it squares: three are rounding.
const NEWTON: usize = 4;

/// A speed that swings: n(t) = n₀·(1 + RVA·sin(2π·RVF·n₀·t)), n in turns a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedVariation {
    /// RVA, 0 to [`MOST_AMPLITUDE`].
    pub amplitude: f64,
    /// RVF, within [`FREQUENCY_RATIOS`]: swings a turn.
    pub frequency_ratio: f64,
}

impl SpeedVariation {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        let (least, most) = FREQUENCY_RATIOS;
        require((0.0..=MOST_AMPLITUDE).contains(&self.amplitude), "rva")?;
        require((least..=most).contains(&self.frequency_ratio), "rvf")
    }

    /// How often the speed swings, Hz, at a mean speed, Hz.
    #[must_use]
    pub fn frequency_hz(&self, mean_hz: f64) -> f64 {
        self.frequency_ratio * mean_hz
    }

    /// The speed at time `t` s over its mean.
    #[must_use]
    pub fn factor(&self, mean_hz: f64, t: f64) -> f64 {
        1.0 + self.amplitude * (TAU * self.frequency_hz(mean_hz) * t).sin()
    }

    /// Largest angular acceleration of the spindle, rad/s²: 2π·n₀·RVA·2π·RVF·n₀.
    #[must_use]
    pub fn acceleration_rad_s2(&self, mean_hz: f64) -> f64 {
        TAU * mean_hz * self.amplitude * TAU * self.frequency_hz(mean_hz)
    }

    /// Time after `t` s, s, in which a spindle whose mean speed is `carrier_hz` turns by
    /// `turns`; the speed swings with `swing_hz`.
    ///
    /// Solves c·\[Δ + RVA·(cos 2πft - cos 2πf(t+Δ))/2πf\] = turns; the difference of the
    /// cosines as 2·sin(2πft + πfΔ)·sin(πfΔ), which loses nothing where Δ is short.
    #[must_use]
    pub fn time_for_s(&self, carrier_hz: f64, swing_hz: f64, t: f64, turns: f64) -> f64 {
        let w = TAU * swing_hz;
        let wanted = turns / carrier_hz;
        let phase = (w * t) % TAU;
        let mut dt = wanted / (1.0 + self.amplitude * phase.sin());
        for _ in 0..NEWTON {
            let half = 0.5 * w * dt;
            let cosines = 2.0 * (phase + half).sin() * half.sin();
            let turned = dt + self.amplitude / w * cosines;
            let speed = 1.0 + self.amplitude * (phase + 2.0 * half).sin();
            dt -= (turned - wanted) / speed;
        }
        dt
    }

    /// RVF as a fraction of so many swings in so many turns of 1/`of` (tooth passes), the
    /// nearest with at most `most` swings that is within 0.3 %, else the best of them.
    pub(super) fn whole(&self, of: f64, most: usize) -> (usize, usize) {
        let per_swing = of / self.frequency_ratio;
        let candidate = |swings: usize| {
            let passes = (swings as f64 * per_swing).round().max(1.0);
            (
                swings,
                passes as usize,
                (passes / (swings as f64 * per_swing) - 1.0).abs(),
            )
        };
        let near = (1..=most).map(candidate).find(|c| c.2 < 3e-3);
        let best = (1..=most).map(candidate).min_by(|a, b| a.2.total_cmp(&b.2));
        near.or(best)
            .map_or((1, 1), |(swings, passes, _)| (swings, passes))
    }
}

/// How far the phase of a wave of `f_hz` between two teeth swings to either side, rad:
/// 2π·w·RVA·sinc(π·RVF/N), w = f/(n₀·N), N `teeth`, to first order in RVA.
#[must_use]
pub fn phase_swing_rad(variation: &SpeedVariation, f_hz: f64, mean_hz: f64, teeth: usize) -> f64 {
    let waves = f_hz / (mean_hz * teeth as f64);
    let x = PI * variation.frequency_ratio / teeth as f64;
    TAU * waves * variation.amplitude * x.sin() / x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_for_a_turn_is_that_of_the_integral() {
        let v = SpeedVariation {
            amplitude: 0.3,
            frequency_ratio: 0.37,
        };
        // The speed itself, summed by Simpson's rule over the time that is said.
        let n0 = 40.0;
        let (mut t, mut worst) = (0.0, 0.0_f64);
        for _ in 0..50 {
            let dt = v.time_for_s(n0, v.frequency_hz(n0), t, 0.25);
            let steps = 2000;
            let h = dt / f64::from(steps);
            let sum: f64 = (0..=steps)
                .map(|i| {
                    let weight = if i == 0 || i == steps {
                        1.0
                    } else if i % 2 == 1 {
                        4.0
                    } else {
                        2.0
                    };
                    weight * n0 * v.factor(n0, t + h * f64::from(i))
                })
                .sum::<f64>()
                * h
                / 3.0;
            worst = worst.max((sum - 0.25).abs());
            t += dt;
        }
        assert!(worst < 1e-10, "{worst}");
        // Whole swings take whole mean turns.
        let swing = v.time_for_s(n0, v.frequency_hz(n0), 0.123, 1.0 / 0.37);
        assert!((swing - 1.0 / (0.37 * n0)).abs() < 1e-9, "{swing}");
    }

    #[test]
    fn swings_and_passes_are_whole() {
        let of = |rvf: f64, teeth: f64| {
            SpeedVariation {
                amplitude: 0.1,
                frequency_ratio: rvf,
            }
            .whole(teeth, 12)
        };
        assert_eq!(of(0.1, 1.0), (1, 10));
        assert_eq!(of(0.3, 1.0), (3, 10));
        assert_eq!(of(0.01, 4.0), (1, 400));
        let (swings, passes) = of(0.377, 1.0);
        assert!((swings as f64 / passes as f64 / 0.377 - 1.0).abs() < 6e-3);
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        for (amplitude, frequency_ratio) in [(-0.1, 0.1), (0.6, 0.1), (0.1, 0.0), (f64::NAN, 0.1)] {
            let v = SpeedVariation {
                amplitude,
                frequency_ratio,
            };
            assert!(v.validate().is_err(), "{v:?}");
        }
    }
}
