//! Load steps of a loaded ball bar: a table `angle_deg,load_n,deflection_um`.

use super::table::Dialect;
use super::{InputError, Problem, whole};
use std::path::Path;

const NAMES: [&str; 3] = ["angle_deg", "load_n", "deflection_um"];

/// One step of the load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadStep {
    /// Direction of the load, rad.
    pub angle_rad: f64,
    /// Load, N.
    pub load_n: f64,
    /// Deflection along it, m; its zero does not matter.
    pub deflection_m: f64,
}

/// Reads the load steps at `path`. Deflection is counted along the load; its zero does not
/// matter.
///
/// # Errors
/// The file cannot be read, has other columns, or a line that is no three numbers.
pub fn read_load_steps(path: &Path) -> Result<Vec<LoadStep>, InputError> {
    let bytes = whole::bytes(path, whole::MOST_TABLE)?;
    parse(&String::from_utf8_lossy(&bytes)).map_err(|e| e.in_file(path))
}

fn parse(text: &str) -> Result<Vec<LoadStep>, InputError> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(i, l)| (i + 1, l.trim()))
        .filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
    let (number, head) = lines.next().unwrap_or((1, ""));
    let dialect = Dialect::of(head);
    let names = dialect.fields(head);
    if names != NAMES {
        return Err(InputError::new(
            Problem::Header,
            format!("line {number}"),
            "the columns are not angle_deg, load_n, deflection_um",
            "name them so, in these units",
        ));
    }
    let mut out = Vec::new();
    for (number, line) in lines {
        let fields = dialect.fields(line);
        let value =
            |column: usize, unit: f64| dialect.quantity((number, column), fields.get(column), unit);
        out.push(LoadStep {
            angle_rad: value(0, 1_f64.to_radians())?,
            load_n: value(1, 1.0)?,
            deflection_m: value(2, 1e-6)?,
        });
    }
    if out.is_empty() {
        return Err(InputError::new(
            Problem::NoSamples,
            "data",
            "there is no line with numbers",
            "check that these are the load steps",
        ));
    }
    Ok(out)
}
