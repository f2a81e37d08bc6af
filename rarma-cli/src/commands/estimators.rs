//! The estimators behind `rarma identify` and `rarma order`, by name.

use crate::args::Method;
use rarma_core::estimate::batch::{
    self, ArFit, ArmaFit, Bound, FitError, Ml, MlConfig, Pem, PemConfig,
};
use rarma_core::estimate::{BoundedArma, Gradient, RarmaConfig};
use rarma_core::spectrum::{FactorTracker, Roots, deviation, modal};
use serde::Serialize;

/// Largest p and q.
pub const MAX_ORDER: usize = 30;
/// Parameters at most.
const N: usize = 2 * MAX_ORDER;
/// States of the exact likelihood at most.
const R: usize = MAX_ORDER + 1;

/// Settings of the recursive methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Memory {
    /// Forgetting factor per sample.
    pub forgetting: f64,
    /// Random walk of every parameter, variance per sample.
    pub random_walk: f64,
}

/// A fitted model.
#[derive(Debug, Clone)]
pub struct Model {
    /// a₁…a_p.
    pub a: Vec<f64>,
    /// c₁…c_q.
    pub c: Vec<f64>,
    /// Innovation variance; none where the method leaves it to the residuals.
    pub sigma2: Option<f64>,
    uncertainty: Uncertainty,
}

/// Where the standard deviations come from.
#[derive(Debug, Clone)]
enum Uncertainty {
    /// The fit's own covariance.
    Fit(Box<ArmaFit<f64, N>>),
    /// The recursion's covariance.
    Recursion(Box<BoundedArma<f64>>),
    /// The Cramér–Rao bound of the model that was found.
    Bound(usize),
}

/// One mode of a model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct IdentifiedMode {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Standard deviation of it, Hz; null where none can be given.
    pub f_sd: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Standard deviation of it.
    pub zeta_sd: f64,
}

/// Fits a series whose mean has been removed.
///
/// # Errors
/// What stands against it, in words.
pub fn fit(
    method: Method,
    y: &[f64],
    (p, q): (usize, usize),
    memory: Memory,
) -> Result<Model, String> {
    let words = |why: FitError| format!("{}: {why}", method.name());
    let fit = match method {
        Method::Rpem | Method::Rplr => return recursive(method, y, (p, q), memory),
        Method::Pem => Pem::new(PemConfig::default()).and_then(|m| m.fit::<N>(y, p, q)),
        Method::Ml => Ml::new(MlConfig {
            with_mean: false,
            ..MlConfig::default()
        })
        .and_then(|m| m.fit::<N, R>(y, p, q)),
        Method::Burg => return Ok(autoregressive(batch::burg(y, p).map_err(words)?)),
        Method::YuleWalker => return Ok(autoregressive(batch::yule_walker(y, p).map_err(words)?)),
        Method::LeastSquares => return Ok(autoregressive(batch::covariance(y, p).map_err(words)?)),
        Method::Lattice => {
            return Ok(autoregressive(
                batch::geometric_lattice(y, p).map_err(words)?,
            ));
        }
        Method::Iv => return instruments(y, (p, q)).map_err(words),
    };
    let fit = fit.map_err(words)?;
    Ok(Model {
        a: fit.a().to_vec(),
        c: fit.c().to_vec(),
        sigma2: Some(fit.sigma2()),
        uncertainty: Uncertainty::Fit(Box::new(fit)),
    })
}

fn autoregressive(fit: ArFit<f64, N>) -> Model {
    Model {
        a: fit.a().to_vec(),
        c: Vec::new(),
        sigma2: Some(fit.sigma2()),
        uncertainty: Uncertainty::Bound(fit.samples()),
    }
}

/// A by instrumental variables, C from what A leaves by the innovations algorithm.
fn instruments(y: &[f64], (p, q): (usize, usize)) -> Result<Model, FitError> {
    let lags = (4 * p).clamp(p, y.len() / 4);
    let fit: ArFit<f64, N> = batch::instrumental_variables(y, p, q, lags)?;
    let a = fit.a().to_vec();
    let (c, sigma2) = if q == 0 {
        (Vec::new(), None)
    } else {
        let rest = super::identify::residuals(y, &a, &[]);
        let rows = (4 * q).min(N);
        let moving = batch::innovations_algorithm::<f64, N>(&rest[p..], q, rows)?;
        (moving.c().to_vec(), None)
    };
    Ok(Model {
        a,
        c,
        sigma2,
        uncertainty: Uncertainty::Bound(y.len()),
    })
}

/// One pass of the recursive estimator.
fn recursive(
    method: Method,
    y: &[f64],
    (p, q): (usize, usize),
    memory: Memory,
) -> Result<Model, String> {
    let config = RarmaConfig {
        gradient: match method {
            Method::Rplr => Gradient::Pseudo,
            _ => Gradient::Filtered,
        },
        forgetting: memory.forgetting,
        random_walk: memory.random_walk,
        ..RarmaConfig::default()
    };
    let mut model = BoundedArma::new(p, q, config)
        .ok_or_else(|| format!("{}: nothing to estimate at order 0,0", method.name()))?;
    for &x in y {
        model.update(x);
    }
    model.finish_start();
    if model.a().iter().chain(model.c()).any(|x| !x.is_finite()) {
        return Err(format!("{}: the estimate is not finite", method.name()));
    }
    Ok(Model {
        a: model.a().to_vec(),
        c: model.c().to_vec(),
        sigma2: None,
        uncertainty: Uncertainty::Recursion(Box::new(model)),
    })
}

impl Model {
    /// Modes sorted by frequency; none if the roots of A are not found.
    pub fn modes(&self, fs: f64) -> Option<Vec<IdentifiedMode>> {
        let p = self.a.len();
        if p == 0 {
            return Some(Vec::new());
        }
        let mut roots = FactorTracker::<f64, MAX_ORDER>::new();
        roots.solve(&self.a, 4000)?;
        let bound = Bound::<f64, N>::of(&self.a, &self.c).ok();
        let mut modes: Vec<IdentifiedMode> = roots
            .factors(p)
            .iter()
            .filter_map(|factor| {
                let mode = modal(factor, fs)?;
                let Roots::Pair { re, im } = factor.roots() else {
                    return None;
                };
                let sd = match &self.uncertainty {
                    Uncertainty::Fit(fit) => fit.pole(re, im, fs).map(|d| (d.frequency, d.damping)),
                    Uncertainty::Recursion(model) => {
                        let (covariance, scale) = model.covariance();
                        deviation(&self.a, p + self.c.len(), factor, fs, covariance, scale)
                            .map(|d| (d.frequency, d.damping))
                    }
                    Uncertainty::Bound(n) => bound
                        .as_ref()
                        .and_then(|b| b.pole(re, im, fs, *n))
                        .map(|d| (d.frequency, d.damping)),
                };
                let (f_sd, zeta_sd) = sd.unwrap_or((f64::NAN, f64::NAN));
                Some(IdentifiedMode {
                    f: mode.frequency,
                    f_sd,
                    zeta: mode.damping,
                    zeta_sd,
                })
            })
            .collect();
        modes.sort_by(|x, y| x.f.total_cmp(&y.f));
        Some(modes)
    }
}
