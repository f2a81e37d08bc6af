//! What was heard, as the pictures of a run need it: all of a short recording, of a long
//! one its envelope and its spectra, in memory that does not grow.

use rarma_fourier::{Complex, Forward};

/// Samples up to which all are kept: 22 s at 48 kHz.
const WHOLE: usize = 1 << 20;
/// Stretches of the envelope at most; half as many at least.
const STRETCHES: usize = 1 << 16;
/// Columns of spectra at most; half as many at least.
const COLUMNS: usize = 2048;
/// Spectra averaged in a column at most.
const PIECES: u64 = 4;
/// Rows of the waterfall; its windows are chosen for them.
pub(super) const ROWS: usize = 208;
/// Shortest window that still shows more than a smear.
pub(super) const SHORTEST: usize = 32;
/// Longest window.
const LONGEST: usize = 16_384;

/// The analysed channel.
#[derive(Debug, Clone)]
pub struct Sound {
    fs: f64,
    top_hz: f64,
    /// Samples heard, and those that were kept, one stretch of them.
    heard: u64,
    samples: u64,
    /// Stretch of them that is kept.
    wanted: (u64, u64),
    /// Least and largest finite sample.
    ends: Option<(f64, f64)>,
    kept: Kept,
}

#[derive(Debug, Clone)]
enum Kept {
    Whole(Vec<f64>),
    Thin(Box<Thin>),
}

#[derive(Debug, Clone)]
struct Thin {
    envelope: Envelope,
    spectra: Spectra,
}

/// The window for a waterfall up to `top_hz` of samples of rate `fs`, at most `longest`.
pub(super) fn window(fs: f64, top_hz: f64, longest: usize) -> usize {
    // Fine enough that a row holds one bin, short enough to see the onset.
    let wanted = 1.4 * ROWS as f64 * fs / top_hz;
    let window = (wanted.clamp(SHORTEST as f64, LONGEST as f64) as usize).min(longest);
    (window + 1).next_power_of_two() / 2
}

/// Hann's window of a length, and the factor from a spectrum under it to amplitudes.
pub(crate) fn hann(window: usize) -> (Vec<f64>, f64) {
    let hann: Vec<f64> = (0..window)
        .map(|i| 0.5 - 0.5 * (std::f64::consts::TAU * (i as f64 + 0.5) / window as f64).cos())
        .collect();
    let gain = 2.0 / hann.iter().sum::<f64>();
    (hann, gain)
}

impl Sound {
    /// Nothing heard yet; of samples of rate `fs`, Hz, the band between two edges, Hz,
    /// is analysed.
    pub fn new(fs: f64, band_hz: (f64, f64)) -> Self {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let fs = if positive(fs) { fs } else { 1.0 };
        let wanted = 1.15 * band_hz.1;
        let top_hz = if positive(wanted) { wanted } else { fs };
        Self {
            fs,
            top_hz: top_hz.min(0.5 * fs),
            heard: 0,
            samples: 0,
            wanted: (0, u64::MAX),
            ends: None,
            kept: Kept::Whole(Vec::new()),
        }
    }

    /// Keeps what lies between two instants, s, and nothing else.
    pub fn within(self, (from, to): (f64, f64)) -> Self {
        let place = |t: f64| (t * self.fs).max(0.0).round() as u64;
        Self {
            wanted: (place(from), place(to)),
            ..self
        }
    }

    /// All of a recording.
    pub fn of(samples: &[f64], fs: f64, band_hz: (f64, f64)) -> Self {
        let mut sound = Self::new(fs, band_hz);
        samples.iter().for_each(|x| sound.push(*x));
        sound
    }

    /// Takes the next sample.
    pub fn push(&mut self, x: f64) {
        let (from, to) = self.wanted;
        let wanted = (from..to).contains(&self.heard);
        self.heard += 1;
        if !wanted {
            return;
        }
        self.samples += 1;
        if x.is_finite() {
            let (low, high) = self.ends.unwrap_or((x, x));
            self.ends = Some((low.min(x), high.max(x)));
        }
        match &mut self.kept {
            Kept::Whole(samples) if samples.len() < WHOLE => samples.push(x),
            Kept::Whole(samples) => {
                let mut thin = Box::new(Thin::new(self.fs, self.top_hz, mean(samples)));
                samples.iter().for_each(|x| thin.push(*x));
                thin.push(x);
                self.kept = Kept::Thin(thin);
            }
            Kept::Thin(thin) => thin.push(x),
        }
    }

