//! `rarma choose-order`: which order and structure reads a virtual cut right.
//!
//! Batch identification over candidates against the roots of the delay equation,
//! then the recursive estimator with the choice.

use super::band::detrended;
use super::estimators::residuals;
use super::estimators::{self, IdentifiedMode, Memory};
use super::fitting::with_stack;
use super::{monitor, show};
use crate::args::{ChooseOrderArgs, Detrend, Method};
use crate::failure::Failure;
use crate::output;
use rarma_box::wire::MonitorJob;
use rarma_core::Order;
use rarma_core::monitor::MonitorConfig;
use rarma_fit::Criteria;
use rarma_plants::delay::{DepthSearch, Root};
use rarma_plants::truth::{limit_of, roots};
use rarma_scenarios::ear::{self, Forced, Heard};
use rarma_scenarios::scenario::{self, Loaded};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;
use std::path::Path;

/// Roots damped more than this are no vibration that a model of low order finds.
const MOST_DAMPED: f64 = 0.12;
/// Roots that are looked for.
const ROOTS: usize = 24;
/// A mode within this part of a root's frequency is taken for it.
const MATCH: f64 = 0.04;
/// A cut that is unstable at its depth is looked at this part of its limit.
const STABLE_PART: f64 = 0.8;
/// A lower order is taken if its factor is larger by no more than this one.
const SIMPLER: f64 = 1.05;
/// Factor that a root not found, or read as growing, counts.
const MISSED: f64 = 100.0;

/// One candidate, over all runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OrderCandidate {
    /// `[p, q]`.
    pub order: [usize; 2],
    /// The box has it.
    pub in_box: bool,
    /// Factor by which ζ is off, the geometric mean over roots and runs; a root not
    /// found counts 100.
    pub zeta_factor: f64,
    /// Mean relative error of f over the roots that were found.
    pub f_error: f64,
    /// Roots not found, over all runs.
    pub missed: usize,
    /// Akaike's criterion, mean over the runs.
    pub aic: f64,
    /// Final prediction error, mean over the runs.
    pub fpe: f64,
}

pub(super) fn main(args: &ChooseOrderArgs) -> Result<u8, Failure> {
    let loaded = scenario::load(&args.scenario, args.seed)?;
    let seed = args.seed.unwrap_or(1);
    let (depth_m, why) = depth(args, &loaded)?;
    let process = &loaded.scenario.process;
    let plant = |why| Failure::whole(&args.scenario, why, "correct the fields it names");
    let all = roots(process, f64::INFINITY, depth_m, ROOTS).map_err(plant)?;
    let band = loaded.band();
    let truth = ear::dominant(process, &ear::audible(&all, band, MOST_DAMPED));
    if truth.is_empty() {
        return Err(Failure::Input(format!(
            "{}: box: no root of the cut with ζ below {MOST_DAMPED} lies in the band {}:{} Hz (choose another band)",
            args.scenario, band.low_hz, band.high_hz
        )));
    }
    let heard: Vec<(Heard, Heard)> = (0..args.runs as u64)
        .into_par_iter()
        .map(|k| {
            let cut = ear::held(&loaded, process, depth_m, args.seconds, seed + 1000 * k);
            let kept = ear::hear(&cut, band, Forced::Kept)?;
            let free = if args.with_forced {
                kept.clone()
            } else {
                ear::hear(&cut, band, Forced::Removed)?
            };
            Ok((kept, free))
        })
        .collect::<Result<_, Failure>>()?;
    let (heard, free): (Vec<Heard>, Vec<Heard>) = heard.into_iter().unzip();
    let candidates = compare(&free, &truth, args.max);
    let Some(chosen) = choose(&candidates) else {
        return Err(Failure::System(
            "no order of the box could be fitted: a defect of this program".to_owned(),
        ));
    };
    let order = Order::new(chosen.order[0], chosen.order[1]).unwrap_or(loaded.hints.order);
    let job = job(&loaded, order, heard[0].fs);
    let on_free = recursive(&job, &free, &truth)?;
    let recursive = recursive(&job, &heard, &truth)?;
    if let Some(path) = &args.settings {
        write_settings(path, &job)?;
    }
    if args.json {
        let report = json!({
            "scenario": loaded.scenario.name,
            "depth_mm": 1e3 * depth_m,
            "truth": truth.iter().map(|r| json!({ "f": r.f_hz, "zeta": r.zeta })).collect::<Vec<_>>(),
            "candidates": candidates,
            "choice": chosen.order,
            "forced_removed": !args.with_forced,
            "recursive": recursive,
            "recursive_free": on_free,
        });
        say!("{report}");
        return Ok(0);
    }
    say!(
        "{} at {:.3} mm ({why}), {} runs of {} s, forced vibration {}",
        loaded.scenario.name,
        1e3 * depth_m,
        args.runs,
        args.seconds,
        if args.with_forced { "kept" } else { "removed" }
    );
    for r in &truth {
        say!("  true root {:8.1} Hz  ζ {:+.3} %", r.f_hz, 100.0 * r.zeta);
    }
    say!("    p  q   ζ off by     error of f  missed          AIC          FPE");
    for c in &candidates {
        say!(
            "   {:2} {:2}   ×{:8.3}    {:8.3} %  {:6}  {:11.1}  {:11.4e}{}{}",
            c.order[0],
            c.order[1],
            c.zeta_factor,
            100.0 * c.f_error,
            c.missed,
            c.aic,
            c.fpe,
            if c.in_box { "" } else { "  (not in the box)" },
            if c.order == chosen.order { " <" } else { "" }
        );
    }
    explain(&candidates, chosen);
    tell_recursive(
        "The recursive estimator with it, as the box hears it",
        &truth,
        &recursive,
    );
    if !args.with_forced {
        tell_recursive("The same without the forced vibration", &truth, &on_free);
    }
    if let Some(path) = &args.settings {
        say!("Settings: {}", path.display());
    }
    Ok(0)
}

