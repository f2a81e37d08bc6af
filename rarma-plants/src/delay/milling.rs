//! Milling as a periodic delay equation.

use super::varied::{Grid, KNOTS, MOST_SWINGS, steps_in};
use super::{DelaySystem, Seen, StepLaw, too_many};
use crate::error::{PlantError, non_negative, positive};
use crate::milling::MillingConfig;
use crate::variation::SpeedVariation;
use core::f64::consts::TAU;

/// Axial slices over which a helical edge is averaged.
const SLICES: usize = 24;

/// Milling at axial depth `depth_m`, with at least `steps_per_period` steps in a
/// period of the fastest mode.
///
/// The linear equation: every tooth in the arc cuts, runout and edge forces do
/// not matter to a small disturbance. Equal teeth: the period is that of a
/// tooth; unequal pitch: a revolution, delays rounded to whole steps. A speed that
/// swings: the common period of its swings and of that.
///
/// # Errors
/// As [`MillingConfig::validate`]; `OutOfRange` without modes, at a depth that is
/// negative or no number, or with steps that are too long for the modes or the depth.
pub fn milling_delay(
    config: &MillingConfig,
    depth_m: f64,
    steps_per_period: f64,
) -> Result<DelaySystem, PlantError> {
    if let Some(variation) = config.variation.filter(|v| v.amplitude > 0.0) {
        return swinging(config, variation, depth_m, steps_per_period);
    }
    config.validate()?;
    non_negative(depth_m, "depth_m")?;
    positive(steps_per_period, "steps_per_period")?;
    let shapes = config.shaped_modes();
    let highest = shapes.iter().map(|s| s.mode.f_hz).fold(0.0, f64::max);
    let per_tooth = (steps_per_period * highest / config.tooth_hz())
        .ceil()
        .max(40.0) as usize;
    let equal = config.pitch_rad.is_empty();
    let (steps, period_s) = if equal {
        (per_tooth, 1.0 / config.tooth_hz())
    } else {
        (per_tooth * config.teeth, 1.0 / config.spindle_hz)
    };
    too_many(steps, shapes.len(), "spindle_hz")?;
    let step_rad = TAU * period_s * config.spindle_hz / steps as f64;
    let teeth = teeth(config, step_rad);
    let laws: Vec<StepLaw> = (0..steps)
        .map(|k| law(config, depth_m, k as f64 * step_rad, step_rad, &teeth))
        .collect();
    DelaySystem::new(seen(config), period_s, &laws)
}

/// [`milling_delay`] of a cut whose speed swings.
///
/// # Errors
/// As there; `TooLarge` where the common period holds too many steps.
fn swinging(
    config: &MillingConfig,
    variation: SpeedVariation,
    depth_m: f64,
    steps_per_period: f64,
) -> Result<DelaySystem, PlantError> {
    config.validate()?;
    non_negative(depth_m, "depth_m")?;
    positive(steps_per_period, "steps_per_period")?;
    let seen = seen(config);
    let equal = config.pitch_rad.is_empty();
    let tooth_s = 1.0 / config.tooth_hz();
    let per_tooth = steps_in(tooth_s, &seen, steps_per_period, variation.amplitude);
    let per_turn = per_tooth * config.teeth;
    let (phases, of) = if equal {
        (per_tooth, config.teeth as f64)
    } else {
        (per_turn, 1.0)
    };
    let (swings, passes) = variation.whole(of, MOST_SWINGS);
    let grid = Grid {
        mean_hz: config.spindle_hz,
        variation: SpeedVariation {
            frequency_ratio: swings as f64 * of / passes as f64,
            ..variation
        },
        per_turn,
        phases,
        steps: passes.saturating_mul(phases),
        knots: KNOTS,
    };
    let step_rad = TAU / per_turn as f64;
    let teeth = teeth(config, step_rad);
    let history = teeth.iter().map(|t| t.1).max().unwrap_or(1);
    grid.system(seen, history, |phase, hz| {
        let at = MillingConfig {
            spindle_hz: hz,
            ..config.clone()
        };
        law(&at, depth_m, phase as f64 * step_rad, step_rad, &teeth)
    })
}