    /// Samples heard, all of them.
    pub fn heard(&self) -> u64 {
        self.heard
    }

    /// Samples kept: those heard, or those of the stretch that is wanted.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// When the first of those was heard, s.
    pub(super) fn start_s(&self) -> f64 {
        self.wanted.0 as f64 / self.fs
    }

    /// Least and largest finite sample, if there is one.
    pub(super) fn ends(&self) -> Option<(f64, f64)> {
        self.ends
    }

    /// Every sample, where they are few enough.
    pub(super) fn whole(&self) -> Option<&[f64]> {
        match &self.kept {
            Kept::Whole(samples) => Some(samples),
            Kept::Thin(_) => None,
        }
    }

    /// Least and largest finite sample of those from `from` up to `to`; of a long
    /// recording, of the stretches that begin there.
    pub(super) fn between(&self, from: u64, to: u64) -> Option<(f64, f64)> {
        match &self.kept {
            Kept::Whole(samples) => {
                let finite = samples[from as usize..to as usize]
                    .iter()
                    .filter(|v| v.is_finite());
                finite.fold(None, |ends: Option<(f64, f64)>, v| {
                    let (low, high) = ends.unwrap_or((*v, *v));
                    Some((low.min(*v), high.max(*v)))
                })
            }
            Kept::Thin(thin) => thin.envelope.between(from, to),
        }
    }

    /// Of a long recording, the window of its spectra, samples, and the mean power of
    /// every frequency of it between two samples.
    pub(super) fn spectrum(&self, from: u64, to: u64) -> Option<(usize, Vec<f64>)> {
        match &self.kept {
            Kept::Whole(_) => None,
            Kept::Thin(thin) => Some((thin.spectra.window, thin.spectra.between(from, to))),
        }
    }
}

/// Mean of the finite samples.
pub(super) fn mean(samples: &[f64]) -> f64 {
    let finite = || samples.iter().copied().filter(|v| v.is_finite());
    finite().sum::<f64>() / finite().count().max(1) as f64
}

impl Thin {
    fn new(fs: f64, top_hz: f64, mean: f64) -> Self {
        Self {
            envelope: Envelope {
                step: 1,
                all: Vec::with_capacity(STRETCHES),
                open: Envelope::NONE,
                filled: 0,
            },
            spectra: Spectra::new(fs, top_hz, mean),
        }
    }

    fn push(&mut self, x: f64) {
        self.envelope.push(x as f32);
        self.spectra.push(x);
    }
}

/// Least and largest sample of stretches of equal length; where there are too many, two
/// become one.
#[derive(Debug, Clone)]
struct Envelope {
    /// Samples in a stretch.
    step: u64,
    all: Vec<(f32, f32)>,
    open: (f32, f32),
    filled: u64,
}

impl Envelope {
    /// No finite sample.
    const NONE: (f32, f32) = (f32::INFINITY, f32::NEG_INFINITY);

    fn push(&mut self, x: f32) {
        if x.is_finite() {
            self.open = (self.open.0.min(x), self.open.1.max(x));
        }
        self.filled += 1;
        if self.filled < self.step {
            return;
        }
        if self.all.len() == STRETCHES {
            halve(&mut self.all, |a, b| *a = (a.0.min(b.0), a.1.max(b.1)));
            self.step *= 2;
            // The open stretch is half of one now.
            if self.filled < self.step {
                return;
            }
        }
        self.all.push(self.open);
        (self.open, self.filled) = (Self::NONE, 0);
    }

