//! What a universal file is made of: lines, fixed columns, numbers, labels of units.

use super::super::{InputError, Problem};

/// Lines and raw bytes by turns.
pub(in crate::input) struct Cursor<'a> {
    pub bytes: &'a [u8],
    pub at: usize,
    pub line: usize,
}

impl<'a> Cursor<'a> {
    pub fn line(&mut self) -> Option<(usize, String)> {
        let rest = self.bytes.get(self.at..).filter(|r| !r.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        self.line += 1;
        let text = String::from_utf8_lossy(&rest[..end]).into_owned();
        Some((self.line, text.trim_end_matches('\r').to_owned()))
    }

    pub fn raw(&mut self, count: usize) -> Option<&'a [u8]> {
        let found = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.at += count;
        Some(found)
    }
}

/// Hands each dataset's head to `take`: the lines behind it, the line of its kind, the kind. What is
/// not taken is passed over.
///
/// # Errors
/// It is no universal file, or ends inside a dataset; those of `take`.
pub(in crate::input) fn each_dataset(
    bytes: &[u8],
    mut take: impl FnMut(&mut Cursor<'_>, usize, &str) -> Result<(), InputError>,
) -> Result<(), InputError> {
    let mut cursor = Cursor {
        bytes,
        at: 0,
        line: 0,
    };
    while let Some((line, text)) = cursor.line() {
        if text.trim().is_empty() {
            continue;
        }
        if text.trim() != "-1" {
            return Err(InputError::new(
                Problem::NotThisFormat,
                format!("line {line}"),
                "a dataset should begin with -1 here",
                "check that this is a universal file",
            ));
        }
        let Some((line, kind)) = cursor.line() else {
            break;
        };
        take(&mut cursor, line, &kind)?;
        loop {
            match cursor.line() {
                Some((_, text)) if text.trim() == "-1" => break,
                Some(_) => {}
                None => return Err(cut_short(cursor.line)),
            }
        }
    }
    Ok(())
}

pub(in crate::input) fn cut_short(line: usize) -> InputError {
    InputError::new(
        Problem::Truncated,
        format!("line {line}"),
        "the file ends inside a dataset",
        "export it again",
    )
}

/// Field of fixed columns, without blanks.
pub(in crate::input) fn field(text: &str, from: usize, width: usize) -> String {
    text.chars()
        .skip(from)
        .take(width)
        .collect::<String>()
        .trim()
        .to_owned()
}

pub(in crate::input) fn number(line: usize, text: &str) -> Result<f64, InputError> {
    text.trim()
        .replace(['D', 'd'], "E")
        .parse()
        .map_err(|_| super::super::table::not_a_number(line, 1, text))
}

/// A whole number in fixed columns; the n-th word of the line where the columns do not
/// hold one, as some writers do not keep them.
pub(in crate::input) fn whole(
    line: usize,
    text: &str,
    (from, width): (usize, usize),
    word: usize,
) -> Result<i64, InputError> {
    let fixed = field(text, from, width).parse().ok();
    fixed
        .or_else(|| text.split_whitespace().nth(word)?.parse().ok())
        .ok_or_else(|| super::super::table::not_a_number(line, word + 1, text.trim()))
}

/// Ordinates as text: columns of 13 (single) or 20 characters, the abscissa always 13;
/// words where the columns hold no numbers.
pub(super) fn numbers_text(
    cursor: &mut Cursor<'_>,
    double: bool,
    even: bool,
    count: usize,
) -> Result<Vec<f64>, InputError> {
    let widths: &[usize] = match (double, even) {
        (false, _) => &[13],
        (true, true) => &[20],
        (true, false) => &[13, 20, 20],
    };
    let wanted = count.saturating_mul(if even { 2 } else { 3 });
    let mut out = Vec::new();
    while out.len() < wanted {
        let Some((line, text)) = cursor.line() else {
            return Err(cut_short(cursor.line));
        };
        if text.trim() == "-1" {
            return Err(InputError::new(
                Problem::Truncated,
                format!("line {line}"),
                format!("{} of {wanted} values", out.len()),
                "export it again",
            ));
        }
        match columns(&text, widths) {
            Some(found) => out.extend(found),
            None => {
                for word in text.split_whitespace() {
                    out.push(number(line, word)?);
                }
            }
        }
    }
    Ok(out)
}

pub(in crate::input) fn columns(text: &str, widths: &[usize]) -> Option<Vec<f64>> {
    let (mut out, mut at, mut k) = (Vec::new(), 0, 0);
    let length = text.trim_end().chars().count();
    while at < length {
        let width = widths[k % widths.len()];
        let word = field(text, at, width);
        out.push(word.replace(['D', 'd'], "E").parse().ok()?);
        (at, k) = (at + width, k + 1);
    }
    Some(out)
}

pub(super) fn numbers_binary(bytes: &[u8], big: bool, double: bool, even: bool) -> Vec<f64> {
    let single = |b: &[u8]| {
        let b: [u8; 4] = b.try_into().unwrap_or_default();
        f64::from(if big {
            f32::from_be_bytes(b)
        } else {
            f32::from_le_bytes(b)
        })
    };
    let whole = |b: &[u8]| {
        let b: [u8; 8] = b.try_into().unwrap_or_default();
        if big {
            f64::from_be_bytes(b)
        } else {
            f64::from_le_bytes(b)
        }
    };
    if !double {
        return bytes.chunks_exact(4).map(single).collect();
    }
    if even {
        return bytes.chunks_exact(8).map(whole).collect();
    }
    // An uneven abscissa stays single.
    bytes
        .chunks_exact(20)
        .flat_map(|b| [single(&b[..4]), whole(&b[4..12]), whole(&b[12..])])
        .collect()
}

/// Metres in a unit of motion, whatever the power of time below it.
pub(super) fn length_of(label: &str) -> Option<f64> {
    let head = label.split('/').next()?.trim();
    match head {
        "m" => Some(1.0),
        "mm" => Some(1e-3),
        "um" | "µm" => Some(1e-6),
        "in" => Some(0.0254),
        "g" => Some(9.806_65),
        _ => None,
    }
}

pub(super) fn force_of(label: &str) -> Option<f64> {
    match label {
        "N" => Some(1.0),
        "kN" => Some(1e3),
        "lbf" => Some(4.448_221_615_260_5),
        _ => None,
    }
}
