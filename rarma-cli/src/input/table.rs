//! Comma-separated text, one sample per line.
//!
//! ```text
//! # fs = 5000          comment lines anywhere; this one gives the rate
//! time,x,y             a header line, optional
//! 0.0000,0.12,0.30     one column: the value; more: time in seconds, values
//! ```
//!
//! Semicolons (then with decimal commas if there are any) and tabs separate as
//! well. A header such as `t_ms` or `time (us)` scales the time column. Lines
//! are split here and not by the `csv` crate, which passes over empty lines: in
//! a recording an empty line is a sample that is missing, and has to be named.

use super::time::{TimeColumn, resolution_of};
use super::{Decoded, InputError, Problem, ReadOptions, no_channel};

/// Reads the chosen column of a table.
pub(super) fn decode(bytes: &[u8], opts: &ReadOptions) -> Result<Decoded, InputError> {
    if bytes.contains(&0) {
        return Err(InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            "this is not plain text",
            "export as CSV in UTF-8, or correct the extension",
        ));
    }
    let text = String::from_utf8_lossy(bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let mut table = Table::new(opts.channel);
    for (i, line) in text.lines().enumerate() {
        table.line(i + 1, line.trim())?;
    }
    table.finish(opts)
}

/// Separator and decimal sign, decided at the first line that is no comment.
#[derive(Clone, Copy)]
pub(super) struct Dialect {
    pub(super) separator: char,
    decimal_comma: bool,
}

impl Dialect {
    pub(super) fn of(line: &str) -> Self {
        let separator = [';', '\t']
            .into_iter()
            .find(|&c| line.contains(c))
            .unwrap_or(',');
        Self {
            separator,
            decimal_comma: separator != ',',
        }
    }

    pub(super) fn number(self, field: &str) -> Option<f64> {
        if self.decimal_comma && field.contains(',') {
            return field.replace(',', ".").parse().ok();
        }
        field.parse().ok()
    }
}

struct Table {
    channel: usize,
    dialect: Option<Dialect>,
    /// Columns of the first line; every later one must have as many.
    columns: usize,
    time: TimeColumn,
    /// Seconds per unit of the time column.
    unit: f64,
    samples: Vec<f64>,
    comment_fs: Option<(usize, f64)>,
    /// An empty line that is a hole if data follow.
    gap: Option<usize>,
    notices: Vec<String>,
}

impl Table {
    fn new(channel: usize) -> Self {
        Self {
            channel,
            dialect: None,
            columns: 0,
            time: TimeColumn::default(),
            unit: 1.0,
            samples: Vec::new(),
            comment_fs: None,
            gap: None,
            notices: Vec::new(),
        }
    }

    fn line(&mut self, number: usize, line: &str) -> Result<(), InputError> {
        if let Some(comment) = line.strip_prefix('#') {
            if let Some(fs) = rate_in(comment) {
                self.comment_fs = Some((number, fs));
            }
            return Ok(());
        }
        if line.is_empty() {
            if !self.samples.is_empty() && self.gap.is_none() {
                self.gap = Some(number);
            }
            return Ok(());
        }
        if let Some(gap) = self.gap {
            return Err(InputError::new(
                Problem::Hole,
                format!("line {gap}"),
                "an empty line in the middle of the data",
                "fill in the sample or cut the recording there",
            ));
        }
        let first = self.dialect.is_none();
        let dialect = *self.dialect.get_or_insert_with(|| Dialect::of(line));
        let fields: Vec<&str> = line
            .split(dialect.separator)
            .map(|f| f.trim().trim_matches('"'))
            .collect();
        if first {
            self.columns = fields.len();
            // Values only follow the time column where there are two or more.
            let channels = self.channels();
            if self.channel >= channels {
                let place = format!("line {number}");
                return Err(no_channel(&place, self.channel, channels));
            }
            if fields.iter().all(|f| dialect.number(f).is_none()) {
                return self.header(number, &fields);
            }
        }
        self.data(number, &fields, dialect)
    }

    fn header(&mut self, number: usize, fields: &[&str]) -> Result<(), InputError> {
        // A line of nothing but separators is a hole, not a header.
        if fields.iter().all(|f| f.is_empty()) {
            return Err(hole(number, 1));
        }
        let name = fields[0].to_lowercase();
        let ends = |unit: &str| {
            name.trim_end_matches([')', ']'])
                .strip_suffix(unit)
                .is_some_and(|head| head.ends_with(['_', '(', '[', ' ', '/']))
        };
        if self.columns > 1 {
            if ends("ms") {
                self.unit = 1e-3;
            } else if ends("us") || ends("µs") {
                self.unit = 1e-6;
            }
        }
        Ok(())
    }

