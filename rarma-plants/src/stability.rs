//! Limits of stability in closed form: orthogonal turning, and milling by the
//! zero-order method.
//!
//! Slow path; nothing here runs per step. The zero-order method (Altintas and
//! Budak) keeps only the mean of the periodic directional factors. Against the
//! converged time simulation it is within about 3 % for a slot and for half
//! immersion of a symmetric structure; at small immersion it misses the
//! period-doubling lobes altogether, so do not use it there.
//!
//! Glossary: *ε* phase between the wave being cut and the one left before;
//! *κ* ratio of imaginary to real part of the eigenvalue Λ.

use super::error::{PlantError, positive, require};
use super::milling::{Engagement, MillingConfig};
use super::modal::Mode;
use core::f64::consts::{PI, TAU};
use nalgebra::Complex;

/// A point on a stability border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Limit depth (milling) or chip width (turning), m.
    pub depth_m: f64,
    /// Chatter frequency there, Hz.
    pub chatter_hz: f64,
}

/// Lowest limit of 1-DOF turning over all speeds.
///
/// b = 2kζ(1+ζ)/Ks at ωc = ω√(1+2ζ), where the real part of the receptance has
/// its minimum -1/(4kζ(1+ζ)).
#[must_use]
pub fn turning_limit(mode: &Mode, ks_n_per_m2: f64) -> Limit {
    let z = mode.zeta;
    Limit {
        depth_m: 2.0 * mode.stiffness_n_per_m * z * (1.0 + z) / ks_n_per_m2,
        chatter_hz: mode.f_hz * (1.0 + 2.0 * z).sqrt(),
    }
}

/// Spindle frequency, Hz, of the lowest point of turning lobe `j`.
///
/// n = fc/(j + ε/2π), ε = 3π + 2·atan(Im G/Re G) taken within one turn.
#[must_use]
pub fn turning_lobe_hz(mode: &Mode, lobe: u32) -> f64 {
    let fc = turning_limit(mode, 1.0).chatter_hz;
    let (re, im) = mode.receptance(TAU * fc);
    let epsilon = (3.0 * PI + 2.0 * (im / re).atan()).rem_euclid(TAU);
    fc / (f64::from(lobe) + epsilon / TAU)
}

/// Limit of turning with any modes at one spindle frequency.
///
/// b = -1/(2·Ks·Re G(ω)) wherever ω·T = ε(ω) + 2πj; the lowest of them.
///
/// # Errors
/// `NoLimit` if no frequency from half the lowest to twice the highest mode
/// satisfies the phase condition; `OutOfRange` naming a field.
pub fn turning_limit_at(
    modes: &[Mode],
    ks_n_per_m2: f64,
    spindle_hz: f64,
) -> Result<Limit, PlantError> {
    positive(ks_n_per_m2, "ks_n_per_m2")?;
    let candidates = |w: f64| {
        let g = receptance(modes, w);
        let epsilon = (3.0 * PI + 2.0 * (g.im / g.re).atan()).rem_euclid(TAU);
        [
            (-1.0 / (2.0 * ks_n_per_m2 * g.re), epsilon, g),
            (-1.0, 0.0, g),
        ]
    };
    lowest(modes, spindle_hz, candidates)
}

/// Mean directional factors \[αxx, αxy, αyx, αyy\] of an arc, for `kr` = Kn/Kt,
/// with the factor ½ included.
#[must_use]
pub fn directional_factors(arc: Engagement, kr: f64) -> [f64; 4] {
    let primitive = |p: f64| {
        let (s, c) = (2.0 * p).sin_cos();
        [
            c - 2.0 * kr * p + kr * s,
            -s - 2.0 * p + kr * c,
            -s + 2.0 * p + kr * c,
            -c - 2.0 * kr * p - kr * s,
        ]
    };
    let (a, b) = (primitive(arc.entry_rad), primitive(arc.exit_rad));
    core::array::from_fn(|i| 0.5 * (b[i] - a[i]))
}

