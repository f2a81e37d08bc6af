//! The short-time spectrum: a window of samples every [`HOP_S`], its power, its level at
//! idle.
//!
//! Rate: a slice of the work once a decimated sample.

use crate::condition::SlicedFft;
use crate::real::Real;
use crate::visit::{State, StateVisitor, state};

/// Complex points of the transform.
pub(super) const HALF: usize = 1024;
/// Samples that are kept.
pub(super) const FRAME: usize = 2 * HALF;
/// Between two windows, s.
pub const HOP_S: f64 = 0.05;
/// Length of the window at 6 kHz, s; at other rates it goes with the root of the period,
/// half way between the same time and the same number of samples.
const WINDOW_S: f64 = 0.25;
const WINDOW_AT_HZ: f64 = 6000.0;
/// Parts of the window in which a line's power is looked at.
pub(super) const SEGMENTS: usize = 16;
/// The band that is looked at, as parts of the rate.
pub(super) const BAND: (f64, f64) = (0.012, 0.48);
/// Smoothing of the spectrum whose least is idle, s.
const SMOOTH_S: f64 = 0.3;
/// The level at idle rises by this part of itself in a hop, so that it is learnt anew in
/// minutes.
const RISE: f64 = 0.0005;
/// The level at idle begins so long after the first window, s.
const SETTLED_S: f64 = 0.2;
/// Half the width of a line, in units of one over the window.
const HALF_LINE: f64 = 2.0;
/// Work of one slice.
const PUT: usize = 16;
const BUTTERFLIES: usize = 4;
const PAIRS: usize = 8;
const BINS: usize = 16;
/// Slices of the transform, and of what makes it powers.
const TRANSFORMED: usize = (SlicedFft::<f32, HALF>::BUTTERFLIES).div_ceil(BUTTERFLIES);
const UNPACKED: usize = (HALF / 2 + 1).div_ceil(PAIRS);

/// What is being done, and from where on: sample, slice, slice, bin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Fill(usize),
    Transform(usize),
    Unpack(usize),
    Smooth(usize),
    /// Not the first, which would make a blank verdict all zeros: the compiler (1.96) then makes its 30 KB on
    /// the stack of whoever starts a box, where it copies what is not from the flash to its place.
    Done,
}

impl Phase {
    /// As two numbers: which, and where in it.
    fn numbers(self) -> (u8, usize) {
        match self {
            Self::Fill(at) => (0, at),
            Self::Transform(at) => (1, at),
            Self::Unpack(at) => (2, at),
            Self::Smooth(at) => (3, at),
            Self::Done => (4, 0),
        }
    }

    /// What it looks at is there; `bins` are those of the band.
    fn is_within(self, bins: (usize, usize)) -> bool {
        match self {
            Self::Fill(at) => at < FRAME,
            Self::Transform(at) => at < TRANSFORMED,
            Self::Unpack(at) => at < UNPACKED,
            Self::Smooth(at) => at >= bins.0 && at <= bins.1,
            Self::Done => true,
        }
    }
}

impl<T: Real> State<T> for Phase {
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        let mut numbers = self.numbers();
        if !State::<T>::visit_state(&mut numbers, visitor) {
            return false;
        }
        let at = numbers.1;
        let all = [
            Self::Fill(at),
            Self::Transform(at),
            Self::Unpack(at),
            Self::Smooth(at),
            Self::Done,
        ];
        let there = all.iter().find(|phase| phase.numbers() == numbers);
        *self = there.copied().unwrap_or(Self::Done);
        there.is_some()
    }
}

/// Samples, and the power spectrum of the last window.
#[derive(Debug, Clone)]
pub(super) struct Frame<T> {
    ring: [T; FRAME],
    /// Where the next sample goes, and the first sample of the window that is worked on.
    next: usize,
    from: usize,
    fft: SlicedFft<T, HALF>,
    smooth: [T; HALF],
    idle: [T; HALF],
    phase: Phase,
    /// Cosine and sine of the window, and their step.
    turn: (T, T),
    step: (T, T),
    /// Windows so far, and from which on idle is learnt.
    windows: u32,
    settled: u32,
    /// Samples of the window; bins of the band, first and one past the last.
    pub(super) window: usize,
    pub(super) bins: (usize, usize),
    pub(super) bin_hz: T,
    /// Half the width of a line, bins.
    pub(super) half: usize,
    pub(super) hop: usize,
    gain: T,
    /// Power of the band, and the mean logarithm of its bins.
    pub(super) total: T,
    pub(super) mean_ln: T,
    sum_ln: T,
    sum: T,
}

state! { Frame<T> {
    ring, next, from, fft, smooth, idle, phase, turn, windows, total, mean_ln, sum_ln, sum;
    settings step, settled, window, bins, bin_hz, half, hop, gain;
    where *next < FRAME && *from < FRAME && phase.is_within(*bins)
} }

