//! A row of samples between two corrections: what the lines are in it is worked out ahead, and what
//! is left of it is compared with them when it is full.
//!
//! Amplitudes, phase and speed stand still within a row, so that each line is a sine of fixed step,
//! and two recurrences of one product a sample do both:
//!
//! ```text
//! r(i) = Re(c·e^(jn(φ + iω))):   r(i+1) = 2·cos(nω)·r(i) − r(i−1)
//! S = Σ_i e(i)·e^(−jniω):        s(i) = e(i) + 2·cos(nω)·s(i+1) − s(i+2),  S = s(0) − e^(jnω)·s(1)
//! ```
//!
//! The second is Goertzel's, from the last sample to the first. Rounding grows with the square of
//! the length, at the most by some 500 units of the last place of a line's amplitude: hence the
//! short rows.

use super::line::RotationLine;
use crate::real::Real;
use crate::visit::state;

/// Longest row: that of a block at 6 kHz fills half of it.
pub(super) const LONGEST: usize = 32;
/// Lines that are worked on side by side, so that none waits for its own last result.
const ABREAST: usize = 4;

/// Samples of a row: the lines' part of those to come, what is left of those that were.
#[derive(Debug, Clone)]
pub(super) struct Row<T> {
    values: [T; LONGEST],
    at: usize,
    length: usize,
}

state! { Row<T> {
    values, at, length;
    where *at <= LONGEST && *length <= LONGEST
} }

impl<T: Real> Row<T> {
    /// A row of no samples.
    pub(super) const EMPTY: Self = Self {
        values: [T::ZERO; LONGEST],
        at: 0,
        length: 0,
    };

    /// Samples of the row.
    pub(super) fn length(&self) -> usize {
        self.length
    }

    /// What is left of a sample without the lines; one that is no number counts as explained.
    #[inline(always)]
    pub(super) fn rest(&mut self, y: T) -> T {
        let Some(value) = self.values.get_mut(self.at) else {
            return y;
        };
        self.at += 1;
        let rest = y - *value;
        *value = if rest.is_finite() { rest } else { T::ZERO };
        rest
    }

    /// Every sample of the row has come.
    pub(super) fn is_full(&self) -> bool {
        self.at >= self.length
    }

    /// Begins a row of `length` samples: what `lines` will be in it, with the phasors of the
    /// rotation at its first sample and of its turn in a sample.
    pub(super) fn begin(
        &mut self,
        lines: &[RotationLine<T>],
        base: (T, T),
        turn: (T, T),
        length: usize,
    ) {
        self.at = 0;
        self.length = length.min(LONGEST);
        self.values = [T::ZERO; LONGEST];
        let (mut phases, mut steps) = (Powers::of(base), Powers::of(turn));
        let pairs = self.values.as_chunks_mut::<2>().0;
        for lines in lines.chunks(ABREAST) {
            let (mut now, mut before) = ([T::ZERO; ABREAST], [T::ZERO; ABREAST]);
            let mut twice = [T::ZERO; ABREAST];
            let places = now.iter_mut().zip(&mut before).zip(&mut twice);
            for (line, ((now, before), twice)) in lines.iter().zip(places) {
                let step = steps.at(line.multiple);
                let here = product(line.c, phases.at(line.multiple));
                *now = here.0;
                *before = here.0 * step.0 + here.1 * step.1;
                *twice = step.0 + step.0;
            }
            for [one, two] in pairs.iter_mut().take(self.length.div_ceil(2)) {
                for k in 0..ABREAST {
                    *one += now[k];
                    before[k] = twice[k] * now[k] - before[k];
                }
                for k in 0..ABREAST {
                    *two += before[k];
                    now[k] = twice[k] * before[k] - now[k];
                }
            }
        }
    }

    /// Adds Σ e·e^(−jnφ) of the full row to each line's, with the phasors it was begun with.
    pub(super) fn end(&mut self, lines: &mut [RotationLine<T>], base: (T, T), turn: (T, T)) {
        // An odd row has a place too much in its last pair.
        if let Some(last) = self.values.get_mut(self.length) {
            *last = T::ZERO;
        }
        let (mut phases, mut steps) = (Powers::of(base), Powers::of(turn));
        let pairs = self.values.as_chunks::<2>().0;
        let used = self.length.div_ceil(2);
        for lines in lines.chunks_mut(ABREAST) {
            let (mut first, mut second) = ([T::ZERO; ABREAST], [T::ZERO; ABREAST]);
            // Of phase and step.
            let mut phasors = [((T::ZERO, T::ZERO), (T::ZERO, T::ZERO)); ABREAST];
            let mut twice = [T::ZERO; ABREAST];
            for (line, (phasors, twice)) in lines.iter().zip(phasors.iter_mut().zip(&mut twice)) {
                *phasors = (phases.at(line.multiple), steps.at(line.multiple));
                *twice = phasors.1.0 + phasors.1.0;
            }
            for [one, two] in pairs.iter().take(used).rev() {
                for k in 0..ABREAST {
                    second[k] = *two + twice[k] * first[k] - second[k];
                }
                for k in 0..ABREAST {
                    first[k] = *one + twice[k] * second[k] - first[k];
                }
            }
            let sums = first.into_iter().zip(second).zip(phasors);
            for (line, ((first, second), (at, step))) in lines.iter_mut().zip(sums) {
                let sum = (first - step.0 * second, -step.1 * second);
                let turned = product(sum, (at.0, -at.1));
                line.sum.0 += turned.0;
                line.sum.1 += turned.1;
            }
        }
    }
}

