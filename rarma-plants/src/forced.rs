//! What teeth and runout force of a cut that does not chatter, played in time until the start has died away.
//!
//! Slow path.

use super::error::PlantError;
use super::milling::{Milling, MillingConfig};
use super::process::{ForceNoise, Schedule};
use core::f64::consts::TAU;

// Chosen by 121 stable speeds of 60 drawn cuts, each against a play twenty times as long and as fine: error of the
// vibration in the median, in 90 % and in 99 %, as a ratio: 2, 12, 100 %. The last are speeds beside the limit, where
// the start hardly dies away. Half and double of each constant stand beside it.

/// What the start leaves is waited for so many time constants of the mode that keeps it longest: 2 % are left.
/// Half: 2, 22, 127 %; double: 1, 8, 86 %.
const SETTLED: f64 = 4.0;
/// ... but not longer, s, so that a slow mode does not keep everybody waiting: one of 100 Hz and 1 % would take 0.64.
/// Half and double change nothing.
const MOST_S: f64 = 0.5;
/// It is measured over whole turns, for so long at least, s. One turn would do if nothing were left of the start: what
/// is left beats with the teeth, some tens of a second. Half: 2, 13, 120 %; double: 1, 9, 95 %.
const MEASURED_S: f64 = 0.05;
/// Steps a period of the fastest mode: the force is a square, and its third multiple counts.
/// Half: 3, 23, 105 %; double: 1, 11, 114 %.
const STEPS: f64 = 40.0;

/// Vibration of the tool in milling about its mean, m rms over both directions, at a constant depth, m, and at the
/// nominal speed: of feed and runout alone, without noise and a workpiece's gaps. 0 of a tool without modes.
///
/// It means something where the cut is stable.
///
/// # Errors
/// As [`Milling::new`].
pub fn milling_forced_m(config: &MillingConfig, depth_m: f64) -> Result<f64, PlantError> {
    let modes = config.shaped_modes();
    let decays_per_s = modes.iter().map(|m| TAU * m.mode.zeta * m.mode.f_hz);
    let Some(slowest_per_s) = decays_per_s.reduce(f64::min) else {
        return Ok(0.0);
    };
    let fastest_hz = modes.iter().map(|m| m.mode.f_hz).fold(0.0, f64::max);
    let mut mill = Milling::new(MillingConfig {
        speed: None,
        variation: None,
        workpiece: None,
        depth: Schedule::constant(depth_m),
        noise: ForceNoise::default(),
        min_step_rate_hz: STEPS * fastest_hz,
        ..config.clone()
    })?;
    let steps = |s: f64| (s / mill.dt()).ceil() as usize;
    let settles = steps((SETTLED / slowest_per_s).min(MOST_S));
    let turns = (MEASURED_S * config.spindle_hz).ceil();
    let count = steps(turns / config.spindle_hz);
    (0..settles).for_each(|_| {
        mill.step();
    });
    let (mut sum, mut squares) = ([0.0; 2], 0.0);
    for _ in 0..count {
        let at = mill.step().position_m;
        for (sum, x) in sum.iter_mut().zip(at) {
            *sum += x / count as f64;
            squares += x * x / count as f64;
        }
    }
    let mean_square: f64 = sum.iter().map(|x| x * x).sum();
    Ok((squares - mean_square).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::Engagement;
    use crate::modal::Mode;
    use crate::process::Contact;
    use core::f64::consts::{FRAC_PI_2, PI};

    const DEPTH_M: f64 = 3e-4;
    const MODE: Mode = Mode {
        f_hz: 1000.0,
        zeta: 0.02,
        stiffness_n_per_m: 1e7,
    };

    /// One mode along the feed, two teeth, up to half of the diameter.
    fn mill(spindle_hz: f64) -> MillingConfig {
        MillingConfig {
            spindle_hz,
            feed_per_tooth_m: 1e-4,
            engagement: Engagement::up(0.5),
            modes_x: vec![MODE],
            ..MillingConfig::default()
        }
    }

    /// What the teeth force of the mode, m rms: Fourier's series of the force of a chip that is the feed times the sine
    /// of the angle, through the mode. What comes with every tooth is not fed back: each leaves the wave of the last.
    fn by_series(c: &MillingConfig) -> f64 {
        let points = 4000;
        // A tooth is in the cut for a quarter of a turn, half of its period.
        let force = |k: usize| {
            let angle = PI * k as f64 / points as f64;
            let chip = if angle < FRAC_PI_2 {
                c.feed_per_tooth_m * angle.sin()
            } else {
                0.0
            };
            let (sin, cos) = angle.sin_cos();
            DEPTH_M * chip * (c.kt_n_per_m2 * cos + c.kn_n_per_m2 * sin)
        };
        let squares: f64 = (1..=12)
            .map(|multiple| {
                let f_hz = f64::from(multiple) * 2.0 * c.spindle_hz;
                let (mut re, mut im) = (0.0, 0.0);
                for k in 0..points {
                    let turn = TAU * f64::from(multiple) * k as f64 / points as f64;
                    re += 2.0 * force(k) * turn.cos() / points as f64;
                    im += 2.0 * force(k) * turn.sin() / points as f64;
                }
                let ratio = f_hz / MODE.f_hz;
                let gain = 1.0 / MODE.stiffness_n_per_m;
                let gain = gain / (1.0 - ratio * ratio).hypot(2.0 * MODE.zeta * ratio);
                0.5 * (gain * re.hypot(im)).powi(2)
            })
            .sum();
        squares.sqrt()
    }

    #[test]
    fn it_is_that_of_the_series() {
        for spindle_hz in (75..=225).step_by(5).map(f64::from) {
            let config = mill(spindle_hz);
            let ratio = milling_forced_m(&config, DEPTH_M).expect("played") / by_series(&config);
            assert!((ratio - 1.0).abs() < 0.05, "{spindle_hz}: {ratio}");
        }
    }

    #[test]
    fn what_is_not_forced_has_no_part_in_it() {
        let still = milling_forced_m(&mill(150.0), DEPTH_M).expect("played");
        let noisy = MillingConfig {
            noise: ForceNoise {
                relative: 0.2,
                ..ForceNoise::default()
            },
            speed: Some(Schedule::constant(200.0)),
            depth: Schedule::constant(1.0),
            ..mill(150.0)
        };
        assert_eq!(milling_forced_m(&noisy, DEPTH_M), Ok(still));
        let rigid = MillingConfig {
            modes_x: Vec::new(),
            ..mill(150.0)
        };
        assert_eq!(milling_forced_m(&rigid, DEPTH_M), Ok(0.0));
        let unfed = MillingConfig {
            feed_per_tooth_m: 0.0,
            contact: Contact::Linear,
            ..mill(150.0)
        };
        assert_eq!(milling_forced_m(&unfed, DEPTH_M), Ok(0.0));
        let bad = MillingConfig {
            teeth: 0,
            ..mill(150.0)
        };
        assert!(milling_forced_m(&bad, DEPTH_M).is_err());
    }
}
