//! A terminal's letters and colours as a picture.

use std::fmt::Write as _;

/// A letter's width and height, pixels, and where in it the letters stand.
const CELL: (f64, f64) = (9.0, 18.0);
const BASE: f64 = 14.0;
const MARGIN: f64 = 9.0;
/// Colours of a terminal in which nothing was set.
const INK: Rgb = [222, 222, 222];
const PAPER: Rgb = [22, 22, 26];
/// The sixteen colours that have names.
const NAMED: [Rgb; 16] = [
    [0, 0, 0],
    [205, 49, 49],
    [13, 188, 121],
    [229, 229, 16],
    [36, 114, 200],
    [188, 63, 188],
    [17, 168, 205],
    [204, 204, 204],
    [102, 102, 102],
    [241, 76, 76],
    [35, 209, 139],
    [245, 245, 67],
    [59, 142, 234],
    [214, 112, 214],
    [41, 184, 219],
    [255, 255, 255],
];

type Rgb = [u8; 3];

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Look {
    ink: Option<Rgb>,
    paper: Option<Rgb>,
    bold: bool,
    reversed: bool,
}

impl Look {
    fn ink(self) -> Rgb {
        if self.reversed {
            self.paper.unwrap_or(PAPER)
        } else {
            self.ink.unwrap_or(INK)
        }
    }

    fn paper(self) -> Rgb {
        if self.reversed {
            self.ink.unwrap_or(INK)
        } else {
            self.paper.unwrap_or(PAPER)
        }
    }

    /// Takes the numbers of `ESC [ … m`.
    fn take(&mut self, numbers: &str) {
        let mut numbers = numbers.split([';', ':']).map(|n| n.parse().unwrap_or(0));
        while let Some(number) = numbers.next() {
            match number {
                0 => *self = Self::default(),
                1 => self.bold = true,
                22 => self.bold = false,
                7 => self.reversed = true,
                27 => self.reversed = false,
                30..=37 => self.ink = Some(indexed(number - 30)),
                90..=97 => self.ink = Some(indexed(number - 82)),
                40..=47 => self.paper = Some(indexed(number - 40)),
                100..=107 => self.paper = Some(indexed(number - 92)),
                38 => self.ink = colour(&mut numbers),
                48 => self.paper = colour(&mut numbers),
                39 => self.ink = None,
                49 => self.paper = None,
                _ => {}
            }
        }
    }
}

/// What follows on 38 or 48.
fn colour(numbers: &mut impl Iterator<Item = u16>) -> Option<Rgb> {
    match numbers.next()? {
        5 => Some(indexed(numbers.next()?)),
        2 => {
            let mut next = || numbers.next().map(|n| n as u8);
            Some([next()?, next()?, next()?])
        }
        _ => None,
    }
}

/// One of the 256 colours.
fn indexed(n: u16) -> Rgb {
    match n {
        0..=15 => NAMED[n as usize],
        16..=231 => {
            let level = |k: u16| if k == 0 { 0 } else { (55 + 40 * k) as u8 };
            let n = n - 16;
            [level(n / 36), level(n / 6 % 6), level(n % 6)]
        }
        _ => [(8 + 10 * (n.min(255) - 232)) as u8; 3],
    }
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A row's letters with how each looks.
fn cells(row: &str, look: &mut Look) -> Vec<(char, Look)> {
    let mut out = Vec::new();
    let mut rest = row.chars();
    while let Some(letter) = rest.next() {
        if letter != '\u{1b}' {
            if !letter.is_control() {
                out.push((letter, *look));
            }
            continue;
        }
        // `ESC [ numbers letter`; only those of letters' looks are of interest.
        let code: String = rest
            .by_ref()
            .skip(1)
            .take_while(|c| !c.is_alphabetic())
            .collect();
        look.take(&code);
    }
    out
}

/// The upper and the lower end of a letter that is a block, parts of the height.
fn block(letter: char) -> Option<(f64, f64)> {
    match letter {
        '▀' => Some((0.0, 0.5)),
        '▁'..='█' => {
            let eighths = f64::from(u32::from(letter) - u32::from('▁') + 1);
            Some((1.0 - eighths / 8.0, 1.0))
        }
        _ => None,
    }
}

/// What `tmux capture-pane -e` says as an SVG of so many columns and rows.
pub fn picture(captured: &str, (columns, rows): (u16, u16)) -> String {
    let width = 2.0 * MARGIN + f64::from(columns) * CELL.0;
    let height = 2.0 * MARGIN + f64::from(rows) * CELL.1;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\" font-size=\"15\" shape-rendering=\"crispEdges\">\n<rect width=\"100%\" height=\"100%\" fill=\"{}\"/>\n",
        hex(PAPER)
    );
    let mut look = Look::default();
    for (row, y) in captured.lines().zip(0_u16..) {
        let y = MARGIN + f64::from(y) * CELL.1;
        let cells = cells(row, &mut look);
        let mut k = 0;
        while let Some((first, look)) = cells.get(k) {
            // As far as everything looks alike.
            let same =
                |(letter, other): &&(char, Look)| other == look && block(*letter) == block(*first);
            let run = cells[k..].iter().take_while(same).count();
            let (x, long) = (MARGIN + k as f64 * CELL.0, run as f64 * CELL.0);
            let mut rect = |y: f64, high: f64, colour: Rgb| {
                let _ = writeln!(
                    svg,
                    "<rect x=\"{x}\" y=\"{y}\" width=\"{long}\" height=\"{high}\" fill=\"{}\"/>",
                    hex(colour)
                );
            };
            if look.paper() != PAPER {
                rect(y, CELL.1, look.paper());
            }
            let text: String = cells[k..k + run]
                .iter()
                .map(|(letter, _)| *letter)
                .collect();
            if let Some((from, to)) = block(*first) {
                rect(y + from * CELL.1, (to - from) * CELL.1, look.ink());
            } else if !text.trim().is_empty() {
                let weight = if look.bold {
                    " font-weight=\"bold\""
                } else {
                    ""
                };
                let _ = writeln!(
                    svg,
                    "<text x=\"{x}\" y=\"{}\" fill=\"{}\"{weight} textLength=\"{long}\" lengthAdjust=\"spacingAndGlyphs\" xml:space=\"preserve\">{}</text>",
                    y + BASE,
                    hex(look.ink()),
                    text.replace('&', "&amp;").replace('<', "&lt;")
                );
            }
            k += run;
        }
    }
    svg + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_blocks_become_what_they_look_like() {
        let svg = picture(
            "a\u{1b}[1;38;5;160;48;5;214m<b\u{1b}[0m\n\u{1b}[7m▄▄\u{1b}[27m",
            (4, 2),
        );
        assert!(svg.contains(">a</text>"), "{svg}");
        assert!(
            svg.contains("fill=\"#d70000\" font-weight=\"bold\"") && svg.contains(">&lt;b</text>")
        );
        assert!(svg.contains("fill=\"#ffaf00\""), "{svg}");
        // Reversed, and half a row high over two columns.
        assert!(
            svg.contains("y=\"36\" width=\"18\" height=\"9\" fill=\"#16161a\""),
            "{svg}"
        );
    }

    #[test]
    fn a_row_keeps_its_letters_whatever_codes_are_between() {
        let mut look = Look::default();
        let row = cells("\u{1b}[31mre\u{1b}[39md\u{1b}[K!", &mut look);
        let text: String = row.iter().map(|(letter, _)| letter).collect();
        assert_eq!(text, "red!");
        assert_eq!(row[2].1.ink, None);
    }
}