impl<T: Real> Frame<T> {
    /// Zeros, until [`Self::restart`].
    pub(super) const BLANK: Self = Self {
        ring: [T::ZERO; FRAME],
        next: 0,
        from: 0,
        fft: SlicedFft::BLANK,
        smooth: [T::ZERO; HALF],
        idle: [T::ZERO; HALF],
        phase: Phase::Done,
        turn: (T::ZERO, T::ZERO),
        step: (T::ZERO, T::ZERO),
        windows: 0,
        settled: 0,
        window: 0,
        bins: (0, 0),
        bin_hz: T::ZERO,
        half: 0,
        hop: 0,
        gain: T::ZERO,
        total: T::ZERO,
        mean_ln: T::ZERO,
        sum_ln: T::ZERO,
        sum: T::ZERO,
    };

    /// Forgets everything, and takes samples of this rate, in place: it is 25 KB.
    #[inline(never)]
    pub(super) fn restart(&mut self, fs_hz: f64) {
        let hop = ((HOP_S * fs_hz) as usize).max(4);
        let wished = WINDOW_S * (WINDOW_AT_HZ * fs_hz).sqrt();
        // While a window is worked on, new samples come.
        let window = ((wished as usize).min(FRAME - hop) / SEGMENTS).max(4) * SEGMENTS;
        let bin_hz = fs_hz / FRAME as f64;
        let (s, c) = T::from_f64(core::f64::consts::TAU / (window - 1) as f64).sin_cos();
        let bin = |part: f64| (part * fs_hz / bin_hz) as usize;
        // All of them by name, so that none is forgotten.
        let Self {
            ring,
            next,
            from,
            fft,
            smooth,
            idle,
            phase,
            turn,
            step,
            windows,
            settled,
            window: samples,
            bins,
            bin_hz: bin_width,
            half,
            hop: between,
            gain,
            total,
            mean_ln,
            sum_ln,
            sum,
        } = self;
        ring.fill(T::ZERO);
        fft.restart();
        smooth.fill(T::ZERO);
        idle.fill(T::ZERO);
        *phase = Phase::Done;
        *turn = (T::ONE, T::ZERO);
        *step = (c, s);
        (*next, *from, *windows) = (0, 0, 0);
        *settled = (SETTLED_S / HOP_S) as u32;
        *samples = window;
        *bins = (bin(BAND.0) + 1, bin(BAND.1));
        *bin_width = T::from_f64(bin_hz);
        *half = ((HALF_LINE * FRAME as f64 / window as f64).round() as usize).max(1);
        *between = hop;
        *gain = T::from_f64((HOP_S / SMOOTH_S).min(1.0));
        for x in [total, mean_ln, sum_ln, sum] {
            *x = T::ZERO;
        }
    }

    /// One over the window's length, Hz: how far apart lines are told from each other.
    pub(super) fn resolution_hz(&self) -> T {
        self.bin_hz * T::from_f64(FRAME as f64 / self.window as f64)
    }

    #[inline(always)]
    pub(super) fn push(&mut self, x: T) {
        // One bad sample would spoil the belief for ever.
        let x = if x.is_finite() { x } else { T::ZERO };
        self.ring[self.next & (FRAME - 1)] = x;
        self.next = (self.next + 1) & (FRAME - 1);
    }

    /// Sample `i` of the window that is worked on.
    #[inline(always)]
    pub(super) fn sample(&self, i: usize) -> T {
        self.ring[(self.from + i) & (FRAME - 1)]
    }

    /// The last samples become the window.
    pub(super) fn begin(&mut self) {
        self.from = (self.next + FRAME - self.window) & (FRAME - 1);
        self.turn = (T::ONE, T::ZERO);
        self.sum = T::ZERO;
        self.sum_ln = T::ZERO;
        self.phase = Phase::Fill(0);
    }

    /// Slices of work from [`Self::begin`] to the end, at most.
    pub(super) fn slices() -> usize {
        FRAME / PUT + TRANSFORMED + UNPACKED + HALF / BINS + 7
    }

    /// So many slices; how many are left over once the spectrum is ready.
    pub(super) fn work(&mut self, mut slices: usize) -> Option<usize> {
        while slices > 0 && self.phase != Phase::Done {
            // Those of one kind in one go.
            let (used, next) = match self.phase {
                Phase::Fill(at) => self.fill(at, slices),
                Phase::Transform(at) => {
                    let used = slices.min(TRANSFORMED.saturating_sub(at));
                    self.fft.transform(BUTTERFLIES * used);
                    let next = at + used;
                    let is_over = next >= TRANSFORMED;
                    let unpack = Phase::Unpack(0);
                    (
                        used,
                        if is_over {
                            unpack
                        } else {
                            Phase::Transform(next)
                        },
                    )
                }
                Phase::Unpack(at) => {
                    let used = slices.min(UNPACKED.saturating_sub(at));
                    self.fft.unpack(PAIRS * used);
                    let next = at + used;
                    let is_over = next >= UNPACKED;
                    let smooth = Phase::Smooth(self.bins.0);
                    (used, if is_over { smooth } else { Phase::Unpack(next) })
                }
                Phase::Smooth(at) => (1, self.smooth(at)),
                Phase::Done => (slices, Phase::Done),
            };
            slices = slices.saturating_sub(used);
            self.phase = next;
        }
        (self.phase == Phase::Done).then_some(slices)
    }