/// The powers of a phasor, in ascending order.
struct Powers<T> {
    of: (T, T),
    power: (T, T),
    n: u16,
}

impl<T: Real> Powers<T> {
    fn of(of: (T, T)) -> Self {
        Self {
            of,
            power: (T::ONE, T::ZERO),
            n: 0,
        }
    }

    /// The `n`-th power, `n` not below the last one asked for.
    #[inline(always)]
    fn at(&mut self, n: u16) -> (T, T) {
        while self.n < n {
            self.power = product(self.power, self.of);
            self.n += 1;
        }
        self.power
    }
}

/// Product of two complex numbers.
#[inline(always)]
pub(super) fn product<T: Real>(a: (T, T), b: (T, T)) -> (T, T) {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: f64 = 0.0312;
    const PHASE: f64 = 1.1;

    fn phasor(angle: f64) -> (f64, f64) {
        (angle.cos(), angle.sin())
    }

    fn lines(multiples: &[u16]) -> Vec<RotationLine<f64>> {
        let line = |(k, &n): (usize, &u16)| RotationLine {
            c: (1.0 + k as f64, 0.5 - k as f64),
            ..RotationLine::new(n)
        };
        multiples.iter().enumerate().map(line).collect()
    }

    #[test]
    fn a_row_is_the_sum_of_the_lines_and_of_its_errors() {
        for length in [1, 2, 15, 16, 31, 32] {
            let mut lines = lines(&[3, 7, 8, 20, 61]);
            let mut row = Row::EMPTY;
            row.begin(&lines, phasor(PHASE), phasor(TURN), length);
            let error = |i: usize| (i as f64 * 1.7).sin() + 0.2;
            let mut sums = vec![(0.0, 0.0); lines.len()];
            for i in 0..length {
                let mut y = error(i);
                for (line, sum) in lines.iter().zip(&mut sums) {
                    let angle = f64::from(line.multiple) * (PHASE + i as f64 * TURN);
                    y += line.c.0 * angle.cos() - line.c.1 * angle.sin();
                    sum.0 += error(i) * angle.cos();
                    sum.1 -= error(i) * angle.sin();
                }
                assert!(!row.is_full());
                assert!((row.rest(y) - error(i)).abs() < 1e-11, "{length}, {i}");
            }
            assert!(row.is_full());
            row.end(&mut lines, phasor(PHASE), phasor(TURN));
            for (line, sum) in lines.iter().zip(sums) {
                let off = (line.sum.0 - sum.0).hypot(line.sum.1 - sum.1);
                assert!(off < 1e-10, "{length}, multiple {}: {off}", line.multiple);
            }
        }
    }

    #[test]
    fn single_precision_leaves_little_of_the_slowest_line() {
        // A line at the lowest edge that a band may have, 1/250 of its upper one: 0.01 rad a sample.
        let line = RotationLine::<f32> {
            c: (1.0, 0.0),
            ..RotationLine::new(1)
        };
        let mut row = Row::EMPTY;
        let (sin, cos) = 0.01f32.sin_cos();
        row.begin(&[line], (1.0, 0.0), (cos, sin), LONGEST);
        let mut worst = 0.0f64;
        for i in 0..LONGEST {
            let exact = (0.01 * i as f64).cos() as f32;
            worst = worst.max(f64::from(row.rest(exact).abs()));
        }
        assert!((1e-7..1e-4).contains(&worst), "{worst}");
    }

    #[test]
    fn a_sample_that_is_no_number_tells_the_lines_nothing() {
        let mut lines = lines(&[3]);
        let mut row = Row::EMPTY;
        row.begin(&[], phasor(PHASE), phasor(TURN), 2);
        assert!(row.rest(f64::NAN).is_nan());
        assert_eq!(row.rest(0.0), 0.0);
        row.end(&mut lines, phasor(PHASE), phasor(TURN));
        assert_eq!(lines[0].sum, (0.0, 0.0));
        assert_eq!(row.rest(3.0), 3.0 - 0.0, "past its end");
    }
}
