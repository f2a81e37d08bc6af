//! A rational function through a receptance, by least squares.
//!
//! ```text
//! G(s) ≈ Σ_{k<2n+3} c_k φ_k(s) / (φ_2n(s) + Σ_{k<2n} d_k φ_k(s)),   s = jf/f_high
//! φ_0 = 1,  φ_1 = s,  φ_{k+1} = 2s·φ_k + φ_{k−1}
//! ```
//!
//! The basis is Chebyshev's on the axis (φ_k(jx) = j^k·T_k(x)): real coefficients, values
//! of at most 1, and columns that stay apart; powers of s lose digits with every degree.
//! The numerator's last three degrees stand for the modes above the band, whose
//! receptance begins as c + c₂·s².
//!
//! The equations are linear after multiplication by the denominator, and divided by the
//! one of the round before (Sanathanan and Koerner), so that the residual of the last
//! round is that of G itself.

use super::complex::Complex;
use super::error::ElsError;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Rounds at most; five are usual.
const ROUNDS: u32 = 40;
/// Numerator coefficients beyond two a mode.
const EXTRA: usize = 3;

/// A fitted rational function of n modes; 4n + 3 ≤ `N`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rational<T, const N: usize> {
    /// Numerator, then denominator without its leading 1.
    theta: [T; N],
    modes: usize,
    top_hz: T,
    unit: T,
    /// √(Σ|G − fit|²/Σ|G|²).
    pub residual: T,
    pub rounds: u32,
}

/// φ_0 … φ_{K−1} and their derivatives at s.
fn basis<T: Real, const N: usize>(s: Complex<T>) -> ([Complex<T>; N], [Complex<T>; N]) {
    let two = T::from_f64(2.0);
    let (mut value, mut slope) = ([Complex::ZERO; N], [Complex::ZERO; N]);
    for k in 0..N {
        (value[k], slope[k]) = match k {
            0 => (Complex::new(T::ONE, T::ZERO), Complex::ZERO),
            1 => (s, Complex::new(T::ONE, T::ZERO)),
            _ => (
                (s * value[k - 1]).scale(two) + value[k - 2],
                (value[k - 1] + s * slope[k - 1]).scale(two) + slope[k - 2],
            ),
        };
    }
    (value, slope)
}

impl<T: Real, const N: usize> Rational<T, N> {
    fn numerator(&self) -> usize {
        2 * self.modes + EXTRA
    }

    /// Fits n modes; frequencies rise, all finite (the caller's to check).
    pub fn fit(f: &[T], g: &[Complex<T>], modes: usize) -> Result<Self, ElsError> {
        let unknowns = modes.saturating_mul(4).saturating_add(EXTRA);
        if unknowns > N {
            return Err(ElsError::OrderAboveCapacity);
        }
        let unit = g.iter().fold(T::ZERO, |m, g| m.max(g.abs()));
        let top_hz = f.last().copied().unwrap_or(T::ZERO);
        if f.len() < unknowns || !(unit > T::ZERO && top_hz > T::ZERO) {
            return Err(ElsError::TooFewLines { needed: unknowns });
        }
        let mut now = Self {
            theta: [T::ZERO; N],
            modes,
            top_hz,
            unit,
            residual: T::ONE / T::ZERO,
            rounds: 0,
        };
        let mut best: Option<Self> = None;
        for round in 1..=ROUNDS {
            now.theta = now.round(f, g, round == 1)?;
            now.rounds = round;
            now.residual = now.distance(f, g);
            let gained = best.map_or(T::ONE, |b| T::ONE - now.residual / b.residual);
            if gained > T::ZERO {
                best = Some(now);
            }
            // The rounds go down quickly, then wander about the minimum.
            if gained.abs() < T::from_f64(1e-4) && round > 3 {
                break;
            }
        }
        best.filter(|b| b.residual.is_finite())
            .ok_or(ElsError::Singular)
    }

