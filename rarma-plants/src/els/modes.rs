//! Natural frequencies and shapes.

use super::assembly::{ElsModel, SLOPE_X, SLOPE_Y, TWIST, X, Y};
use super::error::ElsModelError;
use core::f64::consts::TAU;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Steps of the QR iteration for each eigenvalue at most; a few are usual.
const QR_STEPS: usize = 60;
/// A mode below this share of the highest eigenvalue costs no force.
const RIGID: f64 = 1e-12;

/// What a mode mostly is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Across the axis.
    Bending,
    /// About it.
    Torsion,
}

/// A natural mode without damping.
#[derive(Clone, Debug, PartialEq)]
pub struct NaturalMode {
    /// Frequency, Hz; 0 for a rigid motion.
    pub f_hz: f64,
    /// What it is, by kinetic energy.
    pub shape: Shape,
    /// Damping ratio that the loss factors give it: φᵀK_ηφ/(2ω²).
    pub zeta: f64,
    /// (z, x, y, twist) of each node, z in m from the tool joint; of unit modal mass, so
    /// 1/√kg and rad/(m·√kg).
    pub nodes: Vec<[f64; 4]>,
    /// How many of `nodes`, from the first, belong to the holder.
    pub holder_nodes: usize,
}

/// Eigenvalues (rising), vectors of unit modal mass, of K·φ = λ·M·φ.
pub(super) fn eigen(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
) -> Result<(DVector<f64>, DMatrix<f64>), ElsModelError> {
    let factor = m
        .clone()
        .cholesky()
        .ok_or(ElsModelError::Massless)?
        .unpack();
    let solved = |right: &DMatrix<f64>| {
        factor
            .solve_lower_triangular(right)
            .ok_or(ElsModelError::Massless)
    };
    // L⁻¹·K·L⁻ᵀ, symmetrised against rounding.
    let a = solved(&solved(k)?.transpose())?;
    let a = (&a + a.transpose()) * 0.5;
    if !a.iter().all(|x| x.is_finite()) {
        return Err(ElsModelError::Unsettled);
    }
    let most = QR_STEPS * a.nrows();
    let found = SymmetricEigen::try_new(a, f64::EPSILON, most).ok_or(ElsModelError::Unsettled)?;
    let mut order: Vec<usize> = (0..found.eigenvalues.len()).collect();
    order.sort_by(|&i, &j| found.eigenvalues[i].total_cmp(&found.eigenvalues[j]));
    let values = DVector::from_iterator(order.len(), order.iter().map(|&i| found.eigenvalues[i]));
    let vectors = found.eigenvectors.select_columns(&order);
    let back = factor
        .transpose()
        .solve_upper_triangular(&vectors)
        .ok_or(ElsModelError::Massless)?;
    Ok((values, back))
}

/// Number of eigenvalues that are zero to within rounding.
pub(super) fn rigid(values: &DVector<f64>) -> usize {
    let most = values.iter().copied().fold(0.0, f64::max);
    values.iter().filter(|v| **v < RIGID * most).count()
}

impl ElsModel {
    /// The lowest `count` natural modes with the link under `load_n`, rigid ones included.
    ///
    /// # Errors
    /// A load out of range; a segment without mass.
    pub fn natural_modes(
        &self,
        load_n: f64,
        count: usize,
    ) -> Result<Vec<NaturalMode>, ElsModelError> {
        let (k, lossy) = self.linked(load_n)?;
        let (values, vectors) = eigen(&k, &self.mass)?;
        let rigid = rigid(&values);
        Ok((0..count.min(values.len()))
            .map(|i| {
                let phi = vectors.column(i).into_owned();
                let value = if i < rigid { 0.0 } else { values[i] };
                let lost = phi.dot(&(&lossy * &phi));
                NaturalMode {
                    f_hz: value.max(0.0).sqrt() / TAU,
                    shape: self.shape(&phi),
                    zeta: if value > 0.0 { 0.5 * lost / value } else { 0.0 },
                    nodes: self.picture(&phi),
                    holder_nodes: self.holder_m.len(),
                }
            })
            .collect())
    }

    fn shape(&self, phi: &DVector<f64>) -> Shape {
        let moving = &self.mass * phi;
        let energy = |coordinates: &[usize]| -> f64 {
            let nodes = self.holder_m.len() + self.spindle_m.len();
            (0..nodes)
                .flat_map(|n| coordinates.iter().filter_map(move |&c| self.row(n, c)))
                .map(|r| phi[r] * moving[r])
                .sum()
        };
        if energy(&[TWIST]) > energy(&[X, SLOPE_X, Y, SLOPE_Y]) {
            Shape::Torsion
        } else {
            Shape::Bending
        }
    }

    fn picture(&self, phi: &DVector<f64>) -> Vec<[f64; 4]> {
        let value = |node, c| self.row(node, c).map_or(0.0, |r| phi[r]);
        let first = self.holder_m.len();
        let holder = self.holder_m.iter().copied().enumerate();
        let spindle = self.spindle_m.iter().enumerate();
        holder
            .chain(spindle.map(|(k, z)| (first + k, self.nose_m + z)))
            .map(|(n, z)| [z, value(n, X), value(n, Y), value(n, TWIST)])
            .collect()
    }
}
