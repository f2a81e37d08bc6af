//! Modes of the model of one order.

use super::error::ChannelError;
use super::perturbation::{Pole, deviation};
use super::shape::{ChannelMode, ShapePart};
use super::subspace::{SWEEPS, Subspace};
use alloc::vec;
use alloc::vec::Vec;
use core::f64::consts::TAU;
use nalgebra::{Complex, DMatrix, DMatrixView, DVector, Schur};

type Number = Complex<f64>;

/// The realised model, its eigenvalues and vectors.
struct Model {
    /// (O↑ᵀO↑)⁻¹.
    inverse: DMatrix<f64>,
    values: Vec<Number>,
    /// Columns φ.
    vectors: DMatrix<Number>,
    /// Rows are the left eigenvectors, of product 1 with those of the right.
    left: DMatrix<Number>,
}

impl Subspace {
    /// Modes of the model of `order` states, sorted by frequency: those of the oscillating pairs
    /// of poles, `order`/2 at most, growing ones (ζ < 0) among them. `fs` is the rate, Hz.
    ///
    /// # Errors
    /// `Order` if it is none that [`most_order`](Self::most_order) allows, `OutOfRange` if `fs`
    /// is no rate, `Singular` if the record holds fewer states, or poles that cannot be told
    /// apart.
    pub fn modes(&self, order: usize, fs: f64) -> Result<Vec<ChannelMode>, ChannelError> {
        let most = self.most_order();
        if !(1..=most).contains(&order) {
            return Err(ChannelError::Order { most });
        }
        if !(fs > 0.0 && fs.is_finite()) {
            return Err(ChannelError::OutOfRange { setting: "fs" });
        }
        if !(self.sigma[order - 1] > f64::EPSILON * self.sigma.len() as f64 * self.sigma[0]) {
            return Err(ChannelError::Singular);
        }
        let model = self.realise(order)?;
        let turns: Vec<DMatrix<f64>> = self
            .turns
            .iter()
            .map(|turn| self.observability_turn(turn, order))
            .collect();
        let mut modes: Vec<ChannelMode> = (0..order)
            .filter(|i| model.values[*i].im > 0.0)
            .map(|i| self.mode(&model, i, &turns, fs))
            .collect();
        modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        Ok(modes)
    }

