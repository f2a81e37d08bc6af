//! How much the power of a line fluctuates within the window.

use super::frame::{Frame, SEGMENTS};
use crate::real::{Real, times};
use crate::visit::state;

/// Segments of one look, and the weights of the outer and the inner ones: a Hann window in four
/// steps.
const LOOK: usize = 4;
const WEIGHTS: (f64, f64) = (0.146, 0.854);

/// S = Var V/E²V of a line's power V in thirteen looks of a quarter window: 1 for a mode
/// that noise rings and the window is long enough for, 0 for a line that stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steadiness<T> {
    sums: [(T, T); SEGMENTS],
    at: usize,
    /// e^(−jω) of one sample, and of the segments so far and of one.
    step: (T, T),
    turn: (T, T),
    segment: (T, T),
}

state! { Steadiness<T> {
    sums, at, step, turn, segment;
    where *at <= SEGMENTS
} }

impl<T: Real> Steadiness<T> {
    /// Of no line, until [`Self::begin`].
    pub(super) const BLANK: Self = Self {
        sums: [(T::ZERO, T::ZERO); SEGMENTS],
        at: 0,
        step: (T::ZERO, T::ZERO),
        turn: (T::ZERO, T::ZERO),
        segment: (T::ZERO, T::ZERO),
    };

    /// Begins with a line of so many radians a sample.
    pub(super) fn begin(&mut self, angle: T, frame: &Frame<T>) {
        let rotation = |angle: T| {
            let turns = (angle * T::from_f64(0.5 / core::f64::consts::PI)).round();
            let (s, c) = (angle - turns * T::from_f64(core::f64::consts::TAU)).sin_cos();
            (c, -s)
        };
        self.step = rotation(angle);
        self.segment = rotation(angle * T::from_u32((frame.window / SEGMENTS) as u32));
        self.turn = (T::ONE, T::ZERO);
        self.at = 0;
    }

    /// One segment; whether all are done. Its sum Σ xₙ·e^(−jωn) is e^(−jω(L−1))·(v − v'·e^(−jω))
    /// with v = x + 2cos ω·v' − v″ over its L samples (Goertzel).
    pub(super) fn work(&mut self, frame: &Frame<T>) -> bool {
        let length = frame.window / SEGMENTS;
        let (c, s) = self.step;
        let twice = c + c;
        let (mut v, mut before) = (T::ZERO, T::ZERO);
        for i in self.at * length..(self.at + 1) * length {
            (v, before) = (frame.sample(i) + twice * v - before, v);
        }
        // By one sample too far, in every segment: no power changes.
        self.turn = times(self.turn, self.segment);
        let sum = times((v - before * c, -before * s), self.turn);
        self.sums[self.at & (SEGMENTS - 1)] = sum;
        self.at += 1;
        self.at >= SEGMENTS
    }

    /// S.
    pub(super) fn value(&self) -> T {
        let mut powers = [T::ZERO; SEGMENTS - LOOK + 1];
        let mut mean = T::ZERO;
        let (outer, inner) = (T::from_f64(WEIGHTS.0), T::from_f64(WEIGHTS.1));
        for (power, look) in powers.iter_mut().zip(self.sums.windows(LOOK)) {
            let [a, b, c, d] = look else { continue };
            let re = outer * (a.0 + d.0) + inner * (b.0 + c.0);
            let im = outer * (a.1 + d.1) + inner * (b.1 + c.1);
            *power = re * re + im * im;
            mean += *power;
        }
        let n = T::from_u32(powers.len() as u32);
        mean /= n;
        if mean <= T::ZERO {
            return T::ZERO;
        }
        // Parts of the mean, so that no power is squared.
        let mut square = T::ZERO;
        for power in powers {
            let off = power / mean - T::ONE;
            square += off * off;
        }
        square / n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(x: impl Fn(f64) -> f64, f_hz: f64) -> f64 {
        let fs = 6000.0;
        let mut frame = Frame::<f64>::BLANK;
        frame.restart(fs);
        for n in 0..3000 {
            frame.push(x(n as f64 / fs));
        }
        frame.begin();
        let mut s = Steadiness::BLANK;
        s.begin(core::f64::consts::TAU * f_hz / fs, &frame);
        while !s.work(&frame) {}
        s.value()
    }

    #[test]
    fn a_tone_stands_and_a_beat_does_not() {
        let tone = |f: f64| move |t: f64| (core::f64::consts::TAU * f * t).sin();
        assert!(of(tone(800.0), 800.0) < 1e-3);
        // A beat of 8 Hz: V = 2(1 + cos), whose S is a half over whole periods.
        let beat = |t: f64| tone(796.0)(t) + tone(804.0)(t);
        let s = of(beat, 800.0);
        assert!((0.2..0.8).contains(&s), "{s}");
    }
}
