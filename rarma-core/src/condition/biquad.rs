//! Second-order sections: Butterworth high- and low-pass of any even order.
//!
//! Rate: once a (decimated) sample. Transposed direct form II:
//! y = b₀x + s₁, s₁ ← b₁x − a₁y + s₂, s₂ ← b₂x − a₂y, with 1 + a₁q⁻¹ + a₂q⁻²
//! in the denominator (plus signs, as everywhere here).

use crate::real::Real;
use crate::visit::state;

/// Coefficients of one section.
#[derive(Debug, Clone, Copy)]
pub struct Biquad<T> {
    b: [T; 3],
    a: [T; 2],
}

/// Memory of one section.
#[derive(Debug, Clone, Copy, Default)]
pub struct BiquadState<T> {
    s1: T,
    s2: T,
}

state! { BiquadState<T> { s1, s2 } }

/// Which side of the corner passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// Below the corner.
    Low,
    /// Above the corner.
    High,
}

/// Zeros of a high-pass section, as a fraction of its corner.
pub const ZERO_FRACTION: f64 = 1.0 / 6.0;

impl<T: Real> Biquad<T> {
    /// Passes nothing.
    pub(super) const BLANK: Self = Self {
        b: [T::ZERO; 3],
        a: [T::ZERO; 2],
    };

    /// Section `k` of a Butterworth filter of `sections` sections (order twice
    /// that), corner `fc` (−3 dB) at rate `fs`, by the bilinear transform with the
    /// corner prewarped. Requires 0 < fc < fs/2.
    ///
    /// The zeros of a high-pass lie at [`ZERO_FRACTION`] of its corner instead of at
    /// zero frequency: it falls as usual down to there and then stays 31 dB down a
    /// section. Zeros on the unit circle would have to be modelled by C(q), which
    /// must keep inside it.
    pub fn butterworth(pass: Pass, fc: f64, fs: f64, k: usize, sections: usize) -> Self {
        let pi = core::f64::consts::PI;
        // Pole pair k of the analogue prototype: 1/Q = 2 cos of its angle.
        let angle = pi * (2 * k + 1) as f64 / (4 * sections) as f64;
        let inverse_q = 2.0 * libm::cos(angle);
        let w = libm::tan(pi * fc / fs);
        let norm = 1.0 / (1.0 + w * inverse_q + w * w);
        let b = match pass {
            Pass::Low => [w * w * norm, 2.0 * w * w * norm, w * w * norm],
            Pass::High => {
                let zero = libm::exp(-2.0 * pi * fc * ZERO_FRACTION / fs);
                let gain = 4.0 * norm / ((1.0 + zero) * (1.0 + zero));
                [gain, -2.0 * zero * gain, zero * zero * gain]
            }
        };
        Self {
            b: b.map(T::from_f64),
            a: [
                T::from_f64(2.0 * (w * w - 1.0) * norm),
                T::from_f64((1.0 - w * inverse_q + w * w) * norm),
            ],
        }
    }

    /// |H|² at `angle` rad a sample. Slow path.
    pub(super) fn power_gain(&self, angle: f64) -> f64 {
        let squared = |x: [f64; 3]| {
            let (one, two) = (libm::cos(angle), libm::cos(2.0 * angle));
            let (a, b) = (libm::sin(angle), libm::sin(2.0 * angle));
            let (re, im) = (x[0] + x[1] * one + x[2] * two, x[1] * a + x[2] * b);
            re * re + im * im
        };
        squared(self.b.map(T::to_f64)) / squared([1.0, self.a[0].to_f64(), self.a[1].to_f64()])
    }

    /// One sample through the section.
    #[inline(always)]
    pub fn process(&self, state: &mut BiquadState<T>, x: T) -> T {
        let y = self.b[0] * x + state.s1;
        state.s1 = self.b[1] * x - self.a[0] * y + state.s2;
        state.s2 = self.b[2] * x - self.a[1] * y;
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(pass: Pass, fc: f64, f: f64) -> f64 {
        let fs = 6000.0;
        let mut state = [BiquadState::<f64>::default(); 2];
        let sections: [Biquad<f64>; 2] =
            core::array::from_fn(|k| Biquad::butterworth(pass, fc, fs, k, 2));
        let (mut re, mut im) = (0.0, 0.0);
        for n in 0..24_000 {
            let phase = 2.0 * core::f64::consts::PI * f * n as f64 / fs;
            let mut y = phase.cos();
            for (c, s) in sections.iter().zip(&mut state) {
                y = c.process(s, y);
            }
            if n >= 12_000 {
                re += y * phase.cos() / 6000.0;
                im += y * phase.sin() / 6000.0;
            }
        }
        (re * re + im * im).sqrt()
    }

    #[test]
    fn corner_and_slope_are_those_of_butterworth() {
        let half = 0.5f64.sqrt();
        assert!((gain(Pass::Low, 300.0, 300.0) - half).abs() < 1e-3);
        // The zeros at 50 Hz lift the corner by 1 + 1/36 for each of two sections.
        let lift = |f: f64| (1.0 + (50.0 / f).powi(2)).powi(2);
        assert!((gain(Pass::High, 300.0, 300.0) / lift(300.0) - half).abs() < 0.02);
        // Fourth order falls by 24 dB an octave: 1/16.03 an octave out.
        assert!((gain(Pass::High, 300.0, 150.0) / lift(150.0) - 0.0618).abs() < 0.003);
        assert!((4e-4..1.2e-3).contains(&gain(Pass::High, 300.0, 1.0)));
        assert!(gain(Pass::High, 300.0, 1500.0) > 0.995);
        assert!(gain(Pass::Low, 300.0, 30.0) > 0.995);
    }
}
