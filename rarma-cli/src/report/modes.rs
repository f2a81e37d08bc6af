//! Pictures (c) and (d): damping and frequency of every mode.

use super::moment::Seen;
use super::{Scene, band, density, multiples};
use crate::record::Label;
use rarma_core::named::Named;
use rarma_pictures::Axis;
use rarma_pictures::put;
use rarma_pictures::text::{hertz, percent, px};
use rarma_pictures::{Panel, TOP};
use std::collections::HashSet;

/// Size of the grid that points are thinned to, pixels.
const CELL: f64 = 3.0;
/// Marks of self-excited modes that do not hide each other: a few in a long run must be seen,
/// and more are a density like the others.
const MARKS: usize = 1000;
/// Ends of the damping axis, percent.
const ZETA: (f64, f64) = (0.01, 100.0);
/// Drawn in this order, so that what matters lies on top.
const LABELS: [Label; 3] = [Label::Structural, Label::Forced, Label::SelfExcited];

fn class(label: Label) -> &'static str {
    match label {
        Label::SelfExcited => "self",
        Label::Structural => "struct",
        Label::Forced => "forced",
    }
}

/// A mark of half-width `r`: shape tells the label without colour.
fn mark(label: Label, x: f64, y: f64, r: f64) -> String {
    let (two, x0) = (px(2.0 * r), px(x - r));
    match label {
        Label::SelfExcited => format!("M{x0} {}h{two}l-{} -{two}z", px(y + r), px(r)),
        Label::Structural => {
            format!(
                "M{x0} {}a{r} {r} 0 1 0 {two} 0a{r} {r} 0 1 0 -{two} 0",
                px(y),
                r = px(r)
            )
        }
        Label::Forced => {
            let (top, bottom) = (px(y - r), px(y + r));
            format!("M{x0} {top}l{two} {two}M{x0} {bottom}l{two} -{two}")
        }
    }
}

