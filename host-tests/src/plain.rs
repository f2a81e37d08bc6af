//! The textbook estimator that the product is compared with: recursive prediction
//! error with a dense covariance, and its roots by Durand and Kerner.
//!
//! Straightforward on purpose: full matrices, no start-up, no guard but the projection
//! of C. Source: L. Ljung, T. Söderström, *Theory and Practice of Recursive
//! Identification*, 1983.

use rarma_core::Real;

/// Largest root radius allowed for C, as in the product.
const RADIUS: f64 = 0.998;

/// Recursive prediction-error ARMA(p, q), q ≤ p, covariance form.
///
/// ```text
/// e = y − φᵀθ,  α = λσ² + ψᵀPψ,  K = Pψ/α,  θ ← θ + K·e,  P ← (P − K·(Pψ)ᵀ)/λ
/// ψ = φ filtered by 1/C,  σ² ← σ² + g·(e²·λσ²/α − σ²)
/// ```
///
/// Signs and order of θ = (a, c) as in the product.
#[derive(Debug, Clone)]
pub struct PlainRpem<T, const P: usize, const Q: usize, const N: usize> {
    theta: [T; N],
    phi: [T; N],
    psi: [T; N],
    covariance: [[T; N]; N],
    sigma2: T,
    lambda: T,
    gain: T,
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> PlainRpem<T, P, Q, N> {
    /// A model at 0 with covariance 1, for an input whose innovations have about the
    /// variance `sigma2`.
    #[must_use]
    pub fn new(lambda: T, gain: T, sigma2: T) -> Self {
        const { assert!(N == P + Q && Q <= P && P > 0) };
        let mut covariance = [[T::ZERO; N]; N];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = T::ONE;
        }
        Self {
            theta: [T::ZERO; N],
            phi: [T::ZERO; N],
            psi: [T::ZERO; N],
            covariance,
            sigma2,
            lambda,
            gain,
        }
    }

    /// Takes one sample; the innovation.
    #[inline]
    pub fn update(&mut self, y: T) -> T {
        let e = y - dot(&self.phi, &self.theta);
        let mut gain: [T; N] = core::array::from_fn(|i| dot(&self.covariance[i], &self.psi));
        let weighted = self.lambda * self.sigma2;
        let alpha = weighted + dot(&self.psi, &gain);
        // g·h first: the product is the same both ways round and P stays symmetric to
        // the bit. As (g/α)·h the unsymmetric part grows by 1/λ a sample; at λ = 0.998
        // that ended in nonsense after 15 000 samples, in double precision.
        let inverse = T::ONE / alpha;
        let forget = T::ONE / self.lambda;
        for (row, g) in self.covariance.iter_mut().zip(gain) {
            for (x, h) in row.iter_mut().zip(gain) {
                *x = (*x - g * h * inverse) * forget;
            }
        }
        for g in &mut gain {
            *g = *g * e * inverse;
        }
        let mut next = self.theta;
        // The step is halved until C is stable; after ten times it is left out.
        for _ in 0..10 {
            for i in 0..N {
                next[i] = self.theta[i] + gain[i];
                gain[i] *= T::from_f64(0.5);
            }
            if stable(&next[P..]) {
                self.theta = next;
                break;
            }
        }
        self.sigma2 += self.gain * (e * e * weighted / alpha - self.sigma2);

        // As in the product the prediction error enters φ, not the residual.
        let (mut y_f, mut e_f) = (-y, e);
        for j in 0..Q {
            y_f -= self.theta[P + j] * self.psi[j];
            e_f -= self.theta[P + j] * self.psi[P + j];
        }
        self.phi.copy_within(0..N - 1, 1);
        self.psi.copy_within(0..N - 1, 1);
        (self.phi[0], self.psi[0]) = (-y, y_f);
        if Q > 0 {
            (self.phi[P], self.psi[P]) = (e, e_f);
        }
        e
    }

    /// θ = (a, c).
    #[must_use]
    pub fn theta(&self) -> &[T; N] {
        &self.theta
    }
}

fn dot<T: Real>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::ZERO, |sum, (x, y)| sum + *x * *y)
}

