//! Frequency response functions from blocks of force, motion and the commanded sequence.
//!
//! Rate: slow path, once a block. Convention: e^{+jωt}, spectra Y·U*, sums over blocks; a
//! delay turns H clockwise.

use super::error::CersError;
use super::spectra::RealFft;
use crate::els::Complex;
use rarma_core::real::Real;

/// Weight of the samples of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Window {
    /// None: for blocks of exactly one period.
    Rectangular,
    /// 1 − cos(2πn/N): for random signals.
    Hann,
}

/// Sums of spectra of one line: force u, motion y, command r.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sums<T> {
    uu: T,
    yy: T,
    rr: T,
    yu: Complex<T>,
    yr: Complex<T>,
    ur: Complex<T>,
}

/// One line of a response, motion over force, by every estimator.
///
/// ```text
/// H1 = Syu/Suu (noise on y only)      H2 = Syy/Suy (noise on u only)
/// Hv = √(Syy/Suu)·e^{j·arg Syu}       H_IV = Syr/Sur
/// γ² = |Syu|²/(Suu·Syy)
/// ```
///
/// With noise n on u and m on y, H1 is low by Suu/(Suu + Snn) and H2 high by
/// 1 + Smm/Syy, however many blocks. H_IV has neither: the command is a sequence of
/// numbers and carries no noise. It is also the one that stands when the current loop
/// feeds motion back into the force. With a periodic command it equals the ratio of the
/// averages in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrfLine<T> {
    /// From the command as instrument.
    pub iv: Complex<T>,
    /// Force taken as exact.
    pub h1: Complex<T>,
    /// Motion taken as exact.
    pub h2: Complex<T>,
    /// Noise taken as equal parts of both.
    pub hv: Complex<T>,
    /// Coherence of force and motion, 0 to 1.
    pub coherence: T,
    /// Standard deviation of |H1| over |H1|: √((1 − γ²)/(2·n·γ²)); about that of its angle,
    /// rad.
    pub random_error: T,
    /// The same of H_IV: √(See·Srr/(2·n·|Syr|²)), See the power of y − H_IV·u.
    pub iv_random_error: T,
}

/// Spectra summed over blocks of 2·`M` samples; `M` lines, that at 0 Hz included.
#[derive(Debug, Clone)]
pub struct Frf<T, const M: usize> {
    sums: [Sums<T>; M],
    blocks: u32,
    window: Window,
}

impl<T: Real, const M: usize> Frf<T, M> {
    /// Nothing seen yet.
    pub fn new(window: Window) -> Self {
        let none = Sums {
            uu: T::ZERO,
            yy: T::ZERO,
            rr: T::ZERO,
            yu: Complex::ZERO,
            yr: Complex::ZERO,
            ur: Complex::ZERO,
        };
        Self {
            sums: [none; M],
            blocks: 0,
            window,
        }
    }

    /// Blocks in the sums.
    pub fn blocks(&self) -> u32 {
        self.blocks
    }

    /// Adds a block of command, force and motion of the same instants. `work` is as long
    /// as a block and holds nothing afterwards.
    ///
    /// Drop blocks with a force that is not trusted
    /// ([`Force::trusted`](super::Force::trusted)), with a limit of the voltage or a fault.
    ///
    /// # Errors
    /// `DifferentLengths` if one is not 2·M long; `NotFinite` at the first sample that is
    /// not. Nothing is added then.
    pub fn add(
        &mut self,
        fft: &mut [RealFft<T, M>; 3],
        command: &[T],
        force: &[T],
        motion: &[T],
        work: &mut [T],
    ) -> Result<(), CersError> {
        let n = 2 * M;
        if work.len() != n || [command, force, motion].iter().any(|x| x.len() != n) {
            return Err(CersError::DifferentLengths);
        }
        for x in [command, force, motion] {
            if let Some(index) = x.iter().position(|x| !x.is_finite()) {
                return Err(CersError::NotFinite { index });
            }
        }
        for (fft, x) in fft.iter_mut().zip([command, force, motion]) {
            self.windowed(x, work);
            fft.analyse(work)?;
        }
        let [r, u, y] = fft;
        for (k, s) in self.sums.iter_mut().enumerate() {
            let (r, u, y) = (r.bin(k), u.bin(k), y.bin(k));
            let conjugate = |z: Complex<T>| Complex::new(z.re, -z.im);
            s.uu += u.norm_sqr();
            s.yy += y.norm_sqr();
            s.rr += r.norm_sqr();
            s.yu = s.yu + y * conjugate(u);
            s.yr = s.yr + y * conjugate(r);
            s.ur = s.ur + u * conjugate(r);
        }
        self.blocks += 1;
        Ok(())
    }

