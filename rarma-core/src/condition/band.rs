//! The band of interest: how far to decimate, and which filters.
//!
//! Every pole of a filter is one that the model must spend a root of A on, so there
//! are as few as can be: the decimation filters have none, and the high-pass two. A
//! fourth-order high-pass and low-pass made ARMA(6,5) read three modes of 2 to 3 %
//! damping as two of 6 to 10 %.
//!
//! A lower rate puts the modes where an ARMA model is well conditioned (poles
//! spread over the circle, 0.05 to 0.42 of the rate) and pays for itself: the
//! estimator runs once per decimated sample.

use super::biquad::{Biquad, BiquadState, Pass};
use super::fir::FirStage;
use crate::real::Real;
use crate::visit::state;
use core::fmt;

/// Band edges, Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Band {
    /// Lower edge (−3 dB of a second-order high-pass), Hz.
    pub low_hz: f64,
    /// Upper edge, Hz.
    pub high_hz: f64,
}

/// Why a band does not fit a rate.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BandError {
    /// Edges must be finite, positive and in order, at least a factor of 1.2 apart.
    Edges,
    /// The sampling rate must be positive and finite.
    Rate,
    /// The upper edge lies above [`TOP_FRACTION`] of the sampling rate.
    RateTooLow {
        /// Highest upper edge this rate allows, Hz.
        highest_hz: f64,
    },
    /// The lower edge is too low for the upper one: below 1/250 of it the filters
    /// would lose their precision in single precision.
    TooWide {
        /// Lowest lower edge for this upper one, Hz.
        lowest_hz: f64,
    },
}

impl fmt::Display for BandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Edges => f.write_str(
                "the band's edges must be above 0, the upper one at least 1.2 times the lower",
            ),
            Self::Rate => f.write_str("the sampling rate must be above 0"),
            Self::RateTooLow { highest_hz } => {
                write!(f, "the rate allows a band up to {highest_hz:.0} Hz")
            }
            Self::TooWide { lowest_hz } => {
                write!(
                    f,
                    "a band with this upper edge must begin at {lowest_hz:.1} Hz or above"
                )
            }
        }
    }
}

impl core::error::Error for BandError {}

/// Highest band edge as a fraction of the sampling rate.
pub const TOP_FRACTION: f64 = 0.45;
/// The decimated rate is at least this multiple of the upper band edge.
const RATE_PER_EDGE: f64 = 2.4;
const STAGES: usize = 4;
/// Memory of the offset, s: a corner at 1.6 Hz. Short, so that one absurd sample is
/// forgotten within a second or two.
const OFFSET_TAU_S: f64 = 0.1;

impl Band {
    /// Band of the monitor where none is given: 300 to 2500 Hz, where tools and
    /// holders vibrate; for a slow recording its upper 0.42 of the rate, the lower
    /// edge in the same proportion.
    pub fn usual(fs: f64) -> Self {
        let high_hz = if fs * 0.42 < 2500.0 {
            fs * 0.42
        } else {
            2500.0
        };
        Self {
            low_hz: high_hz * 0.12,
            high_hz,
        }
    }

    /// Checks the band against a sampling rate.
    ///
    /// # Errors
    /// See [`BandError`].
    pub fn check(&self, fs: f64) -> Result<(), BandError> {
        if !(fs.is_finite() && fs > 0.0) {
            return Err(BandError::Rate);
        }
        let ordered = self.low_hz > 0.0 && self.low_hz * 1.2 <= self.high_hz;
        if !(self.low_hz.is_finite() && self.high_hz.is_finite() && ordered) {
            return Err(BandError::Edges);
        }
        if self.high_hz > fs * TOP_FRACTION {
            return Err(BandError::RateTooLow {
                highest_hz: fs * TOP_FRACTION,
            });
        }
        if self.low_hz * 250.0 < self.high_hz {
            return Err(BandError::TooWide {
                lowest_hz: self.high_hz / 250.0,
            });
        }
        Ok(())
    }
}

