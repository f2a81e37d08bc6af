//! A machine, a tool and a material, drawn at random, and the depth at which they chatter.

use super::ranges::{self as r, chance, one_of};
use crate::PlantError;
use crate::cut::Process;
use crate::delay::DepthSearch;
use crate::milling::{Engagement, MillingConfig};
use crate::modal::{Mode, ShapedMode};
use crate::process::{Contact, ForceNoise, Schedule};
use crate::truth::limit_of;
use crate::turning::TurningConfig;
use core::f64::consts::{PI, TAU};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Draws before a seed is given up.
const TRIES: usize = 40;
/// Steps of the simulation in a period of the fastest mode: limits within 1 %.
const STEPS_PER_PERIOD: f64 = 50.0;
/// The search of the limit goes from this part of an estimate up to this multiple.
const SEARCH: [f64; 2] = [0.3, 30.0];
/// One depth of that search over the one before. It bounds the time of a draw.
const SEARCH_RATIO: f64 = 1.5;

/// A machine at its limit.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    /// The process, its depth constant at the limit.
    pub process: Process,
    /// Depth or width at which it loses stability, m.
    pub limit_m: f64,
}

/// Draws until there is a limit.
///
/// # Errors
/// `NoLimit` after many draws without one; else a defect of the ranges.
pub(super) fn draw(rng: &mut ChaCha8Rng) -> Result<Machine, PlantError> {
    for _ in 0..TRIES {
        let (process, guess_m) = if chance(rng, r::TURNED) {
            turning(rng)
        } else {
            let Some(drawn) = milling(rng) else { continue };
            drawn
        };
        let search = DepthSearch {
            low_m: SEARCH[0] * guess_m,
            high_m: SEARCH[1] * guess_m,
            ratio: SEARCH_RATIO,
            tolerance: 0.01,
        };
        match limit_of(&process, f64::INFINITY, &search) {
            Ok(border) => {
                let limit_m = border.depth_m;
                return Ok(Machine {
                    process: process.at_depth(Schedule::constant(limit_m)),
                    limit_m,
                });
            }
            Err(PlantError::NoLimit | PlantError::GivenUp | PlantError::Unsettled) => {}
            Err(other) => return Err(other),
        }
    }
    Err(PlantError::NoLimit)
}

fn modes(rng: &mut ChaCha8Rng) -> Vec<Mode> {
    let count = rng.random_range(1..=r::MOST_MODES);
    (0..count)
        .map(|_| Mode {
            f_hz: r::MODE_HZ.draw(rng),
            zeta: r::ZETA.draw(rng),
            stiffness_n_per_m: r::STIFFNESS_N_PER_M.draw(rng),
        })
        .collect()
}

fn fastest_hz(modes: &[Mode]) -> f64 {
    modes.iter().map(|m| m.f_hz).fold(0.0, f64::max)
}

/// 2kζ/K of the weakest mode: the order of every limit (exact for one mode in turning,
/// but for 1 + ζ).
fn guess_m(modes: &[Mode], cutting_n_per_m2: f64) -> f64 {
    let weakest = modes
        .iter()
        .map(|m| m.stiffness_n_per_m * m.zeta)
        .fold(f64::INFINITY, f64::min);
    2.0 * weakest / cutting_n_per_m2
}

fn noise(rng: &mut ChaCha8Rng) -> ForceNoise {
    ForceNoise {
        relative: r::FORCE_NOISE.draw(rng),
        background_n: r::BACKGROUND_N.draw(rng),
        ..ForceNoise::default()
    }
}

fn turning(rng: &mut ChaCha8Rng) -> (Process, f64) {
    let modes = modes(rng);
    let ks = r::CUTTING_N_PER_M2.draw(rng);
    let guess = guess_m(&modes, ks);
    let fastest = fastest_hz(&modes);
    let config = TurningConfig {
        spindle_hz: r::TURNED_RPM.draw(rng) / 60.0,
        variation: None,
        feed_m: r::FEED_M.draw(rng),
        ks_n_per_m2: ks,
        edge_n_per_m: r::EDGE_N_PER_M.draw(rng),
        nose_radius_m: 0.8e-3,
        modes,
        width: Schedule::constant(guess),
        process_damping: None,
        noise: noise(rng),
        contact: Contact::Real,
        min_step_rate_hz: (STEPS_PER_PERIOD * fastest).max(24_000.0),
        seed: rng.random(),
    };
    (Process::Turning(Box::new(config)), guess)
}

/// `None` where the delay equation would take too long.
fn milling(rng: &mut ChaCha8Rng) -> Option<(Process, f64)> {
    let modes = modes(rng);
    let teeth = rng.random_range(r::TEETH.0..=r::TEETH.1);
    let spindle_hz = r::SPEED_RPM.draw(rng) / 60.0;
    let fastest = fastest_hz(&modes);
    let unequal = teeth > 1 && chance(rng, r::UNEQUAL_PITCH.0);
    // With unequal pitch the period of the equation is the whole turn.
    let periods_hz = spindle_hz * if unequal { 1.0 } else { teeth as f64 };
    if fastest / periods_hz > r::MOST_WAVES {
        return None;
    }
    let kt = r::CUTTING_N_PER_M2.draw(rng);
    let feed = r::FEED_M.draw(rng);
    let edge = r::EDGE_N_PER_M.draw(rng);
    let immersion = r::IMMERSION.draw(rng);
    let arc = one_of(rng, &[0, 1, 2]);
    let engagement = match arc {
        0 => Engagement::up(immersion),
        1 => Engagement::down(immersion),
        _ => Engagement::SLOT,
    };
    let radial = r::RADIAL_PART.draw(rng);
    let runout = r::RUNOUT.draw(rng) * feed;
    let guess =
        guess_m(&modes, kt) * TAU / (teeth as f64 * (engagement.exit_rad - engagement.entry_rad));
    let config = MillingConfig {
        teeth,
        pitch_rad: if unequal {
            pitches(rng, teeth)
        } else {
            Vec::new()
        },
        runout_m: (0..teeth)
            .map(|_| runout * (2.0 * rng.random::<f64>() - 1.0))
            .collect(),
        spindle_hz,
        feed_per_tooth_m: feed,
        kt_n_per_m2: kt,
        kn_n_per_m2: radial * kt,
        kt_edge_n_per_m: edge,
        kn_edge_n_per_m: edge,
        engagement,
        modes_other: modes.into_iter().map(|m| anywhere(rng, m)).collect(),
        depth: Schedule::constant(guess),
        noise: noise(rng),
        min_step_rate_hz: (STEPS_PER_PERIOD * fastest).max(24_000.0),
        seed: rng.random(),
        ..MillingConfig::default()
    };
    Some((Process::Milling(Box::new(config)), guess))
}

/// A mode that bends in some direction.
fn anywhere(rng: &mut ChaCha8Rng, mode: Mode) -> ShapedMode {
    let (y, x) = (PI * rng.random::<f64>()).sin_cos();
    ShapedMode {
        x,
        y,
        at_sensor: r::Span::ratio(0.3, 1.0).draw(rng),
        ..ShapedMode::along_x(mode)
    }
}

/// Pitches that add up to a turn, each off the mean.
fn pitches(rng: &mut ChaCha8Rng, teeth: usize) -> Vec<f64> {
    let off = r::UNEQUAL_PITCH.1.draw(rng);
    let raw: Vec<f64> = (0..teeth)
        .map(|_| 1.0 + off * (2.0 * rng.random::<f64>() - 1.0))
        .collect();
    let sum: f64 = raw.iter().sum();
    raw.iter().map(|p| TAU * p / sum).collect()
}
