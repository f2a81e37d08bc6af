//! `rarma order`: candidate orders with their criteria, and the choice.

use super::estimators::{self, Memory};
use super::identify::{self, with_stack};
use super::monitor::read;
use super::show;
use crate::args::{Criterion, Detrend, Method, OrderArgs};
use crate::failure::Failure;
use rarma_core::estimate::batch::Criteria;
use rarma_core::spectrum::{Modal, StabilisationConfig, Stability, stabilise};
use serde::Serialize;
use serde_json::json;

/// One mode of a candidate, against the candidate one order step below.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CandidateMode {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Damping ratio.
    pub zeta: f64,
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

pub(super) fn main(args: &OrderArgs) -> Result<u8, Failure> {
    let recording = read(&args.input)?;
    let file = recording.path.display().to_string();
    let (_, y) = identify::detrended(&recording.samples, Detrend::Mean);
    let candidates = candidates(&y, recording.fs, args.max);
    let Some(choice) = candidates
        .iter()
        .min_by(|x, y| x.by(args.criterion).total_cmp(&y.by(args.criterion)))
    else {
        return Err(Failure::Input(format!(
            "{file}: end of data: {} samples are too few for any candidate (record longer)",
            y.len()
        )));
    };
    let name = args.criterion.name();
    if args.json {
        let report = json!({
            "criterion": name,
            "choice": choice.order,
            "candidates": candidates,
        });
        say!("{report}");
    } else {
        say!("    p  q        AIC         AICc         BIC          FPE   modes, Hz and damping");
        for c in &candidates {
            let mark = if c.order == choice.order { "<" } else { " " };
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
        say!("  ** stable: within 1 % in f and 5 % in damping of a mode at p-1, q-1; * in f alone");
        say!(
            "Choice by {name}: order {},{}.",
            choice.order[0],
            choice.order[1]
        );
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

/// Orders (p, p−1) and (p, p) up to `max`: sampled vibration without and with white
/// sensor noise. A candidate that cannot be fitted is left out.
pub fn candidates(y: &[f64], fs: f64, max: usize) -> Vec<Candidate> {
    let orders: Vec<(usize, usize)> = (1..=max).flat_map(|p| [(p, p - 1), (p, p)]).collect();
    let bar = show::progress(orders.len() as u64, "fitting");
    let memory = Memory {
        forgetting: 1.0,
        random_walk: 0.0,
    };
    let mut found: Vec<Candidate> = orders
        .into_iter()
        .filter_map(|(p, q)| {
            bar.inc(1);
            let model = with_stack(|| estimators::fit(Method::Pem, y, (p, q), memory)).ok()?;
            // The same samples for all: those after the longest start.
            let errors = identify::residuals(y, &model.a, &model.c);
            let used = errors.get(max..)?;
            let n = used.len();
            let sigma2 = used.iter().map(|e| e * e).sum::<f64>() / n as f64;
            let criteria = Criteria::of(sigma2, n, p + q).ok()?;
            Some(Candidate {
                order: [p, q],
                sigma2,
                aic: criteria.aic,
                aicc: criteria.aicc,
                bic: criteria.bic,
                fpe: criteria.fpe,
                modes: modes(&model, fs),
            })
        })
        .collect();
    bar.finish_and_clear();
    mark(&mut found);
    found
}

/// Modes not yet compared; none if the roots are not found.
fn modes(model: &estimators::Model, fs: f64) -> Vec<CandidateMode> {
    let modes = model.modes(fs).unwrap_or_default();
    let mode = |m: &estimators::IdentifiedMode| CandidateMode {
        f: m.f,
        zeta: m.zeta,
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
