//! How far two measured cross receptances disagree.

use super::complex::Complex;
use super::error::ElsError;
use super::receptance::Receptance;
use rarma_core::real::Real;

/// Distance of the cross receptances from reciprocity, over a band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reciprocity<T> {
    /// √(Σ|Guv − Gvu|²) / √(Σ(|Guv| + |Gvu|)²): 0 for a reciprocal structure, 1 where one
    /// is missing or they have opposite signs (a sensor turned round).
    pub distance: T,
    /// Line with the largest |Guv − Gvu|, from 0.
    pub worst_line: usize,
    /// |Guv − Gvu| there over the largest cross receptance of the band, 1.
    pub worst: T,
}

/// Compares Guv with Gvu over all lines.
///
/// A linear structure at rest has Guv = Gvu (Maxwell). A turning spindle with gyroscopic
/// moments has not, nor has a calibration that differs between the directions: then
/// take the receptances as measured.
///
/// Without any cross receptance the distance is 0.
///
/// # Errors
/// `TooFewLines` without a line; `NotFinite`.
pub fn reciprocity<T: Real>(lines: &[Receptance<T>]) -> Result<Reciprocity<T>, ElsError> {
    if lines.is_empty() {
        return Err(ElsError::TooFewLines { needed: 1 });
    }
    let mut largest = T::ZERO;
    for (index, g) in lines.iter().enumerate() {
        if !g.is_finite() {
            return Err(ElsError::NotFinite { index });
        }
        largest = largest.max(g.resp_u_exc_v.abs()).max(g.resp_v_exc_u.abs());
    }
    let mut out = Reciprocity {
        distance: T::ZERO,
        worst_line: 0,
        worst: T::ZERO,
    };
    if !(largest > T::ZERO) {
        return Ok(out);
    }
    // In units of the largest, so that squares stay within `f32`.
    let size = |z: Complex<T>| z.abs() / largest;
    let (mut apart, mut both) = (T::ZERO, T::ZERO);
    for (index, g) in lines.iter().enumerate() {
        let d = size(g.resp_u_exc_v - g.resp_v_exc_u);
        let s = size(g.resp_u_exc_v) + size(g.resp_v_exc_u);
        apart += d * d;
        both += s * s;
        if d > out.worst {
            (out.worst, out.worst_line) = (d, index);
        }
    }
    out.distance = (apart / both).sqrt();
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(scale: f64) -> [Receptance<f64>; 3] {
        core::array::from_fn(|k| {
            let g = Complex::new(1e-8, -2e-9 * k as f64);
            Receptance {
                resp_u_exc_v: g,
                resp_v_exc_u: g.scale(scale),
                ..Receptance::default()
            }
        })
    }

    #[test]
    fn reciprocal_missing_and_turned_round() {
        let distance = |scale| reciprocity(&lines(scale)).expect("lines").distance;
        assert_eq!(distance(1.0), 0.0);
        assert!((distance(0.0) - 1.0).abs() < 1e-12);
        assert!((distance(-1.0) - 1.0).abs() < 1e-12);
        assert!((distance(0.9) - 0.1 / 1.9).abs() < 1e-12);
    }

    #[test]
    fn refusals() {
        assert_eq!(
            reciprocity::<f64>(&[]),
            Err(ElsError::TooFewLines { needed: 1 })
        );
        let mut bad = lines(1.0);
        bad[2].resp_u_exc_u.im = f64::NAN;
        assert_eq!(reciprocity(&bad), Err(ElsError::NotFinite { index: 2 }));
        let none = [Receptance::<f32>::default(); 2];
        assert_eq!(reciprocity(&none).expect("lines").distance, 0.0);
    }
}
