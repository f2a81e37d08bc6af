//! Stepped sine with its own lock-in: the response line by line, without keeping a record.

use super::job::{Direction, ExcitationJob};
use crate::cers::error::{CersError, within};
use crate::els::Complex;
use rarma_core::real::Real;

/// Blocks of a line; their scatter is the line's deviation.
pub const BLOCKS: u32 = 4;
/// Blocks before them, in which the structure settles.
const SETTLING: u32 = 1;
/// A block lasts at least so many cycles: the window needs them to be blind to a constant.
const LEAST_CYCLES: f32 = 4.0;
/// And so long, s: the resolution is twice its inverse.
const LEAST_BLOCK_S: f32 = 0.01;

/// Hann's window is blind to what is two of a block's inverse lengths away.
const CLEAR_BINS: f32 = 2.0;
/// Runout beyond this multiple of the speed is small.
const MOST_ORDER: f32 = 4.0;

/// Force and motion of one period.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Seen {
    /// Magnetic force of the axis that [`Source::measures`](super::Source::measures) names, N.
    pub force_n: f32,
    /// Displacement in x and y, m.
    pub displacement_m: [f32; 2],
    /// The force can be relied upon.
    pub trusted: bool,
}

/// Force and motion at one frequency over one block.
///
/// Amplitudes of e^{+jωt}, ω = 2π·f, against the phase of the commanded sine: the command is
/// the instrument, so noise on force and motion leaves no bias.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Block {
    /// Driven axis, 0 is x.
    pub axis: u8,
    /// Line, from 0, and block of it.
    pub line: u16,
    /// See [`Self::line`].
    pub block: u8,
    /// Frequency, Hz.
    pub f_hz: f32,
    /// Force of the driven axis, N.
    pub force_n: Complex<f32>,
    /// Displacement in x and y, m.
    pub motion_m: [Complex<f32>; 2],
    /// Every force in it could be relied upon.
    pub trusted: bool,
}

/// A phase that turns by a constant angle: c + js, e^{jφ}.
#[derive(Debug, Clone, Copy)]
struct Turning {
    now: Complex<f32>,
    by: Complex<f32>,
}

impl Turning {
    fn new(angle: f32) -> Self {
        let (s, c) = Real::sin_cos(angle);
        let by = Complex::new(c, s);
        Self {
            now: Complex::new(1.0, 0.0),
            // To length 1: what is over would grow with every period of a block.
            by: by.scale(1.5 - 0.5 * by.norm_sqr()),
        }
    }

    #[inline(always)]
    fn step(&mut self) {
        self.now = self.now * self.by;
    }

    /// Back to phase 0 after whole turns: rounding does not add up.
    #[inline(always)]
    fn again(&mut self) {
        self.now = Complex::new(1.0, 0.0);
    }
}

/// Frequencies rise by a constant factor from the lower to the upper edge; each is moved to
/// whole cycles in a block, so that blocks follow each other without a jump.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    rate_hz: f32,
    low_hz: f32,
    spindle_hz: f32,
    /// ln of the factor between lines.
    log_factor: f32,
    lines: u16,
    axes: [bool; 2],
    block_s: f32,
    over: bool,
    axis: u8,
    line: u16,
    at: Where,
    carrier: Turning,
    window: Turning,
    /// Periods of a block of this line.
    length: u32,
    cycles: f32,
    sum: Sums,
}

#[derive(Debug, Clone, Copy)]
struct Where {
    /// Blocks of settling that are left; none when measuring.
    settling: u32,
    block: u8,
    n: u32,
}

#[derive(Debug, Clone, Copy)]
struct Sums {
    force: Complex<f32>,
    motion: [Complex<f32>; 2],
    trusted: bool,
}

const NOTHING: Sums = Sums {
    force: Complex::ZERO,
    motion: [Complex::ZERO; 2],
    trusted: true,
};

impl Steps {
    pub(super) fn new(
        job: &ExcitationJob,
        rate_hz: f32,
        spindle_hz: f32,
    ) -> Result<Self, CersError> {
        within(job.lines, 2, 2000, "lines")?;
        let axes = [job.direction.drives(0), job.direction.drives(1)];
        let of_both = if job.direction == Direction::Both {
            2.0
        } else {
            1.0
        };
        let line_s = job.seconds / (of_both * f32::from(job.lines));
        let block_s = line_s / (SETTLING + BLOCKS) as f32;
        let least = LEAST_BLOCK_S.max(LEAST_CYCLES / job.low_hz);
        within(block_s, least, 100.0, "seconds")?;
        let mut out = Self {
            rate_hz,
            low_hz: job.low_hz,
            spindle_hz,
            log_factor: libm::logf(job.high_hz / job.low_hz) / f32::from(job.lines - 1),
            lines: job.lines,
            axes,
            block_s,
            over: false,
            axis: u8::from(!axes[0]),
            line: 0,
            at: Where {
                settling: 0,
                block: 0,
                n: 0,
            },
            carrier: Turning::new(0.0),
            window: Turning::new(0.0),
            length: 1,
            cycles: 1.0,
            sum: NOTHING,
        };
        out.begin_line();
        Ok(out)
    }

