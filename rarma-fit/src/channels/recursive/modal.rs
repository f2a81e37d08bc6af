//! From the model's uncertainty to that of a mode.

use super::{MOST_PARAMETERS, RecursiveChannels, Weights};
use core::f64::consts::TAU;
use nalgebra::Complex;
use rarma_core::spectrum::{ModalDeviation, Quadratic, Roots};

impl RecursiveChannels {
    /// Standard deviations of the mode at a factor of A at `fs` Hz; none for real roots. With
    ///
    /// ```text
    /// ∂z/∂a_i = −z^(p−i)/A′(z),   r = |ln z|,   ∂f = fs/2π·∂r,   ∂ζ = −∂(Re ln z/r)
    /// x = P·g,   var = gᵀ·P·g·factor, or xᵀ·J·x
    /// ```
    ///
    /// g the gradient of f or ζ. With [`Weights::Own`] and several channels the second, held
    /// between the first and K times it: scores of K channels, each white by itself, scatter
    /// K times as much as independent ones at the most.
    pub fn deviation(&self, factor: &Quadratic<f64>, fs: f64) -> Option<ModalDeviation<f64>> {
        let Roots::Pair { re, im } = factor.roots() else {
            return None;
        };
        let z = Complex::new(re, im);
        let one = Complex::new(1.0, 0.0);
        let (mut value, mut slope) = (one, Complex::new(0.0, 0.0));
        for a in self.a() {
            slope = slope * z + value;
            value = value * z + a;
        }
        let log = z.ln();
        let r = libm::hypot(log.re, log.im);
        let (mut by_f, mut by_zeta) = ([0.0; MOST_PARAMETERS], [0.0; MOST_PARAMETERS]);
        // d ln z by a_p, then one factor z more for each lower one.
        let mut by = -one / (z * slope);
        for i in (0..self.p).rev() {
            by_f[i] = (log.conj() * by).re / r * fs / TAU;
            by_zeta[i] = log.im * (log.conj() * by).im / (r * r * r);
            by *= z;
        }
        let found = ModalDeviation {
            frequency: libm::sqrt(self.variance(&by_f)),
            damping: libm::sqrt(self.variance(&by_zeta)),
        };
        (found.frequency.is_finite() && found.damping.is_finite()).then_some(found)
    }

    /// Variance of gᵀθ.
    fn variance(&self, g: &[f64; MOST_PARAMETERS]) -> f64 {
        let n = self.theta.len();
        let x = self.covariance.product(n, g);
        let independent =
            g.iter().zip(&x).map(|(g, x)| g * x).sum::<f64>() * self.covariance_factor();
        let channels = self.channels.len() as f64;
        match self.weights() {
            Weights::Own if channels > 1.0 => {
                let scattered = self.scores.quadratic(&x[..n]);
                scattered.clamp(independent, channels * independent)
            }
            _ => independent,
        }
    }
}
