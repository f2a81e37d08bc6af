//! Receptances.

use super::assembly::{ElsModel, X, Y};
use super::config::Place;
use super::error::{ElsModelError, check};
use super::modes::{eigen, rigid};
use core::f64::consts::TAU;
use nalgebra::{Complex, DMatrix};
use rarma_rigs::els;

/// Modes up to this multiple of the highest line are kept; the others answer statically.
const KEPT: f64 = 8.0;
const LEAST: usize = 20;

type Cx = Complex<f64>;

/// K + jK_η.
fn complex(re: &DMatrix<f64>, im: &DMatrix<f64>) -> DMatrix<Cx> {
    re.zip_map(im, Cx::new)
}

impl ElsModel {
    /// Receptance tensor at one place (u = x, v = y) at `f_hz`, the link under `load_n`:
    ///
    /// ```text
    /// G(ω) = bᵀ(K + jK_η − ω²M)⁻¹b
    /// ```
    ///
    /// by modes up to eight times the highest line, coupled by the loss factors as they
    /// are, and the static answer of all others.
    ///
    /// # Errors
    /// As [`Self::natural_modes`]; frequencies or a place out of range; `Singular` where
    /// a motion is free and 0 Hz is asked for.
    pub fn receptance(
        &self,
        load_n: f64,
        place: Place,
        f_hz: &[f64],
    ) -> Result<Vec<els::Receptance<f64>>, ElsModelError> {
        check(f_hz.iter().all(|f| f.is_finite() && *f >= 0.0), "f_hz")?;
        let (k, lossy) = self.linked(load_n)?;
        let (values, vectors) = eigen(&k, &self.mass)?;
        let free = rigid(&values);
        if free > 0 && f_hz.contains(&0.0) {
            return Err(ElsModelError::Singular { free });
        }
        let top = f_hz.iter().copied().fold(0.0, f64::max) * TAU * KEPT;
        let kept = values.iter().filter(|v| **v < top * top).count();
        // Free motions have no static answer: keep every mode.
        let kept = if free > 0 {
            values.len()
        } else {
            kept.max(LEAST).min(values.len())
        };
        let phi = vectors.columns(0, kept).into_owned();
        let input = self.input(place)?;
        let seen = phi.transpose() * &input;
        let small_k = DMatrix::from_diagonal(&values.rows(0, kept).into_owned());
        let small = complex(&small_k, &(phi.transpose() * &lossy * &phi));
        let seen = seen.map(|x| Cx::new(x, 0.0));
        let solved = |a: DMatrix<Cx>, b: &DMatrix<Cx>| {
            let x = a.lu().solve(b).ok_or(ElsModelError::Singular { free })?;
            Ok(b.transpose() * x)
        };
        let rest = if kept < values.len() {
            let whole = input.map(|x| Cx::new(x, 0.0));
            solved(complex(&k, &lossy), &whole)? - solved(small.clone(), &seen)?
        } else {
            DMatrix::zeros(2, 2)
        };
        f_hz.iter()
            .map(|f| {
                let mut a = small.clone();
                for i in 0..kept {
                    a[(i, i)] -= Cx::new((TAU * f).powi(2), 0.0);
                }
                let g = solved(a, &seen)? + &rest;
                Ok(tensor(&g))
            })
            .collect()
    }

    /// The same at one frequency without modes, by one solution of the whole system: the
    /// check of [`Self::receptance`].
    ///
    /// # Errors
    /// As there.
    pub fn receptance_direct(
        &self,
        load_n: f64,
        place: Place,
        f_hz: f64,
    ) -> Result<els::Receptance<f64>, ElsModelError> {
        let (k, lossy) = self.linked(load_n)?;
        let a = complex(&(k - &self.mass * (TAU * f_hz).powi(2)), &lossy);
        let b = self.input(place)?.map(|x| Cx::new(x, 0.0));
        let x = a
            .lu()
            .solve(&b)
            .ok_or(ElsModelError::Singular { free: 1 })?;
        Ok(tensor(&(b.transpose() * x)))
    }

    /// Unit forces along x and y at a place.
    pub(super) fn input(&self, place: Place) -> Result<DMatrix<f64>, ElsModelError> {
        let node = self.node(place)?;
        let mut b = DMatrix::zeros(self.size(), 2);
        for (column, c) in [X, Y].into_iter().enumerate() {
            if let Some(row) = self.row(node, c) {
                b[(row, column)] = 1.0;
            }
        }
        Ok(b)
    }
}

fn tensor(g: &DMatrix<Cx>) -> els::Receptance<f64> {
    let of = |i, j| {
        let z: Cx = g[(i, j)];
        els::Complex::new(z.re, z.im)
    };
    els::Receptance {
        resp_u_exc_u: of(0, 0),
        resp_u_exc_v: of(0, 1),
        resp_v_exc_u: of(1, 0),
        resp_v_exc_v: of(1, 1),
    }
}
