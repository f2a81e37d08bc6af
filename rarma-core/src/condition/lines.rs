//! Removal of lines whose frequencies are known: what the turning spindle forces.
//!
//! Rate: once a (decimated) sample, ahead of the estimator. Words: *line*, a steady
//! tone; *notch*, the band around a line in which nothing else can be seen either.

use crate::real::Real;
use crate::ud::UdFactors;

/// Variance of an amplitude before the first sample, over that of the rest: nothing is
/// known.
const START_VARIANCE: f64 = 1e9;
/// Range of a factor of that covariance.
const FACTORS: (f64, f64) = (1e-9, 1e9);
/// Least 1 − λ that counts as forgetting.
const SMALLEST: f64 = 1e-30;

/// Subtracts up to `H` lines of known frequency by recursive least squares.
///
/// ```text
/// y(t) = Σ_h (α_h·cos φ_h(t) + β_h·sin φ_h(t)) + rest,   φ_h(t) = φ_h(t−1) + 2π·f_h/fs
/// ```
///
/// `M` must be 2·`H`, checked when the code is built. α and β follow the recursive
/// least squares of the estimator (U·D·Uᵀ factors), so that they are there after a few
/// tens of samples, however loud the lines are, and close lines are told apart. What
/// comes out is the rest with the amplitudes of this sample.
///
/// Memory λ: with 1 the amplitudes settle for ever and the notch closes as 1/T; with
/// λ < 1 they follow, and everything within [`Self::notch_hz`] of a line is taken with
/// it, chatter as well.
///
/// ```
/// use rarma_core::condition::KnownLines;
/// let fs = 5000.0;
/// let mut lines = KnownLines::<f64, 1, 2>::new(&[1200.0], fs, 1.0).unwrap();
/// let mut rest = 0.0;
/// for n in 0..1000 {
///     rest = lines.process((2.0 * core::f64::consts::PI * 1200.0 * f64::from(n) / fs).sin());
/// }
/// assert!(rest.abs() < 1e-3 && (lines.amplitude(0).unwrap() - 1.0).abs() < 1e-3);
/// ```
#[derive(Debug, Clone)]
pub struct KnownLines<T, const H: usize, const M: usize> {
    used: usize,
    fs_hz: T,
    lambda: T,
    /// cos φ, sin φ of each line, and its turn in a sample.
    phasors: [(T, T); H],
    turns: [(T, T); H],
    /// (α, β) of each line in turn.
    theta: [T; M],
    covariance: UdFactors<T, M>,
    turn: usize,
    samples: u32,
}

/// What is wrong with the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LinesError {
    /// More frequencies than `H`.
    TooMany,
    /// A frequency that is not above 0 and below half the sampling rate.
    Frequency,
    /// λ must lie in 0.9..=1.
    Forgetting,
}

impl<T: Real, const H: usize, const M: usize> KnownLines<T, H, M> {
    /// Lines at `frequencies_hz` in samples of rate `fs_hz`, with forgetting λ.
    ///
    /// # Errors
    /// See [`LinesError`].
    pub fn new(frequencies_hz: &[T], fs_hz: T, lambda: T) -> Result<Self, LinesError> {
        const { assert!(M == 2 * H, "M must be 2·H") };
        if !(lambda >= T::from_f64(0.9) && lambda <= T::ONE) {
            return Err(LinesError::Forgetting);
        }
        let mut lines = Self {
            used: 0,
            fs_hz,
            lambda,
            phasors: [(T::ONE, T::ZERO); H],
            turns: [(T::ONE, T::ZERO); H],
            theta: [T::ZERO; M],
            covariance: UdFactors::diagonal(T::from_f64(START_VARIANCE)),
            turn: 0,
            samples: 0,
        };
        lines.steer(frequencies_hz)?;
        Ok(lines)
    }

    /// New frequencies of the same lines, for a speed that changes: the phases run on.
    /// Slow path.
    ///
    /// # Errors
    /// See [`LinesError`]; nothing has changed then.
    pub fn steer(&mut self, frequencies_hz: &[T]) -> Result<(), LinesError> {
        if frequencies_hz.len() > H {
            return Err(LinesError::TooMany);
        }
        let half = self.fs_hz * T::from_f64(0.5);
        if !frequencies_hz.iter().all(|f| *f > T::ZERO && *f < half) {
            return Err(LinesError::Frequency);
        }
        for (turn, f) in self.turns.iter_mut().zip(frequencies_hz) {
            let (sin, cos) = (T::from_f64(2.0) * T::PI * *f / self.fs_hz).sin_cos();
            *turn = (cos, sin);
        }
        self.used = frequencies_hz.len();
        Ok(())
    }