    fn windowed(&self, x: &[T], out: &mut [T]) {
        let mean = x.iter().copied().sum::<T>() / T::from_u32(x.len() as u32);
        let turn = T::from_f64(2.0) * T::PI / T::from_u32(x.len() as u32);
        for (n, (out, x)) in out.iter_mut().zip(x).enumerate() {
            let weight = match self.window {
                Window::Rectangular => T::ONE,
                Window::Hann => T::ONE - (turn * T::from_u32(n as u32)).sin_cos().1,
            };
            *out = (*x - mean) * weight;
        }
    }

    /// Line `k`, at k·rate/(2·M) Hz; none beyond the lines, at 0 Hz, before the first block,
    /// or where the command or the force is silent.
    pub fn line(&self, k: usize) -> Option<FrfLine<T>> {
        let s = self.sums.get(k).filter(|_| k > 0 && self.blocks > 0)?;
        let cross = s.yu.norm_sqr();
        let instrument = s.ur.norm_sqr();
        if !(s.uu > T::ZERO && cross > T::ZERO && instrument > T::ZERO) {
            return None;
        }
        let coherence = (cross / s.uu / s.yy).min(T::ONE);
        let two_n = T::from_u32(2 * self.blocks);
        let iv = s.yr * s.ur.inverse();
        // |y − H·u|² summed; rounding may leave it below zero.
        let cross_part = iv.re * s.yu.re + iv.im * s.yu.im;
        let left = s.yy - cross_part * T::from_f64(2.0) + iv.norm_sqr() * s.uu;
        let out = FrfLine {
            iv,
            h1: s.yu.scale(T::ONE / s.uu),
            h2: s.yu.scale(s.yy / cross),
            hv: s.yu.scale((s.yy / s.uu).sqrt() / cross.sqrt()),
            coherence,
            random_error: ((T::ONE - coherence) / (two_n * coherence)).sqrt(),
            iv_random_error: (left.max(T::ZERO) * s.rr / (two_n * s.yr.norm_sqr())).sqrt(),
        };
        (out.iv.is_finite() && out.h2.is_finite()).then_some(out)
    }
}

/// What a motion is measured as, over force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Displacement over force, m/N.
    Receptance,
    /// Velocity over force, m/(N·s): jω times the receptance.
    Mobility,
    /// Acceleration over force, 1/kg: −ω² times the receptance.
    Accelerance,
}

impl Quantity {
    /// (jω)ⁿ of this quantity over the receptance.
    fn factor<T: Real>(self, f_hz: T) -> Complex<T> {
        let w = T::from_f64(2.0) * T::PI * f_hz;
        match self {
            Self::Receptance => Complex::new(T::ONE, T::ZERO),
            Self::Mobility => Complex::new(T::ZERO, w),
            Self::Accelerance => Complex::new(-w * w, T::ZERO),
        }
    }

    /// A response measured as `self` in terms of `other`, at `f_hz` > 0.
    pub fn to<T: Real>(self, other: Self, h: Complex<T>, f_hz: T) -> Complex<T> {
        h * other.factor(f_hz) * self.factor(f_hz).inverse()
    }
}

/// What stands between the two measured signals besides the structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path<T> {
    /// Motion is sampled this much later than force, s; negative if earlier.
    pub motion_delay_s: T,
    /// Response of the sensor of motion at this line, over that at 0 Hz.
    pub motion_sensor: Complex<T>,
    /// Force over the force reconstructed from the current at this line: the lag of the
    /// flux ([`Eddy::flux`](super::Eddy::flux)).
    pub force_lag: Complex<T>,
}

impl<T: Real> Path<T> {
    /// Nothing in between.
    pub fn none() -> Self {
        Self {
            motion_delay_s: T::ZERO,
            motion_sensor: Complex::new(T::ONE, T::ZERO),
            force_lag: Complex::new(T::ONE, T::ZERO),
        }
    }

    /// The structure's own response: H·e^{+jωτ}/(sensor·lag).
    pub fn correct(&self, h: Complex<T>, f_hz: T) -> Complex<T> {
        let angle = T::from_f64(2.0) * T::PI * f_hz * self.motion_delay_s;
        let (s, c) = angle.sin_cos();
        h * Complex::new(c, s) * (self.motion_sensor * self.force_lag).inverse()
    }
}

#[cfg(test)]
#[path = "frf_tests.rs"]
mod tests;
