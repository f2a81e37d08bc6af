//! Hysteresis of one load cycle in one direction.

use super::error::LdbbError;
use rarma_core::real::Real;

/// What a cycle up and down leaves, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadCycle<T> {
    /// Largest unloading less loading deflection at one force.
    pub most_m: T,
    /// The force of it, N.
    pub most_at_n: T,
    /// Unloading less loading deflection at the smallest force: what stays.
    pub left_m: T,
    /// Work lost in the cycle, J: the loop's area.
    pub lost_j: T,
}

impl<T: Real> LoadCycle<T> {
    /// From pairs of force (N) and Δr (m), `up` in rising and `down` in falling order. The
    /// loading curve is interpolated at the forces of unloading, which need not be the
    /// same: a pressure is set anew each time.
    ///
    /// # Errors
    /// `TooFew` with fewer than two pairs a way; `NotFinite`; `EqualForces` where the
    /// forces of `up` do not rise.
    pub fn new(up: &[(T, T)], down: &[(T, T)]) -> Result<Self, LdbbError> {
        let (Some(first), true) = (down.first(), up.len() >= 2 && down.len() >= 2) else {
            return Err(LdbbError::TooFew { needed: 2 });
        };
        for (index, (f, r)) in up.iter().chain(down).enumerate() {
            if !(f.is_finite() && r.is_finite()) {
                return Err(LdbbError::NotFinite { index });
            }
        }
        if up.iter().zip(up.iter().skip(1)).any(|(a, b)| !(b.0 > a.0)) {
            return Err(LdbbError::EqualForces);
        }
        let apart = |(f, r): (T, T)| r - interpolated(up, f);
        let mut out = Self {
            most_m: T::ZERO,
            most_at_n: first.0,
            left_m: T::ZERO,
            lost_j: T::ZERO,
        };
        let mut least = None;
        for &pair in down {
            let d = apart(pair);
            if d.abs() > out.most_m.abs() {
                (out.most_m, out.most_at_n) = (d, pair.0);
            }
            if least.is_none_or(|f| pair.0 < f) {
                least = Some(pair.0);
                out.left_m = d;
            }
        }
        let half = T::from_f64(0.5);
        for (a, b) in down.iter().zip(down.iter().skip(1)) {
            out.lost_j += half * (apart(*a) + apart(*b)) * (a.0 - b.0);
        }
        Ok(out)
    }
}

/// The curve at a force; beyond its ends along its last piece.
fn interpolated<T: Real>(curve: &[(T, T)], force: T) -> T {
    let mut value = T::ZERO;
    let pieces = curve.iter().zip(curve.iter().skip(1));
    for (k, (&(f0, r0), &(f1, r1))) in pieces.enumerate() {
        if k > 0 && force < f0 {
            break;
        }
        value = r0 + (r1 - r0) * (force - f0) / (f1 - f0);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_of_known_width() {
        let up: Vec<(f64, f64)> = (0..8)
            .map(|k| (126.0 * f64::from(k), 1e-7 * 126.0 * f64::from(k)))
            .collect();
        // Widest in the middle, nothing at the top, 3 µm left; forces a little off.
        let down: Vec<(f64, f64)> = (0..8)
            .rev()
            .map(|k| {
                let f = 126.0 * f64::from(k) + 2.0;
                let gap = [3e-6, 4e-6, 5e-6, 5e-6, 4e-6, 3e-6, 2e-6, 0.0][k as usize];
                (f, 1e-7 * f + gap)
            })
            .collect();
        let c = LoadCycle::new(&up, &down).expect("cycle");
        assert!((c.most_m - 5e-6).abs() < 1e-12 && (c.left_m - 3e-6).abs() < 1e-12);
        assert!((c.most_at_n - 380.0).abs() < 1e-9 || (c.most_at_n - 254.0).abs() < 1e-9);
        let area = 126.0 * (26e-6 - 0.5 * 3e-6);
        assert!((c.lost_j - area).abs() < 1e-9, "{c:?}");
    }

    #[test]
    fn refusals() {
        let flat = [(100.0f32, 0.0), (100.0, 1e-6)];
        assert_eq!(LoadCycle::new(&flat, &flat), Err(LdbbError::EqualForces));
        assert!(LoadCycle::new(&flat[..1], &flat).is_err());
        let bad = [(100.0f32, 0.0), (200.0, f32::NAN)];
        assert_eq!(
            LoadCycle::new(&bad, &flat),
            Err(LdbbError::NotFinite { index: 1 })
        );
    }
}
