//! What a ball-bar report says first: the deviations, whether they are within a tolerance, and
//! which errors make them.

use rarma_pictures::table;
use rarma_pictures::{Bar, Bars};
use rarma_scenarios::ldbb::errors::AtForce;
use rarma_scenarios::ldbb::errors::OneWay;

/// Causes below this part of all are not drawn; the table of errors has them.
const SEEN: f64 = 0.005;

/// The section; `tolerance_um` is what the deviation is compared with, if anything.
pub(super) fn circularity(all: &[AtForce], tolerance_um: Option<f64>) -> String {
    let Some(first) = all.first() else {
        return String::new();
    };
    let mut body = "<h2>Circular test</h2>\n".to_owned();
    if let Some(text) = verdict(first, tolerance_um) {
        body += &format!("<p>{text}</p>\n");
    }
    body += &table(
        &[
            "force N",
            "G(CCW) µm",
            "G(CW) µm",
            "G(b) µm",
            "D µm",
            "H µm",
            "F(CCW) µm",
            "F(CW) µm",
        ],
        &all.iter().map(row).collect::<Vec<_>>(),
    );
    body += "<p>G: circular deviation, the distance of the two concentric circles that hold the path, about the centre that makes it smallest; G(b): of both directions together; D: mean radial deviation of both; H: largest distance of the two; F: largest and smallest radial deviation about the least-squares centre. Named after ISO 230-4, defined from general knowledge of it. D and F hold the error of the bar's length.</p>\n";
    let last = all.last().filter(|_| all.len() > 1);
    for e in [Some(first), last].into_iter().flatten() {
        body += &causes(e);
    }
    body
}

/// The verdict at the smallest force, in words.
pub(super) fn verdict(e: &AtForce, tolerance_um: Option<f64>) -> Option<String> {
    let (symbol, um) = e.circularity.judged()?;
    let force = format!("at {:.0} N", e.force_n);
    Some(match tolerance_um {
        Some(tolerance) if um <= tolerance => {
            format!("Within tolerance: {symbol} {um:.1} µm of {tolerance} µm {force}.")
        }
        Some(tolerance) => format!(
            "Out of tolerance: {symbol} {um:.1} µm, {:.1} µm more than {tolerance} µm, {force}.",
            um - tolerance
        ),
        None => format!("{symbol} {um:.1} µm {force}; no tolerance was given (--tolerance UM)."),
    })
}

fn row(e: &AtForce) -> Vec<String> {
    let c = &e.circularity;
    let um = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.1}"));
    let radial = |way: Option<OneWay>| {
        way.map_or("–".to_owned(), |w| {
            format!("{:+.1} to {:+.1}", w.f_min_um, w.f_max_um).replace('-', "−")
        })
    };
    vec![
        format!("{:.0}", e.force_n),
        um(c.ccw.map(|w| w.g_um)),
        um(c.cw.map(|w| w.g_um)),
        um(c.g_b_um),
        um(c.d_um),
        um(e.hysteresis_um),
        radial(c.ccw),
        radial(c.cw),
    ]
}

/// The causes at one force as bars.
fn causes(e: &AtForce) -> String {
    Bars {
        title: format!("Where the deviation at {:.0} N comes from", e.force_n),
        unit: "µm".to_owned(),
        bars: e
            .causes
            .iter()
            .filter(|c| c.share >= SEEN)
            .map(|c| Bar {
                name: c.name.clone(),
                value: c.um,
                share: c.share,
            })
            .collect(),
        caption: "Circular deviation that each error alone would make, and its part of their sum. Errors add up with their signs and places, so the measured deviation is less than the sum.".to_owned(),
    }
    .figure()
}
