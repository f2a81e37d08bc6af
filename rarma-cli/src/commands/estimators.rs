//! The estimators behind `rarma identify` and `rarma order`, by name.

mod lines;

use crate::args::Method;
use rarma_core::estimate::{BoundedArma, Gain, Gradient, IvConfig, RarmaConfig, RecursiveIv};
use rarma_core::spectrum::{FactorTracker, Quadratic, Roots, deviation, modal};
use rarma_fit::{ArFit, ArmaFit, Bound, FitError, Ml, MlConfig, Pem, PemConfig, earlier_errors};
use serde::Serialize;

/// Largest p and q.
pub const MAX_ORDER: usize = 30;
/// Parameters at most, and the largest p of an autoregressive method.
pub const N: usize = 2 * MAX_ORDER;
/// [`work`] that takes a minute or two.
pub const MINUTES: f64 = 1.5e9;
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

impl Memory {
    /// Of everything.
    pub const WHOLE: Self = Self {
        forgetting: 1.0,
        random_walk: 0.0,
    };
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
    pub(super) uncertainty: Uncertainty,
}

/// Where the standard deviations come from.
#[derive(Debug, Clone)]
pub(super) enum Uncertainty {
    /// The fit's own covariance.
    Fit(Box<ArmaFit<f64, N>>),
    /// The recursion's covariance.
    Recursion(Box<BoundedArma<f64>>),
    /// The Cramér–Rao bound of the model that was found.
    Bound(usize),
    /// Tones: they are the modes, and what they leave is the noise.
    Tones(Box<lines::Tones>),
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
    /// Amplitude (peak), input units; of tones only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<f64>,
}

/// What a fit costs, about: samples times squared parameters, as often as the method goes
/// through them against `pem`.
pub fn work(method: Method, samples: usize, (p, q): (usize, usize)) -> f64 {
    let weight = match method {
        Method::Pem => 1.0,
        // 50 s for 5 s, (8,7) over 110 000 samples.
        Method::Ml => 10.0,
        Method::Tones => 20.0,
        _ => 0.0,
    };
    weight * samples as f64 * ((p + q) as f64).powi(2)
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
        Method::Rpem | Method::Rplr | Method::Gradient => {
            return recursive(method, y, (p, q), memory);
        }
        Method::Pem => Pem::new(PemConfig::default()).and_then(|m| m.fit::<N>(y, p, q)),
        Method::Ml => Ml::new(MlConfig {
            with_mean: false,
            ..MlConfig::default()
        })
        .and_then(|m| m.fit::<N, R>(y, p, q)),
        Method::Burg => return Ok(autoregressive(rarma_fit::burg(y, p).map_err(words)?)),
        Method::YuleWalker => {
            return Ok(autoregressive(rarma_fit::yule_walker(y, p).map_err(words)?));
        }
        Method::LeastSquares => {
            return Ok(autoregressive(rarma_fit::covariance(y, p).map_err(words)?));
        }
        Method::Lattice => {
            return Ok(autoregressive(
                rarma_fit::geometric_lattice(y, p).map_err(words)?,
            ));
        }
        Method::Riv => return recursive_instruments(y, (p, q), memory),
        Method::Iv => return instruments(y, (p, q)).map_err(words),
        Method::Esprit => return lines::subspace(y, (p, q)).map_err(words),
        Method::Tones => return lines::tones(y, (p, q)).map_err(words),
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

/// A by instrumental variables, C from what A leaves.
fn instruments(y: &[f64], (p, q): (usize, usize)) -> Result<Model, FitError> {
    let lags = (4 * p).min(y.len() / 4).max(p);
    let fit: ArFit<f64, N> = rarma_fit::instrumental_variables(y, p, q, lags)?;
    with_moving_average(y, fit.a(), q)
}

/// A model of a given A, with C from what A leaves by the innovations algorithm.
pub(super) fn with_moving_average(y: &[f64], a: &[f64], q: usize) -> Result<Model, FitError> {
    let c = if q == 0 {
        Vec::new()
    } else {
        let rest = residuals(y, a, &[]);
        let rows = (4 * q).min(N);
        let moving = rarma_fit::innovations_algorithm::<f64, N>(&rest[a.len()..], q, rows)?;
        moving.c().to_vec()
    };
    Ok(Model {
        a: a.to_vec(),
        c,
        sigma2: None,
        uncertainty: Uncertainty::Bound(y.len()),
    })
}

/// A by one pass of recursive instrumental variables, C from what A leaves.
fn recursive_instruments(
    y: &[f64],
    (p, q): (usize, usize),
    memory: Memory,
) -> Result<Model, String> {
    let name = Method::Riv.name();
    let config = IvConfig {
        forgetting: memory.forgetting,
        ..IvConfig::default()
    };
    let mut model = RecursiveIv::<f64, MAX_ORDER>::new(p, q, config)
        .ok_or_else(|| format!("{name}: p must be 1 to {MAX_ORDER} and q at most {MAX_ORDER}"))?;
    for &x in y {
        model.update(x);
    }
    if model.a().iter().any(|x| !x.is_finite()) {
        return Err(format!("{name}: the estimate is not finite"));
    }
    with_moving_average(y, model.a(), q).map_err(|why| format!("{name}: {why}"))
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
        gain: match method {
            Method::Gradient => Gain::normalised(),
            _ => Gain::Covariance,
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
        uncertainty: match method {
            // Its covariance is that of the start-up, not of the model.
            Method::Gradient => Uncertainty::Bound(y.len()),
            _ => Uncertainty::Recursion(Box::new(model)),
        },
    })
}

