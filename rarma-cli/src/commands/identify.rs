//! `rarma identify`: one ARMA model of a whole recording.

use super::monitor::read;
use crate::args::{Detrend, IdentifyArgs, Method};
use crate::failure::Failure;
use rarma_core::estimate::{BoundedArma, Gradient, RarmaConfig};
use rarma_core::spectrum::{FactorTracker, deviation, modal};
use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Lags of the whiteness test, beyond the parameters.
const WHITENESS_LAGS: usize = 20;

/// One mode of a model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct IdentifiedMode {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Standard deviation of it, Hz.
    pub f_sd: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Standard deviation of it.
    pub zeta_sd: f64,
}

/// A model and how good it is: the JSON of `rarma identify`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identified {
    /// Estimator.
    pub method: &'static str,
    /// `[p, q]`.
    pub order: [usize; 2],
    /// Sampling rate, Hz.
    pub fs: f64,
    /// Samples used.
    pub n: usize,
    /// a₁…a_p of A(q) = 1 + Σ aᵢ q⁻ⁱ.
    pub a: Vec<f64>,
    /// c₁…c_q of C(q) = 1 + Σ cᵢ q⁻ⁱ.
    pub c: Vec<f64>,
    /// Variance of the residuals of the final model over the whole recording.
    pub sigma2: f64,
    /// Mean that was removed.
    pub mean: f64,
    /// Modes sorted by frequency.
    pub modes: Vec<IdentifiedMode>,
    /// n·ln σ² + 2k.
    pub aic: f64,
    /// n·ln σ² + k·ln n.
    pub bic: f64,
    /// σ²(n + k)/(n − k).
    pub fpe: f64,
    /// Probability of residuals this coloured if they are white (Ljung–Box).
    pub whiteness_p: Option<f64>,
}

pub(super) fn main(args: &IdentifyArgs) -> Result<u8, Failure> {
    let recording = read(&args.input)?;
    let file = recording.path.display().to_string();
    let found = identify(&recording.samples, recording.fs, args)
        .map_err(|why| Failure::Input(format!("{file}: {why}")))?;
    if args.json {
        let text = serde_json::to_string(&found).map_err(std::io::Error::from)?;
        say!("{text}");
    } else {
        show(&found);
    }
    Ok(0)
}

fn show(m: &Identified) {
    say!(
        "ARMA({},{}) by {} over {} samples at {} Hz, innovation variance {:.6e}",
        m.order[0],
        m.order[1],
        m.method,
        m.n,
        m.fs,
        m.sigma2
    );
    for (name, values) in [("a", &m.a), ("c", &m.c)] {
        let words: Vec<String> = values.iter().map(|x| format!("{x:.6}")).collect();
        say!("  {name} = [{}]", words.join(", "));
    }
    for mode in &m.modes {
        say!(
            "  {:10.2} Hz ± {:.2}   damping {:.3} % ± {:.3}",
            mode.f,
            mode.f_sd,
            100.0 * mode.zeta,
            100.0 * mode.zeta_sd
        );
    }
    say!("  AIC {:.2}  BIC {:.2}  FPE {:.6e}", m.aic, m.bic, m.fpe);
    match m.whiteness_p {
        Some(p) => say!("  residuals white with probability {p:.3} (Ljung-Box)"),
        None => say!("  too few samples to test the residuals"),
    }
}

/// Fits an ARMA model of any order up to (30,30) to a series.
///
/// # Errors
/// What is wrong with the series, without its name.
pub fn identify(series: &[f64], fs: f64, args: &IdentifyArgs) -> Result<Identified, String> {
    let (p, q) = args.order;
    let k = p + q;
    let n = series.len();
    if n < 2 * k + 10 {
        return Err(format!(
            "end of data: {n} samples are too few for order {p},{q}, which needs at least {} (record longer or choose a lower order)",
            2 * k + 10
        ));
    }
    let (mean, y) = detrended(series, args.detrend);
    let variance = y.iter().map(|x| x * x).sum::<f64>() / n as f64;
    let scale = series.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(variance > (scale * 1e-12).powi(2)) {
        return Err("whole file: nothing is left once the trend is removed: the series is constant (check the sensor)".to_owned());
    }
    let mut found = Identified {
        method: args.method.name(),
        order: [p, q],
        fs,
        n,
        a: Vec::new(),
        c: Vec::new(),
        sigma2: variance,
        mean,
        modes: Vec::new(),
        aic: 0.0,
        bic: 0.0,
        fpe: 0.0,
        whiteness_p: None,
    };
    let mut residuals = y.clone();
    if let Some(mut model) = BoundedArma::new(p, q, config(args, n)) {
        for &x in &y {
            model.update(x);
        }
        found.a = model.a().to_vec();
        found.c = model.c().to_vec();
        if found.a.iter().chain(&found.c).any(|x| !x.is_finite()) {
            return Err("whole file: the estimate is not finite".to_owned());
        }
        residuals = filtered(&y, &found.a, &found.c);
        found.modes = modes(&model, p, k, fs).ok_or("whole file: the roots of A were not found")?;
    }
    // The first samples lack their past: leave them out of the variance.
    let from = p.max(q).min(n / 4);
    let used = &residuals[from..];
    found.sigma2 = used.iter().map(|e| e * e).sum::<f64>() / used.len() as f64;
    let (nf, kf) = (n as f64, k as f64);
    found.aic = nf * found.sigma2.ln() + 2.0 * kf;
    found.bic = nf * found.sigma2.ln() + kf * nf.ln();
    found.fpe = found.sigma2 * (nf + kf) / (nf - kf);
    found.whiteness_p = whiteness(used, k);
    Ok(found)
}

