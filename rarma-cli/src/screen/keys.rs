//! What a key does.

use super::input_line::InputLine;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// Lines of the log that a page turns.
const PAGE: usize = 8;

/// What is on the screen beside the model.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Ui {
    /// The page of help covers the rest.
    pub(super) help: bool,
    /// What is drawn stands still.
    pub(super) paused: bool,
    /// Lines of the log below those that are shown.
    pub(super) scroll: usize,
    /// None where nothing can be said.
    pub(super) input: Option<InputLine>,
}

impl Ui {
    /// With a line in which commands are typed.
    pub(super) fn with_input() -> Self {
        Self {
            input: Some(InputLine::default()),
            ..Self::default()
        }
    }
}

/// What follows from a key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Act {
    /// Nothing but what has changed on the screen.
    Draw,
    /// The program is to end.
    Leave,
    /// All is to be drawn anew.
    Anew,
    /// A line was typed.
    Say(String),
}

/// Every key with what it does, for the page of help; the third only where commands are typed.
pub(super) const KEYS: &[(&str, &str, bool)] = &[
    ("q, Ctrl-C", "end; what was heard until then counts", false),
    ("?, F1", "this page; any key leaves it", false),
    (
        "p, F2",
        "hold the picture, and let it go; listening goes on",
        false,
    ),
    ("PgUp PgDn", "older and newer lines of the log", false),
    ("Ctrl-L", "draw all anew", false),
    ("Enter", "say what is typed to the box", true),
    ("Tab", "complete a command or the name of a setting", true),
    ("Up Down", "lines typed before", true),
    ("Ctrl-U Ctrl-W", "take the line, the word away", true),
    ("Ctrl-D", "end, on an empty line; as does `quit`", true),
];

/// Takes a key.
pub(super) fn press(ui: &mut Ui, key: KeyEvent) -> Act {
    if key.kind == KeyEventKind::Release {
        return Act::Draw;
    }
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    // The end goes before all else.
    if control && key.code == KeyCode::Char('c') {
        return Act::Leave;
    }
    if ui.help {
        ui.help = false;
        return Act::Draw;
    }
    match key.code {
        KeyCode::F(1) => ui.help = true,
        KeyCode::F(2) => ui.paused = !ui.paused,
        KeyCode::PageUp => ui.scroll = ui.scroll.saturating_add(PAGE),
        KeyCode::PageDown => ui.scroll = ui.scroll.saturating_sub(PAGE),
        KeyCode::Char('l') if control => return Act::Anew,
        _ => {
            return match &mut ui.input {
                Some(line) => typed(line, key.code, control, &mut ui.help),
                None => pressed(ui, key.code),
            };
        }
    }
    Act::Draw
}

/// Where nothing is typed, letters are keys.
fn pressed(ui: &mut Ui, key: KeyCode) -> Act {
    match key {
        KeyCode::Char('q') => return Act::Leave,
        KeyCode::Char('?') => ui.help = true,
        KeyCode::Char('p') => ui.paused = !ui.paused,
        _ => {}
    }
    Act::Draw
}

fn typed(line: &mut InputLine, key: KeyCode, control: bool, help: &mut bool) -> Act {
    match key {
        KeyCode::Char('d') if control && line.is_empty() => return Act::Leave,
        KeyCode::Char('d') if control => line.delete(),
        KeyCode::Char('u') if control => line.back_all(),
        KeyCode::Char('w') if control => line.back_word(),
        KeyCode::Char('a') if control => line.go(isize::MIN),
        KeyCode::Char('e') if control => line.go(isize::MAX),
        KeyCode::Char(_) if control => {}
        KeyCode::Char('?') if line.is_empty() => *help = true,
        KeyCode::Char(letter) => line.insert(letter),
        KeyCode::Backspace => line.back(),
        KeyCode::Delete => line.delete(),
        KeyCode::Left => line.go(-1),
        KeyCode::Right => line.go(1),
        KeyCode::Home => line.go(isize::MIN),
        KeyCode::End => line.go(isize::MAX),
        KeyCode::Up => line.recall(true),
        KeyCode::Down => line.recall(false),
        KeyCode::Tab => line.complete(),
        KeyCode::Enter => {
            let said = line.enter();
            return match said.as_str() {
                "" => Act::Draw,
                "help" => {
                    *help = true;
                    Act::Draw
                }
                _ => Act::Say(said),
            };
        }
        _ => {}
    }
    Act::Draw
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(code: KeyCode) -> KeyEvent {
        KeyEvent::new(code, KeyModifiers::NONE)
    }

    fn control(letter: char) -> KeyEvent {
        KeyEvent::new(KeyCode::Char(letter), KeyModifiers::CONTROL)
    }

    #[test]
    fn letters_are_keys_where_nothing_is_typed() {
        let mut ui = Ui::default();
        press(&mut ui, key(KeyCode::Char('p')));
        assert!(ui.paused);
        press(&mut ui, key(KeyCode::Char('?')));
        assert!(ui.help);
        // Any key leaves the help, and does nothing else.
        assert_eq!(press(&mut ui, key(KeyCode::Char('q'))), Act::Draw);
        assert!(!ui.help);
        assert_eq!(press(&mut ui, key(KeyCode::Char('q'))), Act::Leave);
    }

    #[test]
    fn letters_are_typed_where_there_is_a_line() {
        let mut ui = Ui::with_input();
        for letter in "take q?p".chars() {
            assert_eq!(press(&mut ui, key(KeyCode::Char(letter))), Act::Draw);
        }
        assert!(!ui.paused && !ui.help);
        let said = press(&mut ui, key(KeyCode::Enter));
        assert_eq!(said, Act::Say("take q?p".to_owned()));
        assert_eq!(press(&mut ui, key(KeyCode::Enter)), Act::Draw);
        assert_eq!(press(&mut ui, control('d')), Act::Leave);
        press(&mut ui, key(KeyCode::Char('x')));
        assert_eq!(press(&mut ui, control('d')), Act::Draw);
        assert_eq!(press(&mut ui, control('c')), Act::Leave);
    }
}
