//! The page of `rarma identify`: the modes, poles over orders, the density of the model over the
//! estimate, the residuals, and other methods beside it.

use super::methods::{Reading, readings};
use super::{Identified, WHITENESS_LAGS, residuals};
use crate::args::{IdentifyArgs, Method};
use crate::commands::band::Part;
use crate::commands::estimators;
use crate::commands::model_pictures::{BAR, densities, diagram, residuals as left_over};
use crate::commands::order::{self, Candidate};
use crate::commands::psd;
use rarma_pictures::text::escape;
use rarma_pictures::{Chart, Mark, Scale, Series, sheet, table};

/// Orders above the one that was asked for, in the diagram.
const ABOVE: usize = 4;
/// A mode of another method is the same within this part of the frequency.
const SAME: f64 = 0.03;

/// The page.
pub(super) fn html(part: &Part, found: &Identified, args: &IdentifyArgs, title: &str) -> String {
    let mut body = String::from("<h2>Modes</h2>\n");
    body += &modes(found);
    let estimate = psd::estimate(part);
    let candidates = neighbours(part, args);
    if !candidates.is_empty() {
        body += &diagram(
            &order::poles(&candidates, Some(found.order)),
            &order::agreed(&candidates, found.order),
            &estimate,
            part.edges(),
            "parameters p + q",
            order::STABLE,
        );
    }
    let curve = psd::of_model(part, (&found.a, &found.c), found.sigma2);
    if args.method != Method::Tones {
        body += &densities(&estimate, &curve, part.edges(), found.order);
        let errors = residuals(&part.samples, &found.a, &found.c);
        let lacking = found.order[0].max(found.order[1]).min(errors.len() / 4);
        let lags = found.order[0] + found.order[1] + WHITENESS_LAGS;
        body += &left_over(&errors[lacking..], lags, found.whiteness_p);
        body += &methods(part, found, args);
    }
    let [p, q] = found.order;
    let n = found.modes.len();
    sheet(
        title,
        &format!(
            "{n} mode{} by {} ({p},{q})",
            if n == 1 { "" } else { "s" },
            found.method
        ),
        &body,
        env!("CARGO_PKG_VERSION"),
    )
}

fn modes(found: &Identified) -> String {
    let rows: Vec<Vec<String>> = found
        .modes
        .iter()
        .map(|m| {
            vec![
                with_deviation(m.f, m.f_sd, 2, "Hz"),
                with_deviation(100.0 * m.zeta, 100.0 * m.zeta_sd, 3, "%"),
            ]
        })
        .collect();
    table(&["frequency", "damping ratio"], &rows)
}

fn with_deviation(value: f64, sd: f64, digits: usize, unit: &str) -> String {
    if sd.is_finite() {
        format!("{value:.digits$} ± {sd:.digits$} {unit}")
    } else {
        format!("{value:.digits$} {unit}")
    }
}

/// Models of the orders around the one asked for, with as many more parameters in A; none where
/// that makes no sense.
fn neighbours(part: &Part, args: &IdentifyArgs) -> Vec<Candidate> {
    let (p, q) = args.order;
    if args.method == Method::Tones || p == 0 || p > estimators::MAX_ORDER {
        return Vec::new();
    }
    let highest = (p + ABOVE).min(estimators::MAX_ORDER);
    let orders: Vec<(usize, usize)> = (1..=highest)
        .filter_map(|k| match q {
            0 => Some((k, 0)),
            q if q > p => Some((k, (k + q - p).min(estimators::MAX_ORDER))),
            q => Some((k, (k + q).checked_sub(p)?)),
        })
        .collect();
    order::models(part, orders, highest).unwrap_or_default()
}

/// A table of what other methods read, and a picture of it.
fn methods(part: &Part, found: &Identified, args: &IdentifyArgs) -> String {
    let all = readings(part, args);
    let mut head = vec!["method".to_owned(), "fit".to_owned()];
    head.extend(found.modes.iter().map(|m| format!("near {:.0} Hz", m.f)));
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    let nearest = |reading: &Reading, f: f64| {
        let modes = reading.modes.as_ref().ok()?;
        let off = |m: &estimators::IdentifiedMode| (m.f - f).abs();
        let best = modes.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
        (off(best) <= SAME * f).then_some(*best)
    };
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|reading| {
            let took = match &reading.modes {
                Ok(_) => format!("{:.3} s", reading.seconds),
                Err(_) => "–".to_owned(),
            };
            let mut row = vec![reading.name.clone(), took];
            row.extend(found.modes.iter().map(|m| match nearest(reading, m.f) {
                Some(n) => format!(
                    "{}, {}",
                    with_deviation(n.f, n.f_sd, 1, "Hz"),
                    with_deviation(100.0 * n.zeta, 100.0 * n.zeta_sd, 2, "%")
                ),
                None => "–".to_owned(),
            }));
            row
        })
        .collect();
    let mut series = Vec::new();
    for (k, reading) in all.iter().enumerate() {
        let those: Vec<_> = found
            .modes
            .iter()
            .filter_map(|m| nearest(reading, m.f))
            .collect();
        // Beside each other, so that none hides another.
        let (low, high) = part.edges();
        let moved = 0.006 * (high - low) * (k as f64 - 0.5 * (all.len() - 1) as f64);
        let bars = those
            .iter()
            .filter(|m| m.zeta_sd.is_finite())
            .flat_map(|m| {
                let (zeta, reach) = (100.0 * m.zeta, 100.0 * BAR * m.zeta_sd);
                let f = m.f + moved;
                [(f, zeta - reach), (f, zeta + reach), (f64::NAN, f64::NAN)]
            });
        series.push(Series {
            name: String::new(),
            points: bars.collect(),
            mark: Mark::Line,
            colour: k,
        });
        series.push(Series {
            name: reading.name.clone(),
            points: those
                .iter()
                .map(|m| (m.f + moved, 100.0 * m.zeta))
                .collect(),
            mark: Mark::Dots,
            colour: k,
        });
    }
    let top = series
        .iter()
        .flat_map(|s| s.points.iter().map(|p| p.1))
        .filter(|y| y.is_finite())
        .fold(1.0, f64::max);
    let (low, high) = part.edges();
    let picture = Chart {
        title: "Damping by method".to_owned(),
        x: Scale::linear("frequency (Hz)", low, high),
        y: Scale::linear("damping ratio (%)", 0.0, 1.1 * top),
        height: 220.0,
        series,
        caption:
            "Bars: 1.96 standard deviations either way. The methods stand beside each other at \
                  each mode, a little off its frequency, so that none hides another."
                .to_owned(),
    };
    let without: String = all
        .iter()
        .filter_map(|reading| Some((&reading.name, reading.modes.as_ref().err()?)))
        .map(|(name, why)| format!("<p>{name}: {}.</p>\n", escape(why)))
        .collect();
    format!(
        "<h2>Other methods</h2>\n{}{without}<p>Each mode of the model, and what other methods read within 3 % of it: \
         burg stands for a long autoregression, its deviations are the least that are possible.</p>\n{}",
        table(&head, &rows),
        picture.figure()
    )
}