/// Zero-order limit depth of milling at the spindle speed of the configuration.
///
/// Λ solves a0·Λ² + a1·Λ + 1 = 0 with a0 = Gx·Gy·(αxx·αyy - αxy·αyx), a1 =
/// αxx·Gx + αyy·Gy; a = -2π·Re Λ·(1+κ²)/(N·Kt), ε = π - 2·atan κ; of all
/// frequencies with ω·τ = ε + 2πj the one of lowest positive depth counts.
/// Runout, edge forces, unequal pitch and process damping are not in it.
///
/// # Errors
/// `NoLimit` if there is none; `OutOfRange` naming a field.
pub fn milling_limit(config: &MillingConfig) -> Result<Limit, PlantError> {
    let modes = all_modes(config);
    lowest(&modes, config.tooth_hz(), |w| milling_border(config, w))
}

/// Lowest zero-order limit over all spindle speeds.
///
/// # Errors
/// As [`milling_limit`].
pub fn milling_minimum(config: &MillingConfig) -> Result<Limit, PlantError> {
    let modes = all_modes(config);
    frequencies(&modes)?
        .flat_map(|w| milling_border(config, w).map(|(a, _, _)| (a, w)))
        .filter(|(a, _)| *a > 0.0)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(depth_m, w)| Limit {
            depth_m,
            chatter_hz: w / TAU,
        })
        .ok_or(PlantError::NoLimit)
}

fn all_modes(config: &MillingConfig) -> Vec<Mode> {
    config
        .modes_x
        .iter()
        .chain(&config.modes_y)
        .copied()
        .collect()
}

/// Depth (≤ 0: no limit), phase ε and eigenvalue of one branch.
type Border = (f64, f64, Complex<f64>);

/// Both eigenvalues at one frequency.
fn milling_border(config: &MillingConfig, w: f64) -> [Border; 2] {
    let gx = receptance(&config.modes_x, w);
    let gy = receptance(&config.modes_y, w);
    let [xx, xy, yx, yy] =
        directional_factors(config.engagement, config.kn_n_per_m2 / config.kt_n_per_m2);
    let a0 = gx * gy * (xx * yy - xy * yx);
    let a1 = gx * xx + gy * yy;
    let border = |lambda: Complex<f64>| {
        let kappa = lambda.im / lambda.re;
        let n = config.teeth as f64;
        let depth = -TAU * lambda.re * (1.0 + kappa * kappa) / (n * config.kt_n_per_m2);
        (depth, PI - 2.0 * kappa.atan(), lambda)
    };
    if a0.norm() < 1e-12 * a1.norm() * a1.norm() {
        return [border(-a1.inv()), (-1.0, 0.0, Complex::ZERO)];
    }
    let root = (a1 * a1 - 4.0 * a0).sqrt();
    let scale = (-2.0 * a0).inv();
    [border((a1 + root) * scale), border((a1 - root) * scale)]
}

const GRID: usize = 40_000;

/// Angular frequencies from half the lowest to twice the highest mode.
fn frequencies(modes: &[Mode]) -> Result<impl Iterator<Item = f64> + use<>, PlantError> {
    require(!modes.is_empty(), "modes")?;
    for mode in modes {
        mode.validate()?;
    }
    let low = modes.iter().map(Mode::omega).fold(f64::INFINITY, f64::min) * 0.5;
    let high = modes.iter().map(Mode::omega).fold(0.0, f64::max) * 2.0;
    Ok((0..=GRID).map(move |i| low + (high - low) * i as f64 / GRID as f64))
}

/// Walks along the frequencies, pairs the two branches by continuity, and takes
/// the lowest depth at which ω/(2π·rate) - ε/2π passes an integer.
fn lowest(
    modes: &[Mode],
    rate_hz: f64,
    border: impl Fn(f64) -> [Border; 2],
) -> Result<Limit, PlantError> {
    positive(rate_hz, "spindle_hz")?;
    let mut best: Option<Limit> = None;
    let mut before: Option<(f64, [Border; 2])> = None;
    for w in frequencies(modes)? {
        let mut now = border(w);
        if let Some((w0, old)) = before {
            let gap = |a: Complex<f64>, b: Complex<f64>| (a - b).norm();
            let straight = gap(now[0].2, old[0].2) + gap(now[1].2, old[1].2);
            let crossed = gap(now[1].2, old[0].2) + gap(now[0].2, old[1].2);
            if crossed < straight {
                now.swap(0, 1);
            }
            for (a, b) in old.iter().zip(&now) {
                if a.0 <= 0.0 || b.0 <= 0.0 {
                    continue;
                }
                let (pa, pb) = (
                    w0 / (TAU * rate_hz) - a.1 / TAU,
                    w / (TAU * rate_hz) - b.1 / TAU,
                );
                let level = pa.max(pb).floor();
                if pa.min(pb) < level {
                    let part = (level - pa) / (pb - pa);
                    let depth_m = a.0 + part * (b.0 - a.0);
                    if best.is_none_or(|l| depth_m < l.depth_m) {
                        best = Some(Limit {
                            depth_m,
                            chatter_hz: (w0 + part * (w - w0)) / TAU,
                        });
                    }
                }
            }
        }
        before = Some((w, now));
    }
    best.ok_or(PlantError::NoLimit)
}

