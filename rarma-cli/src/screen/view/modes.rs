//! Each mode: frequency, damping ratio, and where that lies beside the threshold.

use super::palette::Palette;
use super::text::{heading, put};
use crate::record::{Label, ModeRecord, Origin};
use crate::report::words::Tone;
use crate::screen::model::Model;
use rarma_core::named::Named;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

/// Columns of the numbers, and of the words behind the picture.
const NUMBERS: u16 = 36;
const WORDS: u16 = 23;
/// The picture goes from so many thresholds to so many.
const FROM: f64 = -2.0;
const TO: f64 = 8.0;
/// Half a band of 95 %, standard deviations.
const BAND: f64 = 1.96;

/// Draws a heading and a line for each mode.
pub(super) fn draw(model: &Model, area: Rect, palette: Palette, buffer: &mut Buffer) {
    let picture = Rect {
        x: area.x + NUMBERS,
        width: area.width.saturating_sub(NUMBERS + WORDS),
        ..area
    };
    let scale = Scale {
        threshold: model.threshold,
        columns: picture.width,
    };
    let dim = palette.dim();
    heading("modes: frequency  damping", dim, area, buffer);
    let place = |zeta| scale.column(zeta).map(|column| picture.x + column);
    let threshold = format!("{:.1} %", 100.0 * model.threshold);
    if let Some(x) = place(model.threshold) {
        let text = Span::styled(format!("┬ {threshold} "), palette.accent());
        let here = Rect {
            x,
            width: area.right() - x,
            ..area
        };
        put(text, here, 0, buffer);
    }
    let modes = model.line.as_ref().map_or(&[][..], |line| &line.modes);
    if modes.is_empty() {
        put(Span::styled("  none heard", dim), area, 1, buffer);
    }
    for (mode, row) in modes.iter().zip(1..area.height) {
        let style = style(mode, model.threshold, palette);
        let numbers = format!(
            " {:7.1} ±{:5.1} Hz  {:6.2} ±{:5.2} %",
            mode.f,
            mode.f_sd,
            100.0 * mode.zeta,
            100.0 * mode.zeta_sd
        );
        put(Span::styled(numbers, style), area, row, buffer);
        for (zeta, mark) in [(0.0, "·"), (model.threshold, "│")] {
            if let Some(x) = place(zeta) {
                buffer.set_string(x, area.y + row, mark, palette.accent());
            }
        }
        interval(mode, scale, picture, (row, style), buffer);
        let words = Rect {
            x: picture.right() + 1,
            width: WORDS - 1,
            ..area
        };
        put(Line::styled(mode_words(mode), style), words, row, buffer);
    }
}

/// Where a damping ratio lies.
#[derive(Debug, Clone, Copy)]
struct Scale {
    threshold: f64,
    columns: u16,
}

impl Scale {
    /// None beyond the ends.
    fn column(self, zeta: f64) -> Option<u16> {
        let x = (zeta / self.threshold - FROM) / (TO - FROM);
        let last = f64::from(self.columns.checked_sub(1)?);
        ((0.0..=1.0).contains(&x)).then(|| (x * last).round() as u16)
    }

    /// The end beyond which it lies, else its place.
    fn within(self, zeta: f64) -> Option<u16> {
        let ends = (FROM * self.threshold, TO * self.threshold);
        self.column(zeta.clamp(ends.0, ends.1))
    }
}

/// The band of 95 % with its middle; an arrow where that lies beyond.
fn interval(
    mode: &ModeRecord,
    scale: Scale,
    picture: Rect,
    (row, style): (u16, Style),
    buffer: &mut Buffer,
) {
    if !mode.zeta.is_finite() {
        return;
    }
    let half = BAND * mode.zeta_sd.max(0.0);
    let ends = scale
        .within(mode.zeta - half)
        .zip(scale.within(mode.zeta + half));
    let Some((from, to)) = ends else { return };
    let y = picture.y + row;
    for column in from..=to {
        if let Some(cell) = buffer.cell_mut((picture.x + column, y)) {
            let crosses = cell.symbol() == "│";
            cell.set_symbol(if crosses { "┿" } else { "━" })
                .set_style(style);
        }
    }
    let mark = match scale.column(mode.zeta) {
        Some(_) => "●",
        None if mode.zeta > 0.0 => "▶",
        None => "◀",
    };
    if let Some(column) = scale.within(mode.zeta) {
        buffer.set_string(picture.x + column, y, mark, style);
    }
}

/// As bad as it is: undamped and unexplained, undamped, or damped.
fn style(mode: &ModeRecord, threshold: f64, palette: Palette) -> Style {
    match (mode.zeta < threshold, mode.label) {
        (true, Label::SelfExcited) => palette.words(Tone::Bad),
        (true, _) => palette.words(Tone::Careful),
        (false, _) => palette.words(Tone::Unknown),
    }
}

/// What it is, in the words of JSON.
fn mode_words(mode: &ModeRecord) -> String {
    let label = mode.label.name();
    if let Some(k) = mode.harmonic {
        return format!("{label}, {k} × speed");
    }
    if let Some(s) = mode.time_left {
        return format!("{label}, {s:.1} s left");
    }
    match mode.origin {
        Origin::Free => label.to_owned(),
        origin => format!("{label}, {}", origin.name()),
    }
}