/// Settings that suit the length: a short series has no thousand samples to spare
/// for the start.
fn config(args: &IdentifyArgs, n: usize) -> RarmaConfig<f64> {
    let part = |wanted: usize, share: usize| wanted.min(n / share) as u32;
    RarmaConfig {
        gradient: match args.method {
            Method::Rpem => Gradient::Filtered,
            Method::Rplr => Gradient::Pseudo,
        },
        forgetting: args.forgetting,
        random_walk: args.random_walk,
        settle_samples: part(64, 40),
        autoregressive_samples: part(320, 10),
        startup_samples: part(1000, 4),
        ..RarmaConfig::default()
    }
}

/// The mean, and the series without its trend.
fn detrended(series: &[f64], how: Detrend) -> (f64, Vec<f64>) {
    let n = series.len() as f64;
    let mean = series.iter().sum::<f64>() / n;
    match how {
        Detrend::None => (0.0, series.to_vec()),
        Detrend::Mean => (mean, series.iter().map(|x| x - mean).collect()),
        Detrend::Linear => {
            let centre = (n - 1.0) / 2.0;
            let (mut sxy, mut sxx) = (0.0, 0.0);
            for (i, x) in series.iter().enumerate() {
                let t = i as f64 - centre;
                sxy += t * (x - mean);
                sxx += t * t;
            }
            let slope = sxy / sxx;
            let line = |i: usize| mean + slope * (i as f64 - centre);
            let rest = series.iter().enumerate().map(|(i, x)| x - line(i));
            (mean, rest.collect())
        }
    }
}

/// Residuals e = A/C·y of a fixed model, from rest.
fn filtered(y: &[f64], a: &[f64], c: &[f64]) -> Vec<f64> {
    let mut e: Vec<f64> = Vec::with_capacity(y.len());
    for (t, &x) in y.iter().enumerate() {
        let past = |v: &[f64], i: usize| if t > i { v[t - 1 - i] } else { 0.0 };
        let ar: f64 = a.iter().enumerate().map(|(i, a)| a * past(y, i)).sum();
        let ma: f64 = c.iter().enumerate().map(|(i, c)| c * past(&e, i)).sum();
        e.push(x + ar - ma);
    }
    e
}

/// Modes of the model with their uncertainty; none if the roots are not found.
fn modes(model: &BoundedArma<f64>, p: usize, n: usize, fs: f64) -> Option<Vec<IdentifiedMode>> {
    if p == 0 {
        return Some(Vec::new());
    }
    let mut roots = FactorTracker::<f64, 30>::new();
    roots.solve(model.a(), 2000)?;
    let (covariance, scale) = model.covariance();
    let mut modes: Vec<IdentifiedMode> = roots
        .factors(p)
        .iter()
        .filter_map(|factor| {
            let mode = modal(factor, fs)?;
            let sd = deviation(model.a(), n, factor, fs, covariance, scale)?;
            Some(IdentifiedMode {
                f: mode.frequency,
                f_sd: sd.frequency,
                zeta: mode.damping,
                zeta_sd: sd.damping,
            })
        })
        .collect();
    modes.sort_by(|x, y| x.f.total_cmp(&y.f));
    Some(modes)
}

/// Ljung–Box: Q = n(n+2) Σ r_k²/(n−k), chi-squared with lags − k degrees of freedom.
fn whiteness(e: &[f64], parameters: usize) -> Option<f64> {
    let n = e.len();
    let lags = parameters + WHITENESS_LAGS;
    if n < 4 * lags {
        return None;
    }
    let power: f64 = e.iter().map(|x| x * x).sum();
    let mut q = 0.0;
    for k in 1..=lags {
        let r = e[k..].iter().zip(e).map(|(x, y)| x * y).sum::<f64>() / power;
        q += r * r / (n - k) as f64;
    }
    q *= n as f64 * (n as f64 + 2.0);
    let distribution = ChiSquared::new(WHITENESS_LAGS as f64).ok()?;
    Some(distribution.sf(q))
}
