//! Comma-separated text, one sample per line.
//!
//! ```text
//! # fs = 5000          comment lines anywhere; this one gives the rate
//! time,x,y             a header line, optional
//! 0.0000,0.12,0.30     one column: the value; more: time in seconds, values
//! ```
//!
//! Semicolons (then with decimal commas if there are any) and tabs separate as
//! well. A header such as `t_ms` or `time (us)` scales the time column; one such as
//! `acceleration (m/s^2)` tells the unit of its column. Lines
//! are split here and not by the `csv` crate, which passes over empty lines: in
//! a recording an empty line is a sample that is missing, and has to be named.

use super::blocks::{Begin, Blocks, End};
use super::bytes::Bytes;
use super::time::{TimeColumn, is_rate, resolution_of};
use super::{InputError, Problem, no_channel};

/// Longest line that is read, bytes.
const LONGEST: usize = 1 << 20;
/// Lines handed on at once.
const BLOCK: usize = 1 << 12;
/// No quantity of a table of measurements is larger, in SI units: whatever is made of it, its
/// square too, is a number.
pub(super) const MOST_SI: f64 = 1e12;

/// Reads up to the first line that is no comment.
pub(super) fn begin(mut bytes: Bytes, fs: Option<f64>) -> Result<Begin, InputError> {
    plain(bytes.look(1 << 16)?)?;
    if bytes.look(3)? == [0xEF, 0xBB, 0xBF] {
        bytes.take(3);
    }
    let mut table = Table::new(bytes, fs);
    while table.dialect.is_none()
        && let Some(line) = table.read_line()?
    {
        table.begin_with(&line);
        if table.dialect.is_some() {
            table.first = Some(line);
        } else {
            table.line(&line, &mut [])?;
        }
    }
    let channels = table.channels_there();
    let told = table.comment_fs.map(|(_, fs)| fs);
    let told = told.filter(|fs| is_rate(*fs));
    Ok(Begin {
        format: match table.columns {
            0 | 1 => "CSV, values only".into(),
            n => format!("CSV, time and {} values per line", n - 1),
        },
        // A column of times tells the rate at its end only.
        fs: (fs.or(told)).filter(|_| table.columns == 1),
        step: None,
        channels,
        blocks: Box::new(table),
    })
}

fn plain(bytes: &[u8]) -> Result<(), InputError> {
    if bytes.contains(&0) {
        return Err(InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            "this is not plain text",
            "export as CSV in UTF-8, or correct the extension",
        ));
    }
    Ok(())
}

/// Separator and decimal sign, decided at the first line that is no comment.
#[derive(Clone, Copy)]
pub(super) struct Dialect {
    /// None: blanks.
    separator: Option<char>,
}

impl Dialect {
    pub(super) fn of(line: &str) -> Self {
        let separator = [';', '\t', ','].into_iter().find(|&c| line.contains(c));
        // Numbers with blanks between them; a name may have blanks in it.
        let is_number = |field: &str| field.parse::<f64>().is_ok();
        let by_blanks = separator.is_none() && line.split_whitespace().all(is_number);
        Self {
            separator: separator.or((!by_blanks).then_some(',')),
        }
    }

    /// The fields of a line, without blanks and quotes about them.
    pub(super) fn fields(self, line: &str) -> Vec<&str> {
        fn bare(field: &str) -> &str {
            field.trim().trim_matches('"')
        }
        match self.separator {
            Some(separator) => line.split(separator).map(bare).collect(),
            None => line.split_whitespace().map(bare).collect(),
        }
    }

    pub(super) fn number(self, field: &str) -> Option<f64> {
        if self.separator != Some(',') && field.contains(',') {
            return field.replace(',', ".").parse().ok();
        }
        field.parse().ok()
    }

    /// What one field of a table of measurements says in SI units, of which its own unit is
    /// so many; columns count from 0.
    pub(super) fn quantity(
        self,
        (line, column): (usize, usize),
        field: Option<&&str>,
        unit: f64,
    ) -> Result<f64, InputError> {
        let field = field.copied().unwrap_or_default();
        if field.is_empty() {
            return Err(hole(line, column + 1));
        }
        let number = self.number(field).filter(|x| x.is_finite());
        let number = number.ok_or_else(|| not_a_number(line, column + 1, field))?;
        let quantity = unit * number;
        if quantity.abs() > MOST_SI {
            return Err(InputError::new(
                Problem::Range,
                format!("line {line}, column {}", column + 1),
                format!("{number:e} is too large: {MOST_SI:e} in SI units at most"),
                "correct the line, or the unit of the column",
            ));
        }
        Ok(quantity)
    }
}

struct Table {
    bytes: Bytes,
    asked_fs: Option<f64>,
    /// The first line that is no comment, until it is given.
    first: Option<String>,
    /// Lines read.
    number: usize,
    channels: Vec<usize>,
    dialect: Option<Dialect>,
    /// Columns of the first line; every later one must have as many.
    columns: usize,
    time: TimeColumn,
    /// Seconds per unit of the time column.
    unit: f64,
    /// Units that the header tells, of all columns; empty without a header.
    units: Vec<Option<String>>,
    samples: u64,
    comment_fs: Option<(usize, f64)>,
    /// An empty line that is a hole if data follow.
    gap: Option<usize>,
    notices: Vec<String>,
}

impl Table {
    fn new(bytes: Bytes, asked_fs: Option<f64>) -> Self {
        Self {
            bytes,
            asked_fs,
            first: None,
            number: 0,
            channels: vec![0],
            dialect: None,
            columns: 0,
            time: TimeColumn::default(),
            unit: 1.0,
            units: Vec::new(),
            samples: 0,
            comment_fs: None,
            gap: None,
            notices: Vec::new(),
        }
    }