impl Model {
    /// What the model leaves of the series, where that is not A/C·y.
    pub fn own_residuals(&self) -> Option<&[f64]> {
        match &self.uncertainty {
            Uncertainty::Tones(tones) => Some(tones.residuals()),
            _ => None,
        }
    }

    /// Modes sorted by frequency; none if the roots of A are not found.
    pub fn modes(&self, fs: f64) -> Option<Vec<IdentifiedMode>> {
        let p = self.a.len();
        if p == 0 {
            return Some(Vec::new());
        }
        if let Uncertainty::Tones(tones) = &self.uncertainty {
            return Some(tones.modes(fs));
        }
        let bound = Bound::<f64, N>::of(&self.a, &self.c).ok();
        modes_of(&self.a, fs, |factor| {
            let Roots::Pair { re, im } = factor.roots() else {
                return None;
            };
            match &self.uncertainty {
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
                Uncertainty::Tones(_) => None,
            }
        })
    }
}

/// Modes of A sorted by frequency, with the deviations of frequency (Hz) and damping that `sd`
/// gives for a pole pair; none if the roots of A are not found.
pub fn modes_of(
    a: &[f64],
    fs: f64,
    sd: impl Fn(&Quadratic<f64>) -> Option<(f64, f64)>,
) -> Option<Vec<IdentifiedMode>> {
    let mut roots = FactorTracker::<f64, N>::new();
    roots.solve(a, 4000)?;
    let mode = |factor: &Quadratic<f64>| {
        let mode = modal(factor, fs)?;
        let (f_sd, zeta_sd) = sd(factor).unwrap_or((f64::NAN, f64::NAN));
        Some(IdentifiedMode {
            f: mode.frequency,
            f_sd,
            zeta: mode.damping,
            zeta_sd,
            amplitude: None,
        })
    };
    let mut modes: Vec<IdentifiedMode> = roots.factors(a.len()).iter().filter_map(mode).collect();
    modes.sort_by(|x, y| x.f.total_cmp(&y.f));
    Some(modes)
}

/// Residuals e = A/C·y of a fixed model. The first p are not known: the last q of them stand as what
/// the rest makes likely, the others as 0.
pub(super) fn residuals(y: &[f64], a: &[f64], c: &[f64]) -> Vec<f64> {
    let (p, q) = (a.len(), c.len());
    let earlier = earlier_errors::<f64, { N }>(y, a, c).unwrap_or([0.0; N]);
    // From e(p − q) on.
    let mut e: Vec<f64> = earlier[..q].iter().rev().copied().collect();
    for t in p..y.len() {
        let ar: f64 = a.iter().zip(y[..t].iter().rev()).map(|(a, y)| a * y).sum();
        let ma: f64 = c.iter().zip(e.iter().rev()).map(|(c, e)| c * e).sum();
        e.push(y[t] + ar - ma);
    }
    let mut out = vec![0.0; p.saturating_sub(q)];
    out.extend_from_slice(&e[q.saturating_sub(p)..]);
    out.truncate(y.len());
    out
}