fn tell_recursive(what: &str, truth: &[Root], found: &[Option<IdentifiedMode>]) {
    say!("{what}:");
    for (r, found) in truth.iter().zip(found) {
        match found {
            Some(m) => say!(
                "  {:8.1} Hz: reads {:8.1} Hz ({:+.2} %), ζ {:.3} % for {:.3} % ({:+.0} %)",
                r.f_hz,
                m.f,
                100.0 * (m.f / r.f_hz - 1.0),
                100.0 * m.zeta,
                100.0 * r.zeta,
                100.0 * (m.zeta / r.zeta - 1.0)
            ),
            None => say!("  {:8.1} Hz: not found", r.f_hz),
        }
    }
}

/// The depth at which the cut is looked at, and why.
fn depth(args: &ChooseOrderArgs, loaded: &Loaded) -> Result<(f64, &'static str), Failure> {
    if let Some(mm) = args.depth_mm {
        return Ok((1e-3 * mm, "as told"));
    }
    let process = &loaded.scenario.process;
    let deepest = process.depth().largest();
    if !(deepest > 0.0) {
        return Err(Failure::Usage(
            "--depth-mm: must be given, the scenario cuts nothing".to_owned(),
        ));
    }
    let search = DepthSearch {
        low_m: 0.01 * deepest,
        high_m: deepest,
        ratio: 1.1,
        tolerance: 1e-4,
    };
    Ok(match limit_of(process, f64::INFINITY, &search) {
        Ok(limit) => (
            STABLE_PART * limit.depth_m,
            "0.8 of the limit: a root is only read in a stable cut",
        ),
        Err(_) => (deepest, "its largest"),
    })
}

/// Every candidate over every run.
fn compare(heard: &[Heard], truth: &[Root], max: usize) -> Vec<OrderCandidate> {
    let orders: Vec<(usize, usize)> = (2..=max)
        .flat_map(|p| [(p, 0), (p, p - 1), (p, p)])
        .collect();
    let bar = show::progress(orders.len() as u64, "fitting");
    let found = orders
        .into_par_iter()
        .filter_map(|(p, q)| {
            let mut zeta = Vec::new();
            let mut f = Vec::new();
            let (mut missed, mut aic, mut fpe, mut fits) = (0, 0.0, 0.0, 0.0);
            for run in heard {
                let Some((modes, criteria)) = fit(run, (p, q), max) else {
                    missed += truth.len();
                    zeta.extend(truth.iter().map(|_| MISSED.ln()));
                    continue;
                };
                for r in truth {
                    match nearest(&modes, r.f_hz) {
                        Some(m) => {
                            zeta.push(off(m.zeta, r.zeta));
                            f.push((m.f / r.f_hz - 1.0).abs());
                        }
                        None => {
                            missed += 1;
                            zeta.push(MISSED.ln());
                        }
                    }
                }
                aic += criteria.aic;
                fpe += criteria.fpe;
                fits += 1.0;
            }
            bar.inc(1);
            (fits > 0.0).then(|| OrderCandidate {
                order: [p, q],
                in_box: Order::new(p, q).is_some(),
                zeta_factor: mean(&zeta).exp(),
                f_error: mean(&f),
                missed,
                aic: aic / fits,
                fpe: fpe / fits,
            })
        })
        .collect();
    bar.finish_and_clear();
    found
}

