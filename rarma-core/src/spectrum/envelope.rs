//! The squared envelope of a mode, wide enough to keep its fluctuations.
//!
//! Rate: `process` once a decimated sample (one complex rotation, no trigonometry);
//! `steer` and `squared` at the decision rate. A [`LockIn`] with its own time constant
//! reads how loud a mode is; here the width follows the mode, because a filter
//! narrower than the mode makes its own, slower, fluctuations out of any noise.

use super::lockin::LockIn;
use crate::real::Real;
use crate::visit::state;

/// Half-width of the band (−3 dB) in half-widths ζf of the mode.
pub const ENVELOPE_WIDTHS: f64 = 3.0;
/// Least half-width, Hz: the frequency of a mode without damping is not known better
/// while a spindle's speed wanders.
pub const ENVELOPE_FLOOR_HZ: f64 = 15.0;
/// Largest half-width as a part of the frequency: beyond it the image at 2f leaks in.
/// At 0.3 it is 7 % in amplitude (f = fs/6) and adds 0.01 to the scintillation.
const WIDEST: f64 = 0.3;
/// Corner of each of two equal stages over their common −3 dB half-width:
/// 1/√(√2 − 1).
const STAGE: f64 = 1.553_773_974;
/// Part of a change of the mode that one `steer` takes over.
const STEERING: f64 = 1.0 / 16.0;

/// Half-width of the band around a mode, Hz: max(3·ζ·f, 15 Hz), at most 0.3·f.
/// `f_hz` in Hz, ζ as a ratio; a ζ below 0 or NaN counts as 0.
pub fn envelope_half_width<T: Real>(f_hz: T, zeta: T) -> T {
    let modal = T::ZERO.max(zeta) * f_hz;
    T::from_f64(ENVELOPE_FLOOR_HZ)
        .max(T::from_f64(ENVELOPE_WIDTHS) * modal)
        .min(T::from_f64(WIDEST) * f_hz)
}

/// Corner of each of the two stages, rad/s, for the half-width above.
pub fn envelope_corner<T: Real>(f_hz: T, zeta: T) -> T {
    T::from_f64(2.0 * STAGE) * T::PI * envelope_half_width(f_hz, zeta)
}

/// Follows V = A² of the component x = A·sin(ωt + φ) near a mode's frequency (eq. 24
/// of the thesis): quadrature mixer and two low-pass stages.
///
/// ```text
/// w ← w + g(y·e^(jωt) − w),  z ← z + g(w − z),  V = 4|z|²,  g = 1 − e^(−β/fs)
/// β = 2π·1.55·max(3ζf, 15 Hz)
/// ```
///
/// The mode's own half-width is ζf, so the band is three times as wide as the mode.
/// Frequency and width follow the mode by a sixteenth of the difference a call; a mode
/// that has jumped out of the band is followed at once.
///
/// Lines in the band (tooth passing) must have been removed before.
///
/// ```
/// use rarma_core::spectrum::Envelope;
/// let mut envelope = Envelope::<f32>::new(6000.0);
/// for n in 0..6000 {
///     if n % 12 == 0 {
///         envelope.steer(900.0, 0.02);
///     }
///     envelope.process(0.5 * (0.3 * core::f32::consts::PI * n as f32).sin());
/// }
/// assert!((envelope.squared() - 0.25).abs() < 0.01);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Envelope<T> {
    lockin: LockIn<T>,
    fs_hz: T,
    f_hz: T,
    zeta: T,
    gain: T,
}

state! { Envelope<T> {
    lockin, f_hz, zeta, gain;
    settings fs_hz
} }

impl<T: Real> Envelope<T> {
    /// At rest, for samples at `fs_hz` (> 0); deaf until it is steered.
    pub fn new(fs_hz: f64) -> Self {
        Self {
            lockin: LockIn::default(),
            fs_hz: T::from_f64(fs_hz),
            f_hz: T::ZERO,
            zeta: T::ZERO,
            gain: T::ZERO,
        }
    }