fn stable<T: Real>(c: &[T]) -> bool {
    let mut a = [T::ZERO; 32];
    let mut scale = T::ONE;
    for (a, c) in a.iter_mut().zip(c) {
        scale /= T::from_f64(RADIUS);
        *a = *c * scale;
    }
    for m in (1..=c.len()).rev() {
        let k = a[m - 1];
        if !(k.abs() < T::ONE) {
            return false;
        }
        let scale = T::ONE / (T::ONE - k * k);
        let old = a;
        for i in 0..m - 1 {
            a[i] = (old[i] - k * old[m - 2 - i]) * scale;
        }
    }
    true
}

/// All roots of z^P + a₁ z^(P−1) + … as complex numbers, one sweep of Durand and
/// Kerner a sample from where they were.
#[derive(Debug, Clone)]
pub struct DurandKerner<T, const P: usize> {
    roots: [(T, T); P],
}

impl<T: Real, const P: usize> Default for DurandKerner<T, P> {
    fn default() -> Self {
        let roots = core::array::from_fn(|k| {
            let angle = T::from_f64(2.0) * T::PI * T::from_u32(k as u32) / T::from_u32(P as u32);
            let (sin, cos) = (angle + T::from_f64(0.4)).sin_cos();
            (T::from_f64(0.9) * cos, T::from_f64(0.9) * sin)
        });
        Self { roots }
    }
}

impl<T: Real, const P: usize> DurandKerner<T, P> {
    /// One sweep; the sum of the damping ratios of the roots above the real axis.
    #[inline]
    pub fn damping(&mut self, a: &[T]) -> T {
        let times = |x: (T, T), y: (T, T)| (x.0 * y.0 - x.1 * y.1, x.0 * y.1 + x.1 * y.0);
        let mut sum = T::ZERO;
        for k in 0..P {
            let z = self.roots[k];
            let (mut value, mut product) = ((T::ONE, T::ZERO), (T::ONE, T::ZERO));
            for x in a {
                value = times(value, z);
                value.0 += *x;
            }
            for (j, other) in self.roots.iter().enumerate() {
                if j != k {
                    product = times(product, (z.0 - other.0, z.1 - other.1));
                }
            }
            let size = product.0 * product.0 + product.1 * product.1;
            let step = times(value, (product.0 / size, -product.1 / size));
            let z = (z.0 - step.0, z.1 - step.1);
            self.roots[k] = z;
            if z.1 > T::ZERO {
                let l = (z.0 * z.0 + z.1 * z.1).ln() * T::from_f64(0.5);
                let theta = z.1.atan2(z.0);
                sum -= l / (l * l + theta * theta).sqrt();
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::{modes, polynomial};
    use rarma_core::estimate::{RarmaConfig, RecursiveArma};

    /// In double precision, once both starts are forgotten, the product's factored
    /// form and the textbook's dense one are the same estimator.
    #[test]
    fn the_product_follows_the_textbook() {
        let lambda = 0.998;
        let config = RarmaConfig {
            forgetting: lambda,
            variance_gain: 0.002,
            outlier_ratio: 1e30,
            ..RarmaConfig::default()
        };
        let mut ours = RecursiveArma::<f64, 2, 1, 3>::new(config);
        let mut plain = PlainRpem::<f64, 2, 1, 3>::new(lambda, 0.002, 0.1);
        let (mut early, mut late) = (0.0f64, 0.0f64);
        for (k, y) in modes(&[(980.0, 0.02)], 6000.0, 1).take(50_000).enumerate() {
            ours.update(y);
            plain.update(y);
            let apart = ours.theta().iter().zip(plain.theta());
            let apart = apart.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
            if k < 2000 {
                early = early.max(apart);
            } else if k > 40_000 {
                late = late.max(apart);
            }
        }
        println!("apart {early:.1e} at first, {late:.1e} after eighty memories");
        assert!(early > 1e-3 && late < 1e-12, "{early} {late}");
    }

    #[test]
    fn durand_kerner_finds_the_damping() {
        let a = polynomial(&[(980.0, 0.02), (450.0, 0.03), (1500.0, 0.05)], 6000.0);
        let mut roots = DurandKerner::<f64, 6>::default();
        let found = (0..60).map(|_| roots.damping(&a)).last().expect("some");
        assert!((found - 0.10).abs() < 1e-9, "{found}");
    }
}
