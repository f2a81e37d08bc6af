//! Pictures of a record: responses, coherence, modes side by side.

use super::export::quantity;
use super::{Answer, over_speed, sensor_name};
use crate::args::KindArg;
use rarma_pictures::palette;
use rarma_pictures::{Chart, Mark, Scale, Series, table};
use rarma_rigs::cers::Quantity;
use rarma_rigs::els::Complex;
use rarma_scenarios::cers::CersRecord;
use rarma_scenarios::cers::modes::{curve_of, direct};
use rarma_scenarios::cers::response::{Cleaned, Response, Sensor};

/// The page of one record.
pub(super) fn page(
    answer: &Answer,
    record: &CersRecord,
    clean: &Cleaned,
    responses: &[Response],
    kind: KindArg,
) -> String {
    if let Some(sweep) = &answer.sweep {
        return over_speed::pictures(record, clean, &sweep.tracks);
    }
    let mut body = magnitude(responses, kind);
    body += &fitted(record, clean, answer.band_hz);
    body += &phase(responses, kind);
    body += &coherence(responses);
    if let Some(found) = &answer.modes {
        body += "<h2>Modes</h2>\n";
        let pair = |p: Option<(f64, f64)>| {
            p.map_or("–".to_owned(), |(f, z)| {
                format!("{f:.1} Hz, {:.2} %", 100.0 * z)
            })
        };
        let rows: Vec<Vec<String>> = found
            .modes
            .iter()
            .map(|m| {
                vec![
                    m.axis.to_owned(),
                    format!("{:.1} ± {:.2} Hz", m.f, m.f_sd),
                    format!("{:.2} ± {:.3} %", 100.0 * m.zeta, 100.0 * m.zeta_sd),
                    pair(m.arx.map(|r| (r.f, r.zeta))),
                    pair(m.arma.map(|r| (r.f, r.zeta))),
                    pair(m.table_3.map(|t| t.ema)),
                    pair(m.table_3.and_then(|t| t.para)),
                    pair(m.truth),
                ]
            })
            .collect();
        body += &table(
            &[
                "",
                "frequency",
                "damping ratio",
                "ARX, force known",
                "ARMA(30,29), response alone",
                "table 3, EMA",
                "table 3, Para",
                "truth",
            ],
            &rows,
        );
    }
    body
}

fn name(r: &Response) -> String {
    let axis = |k: usize| ["x", "y"][k];
    format!(
        "{} over force {}, {}",
        axis(r.to),
        axis(r.from),
        sensor_name(r.sensor)
    )
}

fn series(responses: &[Response], of: impl Fn(&Response) -> Vec<(f64, f64)>) -> Vec<Series> {
    responses
        .iter()
        .filter(|r| r.sensor == Sensor::Displacement)
        .map(|r| Series {
            name: name(r),
            points: of(r),
            mark: if r.from == r.to {
                Mark::Line
            } else {
                Mark::Dashes
            },
            colour: colour(r),
        })
        .collect()
}

/// A response keeps its colour in every picture, whichever others are there.
fn colour(r: &Response) -> usize {
    if r.from == r.to { r.to } else { 2 + r.to }
}

fn ends(responses: &[Response]) -> (f64, f64) {
    let lines = || responses.iter().flat_map(|r| &r.lines);
    (
        lines().fold(f64::INFINITY, |m, l| m.min(l.f_hz)),
        lines().fold(1.0, |m: f64, l| m.max(l.f_hz)),
    )
}

/// Title, unit of the picture, and its part of the SI unit.
fn shown(kind: KindArg) -> (&'static str, &'static str, f64) {
    match kind {
        KindArg::Receptance => ("Receptance", "µm/N", 1e-6),
        KindArg::Mobility => ("Mobility", "mm/(N·s)", 1e-3),
        KindArg::Accelerance => ("Accelerance", "1/kg", 1.0),
    }
}

