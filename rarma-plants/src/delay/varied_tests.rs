//! The truth of a swinging speed against an integration in time that shares nothing
//! with it: fixed steps of time, Runge-Kutta of fourth order, the delay by bisection of
//! the angle in closed form, the past by Hermite cubics.

use super::*;
use crate::growth::milling_growth;
use crate::milling::{Engagement, MillingConfig};
use crate::process::{Contact, ForceNoise, Schedule};
use crate::stability::tests::benchmark;
use crate::turning::{Turning, TurningConfig};
use crate::variation::SpeedVariation;
use core::f64::consts::{PI, TAU};

const MODE: Mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);
const KS: f64 = 2e9;

fn lathe(rpm: f64, rva: f64, rvf: f64) -> TurningConfig {
    TurningConfig {
        spindle_hz: rpm / 60.0,
        variation: Some(SpeedVariation {
            amplitude: rva,
            frequency_ratio: rvf,
        }),
        feed_m: 0.0,
        ks_n_per_m2: KS,
        edge_n_per_m: 0.0,
        nose_radius_m: 0.8e-3,
        modes: vec![MODE],
        width: Schedule::constant(1e-4),
        process_damping: None,
        noise: ForceNoise::default(),
        contact: Contact::Linear,
        min_step_rate_hz: 100_000.0,
        seed: 0,
    }
}

fn growth(system: &DelaySystem) -> f64 {
    system.radius().ln() / system.period_s()
}

