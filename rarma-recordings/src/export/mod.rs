//! Signals and spectra out, in the formats of other programs. Units stand in the file.
//!
//! | ending | what |
//! |---|---|
//! | `.csv` | a comment `# fs = …`, names of columns with units, then a line a sample |
//! | `.uff`, `.unv` | universal file, dataset 58, text in double precision, one for each column |
//! | `.mat` | MATLAB level 5, one variable for each part |
//!
//! All three are written out here: each is a page of code, and the crates that write them would
//! bring more than that (decision 7, of the readers, holds for them too).

mod csv;
mod mat;
mod uff;

use crate::output::{NewFile, Whole, WriteError, WriteProblem};
use std::path::Path;

/// What stands along the rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Along {
    /// Time from 0 on, in steps of 1/fs; fs in Hz.
    Time {
        /// Sampling rate, Hz.
        fs: f64,
    },
    /// Frequency in even steps, Hz.
    Frequency {
        /// The first one.
        first: f64,
        /// From one to the next.
        step: f64,
    },
}

impl Along {
    /// First value and step.
    fn grid(self) -> (f64, f64) {
        match self {
            Self::Time { fs } => (0.0, 1.0 / fs),
            Self::Frequency { first, step } => (first, step),
        }
    }

    /// Name and unit.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Time { .. } => ("time", "s"),
            Self::Frequency { .. } => ("frequency", "Hz"),
        }
    }
}

/// One column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name, such as `channel 0`.
    pub name: String,
    /// Number of the channel, counted from 0.
    pub channel: usize,
    /// Unit, such as `m/s^2`; `1` for parts of full scale.
    pub unit: String,
    /// A value for each row.
    pub values: Vec<f64>,
}

/// What is to be written: columns of one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What it is, one line.
    pub title: String,
    /// What the rows are.
    pub along: Along,
    /// The columns.
    pub columns: Vec<Column>,
}

impl Table {
    fn rows(&self) -> usize {
        self.columns
            .iter()
            .map(|c| c.values.len())
            .min()
            .unwrap_or(0)
    }
}

/// Formats by their endings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Lines of text.
    Csv,
    /// Universal file.
    Uff,
    /// MATLAB level 5.
    Mat,
}

impl Format {
    /// By the name of a file; none where its ending is none of these.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_ascii_lowercase();
        match ending.as_str() {
            "csv" => Some(Self::Csv),
            "uff" | "unv" => Some(Self::Uff),
            "mat" => Some(Self::Mat),
            _ => None,
        }
    }
}

/// Writes a table in the format of the file's ending; it takes its name when it is kept
/// ([`crate::output::keep`]).
///
/// # Errors
/// Another ending, more than the format holds, or a file that cannot be written.
pub fn write(path: &Path, table: &Table) -> Result<Whole, WriteError> {
    let Some(format) = Format::of(path) else {
        return Err(WriteError::new(
            WriteProblem::Ending,
            path,
            "",
            "has none of the endings .csv, .uff, .unv and .mat",
            "",
        ));
    };
    let bytes = match format {
        Format::Csv => csv::bytes(table),
        Format::Uff => uff::bytes(table),
        Format::Mat => mat::bytes(table).ok_or_else(|| {
            WriteError::new(
                WriteProblem::System,
                path,
                "write",
                "a variable of a MAT file holds no more than 2 GiB",
                "make it shorter, or write .csv",
            )
        })?,
    };
    NewFile::whole(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn table(n: usize) -> Table {
        let column = |channel: usize, unit: &str| Column {
            name: format!("channel {channel}"),
            channel,
            unit: unit.to_owned(),
            values: (0..n)
                .map(|t| ((t * (channel + 3)) as f64 * 0.37).sin() / 3.0)
                .collect(),
        };
        Table {
            title: "two sensors".to_owned(),
            along: Along::Time { fs: 44_100.0 },
            columns: vec![column(0, "m/s²"), column(1, "Pa")],
        }
    }

    #[test]
    fn endings_tell_the_format() {
        let of = |name: &str| Format::of(Path::new(name));
        assert_eq!(of("a.CSV"), Some(Format::Csv));
        assert_eq!(of("a.b.unv"), Some(Format::Uff));
        assert_eq!((of("a.wav"), of("mat")), (None, None));
    }

    /// Our own readers find every sample again, the rate and the units.
    #[test]
    fn csv_and_uff_come_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let table = table(1000);
        for (name, tolerance, unit) in [("a.csv", 0.0, "m/s²"), ("a.uff", 1e-12, "m/s^2")] {
            let path = folder.path().join(name);
            let whole = write(&path, &table).expect("written");
            crate::output::keep(vec![whole]).expect("kept");
            let options = crate::input::ReadOptions::default();
            let back = crate::input::read_channels(&path, &options, None, None).expect("read");
            assert_eq!(back.len(), 2, "{name}");
            let units = [&back[0], &back[1]].map(|r| r.unit.as_deref());
            assert_eq!(units, [Some(unit), Some("Pa")], "{name}");
            for (read, column) in back.iter().zip(&table.columns) {
                assert!((read.fs - 44_100.0).abs() < 1e-6, "{name}: {}", read.fs);
                assert_eq!(read.samples.len(), 1000);
                for (a, b) in read.samples.iter().zip(&column.values) {
                    assert!((a - b).abs() <= tolerance, "{name}: {a} {b}");
                }
            }
        }
    }
}
