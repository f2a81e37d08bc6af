//! How loud is the signal at one frequency: a lock-in that follows a mode.
//!
//! Rate: `process` once a decimated sample (one complex rotation, no
//! trigonometry); `steer` at the decision rate.

use crate::real::Real;
use crate::visit::state;

/// Time constant of each of the two smoothing stages, s. Together they pass
/// about ±16 Hz around the frequency.
pub const LOCKIN_TAU_S: f64 = 0.008;

/// Follows the component of a signal near one frequency.
///
/// ```text
/// r ← r·e^(jω),  w ← w + g(y·r − w),  z ← z + g(w − z),  amplitude = 2|z|
/// ```
#[derive(Debug, Clone, Copy)]
pub struct LockIn<T> {
    rotor: (T, T),
    turn: (T, T),
    first: (T, T),
    second: (T, T),
    before: (T, T),
}

state! { LockIn<T> { rotor, turn, first, second, before } }

impl<T: Real> Default for LockIn<T> {
    fn default() -> Self {
        Self {
            rotor: (T::ONE, T::ZERO),
            turn: (T::ONE, T::ZERO),
            first: (T::ZERO, T::ZERO),
            second: (T::ZERO, T::ZERO),
            before: (T::ZERO, T::ZERO),
        }
    }
}

impl<T: Real> LockIn<T> {
    /// Sets the frequency as an angle per sample, rad, and puts the rotor back on
    /// the unit circle.
    pub fn steer(&mut self, angle: T) {
        let (s, c) = angle.sin_cos();
        self.turn = (c, s);
        let (x, y) = self.rotor;
        let correction = T::from_f64(1.5) - T::from_f64(0.5) * (x * x + y * y);
        self.rotor = (x * correction, y * correction);
    }

    /// Takes one sample; `gain` is 1/([`LOCKIN_TAU_S`]·rate).
    #[inline(always)]
    pub fn process(&mut self, y: T, gain: T) {
        let (x0, y0) = self.rotor;
        self.rotor = (
            x0 * self.turn.0 - y0 * self.turn.1,
            x0 * self.turn.1 + y0 * self.turn.0,
        );
        self.first.0 += gain * (y * self.rotor.0 - self.first.0);
        self.first.1 += gain * (y * self.rotor.1 - self.first.1);
        self.second.0 += gain * (self.first.0 - self.second.0);
        self.second.1 += gain * (self.first.1 - self.second.1);
    }

    /// Mean square of the component, input units squared: amplitude²/2.
    pub fn power(&self) -> T {
        let (re, im) = self.second;
        T::from_f64(2.0) * (re * re + im * im)
    }

    /// By how much the phase of the component has fallen behind the rotor since the last
    /// call, rad: (ω − ω_signal)·time, within ±π; 0 where there is nothing.
    pub fn slipped(&mut self) -> T {
        let (re, im) = self.second;
        let (x, y) = self.before;
        self.before = self.second;
        (im * x - re * y).atan2(re * x + im * y)
    }

    /// Peak amplitude of the component, input units.
    pub fn amplitude(&self) -> T {
        (T::from_f64(2.0) * self.power()).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_amplitude_of_a_tone_and_little_beside_it() {
        let fs = 6000.0f32;
        let gain = 1.0 / (LOCKIN_TAU_S as f32 * fs);
        for (offset, low, high) in [(0.0, 0.78, 0.82), (60.0, 0.0, 0.1)] {
            let mut lockin = LockIn::<f32>::default();
            for n in 0..60_000 {
                if n % 12 == 0 {
                    lockin.steer(2.0 * core::f32::consts::PI * 900.0 / fs);
                }
                let phase = 2.0 * core::f64::consts::PI * (900.0 + offset) / 6000.0;
                lockin.process(0.8 * (phase * f64::from(n)).sin() as f32, gain);
            }
            let a = lockin.amplitude();
            assert!((low..high).contains(&a), "amplitude {a} at {offset} Hz off");
        }
    }
}