    fn fill(&mut self, at: usize, slices: usize) -> (usize, Phase) {
        let half = T::from_f64(0.5);
        let used = slices.min(FRAME.saturating_sub(at).div_ceil(PUT));
        let end = (at + PUT * used).min(FRAME);
        for i in at..end {
            if i < self.window {
                let (c, s) = self.turn;
                self.fft.put(i, self.sample(i) * (half - half * c));
                let (dc, ds) = self.step;
                self.turn = (c * dc - s * ds, s * dc + c * ds);
            } else {
                self.fft.put(i, T::ZERO);
            }
        }
        let next = if end < FRAME {
            Phase::Fill(end)
        } else {
            Phase::Transform(0)
        };
        (used, next)
    }

    fn smooth(&mut self, at: usize) -> Phase {
        let end = (at + BINS).min(self.bins.1);
        let (least, most) = (T::from_f64(1e-30), T::from_f64(1e30));
        let mut product = T::ONE;
        for k in at..end {
            let p = self.fft.power(k);
            self.sum += p;
            // The logarithm of a product, taken when the next factor would leave the range.
            let next = product * (p + least);
            product = if next > least && next < most {
                next
            } else {
                self.sum_ln += product.ln();
                p + least
            };
            let smooth = &mut self.smooth[k & (HALF - 1)];
            let idle = &mut self.idle[k & (HALF - 1)];
            *smooth = if self.windows == 0 {
                p
            } else {
                *smooth + self.gain * (p - *smooth)
            };
            if self.windows == self.settled {
                *idle = *smooth;
            } else if self.windows > self.settled {
                *idle = (*idle * T::from_f64(1.0 + RISE)).min(*smooth);
            }
        }
        self.sum_ln += product.ln();
        if end < self.bins.1 {
            return Phase::Smooth(end);
        }
        self.total = self.sum + least;
        self.mean_ln = self.sum_ln / T::from_u32((self.bins.1 - self.bins.0) as u32);
        self.windows = self.windows.saturating_add(1);
        Phase::Done
    }

    /// Room for work on a spectrum that is ready, until the next window begins.
    pub(super) fn desk(&mut self) -> &mut [(T, T); HALF] {
        self.fft.seconds()
    }

    /// Power of a bin of the band; none outside.
    #[inline(always)]
    pub(super) fn power(&self, bin: usize) -> T {
        if bin >= self.bins.0 && bin < self.bins.1 {
            self.fft.power(bin)
        } else {
            T::ZERO
        }
    }

    /// Power of the line at a bin.
    pub(super) fn line_power(&self, bin: usize) -> T {
        let mut sum = T::ZERO;
        for k in bin.saturating_sub(self.half)..=bin + self.half {
            sum += self.power(k);
        }
        sum
    }

    /// The least level is learnt.
    pub(super) fn learns_idle(&self) -> bool {
        self.windows > self.settled
    }

    /// Level of a line of this power over what was there at idle, dB, where that is known.
    pub(super) fn over_idle_db(&self, bin: usize, power: T) -> Option<T> {
        if !self.learns_idle() {
            return None;
        }
        Some(decibel(power / self.line_of(&self.idle, bin)))
    }

    /// Power of the line at `f_hz`, averaged over [`SMOOTH_S`], over what was there at idle, where
    /// that is known. Unlike [`Self::power`] it can be asked for while a window is worked on.
    pub(super) fn smooth_over_idle(&self, f_hz: T) -> Option<T> {
        let bin = (f_hz / self.bin_hz).min(T::from_u32(HALF as u32));
        let bin = bin.round().to_f32() as usize;
        self.learns_idle()
            .then(|| self.line_of(&self.smooth, bin) / self.line_of(&self.idle, bin))
    }

    /// Power of the line at a bin of a spectrum that is kept.
    fn line_of(&self, spectrum: &[T; HALF], bin: usize) -> T {
        let mut sum = T::from_f64(1e-30);
        for k in bin.saturating_sub(self.half)..=bin + self.half {
            if k >= self.bins.0 && k < self.bins.1 {
                sum += spectrum[k & (HALF - 1)];
            }
        }
        sum
    }
}

/// 10·lg of a ratio of powers.
pub(super) fn decibel<T: Real>(ratio: T) -> T {
    (ratio + T::from_f64(1e-30)).ln() * T::from_f64(10.0 / core::f64::consts::LN_10)
}
