//! Eddy currents in the laminations: how far the flux of the gap lags the current.
//!
//! Rate: slow path, once a line of a spectrum.

use super::error::{CersError, within};
use crate::els::Complex;
use rarma_core::real::Real;

/// Laminated iron in series with the gap.
///
/// One-dimensional diffusion into a lamination of thickness d leaves the permeability
/// µ·tanh(z)/z, so that the gap's flux over its value without eddy currents is
///
/// ```text
/// G(f) = (2s + l/µ_r) / (2s + (l/µ_r)·z/tanh z),   z = (d/2)·√(j2πf·σ·µ₀µ_r)
/// ```
///
/// for e^{+jωt}: |G| < 1, arg G < 0. Small changes of the force about a bias follow the
/// flux, so a force reconstructed from the current is to be multiplied by G line by line
/// ([`Self::correct`]). Products of two changes (a force at twice the frequency) are not
/// covered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eddy<T> {
    /// Thickness of a lamination d, m, 0 (none) to 5 mm.
    pub lamination_m: T,
    /// Conductivity σ, S/m, 1e4 to 1e8; 2e6 for silicon steel.
    pub conductivity_s_per_m: T,
    /// Relative permeability µ_r, 10 to 1e6.
    pub permeability: T,
    /// Path in iron l, m, 0 to 10.
    pub iron_path_m: T,
    /// Gap s, m, 1e-5 to 1e-2.
    pub gap_m: T,
}

impl<T: Real> Eddy<T> {
    /// Checks every field.
    ///
    /// # Errors
    /// `OutOfRange` with the first field.
    pub fn validate(&self) -> Result<(), CersError> {
        let check =
            |x: T, low: f64, high: f64, name| within(x, T::from_f64(low), T::from_f64(high), name);
        check(self.lamination_m, 0.0, 5e-3, "lamination_m")?;
        check(self.conductivity_s_per_m, 1e4, 1e8, "conductivity_s_per_m")?;
        check(self.permeability, 10.0, 1e6, "permeability")?;
        check(self.iron_path_m, 0.0, 10.0, "iron_path_m")?;
        check(self.gap_m, 1e-5, 1e-2, "gap_m")
    }

    /// G at `f_hz` ≥ 0.
    ///
    /// ```
    /// use rarma_rigs::cers::Eddy;
    /// let eddy = Eddy {
    ///     lamination_m: 0.35e-3,
    ///     conductivity_s_per_m: 2e6,
    ///     permeability: 3000.0,
    ///     iron_path_m: 0.12,
    ///     gap_m: 150e-6,
    /// };
    /// let g = eddy.flux(5e3_f64);
    /// assert!((g.abs() - 0.90).abs() < 0.01 && (g.im.atan2(g.re).to_degrees() + 12.0).abs() < 1.0);
    /// ```
    pub fn flux(&self, f_hz: T) -> Complex<T> {
        let two = T::from_f64(2.0);
        let gap = two * self.gap_m;
        let iron = self.iron_path_m / self.permeability;
        // √j = (1 + j)/√2, so z = a(1 + j) with a = (d/2)·√(πfσµ).
        let mu = T::from_f64(super::design::MU_0) * self.permeability;
        let a = self.lamination_m / two * (T::PI * f_hz * self.conductivity_s_per_m * mu).sqrt();
        let rest = Complex::new(gap, T::ZERO) + z_over_tanh(a).scale(iron);
        rest.inverse().scale(gap + iron)
    }

    /// A spectral line of a force reconstructed from currents, with the lag of the flux.
    pub fn correct(&self, line: Complex<T>, f_hz: T) -> Complex<T> {
        line * self.flux(f_hz)
    }
}

