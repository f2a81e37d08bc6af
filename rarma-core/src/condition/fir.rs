//! One decimation stage: a linear-phase low-pass whose output is kept every m-th
//! sample. Rate: once an input sample, the products only once an output sample.

use crate::real::Real;
use crate::visit::state;

/// Longest filter of one stage.
const MAX_TAPS: usize = 64;
/// Half of them, and parts as long as that in the room for samples.
const HALF: usize = MAX_TAPS / 2;
const ROOM: usize = 3;
/// Stop-band attenuation the filters are designed for, dB.
const STOP_DB: f64 = 60.0;

/// A decimation stage; the identity where `factor` is 1.
#[derive(Debug, Clone)]
pub(crate) struct FirStage<T> {
    /// The first half of them and the one in the middle: they are symmetric.
    taps: [T; HALF],
    /// Samples in their order, the newest before `end`. Where the room ends the last ones
    /// go back to its beginning, so that a product never meets a seam.
    history: [[T; HALF]; ROOM],
    length: usize,
    end: usize,
    factor: usize,
    phase: usize,
}

state! { FirStage<T> {
    history, end, phase;
    settings taps, length, factor;
    where *end + 1 >= *length && *end <= ROOM * HALF && *phase < *factor
} }

impl<T: Real> FirStage<T> {
    /// A stage that passes everything.
    pub fn identity() -> Self {
        Self::IDENTITY
    }

    pub(super) const IDENTITY: Self = {
        let mut taps = [T::ZERO; HALF];
        taps[0] = T::ONE;
        Self {
            taps,
            history: [[T::ZERO; HALF]; ROOM],
            length: 1,
            end: 0,
            factor: 1,
            phase: 0,
        }
    };

    /// Low-pass for decimation by `factor` (2 and more) from rate `fs`, flat up to `pass` Hz and
    /// [`STOP_DB`] down from where it would fold onto that, `fs`/`factor` − `pass`: windowed sinc, Kaiser
    /// window. The cut-off lies half way between the two, so that every `factor`-th tap from the middle is 0.
    /// Requires 0 < pass < fs/(2·factor); the length is limited to [`MAX_TAPS`].
    pub fn design(factor: usize, fs: f64, pass: f64) -> Self {
        let pi = core::f64::consts::PI;
        let stop = fs / factor as f64 - pass;
        let width = 2.0 * pi * (stop - pass) / fs;
        let wanted = libm::ceil((STOP_DB - 7.95) / (2.285 * width)) as usize + 1;
        // Odd, so that the delay is a whole number of samples.
        let length = (wanted | 1).clamp(3, MAX_TAPS - 1);
        let beta = 0.1102 * (STOP_DB - 8.7);
        let cut = 1.0 / factor as f64; // twice the cut-off over the rate
        let middle = length / 2;
        let centre = middle as f64;
        let mut raw = [0.0f64; MAX_TAPS];
        let mut sum = 0.0;
        for (n, h) in raw[..length].iter_mut().enumerate() {
            let x = n as f64 - centre;
            let sinc = if n == middle {
                cut
            } else if n.abs_diff(middle).is_multiple_of(factor) {
                0.0
            } else {
                libm::sin(pi * cut * x) / (pi * x)
            };
            let r = x / centre;
            *h = sinc * bessel_i0(beta * libm::sqrt((1.0 - r * r).max(0.0)));
            sum += *h;
        }
        let mut taps = [T::ZERO; HALF];
        for (tap, h) in taps.iter_mut().zip(&raw[..=length / 2]) {
            *tap = T::from_f64(h / sum);
        }
        Self {
            taps,
            length,
            end: length - 1,
            factor,
            ..Self::IDENTITY
        }
    }

    /// Delay of the stage in its input samples.
    pub fn delay(&self) -> f64 {
        (self.length - 1) as f64 / 2.0
    }

    /// Input samples per output sample.
    pub(super) fn factor(&self) -> usize {
        self.factor
    }

    /// |H|² at `angle` rad an input sample. Slow path.
    pub(super) fn power_gain(&self, angle: f64) -> f64 {
        let centre = self.delay();
        let half = self.length / 2;
        // The taps are symmetric: no imaginary part about the centre, and all but it count twice.
        let taps = self.taps.iter().take(half + 1).enumerate();
        let sum: f64 = taps
            .map(|(n, h)| {
                let times = if n == half { 1.0 } else { 2.0 };
                times * h.to_f64() * libm::cos(angle * (n as f64 - centre))
            })
            .sum();
        sum * sum
    }

    /// It passes everything.
    #[inline(always)]
    pub(super) fn is_identity(&self) -> bool {
        self.length == 1
    }

    /// Takes one sample; gives one every `factor`-th time. A function of its own: the stages of a
    /// filter share its code.
    #[inline(never)]
    pub fn process(&mut self, x: T) -> Option<T> {
        for place in self.room(1)? {
            *place = x;
        }
        self.output()
    }

    /// Samples until the next output.
    #[inline(always)]
    pub(super) fn until_output(&self) -> usize {
        self.factor - self.phase
    }

