//! Natural frequencies and damping from a measured receptance.

use super::complex::Complex;
use super::error::ElsError;
use super::polar::rising;
use super::rational::Rational;
use rarma_core::real::Real;
use rarma_core::spectrum::{FactorTracker, Roots};

/// One mode read off a receptance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FittedMode<T> {
    /// Undamped natural frequency, Hz.
    pub f_hz: T,
    /// Damping ratio, 1.
    pub zeta: T,
    /// Modal stiffness at the measured point and direction, N/m: that of the single
    /// mode with a residue of this size, ω²/(2·ω_d·|R|).
    pub stiffness_n_per_m: T,
    /// Angle of the residue from that of a mode without phase (−90°), rad: large where
    /// two modes are read as one, or the damping is not proportional.
    pub phase: T,
}

/// A receptance taken apart; see [`fit_modes`].
#[derive(Debug, Clone, Copy)]
pub struct ModesFit<T, const N: usize> {
    fit: Rational<T, N>,
    modes: [FittedMode<T>; N],
    count: usize,
}

impl<T: Real, const N: usize> ModesFit<T, N> {
    /// The modes by rising frequency: damped pole pairs inside the band. May be fewer
    /// than asked for; the others serve what lies outside, or noise.
    pub fn modes(&self) -> &[FittedMode<T>] {
        &self.modes[..self.count]
    }

    /// √(Σ|G − fit|²/Σ|G|²), 1.
    pub fn residual(&self) -> T {
        self.fit.residual
    }

    /// Rounds of the fit.
    pub fn rounds(&self) -> u32 {
        self.fit.rounds
    }

    /// The fitted receptance at `f` Hz, m/N; means nothing outside the band.
    pub fn at(&self, f: T) -> Complex<T> {
        self.fit.at(f)
    }
}

/// Modes of one receptance by a rational function in s through all its lines (complex
/// rational fraction, iterated to the error of the receptance itself):
///
/// ```text
/// min over B, A of Σ_f |G(f) − B(j2πf)/A(j2πf)|²,   deg A = 2n, deg B = 2n + 2
/// ```
///
/// n pole pairs, and three terms for what lies above the band. Roots λ of A: f = |λ|/2π, ζ =
/// −Re λ/|λ|. Every line weighs alike: peaks rule. Works on displacement over force;
/// accelerance gives the same poles.
///
/// Exact for data of at most n modes. Real structures have more than are asked for:
/// compare several n ([`ModesFit::residual`]).
///
/// Generics: `N` ≥ 4n + 3. Needs as many lines. `f32` is enough for two or three modes.
///
/// # Errors
/// `TooFewLines`, `DifferentLengths`, `Grid`, `NotFinite`, `OrderAboveCapacity`;
/// `OutOfRange` for no mode; `Singular` if A is not determined.
pub fn fit_modes<T: Real, const N: usize>(
    f: &[T],
    g: &[Complex<T>],
    modes: usize,
) -> Result<ModesFit<T, N>, ElsError> {
    if modes == 0 {
        return Err(ElsError::OutOfRange { name: "modes" });
    }
    if f.len() != g.len() {
        return Err(ElsError::DifferentLengths);
    }
    rising(f, 3)?;
    if let Some(index) = g.iter().position(|g| !g.is_finite()) {
        return Err(ElsError::NotFinite { index });
    }
    let fit = Rational::<T, N>::fit(f, g, modes)?;
    let mut out = ModesFit {
        fit,
        modes: [FittedMode::default(); N],
        count: 0,
    };
    let (a, degree) = fit.powers();
    let mut roots = FactorTracker::<T, N>::new();
    roots.solve(&a[..degree], 300).ok_or(ElsError::Singular)?;
    let low = f.first().copied().unwrap_or(T::ZERO);
    for factor in roots.factors(degree) {
        if let Roots::Pair { re, im } = factor.roots() {
            let pole = Complex::new(re, im);
            let size = pole.abs();
            let f_hz = size * fit.top_hz();
            if re < T::ZERO && f_hz >= low && f_hz <= fit.top_hz() && out.count < N {
                out.modes[out.count] = mode(&fit, pole, f_hz);
                out.count += 1;
            }
        }
    }
    // Insertion: a handful.
    for i in 1..out.count {
        let mut k = i;
        while k > 0 && out.modes[k].f_hz < out.modes[k - 1].f_hz {
            out.modes.swap(k, k - 1);
            k -= 1;
        }
    }
    Ok(out)
}