fn fit(
    run: &Heard,
    order: (usize, usize),
    max: usize,
) -> Option<(Vec<IdentifiedMode>, Criteria<f64>)> {
    let (_, y) = detrended(&run.band, Detrend::Mean);
    let memory = Memory {
        forgetting: 1.0,
        random_walk: 0.0,
    };
    let method = if order.1 == 0 {
        Method::LeastSquares
    } else {
        Method::Pem
    };
    let model = with_stack(|| estimators::fit(method, &y, order, memory)).ok()?;
    let modes = model.modes(run.band_fs)?;
    let errors = residuals(&y, &model.a, &model.c);
    let used = errors.get(max..)?;
    let sigma2 = used.iter().map(|e| e * e).sum::<f64>() / used.len() as f64;
    let criteria = Criteria::of(sigma2, used.len(), order.0 + order.1).ok()?;
    Some((modes, criteria))
}

/// The mode taken for a root: of those near its frequency the least damped.
fn nearest(modes: &[IdentifiedMode], f: f64) -> Option<IdentifiedMode> {
    modes
        .iter()
        .filter(|m| (m.f / f - 1.0).abs() < MATCH)
        .min_by(|a, b| (a.f - f).abs().total_cmp(&(b.f - f).abs()))
        .copied()
}

/// |ln| of the ratio of two dampings.
fn off(read: f64, truth: f64) -> f64 {
    if read > 0.0 && truth > 0.0 {
        (read / truth).ln().abs().min(MISSED.ln())
    } else {
        MISSED.ln()
    }
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// The box's order whose ζ is off least; a lower one if it is hardly worse.
fn choose(candidates: &[OrderCandidate]) -> Option<&OrderCandidate> {
    let best = candidates
        .iter()
        .filter(|c| c.in_box)
        .map(|c| c.zeta_factor)
        .fold(f64::INFINITY, f64::min);
    candidates
        .iter()
        .filter(|c| c.in_box && c.zeta_factor <= SIMPLER * best)
        .min_by_key(|c| c.order[0] + c.order[1])
}

fn explain(candidates: &[OrderCandidate], chosen: &OrderCandidate) {
    let by = |key: fn(&OrderCandidate) -> f64| {
        candidates
            .iter()
            .min_by(|a, b| key(a).total_cmp(&key(b)))
            .map_or([0, 0], |c| c.order)
    };
    let (aic, fpe) = (by(|c| c.aic), by(|c| c.fpe));
    say!(
        "Choice: order {},{}: ζ off by a factor of {:.2}, the least in the box or within 5 % of it at the lowest order. AIC asks for {},{}, FPE for {},{}.",
        chosen.order[0],
        chosen.order[1],
        chosen.zeta_factor,
        aic[0],
        aic[1],
        fpe[0],
        fpe[1]
    );
}

fn job(loaded: &Loaded, order: Order, fs: f64) -> MonitorJob {
    let process = &loaded.scenario.process;
    MonitorJob {
        monitor: MonitorConfig {
            full_scale: Some(1.0),
            band: Some(loaded.band()),
            order,
            spindle_hz: Some(process.spindle_hz()),
            teeth: u32::try_from(process.teeth()).ok(),
            ..MonitorConfig::new(fs)
        },
        channel: 0,
        every_s: 0.01,
    }
}

/// Median reading of the box near each root, over the second half of every run.
fn recursive(
    job: &MonitorJob,
    heard: &[Heard],
    truth: &[Root],
) -> Result<Vec<Option<IdentifiedMode>>, Failure> {
    let runs = heard
        .par_iter()
        .map(|h| monitor::listen(job, h.samples.iter().map(|x| *x as f32), |_| {}))
        .collect::<Result<Vec<_>, _>>()?;
    Ok(truth
        .iter()
        .map(|r| {
            let (mut f, mut zeta) = (Vec::new(), Vec::new());
            for run in &runs {
                let half = run.lines.len() / 2;
                for line in &run.lines[half..] {
                    let near = line
                        .modes
                        .iter()
                        .filter(|m| (m.f / r.f_hz - 1.0).abs() < MATCH)
                        .min_by(|a, b| (a.f - r.f_hz).abs().total_cmp(&(b.f - r.f_hz).abs()));
                    if let Some(m) = near {
                        f.push(m.f);
                        zeta.push(m.zeta);
                    }
                }
            }
            Some(IdentifiedMode {
                f: median(&mut f)?,
                f_sd: f64::NAN,
                zeta: median(&mut zeta)?,
                zeta_sd: f64::NAN,
                amplitude: None,
            })
        })
        .collect())
}

fn median(x: &mut [f64]) -> Option<f64> {
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied()
}

/// JSON for people and hosts; postcard, as a box reads it, for any other ending.
fn write_settings(path: &Path, job: &MonitorJob) -> Result<(), Failure> {
    let bytes = if path.extension().is_some_and(|e| e == "json") {
        serde_json::to_vec_pretty(job).map_err(std::io::Error::from)?
    } else {
        let mut buffer = [0; 256];
        postcard::to_slice(job, &mut buffer)
            .map_err(|why| Failure::System(format!("{}: {why}", path.display())))?
            .to_vec()
    };
    Ok(output::write(path, bytes)?)
}
