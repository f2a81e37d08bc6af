//! The Cramér–Rao bound: what no unbiased estimator can undercut.

use super::ar::check_order;
use super::delta::{PoleDeviation, pole_deviation};
use super::error::FitError;
use super::series::count;
use rarma_core::estimate::schur;
use rarma_core::real::Real;

/// Asymptotic Cramér–Rao bound of an ARMA(p, q) model with Gaussian noise.
///
/// With white e of variance σ², the derivatives of the prediction error are the
/// outputs of 1/A and 1/C driven by that same noise, ∂e/∂aᵢ = e(t−i)/A and
/// ∂e/∂cⱼ = −e(t−j)/C. Their joint covariance X = E(ψψᵀ)/σ² is the stationary
/// covariance of the system that puts both in one state:
///
/// ```text
/// ψ(t+1) = F·ψ(t) + g·e(t)/σ,   F = diag(companion of A, companion of C),   g = (1,0…, −1,0…)
/// X = F·X·Fᵀ + g·gᵀ,            cov(a, c) ≥ X⁻¹/n
/// ```
///
/// solved by doubling: X ← X + F·X·Fᵀ, F ← F². σ² drops out. Modes follow by the
/// delta method through the roots of A. For one lightly damped mode the result is
/// near sd(ζ) = √(ζ/(2πf·T)), T the time observed.
///
/// Exact in the limit of long records; for short ones the true bound is higher.
/// With exponential forgetting λ take n = (1 + λ)/(1 − λ).
///
/// ```
/// use rarma_fit::Bound;
/// // AR(1): var(a) = (1 − a²)/n
/// let bound = Bound::<f64, 1>::of(&[-0.9], &[])?;
/// assert!((bound.deviation(0, 100) - (0.19f64 / 100.0).sqrt()).abs() < 1e-12);
/// # Ok::<(), rarma_fit::FitError>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Bound<T, const N: usize> {
    a: [T; N],
    p: usize,
    n: usize,
    /// X⁻¹: the bound of one sample.
    inverse: [[T; N]; N],
}

/// Doublings: more than any root inside the circle in this number type needs.
const DOUBLINGS: u32 = 60;

impl<T: Real, const N: usize> Bound<T, N> {
    /// Of the model with coefficients a and c, without the leading 1; p + q ≤ `N`.
    ///
    /// # Errors
    /// `NotStable` if A or C has a root on or outside the unit circle, `Singular`
    /// if they share one, or the order's fault.
    pub fn of(a: &[T], c: &[T]) -> Result<Self, FitError> {
        let (p, n) = (a.len(), a.len() + c.len());
        check_order::<N>(n)?;
        if !schur::inside::<T, N>(a, T::ONE) || !schur::inside::<T, N>(c, T::ONE) {
            return Err(FitError::NotStable);
        }
        let information = information::<T, N>(a, c).ok_or(FitError::NotStable)?;
        let mut stored = [T::ZERO; N];
        stored[..p].copy_from_slice(a);
        Ok(Self {
            a: stored,
            p,
            n,
            inverse: inverse(&information, n).ok_or(FitError::Singular)?,
        })
    }

    /// Least covariance of parameters i and j of θ = (a, c) after `samples`; NaN
    /// outside p + q.
    pub fn covariance(&self, i: usize, j: usize, samples: usize) -> T {
        if i < self.n && j < self.n {
            self.inverse[i][j] / count(samples)
        } else {
            T::from_f64(f64::NAN)
        }
    }

    /// Least standard deviation of parameter i of θ = (a, c) after `samples`.
    pub fn deviation(&self, i: usize, samples: usize) -> T {
        self.covariance(i, i, samples).sqrt()
    }

    /// Least standard deviations of the mode at the root z = re + j·im of A after
    /// `samples` at `fs` Hz; none for a real root.
    pub fn pole(&self, re: T, im: T, fs: T, samples: usize) -> Option<PoleDeviation<T>> {
        let one = pole_deviation(&self.a[..self.p], &self.inverse, re, im, fs)?;
        let root = count::<T>(samples).sqrt();
        Some(PoleDeviation {
            frequency: one.frequency / root,
            damping: one.damping / root,
        })
    }

