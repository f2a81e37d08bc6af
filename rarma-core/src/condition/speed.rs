//! The speed of the spindle as the sound shows it: the spacing of a comb of lines.
//!
//! Rate: [`SpeedFinder::push`] once a decimated sample, a bounded amount of work each
//! time; an answer every cycle of listening and searching (about 0.6 s at 6 kHz with a
//! told speed, 1 s without). Words: *told speed*, what the operator or the controller
//! says; *background*, the level between the lines of a spectrum.

use super::band::Band;
use super::comb::{Multiples, Peak, Peaks, Score};
use super::sliced_fft::SlicedFft;
use crate::real::Real;

/// Complex points of the transform: 2048 samples.
const HALF: usize = 1024;
/// Samples a spectrum is made of.
pub const FRAME: usize = 2 * HALF;
/// Work per call: butterflies, pairs of bins, bins looked at for a peak.
const BUTTERFLIES: usize = 16;
const PAIRS: usize = 4;
const BINS: usize = 2;
/// The background at a bin: this quantile of the bins so far to both sides.
const REACH: usize = 24;
const QUANTILE: f64 = 0.3;
/// Power of a peak over the background. 0.3 of noise lies below 0.36 of its mean,
/// and 8 in 10 000 of it above 20 times that.
const PEAK_RATIO: f64 = 20.0;
/// Beside a peak this much stronger, within so many bins, there is none: skirts of
/// the window (−31 dB) and of a speed that wanders.
const SKIRT: (usize, f64) = (4, 250.0);
const FAR_SKIRT: (usize, f64) = (12, 10_000.0);
/// Search around a told speed, as a fraction.
pub const TOLD_RANGE: f64 = 0.03;
/// Spacings that are sought where nothing is told, Hz.
pub const SPACING_HZ: (f64, f64) = (15.0, 1000.0);
/// Least spacing the window can resolve, bins.
const LEAST_SPACING_BINS: f64 = 5.0;
/// Chance by which a speed near the told one may be one of random lines.
pub const CHANCE_TOLD: f64 = 1e-3;
/// Chance by which a spacing nobody told may be one of random lines.
pub const CHANCE_BLIND: f64 = 1e-3;
/// Two answers in a row that nobody told agree within this fraction, or there is none.
const AGREE: f64 = 0.015;
/// Most candidates that are counted, ln.
const LN_MANY: f64 = 16.0;

/// What [`SpeedFinder`] is to look for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedFinderConfig {
    /// Rate of the (decimated) samples, Hz.
    pub fs_hz: f64,
    /// Where lines are looked for.
    pub band: Band,
    /// Told speed of the spindle, Hz; none: any spacing.
    pub told_hz: Option<f64>,
    /// Teeth, where known: their lines alone may prove a told speed.
    pub teeth: Option<u32>,
}

/// Lines at multiples of one frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comb<T> {
    /// Spacing, Hz: the spindle's frequency where it was told; else that of the
    /// spindle or of its teeth, whichever the sound shows.
    pub spacing_hz: T,
    /// Standard deviation of it, Hz.
    pub sd_hz: T,
    /// Lines found on multiples.
    pub lines: u32,
    /// Upper bound on the chance that random lines look like it.
    pub chance: T,
}

/// Answer of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding<T> {
    /// The lines, if any, tell no speed.
    NotEstimable,
    /// A comb; at the told speed, if one was told.
    Found(Comb<T>),
    /// A comb, found twice in a row, and it is not that of the told speed.
    Contradiction {
        /// What was told, Hz.
        told_hz: T,
        /// Spacing of the comb that is there, Hz.
        found_hz: T,
    },
}

/// Why there is no finder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeedFinderError {
    /// The sampling rate must be positive and finite.
    Rate,
    /// Band edges must be positive, in order, and below half the rate.
    Band,
    /// The told speed must be positive, at least 5 bins of the spectrum
    /// (5·fs/2048) and below the upper band edge.
    Told,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Collect,
    Transform,
    Unpack,
    Peaks,
    Told,
    Blind,
}

