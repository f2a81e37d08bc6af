//! The speed of the spindle as the sound shows it: the spacing of a comb of lines.
//!
//! Rate: [`SpeedFinder::push`] once a decimated sample, a bounded amount of work each
//! time; an answer every cycle of listening and searching (about 0.6 s at 6 kHz with a
//! told speed, 1 s without). Words: *told speed*, what the operator or the controller
//! says.

mod comb;
mod doubt;
mod finding;
mod peaks;
mod search;
mod sliced_fft;

pub use finding::{Comb, Finding, SpeedFinderConfig, SpeedFinderError};
pub(crate) use peaks::MOST_PEAKS;
pub use sliced_fft::SlicedFft;

use crate::condition::Band;
use crate::real::Real;
use crate::visit::{choice, state};
use comb::Score;
use peaks::{Peaks, peak_at};

/// Complex points of the transform: 2048 samples.
const HALF: usize = 1024;
/// Samples a spectrum is made of.
const FRAME: usize = 2 * HALF;
/// Work per call: butterflies, pairs of bins, bins looked at for a peak.
const BUTTERFLIES: usize = 4;
const PAIRS: usize = 4;
const BINS: usize = 2;
/// Search around a told speed, as a fraction.
pub const TOLD_RANGE: f64 = 0.03;
/// Spacings that are sought where nothing is told, Hz.
const SPACING_HZ: (f64, f64) = (15.0, 1000.0);
/// Least spacing the window can resolve, bins.
const LEAST_SPACING_BINS: f64 = 5.0;
/// Chance by which a speed near the told one may be one of random lines.
pub(crate) const CHANCE_TOLD: f64 = 1e-3;
/// Chance by which a spacing nobody told may be one of random lines.
pub(crate) const CHANCE_BLIND: f64 = 1e-3;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Collect,
    Transform,
    Unpack,
    Peaks,
    Told,
    Blind,
}

choice!(Phase: Collect, Transform, Unpack, Peaks, Told, Blind);

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

state! { SpeedFinder<T> {
    fft, peaks, phase, at, told, generator, multiple, tried, best, previous, last;
    settings bins, bin_hz, teeth, range;
    where *at <= FRAME && *multiple <= HALF as u32 && *tried < 1 << 20 && *generator <= MOST_PEAKS
} }

impl<T: Real> SpeedFinder<T> {
    /// A finder that has heard nothing.
    ///
    /// # Errors
    /// See [`SpeedFinderError`].
    pub fn new(config: &SpeedFinderConfig) -> Result<Self, SpeedFinderError> {
        let mut finder = Self::BLANK;
        finder.restart(config)?;
        Ok(finder)
    }

    /// Nothing at all, until [`Self::restart`]. Every bit is 0: where it is put, no copy of
    /// it is made first.
    pub(crate) const BLANK: Self = Self {
        fft: SlicedFft::BLANK,
        peaks: Peaks::BLANK,
        phase: Phase::Collect,
        at: 0,
        bins: (0, 0),
        bin_hz: T::ZERO,
        told: None,
        teeth: None,
        range: (T::ZERO, T::ZERO),
        generator: 0,
        multiple: 0,
        tried: 0,
        best: None,
        previous: None,
        last: Finding::NotEstimable,
    };

    /// A finder that has heard nothing, as [`Self::new`] makes it, but in place: it is 9 KB,
    /// and no second one lies on the stack meanwhile.
    ///
    /// # Errors
    /// See [`SpeedFinderError`]; of no use then, until it is restarted again.
    #[inline(never)]
    pub fn restart(&mut self, config: &SpeedFinderConfig) -> Result<(), SpeedFinderError> {
        let fs = config.fs_hz;
        if !(fs.is_finite() && fs > 0.0) {
            return Err(SpeedFinderError::Rate);
        }
        let Band { low_hz, high_hz } = config.band;
        if !(low_hz > 0.0 && low_hz < high_hz && high_hz < 0.5 * fs) {
            return Err(SpeedFinderError::Band);
        }
        let bin = fs / FRAME as f64;
        // All of them by name, so that none is forgotten; the others are `tell`'s.
        let Self {
            fft,
            peaks,
            phase: _,
            at: _,
            bins,
            bin_hz,
            told: _,
            teeth,
            range,
            generator,
            multiple,
            tried,
            best,
            previous: _,
            last: _,
        } = self;
        fft.restart();
        *peaks = Peaks::BLANK;
        *bins = (
            ((low_hz / bin) as usize).max(3),
            ((high_hz / bin) as usize).min(HALF - 3),
        );
        *bin_hz = T::from_f64(bin);
        *teeth = config.teeth.filter(|z| *z > 1);
        *range = (
            T::from_f64((SPACING_HZ.0 / bin).max(LEAST_SPACING_BINS)),
            T::from_f64(SPACING_HZ.1 / bin),
        );
        (*generator, *multiple, *tried) = (0, 1, 0);
        *best = None;
        self.tell(config.told_hz.map(T::from_f64))
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

    /// Length of a frame, s: for so long a speed must hold still to be found.
    pub fn frame_s(&self) -> T {
        T::ONE / self.bin_hz
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
            if let Some(peak) = peak_at(&self.fft, self.bins, self.at) {
                self.peaks.insert(peak);
            }
            self.at += 1;
        }
    }

    fn answer(&mut self, finding: Finding<T>) -> Finding<T> {
        self.phase = Phase::Collect;
        self.at = 0;
        self.last = finding;
        finding
    }
}
