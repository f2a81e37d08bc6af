//! Turning as a delay equation.

use super::varied::{Grid, KNOTS_TURNED, steps_in};
use super::{DelaySystem, Root, Seen, StepLaw, too_many};
use crate::error::{PlantError, non_negative, positive, require};
use crate::turning::TurningConfig;
use crate::variation::SpeedVariation;
use core::f64::consts::TAU;
use nalgebra::Complex;

/// Turning at chip width `width_m`, with at least `steps_per_period` steps in a
/// period of the fastest mode.
///
/// One delay of one revolution and constant coefficients: the "period" is the
/// delay itself; of a speed that swings its own period.
///
/// # Errors
/// As [`TurningConfig::validate`]; `OutOfRange` without modes, at a width that is
/// negative or no number, or with steps that are too long for the modes or the width.
pub fn turning_delay(
    config: &TurningConfig,
    width_m: f64,
    steps_per_period: f64,
) -> Result<DelaySystem, PlantError> {
    if let Some(variation) = config.variation.filter(|v| v.amplitude > 0.0) {
        return swinging(config, variation, width_m, steps_per_period);
    }
    config.validate()?;
    non_negative(width_m, "width_m")?;
    positive(steps_per_period, "steps_per_period")?;
    let highest = config.modes.iter().map(|m| m.f_hz).fold(0.0, f64::max);
    let steps = (steps_per_period * highest / config.spindle_hz)
        .ceil()
        .max(40.0) as usize;
    too_many(steps, config.modes.len(), "spindle_hz")?;
    let law = law(config, width_m, config.spindle_hz, steps);
    DelaySystem::new(seen(config), 1.0 / config.spindle_hz, &vec![law; steps])
}

/// [`turning_delay`] of a cut whose speed swings.
///
/// # Errors
/// As there; `TooLarge` where a swing holds too many steps.
fn swinging(
    config: &TurningConfig,
    variation: SpeedVariation,
    width_m: f64,
    steps_per_period: f64,
) -> Result<DelaySystem, PlantError> {
    config.validate()?;
    non_negative(width_m, "width_m")?;
    positive(steps_per_period, "steps_per_period")?;
    let seen = seen(config);
    let turn_s = 1.0 / config.spindle_hz;
    let per_turn = steps_in(turn_s, &seen, steps_per_period, variation.amplitude);
    let steps = (per_turn as f64 / variation.frequency_ratio)
        .round()
        .max(1.0);
    let grid = Grid {
        mean_hz: config.spindle_hz,
        variation: SpeedVariation {
            frequency_ratio: per_turn as f64 / steps,
            ..variation
        },
        per_turn,
        phases: 1,
        steps: steps as usize,
        knots: KNOTS_TURNED,
    };
    grid.system(seen, per_turn, |_, hz| law(config, width_m, hz, per_turn))
}
/// The cut at a speed, Hz, with the delay in steps.
pub(super) fn law(config: &TurningConfig, width_m: f64, spindle_hz: f64, delay: usize) -> StepLaw {
    let rub = config
        .process_damping
        .map_or(0.0, |p| p.per_speed(spindle_hz));
    let along_x = |value: f64| [[value, 0.0], [0.0; 2], [0.0; 2]];
    StepLaw {
        regeneration: vec![(delay, along_x(config.ks_n_per_m2 * width_m))],
        rubbing: along_x(rub * width_m),
    }
}

/// The modes as the cut sees them.
pub(super) fn seen(config: &TurningConfig) -> Vec<Seen> {
    let modes = config.modes.iter();
    modes
        .map(|mode| Seen {
            mode: *mode,
            input: [1.0, 0.0, 0.0],
            chip: [1.0, 0.0],
            motion: [1.0, 0.0],
        })
        .collect()
}

/// Starts of Newton's method in the distance of two roots, 1/T.
const STARTS: f64 = 3.0;

/// Starts at most: 20 kHz at one turn a second.
const MOST_STARTS: usize = 120_000;

