//! The line estimators behind `rarma identify`: subspace and tones.

use super::{IdentifiedMode, MAX_ORDER, Model, N, Uncertainty, with_moving_average};
use rarma_fit::{FitError, ToneFit};
use std::f64::consts::TAU;

/// Half the window of the subspace at most.
const H: usize = 128;
/// Parameters of the tones at most: three each.
const PARAMETERS: usize = 3 * MAX_ORDER / 2;

/// Fitted tones and what they leave of the series.
#[derive(Debug, Clone)]
pub(in crate::commands) struct Tones {
    fit: ToneFit<f64, PARAMETERS>,
    rest: Vec<f64>,
}

/// A from the signal subspace, C from what A leaves.
pub(super) fn subspace(y: &[f64], (p, q): (usize, usize)) -> Result<Model, FitError> {
    let fit = rarma_fit::esprit::<f64, N, H>(y, p)?;
    with_moving_average(y, fit.a(), q)
}

/// p/2 tones: A with its roots on the circle, and C = A, as tones in white noise are.
pub(super) fn tones(y: &[f64], (p, q): (usize, usize)) -> Result<Model, FitError> {
    let fit = rarma_fit::tones::<f64, PARAMETERS, H>(y, p / 2)?;
    let mut a = vec![1.0];
    let mut rest = y.to_vec();
    // Radians per sample are frequencies at a rate of 2π.
    for tone in (0..fit.tones()).filter_map(|k| fit.tone(k, TAU)) {
        a.resize(a.len() + 2, 0.0);
        for i in (1..a.len()).rev() {
            let before = if i > 1 { a[i - 2] } else { 0.0 };
            a[i] += before - 2.0 * tone.frequency.cos() * a[i - 1];
        }
        for (t, e) in rest.iter_mut().enumerate() {
            *e -= tone.amplitude * (tone.frequency * t as f64 + tone.phase).cos();
        }
    }
    a.remove(0);
    Ok(Model {
        c: if q == 0 { Vec::new() } else { a.clone() },
        a,
        sigma2: Some(fit.sigma2()),
        uncertainty: Uncertainty::Tones(Box::new(Tones { fit, rest })),
    })
}

impl Tones {
    pub(super) fn residuals(&self) -> &[f64] {
        &self.rest
    }

    pub(super) fn modes(&self, fs: f64) -> Vec<IdentifiedMode> {
        (0..self.fit.tones())
            .filter_map(|k| self.fit.tone(k, fs))
            .map(|tone| IdentifiedMode {
                f: tone.frequency,
                f_sd: tone.frequency_sd,
                zeta: 0.0,
                zeta_sd: 0.0,
                amplitude: Some(tone.amplitude),
            })
            .collect()
    }
}
