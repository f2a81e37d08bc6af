//! The three constants of a magnet from measured pairs: load cell against current and gap.
//!
//! Rate: slow path, once per magnet.

use super::error::{CersError, within};
use super::force::Magnet;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Constants of a magnet.
const UNKNOWNS: usize = 3;
/// Gaps that differ by less, over the widest, are one gap.
const LEAST_SPREAD: f64 = 0.05;
/// Rounds at most; six to ten are usual.
const ROUNDS: u32 = 60;

/// One measurement of one magnet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ForcePair<T> {
    /// Current, A, above 0.
    pub current_a: T,
    /// Gap as its sensor reads it, m, above 0.
    pub gap_m: T,
    /// Force of the load cell, N, towards the magnet.
    pub force_n: T,
}

/// How sure the measurements are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CalibrationConfig<T> {
    /// Standard deviation of the load cell, N, 1e-6 to 1e3.
    pub force_sd_n: T,
    /// What current and gap add, part of the force, 0 to 0.2. 1 µm of 150 is 0.013.
    pub relative_sd: T,
    /// Least field, over that of the guessed knee, that the pairs must reach for the knee
    /// to be sought, 0.3 to 1; below it the guess stays. 0.6 is usual: there the
    /// knee takes 1.5 % of the force.
    pub least_flux_part: T,
}

impl<T: Real> Default for CalibrationConfig<T> {
    fn default() -> Self {
        Self {
            force_sd_n: T::from_f64(0.05),
            relative_sd: T::from_f64(0.005),
            least_flux_part: T::from_f64(0.6),
        }
    }
}

/// A calibrated magnet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration<T> {
    /// The constants.
    pub magnet: Magnet<T>,
    /// Their standard deviations: N·m²/A², m, A/m; 0 for a knee that was held. From the
    /// stated deviations of the measurements, times √χ² where that is above 1.
    pub deviations: [T; UNKNOWNS],
    /// Root mean square of measured − computed, N.
    pub residual_rms_n: T,
    /// Root mean square of (measured − computed)/computed, 1.
    pub residual_rms_part: T,
    /// Largest |measured − computed| over the stated deviation of its pair, 1.
    pub worst: T,
    /// Place of that pair, from 0.
    pub worst_index: usize,
    /// Σ(residual/deviation)² over (pairs − unknowns): about 1 when the law and the stated
    /// deviations hold.
    pub chi_square: T,
    /// The pairs reach the knee, so that it was sought.
    pub knee_found: bool,
    /// Rounds of the fit.
    pub rounds: u32,
}

/// Finds K, δ and the knee by weighted least squares (Levenberg and Marquardt, rotations
/// instead of normal equations):
///
/// ```text
/// min Σ [(F_j − F(i_j, s_j))/σ_j]²,   σ_j² = force_sd² + (relative_sd·F(i_j, s_j))²
/// ```
///
/// Unknowns are ln K, δ and ln h, so that K and h stay positive. `guess` is where it starts
/// ([`Geometry::magnet`](super::Geometry::magnet)). Gaps must differ by 5 %, for δ and K are one
/// constant at a single gap; a constant less sure than 30 % is refused. Residual j is
/// `pair.force_n − magnet.force(pair.current_a, pair.gap_m)`.
///
/// # Errors
/// `OutOfRange` (a setting, or the guess), `TooFew` below 2 pairs more than unknowns,
/// `NotFinite`, `Singular`, `NotSettled`.
pub fn calibrate<T: Real>(
    pairs: &[ForcePair<T>],
    guess: Magnet<T>,
    config: &CalibrationConfig<T>,
) -> Result<Calibration<T>, CersError> {
    let value = T::from_f64;
    within(config.force_sd_n, value(1e-6), value(1e3), "force_sd_n")?;
    within(config.relative_sd, T::ZERO, value(0.2), "relative_sd")?;
    within(
        config.least_flux_part,
        value(0.3),
        T::ONE,
        "least_flux_part",
    )?;
    let sound = guess.gain > T::ZERO && guess.saturation_a_per_m > T::ZERO;
    if !(sound && guess.gain.is_finite() && guess.gap_offset_m.is_finite()) {
        return Err(CersError::OutOfRange { name: "guess" });
    }
    let mut highest = T::ZERO;
    let (mut narrowest, mut widest) = (T::ONE / T::ZERO, T::ZERO);
    for (index, p) in pairs.iter().enumerate() {
        let usable = p.current_a > T::ZERO && p.gap_m > T::ZERO;
        if !(usable && p.current_a.is_finite() && p.gap_m.is_finite() && p.force_n.is_finite()) {
            return Err(CersError::NotFinite { index });
        }
        narrowest = narrowest.min(p.gap_m);
        widest = widest.max(p.gap_m);
        highest = highest.max(guess.force(p.current_a, p.gap_m).flux_part);
    }
    let knee_found = highest >= config.least_flux_part;
    let unknowns = if knee_found { UNKNOWNS } else { UNKNOWNS - 1 };
    if pairs.len() < unknowns + 2 {
        return Err(CersError::TooFew {
            needed: unknowns + 2,
        });
    }
    if widest - narrowest < value(LEAST_SPREAD) * widest {
        return Err(CersError::Singular);
    }
    let problem = Problem {
        pairs,
        config,
        unknowns,
    };
    let (magnet, triangle, rounds) = problem.solve(guess)?;
    problem.report(magnet, &triangle, knee_found, rounds)
}

struct Problem<'a, T> {
    pairs: &'a [ForcePair<T>],
    config: &'a CalibrationConfig<T>,
    unknowns: usize,
}