/// Finds the spacing of the lines in a sound, a little work per sample.
///
/// 2048 samples are weighted by a Hann window and transformed; a bin that is the
/// largest of five and 13 dB above the 0.3 quantile of its 48 neighbours is a line, its
/// frequency refined by the ratio to its larger neighbour. Every line and every
/// multiple it may be proposes a spacing; a spacing is judged by the chance that so
/// many of the strongest lines lie within 0.4 bins of its multiples
/// (union bound over the binomial), times the number of spacings tried. Half the true spacing has
/// twice the chance per line and so is less likely, unless it explains more.
///
/// The hits must scatter little about a line through the origin:
/// chatter with sidebands a turn apart is no comb.
///
/// With a told speed only ±[`TOLD_RANGE`] around it is searched, and two lines may do;
/// without, three lines are needed, on at least 0.3 of the multiples they span, and two
/// answers that agree: one or two tones are never a comb. Three and more overtones of
/// a chatter below a third of the upper band edge are one, by themselves: only a told
/// speed or a tacho can tell.
///
/// While it searches it does not listen. The speed must hold still for the frame
/// (0.34 s at 6 kHz): a line that moves by more than about 3 bins is not seen.
///
/// ```
/// use rarma_core::condition::{Band, Finding, SpeedFinder, SpeedFinderConfig};
/// let mut finder = SpeedFinder::<f32>::new(&SpeedFinderConfig {
///     fs_hz: 6000.0,
///     band: Band { low_hz: 300.0, high_hz: 2500.0 },
///     told_hz: Some(75.0),
///     teeth: Some(5),
/// }).unwrap();
/// let mut noise = 1u32;
/// let found = (0..6000).find_map(|n| {
///     noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     let t = n as f32 / 6000.0;
///     let teeth: f32 = [5.0, 10.0, 15.0, 20.0].iter()
///         .map(|k| (6.283185 * (76.4 * k * t).fract()).sin())
///         .sum();
///     finder.push(teeth + (noise >> 8) as f32 / 8_388_608.0 - 1.0)
/// });
/// let Some(Finding::Found(comb)) = found else { panic!() };
/// assert!((comb.spacing_hz - 76.4).abs() < 0.05);
/// ```
#[derive(Debug, Clone)]
pub struct SpeedFinder<T> {
    fft: SlicedFft<T, HALF>,
    peaks: Peaks<T>,
    phase: Phase,
    at: usize,
    /// Bins of the band, first and one past the last.
    bins: (usize, usize),
    bin_hz: T,
    told: Option<T>,
    teeth: Option<u32>,
    /// Spacings sought blindly, bins.
    range: (T, T),
    /// The candidate: which peak, which multiple.
    generator: usize,
    multiple: u32,
    tried: u32,
    best: Option<Score<T>>,
    previous: Option<T>,
    last: Finding<T>,
}

impl<T: Real> SpeedFinder<T> {
    /// A finder that has heard nothing.
    ///
    /// # Errors
    /// See [`SpeedFinderError`].
    pub fn new(config: &SpeedFinderConfig) -> Result<Self, SpeedFinderError> {
        let fs = config.fs_hz;
        if !(fs.is_finite() && fs > 0.0) {
            return Err(SpeedFinderError::Rate);
        }
        let Band { low_hz, high_hz } = config.band;
        if !(low_hz > 0.0 && low_hz < high_hz && high_hz < 0.5 * fs) {
            return Err(SpeedFinderError::Band);
        }
        let bin = fs / FRAME as f64;
        let mut finder = Self {
            fft: SlicedFft::default(),
            peaks: Peaks::default(),
            phase: Phase::Collect,
            at: 0,
            bins: (
                ((low_hz / bin) as usize).max(3),
                ((high_hz / bin) as usize).min(HALF - 3),
            ),
            bin_hz: T::from_f64(bin),
            told: None,
            teeth: config.teeth.filter(|z| *z > 1),
            range: (
                T::from_f64((SPACING_HZ.0 / bin).max(LEAST_SPACING_BINS)),
                T::from_f64(SPACING_HZ.1 / bin),
            ),
            generator: 0,
            multiple: 1,
            tried: 0,
            best: None,
            previous: None,
            last: Finding::NotEstimable,
        };
        finder.tell(config.told_hz.map(T::from_f64))?;
        Ok(finder)
    }

    /// Another told speed, Hz, or none; what was found before is forgotten. Slow path.
    ///
    /// # Errors
    /// [`SpeedFinderError::Told`]; nothing has changed then.
    pub fn tell(&mut self, told_hz: Option<T>) -> Result<(), SpeedFinderError> {
        if let Some(told) = told_hz {
            let least = self.bin_hz * T::from_f64(LEAST_SPACING_BINS);
            let most = self.bin_hz * T::from_u32(self.bins.1 as u32);
            if !(told >= least && told <= most) {
                return Err(SpeedFinderError::Told);
            }
        }
        self.told = told_hz.map(|told| told / self.bin_hz);
        self.reset();
        Ok(())
    }