    /// Places of the next `count` samples, which the caller fills: not more than there are until the
    /// next output.
    #[inline(always)]
    pub(super) fn room(&mut self, count: usize) -> Option<&mut [T]> {
        if self.end + count > ROOM * HALF {
            let kept = self.length - 1;
            // Never more than there is room for, which the copy would check else.
            let end = self.end.min(ROOM * HALF);
            let from = end.checked_sub(kept)?;
            self.history.as_flattened_mut().copy_within(from..end, 0);
            self.end = kept;
        }
        let from = self.end;
        self.end += count;
        self.phase += count;
        self.history.as_flattened_mut().get_mut(from..self.end)
    }

    /// What the stage gives once the samples of [`Self::room`] are there: every `factor`-th time.
    #[inline(always)]
    pub(super) fn output(&mut self) -> Option<T> {
        if self.phase < self.factor {
            return None;
        }
        self.phase = 0;
        self.product()
    }

    /// As [`Self::process`], a function of its own.
    #[inline(never)]
    fn product(&self) -> Option<T> {
        // The taps are symmetric: a sample and its counterpart share one.
        let samples = self.history.as_flattened();
        let samples = samples.get(self.end.checked_sub(self.length)?..self.end)?;
        let (early, rest) = samples.split_at_checked(self.length / 2)?;
        let (centre, late) = rest.split_first()?;
        let (taps, centre_tap) = self.taps.split_at_checked(self.length / 2)?;
        let mut sum = *centre_tap.first()? * *centre;
        if self.factor == 2 {
            // From the first tap on that is not 0.
            let skip = (taps.len() + 1) % 2;
            let late = late.get(..late.len().checked_sub(skip)?)?;
            Self::add_pairs::<2>(&mut sum, taps.get(skip..)?, early.get(skip..)?, late);
        } else {
            Self::add_pairs::<1>(&mut sum, taps, early, late);
        }
        Some(sum)
    }

    /// Every `STEP`-th tap, 1 or 2, times the sum of its sample and that one's counterpart.
    #[inline(always)]
    fn add_pairs<const STEP: usize>(sum: &mut T, taps: &[T], early: &[T], late: &[T]) {
        let (taps, last_taps) = taps.as_chunks::<4>();
        let (early, last_early) = early.as_chunks::<4>();
        let (first_late, late) = late.as_rchunks::<4>();
        for ((h, early), late) in taps.iter().zip(early).zip(late.iter().rev()) {
            for i in (0..4).step_by(STEP) {
                *sum += h[i] * (early[i] + late[3 - i]);
            }
        }
        let last = last_taps.iter().zip(last_early);
        let last = last.zip(first_late.iter().rev()).step_by(STEP);
        for ((h, early), late) in last {
            *sum += *h * (*early + *late);
        }
    }
}

/// Modified Bessel function of the first kind, order 0, by its series.
fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= quarter / (k * k) as f64;
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitude of the output for a unit tone at f, over whole output samples.
    fn gain(stage: &mut FirStage<f64>, fs: f64, f: f64) -> f64 {
        let mut peak = 0.0f64;
        for n in 0..20_000 {
            let x = (2.0 * core::f64::consts::PI * f * n as f64 / fs + 0.3).sin();
            if let Some(y) = stage.process(x)
                && n > 1000
            {
                peak = peak.max(y.abs());
            }
        }
        peak
    }

    #[test]
    fn passes_the_band_and_stops_what_would_fold_into_it() {
        let make = || FirStage::<f64>::design(2, 12_000.0, 2500.0);
        for f in [50.0, 1000.3, 2400.7] {
            let g = gain(&mut make(), 12_000.0, f);
            assert!((0.985..1.005).contains(&g), "gain {g} at {f} Hz");
        }
        for f in [3550.0, 4000.1, 5900.3] {
            let g = gain(&mut make(), 12_000.0, f);
            assert!((1e-7..2e-3).contains(&g), "gain {g} at {f} Hz");
        }
    }

    /// Wherever the samples lie in the room: one in a few of what the impulse response gives,
    /// which is read off a stage that keeps every sample.
    #[test]
    fn a_stage_gives_one_in_a_few_samples_of_its_convolution() {
        for (factor, fs) in [(2, 12_000.0), (2, 12_300.0), (2, 24_000.0), (4, 48_000.0)] {
            let made = FirStage::<f64>::design(factor, fs, 2500.0);
            // All taps of a stage of factor 1 are read.
            let mut whole = FirStage {
                factor: 1,
                ..made.clone()
            };
            let mut response = Vec::new();
            for n in 0..MAX_TAPS {
                response.push(whole.process(f64::from(u8::from(n == 0))).unwrap());
            }
            response.truncate(2 * made.delay() as usize + 1);
            let signal: Vec<f64> = (0..1500u32)
                .map(|n| f64::from(n.wrapping_mul(2_654_435_761)) / 4e9 - 0.5)
                .collect();
            let mut stage = made;
            let mut given = 0;
            for (n, x) in signal.iter().enumerate() {
                let Some(y) = stage.process(*x) else { continue };
                given += 1;
                let before = signal[..=n].iter().rev();
                let wanted: f64 = response.iter().zip(before).map(|(h, x)| h * x).sum();
                assert!((y - wanted).abs() < 1e-12, "{factor}, {n}: {y}, {wanted}");
            }
            assert_eq!(given, signal.len() / factor);
        }
    }
}