/// Growth, 1/s, of q̈ + 2ζω·q̇ + ω²·q = -κ(angle)·(q(t) - q(t-τ))/m in time.
///
/// κ in N/m for the angle, in turns, of tooth 0; `teeth` evenly spaced; growth between whole
/// swings, of the mean of ω²q² + q̇².
fn in_time(
    mode: &Mode,
    (n0, teeth): (f64, f64),
    (rva, rvf): (f64, f64),
    stiffness: impl Fn(f64) -> f64,
    swings: (usize, usize),
) -> f64 {
    let f = rvf * n0;
    // The angle, in turns, in closed form.
    let angle = |t: f64| n0 * t + n0 * rva / (TAU * f) * (1.0 - (TAU * f * t).cos());
    let h = 1.0 / (80.0 * mode.f_hz);
    let delay = |t: f64| {
        let (mut low, mut high) = (0.3 / (n0 * teeth), 3.0 / (n0 * teeth));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if angle(t) - angle(t - middle) < 1.0 / teeth {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    let (w, m) = (mode.omega(), mode.mass_kg());
    let count = (swings.0 + swings.1) as f64 / f / h;
    // At rest before time 0, so that the past is known there.
    let mut past: Vec<[f64; 2]> = vec![[1e-6, 0.0]];
    let before = |past: &[[f64; 2]], t: f64| {
        if t <= 0.0 {
            return 0.0;
        }
        let place = t / h;
        let i = (place as usize).min(past.len() - 2);
        let u = place - i as f64;
        let ([a, da], [b, db]) = (past[i], past[i + 1]);
        let (u2, u3) = (u * u, u * u * u);
        (2.0 * u3 - 3.0 * u2 + 1.0) * a
            + (u3 - 2.0 * u2 + u) * h * da
            + (3.0 * u2 - 2.0 * u3) * b
            + (u3 - u2) * h * db
    };
    let slope = |past: &[[f64; 2]], t: f64, [q, v]: [f64; 2]| {
        let old = if past.len() > 1 {
            before(past, t - delay(t))
        } else {
            0.0
        };
        let force = -stiffness(angle(t)) * (q - old);
        [v, force / m - 2.0 * mode.zeta * w * v - w * w * q]
    };
    let at = |s: [f64; 2], k: [f64; 2], part: f64| [s[0] + part * h * k[0], s[1] + part * h * k[1]];
    let swing = (1.0 / f / h).round() as usize;
    let mut energy = Vec::new();
    let mut sum = 0.0;
    for i in 0..count as usize {
        let (t, s) = (i as f64 * h, past[i]);
        let k1 = slope(&past, t, s);
        let k2 = slope(&past, t + 0.5 * h, at(s, k1, 0.5));
        let k3 = slope(&past, t + 0.5 * h, at(s, k2, 0.5));
        let k4 = slope(&past, t + h, at(s, k3, 1.0));
        let next = [0, 1].map(|c| s[c] + h / 6.0 * (k1[c] + 2.0 * k2[c] + 2.0 * k3[c] + k4[c]));
        past.push(next);
        sum += (w * next[0]).powi(2) + next[1].powi(2);
        if (i + 1) % swing == 0 {
            energy.push(sum);
            sum = 0.0;
        }
    }
    let last = energy.len() - 1;
    0.5 * (energy[last] / energy[swings.0]).ln() / ((last - swings.0) as f64 * swing as f64 * h)
}

#[test]
fn turning_that_swings_grows_as_it_does_in_time() {
    // 39 waves in a turn; 1.4 and 2 times the limit of its speed; quick and slow swings.
    for (rpm, rva, rvf, width_m) in [
        (1500.0, 0.1, 0.2, 0.35e-3),
        (1500.0, 0.05, 0.5, 0.5e-3),
        (1500.0, 0.2, 0.08, 0.5e-3),
        (6000.0, 0.2, 0.05, 0.4e-3),
    ] {
        let config = lathe(rpm, rva, rvf);
        let truth = growth(&turning_delay(&config, width_m, 60.0).expect("valid"));
        let n0 = rpm / 60.0;
        let time = in_time(&MODE, (n0, 1.0), (rva, rvf), |_| KS * width_m, (4, 12));
        let mut still = config.clone();
        still.variation = None;
        let constant = turning_roots(&still, width_m, 1).expect("roots")[0].growth_per_s;
        println!("{rpm} {rva} {rvf}: truth {truth:.3} in time {time:.3}, constant {constant:.3}");
        assert!(constant > 1.0, "{constant}");
        assert!(
            (truth - time).abs() < 0.01 * truth.abs() + 0.15,
            "{truth} {time}"
        );
        // The swing is worth more than the tolerance.
        assert!((truth - constant).abs() > 2.0, "{truth} {constant}");
    }
}

#[test]
fn milling_that_swings_grows_as_it_does_in_time() {
    let mode = Mode::from_mass(922.0, 0.011, 0.03993);
    let (kt, kn) = (6e8, 2e8);
    for (rpm, rva, rvf, depth_m) in [
        (6000.0, 0.1, 0.1, 0.5e-3),
        (6000.0, 0.25, 0.05, 0.6e-3),
        (20_000.0, 0.1, 0.04, 2e-3),
    ] {
        let mut config = benchmark(Engagement::SLOT, rpm);
        config.modes_y = Vec::new();
        config.variation = Some(SpeedVariation {
            amplitude: rva,
            frequency_ratio: rvf,
        });
        let truth = growth(&milling_delay(&config, depth_m, 60.0).expect("valid"));
        // Angle from +y, in the slot from 0 to π: h = x·sin φ, Fx = -Ft·cos φ - Fr·sin φ.
        let stiffness = |turns: f64| {
            [0.0, 0.5]
                .iter()
                .map(|tooth| TAU * (turns - tooth).rem_euclid(1.0))
                .filter(|phi| *phi < PI)
                .map(|phi| depth_m * phi.sin() * (kt * phi.cos() + kn * phi.sin()))
                .sum::<f64>()
        };
        let time = in_time(&mode, (rpm / 60.0, 2.0), (rva, rvf), stiffness, (3, 12));
        let simulated = milling_growth(&config, depth_m, 16.0 / (rvf * rpm / 60.0)).expect("valid");
        config.variation = None;
        let constant = growth(&milling_delay(&config, depth_m, 60.0).expect("valid"));
        println!(
            "{rpm} {rva} {rvf}: truth {truth:.3} in time {time:.3}, simulated {simulated:.3}, constant {constant:.3}"
        );
        for other in [time, simulated] {
            assert!(
                (truth - other).abs() < 0.015 * truth.abs() + 0.3,
                "{truth} {other}"
            );
        }
        assert!((truth - constant).abs() > 2.0, "{truth} {constant}");
    }
}

#[test]
fn a_swing_of_nothing_changes_nothing() {
    let width_m = 0.35e-3;
    let mut config = lathe(1500.0, 1e-6, 0.25);
    let swinging = growth(&turning_delay(&config, width_m, 60.0).expect("valid"));
    config.variation = None;
    let still = growth(&turning_delay(&config, width_m, 60.0).expect("valid"));
    assert!(
        (swinging - still).abs() < 1e-3 * still.abs(),
        "{swinging} {still}"
    );
    let mut mill = benchmark(Engagement::down(0.5), 10e3);
    mill.pitch_rad = vec![0.48 * TAU, 0.52 * TAU];
    for pitch in [mill.pitch_rad.clone(), Vec::new()] {
        mill.pitch_rad = pitch;
        mill.variation = None;
        let still = milling_delay(&mill, 0.3e-3, 60.0).expect("valid").roots(1)[0];
        mill.variation = Some(SpeedVariation {
            amplitude: 1e-6,
            frequency_ratio: 0.1,
        });
        let swinging = milling_delay(&mill, 0.3e-3, 60.0).expect("valid").roots(1)[0];
        let off = swinging.growth_per_s - still.growth_per_s;
        assert!(
            off.abs() < 2e-3 * still.growth_per_s.abs(),
            "{swinging:?} {still:?}"
        );
        assert!(
            (swinging.f_hz / still.f_hz - 1.0).abs() < 0.02,
            "{swinging:?} {still:?}"
        );
    }
}

/// Shorter steps of the truth and of the simulation lead to the same.
#[test]
fn truth_and_simulation_converge() {
    let config = lathe(1500.0, 0.1, 0.2);
    let width_m = 0.35e-3;
    let truth = |steps: f64| growth(&turning_delay(&config, width_m, steps).expect("valid"));
    let (coarse, middle, fine) = (truth(30.0), truth(60.0), truth(120.0));
    let ratio = (coarse - middle) / (middle - fine);
    println!("truth {coarse:.4} {middle:.4} {fine:.4}: {ratio:.2}");
    assert!((3.0..5.5).contains(&ratio), "{coarse} {middle} {fine}");
    let simulated = |rate: f64| {
        let mut config = config.clone();
        config.min_step_rate_hz = rate;
        config.width = Schedule::constant(width_m);
        let mut machine = Turning::new(config).expect("valid");
        machine.disturb(0, 1e-6, 0.0);
        let swing = 5 * machine.steps_per_turn();
        let energy: Vec<f64> = (0..16)
            .map(|_| {
                let q = (0..swing).map(|_| machine.step().velocity_m_s.powi(2));
                q.sum()
            })
            .collect();
        0.5 * (energy[15] / energy[4]).ln() / (11.0 * 0.2)
    };
    let (a, b) = (simulated(50_000.0), simulated(200_000.0));
    println!("simulated {a:.4} {b:.4}");
    assert!((b - fine).abs() < 0.1, "{b} {fine}");
    assert!((a - fine).abs() > 2.0 * (b - fine).abs(), "{a} {b} {fine}");
}

/// S. Seguy, T. Insperger, L. Arnaud, G. Dessein, G. Peigné, "On the stability of high-speed
/// milling with spindle speed variation", Int. J. Adv. Manuf. Technol. 48 (2010): at high
/// speeds a swing suppresses period doubling, and does little for the quasi-periodic chatter
/// of the first Hopf lobe.
#[test]
fn a_swing_helps_a_flip_at_high_speed_and_not_the_hopf_lobe() {
    let gain = |rpm: f64, depth: (f64, f64)| {
        let mut config: MillingConfig = benchmark(Engagement::up(0.5), rpm);
        config.modes_y = Vec::new();
        let search = DepthSearch {
            low_m: depth.0,
            high_m: depth.1,
            ratio: 1.1,
            tolerance: 1e-3,
        };
        let at = |config: &MillingConfig| {
            limit(&search, |d| milling_delay(config, d, 40.0)).expect("a limit")
        };
        let still = at(&config);
        config.variation = Some(SpeedVariation {
            amplitude: 0.1,
            frequency_ratio: 0.1,
        });
        (still, at(&config).depth_m / still.depth_m)
    };
    let (flip, helped) = gain(22_000.0, (0.3e-3, 30e-3));
    assert_eq!(flip.crossing, Crossing::Flip);
    let (hopf, unhelped) = gain(38_000.0, (0.05e-3, 30e-3));
    assert_eq!(hopf.crossing, Crossing::Hopf);
    // Many waves, where the technique comes from.
    let (slow, slow_helped) = gain(8000.0, (0.1e-3, 30e-3));
    assert_eq!(slow.crossing, Crossing::Hopf);
    println!("flip times {helped:.3}, first Hopf lobe {unhelped:.3}, low speed {slow_helped:.3}");
    assert!((1.3..1.6).contains(&helped), "{helped}");
    assert!((0.95..1.1).contains(&unhelped), "{unhelped}");
    assert!((1.5..2.2).contains(&slow_helped), "{slow_helped}");
}