impl<T: Real> Problem<'_, T> {
    fn deviation(&self, computed: T) -> T {
        let part = self.config.relative_sd * computed;
        (self.config.force_sd_n * self.config.force_sd_n + part * part).sqrt()
    }

    /// Equations of one round and the weighted sum of squares; weights from `weigh`.
    fn equations(&self, at: &Magnet<T>, weigh: &Magnet<T>) -> (Triangle<T, UNKNOWNS>, T) {
        let mut triangle = Triangle::new(self.unknowns);
        let mut sum = T::ZERO;
        let unit = self.mean_gap();
        for p in self.pairs {
            let f = at.force(p.current_a, p.gap_m).newton;
            let weight = T::ONE / self.deviation(weigh.force(p.current_a, p.gap_m).newton);
            let (_, per_m) = at.derivatives(p.current_a, p.gap_m);
            // F depends on the knee through r: ∂ln F/∂ln h = 2r⁶/(1 + r⁶).
            let r = p.current_a / (p.gap_m + at.gap_offset_m) / at.saturation_a_per_m;
            let r6 = r * r * r * r * r * r;
            let by_knee = f * T::from_f64(2.0) * r6 / (T::ONE + r6);
            let mut row = [f * weight, per_m * unit * weight, by_knee * weight];
            let left = (p.force_n - f) * weight;
            sum += left * left;
            let _ = triangle.add(&mut row, left);
        }
        (triangle, sum)
    }

    fn mean_gap(&self) -> T {
        let n = T::from_u32(self.pairs.len() as u32);
        self.pairs.iter().map(|p| p.gap_m).sum::<T>() / n
    }

    fn step(&self, from: &Magnet<T>, by: &[T; UNKNOWNS]) -> Magnet<T> {
        let limit = |x: T| x.clamp(-T::ONE, T::ONE);
        Magnet {
            gain: from.gain * limit(by[0]).exp(),
            gap_offset_m: from.gap_offset_m
                + self.mean_gap() * by[1].clamp(T::from_f64(-0.2), T::from_f64(0.2)),
            saturation_a_per_m: if self.unknowns == UNKNOWNS {
                from.saturation_a_per_m * limit(by[2]).exp()
            } else {
                from.saturation_a_per_m
            },
        }
    }

    fn solve(
        &self,
        guess: Magnet<T>,
    ) -> Result<(Magnet<T>, Triangle<T, UNKNOWNS>, u32), CersError> {
        let settled = T::from_f64(1e-6).max(T::EPSILON * T::from_f64(64.0));
        let mut now = guess;
        let mut damping = T::from_f64(1e-3);
        for round in 1..=ROUNDS {
            // Weights of the round's start: the fit of a round is a plain least squares.
            let weigh = now;
            let (triangle, before) = self.equations(&now, &weigh);
            let mut moved = T::ONE;
            for _ in 0..12 {
                let by = triangle
                    .damped(damping)
                    .solve()
                    .ok_or(CersError::Singular)?;
                let next = self.step(&now, &by);
                let (_, after) = self.equations(&next, &weigh);
                if after <= before {
                    moved = by.iter().fold(T::ZERO, |m, x| m.max(x.abs()));
                    now = next;
                    damping = (damping * T::from_f64(0.2)).max(T::from_f64(1e-9));
                    break;
                }
                damping = (damping * T::from_f64(8.0)).min(T::from_f64(1e4));
                moved = by.iter().fold(T::ZERO, |m, x| m.max(x.abs()));
            }
            if moved < settled {
                let (last, _) = self.equations(&now, &now);
                return Ok((now, last, round));
            }
        }
        Err(CersError::NotSettled)
    }

    fn report(
        &self,
        magnet: Magnet<T>,
        triangle: &Triangle<T, UNKNOWNS>,
        knee_found: bool,
        rounds: u32,
    ) -> Result<Calibration<T>, CersError> {
        let covariance = triangle.inverse_normal().ok_or(CersError::Singular)?;
        let (mut squares, mut parts, mut chi) = (T::ZERO, T::ZERO, T::ZERO);
        let (mut worst, mut worst_index) = (T::ZERO, 0);
        for (index, p) in self.pairs.iter().enumerate() {
            let f = magnet.force(p.current_a, p.gap_m).newton;
            let left = p.force_n - f;
            let over = left.abs() / self.deviation(f);
            squares += left * left;
            parts += (left / f) * (left / f);
            chi += over * over;
            if over > worst {
                (worst, worst_index) = (over, index);
            }
        }
        let n = T::from_u32(self.pairs.len() as u32);
        let free = T::from_u32((self.pairs.len() - self.unknowns) as u32);
        let chi_square = chi / free;
        let wider = chi_square.max(T::ONE).sqrt();
        let unit = [magnet.gain, self.mean_gap(), magnet.saturation_a_per_m];
        let mut deviations = [T::ZERO; UNKNOWNS];
        for k in 0..self.unknowns {
            deviations[k] = covariance[k][k].max(T::ZERO).sqrt() * unit[k] * wider;
            if !(deviations[k] < T::from_f64(0.3) * unit[k]) {
                return Err(CersError::Singular);
            }
        }
        Ok(Calibration {
            magnet,
            deviations,
            residual_rms_n: (squares / n).sqrt(),
            residual_rms_part: (parts / n).sqrt(),
            worst,
            worst_index,
            chi_square,
            knee_found,
            rounds,
        })
    }
}

#[cfg(test)]
#[path = "calibration_tests.rs"]
mod tests;