    /// The last line has been measured; its sine goes on until somebody ends it.
    #[inline]
    pub(super) fn is_over(&self) -> bool {
        self.over
    }

    /// The nearest frequency that the window keeps apart from the spindle's first multiples,
    /// or the middle between them where they are too close for that.
    fn dodged(&self, f_hz: f32) -> f32 {
        if !(self.spindle_hz > 0.0) {
            return f_hz;
        }
        let order = libm::roundf(f_hz / self.spindle_hz);
        let off = f_hz - order * self.spindle_hz;
        let clear = (CLEAR_BINS / self.block_s).min(0.5 * self.spindle_hz);
        if !(1.0..=MOST_ORDER).contains(&order) || off.abs() >= clear {
            return f_hz;
        }
        order * self.spindle_hz + if off < 0.0 { -clear } else { clear }
    }

    /// Once a line: some 200 instructions more than any other period.
    fn begin_line(&mut self) {
        let wanted = self.low_hz * libm::expf(self.log_factor * f32::from(self.line));
        let wanted = self.dodged(wanted);
        self.cycles = libm::floorf(wanted * self.block_s).max(1.0);
        let length = libm::roundf(self.cycles * self.rate_hz / wanted).max(8.0);
        self.length = length as u32;
        let turn = core::f32::consts::TAU;
        self.carrier = Turning::new(turn * self.cycles / length);
        self.window = Turning::new(turn / length);
        self.at = Where {
            settling: SETTLING,
            block: 0,
            n: 0,
        };
        self.sum = NOTHING;
    }

    #[inline]
    pub(super) fn axis(&self) -> u8 {
        self.axis
    }

    #[inline]
    pub(super) fn next_period(&mut self) -> [f32; 2] {
        // sin: starts without a jump, and every line ends where the next one starts.
        let x = self.carrier.now.im;
        if self.axis == 0 { [x, 0.0] } else { [0.0, x] }
    }

    #[inline]
    pub(super) fn see(&mut self, seen: &Seen) -> Option<Block> {
        if self.at.settling == 0 {
            // Hann: 1 − cos; e^{−jφ} against the sine is −j·e^{−jφ}·…, the same for all.
            let w = 1.0 - self.window.now.re;
            let c = self.carrier.now;
            let basis = Complex::new(w * c.re, -w * c.im);
            let [x, y] = seen.displacement_m;
            self.sum.force = self.sum.force + basis.scale(seen.force_n);
            let [mx, my] = self.sum.motion;
            self.sum.motion = [mx + basis.scale(x), my + basis.scale(y)];
            self.sum.trusted &= seen.trusted;
        }
        self.carrier.step();
        self.window.step();
        self.at.n += 1;
        if self.at.n < self.length {
            return None;
        }
        self.at.n = 0;
        self.carrier.again();
        self.window.again();
        if self.at.settling > 0 {
            self.at.settling -= 1;
            return None;
        }
        let scale = 2.0 / self.length as f32;
        let out = Block {
            axis: self.axis,
            line: self.line,
            block: self.at.block,
            f_hz: self.cycles * self.rate_hz / self.length as f32,
            force_n: self.sum.force.scale(scale),
            motion_m: self.sum.motion.map(|m| m.scale(scale)),
            trusted: self.sum.trusted,
        };
        self.sum = NOTHING;
        self.at.block += 1;
        if u32::from(self.at.block) >= BLOCKS {
            self.go_on();
        }
        Some(out)
    }

    fn go_on(&mut self) {
        let last = self.line + 1 >= self.lines;
        let second = last && self.axis == 0 && self.axes[1];
        self.over |= last && !second;
        if self.over {
            self.at.settling = u32::MAX;
            return;
        }
        self.line = if second { 0 } else { self.line + 1 };
        self.axis = if second { 1 } else { self.axis };
        self.begin_line();
    }
}

#[cfg(test)]
mod tests {
    use super::super::job::Signal;
    use super::super::source::Source;
    use super::*;

