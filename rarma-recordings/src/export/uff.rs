//! Universal files: dataset 58, one for each column.

use super::{Along, Column, Table};
use crate::input::exponent;
use std::fmt::Write as _;

/// Function types of dataset 58.
const TIME_RESPONSE: u8 = 1;
const POWER_SPECTRAL_DENSITY: u8 = 9;
/// Abscissa types.
const TIME: u8 = 17;
const FREQUENCY: u8 = 18;

/// Text, double precision. The step has six digits, which is all the format gives it; the values
/// have thirteen.
pub(super) fn bytes(table: &Table) -> Vec<u8> {
    let mut out = String::new();
    for column in &table.columns {
        dataset(&mut out, table, column);
    }
    out.into_bytes()
}

fn dataset(out: &mut String, table: &Table, column: &Column) {
    let n = table.rows();
    let (first, step) = table.along.grid();
    let (function, abscissa) = match table.along {
        Along::Time { .. } => (TIME_RESPONSE, TIME),
        Along::Frequency { .. } => (POWER_SPECTRAL_DENSITY, FREQUENCY),
    };
    let node = column.channel + 1;
    let _ = writeln!(
        out,
        "    -1\n    58\n{}\n{}\nNONE\nNONE\nNONE",
        ascii(&table.title, 79),
        ascii(&column.name, 79)
    );
    let _ = writeln!(
        out,
        "{function:5}{:10}{:5}{:10} {:<10}{node:10}{:4} {:<10}{:10}{:4}",
        node, 1, 0, "NONE", 1, "NONE", 0, 0
    );
    let _ = writeln!(
        out,
        "{:10}{n:10}{:10}{}{}{}",
        4,
        1,
        exponent(first, 5, 13),
        exponent(step, 5, 13),
        exponent(0.0, 5, 13)
    );
    let (name, unit) = table.along.words();
    for (kind, name, unit) in [
        (abscissa, name, unit),
        (0, "NONE", ascii(&in_ascii(&column.unit), 20).as_str()),
        (0, "NONE", "NONE"),
        (0, "NONE", "NONE"),
    ] {
        let _ = writeln!(out, "{kind:10}{:5}{:5}{:5} {name:<20} {unit:<20}", 0, 0, 0);
    }
    for line in column.values[..n].chunks(4) {
        for x in line {
            out.push_str(&exponent(*x, 12, 20));
        }
        out.push('\n');
    }
    out.push_str("    -1\n");
}

/// A unit without the signs that the format does not have: `m/s²` is `m/s^2`, never `m/s`.
fn in_ascii(unit: &str) -> String {
    let mut out = String::new();
    for c in unit.chars() {
        match c {
            '²' => out.push_str("^2"),
            '³' => out.push_str("^3"),
            '\u{b5}' | '\u{3bc}' => out.push('u'),
            '°' => out.push_str("deg"),
            '·' | '⋅' => out.push('*'),
            '\u{2126}' | '\u{3a9}' => out.push_str("ohm"),
            c if c.is_ascii() => out.push(c),
            _ => out.push('?'),
        }
    }
    out
}

/// What the format's lines can hold.
fn ascii(text: &str, most: usize) -> String {
    let plain = text.chars().filter(|c| c.is_ascii() && !c.is_control());
    let text: String = plain.take(most).collect();
    if text.trim().is_empty() {
        "NONE".to_owned()
    } else {
        text
    }
}