fn receptance(modes: &[Mode], w: f64) -> Complex<f64> {
    modes.iter().fold(Complex::ZERO, |sum, m| {
        let (re, im) = m.receptance(w);
        sum + Complex::new(re, im)
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The published two-tooth benchmark, symmetric.
    pub(crate) fn benchmark(engagement: Engagement, rpm: f64) -> MillingConfig {
        let mode = Mode::from_mass(922.0, 0.011, 0.03993);
        MillingConfig {
            engagement,
            spindle_hz: rpm / 60.0,
            modes_x: vec![mode],
            modes_y: vec![mode],
            ..MillingConfig::default()
        }
    }

    #[test]
    fn turning_closed_form() {
        let mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);
        let limit = turning_limit(&mode, 2e9);
        assert!((limit.depth_m - 0.2407e-3).abs() < 0.5e-7);
        assert!((limit.chatter_hz - 999.4).abs() < 0.1);
        let spindle = turning_lobe_hz(&mode, 5);
        assert!(
            (spindle * 60.0 - 10_422.9).abs() < 0.5,
            "{}",
            spindle * 60.0
        );
        let scanned = turning_limit_at(&[mode], 2e9, spindle).expect("limit");
        assert!((scanned.depth_m / limit.depth_m - 1.0).abs() < 1e-4);
        assert!((scanned.chatter_hz - limit.chatter_hz).abs() < 0.2);
        let higher = turning_limit_at(&[mode], 2e9, spindle * 1.05).expect("limit");
        assert!(higher.depth_m > 1.2 * limit.depth_m);
    }

    #[test]
    fn slot_factors() {
        let got = directional_factors(Engagement::SLOT, 1.0 / 3.0);
        for (g, w) in got.iter().zip([-PI / 3.0, -PI, PI, -PI / 3.0]) {
            assert!((g - w).abs() < 1e-12);
        }
    }

    #[test]
    fn zero_order_slot_and_half_immersion() {
        // Slot: roots of the characteristic equation with the mean directional
        // matrix, found separately by Newton's method.
        for (rpm, slot, half) in [
            (6e3, 0.04948, 0.129),
            (10e3, 0.07355, 0.181),
            (15e3, 0.11714, 0.281),
            (20e3, 0.06256, 0.174),
        ] {
            let limit = |arc| milling_limit(&benchmark(arc, rpm)).expect("limit").depth_m * 1e3;
            let got = limit(Engagement::SLOT);
            assert!((got / slot - 1.0).abs() < 0.001, "slot {rpm}: {got}");
            for arc in [Engagement::up(0.5), Engagement::down(0.5)] {
                let got = limit(arc);
                assert!((got / half - 1.0).abs() < 0.03, "half {rpm}: {got}");
            }
        }
    }

    #[test]
    fn lowest_of_all_speeds() {
        let all = milling_minimum(&benchmark(Engagement::SLOT, 6e3)).expect("limit");
        assert!(
            (all.depth_m * 1e3 - 0.0479).abs() < 0.0002,
            "{}",
            all.depth_m * 1e3
        );
        assert!((all.chatter_hz - 923.6).abs() < 0.5, "{}", all.chatter_hz);
    }

    #[test]
    fn rigid_machine_has_no_limit() {
        let mut config = benchmark(Engagement::SLOT, 6e3);
        config.modes_x.clear();
        config.modes_y.clear();
        assert!(milling_limit(&config).is_err());
    }
}
