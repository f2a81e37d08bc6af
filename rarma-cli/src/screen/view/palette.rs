//! Colours, as many as the terminal has; nothing is told by colour alone.

use crate::report::words::Tone;
use ratatui::crossterm::style::available_color_count;
use ratatui::style::{Color, Modifier, Style};

/// From black over red to white, in the 256 colours: darker is weaker.
const HEAT: [u8; 12] = [16, 52, 53, 89, 125, 161, 197, 203, 209, 215, 222, 230];
/// The same in letters.
const SHADES: [char; 6] = [' ', '·', ':', '+', '#', '@'];

/// How many colours there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Palette {
    /// None, or none wanted.
    None,
    /// Sixteen.
    Basic,
    /// 256 or more.
    Many,
}

impl Palette {
    /// What `TERM`, `COLORTERM` and `NO_COLOR` say.
    pub(crate) fn of_this_terminal() -> Self {
        let none = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let mono = std::env::var("TERM").is_ok_and(|term| term.starts_with("vt"));
        match available_color_count() {
            _ if none || mono => Self::None,
            256.. => Self::Many,
            _ => Self::Basic,
        }
    }

    fn color(self, basic: Color, many: u8) -> Option<Color> {
        match self {
            Self::None => None,
            Self::Basic => Some(basic),
            Self::Many => Some(Color::Indexed(many)),
        }
    }

    fn tone(self, tone: Tone) -> Option<Color> {
        match tone {
            Tone::Bad => self.color(Color::Red, 160),
            Tone::Careful => self.color(Color::Yellow, 214),
            Tone::Good => self.color(Color::Green, 34),
            Tone::Unknown => self.color(Color::Gray, 250),
        }
    }

    /// The band behind the state.
    pub(super) fn band(self, tone: Tone) -> Style {
        let style = Style::new().add_modifier(Modifier::BOLD);
        match self.tone(tone) {
            Some(color) if tone == Tone::Bad => style.bg(color).fg(self.white()),
            Some(color) => style.bg(color).fg(Color::Black),
            None if tone == Tone::Bad => style.add_modifier(Modifier::REVERSED),
            None => style,
        }
    }

    fn white(self) -> Color {
        self.color(Color::White, 231).unwrap_or_default()
    }

    /// Words that are as good or bad as that.
    pub(super) fn words(self, tone: Tone) -> Style {
        let style = Style::new();
        let bright = match tone {
            Tone::Bad => self.color(Color::Red, 203),
            Tone::Careful => self.color(Color::Yellow, 220),
            Tone::Good => self.color(Color::Green, 77),
            Tone::Unknown => None,
        };
        let style = bright.map_or(style, |color| style.fg(color));
        match tone {
            Tone::Bad => style.add_modifier(Modifier::BOLD),
            _ => style,
        }
    }

    /// Headings, and what may be overlooked.
    pub(super) fn dim(self) -> Style {
        let color = self.color(Color::Cyan, 245);
        color.map_or(Style::new(), |color| Style::new().fg(color))
    }

    /// What was typed, and the mark of a threshold.
    pub(super) fn accent(self) -> Style {
        let color = self.color(Color::Cyan, 80);
        let style = Style::new().add_modifier(Modifier::BOLD);
        color.map_or(style, |color| style.fg(color))
    }

    /// The colour of a level, 0 to 1; none where letters tell it.
    pub(super) fn heat(self, level: f32) -> Option<Color> {
        let step = (level * HEAT.len() as f32) as usize;
        (self == Self::Many).then(|| Color::Indexed(HEAT[step.min(HEAT.len() - 1)]))
    }

    /// A level, 0 to 1, as a letter.
    pub(super) fn shade(level: f32) -> char {
        SHADES[((level * SHADES.len() as f32) as usize).min(SHADES.len() - 1)]
    }
}
