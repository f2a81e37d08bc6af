//! The limiting width of cut all round.

use super::error::ElsError;
use super::limit::{CutConfig, Limit, LimitSearch};
use super::receptance::Receptance;
use rarma_core::real::Real;

/// One direction of the polar diagram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PolarPoint<T> {
    /// Direction of the cutting force, rad from u towards v.
    pub angle: T,
    /// Limit there.
    pub limit: Limit<T>,
}

impl<T: Real> Default for PolarPoint<T> {
    fn default() -> Self {
        Self {
            angle: T::ZERO,
            limit: Limit::Unlimited,
        }
    }
}

/// Limits with the force turned about the tool, at `out.len()` angles evenly over a whole
/// turn from 0.
///
/// `chip_angle` rad is where the chip thickness is measured, seen from the force: e
/// stands at α + `chip_angle` (the thesis' θ). Signs count: e points out of the
/// workpiece, p is the force *on the tool*, so a force that pushes the tool away has
/// p·e > 0. Turning both by half a turn changes nothing, the diagram has period π.
///
/// Frequencies in Hz, rising; any spacing. O(lines × angles).
///
/// # Errors
/// `DifferentLengths`, `TooFewLines`, `Grid`, `NotFinite`, or as
/// [`CutConfig::validate`]; `OutOfRange` for a chip angle that is not finite.
pub fn polar_limits<T: Real>(
    f: &[T],
    lines: &[Receptance<T>],
    cut: CutConfig<T>,
    chip_angle: T,
    out: &mut [PolarPoint<T>],
) -> Result<(), ElsError> {
    check(f, lines)?;
    let empty = LimitSearch::new(cut)?;
    if !chip_angle.is_finite() {
        return Err(ElsError::OutOfRange { name: "chip_angle" });
    }
    let largest = lines.iter().fold(T::ZERO, |m, g| m.max(g.largest()));
    let nothing = cut.width_m(T::from_f64(16.0) * T::EPSILON * largest);
    let turn = T::from_f64(2.0) * T::PI;
    let count = T::from_u32(u32::try_from(out.len()).unwrap_or(u32::MAX));
    for (k, point) in out.iter_mut().enumerate() {
        let angle = turn * T::from_u32(u32::try_from(k).unwrap_or(u32::MAX)) / count;
        let (s, c) = angle.sin_cos();
        let (t, d) = (angle + chip_angle).sin_cos();
        let mut search = empty;
        for (&f, g) in f.iter().zip(lines) {
            search.line(f, g.between((c, s), (d, t)));
        }
        // A direction that stands across all motion has the rounding of the angles left.
        let limit = match search.finish() {
            Limit::Width { width_m, .. } if !(width_m < nothing) => Limit::Unlimited,
            other => other,
        };
        *point = PolarPoint { angle, limit };
    }
    Ok(())
}

/// Lines that can be used: as many of both, at least three, rising, finite.
pub(super) fn check<T: Real>(f: &[T], lines: &[Receptance<T>]) -> Result<(), ElsError> {
    if f.len() != lines.len() {
        return Err(ElsError::DifferentLengths);
    }
    rising(f, 3)?;
    match lines.iter().position(|g| !g.is_finite()) {
        Some(index) => Err(ElsError::NotFinite { index }),
        None => Ok(()),
    }
}

/// At least `needed` frequencies, finite, not negative, each above the last.
pub(super) fn rising<T: Real>(f: &[T], needed: usize) -> Result<(), ElsError> {
    if f.len() < needed {
        return Err(ElsError::TooFewLines { needed });
    }
    let mut before: Option<T> = None;
    for (index, &x) in f.iter().enumerate() {
        if !x.is_finite() {
            return Err(ElsError::NotFinite { index });
        }
        if !(x >= T::ZERO) || before.is_some_and(|b| !(x > b)) {
            return Err(ElsError::Grid { index });
        }
        before = Some(x);
    }
    Ok(())
}

/// The best and the worst direction of a diagram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes<T> {
    /// Largest limit; unlimited if any direction is.
    pub best: PolarPoint<T>,
    /// Smallest limit.
    pub worst: PolarPoint<T>,
}

/// The best and the worst direction; none for an empty diagram.
pub fn extremes<T: Real>(points: &[PolarPoint<T>]) -> Option<Extremes<T>> {
    let first = *points.first()?;
    let mut out = Extremes {
        best: first,
        worst: first,
    };
    for p in points {
        if p.limit.width_m() > out.best.limit.width_m() {
            out.best = *p;
        }
        if p.limit.width_m() < out.worst.limit.width_m() {
            out.worst = *p;
        }
    }
    Some(out)
}
