//! Sampling rate from a column of times.

use super::{InputError, Problem};
use std::ops::RangeInclusive;

/// Steps may differ by this share of the step: more is a hole or jitter that
/// an ARMA model would read as damping.
const UNIFORM: f64 = 0.01;

/// Steps from whose median the even step is told.
const FIRST: usize = 1 << 16;

/// A column of times, judged as it comes.
///
/// Steps are compared with their median (that of the first [`FIRST`]), so that a hole is
/// blamed on its own line and not on the first one, and within the rounding of the
/// printed digits: 44.1 kHz in whole microseconds steps by 22 and 23.
#[derive(Debug, Default)]
pub(super) struct TimeColumn {
    /// First and last time, s.
    ends: Option<(f64, f64)>,
    count: u64,
    /// Line of the first and of the last.
    lines: (usize, usize),
    /// Place value of the last printed digit, s: times are no better than this.
    resolution: f64,
    /// The first steps with the line at their end, until there are enough.
    steps: Vec<(f64, usize)>,
    /// Median step and how far a step may lie from it, s, once there are enough.
    even: Option<(f64, f64)>,
    /// First of each kind of fault: no number, not forward, uneven.
    not_finite: Option<(f64, usize)>,
    backward: Option<(f64, f64, usize)>,
    uneven: Option<(f64, f64, usize)>,
}

impl TimeColumn {
    /// Takes the time of one line, s, printed to `resolution` s.
    pub(super) fn push(&mut self, t: f64, line: usize, resolution: f64) {
        // Trailing zeros may be left out, so the finest line tells.
        self.resolution = match self.count {
            0 | 1 => resolution,
            _ => self.resolution.min(resolution),
        };
        self.count += 1;
        let Some((first, last)) = self.ends else {
            self.ends = Some((t, t));
            self.lines = (line, line);
            if !t.is_finite() {
                self.not_finite = Some((t, line));
            }
            return;
        };
        self.ends = Some((first, t));
        self.lines.1 = line;
        if !t.is_finite() {
            self.not_finite.get_or_insert((t, line));
        }
        let step = t - last;
        if step <= 0.0 {
            self.backward.get_or_insert((last, t, line));
        }
        match self.even {
            Some(even) => self.compare(step, line, even),
            None => {
                self.steps.push((step, line));
                if self.steps.len() == FIRST {
                    self.settle();
                }
            }
        }
    }

    /// The even step from those so far, and what of them is uneven.
    fn settle(&mut self) {
        let steps = std::mem::take(&mut self.steps);
        let mut sorted: Vec<f64> = steps.iter().map(|s| s.0).collect();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let even = (
            median,
            UNIFORM * median + self.resolution.min(0.1 * median) * 1.001,
        );
        for (step, line) in steps {
            self.compare(step, line, even);
        }
        self.even = Some(even);
    }

    fn compare(&mut self, step: f64, line: usize, (median, tolerance): (f64, f64)) {
        if (step - median).abs() > tolerance {
            self.uneven.get_or_insert((step, median, line));
        }
    }

    /// The rate, after a check that time advances in equal steps.
    pub(super) fn rate(&mut self) -> Result<f64, InputError> {
        let fail = |line: usize, what: String, remedy: &str| {
            Err(InputError::new(
                Problem::Time,
                format!("line {line}"),
                what,
                remedy,
            ))
        };
        let (Some((first, last)), 2..) = (self.ends, self.count) else {
            return Err(InputError::new(
                Problem::Rate,
                "time column",
                "a sampling rate cannot be told from one line",
                "record at least two samples",
            ));
        };
        if self.even.is_none() {
            self.settle();
        }
        if let Some((t, line)) = self.not_finite {
            return fail(line, format!("time is {t}"), "repair the time column");
        }
        if let Some((before, t, line)) = self.backward {
            return fail(
                line,
                format!("time goes from {before} s to {t} s"),
                "times must increase; write more digits or sort the lines",
            );
        }
        if let Some((step, median, line)) = self.uneven {
            let missing = (step / median).round() - 1.0;
            let what = format!("time steps by {step:.6e} s, elsewhere by {median:.6e} s");
            return if missing >= 1.0 {
                fail(
                    line,
                    format!("{what}: {missing} samples are missing before this line"),
                    "fill or cut the recording there",
                )
            } else {
                fail(line, what, "resample to equal steps")
            };
        }
        let span = last - first;
        let fs = (self.count - 1) as f64 / span;
        if !is_rate(fs) {
            let what = format!("time spans {span} s");
            return fail(self.lines.0, what, "repair the time column");
        }
        // A whole number of hertz, if the printed digits cannot tell it apart.
        let doubt = (self.resolution / span).max(1e-9);
        let whole = fs.round();
        Ok(if whole > 0.0 && (fs - whole).abs() <= doubt * fs {
            whole
        } else {
            fs
        })
    }
}

