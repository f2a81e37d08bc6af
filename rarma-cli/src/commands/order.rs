//! `rarma order`: candidate orders with their criteria, and the choice.

mod clusters;
mod page;

pub use clusters::Cluster;
pub(super) use clusters::agreed;
pub(super) use page::{STABLE, poles};

use super::band::{self, Part};
use super::estimators::{self, Memory};
use super::fitting::{REMEDY, criteria, with_stack};
use super::show;
use crate::args::{Criterion, Detrend, Method, OrderArgs};
use crate::failure::Failure;
use crate::progress::ProgressBar;
use crate::report::sheet_told;
use rarma_core::spectrum::Modal;
use rarma_fit::{StabilisationConfig, Stability, stabilise};
use rarma_recordings::input::Recording;
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// What (1,0), the least of them, needs.
const LEAST_SAMPLES: usize = 13;

/// One mode of a candidate, against the candidate one order step below.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CandidateMode {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Standard deviation of it, Hz; null where none can be given.
    pub f_sd: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Standard deviation of it.
    pub zeta_sd: f64,
    /// The frequency is within tolerance of a mode one order step below.
    pub stable_f: bool,
    /// So are frequency and damping ratio.
    pub stable: bool,
}

/// One candidate.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// `[p, q]`.
    pub order: [usize; 2],
    /// Innovation variance over the same samples for every candidate.
    pub sigma2: f64,
    /// Akaike's criterion.
    pub aic: f64,
    /// The same, corrected for short series.
    pub aicc: f64,
    /// Schwarz' criterion.
    pub bic: f64,
    /// Final prediction error, input units squared.
    pub fpe: f64,
    /// Modes sorted by frequency; stable against (p−1, q−1).
    pub modes: Vec<CandidateMode>,
}

impl Candidate {
    fn by(&self, criterion: Criterion) -> f64 {
        match criterion {
            Criterion::Aic => self.aic,
            Criterion::Aicc => self.aicc,
            Criterion::Bic => self.bic,
            Criterion::Fpe => self.fpe,
        }
    }
}

/// The JSON of `rarma order`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// Band that was looked at, `[LO, HI]`, Hz; null for all of the recording.
    pub band: Option<[f64; 2]>,
    /// Every candidate that could be fitted.
    pub candidates: Vec<Candidate>,
    /// `[p, q]` of the best.
    pub choice: [usize; 2],
    /// Modes that several candidates agree on, sorted by frequency.
    pub clusters: Vec<Cluster>,
    /// By what it is the best.
    pub criterion: &'static str,
    /// Rate of the samples that were fitted, Hz.
    pub fs: f64,
    /// How many they are.
    pub n: usize,
}

/// What `rarma order` says of a recording that has been read; `args.input` does not count.
///
/// # Errors
/// As those of the command.
pub fn order_recording(recording: &Recording, args: &OrderArgs) -> Result<Choice, Failure> {
    let part = Part::of(recording, args.band, Detrend::Mean)?;
    choose(&part, args, &recording.path, &ProgressBar::hidden())
}

/// Fits every candidate, and takes the best.
fn choose(
    part: &Part,
    args: &OrderArgs,
    file: &Path,
    bar: &ProgressBar,
) -> Result<Choice, Failure> {
    let refused = |why: String| Failure::Input(format!("{}: {why}", file.display()));
    let n = part.samples.len();
    if n < LEAST_SAMPLES {
        return Err(refused(format!(
            "end of data: {n} samples are too few for any candidate (record longer)"
        )));
    }
    part.variance().map_err(refused)?;
    let candidates = candidates(part, orders(args.max).collect(), args.max, bar)
        .map_err(|why| refused(format!("whole file: no candidate could be fitted: {why}")))?;
    let choice = candidates
        .iter()
        .min_by(|x, y| x.by(args.criterion).total_cmp(&y.by(args.criterion)))
        .map(|c| c.order)
        .unwrap_or_default();
    Ok(Choice {
        band: band::in_json(part.band),
        clusters: clusters::clusters(&candidates, choice),
        candidates,
        choice,
        criterion: args.criterion.name(),
        fs: part.fs,
        n,
    })
}

pub(super) fn main(args: &OrderArgs) -> Result<u8, Failure> {
    let part = Part::read(&args.input, args.band, Detrend::Mean)?;
    let work = |order| estimators::work(Method::Pem, part.samples.len(), order);
    part.warn_of(orders(args.max).map(work).sum(), &args.input.input);
    let steps = orders(args.max).map(step_of).sum();
    let bar = show::progress(steps, "fitting");
    let found = choose(&part, args, &args.input.input, &bar);
    bar.finish_and_clear();
    let found = found?;
    let (choice, name) = (found.choice, found.criterion);
    if let Some(dir) = &args.report {
        let title = args.input.input.display().to_string();
        sheet_told(dir, page::html(&part, &found, &title), args.json)?;
    }
    if args.json {
        let text = serde_json::to_string(&found).map_err(std::io::Error::from)?;
        say!("{text}");
    } else {
        say!("{} samples, {}", found.n, part.words());
        say!("    p  q        AIC         AICc         BIC          FPE   modes, Hz and damping");
        for c in &found.candidates {
            let mark = if c.order == choice { "<" } else { " " };
            let modes: Vec<String> = c.modes.iter().map(word).collect();
            say!(
                "   {:2} {:2} {:12.2} {:12.2} {:12.2} {:12.5e} {mark} {}",
                c.order[0],
                c.order[1],
                c.aic,
                c.aicc,
                c.bic,
                c.fpe,
                modes.join("  ")
            );
        }
        for c in &found.clusters {
            say!(
                "  {} of {} candidates agree on {:.1} Hz ({:.1} to {:.1}), {:.2} % ({:.2} to {:.2})",
                c.candidates,
                found.candidates.len(),
                c.f,
                c.f_range[0],
                c.f_range[1],
                100.0 * c.zeta,
                100.0 * c.zeta_range[0],
                100.0 * c.zeta_range[1]
            );
        }
        say!("  ** stable: within 1 % in f and 5 % in damping of a mode at p-1, q-1; * in f alone");
        say!("Choice by {name}: order {},{}.", choice[0], choice[1]);
    }
    Ok(0)
}

