//! Speeds of a spindle as a control tells them, over time.
//!
//! ```text
//! # spindle 1
//! time,rpm          s from the first sample on, 1/min
//! 0.0,4500
//! 12.4,4950
//! ```
//!
//! Beside a recording it is read whole, and refused before anything is heard. Beside a live sound a
//! pipe is read line by line as it comes: what is wrong with a line is said, and the line is passed
//! over.

use super::table::{Dialect, hole, not_a_number};
use super::{InputError, Problem};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

/// No list of speeds is larger than this, bytes: a day at ten a second has 20 MB.
const MOST_BYTES: u64 = 1 << 28;
/// No line is longer, bytes.
const LONGEST: u64 = 1 << 10;
/// What a spindle may turn, 1/min.
const RPM: (f64, f64) = (0.06, 300_000.0);

/// Time, s, and speed, 1/min.
type Row = (f64, f64);

enum Rows {
    Whole(std::vec::IntoIter<Row>),
    Pipe(Receiver<Result<Row, InputError>>),
}

/// The speeds that are still to come.
pub struct Speeds {
    path: PathBuf,
    rows: Rows,
    next: Option<Row>,
    /// The first, 1/min.
    first: f64,
}

impl Speeds {
    /// Opens a file, a pipe, or standard input (`-`). Beside a recording everything is read at
    /// once; beside a `live` sound a pipe is followed as it comes, and its first speed waited for.
    ///
    /// # Errors
    /// It cannot be read, or holds no speed; of what is read at once: which line is wrong, and
    /// how.
    pub fn open(path: &Path, live: bool) -> Result<Self, InputError> {
        let load = || {
            let (source, is_pipe) = opened(path)?;
            if live && is_pipe {
                let rows = follow(source);
                return Self::begin(path, rows.recv().ok().transpose()?, Rows::Pipe(rows));
            }
            let mut rows = whole(source)?.into_iter();
            Self::begin(path, rows.next(), Rows::Whole(rows))
        };
        load().map_err(|why: InputError| why.in_file(path))
    }

    fn begin(path: &Path, first: Option<Row>, rows: Rows) -> Result<Self, InputError> {
        let Some((_, rpm)) = first else {
            return Err(InputError::new(
                Problem::NoSamples,
                "file",
                "there is no speed in it",
                "give lines of time in s and speed in 1/min",
            ));
        };
        Ok(Self {
            path: path.to_owned(),
            rows,
            next: first,
            first: rpm,
        })
    }

    /// The first speed, 1/min: it stands from the beginning.
    pub fn first(&self) -> f64 {
        self.first
    }

    /// The newest speed whose time has come at `t_s`, 1/min; of a pipe, what is wrong with its
    /// lines goes to `odd`.
    pub fn due(&mut self, t_s: f64, mut odd: impl FnMut(InputError)) -> Option<f64> {
        let mut newest = None;
        loop {
            if self.next.is_none() {
                self.next = match &mut self.rows {
                    Rows::Whole(rows) => rows.next(),
                    Rows::Pipe(rows) => match rows.try_recv() {
                        Ok(Ok(row)) => Some(row),
                        Ok(Err(why)) => {
                            odd(why.in_file(&self.path));
                            continue;
                        }
                        // Nothing yet, or no more.
                        Err(_) => None,
                    },
                };
            }
            match self.next {
                Some((from_s, rpm)) if from_s <= t_s => {
                    newest = Some(rpm);
                    self.next = None;
                }
                _ => return newest,
            }
        }
    }
}

/// What is to be read, and whether it may come bit by bit.
fn opened(path: &Path) -> Result<(Box<dyn Read + Send>, bool), InputError> {
    if path == Path::new("-") {
        return Ok((Box::new(io::stdin()), true));
    }
    let failed = |why| InputError::from_io(&why);
    let file = File::open(path).map_err(failed)?;
    let is_pipe = !file.metadata().map_err(failed)?.is_file();
    Ok((Box::new(file), is_pipe))
}

/// All rows at once.
fn whole(source: impl Read) -> Result<Vec<Row>, InputError> {
    let mut bytes = Vec::new();
    source
        .take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|why| InputError::from_io(&why))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(InputError::new(
            Problem::Size,
            format!("byte {MOST_BYTES}"),
            "the list goes on: no list of speeds is longer",
            "check that it is the right file",
        ));
    }
    let text = super::whole::utf8(bytes)?;
    let mut reader = Lines::default();
    let mut rows = Vec::new();
    for line in text.strip_prefix('\u{feff}').unwrap_or(&text).lines() {
        rows.extend(reader.line(line)?);
    }
    Ok(rows)
}

