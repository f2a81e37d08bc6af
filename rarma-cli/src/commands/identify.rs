//! `rarma identify`: one model of a whole recording.

mod methods;
mod page;

use super::band::{self, Part};
use super::channels;
use super::estimators::{self, IdentifiedMode, Memory, residuals};
use super::fitting::{REMEDY, criteria, with_stack};
use super::show;
use crate::args::{IdentifyArgs, Method};
use crate::failure::Failure;
use crate::report::sheet_told;
use rarma_fit::Whiteness;
use rarma_recordings::input::Recording;
use serde::Serialize;
use std::path::Path;

/// Lags of the whiteness test, beyond the parameters.
const WHITENESS_LAGS: usize = 20;
/// Lags at most.
const MOST_LAGS: usize = 2 * estimators::MAX_ORDER + WHITENESS_LAGS;

/// A model and how good it is: the JSON of `rarma identify`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identified {
    /// Estimator.
    pub method: &'static str,
    /// `[p, q]`.
    pub order: [usize; 2],
    /// Band that was looked at, `[LO, HI]`, Hz; null for all of the recording.
    pub band: Option<[f64; 2]>,
    /// Rate of the samples that were fitted, Hz.
    pub fs: f64,
    /// How many they are.
    pub n: usize,
    /// a₁…a_p of A(q) = 1 + Σ aᵢ q⁻ⁱ.
    pub a: Vec<f64>,
    /// c₁…c_q of C(q) = 1 + Σ cᵢ q⁻ⁱ.
    pub c: Vec<f64>,
    /// Innovation variance: the method's own, or that of the residuals.
    pub sigma2: f64,
    /// Mean of the recording, where it was removed.
    pub mean: f64,
    /// Modes in the band, sorted by frequency.
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

/// Refuses an order that the method does not fit.
fn possible(args: &IdentifyArgs) -> Result<(), Failure> {
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
    Ok(())
}

pub(super) fn main(args: &IdentifyArgs) -> Result<u8, Failure> {
    if args.several.channels.is_some() {
        return channels::main(args);
    }
    possible(args)?;
    let part = Part::read(&args.input, args.band, args.detrend)?;
    let work = estimators::work(args.method, part.samples.len(), args.order);
    part.warn_of(work, &args.input.input);
    let bar = show::waiting(format!(
        "fitting {} samples by {}",
        part.samples.len(),
        args.method.name()
    ));
    let found = fit_named(&part, args, &args.input.input);
    bar.finish_and_clear();
    let found = found?;
    if let Some(dir) = &args.report {
        let bar = show::waiting("other orders and methods".to_owned());
        let title = args.input.input.display().to_string();
        let html = page::html(&part, &found, args, &title);
        bar.finish_and_clear();
        sheet_told(dir, html, args.json)?;
    }
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
        "ARMA({},{}) by {} over {} samples at {} Hz{}, innovation variance {:.6e}",
        m.order[0],
        m.order[1],
        m.method,
        m.n,
        m.fs,
        m.band
            .map(|[low, high]| format!(", band {low}:{high} Hz"))
            .unwrap_or_default(),
        m.sigma2
    );
    for (name, values) in [("a", &m.a), ("c", &m.c)] {
        let words: Vec<String> = values.iter().map(|x| format!("{x:.6}")).collect();
        say!("  {name} = [{}]", words.join(", "));
    }
    for mode in &m.modes {
        // Where there is no deviation JSON says null.
        let sd = |sd: f64, digits: usize| match sd.is_finite() {
            true => format!("{sd:.digits$}"),
            false => "?".to_owned(),
        };
        say!(
            "  {:10.2} Hz ± {}   damping {:.3} % ± {}",
            mode.f,
            sd(mode.f_sd, 2),
            100.0 * mode.zeta,
            sd(100.0 * mode.zeta_sd, 3)
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

/// Fits a model of any order up to (30,30) to a series as it is, without its trend;
/// `args.band` does not count.
///
/// # Errors
/// What is wrong with the series, without its name.
pub fn identify(series: &[f64], fs: f64, args: &IdentifyArgs) -> Result<Identified, String> {
    let part = Part::whole(series, fs, args.detrend);
    with_stack(|| fit_part(&part, args))
}

/// What `rarma identify` says of a recording that has been read; `args.input` does not count.
///
/// # Errors
/// As those of the command.
pub fn identify_recording(
    recording: &Recording,
    args: &IdentifyArgs,
) -> Result<Identified, Failure> {
    possible(args)?;
    let part = Part::of(recording, args.band, args.detrend)?;
    fit_named(&part, args, &recording.path)
}

fn fit_named(part: &Part, args: &IdentifyArgs, file: &Path) -> Result<Identified, Failure> {
    with_stack(|| fit_part(part, args))
        .map_err(|why| Failure::Input(format!("{}: {why}", file.display())))
}

fn fit_part(part: &Part, args: &IdentifyArgs) -> Result<Identified, String> {
    let (p, q) = args.order;
    let k = p + q;
    let y = &part.samples;
    let n = y.len();
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
    let variance = part.variance()?;
    let memory = Memory {
        forgetting: args.forgetting,
        random_walk: args.random_walk,
    };
    let (a, c, own_sigma2, modes, own_residuals) = if k == 0 {
        (Vec::new(), Vec::new(), Some(variance), Vec::new(), None)
    } else {
        let model = estimators::fit(args.method, y, args.order, memory)
            .map_err(|why| format!("whole file: {why} {REMEDY}"))?;
        let modes = part
            .modes(&model)
            .ok_or_else(|| format!("whole file: the roots of A were not found {REMEDY}"))?;
        let rest = model.own_residuals().map(<[f64]>::to_vec);
        (model.a, model.c, model.sigma2, modes, rest)
    };
    // The first residuals lack their past: they are left out.
    let lacking = if own_residuals.is_some() {
        0
    } else {
        p.max(q).min(n / 4)
    };
    let errors = own_residuals.unwrap_or_else(|| residuals(y, &a, &c));
    let used = &errors[lacking..];
    // A tone has frequency, amplitude and phase, whatever order it is written as.
    let k = if args.method == Method::Tones {
        3 * p / 2
    } else {
        k
    };
    let sigma2 = own_sigma2.unwrap_or(used.iter().map(|e| e * e).sum::<f64>() / used.len() as f64);
    let criteria = criteria(sigma2, n, k).map_err(|why| format!("whole file: {why}"))?;
    let lags = k + WHITENESS_LAGS;
    let whiteness_p = (used.len() >= 4 * lags)
        .then(|| Whiteness::of::<MOST_LAGS>(used.iter().copied(), lags, k).ok())
        .flatten()
        .map(|w| w.probability)
        .filter(|p| p.is_finite());
    let found = Identified {
        method: args.method.name(),
        order: [p, q],
        band: band::in_json(part.band),
        fs: part.fs,
        n,
        a,
        c,
        sigma2,
        mean: part.mean,
        modes,
        aic: criteria.aic,
        bic: criteria.bic,
        fpe: criteria.fpe,
        whiteness_p,
    };
    let numbers = [found.sigma2, found.aic, found.bic, found.fpe, found.mean];
    let modes = found.modes.iter().flat_map(|m| [m.f, m.zeta]);
    let coefficients = found.a.iter().chain(&found.c).copied();
    if coefficients
        .chain(numbers)
        .chain(modes)
        .any(|x| !x.is_finite())
    {
        return Err(format!("whole file: the model overflows {REMEDY}"));
    }
    Ok(found)
}
