//! Phase and speed of the rotation from phase errors: a Kalman filter of two states.
//!
//! Rate: once a block of samples. Phase errors come with their variance, so that the
//! loop is wide where the lines stand far above the rest and narrow where they do not.

use crate::real::Real;
use crate::visit::state;

/// Innovations this many times their own variance, on the mean, and the speed is taken
/// to change.
const RESTLESS: f64 = 2.5;
/// Memory of that mean, blocks.
const MEMORY: f64 = 8.0;
/// The wander grows by this factor a block while the speed changes, and shrinks by
/// the other one when it does not.
const GROWTH: f64 = 2.0;
const DECAY: f64 = 0.97;
/// Range of the wander over the one that was asked for.
const LEAST_WANDER: f64 = 0.1;

/// Phase φ (rad, its error only: the phase itself is the caller's) and speed ω, rad per
/// block.
///
/// ```text
/// φ ← φ + ω,  ω ← ω + w,   w of variance (q·ω)² per block
/// z = error of φ + v,      v of variance R, told with every z
/// ```
///
/// q adapts between 0.1 and 1 times what was asked for, by the size of the
/// innovations: a steady spindle is averaged for long, a ramp is followed.
#[derive(Debug, Clone, Copy)]
pub(super) struct PhaseLoop<T> {
    pub omega: T,
    /// Variances of φ and ω, and their covariance.
    pub p: (T, T, T),
    wander: T,
    most_wander: T,
    restless: T,
}

state! { PhaseLoop<T> { omega, p, wander, most_wander, restless } }

impl<T: Real> PhaseLoop<T> {
    /// A speed with its standard deviation, rad per block; the wander is the relative
    /// change of the speed in a block, at the most.
    pub fn new(omega: T, sd: T, most_wander: T) -> Self {
        Self {
            omega,
            p: (T::ZERO, T::ZERO, sd * sd),
            wander: most_wander,
            most_wander,
            restless: T::ONE,
        }
    }

    /// A block has passed.
    pub fn predict(&mut self) {
        let q = self.wander * self.omega;
        let q = q * q;
        let (a, b, c) = self.p;
        let third = T::from_f64(1.0 / 3.0);
        let half = T::from_f64(0.5);
        self.p = (a + b + b + c + q * third, b + c + q * half, c + q);
    }

    /// Takes the phase error `z` of variance `r`, rad and rad²; gives by how much the
    /// phase is to be put forward.
    pub fn correct(&mut self, z: T, r: T) -> T {
        let (a, b, c) = self.p;
        let s = a + r;
        if !(s > T::ZERO) || !z.is_finite() || !s.is_finite() {
            return T::ZERO;
        }
        let (k, l) = (a / s, b / s);
        self.omega += l * z;
        self.p = (a - k * a, b - k * b, c - l * b);
        let gain = T::from_f64(1.0 / MEMORY);
        self.restless += gain * ((z * z / s).min(T::from_f64(20.0)) - self.restless);
        let factor = if self.restless > T::from_f64(RESTLESS) {
            GROWTH
        } else {
            DECAY
        };
        self.wander = (self.wander * T::from_f64(factor)).clamp(
            self.most_wander * T::from_f64(LEAST_WANDER),
            self.most_wander,
        );
        k * z
    }

    /// Takes a speed that something else has measured, with its standard deviation,
    /// rad per block.
    pub fn measure(&mut self, omega: T, sd: T) {
        let (a, b, c) = self.p;
        let s = c + sd * sd;
        let off = omega - self.omega;
        if !(s > T::ZERO) || !off.is_finite() || !s.is_finite() {
            return;
        }
        let (k, l) = (b / s, c / s);
        self.omega += l * off;
        self.p = (a - k * b, b - k * c, c - l * c);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_a_ramp_and_settles_on_a_steady_speed() {
        let mut seed = 3u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (f64::from(seed >> 8) / 8_388_608.0 - 1.0) * 3f64.sqrt()
        };
        // 50 Hz in blocks of 1/375 s; phase noise of 0.005 rad.
        let start = core::f64::consts::TAU * 50.0 / 375.0;
        let mut wanted = start;
        let mut follows = PhaseLoop::new(start * 1.001, start * 0.001, 1e-4);
        let mut off = 0.0;
        let mut worst = 0.0f64;
        for n in 0..1500 {
            off += wanted - follows.omega;
            follows.predict();
            if (500..875).contains(&n) {
                wanted += start * 0.1 / 375.0;
            }
            off -= follows.correct(off + 0.005 * noise(), 2.5e-5);
            if n == 499 || n == 1499 {
                let error = (follows.omega - wanted).abs();
                let sd = follows.p.2.sqrt();
                assert!(error < 3.0 * sd && sd < 2e-3 * start, "{error} {sd}");
            }
            if n > 600 && n < 875 {
                worst = worst.max(off.abs());
            }
        }
        assert!((0.005..0.1).contains(&worst), "{worst}");
        assert!((wanted / start - 1.1).abs() < 1e-9);
    }

    #[test]
    fn a_measured_speed_counts_by_its_error() {
        let mut both = PhaseLoop::new(1.0, 0.01, 0.0);
        both.measure(1.02, 0.01);
        assert!((both.omega - 1.01f64).abs() < 1e-12);
        assert!((both.p.2 - 0.5e-4).abs() < 1e-12);
        both.measure(f64::NAN, 0.01);
        assert!(both.omega.is_finite());
        assert_eq!(both.correct(f64::NAN, 1.0), 0.0);
    }
}