    /// Follows a mode: frequency, Hz, and damping ratio. A frequency outside
    /// 0 < f < fs/2 changes nothing; a ζ that is not finite counts as before.
    pub fn steer(&mut self, f_hz: T, zeta: T) {
        if !(f_hz > T::ZERO && f_hz < self.fs_hz * T::from_f64(0.5)) {
            return;
        }
        let zeta = if zeta.is_finite() {
            zeta.clamp(T::ZERO, T::ONE)
        } else {
            self.zeta
        };
        let off = f_hz - self.f_hz;
        let jump = off.abs() > envelope_half_width(self.f_hz, self.zeta);
        let part = if jump { T::ONE } else { T::from_f64(STEERING) };
        self.f_hz += part * off;
        self.zeta += part * (zeta - self.zeta);
        self.gain = T::ONE - (-envelope_corner(self.f_hz, self.zeta) / self.fs_hz).exp();
        self.lockin
            .steer(T::from_f64(2.0) * T::PI * self.f_hz / self.fs_hz);
    }

    /// Takes one sample; one that is not finite is left out.
    #[inline(always)]
    pub fn process(&mut self, y: T) {
        if y.abs() < T::from_f64(1e15) {
            self.lockin.process(y, self.gain);
        }
    }

    /// V, the squared amplitude, input units squared.
    pub fn squared(&self) -> T {
        T::from_f64(2.0) * self.lockin.power()
    }

    /// Frequency followed, Hz; 0 before the first `steer`.
    pub fn frequency(&self) -> T {
        self.f_hz
    }

    /// Forgets signal and mode.
    pub fn reset(&mut self) {
        *self = Self {
            fs_hz: self.fs_hz,
            ..Self::new(0.0)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// Mean amplitude of a unit tone `off_hz` beside 980 Hz.
    fn heard(zeta: f64, off_hz: f64) -> f64 {
        let fs = 6000.0;
        let mut envelope = Envelope::<f64>::new(fs);
        let mut sum = 0.0;
        for n in 0..24_000 {
            if n % 12 == 0 {
                envelope.steer(980.0, zeta);
            }
            envelope.process((2.0 * PI * (980.0 + off_hz) * f64::from(n) / fs).sin());
            if n >= 12_000 {
                sum += envelope.squared() / 12_000.0;
            }
        }
        sum.sqrt()
    }

    #[test]
    fn width_follows_the_mode_down_to_the_floor() {
        let half = 0.5f64.sqrt();
        for (zeta, width) in [
            (0.0, 15.0),
            (0.002, 15.0),
            (0.02, 58.8),
            (0.05, 147.0),
            (0.2, 294.0),
        ] {
            assert!((envelope_half_width(980.0, zeta) - width).abs() < 1e-9);
            assert!((heard(zeta, 0.0) - 1.0).abs() < 0.02, "{zeta}");
            let corner = heard(zeta, width);
            // The sampled stages and the image shift the corner of a wide band.
            assert!((corner - half).abs() < 0.05, "{zeta}: {corner}");
            // −12 dB an octave, far out: (1 + 16·(√2 − 1))⁻¹ at four half-widths.
            if zeta < 0.03 {
                let far = heard(zeta, 4.0 * width);
                assert!((far - 0.131).abs() < 0.02, "{zeta}: {far}");
            }
        }
    }

    #[test]
    fn follows_slowly_jumps_far_and_takes_no_rubbish() {
        let mut envelope = Envelope::<f32>::new(6000.0);
        envelope.process(1.0);
        assert_eq!(envelope.squared(), 0.0);
        envelope.steer(980.0, 0.02);
        assert_eq!(envelope.frequency(), 980.0);
        envelope.steer(996.0, 0.02);
        assert!((envelope.frequency() - 981.0).abs() < 1e-3);
        envelope.steer(500.0, 0.02);
        assert_eq!(envelope.frequency(), 500.0);
        for f in [f32::NAN, -1.0, 0.0, 3000.0, f32::INFINITY] {
            envelope.steer(f, f32::NAN);
        }
        assert_eq!(envelope.frequency(), 500.0);
        for (y, zeta) in [(f32::NAN, f32::NAN), (f32::INFINITY, -9.0), (1e30, 1e30)] {
            envelope.steer(500.0, zeta);
            envelope.process(y);
            assert!(envelope.squared().is_finite());
        }
        envelope.reset();
        assert!(envelope.frequency() == 0.0 && envelope.squared() == 0.0);
    }
}