    /// One weighted linear least squares.
    fn round(&self, f: &[T], g: &[Complex<T>], first: bool) -> Result<[T; N], ElsError> {
        let (m, poles) = (self.numerator(), 2 * self.modes);
        let mut triangle = Triangle::<T, N>::new(m + poles);
        for (&f, &g) in f.iter().zip(g) {
            let (phi, _) = basis::<T, N>(self.place(f));
            let weight = if first {
                T::ONE
            } else {
                T::ONE / self.denominator(&phi).abs()
            };
            if !weight.is_finite() {
                continue;
            }
            let g = g.scale(T::ONE / self.unit);
            let (mut re, mut im) = ([T::ZERO; N], [T::ZERO; N]);
            for k in 0..m {
                (re[k], im[k]) = (weight * phi[k].re, weight * phi[k].im);
            }
            for k in 0..poles {
                let x = (g * phi[k]).scale(-weight);
                (re[m + k], im[m + k]) = (x.re, x.im);
            }
            let right = (g * phi[poles]).scale(weight);
            let _ = triangle.add(&mut re, right.re);
            let _ = triangle.add(&mut im, right.im);
        }
        triangle.solve().ok_or(ElsError::Singular)
    }

    fn place(&self, f: T) -> Complex<T> {
        Complex::new(T::ZERO, f / self.top_hz)
    }

    fn denominator(&self, phi: &[Complex<T>; N]) -> Complex<T> {
        let (m, poles) = (self.numerator(), 2 * self.modes);
        (0..poles).fold(phi[poles], |sum, k| sum + phi[k].scale(self.theta[m + k]))
    }

    fn above(&self, phi: &[Complex<T>; N]) -> Complex<T> {
        (0..self.numerator()).fold(Complex::ZERO, |sum, k| sum + phi[k].scale(self.theta[k]))
    }

    /// The function at `f` Hz.
    pub fn at(&self, f: T) -> Complex<T> {
        let (phi, _) = basis::<T, N>(self.place(f));
        (self.above(&phi) * self.denominator(&phi).inverse()).scale(self.unit)
    }

    fn distance(&self, f: &[T], g: &[Complex<T>]) -> T {
        let (mut apart, mut all) = (T::ZERO, T::ZERO);
        for (&f, &g) in f.iter().zip(g) {
            apart += (self.at(f) - g).scale(T::ONE / self.unit).norm_sqr();
            all += g.scale(T::ONE / self.unit).norm_sqr();
        }
        (apart / all).sqrt()
    }

    /// Denominator in powers of s, highest first and without the leading 1; its degree.
    pub fn powers(&self) -> ([T; N], usize) {
        let degree = 2 * self.modes;
        let two = T::from_f64(2.0);
        // Coefficients by rising power of φ_{k−1} and φ_k.
        let (mut before, mut now) = ([T::ZERO; N], [T::ZERO; N]);
        now[0] = T::ONE;
        let mut sum = [T::ZERO; N];
        for k in 0..=degree {
            let weight = if k == degree {
                T::ONE
            } else {
                self.theta[self.numerator() + k]
            };
            for i in 0..=k {
                sum[i] += weight * now[i];
            }
            let mut next = [T::ZERO; N];
            for i in 0..=k {
                next[i] += before[i];
                next[i + 1] += if k == 0 { now[i] } else { two * now[i] };
            }
            (before, now) = (now, next);
        }
        let mut out = [T::ZERO; N];
        for k in 0..degree {
            out[k] = sum[degree - 1 - k] / sum[degree];
        }
        (out, degree)
    }

    /// Residue of G at the pole s, m/(N·s).
    pub fn residue(&self, s: Complex<T>) -> Complex<T> {
        let (phi, slope) = basis::<T, N>(s);
        let (m, poles) = (self.numerator(), 2 * self.modes);
        let below = (0..poles).fold(slope[poles], |sum, k| {
            sum + slope[k].scale(self.theta[m + k])
        });
        let turns = T::from_f64(2.0) * T::PI * self.top_hz;
        (self.above(&phi) * below.inverse()).scale(self.unit * turns)
    }

    /// Top of the band, Hz: the unit of s.
    pub fn top_hz(&self) -> T {
        self.top_hz
    }
}
