//! The line in which commands are typed, the keys, and the page of help.

use super::palette::Palette;
use super::places::Places;
use super::text::{put, put_right, wrapped};
use crate::screen::input_line::InputLine;
use crate::screen::keys::{KEYS, Ui};
use rarma_scenarios::speech;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

/// What stands before a command.
const PROMPT: &str = " > ";

/// Draws both; where the cursor is to stand.
pub(super) fn draw(
    ui: &Ui,
    places: &Places,
    palette: Palette,
    buffer: &mut Buffer,
) -> Option<(u16, u16)> {
    let Some(line) = &ui.input else {
        let keys = " q end   p hold   ? help   PgUp PgDn log";
        put(Span::styled(keys, palette.dim()), places.keys, 0, buffer);
        return None;
    };
    let below = match line.offers.as_slice() {
        [] => " Tab completes   Up Down lines before   ? help   F2 hold   `quit` ends".to_owned(),
        offers => format!(" {}", offers.join("  ")),
    };
    put(Span::styled(below, palette.dim()), places.keys, 0, buffer);
    Some(input(line, places.input, palette, buffer))
}

/// The line; a long one is shown from where its cursor is to be seen.
fn input(line: &InputLine, area: Rect, palette: Palette, buffer: &mut Buffer) -> (u16, u16) {
    let room = (area.width as usize).saturating_sub(PROMPT.len() + 1);
    let from = line.cursor().saturating_sub(room);
    let text: String = line.text().chars().skip(from).take(room).collect();
    let before: String = text.chars().take(line.cursor() - from).collect();
    let x = area.x + (PROMPT.len() + Span::raw(before).width()) as u16;
    if let Some(form) = line.hint() {
        put_right(&format!("  {form} "), palette.dim(), area, 0, buffer);
    }
    let typed = Line::from(vec![
        Span::styled(PROMPT, palette.accent()),
        Span::raw(text),
    ]);
    put(typed, area, 0, buffer);
    (x.min(area.right() - 1), area.y)
}

/// Every key, what the picture means, and what can be said.
pub(super) fn help(ui: &Ui, palette: Palette, area: Rect, buffer: &mut Buffer) {
    let typed = ui.input.is_some();
    let mut lines = vec![Line::styled(" Keys", palette.accent())];
    for (keys, what, only_typed) in KEYS {
        // Where letters are typed, they are no keys.
        let keys = match keys.split_once(", ") {
            Some((letter, other)) if typed && letter.len() == 1 && letter != "?" => other,
            _ => keys,
        };
        if typed || !only_typed {
            lines.push(Line::raw(format!("   {keys:14} {what}")));
        }
    }
    let width = (area.width as usize).saturating_sub(4);
    let mut say = |title: &'static str, text: &str| {
        lines.push(Line::styled(format!(" {title}"), palette.accent()));
        let text = wrapped(text, width).into_iter();
        lines.extend(text.map(|line| Line::raw(format!("   {line}"))));
    };
    if typed {
        say("Commands", speech::WORDS);
    }
    say(
        "Modes",
        "● damping, ━ its 95 % band, │ the threshold: below it a mode counts as undamped; ▶ ◀ beyond the picture",
    );
    say(
        "Signs",
        "▲ chatter, fault  ◆ warning, notice  ● good  ○ no verdict; below the spectrum ▲ marks a mode",
    );
    for (line, row) in lines.into_iter().zip(0..) {
        put(line, area, row, buffer);
    }
    let last = area.height - 1;
    let leave = " any key leaves this page   docs/screen.md has more ";
    put(
        Span::styled(leave, palette.band(crate::report::words::Tone::Unknown)),
        area,
        last,
        buffer,
    );
}