    /// The same for a mode of A given by its natural frequency (Hz) and damping
    /// ratio: z = exp((−ζ + j√(1−ζ²))·2πf/fs). None unless 0 ≤ ζ < 1.
    pub fn mode(&self, f: T, zeta: T, fs: T, samples: usize) -> Option<PoleDeviation<T>> {
        let w = T::from_f64(2.0) * T::PI * f / fs;
        let radius = (-zeta * w).exp();
        let (sin, cos) = (w * (T::ONE - zeta * zeta).sqrt()).sin_cos();
        self.pole(radius * cos, radius * sin, fs, samples)
    }
}

/// X by doubling; none if it does not converge.
fn information<T: Real, const N: usize>(a: &[T], c: &[T]) -> Option<[[T; N]; N]> {
    let (p, n) = (a.len(), a.len() + c.len());
    let mut f = [[T::ZERO; N]; N];
    let mut g = [T::ZERO; N];
    for (start, coefficients, sign) in [(0, a, T::ONE), (p, c, -T::ONE)] {
        for (i, x) in coefficients.iter().enumerate() {
            f[start][start + i] = -*x;
            if i > 0 {
                f[start + i][start + i - 1] = T::ONE;
            } else {
                g[start] = sign;
            }
        }
    }
    let mut x = [[T::ZERO; N]; N];
    for i in 0..n {
        for j in 0..n {
            x[i][j] = g[i] * g[j];
        }
    }
    for _ in 0..DOUBLINGS {
        let fx = product(&f, &x, n);
        let mut largest = T::ZERO;
        for i in 0..n {
            for j in 0..=i {
                let mut sum = T::ZERO;
                for k in 0..n {
                    sum += fx[i][k] * f[j][k];
                }
                let scale = (x[i][i] * x[j][j]).sqrt();
                x[i][j] += sum;
                x[j][i] = x[i][j];
                // A first term of 0 on the diagonal says nothing yet.
                largest = largest.max(if scale > T::ZERO {
                    sum.abs() / scale
                } else {
                    T::ONE
                });
            }
        }
        if !x.iter().flatten().all(|x| x.is_finite()) {
            return None;
        }
        if largest < T::EPSILON {
            return Some(x);
        }
        f = product(&f, &f, n);
    }
    None
}

fn product<T: Real, const N: usize>(x: &[[T; N]; N], y: &[[T; N]; N], n: usize) -> [[T; N]; N] {
    let mut out = [[T::ZERO; N]; N];
    for i in 0..n {
        for k in 0..n {
            let factor = x[i][k];
            if factor != T::ZERO {
                for j in 0..n {
                    out[i][j] += factor * y[k][j];
                }
            }
        }
    }
    out
}