/// The offset, decimation to the band, and its high-pass. Where the rate is not
/// reduced, what lies above the band stays in and is modelled with it.
#[derive(Debug, Clone)]
pub struct BandFilter<T> {
    stages: [FirStage<T>; STAGES],
    high_pass: Biquad<T>,
    state: BiquadState<T>,
    offset: Offset<T>,
    factor: usize,
    delay_s: f64,
}

state! { BandFilter<T> {
    stages, state, offset;
    settings high_pass, factor, delay_s
} }

impl<T: Real> BandFilter<T> {
    /// Designs the filters for input rate `fs`, Hz.
    ///
    /// # Errors
    /// See [`Band::check`].
    pub fn new(band: Band, fs: f64) -> Result<Self, BandError> {
        let mut filter = Self::unstarted();
        filter.restart(band, fs)?;
        Ok(filter)
    }

    /// Filters of no band, which pass nothing, until [`Self::restart`].
    pub(crate) fn unstarted() -> Self {
        Self {
            stages: [FirStage::IDENTITY; STAGES],
            high_pass: Biquad::BLANK,
            state: BiquadState::default(),
            offset: Offset::new(1.0),
            factor: 1,
            delay_s: 0.0,
        }
    }

    /// Forgets everything and takes this band and rate, stage by stage in place.
    ///
    /// # Errors
    /// See [`Band::check`]; nothing has changed then.
    #[inline(never)]
    pub fn restart(&mut self, band: Band, fs: f64) -> Result<(), BandError> {
        band.check(fs)?;
        // All of them by name, so that none is forgotten.
        let Self {
            stages,
            high_pass,
            state,
            offset,
            factor,
            delay_s,
        } = self;
        let factors = split(fs, band.high_hz);
        *factor = factors.iter().product();
        let mut rate = fs;
        *delay_s = 0.0;
        for (stage, m) in stages.iter_mut().zip(factors) {
            if m == 1 {
                *stage = FirStage::identity();
                continue;
            }
            // What folds onto the band after this stage is gone.
            *stage = FirStage::design(m, rate, band.high_hz);
            *delay_s += stage.delay() / rate;
            rate /= m as f64;
        }
        *high_pass = Biquad::butterworth(Pass::High, band.low_hz, rate, 0, 1);
        *state = BiquadState::default();
        *offset = Offset::new(fs);
        Ok(())
    }

    /// Input samples per output sample.
    pub fn factor(&self) -> usize {
        self.factor
    }

    /// Delay of the linear-phase decimation, s.
    pub fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// Time after which nothing is left of the signal's abrupt beginning, s: the
    /// decimation is filled, and the high-pass has died down to 1.2 %.
    pub fn settle_s(&self, band: Band) -> f64 {
        2.0 * self.delay_s + 1.0 / band.low_hz
    }

    /// What the density of a signal at `f_hz` is multiplied by between input and output,
    /// |H|², from the offset to the high-pass; `fs` is that of [`Self::new`]. Holds up to
    /// the upper edge of the band: above it what is folded comes on top. Slow path.
    pub fn power_gain(&self, f_hz: f64, fs: f64) -> f64 {
        let turn = 2.0 * core::f64::consts::PI * f_hz;
        let mut rate = fs;
        let mut gain = self.offset.power_gain(turn / rate);
        for stage in &self.stages {
            gain *= stage.power_gain(turn / rate);
            rate /= stage.factor() as f64;
        }
        gain * self.high_pass.power_gain(turn / rate)
    }

    /// Takes one finite input sample; gives one every `factor`-th time.
    #[inline(always)]
    pub fn process(&mut self, x: T) -> Option<T> {
        Some(self.process_both(x)?.1)
    }

    /// As [`Self::process`]; gives the sample before the high-pass as well, down to the offset.
    #[inline(always)]
    pub fn process_both(&mut self, x: T) -> Option<(T, T)> {
        let x = self.offset.remove(x);
        self.finish(0, x)
    }

    /// Samples until the first stage gives one: as many at most make a row.
    #[inline(always)]
    pub(crate) fn row(&self) -> usize {
        self.stages[0].until_output()
    }

    /// As [`Self::process_both`] of finite samples in a row, not more than [`Self::row`].
    #[inline(always)]
    pub(crate) fn process_row(&mut self, row: &[T]) -> Option<(T, T)> {
        let [first, ..] = &mut self.stages;
        self.offset.remove_row(row, first.room(row.len())?);
        let x = first.output()?;
        self.finish(1, x)
    }

