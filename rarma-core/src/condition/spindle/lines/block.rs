//! End of a block: amplitudes, phase and speed are corrected by what is left of the
//! lines, and it is judged whether they are there.

use super::line::{RotationLine, gain};
use super::{Lock, SpindleLines, Trust};
use crate::real::Real;

/// Smoothing of a line's errors, blocks.
const SMOOTH: f64 = 8.0;
/// Variance of white errors over that of their mean so smoothed: 2·8 − 1.
const WHITE: f64 = 15.0;
/// Memory of the variance of a line's errors, blocks.
const VARIANCE_BLOCKS: f64 = 40.0;
/// Blocks before the errors of a line are averaged, and before it tells of the phase.
const LEAST_AGE: u16 = 8;
const SPEAKING_AGE: u16 = 20;
/// Blocks before the lines count as locked.
const LOCK_AGE: u16 = 30;
/// A line whose power is this many times that of the noise in its notch is there.
const STRONG: f64 = 12.0;
/// The same for a speed that was only tried.
const LOUD: f64 = 300.0;
/// So many lines must be there: one alone may be a chatter that a wrong speed hits.
const LEAST_STRONG: u32 = 2;
/// Standard deviation of the phase of the lines, rad: locked below the first, lost
/// above the second.
const LOCKED_RAD: f64 = 0.35;
const LOST_RAD: f64 = 0.8;
/// A phase error this many times its variance is that of a line that grows, where growth
/// stays in the signal.
const WILD: f64 = 9.0;
/// Without a lock for so long, s, there is none.
const PATIENCE_S: f64 = 1.0;
/// Without a line that stands out for so long, s, the lock is lost.
const LOST_S: f64 = 0.25;

impl<T: Real, const H: usize> SpindleLines<T, H> {
    /// Corrects amplitudes, phase and speed.
    pub(super) fn end_block(&mut self) {
        self.filter.predict();
        self.age = self.age.saturating_add(1);
        let scale = T::from_f64(2.0) / T::from_u32(u32::from(self.block));
        let (mut error, mut weight) = (T::ZERO, T::ZERO);
        let (mut squares, mut powers) = (T::ZERO, T::ZERO);
        let mut strong = 0;
        let spacing = self.filter.omega / (T::from_f64(2.0) * T::PI);
        let most = spacing.min(T::ONE);
        let smooth = T::from_f64(1.0 / SMOOTH);
        let (choice, all_slow) = (self.choice, self.are_slow());
        let strong_from = T::from_f64(match self.trust {
            Trust::Tried => LOUD,
            Trust::Found | Trust::Doubted => STRONG,
        });
        for line in &mut self.lines[..self.used.min(H)] {
            let u = (line.sum.0 * scale, line.sum.1 * scale);
            line.sum = u;
            line.age = line.age.saturating_add(1);
            let square = line.square();
            if !(square > T::ZERO) {
                continue;
            }
            let inverse = T::ONE / square;
            let radial = (u.0 * line.c.0 + u.1 * line.c.1) * inverse.sqrt();
            line.radial += smooth * (radial - line.radial);
            if line.age < SPEAKING_AGE || (choice.is_flip(line.multiple) && !all_slow) {
                continue;
            }
            let least = if all_slow {
                self.slow_kappa
            } else {
                self.kappa
            };
            let kappa = gain(line.age, most, least);
            // What noise alone leaves of a line of no amplitude.
            let floor = line.variance * kappa;
            let above = square - floor;
            if !(above > T::ZERO) || !(line.variance > T::ZERO) {
                continue;
            }
            let n = T::from_u32(u32::from(line.multiple));
            let per_noise = T::ONE / line.variance;
            error += n * (u.1 * line.c.0 - u.0 * line.c.1) * per_noise;
            weight += n * n * above * per_noise;
            squares += n * n * above;
            powers += above;
            if square > floor * strong_from {
                strong += 1;
            }
        }
        let mut forward = T::ZERO;
        if weight > T::ZERO {
            error /= weight;
            let wild = error * error > (self.filter.p.0 + T::ONE / weight) * T::from_f64(WILD);
            if !(all_slow && wild) {
                forward = self.filter.correct(error, T::ONE / weight);
            }
            self.square_multiple = squares / powers;
        }
        self.draw(most, error, weight, forward);
        self.judge(strong);
        if !self.filter.omega.is_finite() || !self.base.0.is_finite() {
            self.reset();
            self.lock = Lock::Lost;
            return;
        }
        let (s, c) = forward.sin_cos();
        let (x, y) = self.base;
        self.base = (x * c - y * s, x * s + y * c);
        self.choose();
        self.steer();
    }

