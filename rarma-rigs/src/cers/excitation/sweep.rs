//! Sines one at a time: swept or stepped.

use crate::cers::error::{CersError, within};
use rarma_core::real::Real;

/// How the frequency goes from the first to the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// At a constant rate.
    Linear,
    /// By a constant factor in a time.
    Logarithmic,
    /// In this many equal steps, held each for the same time.
    Stepped(u32),
}

/// A sine of amplitude 1 whose phase never jumps; starts again when it has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep<T> {
    from: T,
    to: T,
    length: u32,
    course: Course,
    at: u32,
    turns: T,
}

impl<T: Real> Sweep<T> {
    /// From `from_hz` to `to_hz` (either may be the higher) in `seconds` at `rate_hz`.
    ///
    /// # Errors
    /// `OutOfRange`: rate 100 Hz to 1 MHz, frequencies 0.1 Hz to 0.45 of the rate, time 10
    /// samples to 1e8, 2 to 100 000 steps.
    pub fn new(
        rate_hz: T,
        (from_hz, to_hz): (T, T),
        seconds: T,
        course: Course,
    ) -> Result<Self, CersError> {
        let value = T::from_f64;
        within(rate_hz, value(100.0), value(1e6), "rate_hz")?;
        let top = rate_hz * value(0.45);
        within(from_hz, value(0.1), top, "from_hz")?;
        within(to_hz, value(0.1), top, "to_hz")?;
        let length = seconds * rate_hz;
        within(length, value(10.0), value(1e8), "seconds")?;
        if let Course::Stepped(n) = course {
            within(n, 2, 100_000, "steps")?;
        }
        Ok(Self {
            from: from_hz / rate_hz,
            to: to_hz / rate_hz,
            length: length.to_f64() as u32,
            course,
            at: 0,
            turns: T::ZERO,
        })
    }

    /// Frequency of the next sample over the rate.
    pub fn frequency(&self) -> T {
        let part = T::from_u32(self.at) / T::from_u32(self.length);
        match self.course {
            Course::Linear => self.from + (self.to - self.from) * part,
            Course::Logarithmic => self.from * ((self.to / self.from).ln() * part).exp(),
            Course::Stepped(n) => {
                // Whole steps gone by; the ends of steps may be off by a rounding of T.
                let step = part * T::from_u32(n);
                let step = (step - T::from_f64(0.5)).round().max(T::ZERO);
                self.from + (self.to - self.from) * step / T::from_u32(n - 1)
            }
        }
    }

    /// A sample.
    #[inline]
    pub fn next_sample(&mut self) -> T {
        let (s, _) = (T::from_f64(2.0) * T::PI * self.turns).sin_cos();
        self.turns += self.frequency();
        if self.turns >= T::ONE {
            self.turns -= T::ONE;
        }
        self.at += 1;
        if self.at >= self.length {
            self.at = 0;
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_are_where_they_should_be() {
        for (course, due) in [
            (Course::Linear, 100.0 + 3900.0 * 41.0 / 160.0),
            (Course::Logarithmic, 100.0 * 40f64.powf(41.0 / 160.0)),
            (Course::Stepped(40), 1100.0),
        ] {
            let mut s = Sweep::<f64>::new(40e3, (100.0, 4000.0), 4.0, course).unwrap();
            // Rising zero crossings in 50 ms, 41/160 of the way.
            let x: Vec<f64> = (0..160_000).map(|_| s.next_sample()).collect();
            let around = &x[40_000..42_000];
            let rises = around
                .windows(2)
                .filter(|w| w[0] < 0.0 && w[1] >= 0.0)
                .count();
            let f = rises as f64 / 0.05;
            assert!((f - due).abs() < 25.0, "{course:?}: {f}");
            let most = x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            assert!((0.999..=1.0).contains(&most));
        }
    }

    #[test]
    fn the_phase_never_jumps() {
        let mut s = Sweep::<f64>::new(40e3, (100.0, 4000.0), 0.1, Course::Stepped(10)).unwrap();
        let mut last = 0.0;
        for _ in 0..12_000 {
            let x = s.next_sample();
            // 2π·4000/40 000 is the steepest.
            assert!(f64::abs(x - last) < 0.63, "{x} after {last}");
            last = x;
        }
    }

    #[test]
    fn refusals() {
        let of = |f, s, c| Sweep::<f32>::new(40e3, f, s, c).unwrap_err();
        assert_eq!(
            of((0.0, 100.0), 1.0, Course::Linear),
            CersError::OutOfRange { name: "from_hz" }
        );
        assert_eq!(
            of((10.0, 100.0), 1.0, Course::Stepped(1)),
            CersError::OutOfRange { name: "steps" }
        );
    }
}