/// Sampling rates there are, Hz: the length of any recording is a number, too.
pub const RATES_HZ: RangeInclusive<f64> = 1e-3..=1e9;

/// Whether a number can be a sampling rate, Hz.
pub(super) fn is_rate(fs: f64) -> bool {
    RATES_HZ.contains(&fs)
}

/// Place value of the last digit of a printed decimal number.
pub(super) fn resolution_of(field: &str) -> f64 {
    let (mantissa, exponent) = match field.find(['e', 'E']) {
        Some(i) => (&field[..i], field[i + 1..].parse::<i32>().unwrap_or(0)),
        None => (field, 0),
    };
    let decimals = mantissa
        .find(['.', ','])
        .map_or(0, |i| mantissa.len() - i - 1);
    let decimals = i32::try_from(decimals).unwrap_or(i32::MAX);
    10_f64.powi(exponent.saturating_sub(decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times with a pause of half a second before line `hole`.
    fn column(fs: f64, n: usize, digits: usize, hole: usize) -> TimeColumn {
        let mut c = TimeColumn::default();
        for i in 0..n {
            let pause = if i + 2 >= hole { 0.5 } else { 0.0 };
            let text = format!("{:.*}", digits, i as f64 / fs + pause);
            c.push(text.parse().unwrap(), i + 2, resolution_of(&text));
        }
        c
    }

    #[test]
    fn rounded_times_give_the_rate() {
        let rate = |fs, n, digits| column(fs, n, digits, usize::MAX).rate().unwrap();
        assert_eq!(rate(5000.0, 100, 4), 5000.0);
        assert_eq!(rate(44100.0, 4410, 6), 44100.0);
        assert_eq!(rate(44100.0, 2 * FIRST, 6), 44100.0);
        assert_eq!(rate(12.5, 100, 3), 12.5);
        assert_eq!(rate(0.5, 10, 0), 0.5);
    }

    #[test]
    fn times_that_give_no_rate_or_no_length_are_refused() {
        for (first, last) in [(0.0, 1e308), (-1e308, 1e308), (0.0, 5e-324), (0.0, 1001.0)] {
            let mut c = TimeColumn::default();
            c.push(first, 1, 0.1);
            c.push(last, 2, 0.1);
            let e = c.rate().unwrap_err();
            assert_eq!((e.problem, e.place), (Problem::Time, "line 1".to_owned()));
        }
    }

    #[test]
    fn a_hole_is_blamed_on_its_line() {
        for hole in [42, FIRST + 42] {
            let e = column(1000.0, FIRST + 100, 6, hole).rate().unwrap_err();
            assert_eq!(
                (e.problem, e.place),
                (Problem::Time, format!("line {hole}"))
            );
            assert!(e.what.contains("500 samples"), "{}", e.what);
        }
    }

    #[test]
    fn resolution() {
        assert_eq!(resolution_of("12"), 1.0);
        assert!((resolution_of("0.0002") - 1e-4).abs() < 1e-12);
        assert!((resolution_of("1.25e-3") - 1e-5).abs() < 1e-12);
    }
}