/// The `wanted` least damped roots of turning, exactly.
///
/// With constant coefficients the delay equation has a characteristic equation,
/// 1 + b·\[Ks·(1 - e^(-sT)) + s·C/V\]·G(s) = 0 with G = Σ 1/(m(s² + 2ζωs + ω²)),
/// which Newton's method solves from starts all along the frequencies up to twice
/// the highest mode. Where a revolution holds hundreds of vibrations this is
/// thousands of times faster than [`turning_delay`], and it has no step. A speed that
/// swings is taken for its mean.
///
/// # Errors
/// As [`turning_delay`].
pub fn turning_roots(
    config: &TurningConfig,
    width_m: f64,
    wanted: usize,
) -> Result<Vec<Root>, PlantError> {
    config.validate()?;
    non_negative(width_m, "width_m")?;
    require(!config.modes.is_empty(), "modes")?;
    for mode in &config.modes {
        mode.validate()?;
    }
    let law = Characteristic::new(config, width_m);
    let highest = config.modes.iter().map(|m| m.f_hz).fold(0.0, f64::max);
    let step = config.spindle_hz / STARTS;
    let count = (2.0 * highest / step).ceil() as usize;
    if count > MOST_STARTS {
        return Err(PlantError::TooLarge {
            name: "spindle_hz",
            most: MOST_STARTS,
        });
    }
    let mut found: Vec<Complex<f64>> = Vec::new();
    let starts = (1..=count).flat_map(|i| {
        let branch = law.start(TAU * step * i as f64);
        [branch, Complex::new(0.0, branch.im)]
    });
    // At small widths the roots are the modes, far from the branches.
    let modes = config.modes.iter().map(|m| {
        let w = m.omega();
        Complex::new(-m.zeta * w, w * (1.0 - m.zeta * m.zeta).sqrt())
    });
    found.extend(
        starts
            .chain(modes)
            .filter_map(|start| law.newton(start))
            .filter(|s| s.im > 0.0),
    );
    // Several starts lead to one root: neighbours once they are sorted.
    found.sort_by(|x, y| x.im.total_cmp(&y.im));
    let mut apart: Vec<Complex<f64>> = Vec::new();
    for s in found {
        let near = |o: &Complex<f64>| (o - s).norm() < 1e-6 * s.norm();
        let close = apart.iter().rev();
        let mut close = close.take_while(|o| s.im - o.im < 1e-6 * s.norm());
        if !close.any(near) {
            apart.push(s);
        }
    }
    let mut found = apart;
    found.sort_by(|x, y| y.re.total_cmp(&x.re));
    found.truncate(wanted);
    Ok(found
        .into_iter()
        .map(|s| {
            let multiplier = (s * law.delay_s).exp();
            Root {
                f_hz: s.norm() / TAU,
                zeta: -s.re / s.norm(),
                growth_per_s: s.re,
                multiplier: (multiplier.re, multiplier.im),
                purity: 1.0,
            }
        })
        .collect())
}

/// D(s) and its derivative.
struct Characteristic {
    /// 1/m, 2ζω, ω² of each mode.
    modes: Vec<[f64; 3]>,
    cutting: f64,
    rubbing: f64,
    delay_s: f64,
}

impl Characteristic {
    fn new(config: &TurningConfig, width_m: f64) -> Self {
        let rub = config
            .process_damping
            .map_or(0.0, |p| p.per_speed(config.spindle_hz));
        Self {
            modes: config
                .modes
                .iter()
                .map(|m| {
                    let w = m.omega();
                    [1.0 / m.mass_kg(), 2.0 * m.zeta * w, w * w]
                })
                .collect(),
            cutting: config.ks_n_per_m2 * width_m,
            rubbing: rub * width_m,
            delay_s: 1.0 / config.spindle_hz,
        }
    }

    /// Π pᵢ and Σ Πⱼ≠ᵢ pⱼ/mᵢ with p = s² + 2ζωs + ω², and their derivatives: G as
    /// numerator and denominator, so that the function has no poles.
    fn receptance(&self, s: Complex<f64>) -> [Complex<f64>; 4] {
        let zero = Complex::new(0.0, 0.0);
        let one = Complex::new(1.0, 0.0);
        let mut out = [one, zero, zero, zero];
        for m in &self.modes {
            // Scaled by ω², so that products of many modes stay near 1.
            let p = (s * s + s * m[1] + m[2]) / m[2];
            let d = (s * 2.0 + m[1]) / m[2];
            let [den, den_slope, num, num_slope] = out;
            out = [
                den * p,
                den_slope * p + den * d,
                num * p + den * (m[0] / m[2]),
                num_slope * p + num * d + den_slope * (m[0] / m[2]),
            ];
        }
        out
    }

    /// On the branch at frequency `w` the delayed wave comes back as
    /// e^(sT) = cG/(1 + (c + rs)G): the real part of s from its size.
    fn start(&self, w: f64) -> Complex<f64> {
        let s = Complex::new(0.0, w);
        let [den, _, num, _] = self.receptance(s);
        let back = num * self.cutting / (num * (s * self.rubbing + self.cutting) + den);
        Complex::new(back.norm().ln() / self.delay_s, w)
    }

    fn newton(&self, mut s: Complex<f64>) -> Option<Complex<f64>> {
        for _ in 0..60 {
            let e = (-s * self.delay_s).exp();
            let [den, den_slope, num, num_slope] = self.receptance(s);
            let force = (-e + 1.0) * self.cutting + s * self.rubbing;
            let value = den + num * force;
            let derivative = den_slope
                + num_slope * force
                + num * (e * (self.cutting * self.delay_s) + self.rubbing);
            let mut step = value / derivative;
            // Never further than to the next root: longer steps jump past it.
            let most = 0.5 * TAU / self.delay_s;
            if step.norm() > most {
                step *= most / step.norm();
            }
            s -= step;
            if !(s.norm() < 1e9) {
                return None;
            }
            if step.norm() < 1e-12 * s.norm() {
                return Some(s);
            }
        }
        None
    }
}