/// The modes as the cut sees them.
pub(super) fn seen(config: &MillingConfig) -> Vec<Seen> {
    let ahead = config.feed_ahead_m_per_rad();
    let shapes = config.shaped_modes().into_iter();
    shapes
        .map(|s| Seen {
            mode: s.mode,
            input: [s.x, s.y, s.turn_rad_per_m],
            chip: [s.x - ahead * s.turn_rad_per_m, s.y],
            motion: [s.x, s.y],
        })
        .collect()
}

/// Angle by which each tooth trails tooth 0, and its delay in steps.
pub(super) fn teeth(config: &MillingConfig, step_rad: f64) -> Vec<(f64, usize)> {
    let n = config.teeth;
    let pitch = |j: usize| config.pitch_rad.get(j).copied().unwrap_or(TAU / n as f64);
    let mut trail = 0.0;
    (0..n)
        .map(|j| {
            let before = pitch((j + n - 1) % n);
            let tooth = (trail, ((before / step_rad).round() as usize).max(1));
            trail += pitch(j);
            tooth
        })
        .collect()
}

/// Means over the step from angle `from` of tooth 0.
pub(super) fn law(
    config: &MillingConfig,
    depth_m: f64,
    from: f64,
    step_rad: f64,
    teeth: &[(f64, usize)],
) -> StepLaw {
    let rub = config
        .process_damping
        .map_or((0.0, 0.0), |p| (p.per_speed(config.spindle_hz), p.friction));
    let radius = 0.5 * config.diameter_m;
    let lag = config.helix_lag_rad(depth_m);
    let slices = if lag > 0.0 { SLICES } else { 1 };
    let mut out = StepLaw::default();
    for (trail, delay) in teeth {
        let mut mean = Moments::default();
        for slice in 0..slices {
            let behind = trail + lag * (slice as f64 + 0.5) / slices as f64;
            mean.add(config, (from - behind).rem_euclid(TAU), step_rad);
        }
        let share = depth_m / (slices as f64 * step_rad);
        let k = mean.coupling(config.kt_n_per_m2, config.kn_n_per_m2, radius);
        let r = mean.coupling(rub.0 * rub.1, rub.0, radius);
        let k = k.map(|row| row.map(|x| x * share));
        for (sum, row) in out.rubbing.iter_mut().zip(r) {
            for (s, x) in sum.iter_mut().zip(row) {
                *s += x * share;
            }
        }
        match out.regeneration.iter_mut().find(|(d, _)| d == delay) {
            Some((_, sum)) => {
                for (s, x) in sum.iter_mut().flatten().zip(k.iter().flatten()) {
                    *s += x;
                }
            }
            None => out.regeneration.push((*delay, k)),
        }
    }
    out
}

/// Integrals of sin², sin·cos, cos², sin and cos over the part of a step in the arc.
#[derive(Default)]
struct Moments {
    ss: f64,
    sc: f64,
    cc: f64,
    s: f64,
    c: f64,
}

impl Moments {
    fn add(&mut self, config: &MillingConfig, from: f64, step: f64) {
        let arc = config.engagement;
        for turn in [0.0, TAU] {
            let low = from.max(arc.entry_rad + turn);
            let high = (from + step).min(arc.exit_rad + turn);
            if high <= low {
                continue;
            }
            let (s0, c0) = low.sin_cos();
            let (s1, c1) = high.sin_cos();
            let (plain, double) = (high - low, s1 * c1 - s0 * c0);
            self.ss += 0.5 * (plain - double);
            self.cc += 0.5 * (plain + double);
            self.sc += 0.5 * (s1 * s1 - s0 * s0);
            self.s += c0 - c1;
            self.c += s1 - s0;
        }
    }

    /// F = -K·Δ for tangential and radial coefficients kt and kn.
    fn coupling(&self, kt: f64, kn: f64, radius: f64) -> super::Coupling {
        [
            [kt * self.sc + kn * self.ss, kt * self.cc + kn * self.sc],
            [-kt * self.ss + kn * self.sc, -kt * self.sc + kn * self.cc],
            [radius * kt * self.s, radius * kt * self.c],
        ]
    }
}
