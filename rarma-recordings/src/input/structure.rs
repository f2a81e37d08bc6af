//! Modes of a structure at rest: what `rarma identify --json` writes, or a table with
//! the same names.
//!
//! ```text
//! {"modes": [{"f": 980, "f_sd": 0.4, "zeta": 0.02, "zeta_sd": 0.0003}, …], …}
//!
//! # hammer test, tool at the spindle
//! f,f_sd,zeta,zeta_sd          Hz, Hz, 1, 1
//! 980,0.4,0.02,0.0003
//! ```
//!
//! Whatever else a file holds is passed over.

use super::named::{Named, NamedLine};
use super::{InputError, Problem, whole};
use rarma_core::decide::{MAX_STRUCTURAL_MODES, StructuralMode, Structure, StructureError};
use serde_json::Value;
use std::path::Path;

/// No list of modes is larger than this, bytes: `identify --json` writes some hundred a mode.
const MOST_BYTES: u64 = 1 << 24;

/// The four names, in the order of [`StructuralMode`].
const NAMES: [&str; 4] = ["f", "f_sd", "zeta", "zeta_sd"];

/// A mode's numbers in the order of [`NAMES`], and its place in the file.
type Row = ([f64; 4], String);

/// Reads the structure at `path`, JSON or CSV by its extension.
///
/// # Errors
/// The file cannot be read or is no list of modes, or a mode is incomplete or out of
/// range: which, and where.
pub fn read(path: &Path) -> Result<Structure<f64>, InputError> {
    let load = || {
        let bytes = whole::bytes(path, MOST_BYTES)?;
        let extension = path.extension().and_then(|e| e.to_str());
        let rows = match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("json") => from_json,
            Some("csv" | "tsv" | "txt") => from_table,
            _ => {
                return Err(InputError::new(
                    Problem::Extension,
                    "name",
                    "not a kind of file that holds a structure",
                    "use .json or .csv",
                ));
            }
        };
        let text = whole::utf8(bytes)?;
        structure(&rows(text.strip_prefix('\u{feff}').unwrap_or(&text))?)
    };
    load().map_err(|e: InputError| e.in_file(path))
}

fn structure(rows: &[Row]) -> Result<Structure<f64>, InputError> {
    let modes: Vec<StructuralMode<f64>> = rows
        .iter()
        .map(|([f_hz, f_sd, zeta, zeta_sd], _)| StructuralMode {
            f_hz: *f_hz,
            f_sd: *f_sd,
            zeta: *zeta,
            zeta_sd: *zeta_sd,
        })
        .collect();
    let at = |i: usize, what: String| {
        let place = rows.get(i).map_or("file", |(_, place)| place);
        InputError::new(
            Problem::Range,
            place,
            what,
            "correct it or leave the mode out",
        )
    };
    Structure::new(&modes).map_err(|why| match why {
        StructureError::Empty => InputError::new(
            Problem::NoSamples,
            "modes",
            "there is none",
            "name at least one mode of the structure",
        ),
        StructureError::TooMany => InputError::new(
            Problem::Range,
            "modes",
            format!(
                "{} modes, there is room for {MAX_STRUCTURAL_MODES}",
                rows.len()
            ),
            "keep those that matter",
        ),
        StructureError::Frequency(i) => {
            at(i, format!("f is {}: must be above 0 Hz", modes[i].f_hz))
        }
        StructureError::Damping(i) => at(
            i,
            format!("zeta is {}: must lie between -1 and 1", modes[i].zeta),
        ),
        StructureError::Deviation(i) => at(
            i,
            format!(
                "f_sd is {}, zeta_sd is {}: standard deviations must be 0 or more",
                modes[i].f_sd, modes[i].zeta_sd
            ),
        ),
    })
}

fn from_json(text: &str) -> Result<Vec<Row>, InputError> {
    let value: Value = serde_json::from_str(text).map_err(|e| {
        InputError::new(
            Problem::NotThisFormat,
            format!("line {} column {}", e.line(), e.column()),
            "this is not JSON",
            "give the output of `rarma identify --json`",
        )
    })?;
    let modes = value
        .get("modes")
        .and_then(Value::as_array)
        .ok_or_else(|| {
            InputError::new(
                Problem::Hole,
                "modes",
                "there is no such list",
                "give the output of `rarma identify --json`",
            )
        })?;
    let number = |i: usize, mode: &Value, name: &str| {
        let place = format!("modes[{i}].{name}");
        let remedy = "give a number, or leave the mode out";
        match mode.get(name) {
            None => Err(InputError::new(Problem::Hole, place, "is missing", remedy)),
            Some(x) => x.as_f64().ok_or_else(|| {
                InputError::new(
                    Problem::NotANumber,
                    place,
                    format!("{x} is not a number"),
                    remedy,
                )
            }),
        }
    };
    let row = |(i, mode): (usize, &Value)| {
        let mut numbers = [0.0; 4];
        for (place, name) in numbers.iter_mut().zip(NAMES) {
            *place = number(i, mode, name)?;
        }
        Ok((numbers, format!("modes[{i}]")))
    };
    modes.iter().enumerate().map(row).collect()
}

fn from_table(text: &str) -> Result<Vec<Row>, InputError> {
    let table = Named::read(text, &NAMES, &[])?;
    let row = |line: &NamedLine| {
        let mut numbers = [0.0; 4];
        for (place, number) in numbers.iter_mut().enumerate() {
            *number = line.number(place)?;
        }
        Ok((numbers, line.place()))
    };
    table.lines.iter().map(row).collect()
}
