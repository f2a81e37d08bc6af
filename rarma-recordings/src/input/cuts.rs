//! Cuts that are known: which speeds were stable with a tool, and which chattered.
//!
//! ```text
//! # end mill 12 mm, 4 teeth, aluminium
//! rpm,state,f,depth            1/min, stable or chatter, Hz, mm
//! 12000,chatter,1128,2
//! 10700,stable,,2
//! ```
//!
//! `f`, the frequency of the chatter, and `depth` may be left out.

use super::named::{Named, NamedLine};
use super::{InputError, Problem, whole};
use std::path::Path;

/// No such list is larger, bytes.
const MOST_BYTES: u64 = 1 << 24;
const NEEDED: [&str; 2] = ["rpm", "state"];
const OPTIONAL: [&str; 2] = ["f", "depth"];
/// The header of a list.
pub const CUTS_HEADER: &str = "rpm,state,f,depth";

/// A cut of the list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutRow {
    /// Speed of the spindle, 1/min.
    pub rpm: f64,
    /// It was stable; else it chattered.
    pub stable: bool,
    /// Frequency of the chatter, Hz.
    pub f_hz: Option<f64>,
    /// Depth of cut, mm.
    pub depth_mm: Option<f64>,
}

impl CutRow {
    /// As a line of a list.
    pub fn line(&self) -> String {
        let state = if self.stable { "stable" } else { "chatter" };
        let number = |x: Option<f64>| x.map(|x| x.to_string()).unwrap_or_default();
        format!(
            "{},{state},{},{}",
            self.rpm,
            number(self.f_hz),
            number(self.depth_mm)
        )
    }
}

/// Reads the list of cuts at `path`.
///
/// # Errors
/// The file cannot be read or is no such list; a number is missing or out of range: where.
pub fn read(path: &Path) -> Result<Vec<CutRow>, InputError> {
    let load = || {
        let text = whole::utf8(whole::bytes(path, MOST_BYTES)?)?;
        rows(text.strip_prefix('\u{feff}').unwrap_or(&text))
    };
    load().map_err(|e: InputError| e.in_file(path))
}

/// Whether the list at `path` has the columns of [`CUTS_HEADER`], so that a line can be added.
///
/// # Errors
/// The file cannot be read.
pub fn has_header(path: &Path) -> Result<bool, InputError> {
    let load = || whole::utf8(whole::bytes(path, MOST_BYTES)?);
    let text = load().map_err(|e: InputError| e.in_file(path))?;
    let mut lines = text.lines().map(str::trim);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#'));
    Ok(first.is_some_and(|line| line == CUTS_HEADER))
}

fn rows(text: &str) -> Result<Vec<CutRow>, InputError> {
    let table = Named::read(text, &NEEDED, &OPTIONAL)?;
    table.lines.iter().map(row).collect()
}

fn row(line: &NamedLine) -> Result<CutRow, InputError> {
    let wrong =
        |what: String, remedy: &str| InputError::new(Problem::Range, line.place(), what, remedy);
    let positive = |name: &str, x: f64| {
        if x > 0.0 && x < 1e9 {
            return Ok(x);
        }
        Err(wrong(
            format!("{name} is {x}: must be above 0"),
            "correct it or leave the line out",
        ))
    };
    let rpm = positive("rpm", line.number(0)?)?;
    let stable = match line.text(1) {
        "stable" => true,
        "chatter" => false,
        other => {
            return Err(wrong(
                format!("state is `{other}`"),
                "write `stable` or `chatter`",
            ));
        }
    };
    let maybe = |place, name| line.maybe(place)?.map(|x| positive(name, x)).transpose();
    Ok(CutRow {
        rpm,
        stable,
        f_hz: maybe(2, "f")?.filter(|_| !stable),
        depth_mm: maybe(3, "depth")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_read_as_it_is_written() {
        let cuts = [
            CutRow {
                rpm: 12_000.0,
                stable: false,
                f_hz: Some(1128.5),
                depth_mm: Some(2.0),
            },
            CutRow {
                rpm: 10_700.0,
                stable: true,
                f_hz: None,
                depth_mm: None,
            },
        ];
        let lines: Vec<String> = cuts.iter().map(CutRow::line).collect();
        let text = format!("# a tool\n{CUTS_HEADER}\n{}\n", lines.join("\n"));
        assert_eq!(rows(&text).unwrap(), cuts);
        // Other order, other separator, a column that nobody asked for, none of those that may be missing.
        let other = rows("state;who;rpm\nstable;ada;10700,5\n").unwrap();
        assert_eq!((other[0].rpm, other[0].stable), (10_700.5, true));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        for (text, says) in [
            ("", "holds nothing"),
            ("rpm,f\n1,2\n", "no column state"),
            ("rpm,state\n,stable\n", "line 2"),
            ("rpm,state\n0,stable\n", "rpm is 0: must be above 0"),
            ("rpm,state\n-5,stable\n", "rpm is -5"),
            ("rpm,state\nNaN,stable\n", "rpm is NaN"),
            ("rpm,state\nfast,stable\n", "fast"),
            ("rpm,state\n100,quiet\n", "state is `quiet`"),
            ("rpm,state,f\n100,chatter,x\n", "line 2"),
            ("rpm,state,depth\n100,stable,0\n", "depth is 0"),
        ] {
            let error = rows(text).unwrap_err().to_string();
            assert!(error.contains(says), "{text:?}: {error}");
        }
    }
}