fn mode<T: Real, const N: usize>(fit: &Rational<T, N>, pole: Complex<T>, f_hz: T) -> FittedMode<T> {
    let two_pi = T::from_f64(2.0) * T::PI;
    let residue = fit.residue(pole);
    let (w, damped) = (two_pi * f_hz, two_pi * fit.top_hz() * pole.im);
    FittedMode {
        f_hz,
        zeta: -pole.re / pole.abs(),
        stiffness_n_per_m: w * w / (T::from_f64(2.0) * damped * residue.abs()),
        phase: residue.re.atan2(-residue.im),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Case = (f64, f64, f64);
    const THREE: [Case; 3] = [
        (1074.0, 0.034, 11e6),
        (1961.0, 0.045, 30e6),
        (2617.0, 0.02, 60e6),
    ];

    fn receptance(modes: &[Case], f: f64) -> Complex<f64> {
        modes.iter().fold(Complex::ZERO, |sum, &(f0, z, k)| {
            let r = f / f0;
            sum + Complex::new(1.0 - r * r, 2.0 * z * r).scale(k).inverse()
        })
    }

    fn lines(modes: &[Case]) -> (Vec<f64>, Vec<Complex<f64>>) {
        let f: Vec<f64> = (500..=3000).map(f64::from).collect();
        let g = f.iter().map(|&f| receptance(modes, f)).collect();
        (f, g)
    }

    #[test]
    fn exact_modes_come_back() {
        let (f, g) = lines(&THREE);
        let fit = fit_modes::<_, 32>(&f, &g, 3).expect("a fit");
        assert!(fit.residual() < 1e-10, "{}", fit.residual());
        assert_eq!(fit.modes().len(), 3);
        for (m, (f0, z, k)) in fit.modes().iter().zip(THREE) {
            assert!((m.f_hz / f0 - 1.0).abs() < 1e-9, "{m:?}");
            assert!((m.zeta / z - 1.0).abs() < 1e-8, "{m:?}");
            assert!((m.stiffness_n_per_m / k - 1.0).abs() < 1e-7, "{m:?}");
            assert!(m.phase.abs() < 1e-7, "{m:?}");
        }
    }

    #[test]
    fn a_mode_above_the_band_does_not_move_those_inside() {
        let mut four = THREE.to_vec();
        four.push((4200.0, 0.02, 40e6));
        let (f, g) = lines(&four);
        let fit = fit_modes::<_, 32>(&f, &g, 3).expect("a fit");
        for (m, (f0, z, _)) in fit.modes().iter().zip(THREE) {
            assert!((m.f_hz / f0 - 1.0).abs() < 1e-3, "{m:?}");
            assert!((m.zeta / z - 1.0).abs() < 0.03, "{m:?}");
        }
    }

    #[test]
    fn single_precision_reads_two_modes() {
        let (f, g) = lines(&THREE[..2]);
        let f: Vec<f32> = f.iter().map(|&x| x as f32).collect();
        let g: Vec<_> = g
            .iter()
            .map(|z| Complex::new(z.re as f32, z.im as f32))
            .collect();
        let fit = fit_modes::<_, 16>(&f, &g, 2).expect("a fit");
        assert!((fit.modes()[0].f_hz - 1074.0).abs() < 0.2);
        assert!((fit.modes()[1].zeta - 0.045).abs() < 2e-4);
    }

    #[test]
    fn refusals() {
        let (f, g) = lines(&THREE);
        let of = |f: &[f64], g: &[Complex<f64>], n| fit_modes::<_, 16>(f, g, n).err();
        assert_eq!(of(&f, &g, 4), Some(ElsError::OrderAboveCapacity));
        assert_eq!(of(&f, &g, 0), Some(ElsError::OutOfRange { name: "modes" }));
        assert_eq!(of(&f[..9], &g, 1), Some(ElsError::DifferentLengths));
        let few = Some(ElsError::TooFewLines { needed: 7 });
        assert_eq!(of(&f[..5], &g[..5], 1), few);
    }
}