fn magnitude(responses: &[Response], kind: KindArg) -> String {
    let (title, unit, part) = shown(kind);
    let series = series(responses, |r| {
        r.lines
            .iter()
            .map(|l| {
                let h = Quantity::Receptance.to(quantity(kind), l.receptance, l.f_hz);
                (l.f_hz, h.abs() / part)
            })
            .collect()
    });
    let most = series
        .iter()
        .flat_map(|s| &s.points)
        .fold(0.0, |m: f64, p| m.max(p.1));
    let (low, high) = ends(responses);
    let top = 10_f64.powf(most.max(1e-300).log10().ceil());
    Chart {
        title: format!("{title}, magnitude"),
        x: Scale::linear("frequency (Hz)", low, high),
        y: Scale::log(unit, 1e-4 * top, top),
        height: 300.0,
        series,
        caption: "H_IV by the command as instrument; delay, sensors and the lag of the flux taken out. Dashed: cross.".to_owned(),
    }
    .figure()
}

/// The receptance along each principal direction, and the rational function whose poles are
/// among the modes of the table.
fn fitted(record: &CersRecord, clean: &Cleaned, band_hz: (f64, f64)) -> String {
    let Ok((angle, directs)) = direct(record, clean, band_hz, &|_| false) else {
        return String::new();
    };
    let mut series = Vec::new();
    for d in &directs {
        let curve = |name: String, g: &[Complex<f64>], mark, colour| Series {
            name,
            points: d
                .f_hz
                .iter()
                .zip(g)
                .map(|(f, g)| (*f, 1e6 * g.abs()))
                .collect(),
            mark,
            colour,
        };
        let axis = ["x", "y"][d.axis];
        series.push(curve(format!("{axis}, measured"), &d.g, Mark::Line, d.axis));
        if let Some(fit) = curve_of(d) {
            let name = format!(
                "{axis}, rational function of {} modes, {:.1} % left",
                fit.modes,
                100.0 * fit.left
            );
            // Dark over the measured one, so that it is seen where they agree.
            series.push(curve(name, &fit.g, Mark::Dashes, palette::step(7, 8)));
        }
    }
    let values = || series.iter().flat_map(|s| &s.points).map(|p| p.1);
    let most = values().fold(0.0, f64::max);
    let top = 10_f64.powf(most.max(1e-300).log10().ceil());
    let least = values().fold(top, f64::min).max(1e-4 * top);
    Chart {
        title: "Receptance along the principal directions, measured and fitted".to_owned(),
        x: Scale::linear("frequency (Hz)", band_hz.0, band_hz.1),
        y: Scale::log("µm/N", 10_f64.powf(least.log10().floor()), top),
        height: 300.0,
        series,
        caption: format!(
            "Dashed: the fit of the most modes that were tried; a mode is in the table where several fits agree. The first principal direction lies {:.1}° from x.",
            angle.to_degrees()
        ),
    }
    .figure()
}

fn phase(responses: &[Response], kind: KindArg) -> String {
    let direct: Vec<Response> = responses
        .iter()
        .filter(|r| r.from == r.to)
        .cloned()
        .collect();
    let series = series(&direct, |r| {
        r.lines
            .iter()
            .map(|l| {
                let h = Quantity::Receptance.to(quantity(kind), l.receptance, l.f_hz);
                (l.f_hz, h.im.atan2(h.re).to_degrees())
            })
            .collect()
    });
    let (low, high) = ends(responses);
    Chart {
        title: "Phase, direct".to_owned(),
        x: Scale::linear("frequency (Hz)", low, high),
        y: Scale::linear("degrees", -180.0, 180.0),
        height: 180.0,
        series,
        caption: "A receptance stays between 0 and −180°.".to_owned(),
    }
    .figure()
}

fn coherence(responses: &[Response]) -> String {
    let (low, high) = ends(responses);
    let chart = |title: &str,
                 y: Scale,
                 of: fn(&rarma_scenarios::cers::response::Line) -> f64,
                 caption: &str| {
        Chart {
            title: title.to_owned(),
            x: Scale::linear("frequency (Hz)", low, high),
            y,
            height: 160.0,
            series: series(responses, |r| {
                r.lines.iter().map(|l| (l.f_hz, of(l))).collect()
            }),
            caption: caption.to_owned(),
        }
        .figure()
    };
    chart(
        "Coherence of force and displacement",
        Scale::linear("γ²", 0.0, 1.0),
        |l| l.raw.coherence,
        "Low where the structure hardly moves: there H1 is low and H2 high, H_IV is not.",
    ) + &chart(
        "Random error of H_IV",
        Scale::log("part", 1e-4, 1.0),
        |l| l.raw.iv_random_error,
        "Standard deviation over the magnitude.",
    )
}
