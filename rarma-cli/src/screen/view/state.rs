//! The state in large letters, why, and what is known of the spindle.

use super::big;
use super::palette::Palette;
use super::places::{LEAST, Places};
use super::text::{put, put_right, wrapped};
use crate::frames::fault_words;
use crate::record::State;
use crate::report::reason_words;
use crate::report::words::Tone;
use crate::screen::keys::Ui;
use crate::screen::model::Model;
use rarma_box::guard::Stage;
use rarma_core::named::Named;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

/// After so long without anything new the last verdict is none any more, s.
const SILENT_S: f64 = 2.0;

/// Before the level of the last seconds, which has so many bars where there is room.
const LEVEL: &str = "  level ";
const SHORTEST: usize = 5;
const LONGEST: usize = 50;

/// What is to be seen first.
pub(super) struct Said {
    word: String,
    tone: Tone,
    why: String,
}

/// The state, unless there is something more important.
pub(super) fn said(model: &Model, silent_s: f64) -> Said {
    let said = |word: &str, tone, why| Said {
        word: word.to_owned(),
        tone,
        why,
    };
    if let Some(at_box) = &model.at_box {
        let status = at_box.status.as_ref();
        if silent_s > SILENT_S {
            let why = format!(
                "the box has said nothing for {silent_s:.0} s; still waiting (check its supply and the cable; `quit` ends)"
            );
            return said("no answer", Tone::Unknown, why);
        }
        if let Some(status) = status
            && status.stage == Stage::Faulted
        {
            let fault = status.fault.as_ref().map(fault_words);
            let why = format!("{}: outputs are off", fault.unwrap_or_default());
            return said(status.stage.name(), Tone::Bad, why);
        }
        if model.line.is_none() || model.t_s - model.verdict_s > SILENT_S {
            let mode = status.map_or("not known yet", |status| status.mode.name());
            let why = format!("mode {mode}: nothing is listened to (`start monitor` does)");
            return said("no verdict", Tone::Unknown, why);
        }
    } else if silent_s > SILENT_S {
        let why = format!(
            "nothing has come for {silent_s:.0} s; still waiting (is the source on, and is it sending? q ends)"
        );
        return said("no samples", Tone::Unknown, why);
    }
    let Some(line) = &model.line else {
        let word = State::Starting.name();
        return said(word, Tone::Unknown, "no sample has come yet".to_owned());
    };
    let why = reason_words(line.state, line.reason).to_owned();
    said(line.state.name(), tone(line.state), why)
}

fn tone(state: State) -> Tone {
    match state {
        State::Chatter => Tone::Bad,
        State::Warning => Tone::Careful,
        State::Stable => Tone::Good,
        State::Starting | State::Idle | State::Invalid => Tone::Unknown,
    }
}

/// The first line: what is listened to, and for how long.
pub(super) fn header(model: &Model, ui: &Ui, area: Rect, palette: Palette, buffer: &mut Buffer) {
    let what = match model.at_box {
        Some(_) => "rarma connect",
        None => "rarma",
    };
    let name = Line::from(vec![
        Span::styled(format!(" {what} "), palette.accent()),
        Span::raw(model.title.clone()),
    ]);
    put(name, area, 0, buffer);
    let held = if ui.paused { "  HELD (p goes on)" } else { "" };
    let right = format!("  {:.1} s{held} ", model.t_s);
    let style = if ui.paused {
        palette.words(Tone::Careful)
    } else {
        palette.dim()
    };
    put_right(&right, style, area, 0, buffer);
}

/// The state over the whole width.
pub(super) fn draw(said: &Said, palette: Palette, places: &Places, buffer: &mut Buffer) {
    let area = places.state;
    let band = palette.band(said.tone);
    buffer.set_style(area, band);
    let word = said.word.to_uppercase();
    let letters = Rect {
        x: area.x + 1,
        width: area.width - 1,
        ..area
    };
    big::draw(&word, places.size, band, letters, buffer);
    let row = area.height - 1;
    let why = format!(" {} {}: {}", said.tone.sign(), said.word, said.why);
    put(Span::styled(why, band), area, row, buffer);
}

/// Speed, lines and level.
pub(super) fn speed(model: &Model, area: Rect, palette: Palette, buffer: &mut Buffer) {
    let at_box = model.at_box.is_some();
    let spindle = model.line.as_ref().map(|line| &line.spindle);
    let known = spindle.and_then(|spindle| Some((spindle, spindle.rpm?)));
    let mut parts = vec![Span::styled(" speed ", palette.dim())];
    match known {
        Some((spindle, rpm)) => {
            let by = spindle.source.name();
            parts.push(Span::raw(format!("{rpm:.0} 1/min ({by})")));
            if spindle.locked {
                let notch = spindle.notch_hz;
                parts.push(Span::raw(format!("; lines removed, ±{notch:.1} Hz")));
            }
        }
        None if at_box => parts.push(Span::raw("unknown (`set monitor.spindle HZ` tells it)")),
        None => parts.push(Span::raw("unknown (--rpm tells it)")),
    }
    if let Some(amplitude) = model.line.as_ref().and_then(|line| line.amplitude.as_ref()) {
        parts.push(Span::styled("  amplitude ", palette.dim()));
        parts.push(Span::raw(format!(
            "{} at {:.0} Hz",
            amplitude.verdict.name(),
            amplitude.f
        )));
    }
    let line = Line::from(parts);
    let room = (area.width as usize).saturating_sub(line.width() + LEVEL.len() + 1);
    put(line, area, 0, buffer);
    if room >= SHORTEST && !model.levels.is_empty() {
        let level = format!("{LEVEL}{} ", trend(model, room.min(LONGEST)));
        put_right(&level, palette.dim(), area, 0, buffer);
    }
}

/// The newest levels as bars, the loudest the highest.
fn trend(model: &Model, width: usize) -> String {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let most = model
        .levels
        .iter()
        .copied()
        .fold(f32::MIN_POSITIVE, f32::max);
    let from = model.levels.len().saturating_sub(width);
    let bar = |level: &f32| BARS[((7.0 * level / most) as usize).min(7)];
    model.levels.iter().skip(from).map(bar).collect()
}

/// Where there is no room: the state all the same, and what to do.
pub(super) fn too_small(said: &Said, palette: Palette, area: Rect, buffer: &mut Buffer) {
    let band = palette.band(said.tone);
    if area.is_empty() {
        return;
    }
    let first = Rect { height: 1, ..area };
    buffer.set_style(first, band);
    let word = format!(
        "{} {}: {}",
        said.tone.sign(),
        said.word.to_uppercase(),
        said.why
    );
    put(Span::styled(word, band), first, 0, buffer);
    let text = format!(
        "This terminal is too small: {} columns and {} rows, {} and {} are needed. Make the window larger or its letters smaller, or end (Ctrl-C) and start again with --screen off.",
        area.width, area.height, LEAST.0, LEAST.1
    );
    for (line, row) in wrapped(&text, area.width as usize).into_iter().zip(1..) {
        put(Span::raw(line), area, row, buffer);
    }
}
