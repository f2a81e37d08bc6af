//! Circular deviation, radial deviation and hysteresis of measured circles.
//!
//! Named after ISO 230-4 and defined here from general knowledge of it; reports say which
//! centre was taken.

use super::error::LdbbError;
use super::trace::Trace;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Halvings of each coordinate in the search for the least zone; 1.6^48 is 10^10.
const STEPS: usize = 48;

/// How far a path, or two, are from a circle, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation<T> {
    /// Radial distance of the two concentric circles about the least-squares centre
    /// that hold everything: an upper bound of [`Self::least_zone_m`].
    pub least_squares_m: T,
    /// The same about the centre that makes it smallest (G, or G(b) for two paths).
    pub least_zone_m: T,
    /// Least-squares centre, m.
    pub centre_m: [T; 2],
    /// Least-squares radius less the nominal one, m (D for two paths); means something
    /// with a calibrated length only.
    pub radius_m: T,
    /// Largest and smallest Δr from the nominal radius about the least-squares centre, m
    /// (F); as above.
    pub radial_m: (T, T),
    /// Largest distance of the two paths at one angle, m (H); 0 for one path.
    pub hysteresis_m: T,
    /// Where, rad.
    pub hysteresis_at_rad: T,
}

/// One path.
///
/// # Errors
/// `TooFew` with fewer than 8 bins filled, `Singular`.
pub fn circular_deviation<T: Real, const BINS: usize>(
    path: &Trace<T, BINS>,
) -> Result<Deviation<T>, LdbbError> {
    bidirectional(path, path)
}

/// Two paths in opposite directions together.
///
/// # Errors
/// As [`circular_deviation`]; bins count that both have.
pub fn bidirectional<T: Real, const BINS: usize>(
    one: &Trace<T, BINS>,
    other: &Trace<T, BINS>,
) -> Result<Deviation<T>, LdbbError> {
    const NEEDED: usize = 8;
    let points = || {
        (0..BINS).filter_map(|k| {
            let (a, b) = (one.mean(k)?, other.mean(k)?);
            Some((Trace::<T, BINS>::angle(k), a, b))
        })
    };
    if points().count() < NEEDED {
        return Err(LdbbError::TooFew { needed: NEEDED });
    }
    let mut triangle = Triangle::<T, 3>::new(3);
    let mut hysteresis = (T::ZERO, T::ZERO);
    for (theta, a, b) in points() {
        let (s, c) = theta.sin_cos();
        let _ = triangle.add(&mut [T::ONE, c, s], a);
        let _ = triangle.add(&mut [T::ONE, c, s], b);
        let apart = (a - b).abs();
        if apart > hysteresis.0 {
            hysteresis = (apart, theta);
        }
    }
    let [radius_m, x, y] = triangle.solve().ok_or(LdbbError::Singular)?;
    let ends = |cx: T, cy: T| {
        let (mut low, mut high) = (None, None);
        for (theta, a, b) in points() {
            let (s, c) = theta.sin_cos();
            let shift = cx * c + cy * s;
            let (small, large) = (a.min(b) - shift, a.max(b) - shift);
            low = Some(low.map_or(small, |l: T| l.min(small)));
            high = Some(high.map_or(large, |h: T| h.max(large)));
        }
        (low.unwrap_or(T::ZERO), high.unwrap_or(T::ZERO))
    };
    let (low, high) = ends(x, y);
    let width = |cx: T, cy: T| {
        let (low, high) = ends(cx, cy);
        high - low
    };
    // The width is convex in the centre, so a search within a search ends at its least; the
    // best centre lies within the width of the least-squares one.
    let span = high - low;
    let least = narrowest(x, span, |cx| narrowest(y, span, |cy| width(cx, cy)));
    Ok(Deviation {
        least_squares_m: high - low,
        least_zone_m: least.min(high - low),
        centre_m: [x, y],
        radius_m,
        radial_m: (high, low),
        hysteresis_m: hysteresis.0,
        hysteresis_at_rad: hysteresis.1,
    })
}

/// Least value of a convex function within `span` of `middle`, by golden sections.
fn narrowest<T: Real>(middle: T, span: T, mut of: impl FnMut(T) -> T) -> T {
    let golden = T::from_f64(0.618_033_988_749_894_8);
    let (mut low, mut high) = (middle - span, middle + span);
    let mut left = high - golden * (high - low);
    let mut right = low + golden * (high - low);
    let (mut at_left, mut at_right) = (of(left), of(right));
    for _ in 0..STEPS {
        if at_left <= at_right {
            high = right;
            (right, at_right) = (left, at_left);
            left = high - golden * (high - low);
            at_left = of(left);
        } else {
            low = left;
            (left, at_left) = (right, at_right);
            right = low + golden * (high - low);
            at_right = of(right);
        }
    }
    at_left.min(at_right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(f: impl Fn(f64) -> f64) -> Trace<f64, 360> {
        let mut trace = Trace::default();
        for k in 0..360 {
            let theta = Trace::<f64, 360>::angle(k);
            assert!(trace.add(theta, f(theta)));
        }
        trace
    }

    #[test]
    fn an_ellipse_off_centre() {
        let d = circular_deviation(&path(|t| {
            2e-6 + 30e-6 * t.cos() - 12e-6 * t.sin() + 5e-6 * (2.0 * t).cos()
        }))
        .expect("whole circle");
        assert!((d.least_squares_m - 10e-6).abs() < 2e-8, "{d:?}");
        assert!((d.least_zone_m - 10e-6).abs() < 2e-8);
        assert!((d.centre_m[0] - 30e-6).abs() < 1e-12 && (d.radius_m - 2e-6).abs() < 1e-12);
        assert!((d.radial_m.0 - 7e-6).abs() < 2e-8 && (d.radial_m.1 + 3e-6).abs() < 2e-8);
        assert_eq!(d.hysteresis_m, 0.0);
    }

    /// A bump pulls the least-squares centre less far than the least zone wants.
    #[test]
    fn the_least_zone_is_smaller_and_two_paths_count_together() {
        let bump = |t: f64| 8e-6 * (-((t - 2.0) / 0.6).powi(2)).exp();
        let one = circular_deviation(&path(bump)).expect("circle");
        assert!(one.least_zone_m < 0.98 * one.least_squares_m, "{one:?}");
        assert!(one.least_zone_m > 4e-6 && one.least_zone_m < 8e-6);
        let two = bidirectional(&path(bump), &path(|t| bump(t) - 3e-6)).expect("circles");
        assert!((two.hysteresis_m - 3e-6).abs() < 1e-12);
        assert!(two.least_zone_m > one.least_zone_m + 2.9e-6);
    }

    #[test]
    fn refusals() {
        let mut few = Trace::<f32, 360>::default();
        for k in 0..7 {
            assert!(few.add(k as f32, 1e-6));
        }
        assert_eq!(
            circular_deviation(&few),
            Err(LdbbError::TooFew { needed: 8 })
        );
    }
}
