//! Receptances in: CSV and universal files (dataset 58) become one list of functions in
//! m/N.
//!
//! | extension | content | units |
//! |---|---|---|
//! | `.csv`, `.txt` | `freq_hz`, then a real and an imaginary column a function | in the names of the columns |
//! | `.uff`, `.unv`, `.bun` | datasets 58 and 58b with function type 4, and 164 | dataset 164, or the labels |
//!
//! Directions are u and v, response first: `uv` is the response in u to a force in v. In a
//! universal file direction ±1 (x) is u and ±2 (y) is v; a minus turns the sign.

mod csv;
mod merge;
mod uff;
pub(super) mod uff_numbers;
mod uff_write;

pub use merge::{Plane, Role, merge};
pub(crate) use uff_write::exponent;
pub use uff_write::write_uff;

use super::{InputError, Problem, whole};
use rarma_rigs::els::Complex;
use std::path::{Path, PathBuf};

/// One frequency response function in m/N.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// File it is from.
    pub path: PathBuf,
    /// Where in the file.
    pub place: String,
    /// Directions, where the file says them.
    pub role: Option<Role>,
    /// Frequencies, Hz, rising.
    pub f_hz: Vec<f64>,
    /// Displacement over force, m/N.
    pub g: Vec<Complex<f64>>,
    /// Odd, but not fatal: one sentence each.
    pub notices: Vec<String>,
}

/// What a column or a dataset holds, to be turned into displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Motion {
    Displacement,
    Velocity,
    Acceleration,
}

impl Motion {
    /// Displacement of a motion at `f` Hz: over jω or (jω)². Not finite at 0 Hz for the
    /// other two.
    pub(super) fn displacement(self, z: Complex<f64>, f: f64) -> Complex<f64> {
        let w = core::f64::consts::TAU * f;
        match self {
            Self::Displacement => z,
            Self::Velocity => Complex::new(z.im / w, -z.re / w),
            Self::Acceleration => z.scale(-1.0 / (w * w)),
        }
    }
}

/// Reads every receptance of a file.
///
/// # Errors
/// The file cannot be read, holds no receptance, or one that is broken: which, and where.
pub fn read_receptances(path: &Path) -> Result<Vec<Function>, InputError> {
    let load = || {
        let extension = path.extension().and_then(|e| e.to_str());
        let bytes = whole::bytes(path, whole::MOST_TABLE)?;
        if bytes.is_empty() {
            return Err(InputError::new(
                Problem::Empty,
                "byte 0",
                "the file is empty",
                "export it again",
            ));
        }
        match extension.map(str::to_ascii_lowercase).as_deref() {
            Some("csv" | "txt" | "tsv") => csv::read(&bytes),
            Some("uff" | "unv" | "bun" | "uf") => uff::read(&bytes),
            _ => Err(InputError::new(
                Problem::Extension,
                "name",
                "not a kind of file that holds receptances",
                "use .csv or .uff",
            )),
        }
    };
    let mut functions = load().map_err(|e| e.in_file(path))?;
    for function in &mut functions {
        path.clone_into(&mut function.path);
        sound(function).map_err(|e| e.in_file(path))?;
    }
    Ok(functions)
}

/// Rising frequencies, finite values; a line at 0 Hz that divides by ω = 0 is left out.
fn sound(function: &mut Function) -> Result<(), InputError> {
    if function.f_hz.first() == Some(&0.0) && function.g.first().is_some_and(|g| !g.is_finite()) {
        function.f_hz.remove(0);
        function.g.remove(0);
    }
    let place = |k: usize| format!("{}, line {k} of the data", function.place);
    if function.f_hz.len() < 3 {
        return Err(InputError::new(
            Problem::NoSamples,
            function.place.clone(),
            format!("{} frequencies, at least 3 are needed", function.f_hz.len()),
            "export the whole function",
        ));
    }
    if let Some(k) = function.g.iter().position(|g| !g.is_finite()) {
        return Err(InputError::new(
            Problem::NonFinite,
            place(k),
            "the receptance is not a finite number",
            "cut the band there",
        ));
    }
    if let Some(k) = function.f_hz.iter().position(|f| !f.is_finite()) {
        return Err(InputError::new(
            Problem::NonFinite,
            place(k),
            "the frequency is not a finite number",
            "repair the column of frequencies",
        ));
    }
    let rising = |k: &usize| !(function.f_hz[*k] > function.f_hz[*k - 1]);
    if let Some(k) = (1..function.f_hz.len()).find(rising) {
        return Err(InputError::new(
            Problem::Grid,
            place(k),
            format!("the frequency {} Hz does not rise", function.f_hz[k]),
            "sort the lines and leave out repeated ones",
        ));
    }
    if function.f_hz[0] < 0.0 {
        return Err(InputError::new(
            Problem::Range,
            place(0),
            "a negative frequency",
            "export the one-sided function",
        ));
    }
    Ok(())
}