    /// Takes a sample, gives what is left of it.
    #[inline]
    pub fn process(&mut self, y: T) -> T {
        let n = 2 * self.used;
        let mut row = [T::ZERO; M];
        for (h, (phasor, turn)) in self.phasors.iter_mut().zip(&self.turns).enumerate() {
            if h >= self.used {
                break;
            }
            row[2 * h] = phasor.0;
            row[2 * h + 1] = phasor.1;
            let (c, s) = *phasor;
            let next = (c * turn.0 - s * turn.1, c * turn.1 + s * turn.0);
            // One step of Newton keeps the length at 1 whatever rounding does.
            let stretch = T::from_f64(1.5) - T::from_f64(0.5) * (next.0 * next.0 + next.1 * next.1);
            *phasor = (next.0 * stretch, next.1 * stretch);
        }
        let before = self.rest(y, &row, n);
        if !before.is_finite() {
            return y;
        }
        self.samples = self.samples.saturating_add(1);
        // The variance of the rest is the unit: amplitudes need no absolute one.
        let mut direction = [T::ZERO; M];
        let growth = T::ONE / self.lambda;
        let inverse = self
            .covariance
            .measure(n, &row, self.lambda, growth, &mut direction);
        let step = before * inverse;
        for (theta, k) in self.theta[..n].iter_mut().zip(&direction) {
            *theta += *k * step;
        }
        self.turn = if self.turn + 1 >= n { 0 } else { self.turn + 1 };
        let (least, most) = FACTORS;
        let _ = self
            .covariance
            .hold(self.turn, T::from_f64(least), T::from_f64(most));
        self.rest(y, &row, n)
    }

    fn rest(&self, y: T, row: &[T; M], n: usize) -> T {
        let mut rest = y;
        for (x, theta) in row[..n].iter().zip(&self.theta) {
            rest -= *x * *theta;
        }
        rest
    }

    /// Amplitude of line `h`, input units; none if there is no such line.
    pub fn amplitude(&self, h: usize) -> Option<T> {
        if h >= self.used {
            return None;
        }
        let (a, b) = (*self.theta.get(2 * h)?, *self.theta.get(2 * h + 1)?);
        Some((a * a + b * b).sqrt())
    }

    /// Power of all lines together, input units squared.
    pub fn power(&self) -> T {
        let sum = self.theta[..2 * self.used]
            .iter()
            .fold(T::ZERO, |sum, x| sum + *x * *x);
        sum * T::from_f64(0.5)
    }

    /// Half the width of the notch around each line, Hz: 1/(2π·τ) with τ the memory,
    /// 1/(1 − λ) samples or, while it fills, the samples so far.
    pub fn notch_hz(&self) -> T {
        let seen = T::from_u32(self.samples.max(1));
        let memory = T::ONE / (T::ONE - self.lambda).max(T::from_f64(SMALLEST));
        self.fs_hz / (T::from_f64(2.0) * T::PI * seen.min(memory))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    fn noise(seed: &mut u32) -> f64 {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(*seed >> 8) / 8_388_608.0 - 1.0
    }

    #[test]
    fn two_close_lines_are_taken_and_the_rest_is_left() {
        let (fs, mut seed) = (5000.0, 1);
        let mut lines = KnownLines::<f64, 2, 4>::new(&[1200.0, 1210.0], fs, 1.0).expect("lines");
        let (mut off, mut left) = (0.0, 0.0);
        for n in 0..20_000 {
            let t = f64::from(n) / fs;
            let rest = noise(&mut seed);
            let y = 30.0 * (TAU * 1200.0 * t + 0.3).sin() + 5.0 * (TAU * 1210.0 * t).cos() + rest;
            let out = lines.process(y);
            if n >= 10_000 {
                off += (out - rest) * (out - rest);
                left += rest * rest;
            }
        }
        assert!((lines.amplitude(0).expect("line") - 30.0).abs() < 0.05);
        assert!((lines.amplitude(1).expect("line") - 5.0).abs() < 0.05);
        assert!((lines.power() - 462.5).abs() < 2.0);
        // Four amplitudes of 10 000 to 20 000 samples.
        let share: f64 = off / left;
        assert!((5e-5..1e-3).contains(&share), "{share}");
        assert!(lines.amplitude(2).is_none());
    }

    #[test]
    fn a_loud_line_is_gone_within_tens_of_samples() {
        let fs = 5000.0f32;
        let mut lines = KnownLines::<f32, 1, 2>::new(&[333.0], fs, 0.998).expect("line");
        let mut worst = 0.0f32;
        for n in 0..400_000u32 {
            let angle = (TAU * 333.0 * f64::from(n) / 5000.0).sin() as f32;
            let out = lines.process(100.0 * angle);
            if n > 50 {
                worst = worst.max(out.abs());
            }
        }
        // Single precision: the phasor's own rounding stays within a part in 10 000.
        assert!((1e-6..0.02).contains(&worst), "{worst}");
        let notch = lines.notch_hz();
        assert!((notch - 1.59).abs() < 0.02, "{notch}");
    }

    #[test]
    fn bad_lines_are_refused_by_name() {
        type One = KnownLines<f64, 1, 2>;
        let refused = |f: &[f64], lambda| One::new(f, 1000.0, lambda).err();
        assert_eq!(refused(&[1.0, 2.0], 1.0), Some(LinesError::TooMany));
        assert_eq!(refused(&[500.0], 1.0), Some(LinesError::Frequency));
        assert_eq!(refused(&[f64::NAN], 1.0), Some(LinesError::Frequency));
        assert_eq!(refused(&[100.0], 0.5), Some(LinesError::Forgetting));
        assert_eq!(refused(&[], 1.0), None);
    }

    #[test]
    fn a_sample_that_is_no_number_changes_nothing() {
        let mut lines = KnownLines::<f64, 1, 2>::new(&[100.0], 1000.0, 1.0).expect("line");
        lines.process(1.0);
        let before = lines.amplitude(0);
        assert!(lines.process(f64::NAN).is_nan());
        assert_eq!(lines.amplitude(0), before);
    }
}