    const JOB: ExcitationJob = ExcitationJob {
        signal: Signal::Steps,
        direction: Direction::Both,
        rms_a: 0.1,
        low_hz: 300.0,
        high_hz: 2000.0,
        seconds: 12.0,
        lines: 30,
    };

    /// Force 40 N/A; motion 2e-8·e^{−j·0.5} m/N of it in the driven axis, a tenth in the
    /// other, a constant and a line of the spindle in both, all later by `late` periods.
    fn blocks(job: &ExcitationJob, late: usize, offset_m: f32, runout_m: f32) -> Vec<Block> {
        let mut source = Source::new(job, 40e3, 0.0).unwrap();
        let mut past: Vec<[f32; 2]> = Vec::new();
        let mut out = Vec::new();
        while let Some(x) = source.next_period() {
            past.push(x);
            let n = past.len();
            let at = |k: usize| n.checked_sub(1 + k).map_or([0.0; 2], |m| past[m]);
            let axis = usize::from(source.measures().unwrap());
            let now = 40.0 * at(late)[axis];
            // A delay of whole periods is a phase that grows with frequency.
            let lag = at(late + 7).map(|i| 40.0 * i);
            let spindle = runout_m * (core::f32::consts::TAU * 100.0 * n as f32 / 40e3).cos();
            let motion = [0, 1].map(|a| 2e-8 * lag[a] + 2e-9 * lag[1 - a] + offset_m + spindle);
            let seen = Seen {
                force_n: now,
                displacement_m: motion,
                trusted: true,
            };
            out.extend(source.see(&seen));
        }
        out
    }

    #[test]
    fn lines_come_in_order_and_give_back_the_response() {
        for late in [0, 3] {
            let all = blocks(&JOB, late, 5e-6, 0.0);
            assert_eq!(all.len(), 2 * 30 * BLOCKS as usize);
            for (k, b) in all.iter().enumerate() {
                let line = k / BLOCKS as usize;
                assert_eq!((b.axis, b.line), ((line / 30) as u8, (line % 30) as u16));
                let wanted = 300.0 * (2000.0f32 / 300.0).powf((line % 30) as f32 / 29.0);
                assert!((b.f_hz / wanted - 1.0).abs() < 2e-3, "{} {wanted}", b.f_hz);
                let a = usize::from(b.axis);
                let h = b.motion_m[a] * b.force_n.inverse();
                let angle = -core::f32::consts::TAU * b.f_hz * 7.0 / 40e3;
                let exact = Complex::new(angle.cos(), angle.sin()).scale(2e-8);
                let off = (h - exact).abs() / 2e-8;
                assert!(off < 2e-3, "{b:?}: {off}");
                let cross = b.motion_m[1 - a] * b.force_n.inverse();
                assert!((cross - exact.scale(0.1)).abs() < 2e-11 && b.trusted);
                assert!((b.force_n.abs() / (40.0 * 0.1414) - 1.0).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn runout_stays_out_where_it_is_three_blocks_away() {
        // 3 µm at 100 Hz beside 0.11 µm of motion, blocks of 40 ms: from 175 Hz on.
        for b in blocks(&JOB, 0, 0.0, 3e-6) {
            let a = usize::from(b.axis);
            let h = (b.motion_m[a] * b.force_n.inverse()).abs();
            assert!((h / 2e-8 - 1.0).abs() < 0.02, "{} Hz: {h}", b.f_hz);
        }
    }

    #[test]
    fn lines_keep_away_from_the_spindle() {
        for (spindle_hz, clear) in [(100.0f32, 49.9), (300.0, 49.9), (40.0, 19.9)] {
            let mut source = Source::new(&JOB, 40e3, spindle_hz).unwrap();
            let mut moved = 0;
            while source.next_period().is_some() {
                let Some(b) = source.see(&Seen::default()) else {
                    continue;
                };
                let order = (b.f_hz / spindle_hz).round();
                let off = (b.f_hz - order * spindle_hz).abs();
                let near = off < 0.999 * clear;
                assert!(!near || !(1.0..=4.0).contains(&order), "{} Hz", b.f_hz);
                moved += usize::from((off - clear).abs() < 1.0);
            }
            assert!(moved > 0 || spindle_hz == 40.0);
        }
    }

    #[test]
    fn a_force_that_is_not_to_be_trusted_marks_its_block() {
        let mut source = Source::new(&JOB, 40e3, 0.0).unwrap();
        let (mut n, mut out) = (0, Vec::new());
        while source.next_period().is_some() {
            n += 1;
            out.extend(source.see(&Seen {
                trusted: n != 44_000,
                ..Seen::default()
            }));
        }
        assert_eq!(out.iter().filter(|b| !b.trusted).count(), 1);
    }
}
