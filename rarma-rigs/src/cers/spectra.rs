//! Spectra of real blocks, both ways, on the sliced transform.
//!
//! Rate: slow path, once a block.

use super::error::CersError;
use crate::els::Complex;
use rarma_core::condition::SlicedFft;
use rarma_core::real::Real;

/// Transform of blocks of 2·`M` real samples, `M` a power of two from 4 on.
///
/// X_k = Σ x_n·e^(−j2πkn/N), N = 2·M. The way back needs no second transform: with
/// h_k = Re X_k − Im X_k over all N lines (Hartley), N·x_n = Re H_n − Im H_n.
#[derive(Debug, Clone)]
pub struct RealFft<T, const M: usize> {
    fft: SlicedFft<T, M>,
}

impl<T: Real, const M: usize> Default for RealFft<T, M> {
    fn default() -> Self {
        Self {
            fft: SlicedFft::default(),
        }
    }
}

impl<T: Real, const M: usize> RealFft<T, M> {
    /// Transforms a block; read [`Self::bin`] then.
    ///
    /// # Errors
    /// `DifferentLengths` if the block is not 2·M long.
    pub fn analyse(&mut self, x: &[T]) -> Result<(), CersError> {
        if x.len() != 2 * M {
            return Err(CersError::DifferentLengths);
        }
        self.put(x.iter().copied());
        Ok(())
    }

    fn put(&mut self, x: impl Iterator<Item = T>) {
        for (i, x) in x.enumerate() {
            self.fft.put(i, x);
        }
        while !self.fft.transform(1024) {}
        while !self.fft.unpack_bins(1024) {}
    }

    /// X_k, `k` from 0 to M; zero beyond.
    #[inline]
    pub fn bin(&self, k: usize) -> Complex<T> {
        let (re, im) = self.fft.bin(k);
        Complex::new(re, im)
    }

    /// Enters a line a·cos(2πkn/N) − b·sin(2πkn/N), a + jb = `line`, into an empty list that
    /// [`Self::synthesise`] turns into samples. 0 < k < M.
    pub(super) fn put_line(list: &mut [T], k: usize, line: Complex<T>) {
        let n = list.len();
        let half = T::from_f64(0.5);
        if k > 0 && k < n / 2 {
            list[k] = (line.re - line.im) * half;
            list[n - k] = (line.re + line.im) * half;
        }
    }

    /// Lines to samples, in place.
    pub(super) fn synthesise(&mut self, list: &mut [T]) -> Result<(), CersError> {
        self.analyse(list)?;
        let n = list.len();
        for i in 0..=M {
            let h = self.bin(i);
            list[i] = h.re - h.im;
            if i > 0 && i < M {
                list[n - i] = h.re + h.im;
            }
        }
        Ok(())
    }

    /// `work` becomes the signal with its own phases and the amplitudes of `period`, on the
    /// lines only.
    pub(super) fn exchange_phases(
        &mut self,
        lines: impl Iterator<Item = usize>,
        period: &[T],
        work: &mut [T],
    ) -> Result<(), CersError> {
        self.analyse(period)?;
        let mut phases = self.clone();
        phases.analyse(work)?;
        work.fill(T::ZERO);
        let scale = T::ONE / T::from_u32(M as u32);
        for k in lines {
            let (size, turn) = (self.bin(k).abs(), phases.bin(k));
            let length = turn.abs();
            let line = if length > T::ZERO {
                turn.scale(size / length)
            } else {
                self.bin(k)
            };
            Self::put_line(work, k, line.scale(scale));
        }
        self.synthesise(work)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// |X_k|² of a block, k below M.
    pub fn powers<const M: usize>(x: &[f64]) -> Vec<f64> {
        let mut fft = RealFft::<f64, M>::default();
        fft.analyse(x).unwrap();
        (0..M).map(|k| fft.bin(k).norm_sqr()).collect()
    }

    #[test]
    fn lines_come_back_from_their_samples() {
        let mut fft = RealFft::<f64, 64>::default();
        let mut x = vec![0.0; 128];
        let lines = [(3, 1.0, 0.4), (17, 0.2, -2.0), (63, 0.7, 1.1)];
        for (k, a, phi) in lines {
            let line = Complex::new(f64::cos(phi), f64::sin(phi)).scale(a);
            RealFft::<f64, 64>::put_line(&mut x, k, line);
        }
        fft.synthesise(&mut x).unwrap();
        for (n, x) in x.iter().enumerate() {
            let due: f64 = lines
                .iter()
                .map(|&(k, a, phi)| {
                    a * (core::f64::consts::TAU * (k * n) as f64 / 128.0 + phi).cos()
                })
                .sum();
            assert!((x - due).abs() < 1e-12, "{n}: {x} {due}");
        }
        fft.analyse(&x).unwrap();
        let line = fft.bin(17).scale(1.0 / 64.0);
        assert!((line.re - 0.2 * f64::cos(-2.0)).abs() < 1e-12);
        assert!((line.im - 0.2 * f64::sin(-2.0)).abs() < 1e-12);
        assert_eq!(fft.analyse(&x[1..]), Err(CersError::DifferentLengths));
    }
}