    /// Forgets the samples and the answers.
    pub fn reset(&mut self) {
        self.phase = Phase::Collect;
        self.at = 0;
        self.previous = None;
        self.last = Finding::NotEstimable;
    }

    /// Answer of the last cycle.
    pub fn last(&self) -> Finding<T> {
        self.last
    }

    /// Lines of the last spectrum, the strongest first: frequency, Hz, and power,
    /// input units squared times an arbitrary factor.
    pub fn lines(&self) -> impl Iterator<Item = (T, T)> + '_ {
        let bin = self.bin_hz;
        let peaks = self.peaks.as_slice().iter();
        peaks.map(move |p| (p.bin * bin, p.power))
    }

    /// Takes a sample; gives an answer at the end of a cycle. A sample that is no
    /// number starts the frame anew.
    #[inline]
    pub fn push(&mut self, y: T) -> Option<Finding<T>> {
        match self.phase {
            Phase::Collect => self.collect(y),
            Phase::Transform => {
                if self.fft.transform(BUTTERFLIES) {
                    self.phase = Phase::Unpack;
                }
            }
            Phase::Unpack => {
                if self.fft.unpack(PAIRS) {
                    self.phase = Phase::Peaks;
                    self.peaks.clear();
                    self.at = self.bins.0;
                }
            }
            Phase::Peaks => self.look_for_peaks(),
            Phase::Told => return self.search_told(),
            Phase::Blind => return self.search_blind(),
        }
        None
    }

    fn collect(&mut self, y: T) {
        if !y.is_finite() {
            self.at = 0;
            return;
        }
        let angle = T::from_f64(core::f64::consts::TAU / FRAME as f64);
        // The angle from −π to π, where sine and cosine are most exact.
        let (_, c) = ((T::from_u32(self.at as u32) + T::from_f64(0.5)) * angle - T::PI).sin_cos();
        self.fft.put(self.at, y * (T::ONE + c) * T::from_f64(0.5));
        self.at += 1;
        if self.at >= FRAME {
            self.phase = Phase::Transform;
        }
    }

    /// Looks at [`BINS`] bins; of two in a row only one can be a peak.
    fn look_for_peaks(&mut self) {
        for _ in 0..BINS {
            if self.at >= self.bins.1 {
                self.generator = 0;
                self.tried = 0;
                self.best = None;
                self.phase = match self.told {
                    Some(_) => Phase::Told,
                    None => Phase::Blind,
                };
                self.multiple = 0;
                return;
            }
            if let Some(peak) = self.peak(self.at) {
                self.peaks.insert(peak);
            }
            self.at += 1;
        }
    }

    /// The peak at bin `k`, if there is one.
    fn peak(&self, k: usize) -> Option<Peak<T>> {
        let at = |i: usize| self.fft.power(i);
        let here = at(k);
        let (left, right) = (at(k - 1), at(k + 1));
        let largest = here > left && here >= right && here > at(k - 2) && here > at(k + 2);
        if !largest || !here.is_finite() {
            return None;
        }
        let level = here / T::from_f64(PEAK_RATIO);
        let (near, far) = (here * T::from_f64(SKIRT.1), here * T::from_f64(FAR_SKIRT.1));
        let (mut below, mut seen) = (0u32, 0u32);
        for i in k.saturating_sub(REACH).max(self.bins.0)..(k + REACH + 1).min(self.bins.1) {
            let p = at(i);
            let d = i.abs_diff(k);
            if (d <= SKIRT.0 && p > near) || (d <= FAR_SKIRT.0 && p > far) {
                return None;
            }
            seen += 1;
            below += u32::from(p < level);
        }
        if T::from_u32(below) < T::from_f64(QUANTILE) * T::from_u32(seen) {
            return None;
        }
        // Hann window: amplitudes of the two largest bins in the ratio
        // (1 + δ)/(2 − δ), δ from the larger one.
        let (side, sign) = if right > left {
            (right, T::ONE)
        } else {
            (left, -T::ONE)
        };
        let ratio = (side / here).sqrt();
        let two = T::from_f64(2.0);
        let delta = ((two * ratio - T::ONE) / (T::ONE + ratio)).clamp(T::ZERO, T::from_f64(0.5));
        Some(Peak {
            bin: T::from_u32(k as u32) + sign * delta,
            power: here,
        })
    }

    /// Next multiple of the present generator, or the first of the next one, with the
    /// spacing inside `lo..=hi`; none when all have been tried.
    fn next_candidate(&mut self, lo: T, hi: T) -> Option<(usize, T)> {
        loop {
            let peak = *self.peaks.as_slice().get(self.generator)?;
            if self.multiple == 0 {
                // Towards zero, then up: the least multiple that fits.
                self.multiple = ((peak.bin / hi).to_f32() as u32).max(1);
                if peak.bin > hi * T::from_u32(self.multiple) {
                    self.multiple += 1;
                }
            } else {
                self.multiple += 1;
            }
            let spacing = peak.bin / T::from_u32(self.multiple);
            if spacing >= lo {
                self.tried += 1;
                return Some((self.generator, spacing));
            }
            // At most once per peak and call: those without a multiple in the range
            // are passed over.
            self.generator += 1;
            self.multiple = 0;
        }
    }

    fn better(&self, score: &Score<T>) -> bool {
        self.best.is_none_or(|b| score.ln_chance < b.ln_chance)
    }

    fn search_told(&mut self) -> Option<Finding<T>> {
        let told = self.told?;
        let range = T::from_f64(TOLD_RANGE);
        let (lo, hi) = (told * (T::ONE - range), told * (T::ONE + range));
        if let Some((from, spacing)) = self.next_candidate(lo, hi) {
            let mut score = self.peaks.score(spacing, Some(from), Multiples::All);
            if let Some(teeth) = self.teeth {
                let few = self.peaks.score(spacing, Some(from), Multiples::Of(teeth));
                score.ln_chance = score.ln_chance.min(few.ln_chance + T::from_f64(2.0).ln());
            }
            if score.hits >= 2 && self.better(&score) && self.peaks.through_origin(&score) {
                self.best = Some(score);
            }
            return None;
        }
        let tried = T::from_u32(self.tried.max(1)).ln();
        let least = T::from_f64(CHANCE_TOLD).ln();
        let teeth = self.teeth;
        let proven = |best: &Score<T>| {
            best.ln_chance + tried < least
                && !self.peaks.rests_on_overtones(best, teeth, least)
                && self.peaks.agrees_with_distances(best)
        };
        if let Some(best) = self.best.filter(proven) {
            let comb = self.comb(&best, tried);
            return Some(self.answer(Finding::Found(comb)));
        }
        self.generator = 0;
        self.multiple = 0;
        self.tried = 0;
        self.best = None;
        self.phase = Phase::Blind;
        None
    }

    fn search_blind(&mut self) -> Option<Finding<T>> {
        let (lo, hi) = self.range;
        if let Some((from, spacing)) = self.next_candidate(lo, hi) {
            let mut score = self.peaks.score(spacing, Some(from), Multiples::All);
            if Peaks::is_comb(&score) {
                // Spacings at least as wide that were or will be tried.
                score.ln_chance += self.wider(spacing);
                let whole =
                    self.peaks.through_origin(&score) && self.peaks.agrees_with_distances(&score);
                if self.better(&score) && whole {
                    self.best = Some(score);
                }
            }
            return None;
        }
        let least = T::from_f64(CHANCE_BLIND).ln();
        let Some(mut best) = self.best.filter(|b| b.ln_chance < least) else {
            self.previous = None;
            return Some(self.answer(Finding::NotEstimable));
        };
        best = self.peaks.refine(&best);
        best = self.peaks.split(&best, lo).unwrap_or(best);
        let agrees = self
            .previous
            .is_some_and(|before| (best.spacing - before).abs() <= before * T::from_f64(AGREE));
        self.previous = Some(best.spacing);
        if !agrees {
            return Some(self.answer(Finding::NotEstimable));
        }
        let comb = self.comb(&best, T::ZERO);
        let finding = match self.told {
            None => Finding::Found(comb),
            Some(told) => Finding::Contradiction {
                told_hz: told * self.bin_hz,
                found_hz: comb.spacing_hz,
            },
        };
        Some(self.answer(finding))
    }

    /// ln of the number of candidates with a spacing of at least `spacing`.
    fn wider(&self, spacing: T) -> T {
        let peaks = self.peaks.as_slice().iter();
        let sum: T = peaks.map(|p| p.bin / spacing).sum();
        sum.max(T::ONE).ln().min(T::from_f64(LN_MANY))
    }

    fn comb(&self, best: &Score<T>, tried: T) -> Comb<T> {
        let fine = self.peaks.refine(best);
        Comb {
            spacing_hz: fine.spacing * self.bin_hz,
            sd_hz: fine.sd * self.bin_hz,
            lines: fine.hits,
            chance: (best.ln_chance + tried).exp().min(T::ONE),
        }
    }

    fn answer(&mut self, finding: Finding<T>) -> Finding<T> {
        self.phase = Phase::Collect;
        self.at = 0;
        self.last = finding;
        finding
    }
}
