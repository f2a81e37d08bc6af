//! Reversal spikes: what the least-squares fit cannot hold.

use super::error_fit::ErrorFit;
use super::terms::Sense;
use super::trace::Trace;
use rarma_core::real::Real;

/// A spike after a reversal.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spike<T> {
    /// Height above what is left elsewhere near by, m, with its sign.
    pub height_m: T,
    /// Degrees after the reversal at which it is highest.
    pub after_deg: T,
}

/// Width after a reversal that is searched, and beyond which the rest is the base, degrees.
const WINDOW_DEG: f64 = 5.0;
const BASE_DEG: f64 = 12.0;

/// Spikes after the reversals at 0°, 90°, 180° and 270°, in this order: X turns round at the
/// first and the third, Y at the others. The fit is taken off first; the height is the largest
/// rest within 5° after the reversal, less the mean of the rest from 5° to 12°.
///
/// A spike is smeared by the bins: use 1° or finer.
pub fn spikes<T: Real, const BINS: usize>(
    trace: &Trace<T, BINS>,
    fit: &ErrorFit<T>,
    sense: Sense,
) -> [Spike<T>; 4] {
    let full = T::from_f64(360.0);
    let degree = T::PI / T::from_f64(180.0);
    core::array::from_fn(|k| {
        let reversal = T::from_u32(90 * k as u32);
        let after = |theta: T| {
            let mut d = sense.sign::<T>() * (theta / degree - reversal);
            while d < T::ZERO {
                d += full;
            }
            while d >= full {
                d -= full;
            }
            d
        };
        let rest = |theta: T, dr: T| dr - fit.predicted(theta, sense);
        let (mut sum, mut n) = (T::ZERO, 0u32);
        for (theta, dr) in trace.points() {
            let d = after(theta);
            if d > T::from_f64(WINDOW_DEG) && d <= T::from_f64(BASE_DEG) {
                sum += rest(theta, dr);
                n += 1;
            }
        }
        if n == 0 {
            return Spike::default();
        }
        let base = sum / T::from_u32(n);
        let mut out: Spike<T> = Spike::default();
        for (theta, dr) in trace.points() {
            let d = after(theta);
            if d <= T::from_f64(WINDOW_DEG) {
                let height = rest(theta, dr) - base;
                if height.abs() > out.height_m.abs() {
                    out = Spike {
                        height_m: height,
                        after_deg: d,
                    };
                }
            }
        }
        out
    })
}