    /// Draws the amplitudes by what the phase does not explain, and learns how loud
    /// the rest is at each line. `error` is the common phase error, of information
    /// `weight`; `forward` is what the phase took of it.
    fn draw(&mut self, most: T, error: T, weight: T, forward: T) {
        let smooth = T::from_f64(1.0 / SMOOTH);
        let (choice, all_slow) = (self.choice, self.are_slow());
        for line in &mut self.lines[..self.used.min(H)] {
            let kappa = match all_slow || choice.is_flip(line.multiple) {
                true if line.shrinks() => gain(line.age, most, self.kappa),
                true if self.held => T::ZERO,
                true => gain(line.age, most, self.slow_kappa),
                false => gain(line.age, most, self.kappa),
            };
            let n = T::from_u32(u32::from(line.multiple));
            let square = line.square();
            if square > T::ZERO && line.age >= LEAST_AGE {
                let length = square.sqrt();
                let across = (line.sum.1 * line.c.0 - line.sum.0 * line.c.1) / length;
                line.across += smooth * (across - n * error * length - line.across);
                // The common error was fitted to this line too, by its part of the
                // information.
                let mut part = T::ONE;
                if weight > T::ZERO && line.variance > T::ZERO {
                    part = (n * n * square / (line.variance * weight)).min(T::ONE);
                }
                let free = T::from_f64(2.0) - part;
                let errors = line.radial * line.radial + line.across * line.across;
                let here = errors * T::from_f64(WHITE) / free;
                let since = T::from_u32(u32::from(line.age - LEAST_AGE + 1));
                let gain = T::ONE / since.min(T::from_f64(VARIANCE_BLOCKS));
                line.variance += gain * (here - line.variance);
            }
            let turned = n * forward;
            let u = (
                line.sum.0 + turned * line.c.1,
                line.sum.1 - turned * line.c.0,
            );
            line.sum = (T::ZERO, T::ZERO);
            if u.0.is_finite() && u.1.is_finite() && line.variance.is_finite() {
                line.c.0 += kappa * u.0;
                line.c.1 += kappa * u.1;
            } else {
                *line = RotationLine::new(line.multiple);
            }
        }
    }

    /// Locked, lost, or neither, by the lines that stand out.
    fn judge(&mut self, strong: u32) {
        let phase_sd = (self.filter.p.0 * self.square_multiple).sqrt();
        let lines = self.lines[..self.used.min(H)].iter();
        let speaking = lines.filter(|line| self.speaks(line.multiple)).count() as u32;
        let there = strong >= LEAST_STRONG.min(speaking).max(1);
        let per_block = T::from_u32(u32::from(self.block)) / self.fs;
        let blocks = |s: f64| (T::from_f64(s) / per_block).to_f32() as u16;
        let bad = !there || phase_sd > T::from_f64(LOST_RAD) || !phase_sd.is_finite();
        self.bad_blocks = if bad {
            self.bad_blocks.saturating_add(1)
        } else {
            0
        };
        match self.lock {
            Lock::Searching => {
                if there && self.age >= LOCK_AGE && phase_sd < T::from_f64(LOCKED_RAD) {
                    self.lock = Lock::Locked;
                } else if self.age > blocks(PATIENCE_S) {
                    self.reset();
                    self.lock = Lock::Lost;
                }
            }
            Lock::Locked => {
                if self.bad_blocks > blocks(LOST_S) {
                    self.reset();
                    self.lock = Lock::Lost;
                }
            }
            Lock::Lost => {}
        }
    }
}
