//! Lines of text, with units in the header.

use super::{Along, Table};
use std::fmt::Write as _;

/// As our own reader takes it: the rate in a comment, then names, then rows. Numbers have as many
/// digits as bring them back bit by bit.
pub(super) fn bytes(table: &Table) -> Vec<u8> {
    let mut out = String::new();
    let title: String = table.title.chars().filter(|c| !c.is_control()).collect();
    let _ = writeln!(out, "# {title}");
    if let Along::Time { fs } = table.along {
        let _ = writeln!(out, "# fs = {fs}");
    }
    let (name, unit) = table.along.words();
    let _ = write!(out, "{name}_{unit}");
    for column in &table.columns {
        let plain = |text: &str| text.replace([',', '"', '\n'], " ");
        let _ = write!(out, ",{} ({})", plain(&column.name), plain(&column.unit));
    }
    out.push('\n');
    let (first, step) = table.along.grid();
    for row in 0..table.rows() {
        // Of a rate the time is a quotient: its digits do not add up to an uneven step.
        let at = match table.along {
            Along::Time { fs } => row as f64 / fs,
            Along::Frequency { .. } => first + step * row as f64,
        };
        let _ = write!(out, "{at}");
        for column in &table.columns {
            let _ = write!(out, ",{}", column.values[row]);
        }
        out.push('\n');
    }
    out.into_bytes()
}