fn legend(panel: &mut Panel<'_>, extra: &[(String, &str)]) {
    let mut entries: Vec<(String, &str)> = LABELS
        .iter()
        .rev()
        .map(|&label| {
            let text = label.name();
            let d = mark(label, 0.0, 0.0, 4.0);
            (format!(r#"<path class="{}" d="{d}"/>"#, class(label)), text)
        })
        .collect();
    entries.extend_from_slice(extra);
    panel.legend(&entries);
}

/// Points of one label, one per cell of the grid; `place` gives the height and
/// the size of a mode, or nothing if it cannot be drawn.
fn points(
    panel: &Panel<'_>,
    scene: &Scene<'_>,
    label: Label,
    place: impl Fn(&Seen) -> Option<(f64, f64)>,
) -> Vec<(f64, f64, f64, Seen)> {
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    for moment in scene.job.course.moments() {
        for mode in moment.all_modes().filter(|m| m.label == label) {
            let Some((y, r)) = place(&mode) else { continue };
            let x = panel.x.at(mode.t);
            if seen.insert(((x / CELL) as i32, (y / CELL) as i32)) {
                found.push((x, y, r, mode));
            }
        }
    }
    found
}

/// Whether modes of a label are drawn as a density, of which there would be so many marks.
fn in_cells(scene: &Scene<'_>, label: Label, marks: usize) -> bool {
    scene.dense() && (label != Label::SelfExcited || marks > MARKS)
}

/// Draws the damping of each mode.
pub(super) fn damping(scene: &Scene<'_>) -> String {
    let mut panel = scene.panel(240.0, "(c) Damping");
    let y = Axis::log(ZETA.0, ZETA.1, panel.bottom, TOP);
    panel.axes(&y, 5, "damping ratio ζ (%)");
    panel.spans();
    let thresholds = [
        (scene.release(), "release", "release"),
        (scene.job.threshold, "threshold", "undamped"),
    ];
    for (zeta, class, name) in thresholds {
        if y.holds(100.0 * zeta) {
            let at = y.at(100.0 * zeta);
            panel.level(at, class);
            panel.margin(at - 6.0, "small", name);
            panel.margin(at + 7.0, "small", &percent(zeta));
        }
    }
    let dense = scene.dense();
    // A band for each of so many lines would cover the plot.
    for label in LABELS.into_iter().filter(|_| !dense) {
        let band = band::path(&panel, scene, label, &y);
        panel.add(&format!(
            r#"<path class="{} confidence" d="{band}"/>"#,
            class(label)
        ));
    }
    let (mut below, mut marked) = (0, true);
    for label in LABELS {
        let place = |m: &Seen| m.zeta.is_finite().then(|| (y.at(100.0 * m.zeta), 2.1));
        let found = points(&panel, scene, label, place);
        let cells = in_cells(scene, label, found.len());
        marked &= !(cells && label == Label::SelfExcited);
        if cells {
            let place = |m: &Seen| (100.0 * m.zeta >= ZETA.0).then(|| y.at(100.0 * m.zeta));
            panel.add(&density::cells(&panel, scene, (label, class(label)), place));
        }
        let (mut marks, mut arrows) = (String::new(), String::new());
        for (x, at, r, mode) in found {
            if 100.0 * mode.zeta < ZETA.0 {
                // Off the logarithmic axis: undamped or worse.
                put!(
                    arrows,
                    "M{} {}h7l-3.5 6z",
                    px(x - 3.5),
                    px(panel.bottom - 7.0)
                );
                below += 1;
                continue;
            }
            if !cells {
                marks.push_str(&mark(label, x, at, r));
            }
        }
        let class = class(label);
        panel.add(&format!(
            r#"<path class="{class}" d="{marks}"/><path class="{class} arrow" d="{arrows}"/>"#
        ));
    }
    let band = r#"<path class="struct confidence" d="M-12 -5H12V5H-12Z"/>"#.to_owned();
    let band = [(band, "± 1.96 sd")];
    legend(&mut panel, if dense { &[] } else { &band });
    let alt = format!(
        "Damping ratio of each mode against time on a logarithmic axis from {} to {} percent, \
         undamped below {}, release above {}. {}",
        ZETA.0,
        ZETA.1,
        percent(scene.job.threshold),
        percent(scene.release()),
        scene.spans_in_words()
    );
    let mut caption = String::from("Operational damping ratio of each mode.");
    if dense {
        caption.push_str(&density::caption(marked));
    } else {
        caption.push_str(
            " Bands: 1.96 standard deviations either way, which hold the true one with 95 % if the \
             model is right.",
        );
    }
    caption.push_str(
        " Dashed: below it a mode counts as undamped; dotted: above it an alarm may be released.",
    );
    if below > 0 {
        caption.push_str(" Arrows at the bottom: ζ below 0.01 %, zero or negative.");
    }
    panel.finish(&alt, &caption)
}

/// Draws the frequency of each mode.
pub(super) fn frequency(scene: &Scene<'_>) -> String {
    let mut panel = scene.panel(220.0, "(d) Frequency");
    let y = Axis::linear(0.0, scene.f_top, panel.bottom, TOP);
    panel.axes(&y, 5, "frequency (Hz)");
    panel.spans();
    scene.band_edges(&mut panel, &y, "band");
    let taken = scene.alarm_marks(&mut panel, &y);
    let forcing = multiples::draw(&mut panel, scene, &y, "harmonic", Some(taken));
    let dense = scene.dense();
    let mut marked = true;
    for label in LABELS {
        let place = |m: &Seen| {
            y.holds(m.f).then(|| {
                let r = match m.zeta {
                    z if z < 0.01 => 3.2,
                    z if z < 0.05 => 2.2,
                    _ => 1.3,
                };
                (y.at(m.f), r)
            })
        };
        let found = points(&panel, scene, label, place);
        if in_cells(scene, label, found.len()) {
            let place = |m: &Seen| y.holds(m.f).then(|| y.at(m.f));
            panel.add(&density::cells(&panel, scene, (label, class(label)), place));
            marked &= label != Label::SelfExcited;
            continue;
        }
        let marks: String = found
            .iter()
            .map(|(x, at, r, _)| mark(label, *x, *at, *r))
            .collect();
        panel.add(&format!(r#"<path class="{}" d="{marks}"/>"#, class(label)));
    }
    let mut extra = Vec::new();
    if let Some(drawn) = &forcing {
        let line = r#"<path class="harmonic tooth" d="M-12 0H12"/>"#.to_owned();
        extra.push((line, drawn.name));
    }
    legend(&mut panel, &extra);
    let mut caption = String::from("Frequency of each mode");
    caption.push_str(if dense {
        "."
    } else {
        ": large marks for ζ below 1 %, middle below 5 %, small above."
    });
    caption.push_str(" Dashed: edges of the analysed band.");
    if dense {
        caption.push_str(&density::caption(marked));
    }
    if let Some(drawn) = &forcing {
        caption.push_str(&drawn.caption);
    }
    let alt = format!(
        "Frequency of each mode against time, up to {}. {}",
        hertz(scene.f_top),
        scene.spans_in_words()
    );
    panel.finish(&alt, &caption)
}