    fn between(&self, from: u64, to: u64) -> Option<(f64, f64)> {
        let place = |at: u64| at.div_ceil(self.step) as usize;
        let inside = (place(from)..place(to).max(place(from) + 1)).filter_map(|i| {
            self.all
                .get(i)
                .or_else(|| (i == self.all.len()).then_some(&self.open))
        });
        let (low, high) = inside.fold(Self::NONE, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        (low <= high).then(|| (f64::from(low), f64::from(high)))
    }
}

/// Every two of a list become one.
pub(super) fn halve<V>(all: &mut Vec<V>, join: impl Fn(&mut V, V)) {
    let mut old = std::mem::take(all).into_iter();
    all.reserve_exact(old.len());
    while let Some(mut first) = old.next() {
        if let Some(second) = old.next() {
            join(&mut first, second);
        }
        all.push(first);
    }
}

/// Mean power spectra of columns of equal length; where there are too many, two become
/// one, and only some of the windows are analysed.
#[derive(Clone)]
struct Spectra {
    window: usize,
    hann: Vec<f64>,
    gain: f64,
    mean: f64,
    fft: Forward,
    input: Vec<f64>,
    output: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
    /// Frequencies kept of each spectrum.
    bins: usize,
    /// Windows in a column, and sum of powers with how many there are.
    length: u64,
    columns: Vec<(Box<[f32]>, u32)>,
    /// Windows begun.
    windows: u64,
    filled: usize,
}

impl std::fmt::Debug for Spectra {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Spectra")
            .field("window", &self.window)
            .field("columns", &self.columns.len())
            .finish_non_exhaustive()
    }
}

impl Spectra {
    fn new(fs: f64, top_hz: f64, mean: f64) -> Self {
        let window = window(fs, top_hz, LONGEST).max(SHORTEST);
        let (hann, gain) = hann(window);
        let fft = rarma_fourier::forward(window);
        let (output, scratch) = (fft.make_output_vec(), fft.make_scratch_vec());
        // A mode may lie a little above the band.
        let bins = (2.0 * top_hz * window as f64 / fs) as usize + 2;
        Self {
            window,
            hann,
            gain,
            mean,
            input: vec![0.0; window],
            bins: bins.min(output.len()),
            output,
            scratch,
            fft,
            length: 1,
            columns: Vec::new(),
            windows: 0,
            filled: 0,
        }
    }

    fn push(&mut self, x: f64) {
        let n = self.filled;
        self.filled += 1;
        let wanted = self.windows.is_multiple_of(self.length.div_ceil(PIECES));
        if wanted {
            self.input[n] = if x.is_finite() {
                (x - self.mean) * self.hann[n]
            } else {
                0.0
            };
        }
        if self.filled < self.window {
            return;
        }
        self.filled = 0;
        if wanted {
            self.transform();
        }
        self.windows += 1;
    }

    fn transform(&mut self) {
        let place = (self.windows / self.length) as usize;
        if place >= COLUMNS {
            halve(&mut self.columns, |(a, n), (b, m)| {
                a.iter_mut().zip(b).for_each(|(x, y)| *x += y);
                *n += m;
            });
            self.length *= 2;
            return self.transform();
        }
        if self.columns.len() <= place {
            self.columns
                .resize(place + 1, (vec![0.0; self.bins].into(), 0));
        }
        let done =
            self.fft
                .process_with_scratch(&mut self.input, &mut self.output, &mut self.scratch);
        if done.is_ok()
            && let Some((sum, count)) = self.columns.get_mut(place)
        {
            for (sum, bin) in sum.iter_mut().zip(&self.output) {
                *sum += (bin.norm_sqr() * self.gain * self.gain) as f32;
            }
            *count += 1;
        }
    }

    fn between(&self, from: u64, to: u64) -> Vec<f64> {
        let samples = self.length * self.window as u64;
        let last = self.columns.len().saturating_sub(1);
        let first = ((from / samples) as usize).min(last);
        let end = (to.div_ceil(samples) as usize).clamp(first + 1, last + 1);
        let mut power = vec![0.0; self.bins];
        let mut count = 0;
        for (sum, n) in &self.columns[first..end] {
            for (p, x) in power.iter_mut().zip(sum) {
                *p += f64::from(*x);
            }
            count += n;
        }
        power.iter_mut().for_each(|p| *p /= f64::from(count.max(1)));
        power
    }
}

#[cfg(test)]
#[path = "sound_tests.rs"]
mod tests;