    fn data(&mut self, number: usize, fields: &[&str], dialect: Dialect) -> Result<(), InputError> {
        if fields.len() > self.columns {
            return Err(InputError::new(
                Problem::NotANumber,
                format!("line {number}"),
                format!(
                    "{} fields, the first line has {}",
                    fields.len(),
                    self.columns
                ),
                "give every line the same columns",
            ));
        }
        let value = |column: usize| -> Result<f64, InputError> {
            match fields.get(column) {
                None | Some(&"") => Err(hole(number, column + 1)),
                Some(field) => dialect
                    .number(field)
                    .ok_or_else(|| not_a_number(number, column + 1, field)),
            }
        };
        if self.columns == 1 {
            self.samples.push(value(0)?);
            return Ok(());
        }
        self.time.seconds.push(value(0)? * self.unit);
        self.time.lines.push(number);
        let resolution = resolution_of(fields[0]) * self.unit;
        // Trailing zeros may be left out, so the finest line tells.
        self.time.resolution = match self.time.seconds.len() {
            1 | 2 => resolution,
            _ => self.time.resolution.min(resolution),
        };
        self.samples.push(value(1 + self.channel)?);
        Ok(())
    }

    fn channels(&self) -> usize {
        self.columns.saturating_sub(1).max(1)
    }

    fn finish(mut self, opts: &ReadOptions) -> Result<Decoded, InputError> {
        if self.samples.is_empty() {
            return Err(InputError::new(
                Problem::NoSamples,
                "data",
                "there is no line with numbers",
                "check that this is the recording",
            ));
        }
        let fs = if self.columns == 1 {
            self.rate_from_words(opts)?
        } else {
            self.rate_from_times(opts)?
        };
        Ok(Decoded {
            format: match self.columns {
                1 => "CSV, values only".into(),
                n => format!("CSV, time and {} values per line", n - 1),
            },
            fs,
            channels: self.channels(),
            samples: self.samples,
            step: None,
            gaps: Vec::new(),
            notices: self.notices,
        })
    }

    fn rate_from_words(&mut self, opts: &ReadOptions) -> Result<f64, InputError> {
        match (opts.fs, self.comment_fs) {
            (Some(asked), Some((line, told))) => {
                if asked != told {
                    self.notices.push(format!(
                        "line {line} says fs = {told} Hz: --fs {asked} Hz used instead"
                    ));
                }
                Ok(asked)
            }
            (Some(fs), None) => Ok(fs),
            (None, Some((_, fs))) if fs.is_finite() && fs > 0.0 => Ok(fs),
            (None, Some((line, fs))) => Err(InputError::new(
                Problem::Rate,
                format!("line {line}"),
                format!("{fs} is not a sampling rate"),
                "correct the comment or give --fs in hertz",
            )),
            (None, None) => Err(InputError::new(
                Problem::Rate,
                "columns",
                "one column without times, so its sampling rate is unknown",
                "give --fs in hertz, or a line '# fs = 5000'",
            )),
        }
    }

    fn rate_from_times(&mut self, opts: &ReadOptions) -> Result<f64, InputError> {
        let fs = self.time.rate()?;
        match opts.fs {
            Some(asked) if (asked - fs).abs() > 0.01 * fs => Err(InputError::new(
                Problem::Rate,
                "time column",
                format!("it says {fs:.6} Hz, --fs says {asked} Hz"),
                "leave out --fs, or correct the times",
            )),
            Some(asked) => Ok(asked),
            None => Ok(fs),
        }
    }
}

pub(super) fn hole(line: usize, column: usize) -> InputError {
    InputError::new(
        Problem::Hole,
        format!("line {line}"),
        format!("no value in column {column}"),
        "fill in the sample or cut the recording there",
    )
}

pub(super) fn not_a_number(line: usize, column: usize, field: &str) -> InputError {
    let mut shown: String = field.chars().take(24).collect();
    if shown.len() < field.len() {
        shown.push('…');
    }
    InputError::new(
        Problem::NotANumber,
        format!("line {line}"),
        format!("'{shown}' in column {column} is not a number"),
        "correct the line, or mark it as a comment with #",
    )
}

/// The rate in a comment such as ` fs = 5000 Hz`.
fn rate_in(comment: &str) -> Option<f64> {
    let rest = comment.trim().strip_prefix("fs")?.trim_start();
    let rest = rest.strip_prefix(['=', ':'])?.trim();
    let number = rest.split_whitespace().next()?;
    number.trim_end_matches("Hz").parse().ok()
}