    /// A sample without its offset through the stages from the `first` on, and the high-pass.
    #[inline(always)]
    fn finish(&mut self, first: usize, mut x: T) -> Option<(T, T)> {
        let stages = self.stages.iter_mut().skip(first);
        for stage in stages.take_while(|stage| !stage.is_identity()) {
            x = stage.process(x)?;
        }
        Some((x, self.high_pass.process(&mut self.state, x)))
    }
}

/// Running mean of the input: the mean of all samples at first, then over
/// [`OFFSET_TAU_S`].
#[derive(Debug, Clone, Copy)]
struct Offset<T> {
    mean: T,
    gain: T,
    last_gain: T,
}

state! { Offset<T> {
    mean, gain;
    settings last_gain
} }

impl<T: Real> Offset<T> {
    fn new(fs: f64) -> Self {
        Self {
            mean: T::ZERO,
            gain: T::ONE,
            last_gain: T::from_f64((1.0 / (OFFSET_TAU_S * fs)).min(1.0)),
        }
    }

    #[inline(always)]
    fn remove(&mut self, x: T) -> T {
        let x = self.follow(x);
        if !self.is_settled() {
            self.gain = Self::next_gain(self.gain).max(self.last_gain);
        }
        x
    }

    /// [`Self::remove`] of samples in a row, put into their places.
    #[inline(always)]
    fn remove_row(&mut self, row: &[T], places: &mut [T]) {
        // In registers meanwhile.
        let mut offset = *self;
        if offset.is_settled() {
            let (fours, rest) = places.as_chunks_mut::<4>();
            let (x4, left) = row.as_chunks::<4>();
            for (place, x) in fours.iter_mut().zip(x4) {
                for i in 0..4 {
                    place[i] = offset.follow(x[i]);
                }
            }
            for (place, x) in rest.iter_mut().zip(left) {
                *place = offset.follow(*x);
            }
        } else {
            for (place, x) in places.iter_mut().zip(row) {
                *place = offset.remove(*x);
            }
        }
        *self = offset;
    }

    /// The same with the gain as it is.
    #[inline(always)]
    fn follow(&mut self, x: T) -> T {
        self.mean += self.gain * (x - self.mean);
        x - self.mean
    }

    /// The gain stays what it is.
    #[inline(always)]
    fn is_settled(&self) -> bool {
        self.gain <= self.last_gain
    }

    /// Of the mean of one sample more. Only at the start: where it is no call, the compiler divides at
    /// every sample and throws the quotient away.
    #[cold]
    #[inline(never)]
    fn next_gain(gain: T) -> T {
        gain / (T::ONE + gain)
    }

    /// |H|² at `angle` rad a sample once the memory is full: mean = g·x/(1 − (1−g)q⁻¹),
    /// so H = (1−g)(1 − q⁻¹)/(1 − (1−g)q⁻¹).
    fn power_gain(&self, angle: f64) -> f64 {
        let kept = 1.0 - self.last_gain.to_f64();
        let squared = |r: f64| 1.0 - 2.0 * r * libm::cos(angle) + r * r;
        kept * kept * squared(1.0) / squared(kept)
    }
}

