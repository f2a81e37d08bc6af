//! Modes of a long run as a density: how many of the lines had one there, instead of a cloud
//! of marks that hide each other.

use super::Scene;
use super::moment::Seen;
use crate::record::Label;
use rarma_pictures::Panel;
use rarma_pictures::put;
use rarma_pictures::text::px;
use std::collections::BTreeMap;

/// Size of a cell, pixels.
const CELL: (f64, f64) = (4.0, 3.0);
/// Parts of a column's lines from which on a cell is darker.
const LEVELS: [f64; 3] = [0.04, 0.12, 0.35];

/// The modes of a label as cells, one path a level; `place` gives the height of a mode, or
/// nothing if it cannot be drawn.
pub(super) fn cells(
    panel: &Panel<'_>,
    scene: &Scene<'_>,
    (label, class): (Label, &str),
    place: impl Fn(&Seen) -> Option<f64>,
) -> String {
    let column = |t: f64| (panel.x.at(t) / CELL.0) as i32;
    let mut lines: BTreeMap<i32, u64> = BTreeMap::new();
    let mut counts: BTreeMap<(i32, i32), u64> = BTreeMap::new();
    for moment in scene.job.course.moments() {
        *lines.entry(column(moment.t)).or_default() += u64::from(moment.lines);
        for mode in moment.all_modes().filter(|m| m.label == label) {
            if let Some(y) = place(&mode) {
                // Its moment's column: what it is a part of.
                let cell = (column(moment.t), (y / CELL.1) as i32);
                *counts.entry(cell).or_default() += u64::from(mode.n);
            }
        }
    }
    let mut paths = [const { String::new() }; LEVELS.len() + 1];
    // Shape tells the label without colour: what is forced is flat.
    let height = if label == Label::Forced { 1.4 } else { CELL.1 };
    for ((column, row), n) in counts {
        let share = n as f64 / lines.get(&column).copied().unwrap_or(1).max(1) as f64;
        let level = LEVELS.iter().filter(|least| share >= **least).count();
        let middle = (f64::from(row) + 0.5) * CELL.1;
        put!(
            paths[level],
            "M{} {}h{w}v{h}h-{w}z",
            px(f64::from(column) * CELL.0),
            px(middle - 0.5 * height),
            w = px(CELL.0),
            h = px(height)
        );
    }
    let mut svg = String::new();
    for (level, d) in paths.iter().enumerate().filter(|(_, d)| !d.is_empty()) {
        put!(svg, r#"<path class="{class} cells l{level}" d="{d}"/>"#);
    }
    svg
}

/// What the shades mean; `marked` tells whether self-excited modes are not drawn so.
pub(super) fn caption(marked: bool) -> String {
    let mut caption = " So many lines that they are drawn as a density: the stronger a cell, the \
         more of the lines had a mode there (below 4 %, 12 %, 35 %, and above); flat cells are forced."
        .to_owned();
    if marked {
        caption.push_str(" What is self-excited is marked one by one.");
    }
    caption
}
