//! Sampling rate from a column of times.

use super::{InputError, Problem};

/// Steps may differ by this share of the step: more is a hole or jitter that
/// an ARMA model would read as damping.
const UNIFORM: f64 = 0.01;

/// A time column as read.
#[derive(Debug, Default)]
pub(super) struct TimeColumn {
    /// Times in seconds.
    pub(super) seconds: Vec<f64>,
    /// Line of each, from 1.
    pub(super) lines: Vec<usize>,
    /// Place value of the last printed digit, s: times are no better than this.
    pub(super) resolution: f64,
}

impl TimeColumn {
    /// The rate, after a check that time advances in equal steps.
    ///
    /// Steps are compared with their median, so that a hole is blamed on its
    /// own line and not on the first one, and within the rounding of the
    /// printed digits: 44.1 kHz in whole microseconds steps by 22 and 23.
    pub(super) fn rate(&self) -> Result<f64, InputError> {
        let t = &self.seconds;
        let fail = |i: usize, what: String, remedy: &str| {
            Err(InputError::new(
                Problem::Time,
                format!("line {}", self.lines[i]),
                what,
                remedy,
            ))
        };
        if t.len() < 2 {
            return Err(InputError::new(
                Problem::Rate,
                "time column",
                "a sampling rate cannot be told from one line",
                "record at least two samples",
            ));
        }
        let steps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
        if let Some(i) = t.iter().position(|v| !v.is_finite()) {
            return fail(i, format!("time is {}", t[i]), "repair the time column");
        }
        if let Some(i) = steps.iter().position(|d| *d <= 0.0) {
            let what = format!("time goes from {} s to {} s", t[i], t[i + 1]);
            return fail(
                i + 1,
                what,
                "times must increase; write more digits or sort the lines",
            );
        }
        let median = {
            let mut sorted = steps.clone();
            sorted.sort_by(f64::total_cmp);
            sorted[sorted.len() / 2]
        };
        let tolerance = UNIFORM * median + self.resolution.min(0.1 * median) * 1.001;
        if let Some(i) = steps.iter().position(|d| (d - median).abs() > tolerance) {
            let missing = (steps[i] / median).round() - 1.0;
            let what = format!(
                "time steps by {:.6e} s, elsewhere by {median:.6e} s",
                steps[i]
            );
            return if missing >= 1.0 {
                fail(
                    i + 1,
                    format!("{what}: {missing} samples are missing before this line"),
                    "fill or cut the recording there",
                )
            } else {
                fail(i + 1, what, "resample to equal steps")
            };
        }
        let span = t[t.len() - 1] - t[0];
        let fs = steps.len() as f64 / span;
        if !(fs.is_finite() && fs > 0.0) {
            return fail(0, format!("time spans {span} s"), "repair the time column");
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

    fn column(fs: f64, n: usize, digits: usize) -> TimeColumn {
        let mut c = TimeColumn::default();
        for i in 0..n {
            let text = format!("{:.*}", digits, i as f64 / fs);
            c.resolution = c.resolution.max(resolution_of(&text));
            c.seconds.push(text.parse().unwrap());
            c.lines.push(i + 2);
        }
        c
    }

    #[test]
    fn rounded_times_give_the_rate() {
        assert_eq!(column(5000.0, 100, 4).rate().unwrap(), 5000.0);
        assert_eq!(column(44100.0, 4410, 6).rate().unwrap(), 44100.0);
        assert_eq!(column(12.5, 100, 3).rate().unwrap(), 12.5);
        assert_eq!(column(0.5, 10, 0).rate().unwrap(), 0.5);
    }

    #[test]
    fn a_hole_is_blamed_on_its_line() {
        let mut c = column(1000.0, 100, 6);
        for t in &mut c.seconds[40..] {
            *t += 0.5;
        }
        let e = c.rate().unwrap_err();
        assert_eq!((e.problem, e.place.as_str()), (Problem::Time, "line 42"));
        assert!(e.what.contains("500 samples"), "{e}");
    }

    #[test]
    fn resolution() {
        assert_eq!(resolution_of("12"), 1.0);
        assert!((resolution_of("0.0002") - 1e-4).abs() < 1e-12);
        assert!((resolution_of("1.25e-3") - 1e-5).abs() < 1e-12);
    }
}