fn word(mode: &CandidateMode) -> String {
    let mark = match (mode.stable, mode.stable_f) {
        (true, _) => "**",
        (_, true) => "*",
        _ => "",
    };
    format!("{:.1} {:.2} %{mark}", mode.f, 100.0 * mode.zeta)
}

/// (p, p−1) and (p, p) up to `max`: sampled vibration without and with white sensor noise.
fn orders(max: usize) -> impl Iterator<Item = (usize, usize)> {
    (1..=max).flat_map(|p| [(p, p - 1), (p, p)])
}

/// Models of some orders, p up to `max`, marked against the step below.
///
/// # Errors
/// Why the first one could not be fitted, if none could.
pub(super) fn models(
    part: &Part,
    orders: Vec<(usize, usize)>,
    max: usize,
) -> Result<Vec<Candidate>, String> {
    candidates(part, orders, max, &ProgressBar::hidden())
}

/// Steps of the bar that a candidate is.
fn step_of(order: (usize, usize)) -> u64 {
    estimators::work(Method::Pem, 1, order) as u64
}

/// A candidate that cannot be fitted is left out.
///
/// # Errors
/// Why the first one could not be, if none could.
fn candidates(
    part: &Part,
    orders: Vec<(usize, usize)>,
    max: usize,
    bar: &ProgressBar,
) -> Result<Vec<Candidate>, String> {
    bar.tick();
    // The longest first, one by one to whoever is free.
    let mut fitted: Vec<((usize, usize), Result<Candidate, String>)> = orders
        .into_par_iter()
        .rev()
        .with_max_len(1)
        .map(|order| {
            let candidate = candidate(part, order, max);
            bar.inc(step_of(order));
            (order, candidate)
        })
        .collect();
    fitted.reverse();
    let mut found = Vec::new();
    let mut first = None;
    for ((p, q), candidate) in fitted {
        match candidate {
            Ok(candidate) => found.push(candidate),
            Err(why) => _ = first.get_or_insert(format!("order {p},{q}: {why}")),
        }
    }
    match first {
        Some(why) if found.is_empty() => Err(why),
        _ => {
            mark(&mut found);
            Ok(found)
        }
    }
}

/// One fit by prediction error, over the same samples as all others: those after the
/// longest start.
fn candidate(part: &Part, (p, q): (usize, usize), max: usize) -> Result<Candidate, String> {
    let y = &part.samples;
    let model = with_stack(|| estimators::fit(Method::Pem, y, (p, q), Memory::WHOLE))
        .map_err(|why| format!("{why} {}", REMEDY))?;
    let errors = estimators::residuals(y, &model.a, &model.c);
    let used = errors.get(max..).unwrap_or_default();
    let n = used.len();
    let sigma2 = used.iter().map(|e| e * e).sum::<f64>() / n as f64;
    let criteria = criteria(sigma2, n, p + q)?;
    if !model.a.iter().chain(&model.c).all(|x| x.is_finite()) {
        return Err(format!("the model overflows {}", REMEDY));
    }
    Ok(Candidate {
        order: [p, q],
        sigma2,
        aic: criteria.aic,
        aicc: criteria.aicc,
        bic: criteria.bic,
        fpe: criteria.fpe,
        modes: modes(part, &model),
    })
}

/// Modes not yet compared; none if the roots are not found.
fn modes(part: &Part, model: &estimators::Model) -> Vec<CandidateMode> {
    let modes = part.modes(model).unwrap_or_default();
    let mode = |m: &estimators::IdentifiedMode| CandidateMode {
        f: m.f,
        f_sd: m.f_sd,
        zeta: m.zeta,
        zeta_sd: m.zeta_sd,
        stable_f: false,
        stable: false,
    };
    modes.iter().map(mode).collect()
}

/// Compares every candidate with (p−1, q−1).
fn mark(found: &mut [Candidate]) {
    let modal = |c: &Candidate| -> Vec<Modal<f64>> {
        let mode = |m: &CandidateMode| Modal {
            frequency: m.f,
            damping: m.zeta,
        };
        c.modes.iter().map(mode).collect()
    };
    let all: Vec<_> = found.iter().map(|c| (c.order, modal(c))).collect();
    for (candidate, (_, modes)) in found.iter_mut().zip(&all) {
        let [p, q] = candidate.order;
        let step_below = |(order, _): &&(_, _)| *order == [p.wrapping_sub(1), q.wrapping_sub(1)];
        let Some((_, below)) = all.iter().find(step_below) else {
            continue;
        };
        let mut marks = vec![Stability::New; modes.len()];
        if stabilise(&StabilisationConfig::default(), below, modes, &mut marks).is_ok() {
            for (mode, mark) in candidate.modes.iter_mut().zip(marks) {
                mode.stable_f = mark != Stability::New;
                mode.stable = mark == Stability::Stable;
            }
        }
    }
}
