//! The page of `rarma order`: the diagram over orders, its columns, the criteria, and how good the
//! chosen model is.

use super::{Candidate, Choice, agreed};
use crate::args::Method;
use crate::commands::band::Part;
use crate::commands::estimators::residuals;
use crate::commands::estimators::{self, Memory};
use crate::commands::fitting::with_stack;
use crate::commands::model_pictures::{DiagramPole, densities, diagram, residuals as left_over};
use crate::commands::psd;
use rarma_fit::Whiteness;
use rarma_pictures::{Chart, Mark, Scale, Series, sheet, table};

/// Lags of the residuals, beyond the parameters.
const LAGS: usize = 20;
const MOST_LAGS: usize = 2 * estimators::MAX_ORDER + LAGS;
/// What the marks of the diagram mean.
pub(in crate::commands) const STABLE: &str = "Stable: within 1 % in frequency and 5 % in damping of a pole one order step below, at \
     (p − 1, q − 1).";

/// The page.
pub(super) fn html(part: &Part, found: &Choice, title: &str) -> String {
    let mut body = String::new();
    let estimate = psd::estimate(part);
    body += &diagram(
        &poles(&found.candidates, Some(found.choice)),
        &agreed(&found.candidates, found.choice),
        &estimate,
        part.edges(),
        "parameters p + q",
        STABLE,
    );
    body += "<h2>Columns: what several orders agree on</h2>\n";
    body += &columns(found);
    body += &criteria(found);
    body += &chosen(part, found, &estimate);
    let [p, q] = found.choice;
    let agreed = found.clusters.len();
    sheet(
        title,
        &format!(
            "Order ({p},{q}) by {}; {agreed} column{} of stable poles",
            found.criterion,
            if agreed == 1 { "" } else { "s" }
        ),
        &body,
        env!("CARGO_PKG_VERSION"),
    )
}

/// All poles of candidates, at the height of their parameters.
pub(in crate::commands) fn poles(
    candidates: &[Candidate],
    choice: Option<[usize; 2]>,
) -> Vec<DiagramPole> {
    candidates
        .iter()
        .flat_map(|c| c.modes.iter().map(move |m| (c, m)))
        .map(|(c, m)| DiagramPole {
            row: (c.order[0] + c.order[1]) as f64,
            f: m.f,
            f_sd: m.f_sd,
            stable: m.stable,
            stable_f: m.stable_f,
            chosen: choice == Some(c.order),
        })
        .collect()
}

fn columns(found: &Choice) -> String {
    if found.clusters.is_empty() {
        return "<p>None: no mode is stable in three candidates. Record longer, or look at a \
                narrower band.</p>\n"
            .to_owned();
    }
    let rows: Vec<Vec<String>> = found
        .clusters
        .iter()
        .map(|c| {
            vec![
                format!("{:.2} Hz", c.f),
                format!("{:.2} to {:.2} Hz", c.f_range[0], c.f_range[1]),
                format!("{:.3} %", 100.0 * c.zeta),
                format!(
                    "{:.3} to {:.3} %",
                    100.0 * c.zeta_range[0],
                    100.0 * c.zeta_range[1]
                ),
                format!("{} of {}", c.candidates, found.candidates.len()),
                if c.chosen { "yes" } else { "no" }.to_owned(),
            ]
        })
        .collect();
    table(
        &[
            "frequency, median",
            "between",
            "damping, median",
            "between",
            "stable in",
            "in the chosen model",
        ],
        &rows,
    )
}

/// Each criterion over the parameters, over its least value.
fn criteria(found: &Choice) -> String {
    let of = |name: &str, pick: fn(&Candidate) -> f64, colour| {
        let least = found.candidates.iter().map(pick).fold(f64::MAX, f64::min);
        let mut points: Vec<(f64, f64)> = found
            .candidates
            .iter()
            .map(|c| ((c.order[0] + c.order[1]) as f64, pick(c) - least))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Series {
            name: name.to_owned(),
            points,
            mark: Mark::Line,
            colour,
        }
    };
    let series = vec![of("BIC", |c| c.bic, 0), of("AIC", |c| c.aic, 1)];
    // The many that are far too small a model would flatten the rest.
    let mut all: Vec<f64> = series[0].points.iter().map(|p| p.1).collect();
    all.sort_by(f64::total_cmp);
    let top = 3.0 * all.get(all.len() / 2).copied().unwrap_or(1.0).max(10.0);
    let last = found
        .candidates
        .iter()
        .map(|c| c.order[0] + c.order[1])
        .max();
    Chart {
        title: "Criteria over orders".to_owned(),
        x: Scale::linear("parameters p + q", 0.0, last.unwrap_or(1) as f64 + 1.0),
        y: Scale::linear("above the least", 0.0, top),
        height: 200.0,
        series,
        caption:
            "The least is chosen. Orders whose value is far above the plot miss a mode; where \
                  the curve is flat, the order does not matter much."
                .to_owned(),
    }
    .figure()
}

/// Density and residuals of the chosen model.
fn chosen(part: &Part, found: &Choice, estimate: &[(f64, f64)]) -> String {
    let [p, q] = found.choice;
    let y = &part.samples;
    let Ok(model) = with_stack(|| estimators::fit(Method::Pem, y, (p, q), Memory::WHOLE)) else {
        return String::new();
    };
    let errors = residuals(y, &model.a, &model.c);
    let used = errors.get(p.max(q).min(errors.len() / 4)..).unwrap_or(&[]);
    let sigma2 = used.iter().map(|e| e * e).sum::<f64>() / used.len() as f64;
    let lags = p + q + LAGS;
    let probability = Whiteness::of::<MOST_LAGS>(used.iter().copied(), lags, p + q)
        .ok()
        .map(|w| w.probability);
    let curve = psd::of_model(part, (&model.a, &model.c), sigma2);
    densities(estimate, &curve, part.edges(), found.choice) + &left_over(used, lags, probability)
}
