//! The lines of a spectrum: its strongest peaks, and the strongest of the first turns.

use super::frame::{FRAME, Frame};
use crate::real::Real;
use crate::visit::state;

/// Lines that may be chatter, and lines more that tell of the speed.
pub(super) const CANDIDATES: usize = 8;
pub(super) const MORE: usize = 6;
pub(super) const LINES: usize = CANDIDATES + MORE;
/// Peaks that are looked through for them.
const PEAKS: usize = 32;
/// A peak nearer than so many quarter widths to one of which it has less than this part is
/// the window's doing.
const LEAK: (usize, f64) = (5, 0.02);
/// The speed is told by lines up to this multiple of it; they stand this far over the
/// band's mean logarithm.
const FIRST_TURNS: f64 = 12.0;
const STANDS_OUT: f64 = 30.0;
/// A line with less than this part of all power tells nothing.
const FAINT: f64 = 3e-4;

/// One line of a spectrum.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SpectrumLine<T> {
    pub(super) bin: usize,
    /// Frequency, Hz.
    pub(super) f_hz: T,
    /// Power of the line, units of the spectrum.
    pub(super) power: T,
    /// It stands out of the noise.
    pub(super) visible: bool,
}

state! { SpectrumLine<T> {
    bin, f_hz, power, visible;
    where *bin < FRAME
} }

/// The strongest peaks, falling.
#[derive(Debug, Clone, Copy)]
struct Strongest<T> {
    peaks: [(usize, T); PEAKS],
    count: usize,
}

state! { Strongest<T> {
    peaks, count;
    where *count <= PEAKS
} }

impl<T: Real> Strongest<T> {
    const BLANK: Self = Self {
        peaks: [(0, T::ZERO); PEAKS],
        count: 0,
    };

    fn take(&mut self, bin: usize, power: T) {
        if self.count == PEAKS && power <= self.peaks[PEAKS - 1].1 {
            return;
        }
        let weaker = |(_, least): &(usize, T)| *least < power;
        let at = self.iter().take_while(|peak| !weaker(peak)).count();
        let Some(after) = self.peaks.get_mut(at..) else {
            return;
        };
        let mut moved = (bin, power);
        for place in after {
            core::mem::swap(place, &mut moved);
        }
        self.count = (self.count + 1).min(PEAKS);
    }

    fn iter(&self) -> impl Iterator<Item = (usize, T)> + '_ {
        self.peaks.iter().copied().take(self.count)
    }
}

/// The lines of the last spectrum: candidates first.
#[derive(Debug, Clone)]
pub(super) struct Lines<T> {
    strongest: Strongest<T>,
    first_turns: Strongest<T>,
    lines: [SpectrumLine<T>; LINES],
    count: usize,
    candidates: usize,
}

state! { Lines<T> {
    strongest, first_turns, lines, count, candidates;
    where *count <= LINES && *candidates <= CANDIDATES && *candidates <= *count
} }

impl<T: Real> Lines<T> {
    /// None.
    pub(super) const BLANK: Self = Self {
        strongest: Strongest::BLANK,
        first_turns: Strongest::BLANK,
        lines: [SpectrumLine {
            bin: 0,
            f_hz: T::ZERO,
            power: T::ZERO,
            visible: false,
        }; LINES],
        count: 0,
        candidates: 0,
    };

    pub(super) fn all(&self) -> &[SpectrumLine<T>] {
        &self.lines[..self.count.min(LINES)]
    }

    pub(super) fn candidates(&self) -> &[SpectrumLine<T>] {
        &self.lines[..self.candidates.min(CANDIDATES)]
    }

    pub(super) fn begin(&mut self) {
        self.strongest.count = 0;
        self.first_turns.count = 0;
    }

    /// Looks for peaks among some bins; `turn_hz` is the speed, where one is known.
    pub(super) fn scan(&mut self, frame: &Frame<T>, from: usize, to: usize, turn_hz: Option<T>) {
        let first = turn_hz.map_or(T::ZERO, |hz| hz * T::from_f64(FIRST_TURNS));
        let (mut before, mut p) = (frame.power(from - 1), frame.power(from));
        for k in from..to.min(frame.bins.1) {
            let after = frame.power(k + 1);
            if p > before && p >= after {
                self.strongest.take(k, p);
                if T::from_u32(k as u32) * frame.bin_hz < first {
                    self.first_turns.take(k, p);
                }
            }
            (before, p) = (p, after);
        }
    }

    /// Takes a peak, unless a line has it already.
    fn add(&mut self, frame: &Frame<T>, bin: usize, p: T, floor: T) {
        if is_apart(self.all(), frame, bin, p)
            && let Some(place) = self.lines.get_mut(self.count)
        {
            *place = line(frame, bin, floor);
            self.count += 1;
        }
    }

    /// Picks the lines among the peaks.
    pub(super) fn pick(&mut self, frame: &Frame<T>) {
        self.count = 0;
        let floor = frame.mean_ln.exp() * T::from_f64(STANDS_OUT);
        let strongest = self.strongest;
        for (bin, p) in strongest.iter() {
            if self.count == CANDIDATES {
                break;
            }
            self.add(frame, bin, p, floor);
        }
        self.candidates = self.count;
        let first_turns = self.first_turns;
        for (bin, p) in first_turns.iter() {
            if self.count >= self.candidates + MORE || p <= floor {
                break;
            }
            self.add(frame, bin, p, floor);
        }
    }
}

/// A peak is no part of a line that is picked already, nor its window's doing.
fn is_apart<T: Real>(picked: &[SpectrumLine<T>], frame: &Frame<T>, bin: usize, p: T) -> bool {
    picked.iter().all(|other| {
        let apart = bin.abs_diff(other.bin);
        let near = 2 * apart < LEAK.0 * frame.half;
        apart > frame.half && !(near && p < frame.power(other.bin) * T::from_f64(LEAK.1))
    })
}

/// The line at a peak; its frequency by a parabola through the logarithms.
fn line<T: Real>(frame: &Frame<T>, bin: usize, floor: T) -> SpectrumLine<T> {
    let half = T::from_f64(0.5);
    let ln = |k: usize| (frame.power(k) + T::from_f64(1e-30)).ln();
    let (a, b, c) = (ln(bin - 1), ln(bin), ln(bin + 1));
    let bend = a - b - b + c;
    let off = if bend < T::from_f64(-1e-6) {
        (half * (a - c) / bend).clamp(-half, half)
    } else {
        T::ZERO
    };
    let power = frame.line_power(bin).min(frame.total);
    SpectrumLine {
        bin,
        f_hz: (T::from_u32(bin as u32) + off) * frame.bin_hz,
        power,
        visible: frame.power(bin) > floor && power > frame.total * T::from_f64(FAINT),
    }
}
