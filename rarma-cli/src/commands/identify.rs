//! `rarma identify`: one model of a whole recording.

use super::estimators::{self, IdentifiedMode, Memory};
use super::monitor::read;
use crate::args::{Detrend, IdentifyArgs, Method};
use crate::failure::Failure;
use rarma_core::estimate::batch::{Criteria, Whiteness};
use serde::Serialize;

/// Lags of the whiteness test, beyond the parameters.
const WHITENESS_LAGS: usize = 20;
/// Lags at most.
const MOST_LAGS: usize = 2 * estimators::MAX_ORDER + WHITENESS_LAGS;
/// The largest models keep their arrays on the stack.
const STACK_BYTES: usize = 64 << 20;

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
    /// Innovation variance: the method's own, or that of the residuals.
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
    /// Probability of residuals this coloured if they are white (Ljung–Box); null
    /// for too few of them.
    pub whiteness_p: Option<f64>,
}

pub(super) fn main(args: &IdentifyArgs) -> Result<u8, Failure> {
    if args.method.is_autoregressive() && args.order.1 > 0 {
        return Err(Failure::Usage(format!(
            "--method {} fits autoregressive models only: --order must be {},0",
            args.method.name(),
            args.order.0
        )));
    }
    let largest = if args.method.is_autoregressive() {
        estimators::N
    } else {
        estimators::MAX_ORDER
    };
    if args.order.0 > largest {
        return Err(Failure::Usage(format!(
            "--method {} fits p up to {largest}, not {}",
            args.method.name(),
            args.order.0
        )));
    }
    let (p, q) = args.order;
    if args.method == Method::Tones && (p == 0 || p % 2 == 1 || (q != p && q != 0)) {
        return Err(Failure::Usage(format!(
            "--method tones fits p/2 tones: --order must be 2k,2k or 2k,0, not {p},{q}"
        )));
    }
    let recording = read(&args.input)?;
    let file = recording.path.display().to_string();
    let found = identify(&recording.samples, recording.fs, args)
        .map_err(|why| Failure::whole(&file, why, "record longer, or choose a lower order"))?;
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
        if let Some(amplitude) = mode.amplitude {
            say!("             amplitude {amplitude:.4e}");
        }
    }
    say!("  AIC {:.2}  BIC {:.2}  FPE {:.6e}", m.aic, m.bic, m.fpe);
    match m.whiteness_p {
        Some(p) => say!("  residuals white with probability {p:.3} (Ljung-Box)"),
        None => say!("  too few samples to test the residuals"),
    }
}

/// Fits a model of any order up to (30,30) to a series.
///
/// # Errors
/// What is wrong with the series, without its name.
pub fn identify(series: &[f64], fs: f64, args: &IdentifyArgs) -> Result<Identified, String> {
    with_stack(|| identify_here(series, fs, args))
}

/// Runs a fit on a thread with room for the largest models.
pub(super) fn with_stack<V: Send>(
    fit: impl FnOnce() -> Result<V, String> + Send,
) -> Result<V, String> {
    std::thread::scope(|scope| {
        std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, fit)
            .map_err(|why| format!("no thread for the fit: {why}"))?
            .join()
            .map_err(|_| "the fit broke off: a defect of this program".to_owned())?
    })
}

fn identify_here(series: &[f64], fs: f64, args: &IdentifyArgs) -> Result<Identified, String> {
    let (p, q) = args.order;
    let k = p + q;
    let n = series.len();
    let needed = if args.method.is_autoregressive() && p > estimators::MAX_ORDER {
        k + k / 2 + 10
    } else {
        2 * k + 10
    };
    if n < needed {
        return Err(format!(
            "end of data: {n} samples are too few for order {p},{q}, which needs at least {needed} (record longer or choose a lower order)"
        ));
    }
    let (mean, y) = detrended(series, args.detrend);
    let variance = y.iter().map(|x| x * x).sum::<f64>() / n as f64;
    let scale = series.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(variance > (scale * 1e-12).powi(2)) {
        return Err("whole file: nothing is left once the trend is removed: the series is constant (check the sensor)".to_owned());
    }
    let memory = Memory {
        forgetting: args.forgetting,
        random_walk: args.random_walk,
    };
    let (a, c, own_sigma2, modes, own_residuals) = if k == 0 {
        (Vec::new(), Vec::new(), Some(variance), Vec::new(), None)
    } else {
        let model = estimators::fit(args.method, &y, args.order, memory)
            .map_err(|why| format!("whole file: {why}"))?;
        let modes = model
            .modes(fs)
            .ok_or("whole file: the roots of A were not found")?;
        let rest = model.own_residuals().map(<[f64]>::to_vec);
        (model.a, model.c, model.sigma2, modes, rest)
    };
    // The first residuals lack their past: they are left out.
    let lacking = if own_residuals.is_some() {
        0
    } else {
        p.max(q).min(n / 4)
    };
    let errors = own_residuals.unwrap_or_else(|| residuals(&y, &a, &c));
    let used = &errors[lacking..];
    // A tone has frequency, amplitude and phase, whatever order it is written as.
    let k = if args.method == Method::Tones {
        3 * p / 2
    } else {
        k
    };
    let sigma2 = own_sigma2.unwrap_or(used.iter().map(|e| e * e).sum::<f64>() / used.len() as f64);
    let criteria =
        Criteria::of(sigma2, n, k).map_err(|why| format!("whole file: criteria: {why}"))?;
    let lags = k + WHITENESS_LAGS;
    let whiteness_p = (used.len() >= 4 * lags)
        .then(|| Whiteness::of::<MOST_LAGS>(used.iter().copied(), lags, k).ok())
        .flatten()
        .map(|w| w.probability);
    Ok(Identified {
        method: args.method.name(),
        order: [p, q],
        fs,
        n,
        a,
        c,
        sigma2,
        mean,
        modes,
        aic: criteria.aic,
        bic: criteria.bic,
        fpe: criteria.fpe,
        whiteness_p,
    })
}

/// The mean, and the series without its trend.
pub(super) fn detrended(series: &[f64], how: Detrend) -> (f64, Vec<f64>) {
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

/// Residuals e = A/C·y of a fixed model, conditional on its start: the first p are 0.
pub(super) fn residuals(y: &[f64], a: &[f64], c: &[f64]) -> Vec<f64> {
    let mut e: Vec<f64> = Vec::with_capacity(y.len());
    for (t, &x) in y.iter().enumerate() {
        if t < a.len() {
            e.push(0.0);
            continue;
        }
        let past = |v: &[f64], i: usize| if t > i { v[t - 1 - i] } else { 0.0 };
        let ar: f64 = a.iter().enumerate().map(|(i, a)| a * past(y, i)).sum();
        let ma: f64 = c.iter().enumerate().map(|(i, c)| c * past(&e, i)).sum();
        e.push(x + ar - ma);
    }
    e
}
