//! The Cramér–Rao bound from a spectral matrix that depends on parameters, by differences:
//!
//! ```text
//! I_ij = n/(4π)·∫ tr(S⁻¹·∂S/∂θ_i·S⁻¹·∂S/∂θ_j) dω over the circle
//! ```
//!
//! which is that of the exact likelihood of a Gaussian process in the limit of long records.

use super::{C, Shared, Structure};
use nalgebra::DMatrix;

/// Points on the half circle: a mode of 2 % at 400 Hz is 7 of them wide.
const GRID: usize = 2048;

/// Least standard deviations of (f in Hz, ζ) of each mode after n samples.
pub type Least = Vec<(f64, f64)>;

fn least(
    theta: &[f64],
    modes: usize,
    n: usize,
    spectrum: impl Fn(&[f64], f64) -> DMatrix<C>,
) -> Least {
    let count = theta.len();
    let mut information = DMatrix::<f64>::zeros(count, count);
    for g in 0..GRID {
        let omega = std::f64::consts::PI * (g as f64 + 0.5) / GRID as f64;
        let inverse = spectrum(theta, omega).try_inverse().expect("regular");
        let slopes: Vec<DMatrix<C>> = (0..count)
            .map(|i| {
                let step = 1e-5 * theta[i].abs().max(1e-3);
                let at = |sign: f64| {
                    let mut moved = theta.to_vec();
                    moved[i] += sign * step;
                    spectrum(&moved, omega)
                };
                &inverse * (at(1.0) - at(-1.0)) / C::new(2.0 * step, 0.0)
            })
            .collect();
        for i in 0..count {
            for j in 0..=i {
                // The other half of the circle gives the same again.
                let term = (&slopes[i] * &slopes[j]).trace().re * n as f64 / (2 * GRID) as f64;
                information[(i, j)] += term;
                if i != j {
                    information[(j, i)] += term;
                }
            }
        }
    }
    // Parameters of one scale each, so that the inverse has all its digits.
    let scale: Vec<f64> = (0..count).map(|i| information[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(count, count, |i, j| {
        information[(i, j)] / (scale[i] * scale[j])
    });
    let inverse = scaled.try_inverse().expect("all parameters are determined");
    let sd = |i: usize| inverse[(i, i)].sqrt() / scale[i];
    (0..modes).map(|m| (sd(2 * m), sd(2 * m + 1))).collect()
}

fn of_modes(modes: &[(f64, f64)]) -> Vec<f64> {
    modes.iter().flat_map(|(f, zeta)| [*f, *zeta]).collect()
}

fn modes_of(theta: &[f64], modes: usize) -> Vec<(f64, f64)> {
    theta[..2 * modes].chunks(2).map(|x| (x[0], x[1])).collect()
}

impl Structure {
    /// What the sensors let one know of the modes: frequencies, damping ratios, shapes and the
    /// noise unknown.
    pub fn least(&self, n: usize) -> Least {
        let m = self.modes.len();
        let k = self.channels();
        let mut theta = of_modes(&self.modes);
        theta.extend(self.shapes.iter().flatten());
        theta.push(self.noise);
        least(&theta, m, n, |theta, omega| {
            let shapes = theta[2 * m..2 * m + m * k].chunks(k);
            Structure {
                modes: modes_of(theta, m),
                shapes: shapes.map(<[f64]>::to_vec).collect(),
                force: self.force,
                noise: theta[2 * m + m * k],
            }
            .spectrum(omega)
        })
    }
}

impl Shared {
    /// What a record of this model lets one know of its modes, all C and Λ unknown.
    pub fn least(&self, n: usize) -> Least {
        let (m, k) = (self.modes.len(), self.c.len());
        let q = self.c[0].len();
        let mut theta = of_modes(&self.modes);
        theta.extend(self.c.iter().flatten());
        for i in 0..k {
            theta.extend((0..=i).map(|j| self.lambda[(i, j)]));
        }
        least(&theta, m, n, |theta, omega| {
            let (c, lambda) = theta[2 * m..].split_at(k * q);
            let at = |i: usize, j: usize| lambda[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)];
            Shared {
                modes: modes_of(theta, m),
                c: c.chunks(q).map(<[f64]>::to_vec).collect(),
                lambda: DMatrix::from_fn(k, k, at),
            }
            .spectrum(omega)
        })
    }
}
