//! Static stiffness: the receptance in the limit of zero frequency.

use super::complex::Complex;
use super::error::ElsError;
use super::polar::rising;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// A static stiffness with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StaticStiffness<T> {
    /// Stiffness, N/m.
    pub n_per_m: T,
    /// Standard deviation of it, N/m: u(k) = k²·u(c).
    pub sd_n_per_m: T,
    /// Compliance c = Re G(0), m/N.
    pub compliance_m_per_n: T,
    /// Standard deviation of it, m/N.
    pub compliance_sd_m_per_n: T,
    /// Lines that were used.
    pub lines: usize,
}

/// Static stiffness from the lines below the first mode:
///
/// ```text
/// Re G(f) = c + c₂·f² + c₄·f⁴ + e,   k = 1/c
/// ```
///
/// Below resonance the real part of every sum of modes is a power series in f², so the
/// limit is an extrapolation, and its uncertainty grows with the distance of the lowest
/// line from zero. An accelerometer measures nothing near zero (its receptance is divided by
/// −ω²): leave out the lines where the sensor's noise shows. The series cut off at f⁴
/// leaves about (f/f₁)⁶ of the compliance: with `high_hz` a third of the first mode
/// 0.1 %, at half of it 1.6 %.
///
/// Uses the lines of `f` between `low_hz` and `high_hz`. Standard deviation from the
/// residuals; lines are taken as independent.
///
/// # Errors
/// `DifferentLengths`, `Grid`, `NotFinite`; `TooFewLines` with fewer than 6 in the band;
/// `Singular` where the compliance is not positive.
pub fn static_stiffness<T: Real>(
    f: &[T],
    direct: &[Complex<T>],
    low_hz: T,
    high_hz: T,
) -> Result<StaticStiffness<T>, ElsError> {
    const TERMS: usize = 3;
    if f.len() != direct.len() {
        return Err(ElsError::DifferentLengths);
    }
    rising(f, 6)?;
    if let Some(index) = direct.iter().position(|g| !g.is_finite()) {
        return Err(ElsError::NotFinite { index });
    }
    let inside = || {
        f.iter()
            .zip(direct)
            .filter(|(f, _)| **f >= low_hz && **f <= high_hz)
    };
    let lines = inside().count();
    if lines < 6 {
        return Err(ElsError::TooFewLines { needed: 6 });
    }
    // In units of the mean, so that 1e-8 m/N squared stays within `f32`.
    let unit = inside().map(|(_, g)| g.re.abs()).sum::<T>() / T::from_u32(lines as u32);
    if !(unit > T::ZERO) {
        return Err(ElsError::Singular);
    }
    let mut triangle = Triangle::<T, TERMS>::new(TERMS);
    let row = |f: T| {
        let x = f * f / (high_hz * high_hz);
        [T::ONE, x, x * x]
    };
    for (&f, g) in inside() {
        let _ = triangle.add(&mut row(f), g.re / unit);
    }
    let found = triangle.solve().ok_or(ElsError::Singular)?;
    let covariance = triangle.inverse_normal().ok_or(ElsError::Singular)?;
    let mut squares = T::ZERO;
    for (&f, g) in inside() {
        let x = row(f);
        let e = g.re / unit - (found[0] + found[1] * x[1] + found[2] * x[2]);
        squares += e * e;
    }
    let variance = squares / T::from_u32((lines - TERMS) as u32) * covariance[0][0];
    let (c, u) = (found[0] * unit, variance.max(T::ZERO).sqrt() * unit);
    if !(c > T::ZERO && u.is_finite()) {
        return Err(ElsError::Singular);
    }
    let k = T::ONE / c;
    Ok(StaticStiffness {
        n_per_m: k,
        sd_n_per_m: k * (u / c),
        compliance_m_per_n: c,
        compliance_sd_m_per_n: u,
        lines,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compliance(f: f64) -> Complex<f64> {
        [(980.0, 0.02, 11.8e6), (1750.0, 0.04, 30e6)].iter().fold(
            Complex::ZERO,
            |sum, &(f0, z, k)| {
                let r = f / f0;
                sum + Complex::new(1.0 - r * r, 2.0 * z * r).scale(k).inverse()
            },
        )
    }

    #[test]
    fn limit_and_coverage() {
        let f: Vec<f64> = (40..=320).map(f64::from).collect();
        let want = 1.0 / (1.0 / 11.8e6 + 1.0 / 30e6);
        let clean: Vec<_> = f.iter().map(|&f| compliance(f)).collect();
        let k = static_stiffness(&f, &clean, 0.0, 330.0).expect("lines");
        assert!((k.n_per_m / want - 1.0).abs() < 1e-3, "{k:?}");
        // 2 % noise a line: the truth within two deviations 95 times in 100.
        let mut seed = 1u32;
        let mut noise = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += f64::from(seed >> 8) / 16_777_216.0;
            }
            sum
        };
        let mut held = 0;
        for _ in 0..400 {
            let noisy: Vec<_> = clean
                .iter()
                .map(|g| *g + Complex::new(0.02 * 1.2e-7 * noise(), 0.0))
                .collect();
            let k = static_stiffness(&f, &noisy, 0.0, 330.0).expect("lines");
            held += u32::from((k.n_per_m - want).abs() < 2.0 * k.sd_n_per_m);
        }
        assert!((368..=394).contains(&held), "{held} of 400");
    }

    #[test]
    fn refusals() {
        let f = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let g = [Complex::new(-1e-8f32, 0.0); 6];
        let of = |low, high| static_stiffness(&f, &g, low, high);
        assert_eq!(of(2.0, 9.0), Err(ElsError::TooFewLines { needed: 6 }));
        assert_eq!(of(0.0, 9.0), Err(ElsError::Singular));
        let back = [1.0f32, 2.0, 2.0, 4.0, 5.0, 6.0];
        assert_eq!(
            static_stiffness(&back, &g, 0.0, 9.0),
            Err(ElsError::Grid { index: 2 })
        );
    }
}