/// z/tanh z for z = a(1 + j).
fn z_over_tanh<T: Real>(a: T) -> Complex<T> {
    let z = Complex::new(a, a);
    let square = Complex::new(T::ZERO, a * a * T::from_f64(2.0));
    if a < T::from_f64(0.03) {
        // 1 + z²/3 − z⁴/45: the next term is below 1e-11 here.
        let fourth = (square * square).scale(-T::ONE / T::from_f64(45.0));
        return Complex::new(T::ONE, T::ZERO) + square.scale(T::ONE / T::from_f64(3.0)) + fourth;
    }
    // tanh z = (1 − e^(−2z))/(1 + e^(−2z)): does not overflow.
    let size = (-T::from_f64(2.0) * a).exp();
    let (s, c) = (T::from_f64(2.0) * a).sin_cos();
    let e = Complex::new(size * c, -size * s);
    let one = Complex::new(T::ONE, T::ZERO);
    z * (one + e) * (one - e).inverse()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eddy(lamination_m: f64) -> Eddy<f64> {
        Eddy {
            lamination_m,
            conductivity_s_per_m: 2e6,
            permeability: 3000.0,
            iron_path_m: 0.12,
            gap_m: 150e-6,
        }
    }

    #[test]
    fn lag_is_the_published_one() {
        // Per cent and degrees at 1, 2 and 5 kHz.
        for (d, rows) in [
            (0.50e-3, [(-3.0, -6.0), (-8.0, -10.0), (-20.0, -15.0)]),
            (0.35e-3, [(-1.0, -3.0), (-3.0, -6.0), (-10.0, -12.0)]),
            (0.20e-3, [(0.0, -1.0), (0.0, -2.0), (-2.0, -5.0)]),
            (0.10e-3, [(0.0, 0.0), (0.0, 0.0), (0.0, -1.0)]),
        ] {
            for (f, (size, angle)) in [1e3, 2e3, 5e3].into_iter().zip(rows) {
                let g = eddy(d).flux(f);
                let (percent, degrees) = (100.0 * (g.abs() - 1.0), g.im.atan2(g.re).to_degrees());
                println!("{d} m {f} Hz: {percent:+.2} % {degrees:+.2}°");
                assert!((percent - size).abs() < 0.7, "{d} {f}: {percent}");
                assert!((degrees - angle).abs() < 0.7, "{d} {f}: {degrees}");
            }
        }
    }

    #[test]
    fn it_is_the_sum_over_its_relaxations() {
        // z/tanh z = 1 + 2·Σ jω/(jω + p_n), p_n = n²π²·4/(d²σµ): an independent form.
        let e = eddy(0.35e-3);
        let mu = super::super::design::MU_0 * e.permeability;
        for f in [0.0, 1.0, 500.0, 5e3, 2e4] {
            let w = core::f64::consts::TAU * f;
            let mut sum = Complex::new(1.0, 0.0);
            for n in 1..200_000 {
                let p = (f64::from(n) * core::f64::consts::PI / (e.lamination_m / 2.0)).powi(2)
                    / (e.conductivity_s_per_m * mu);
                sum = sum + Complex::new(0.0, 2.0 * w) * Complex::new(p, w).inverse();
            }
            let rest = Complex::new(300e-6, 0.0) + sum.scale(40e-6);
            let g = rest.inverse().scale(340e-6);
            assert!((g - e.flux(f)).abs() < 1e-5, "{f}: {g:?} {:?}", e.flux(f));
        }
    }

    #[test]
    fn both_branches_meet_and_no_lamination_has_no_lag() {
        let at = |a: f64| z_over_tanh(a);
        assert!((at(0.029_999) - at(0.030_001)).abs() < 1e-6);
        assert_eq!(eddy(0.0).flux(5e3), Complex::new(1.0, 0.0));
        let single = Eddy::<f32> {
            lamination_m: 0.35e-3,
            conductivity_s_per_m: 2e6,
            permeability: 3000.0,
            iron_path_m: 0.12,
            gap_m: 150e-6,
        };
        let (a, b) = (single.flux(2e3), eddy(0.35e-3).flux(2e3));
        assert!((f64::from(a.re) - b.re).abs() < 1e-6 && (f64::from(a.im) - b.im).abs() < 1e-6);
    }
}
