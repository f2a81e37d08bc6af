//! A model, drawn: from values to letters and colours, without a terminal.

mod big;
mod bottom;
mod log;
mod modes;
mod palette;
mod places;
mod state;
#[cfg(test)]
mod tests;
mod text;
mod waterfall;

pub(super) use palette::Palette;

use super::keys::Ui;
use super::model::Model;
use places::{LEAST, Places};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;

/// How it is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    pub(super) palette: Palette,
    /// Nothing has come for so long, s.
    pub(super) silent_s: f64,
}

/// Draws; where the cursor is to stand, if anywhere.
pub(super) fn draw(
    model: &Model,
    ui: &Ui,
    look: Look,
    area: Rect,
    buffer: &mut Buffer,
) -> Option<(u16, u16)> {
    let said = state::said(model, look.silent_s);
    if area.width < LEAST.0 || area.height < LEAST.1 {
        state::too_small(&said, look.palette, area, buffer);
        return None;
    }
    if ui.help {
        bottom::help(ui, look.palette, area, buffer);
        return None;
    }
    let wrapped = |texts: &[String]| text::wrapped_all(texts, area.width as usize - 2);
    let advice = wrapped(&model.advice);
    let at_box = model.at_box.as_ref().map(|at_box| wrapped(&at_box.lines()));
    let at_box = at_box.unwrap_or_default();
    let places = Places::of(area, at_box.len(), ui.input.is_some(), advice.len());
    state::header(model, ui, places.header, look.palette, buffer);
    state::draw(&said, look.palette, &places, buffer);
    state::speed(model, places.speed, look.palette, buffer);
    log::lines(&at_box, places.at_box, buffer);
    modes::draw(model, places.modes, look.palette, buffer);
    log::advice(&advice, places.advice, look.palette, buffer);
    waterfall::draw(model, places.waterfall, look.palette, buffer);
    log::draw(model, ui, places.log, look.palette, buffer);
    bottom::draw(ui, &places, look.palette, buffer)
}