    /// The next line without spaces around it; none at the end.
    fn read_line(&mut self) -> Result<Option<String>, InputError> {
        let mut seen = 0;
        loop {
            let here = self.bytes.waiting();
            if let Some(end) = here[seen..].iter().position(|b| *b == b'\n') {
                return self.cut_line(seen + end, 1).map(Some);
            }
            seen = here.len();
            if seen > LONGEST {
                return Err(InputError::new(
                    Problem::NotThisFormat,
                    format!("line {}", self.number + 1),
                    format!("is longer than {LONGEST} bytes"),
                    "write one sample a line, or correct the extension",
                ));
            }
            if !self.bytes.more()? {
                return match seen {
                    0 => Ok(None),
                    all => self.cut_line(all, 0).map(Some),
                };
            }
        }
    }

    fn cut_line(&mut self, length: usize, break_: usize) -> Result<String, InputError> {
        let line = &self.bytes.waiting()[..length];
        plain(line)?;
        let line = String::from_utf8_lossy(line).trim().to_owned();
        self.bytes.take(length + break_);
        self.number += 1;
        Ok(line)
    }

    /// What the first line that is no comment tells.
    fn begin_with(&mut self, line: &str) {
        if self.dialect.is_none() && !line.is_empty() && !line.starts_with('#') {
            let dialect = Dialect::of(line);
            self.dialect = Some(dialect);
            self.columns = dialect.fields(line).len();
        }
    }

    fn line(&mut self, line: &str, rows: &mut [Vec<f64>]) -> Result<(), InputError> {
        let number = self.number;
        if let Some(comment) = line.strip_prefix('#') {
            if let Some(fs) = rate_in(comment) {
                self.comment_fs = Some((number, fs));
            }
            return Ok(());
        }
        if line.is_empty() {
            if self.samples > 0 && self.gap.is_none() {
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
        let Some(dialect) = self.dialect else {
            return Ok(());
        };
        let fields = dialect.fields(line);
        let first = self.first.take().is_some();
        if first && fields.iter().all(|f| dialect.number(f).is_none()) {
            return self.header(number, &fields);
        }
        self.data(number, &fields, dialect, rows)
    }

    fn header(&mut self, number: usize, fields: &[&str]) -> Result<(), InputError> {
        // A line of nothing but separators is a hole, not a header.
        if fields.iter().all(|f| f.is_empty()) {
            return Err(hole(number, 1));
        }
        self.units = fields.iter().map(|field| unit_in(field)).collect();
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

    fn data(
        &mut self,
        number: usize,
        fields: &[&str],
        dialect: Dialect,
        rows: &mut [Vec<f64>],
    ) -> Result<(), InputError> {
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
        let before = if self.columns == 1 {
            0
        } else {
            let resolution = resolution_of(fields[0]) * self.unit;
            self.time.push(value(0)? * self.unit, number, resolution);
            1
        };
        for (row, channel) in rows.iter_mut().zip(&self.channels) {
            row.push(value(before + channel)?);
        }
        self.samples += 1;
        Ok(())
    }

    /// Values only follow the time column where there are two or more.
    fn channels_there(&self) -> usize {
        self.columns.saturating_sub(1).max(1)
    }

    fn rate_from_words(&mut self) -> Result<f64, InputError> {
        match (self.asked_fs, self.comment_fs) {
            (Some(asked), Some((line, told))) => {
                if asked != told {
                    self.notices.push(format!(
                        "line {line} says fs = {told} Hz: --fs {asked} Hz used instead"
                    ));
                }
                Ok(asked)
            }
            (Some(fs), None) => Ok(fs),
            (None, Some((_, fs))) if is_rate(fs) => Ok(fs),
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

    fn rate_from_times(&mut self) -> Result<f64, InputError> {
        let fs = self.time.rate()?;
        match self.asked_fs {
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

impl Blocks for Table {
    fn want(&mut self, channels: &[usize]) {
        self.channels = channels.to_vec();
    }

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        if let Some(line) = self.first.clone() {
            self.line(&line, rows)?;
        }
        for _ in 0..BLOCK {
            let Some(line) = self.read_line()? else {
                return Ok(rows.first().is_some_and(|row| !row.is_empty()));
            };
            self.line(&line, rows)?;
        }
        Ok(true)
    }

    fn end(&mut self) -> Result<End, InputError> {
        if self.samples == 0 {
            return Err(InputError::new(
                Problem::NoSamples,
                "data",
                "there is no line with numbers",
                "check that this is the recording",
            ));
        }
        let fs = if self.columns == 1 {
            self.rate_from_words()?
        } else {
            self.rate_from_times()?
        };
        Ok(End {
            fs,
            notices: std::mem::take(&mut self.notices),
        })
    }

    fn unit(&self, channel: usize) -> Option<String> {
        let before = usize::from(self.columns > 1);
        self.units.get(before + channel)?.clone()
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        no_channel(&format!("line {}", self.number), asked, channels)
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

/// The unit behind the name of a column, as in `force (N)`.
fn unit_in(field: &str) -> Option<String> {
    let (_, unit) = field.strip_suffix(')')?.rsplit_once('(')?;
    let unit = unit.trim();
    (!unit.is_empty()).then(|| unit.to_owned())
}

/// The rate in a comment such as ` fs = 5000 Hz`.
fn rate_in(comment: &str) -> Option<f64> {
    let rest = comment.trim().strip_prefix("fs")?.trim_start();
    let rest = rest.strip_prefix(['=', ':'])?.trim();
    let number = rest.split_whitespace().next()?;
    number.trim_end_matches("Hz").parse().ok()
}
