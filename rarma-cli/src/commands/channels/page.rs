//! The page of `rarma identify --channels`: modes, their shapes, poles over orders.

use super::record::{ChannelModeRecord, Channels};
use crate::commands::model_pictures::{BAR, DiagramPole, diagram};
use rarma_pictures::{Chart, Mark, Scale, Series, sheet, table};

/// What the marks of the diagram mean.
const STABLE: &str = "Stable: within 1 % in frequency, 5 % in damping and 0.95 in the likeness of \
                      shapes (MAC) of a pole of the model with two states less.";

/// The page; `density` is that of the first channel, its backdrop.
pub(super) fn html(
    found: &Channels,
    density: &[(f64, f64)],
    edges: (f64, f64),
    title: &str,
) -> String {
    let mut body = String::from("<h2>Modes</h2>\n");
    let rows: Vec<Vec<String>> = found
        .modes
        .iter()
        .map(|m| {
            vec![
                format!("{:.3} ± {:.3} Hz", m.pole.f, m.pole.f_sd),
                format!(
                    "{:.3} ± {:.3} %",
                    100.0 * m.pole.zeta,
                    100.0 * m.pole.zeta_sd
                ),
                match (m.pole.stable, m.pole.stable_f) {
                    (true, _) => "stable",
                    (_, true) => "in frequency alone",
                    _ => "new",
                }
                .to_owned(),
                m.pole.mac.map_or("–".to_owned(), |mac| format!("{mac:.3}")),
            ]
        })
        .collect();
    body += &table(
        &[
            "frequency",
            "damping ratio",
            "over orders",
            "MAC with the order below",
        ],
        &rows,
    );
    let poles: Vec<DiagramPole> = found
        .orders
        .iter()
        .flat_map(|o| o.modes.iter().map(move |m| (o.order, m)))
        .map(|(order, m)| DiagramPole {
            row: order as f64,
            f: m.f,
            f_sd: m.f_sd,
            stable: m.stable,
            stable_f: m.stable_f,
            chosen: order == found.order,
        })
        .collect();
    body += &diagram(&poles, &[], density, edges, "states", STABLE);
    body += "<h2>Shapes of the modes that are stable, in frequency at least</h2>\n";
    for mode in found.modes.iter().filter(|m| m.pole.stable_f) {
        body += &shape(mode);
    }
    body += &singular_values(found);
    let n = found.modes.len();
    sheet(
        title,
        &format!(
            "{n} mode{} of {} channels, {} states",
            if n == 1 { "" } else { "s" },
            found.channels.len(),
            found.order
        ),
        &body,
        env!("CARGO_PKG_VERSION"),
    )
}

/// What moves with the largest part, and what moves a quarter of a turn apart from it.
fn shape(mode: &ChannelModeRecord) -> String {
    let at = |k: usize| k as f64;
    let points = |pick: fn(&super::ShapeRecord) -> f64| -> Vec<(f64, f64)> {
        let values = mode.shape.iter().enumerate();
        values.map(|(k, part)| (at(k), pick(part))).collect()
    };
    let bars = mode
        .shape
        .iter()
        .enumerate()
        .flat_map(|(k, part)| {
            // Of the magnitude, along the real axis.
            let reach = BAR * part.magnitude_sd;
            [
                (at(k), part.re - reach),
                (at(k), part.re + reach),
                (f64::NAN, f64::NAN),
            ]
        })
        .collect();
    let last = mode.shape.len().saturating_sub(1) as f64;
    let phases: Vec<String> = mode
        .shape
        .iter()
        .map(|part| format!("{:.0}°", part.phase_deg))
        .collect();
    Chart {
        title: format!("{:.2} Hz, ζ {:.2} %", mode.pole.f, 100.0 * mode.pole.zeta),
        x: Scale::linear("channel, in the order of the fit", -0.3, last + 0.3),
        y: Scale::linear("part of the largest", -1.15, 1.15),
        height: 150.0,
        series: vec![
            Series::new("with the largest", points(|p| p.re), Mark::Line, 0),
            Series::new("", points(|p| p.re), Mark::Dots, 0),
            Series::new("", bars, Mark::Line, 0),
            Series::new("a quarter turn apart", points(|p| p.im), Mark::Dashes, 1),
        ],
        caption: format!(
            "Phases: {}. Bars: ±1.96 sd of the magnitude.",
            phases.join(", ")
        ),
    }
    .figure()
}

fn singular_values(found: &Channels) -> String {
    let largest = found.singular_values.first().copied().unwrap_or(1.0);
    let points: Vec<(f64, f64)> = found
        .singular_values
        .iter()
        .take(3 * found.order)
        .enumerate()
        .map(|(k, s)| ((k + 1) as f64, 10.0 * (s / largest).max(1e-12).log10()))
        .collect();
    let low = points.iter().fold(-1.0f64, |m, p| m.min(p.1));
    Chart {
        title: "Singular values of the covariances".to_owned(),
        x: Scale::linear("number", 0.0, points.len() as f64 + 1.0),
        y: Scale::linear("dB below the largest", 1.05 * low, 1.0),
        height: 160.0,
        series: vec![Series {
            name: String::new(),
            points,
            mark: Mark::Dots,
            colour: 0,
        }],
        caption:
            "What the record holds ends where they step down; what follows is its noise. Two of \
                  them for each mode."
                .to_owned(),
    }
    .figure()
}