    /// Rows of the observability matrix without the last channel of rows, and without the first.
    fn shifted<'a>(&self, o: &'a DMatrix<f64>) -> [DMatrixView<'a, f64>; 2] {
        let r = self.scale.len();
        [0, r].map(|from| o.rows(from, o.nrows() - r))
    }

    fn realise(&self, n: usize) -> Result<Model, ChannelError> {
        let o = self.u.columns(0, n).into_owned();
        let [up, down] = self.shifted(&o);
        let inverse = up
            .tr_mul(&up)
            .cholesky()
            .ok_or(ChannelError::Singular)?
            .inverse();
        let a = &inverse * up.tr_mul(&down);
        let schur =
            Schur::try_new(a.clone(), f64::EPSILON, SWEEPS).ok_or(ChannelError::Singular)?;
        let values: Vec<Number> = schur.complex_eigenvalues().iter().copied().collect();
        let a = a.map(|x| Number::new(x, 0.0));
        let mut vectors = DMatrix::zeros(n, n);
        for (i, value) in values.iter().enumerate() {
            let vector = eigenvector(&a, *value).ok_or(ChannelError::Singular)?;
            vectors.set_column(i, &vector);
        }
        let left = vectors
            .clone()
            .try_inverse()
            .filter(|w| w.iter().all(|x| x.re.is_finite() && x.im.is_finite()))
            .ok_or(ChannelError::Singular)?;
        Ok(Model {
            inverse,
            values,
            vectors,
            left,
        })
    }

    fn mode(&self, model: &Model, i: usize, turns: &[DMatrix<f64>], fs: f64) -> ChannelMode {
        let n = model.values.len();
        let (lambda, phi) = (model.values[i], model.vectors.column(i).into_owned());
        let o = self.u.columns(0, n).into_owned();
        let r = self.scale.len();
        let through = |o: &DMatrix<f64>, x: &DVector<Number>| {
            let part = |pick: fn(&Number) -> f64| o * x.map(|x| pick(&x));
            let (re, im) = (part(|x| x.re), part(|x| x.im));
            DVector::from_fn(o.nrows(), |k, _| Number::new(re[k], im[k]))
        };
        let seen = through(&o, &phi);
        let m = seen.len();
        let step = |x: &DVector<Number>| DVector::from_fn(m - r, |k, _| x[k + r] - lambda * x[k]);
        // What the least squares of the shift leaves over of this mode.
        let rest = step(&seen);
        let [up, _] = self.shifted(&o);
        let (up, inverse) = (up.transpose(), &model.inverse);
        let psi: Vec<Number> = (0..r).map(|c| seen[c] * self.scale[c]).collect();
        let largest = (0..r)
            .max_by(|a, b| psi[*a].norm_sqr().total_cmp(&psi[*b].norm_sqr()))
            .unwrap_or(0);
        let shape: Vec<Number> = psi.iter().map(|x| x / psi[largest]).collect();
        let pole = Pole::of(lambda);
        let mut changes = Changes::new(r);
        for turn in turns {
            let moved = through(turn, &phi);
            let [turn_up, _] = self.shifted(turn);
            let right = through(&turn_up.transpose(), &rest) + through(&up, &step(&moved));
            let c = &model.left * through(inverse, &right);
            let (omega, damping) = pole.change(c[i]);
            changes.omega.push(omega);
            changes.damping.push(damping);
            let mut by = DVector::from_element(n, Number::new(0.0, 0.0));
            for k in (0..n).filter(|k| *k != i) {
                let share = c[k] / (lambda - model.values[k]);
                by.axpy(share, &model.vectors.column(k), Number::new(1.0, 0.0));
            }
            let seen_by = through(&o.rows(0, r).into_owned(), &by);
            let change = |c: usize| (moved[c] + seen_by[c]) * self.scale[c];
            let reference = change(largest);
            for (c, x) in shape.iter().enumerate() {
                let d = (change(c) - x * reference) / psi[largest];
                // Along the number, and across it.
                let turned = x.conj() * d / libm::hypot(x.re, x.im);
                changes.magnitude[c].push(turned.re);
                changes.across[c].push(turned.im);
            }
        }
        let sd = |d: &[f64]| deviation(d, self.neighbours);
        ChannelMode {
            frequency: pole.omega * fs / TAU,
            frequency_sd: sd(&changes.omega) * fs / TAU,
            damping: pole.damping,
            damping_sd: sd(&changes.damping),
            shape: shape
                .iter()
                .enumerate()
                .map(|(c, x)| ShapePart {
                    re: x.re,
                    im: x.im,
                    magnitude_sd: sd(&changes.magnitude[c]),
                    phase_sd: sd(&changes.across[c]) / libm::hypot(x.re, x.im),
                })
                .collect(),
        }
    }
}

/// Changes of one mode, one a stretch.
struct Changes {
    omega: Vec<f64>,
    damping: Vec<f64>,
    magnitude: Vec<Vec<f64>>,
    across: Vec<Vec<f64>>,
}

impl Changes {
    fn new(channels: usize) -> Self {
        Self {
            omega: Vec::new(),
            damping: Vec::new(),
            magnitude: vec![Vec::new(); channels],
            across: vec![Vec::new(); channels],
        }
    }
}

/// Distance of the shift from the eigenvalue, relative.
const SHIFT: f64 = 1e-10;

/// The vector that (A − λI) takes to nothing, by inverse iteration.
fn eigenvector(a: &DMatrix<Number>, lambda: Number) -> Option<DVector<Number>> {
    let n = a.nrows();
    let shift = lambda * (1.0 + SHIFT);
    let mut shifted = a.clone();
    for i in 0..n {
        shifted[(i, i)] -= shift;
    }
    let lu = shifted.lu();
    let mut x = DVector::from_fn(n, |i, _| Number::new(1.0, (i + 1) as f64 / n as f64));
    for _ in 0..3 {
        x = lu.solve(&x)?;
        let length = x.norm();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        x.unscale_mut(length);
    }
    Some(x)
}