/// Decimation factors of the stages, those that do nothing behind the others: the last one 2 (the
/// sharp one), those before it at most 8 each, their product as large as the band allows.
fn split(fs: f64, high_hz: f64) -> [usize; STAGES] {
    let total = (fs / (RATE_PER_EDGE * high_hz) + 1e-9) as usize;
    if total < 2 {
        return [1; STAGES];
    }
    if total == 3 {
        return [3, 1, 1, 1];
    }
    let target = total / 2;
    let mut best = [1, 1, 1];
    for a in 1..=8usize {
        for b in a..=8 {
            for c in b..=8 {
                let reach: usize = best.iter().product();
                if a * b * c <= target && a * b * c > reach {
                    best = [c, b, a];
                }
            }
        }
    }
    let mut factors = [1; STAGES];
    let sharp = [2];
    let active = best.iter().filter(|m| **m > 1).chain(&sharp);
    for (factor, m) in factors.iter_mut().zip(active) {
        *factor = *m;
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_split_into_short_stages() {
        assert_eq!(split(48_000.0, 2500.0), [4, 2, 1, 1]);
        assert_eq!(split(192_000.0, 2500.0), [8, 2, 2, 1]);
        assert_eq!(split(6000.0, 2500.0), [1; 4]);
        assert_eq!(split(20_000.0, 2500.0), [3, 1, 1, 1]);
        assert_eq!(split(48_000.0, 20.0), [8, 8, 7, 2]);
    }

    #[test]
    fn tone_in_the_band_keeps_its_amplitude() {
        for fs in [6000.0, 8000.0, 44_100.0, 48_000.0, 192_000.0] {
            let mut filter = BandFilter::<f64>::new(Band::usual(fs), fs).unwrap();
            let mut peak = 0.0f64;
            for n in 0..(fs as usize) {
                let x = 5.0 + (2.0 * core::f64::consts::PI * 980.0 * n as f64 / fs).sin();
                if let Some(y) = filter.process(x)
                    && n as f64 > 0.5 * fs
                {
                    peak = peak.max(y.abs());
                }
            }
            assert!((0.97..1.02).contains(&peak), "peak {peak} at {fs} Hz");
        }
    }

    #[test]
    fn gain_is_that_of_a_tone_sent_through() {
        for (band, fs) in [
            (Band::usual(48_000.0), 48_000.0),
            (Band::usual(8000.0), 8000.0),
            (
                Band {
                    low_hz: 20.0,
                    high_hz: 400.0,
                },
                44_100.0,
            ),
            (
                Band {
                    low_hz: 1.0,
                    high_hz: 50.0,
                },
                1000.0,
            ),
        ] {
            for part in [0.0, 0.02, 0.3, 0.9, 1.0] {
                let f = band.low_hz + part * (band.high_hz - band.low_hz);
                let mut filter = BandFilter::<f64>::new(band, fs).unwrap();
                let rate = fs / filter.factor() as f64;
                let turn = 2.0 * core::f64::consts::PI * f;
                let (mut re, mut im, mut m) = (0.0, 0.0, 0.0);
                // Whole periods of the tone, to a sample, after it has settled.
                let (from, until) = (2.0, 2.0 + libm::floor(4.0 * f) / f);
                let mut k = 0.0;
                for n in 0..(until * fs) as usize {
                    let x = libm::sin(turn * n as f64 / fs);
                    let Some(y) = filter.process(x) else { continue };
                    k += 1.0;
                    if k / rate >= from {
                        re += y * libm::cos(turn * k / rate);
                        im += y * libm::sin(turn * k / rate);
                        m += 0.5;
                    }
                }
                let told = filter.power_gain(f, fs);
                let found = (re * re + im * im) / (m * m);
                assert!(
                    (found / told - 1.0).abs() < 0.005,
                    "{found} {told} at {f} of {fs} Hz"
                );
                // 3 dB at the lower edge, and less above it; at 1 Hz the offset takes its part.
                if band.low_hz > 10.0 {
                    let droop = if part == 0.0 { 0.45..0.56 } else { 0.56..1.03 };
                    assert!(droop.contains(&told), "{told} at {f} of {fs} Hz");
                }
            }
        }
    }

    #[test]
    fn bands_that_do_not_fit_are_refused_by_name() {
        let band = |low_hz, high_hz| Band { low_hz, high_hz };
        assert_eq!(
            band(300.0, 2500.0).check(4000.0),
            Err(BandError::RateTooLow { highest_hz: 1800.0 })
        );
        assert_eq!(band(300.0, 200.0).check(4e4), Err(BandError::Edges));
        assert_eq!(band(f64::NAN, 200.0).check(4e4), Err(BandError::Edges));
        assert_eq!(
            band(1.0, 2500.0).check(4e4),
            Err(BandError::TooWide { lowest_hz: 10.0 })
        );
        assert_eq!(band(1.0, 2.0).check(0.0), Err(BandError::Rate));
        assert!(Band::usual(12.0).check(12.0).is_ok());
    }
}
