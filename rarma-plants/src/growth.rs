//! The stability limit found the hard way: watch a small disturbance grow or
//! decay in the time simulation itself.
//!
//! Slow path. Independent of the closed forms in the stability module, so each
//! checks the other; unlike them it includes unequal pitch and process
//! damping, and period doubling at small immersion.

use super::error::{PlantError, positive};
use super::milling::{Milling, MillingConfig};
use super::process::{Contact, ForceNoise, Schedule, Wear};

/// Growth of a small disturbance of milling at depth `depth_m`, 1/s; negative
/// if it decays.
///
/// Runs the linear equation for `duration_s`, without feed, runout and noise,
/// from a disturbance of the first mode of each direction, and compares the
/// level in the last quarter with that in the second: ln(ratio)/(half the
/// duration). Quarters are whole revolutions; take tens of vibration periods each.
/// Torsion makes chips by the feed alone: there the feed stays, and the motion of
/// an undisturbed machine is subtracted.
///
/// # Errors
/// As [`Milling::new`].
pub fn milling_growth(
    config: &MillingConfig,
    depth_m: f64,
    duration_s: f64,
) -> Result<f64, PlantError> {
    positive(duration_s, "duration_s")?;
    let mut linear = config.clone();
    linear.contact = Contact::Linear;
    linear.depth = Schedule::constant(depth_m);
    let torsion = config.modes_other.iter().any(|m| m.turn_rad_per_m != 0.0);
    if !torsion {
        linear.feed_per_tooth_m = 0.0;
    }
    linear.runout_m.clear();
    linear.noise = ForceNoise::default();
    linear.workpiece = None;
    linear.wear = Wear::default();
    linear.speed = None;
    let mut mill = Milling::new(linear)?;
    let mut still = torsion.then(|| mill.clone());
    // The equation is linear: large against the rounding of what is subtracted.
    mill.disturb(0, 0, 1e-4, 0.0);
    mill.disturb(1, 0, 0.7e-4, 0.0);
    mill.disturb(2, 0, 0.5e-4, 0.0);
    // Quarters of whole revolutions: the modulation by the teeth averages out.
    let turn = (mill.step_rate_hz() / config.spindle_hz).round();
    // Where the speed swings, quarters of whole swings, to a step.
    let turns = duration_s * config.spindle_hz / 4.0;
    let quarter = match &config.variation {
        Some(v) => (turns * v.frequency_ratio).ceil() / v.frequency_ratio * turn,
        None => turns.ceil() * turn,
    }
    .round() as usize;
    let mut energy = [0.0_f64; 4];
    for sum in &mut energy {
        for _ in 0..quarter {
            let [mut x, mut y] = mill.step().position_m;
            if let Some(still) = &mut still {
                let [x0, y0] = still.step().position_m;
                x -= x0;
                y -= y0;
            }
            *sum += x * x + y * y;
        }
    }
    let time = 2.0 * quarter as f64 / (turn * config.spindle_hz);
    Ok(0.5 * (energy[3] / energy[1]).ln() / time)
}

/// Depth at which [`milling_growth`] is zero, by bisection between `low` and
/// `high` m until the bracket is below `tolerance` of the depth.
///
/// # Errors
/// `NoLimit` unless `low` decays and `high` grows; else as [`milling_growth`].
pub fn milling_limit_in_time(
    config: &MillingConfig,
    mut low: f64,
    mut high: f64,
    duration_s: f64,
    tolerance: f64,
) -> Result<f64, PlantError> {
    positive(tolerance, "tolerance")?;
    let stable = |depth: f64| Ok(milling_growth(config, depth, duration_s)? < 0.0);
    if !stable(low)? || stable(high)? {
        return Err(PlantError::NoLimit);
    }
    while high - low > tolerance * high {
        let middle = 0.5 * (low + high);
        if stable(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(0.5 * (low + high))
}
