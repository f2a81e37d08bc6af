//! Turning as a delay equation.

use super::{DelaySystem, Seen, StepLaw};
use crate::plant::error::{PlantError, positive};
use crate::plant::turning::TurningConfig;

/// Turning at chip width `width_m`, with at least `steps_per_period` steps in a
/// period of the fastest mode.
///
/// One delay of one revolution and constant coefficients: the "period" is the
/// delay itself.
///
/// # Errors
/// As [`TurningConfig::validate`]; `OutOfRange` without modes.
pub fn turning_delay(
    config: &TurningConfig,
    width_m: f64,
    steps_per_period: f64,
) -> Result<DelaySystem, PlantError> {
    config.validate()?;
    positive(steps_per_period, "steps_per_period")?;
    let highest = config.modes.iter().map(|m| m.f_hz).fold(0.0, f64::max);
    let steps = (steps_per_period * highest / config.spindle_hz)
        .ceil()
        .max(40.0) as usize;
    let rub = config
        .process_damping
        .map_or(0.0, |p| p.per_speed(config.spindle_hz));
    let along_x = |value: f64| [[value, 0.0], [0.0; 2], [0.0; 2]];
    let law = StepLaw {
        regeneration: vec![(steps, along_x(config.ks_n_per_m2 * width_m))],
        rubbing: along_x(rub * width_m),
    };
    let seen = config
        .modes
        .iter()
        .map(|mode| Seen {
            mode: *mode,
            input: [1.0, 0.0, 0.0],
            chip: [1.0, 0.0],
            motion: [1.0, 0.0],
        })
        .collect();
    DelaySystem::new(seen, 1.0 / config.spindle_hz, &vec![law; steps])
}