/// Inverse of a symmetric positive definite matrix, scaled to a unit diagonal
/// first (Cholesky); none if it is singular to rounding.
fn inverse<T: Real, const N: usize>(m: &[[T; N]; N], n: usize) -> Option<[[T; N]; N]> {
    let mut scale = [T::ZERO; N];
    for i in 0..n {
        scale[i] = m[i][i].sqrt();
    }
    let mut l = [[T::ZERO; N]; N];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = m[i][j] / (scale[i] * scale[j]);
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i == j {
                if !(sum > T::EPSILON * T::from_f64(16.0)) {
                    return None;
                }
                l[i][i] = sum.sqrt();
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    // L⁻¹ column by column, then L⁻ᵀL⁻¹.
    let mut lower = [[T::ZERO; N]; N];
    for j in 0..n {
        lower[j][j] = T::ONE / l[j][j];
        for i in j + 1..n {
            let mut sum = T::ZERO;
            for k in j..i {
                sum -= l[i][k] * lower[k][j];
            }
            lower[i][j] = sum / l[i][i];
        }
    }
    let mut out = [[T::ZERO; N]; N];
    for i in 0..n {
        for j in 0..=i {
            let mut sum = T::ZERO;
            for k in i..n {
                sum += lower[k][i] * lower[k][j];
            }
            out[i][j] = sum / (scale[i] * scale[j]);
            out[j][i] = out[i][j];
        }
    }
    out.iter().flatten().all(|x| x.is_finite()).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms_of_order_one() {
        let (a, c) = (-0.8f64, 0.5);
        let bound = Bound::<f64, 2>::of(&[a], &[c]).expect("stable");
        // Box and Jenkins, with their φ = −a and θ = −c.
        let common = (1.0 - a * c).powi(2) / (a - c).powi(2);
        let by_a = (1.0 - a * a) * common;
        let by_c = (1.0 - c * c) * common;
        assert!((bound.covariance(0, 0, 1) - by_a).abs() < 1e-10);
        assert!((bound.covariance(1, 1, 1) - by_c).abs() < 1e-10);
        assert!((bound.deviation(0, 400) - by_a.sqrt() / 20.0).abs() < 1e-10);
        assert!(bound.covariance(0, 2, 1).is_nan());
        let moving = Bound::<f64, 1>::of(&[], &[0.6]).expect("stable");
        assert!((moving.covariance(0, 0, 1) - 0.64).abs() < 1e-10);
    }

    #[test]
    fn information_is_toeplitz_in_its_blocks() {
        let a = [-1.1, 0.95, -0.805, 0.76];
        let c = [0.5, -0.3];
        let x = information::<f64, 6>(&a, &c).expect("stable");
        let mut r = [0.0; 4];
        super::super::polynomial::autocovariance::<f64, 4>(&a, &mut r).expect("stable");
        for i in 0..4usize {
            for j in 0..4 {
                assert!((x[i][j] - r[i.abs_diff(j)]).abs() < 1e-9);
            }
        }
        // E[x_A(t−1)·x_C(t−1)] by impulse responses.
        let (mut ha, mut hc) = ([0.0; 4], [0.0; 2]);
        let mut sum = 0.0;
        for k in 0..2000 {
            let input = f64::from(u8::from(k == 0));
            let x: f64 = input - (0..4).map(|i| a[i] * ha[i]).sum::<f64>();
            let y: f64 = input - (0..2).map(|i| c[i] * hc[i]).sum::<f64>();
            sum += x * y;
            ha.copy_within(..3, 1);
            ha[0] = x;
            hc[1] = hc[0];
            hc[0] = y;
        }
        assert!((x[0][4] + sum).abs() < 1e-9, "{} {sum}", x[0][4]);
    }

    #[test]
    fn one_mode_is_near_the_rule_of_thumb() {
        let (f, zeta, fs, n) = (980.0, 0.02, 5000.0, 5000);
        let w = 2.0 * core::f64::consts::PI * f / fs;
        let radius = (-zeta * w).exp();
        let a = [
            -2.0 * radius * (w * (1.0 - zeta * zeta).sqrt()).cos(),
            radius * radius,
        ];
        let thumb = (zeta / (2.0 * core::f64::consts::PI * f * n as f64 / fs)).sqrt();
        let sd = Bound::<f64, 2>::of(&a, &[])
            .and_then(|b| b.mode(f, zeta, fs, n).ok_or(FitError::Singular))
            .expect("a mode");
        assert!(
            (0.97..1.03).contains(&(sd.damping / thumb)),
            "{}",
            sd.damping / thumb
        );
        // In frequency: sd(f)/f is sd(ζ) for light damping.
        assert!((0.97..1.03).contains(&(sd.frequency / f / sd.damping)));
        let single = Bound::<f32, 2>::of(&a.map(|x| x as f32), &[]).expect("stable");
        let other = single.mode(f as f32, 0.02, 5000.0, n).expect("a mode");
        assert!((f64::from(other.damping) / sd.damping - 1.0).abs() < 1e-2);
    }

    #[test]
    fn refuses_by_cause() {
        assert_eq!(
            Bound::<f64, 2>::of(&[-1.0], &[]).err(),
            Some(FitError::NotStable)
        );
        assert_eq!(
            Bound::<f64, 2>::of(&[-0.5], &[-0.5]).err(),
            Some(FitError::Singular)
        );
        assert_eq!(
            Bound::<f64, 2>::of(&[0.1, 0.1], &[0.1]).err(),
            Some(FitError::OrderAboveCapacity)
        );
        assert_eq!(
            Bound::<f64, 2>::of(&[], &[]).err(),
            Some(FitError::NothingToEstimate)
        );
    }
}