/// Reads a pipe beside the listening, which does not wait for it.
fn follow(pipe: impl Read + Send + 'static) -> Receiver<Result<Row, InputError>> {
    let (send, rows) = channel();
    thread::spawn(move || {
        let mut reader = Lines::default();
        let mut pipe = BufReader::new(pipe);
        let mut line = Vec::new();
        loop {
            line.clear();
            match pipe.by_ref().take(LONGEST).read_until(b'\n', &mut line) {
                Ok(0) => return,
                Ok(_) => {}
                Err(why) => {
                    let _ = send.send(Err(InputError::from_io(&why)));
                    return;
                }
            }
            let row = reader.line(&String::from_utf8_lossy(&line)).transpose();
            if row.is_some_and(|row| send.send(row).is_err()) {
                return;
            }
        }
    });
    rows
}

/// Lines one after the other.
#[derive(Default)]
struct Lines {
    number: usize,
    dialect: Option<Dialect>,
    last_s: Option<f64>,
}

impl Lines {
    /// What a line tells; nothing if it is a comment, empty, or the header.
    fn line(&mut self, line: &str) -> Result<Option<Row>, InputError> {
        self.number += 1;
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            return Ok(None);
        }
        let is_first = self.dialect.is_none();
        let dialect = *self.dialect.get_or_insert_with(|| Dialect::of(line));
        let fields: Vec<&str> = line.split(dialect.separator).map(str::trim).collect();
        if is_first && fields.iter().all(|field| dialect.number(field).is_none()) {
            return Ok(None);
        }
        let number = |column: usize| {
            let field = fields.get(column).copied().unwrap_or_default();
            if field.is_empty() {
                return Err(hole(self.number, column + 1));
            }
            let number = dialect.number(field).filter(|x| x.is_finite());
            number.ok_or_else(|| not_a_number(self.number, column + 1, field))
        };
        let (t_s, rpm) = (number(0)?, number(1)?);
        let at = format!("line {}", self.number);
        if !(RPM.0..=RPM.1).contains(&rpm) {
            return Err(InputError::new(
                Problem::Range,
                at,
                format!("{rpm} 1/min is no speed: 0.06 to 300000"),
                "leave the line out, or correct it",
            ));
        }
        if let Some(last_s) = self.last_s
            && t_s < last_s
        {
            return Err(InputError::new(
                Problem::Range,
                at,
                format!("{t_s} s comes after {last_s} s: time goes back"),
                "sort the lines by time",
            ));
        }
        self.last_s = Some(t_s);
        Ok(Some((t_s, rpm)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Speeds, InputError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("speed.csv");
        crate::output::write(&path, text).expect("written");
        Speeds::open(&path, false)
    }

    #[test]
    fn each_speed_counts_from_its_time_on() {
        let text = "# spindle\ntime,rpm\n0,4500\n\n1.5,4950\n1.6;\n";
        let mut speeds = read(&text[..text.len() - 5]).expect("speeds");
        assert_eq!(speeds.first(), 4500.0);
        let mut due = |t| speeds.due(t, |why| panic!("{why}"));
        assert_eq!(due(0.0), Some(4500.0));
        assert_eq!(due(1.4), None);
        assert_eq!(due(2.0), Some(4950.0));
        assert_eq!(due(1e9), None);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, line, word) in [
            ("0,4500\n2,4600\n1,4700\n", "line 3", "goes back"),
            ("0,4500\n1,NaN\n", "line 2", "not a number"),
            ("0,4500\n1\n", "line 2", "no value"),
            ("0,0\n", "line 1", "no speed"),
            ("time,rpm\n", "file", "no speed"),
        ] {
            let why = read(text).map(|_| ()).expect_err(text).to_string();
            assert!(why.contains(line) && why.contains(word), "{text}: {why}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_is_followed_and_its_odd_lines_are_passed_over() {
        use std::io::Write;
        let (read, mut write) = io::pipe().expect("a pipe");
        let rows = follow(read);
        write
            .write_all(b"0,4500\nx,y,z\n0.5,nan\n0.4,5000\n")
            .expect("written");
        drop(write);
        let first = rows.recv().expect("a row").expect("a speed");
        let mut speeds =
            Speeds::begin(Path::new("pipe"), Some(first), Rows::Pipe(rows)).expect("speeds");
        let (mut told, mut odd) = (Vec::new(), 0);
        for _ in 0..1000 {
            told.extend(speeds.due(0.45, |_| odd += 1));
            if odd == 2 && told.len() == 2 {
                break;
            }
            thread::sleep(std::time::Duration::from_millis(5));
        }
        assert_eq!((told.last(), odd), (Some(&5000.0), 2));
    }
}
