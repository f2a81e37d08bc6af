//! Pseudo-random binary sequences from a shift register.

use crate::cers::error::CersError;

/// Taps of registers of 9 to 20 bits that run through all 2ⁿ − 1 states; bit b is b + 1 in
/// the usual numbering.
const TAPS: [(u32, u32); 11] = [
    (9, 1 << 8 | 1 << 4),
    (10, 1 << 9 | 1 << 6),
    (11, 1 << 10 | 1 << 8),
    (12, 1 << 11 | 1 << 10 | 1 << 9 | 1 << 3),
    (13, 1 << 12 | 1 << 11 | 1 << 10 | 1 << 7),
    (14, 1 << 13 | 1 << 12 | 1 << 11 | 1 << 1),
    (15, 1 << 14 | 1 << 13),
    (16, 1 << 15 | 1 << 14 | 1 << 12 | 1 << 3),
    (17, 1 << 16 | 1 << 13),
    (18, 1 << 17 | 1 << 10),
    (20, 1 << 19 | 1 << 16),
];

/// A binary sequence of ±1, held for a whole number of samples.
///
/// With a clock f_c = rate/hold the spectrum falls as sinc²(f/f_c): −3 dB at 0.443·f_c, a
/// zero at f_c. The period is (2ⁿ − 1)·hold samples; over it the mean is 1/(2ⁿ − 1) and the
/// autocorrelation elsewhere −1/(2ⁿ − 1). Two directions at once: the same sequence,
/// [`Self::advanced`] by half a period, is orthogonal for responses shorter than that.
///
/// ```
/// use rarma_rigs::cers::Prbs;
/// let mut x = Prbs::new(9, 2)?;
/// let (a, b) = (x.next_sample(), x.next_sample());
/// assert!(a == b && a.abs() == 1.0);
/// # Ok::<(), rarma_rigs::cers::CersError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Prbs {
    state: u32,
    taps: u32,
    bits: u32,
    hold: u32,
    left: u32,
}

impl Prbs {
    /// A register of 9 to 18 or of 20 bits; each value for `hold` samples, 1 to 1000.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn new(bits: u32, hold: u32) -> Result<Self, CersError> {
        let Some(&(_, taps)) = TAPS.iter().find(|(n, _)| *n == bits) else {
            return Err(CersError::OutOfRange { name: "bits" });
        };
        if !(1..=1000).contains(&hold) {
            return Err(CersError::OutOfRange { name: "hold" });
        }
        Ok(Self {
            state: 1,
            taps,
            bits,
            hold,
            left: hold,
        })
    }

    /// Samples in a period.
    pub fn period(&self) -> u32 {
        ((1 << self.bits) - 1) * self.hold
    }

    /// The same sequence from `steps` clocks later on. Slow path.
    #[must_use]
    pub fn advanced(mut self, steps: u32) -> Self {
        for _ in 0..steps {
            self.clock();
        }
        self
    }

    #[inline(always)]
    fn clock(&mut self) {
        let new = (self.state & self.taps).count_ones() & 1;
        self.state = (self.state << 1 | new) & ((1 << self.bits) - 1);
    }

    /// ±1.
    #[inline]
    pub fn next_sample(&mut self) -> f32 {
        let out = if self.state & 1 == 1 { 1.0 } else { -1.0 };
        self.left -= 1;
        if self.left == 0 {
            self.left = self.hold;
            self.clock();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_register_runs_through_all_its_states() {
        for (bits, _) in TAPS {
            let mut p = Prbs::new(bits, 1).unwrap();
            let mut count = 0u32;
            let mut sum = 0.0f64;
            loop {
                sum += f64::from(p.next_sample());
                count += 1;
                if p.state == 1 {
                    break;
                }
            }
            assert_eq!(count, p.period(), "{bits}");
            assert_eq!(sum, 1.0, "{bits}");
        }
    }

    #[test]
    fn autocorrelation_is_that_of_noise_but_for_one_in_a_period() {
        let mut p = Prbs::new(10, 1).unwrap();
        let x: Vec<f32> = (0..1023).map(|_| p.next_sample()).collect();
        for lag in [1usize, 2, 10, 511, 1022] {
            let sum: f32 = (0..1023).map(|i| x[i] * x[(i + lag) % 1023]).sum();
            assert_eq!(sum, -1.0, "{lag}");
        }
        let mut later = Prbs::new(10, 1).unwrap().advanced(511);
        let y: Vec<f32> = (0..1023).map(|_| later.next_sample()).collect();
        assert_eq!(y[0], x[511]);
    }

    #[test]
    fn spectrum_is_3_db_down_at_0_443_of_the_clock() {
        // Mean power of lines about 0.443·f_c over that near 0, hold 8: f_c = rate/8.
        let (bits, hold) = (11u32, 8u32);
        let mut p = Prbs::new(bits, hold).unwrap();
        let n = p.period() as usize;
        let x: Vec<f64> = (0..n).map(|_| f64::from(p.next_sample())).collect();
        let power = |part: f64| {
            let centre = (part * f64::from((1 << bits) - 1)) as usize;
            (centre..centre + 40)
                .map(|k| {
                    let (mut re, mut im) = (0.0, 0.0);
                    for (i, x) in x.iter().enumerate() {
                        let a = core::f64::consts::TAU * ((k * i) % n) as f64 / n as f64;
                        re += x * a.cos();
                        im += x * a.sin();
                    }
                    re * re + im * im
                })
                .sum::<f64>()
        };
        let db = 10.0 * (power(0.433) / power(0.001)).log10();
        assert!((-3.2..-2.8).contains(&db), "{db}");
    }

    #[test]
    fn refusals() {
        assert_eq!(
            Prbs::new(19, 1),
            Err(CersError::OutOfRange { name: "bits" })
        );
        assert_eq!(Prbs::new(9, 0), Err(CersError::OutOfRange { name: "hold" }));
    }
}
