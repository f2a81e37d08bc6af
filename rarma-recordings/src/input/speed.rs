//! Speeds of a spindle as a control tells them, over time.
//!
//! ```text
//! # spindle 1
//! time,rpm          s from the first sample on, 1/min
//! 0.0,4500
//! 12.4,4950
//! ```
//!
//! The sign, which tells the direction, is of no account. A spindle that stands makes no lines: a
//! line that says so is checked and passed over, and the speed before stays in force.
//!
//! Beside a recording it is read whole, and refused before anything is heard. Beside a live sound a
//! pipe is read line by line as it comes: what is wrong with a line is said, and the line is passed
//! over.

use super::table::{Dialect, hole, not_a_number};
use super::whole::not_text;
use super::{InputError, Problem};
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// No list of speeds is larger than this, bytes: a day at ten a second has 20 MB.
const MOST_BYTES: u64 = 1 << 28;
/// No line is longer, bytes, its end included; of a comment the rest does not matter.
const LONGEST: u64 = 1 << 10;
/// A pipe is read so many lines ahead, and no further: whoever writes more waits.
const AHEAD: usize = 1 << 10;
/// What a spindle may turn, 1/min; below it stands.
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
    /// once; beside a `live` sound a pipe is [followed](Self::follow).
    ///
    /// # Errors
    /// It cannot be read, or holds no speed; of what is read at once: which line is wrong, and
    /// how.
    pub fn open(path: &Path, live: bool) -> Result<Self, InputError> {
        let (source, is_pipe) = opened(path).map_err(|why| why.in_file(path))?;
        if live && is_pipe {
            return Self::follow(path, source);
        }
        let load = || {
            let mut rows = whole(source)?.into_iter();
            Self::begin(path, rows.next(), Rows::Whole(rows))
        };
        load().map_err(|why| why.in_file(path))
    }

    /// Follows a pipe, of this name in messages, as it comes; its first speed is waited for.
    ///
    /// # Errors
    /// It cannot be read, ends without a speed, or what comes before the first is wrong.
    pub fn follow(path: &Path, pipe: impl Read + Send + 'static) -> Result<Self, InputError> {
        let rows = as_they_come(pipe);
        let first = rows.recv().ok().transpose();
        first
            .and_then(|first| Self::begin(path, first, Rows::Pipe(rows)))
            .map_err(|why| why.in_file(path))
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
        while let Some((_, rpm)) = self.next_until(t_s, &mut odd) {
            newest = Some(rpm);
        }
        newest
    }

    /// The next speed whose time has come at `t_s`: its time, s, and 1/min; `odd` as in
    /// [`due`](Self::due).
    pub fn next_until(&mut self, t_s: f64, mut odd: impl FnMut(InputError)) -> Option<Row> {
        while self.next.is_none() {
            self.next = match &mut self.rows {
                Rows::Whole(rows) => Some(rows.next()?),
                // Nothing yet, or no more.
                Rows::Pipe(rows) => match rows.try_recv().ok()? {
                    Ok(row) => Some(row),
                    Err(why) => {
                        odd(why.in_file(&self.path));
                        None
                    }
                },
            };
        }
        self.next.take_if(|(from_s, _)| *from_s <= t_s)
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
    let mut lines = Lines::of(source.take(MOST_BYTES + 1));
    let rows = lines.by_ref().collect();
    // Then the last line may be cut, and wrong for that.
    if lines.source.get_ref().limit() == 0 {
        return Err(InputError::new(
            Problem::Size,
            format!("byte {MOST_BYTES}"),
            "the list goes on: no list of speeds is longer",
            "check that it is the right file",
        ));
    }
    rows
}

/// Reads a pipe beside the listening, which does not wait for it.
fn as_they_come(pipe: impl Read + Send + 'static) -> Receiver<Result<Row, InputError>> {
    let (send, rows) = sync_channel(AHEAD);
    thread::spawn(move || {
        // Until the pipe ends, or nobody listens any more.
        let _ = Lines::of(pipe).try_for_each(|row| send.send(row));
    });
    rows
}

/// Lines one after the other: the speed that each tells, or what is wrong with it.
struct Lines<R> {
    source: BufReader<R>,
    line: Vec<u8>,
    number: usize,
    /// The line was too long, and its rest is still to come.
    rest: bool,
    /// The source failed: nothing more comes of it.
    failed: bool,
    dialect: Option<Dialect>,
    last_s: Option<f64>,
}

impl<R: Read> Iterator for Lines<R> {
    type Item = Result<Row, InputError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.failed {
            match self.read_line() {
                Ok(true) => {}
                Ok(false) => return None,
                Err(why) => {
                    self.failed = true;
                    return Some(Err(InputError::from_io(&why)));
                }
            }
            if let Some(row) = self.row().transpose() {
                return Some(row);
            }
        }
        None
    }
}

impl<R: Read> Lines<R> {
    fn of(source: R) -> Self {
        Self {
            source: BufReader::new(source),
            line: Vec::new(),
            number: 0,
            rest: false,
            failed: false,
            dialect: None,
            last_s: None,
        }
    }

    /// Reads the next line, or as much of it as one may have; false at the end.
    fn read_line(&mut self) -> io::Result<bool> {
        if self.rest {
            self.source.skip_until(b'\n')?;
        }
        self.line.clear();
        let mut line = self.source.by_ref().take(LONGEST);
        let read = line.read_until(b'\n', &mut self.line)? as u64;
        self.rest = read == LONGEST && !self.line.ends_with(b"\n");
        self.number += 1;
        if self.number == 1 && self.line.starts_with("\u{feff}".as_bytes()) {
            self.line.drain(.."\u{feff}".len());
        }
        Ok(read > 0)
    }

    /// What the line tells; nothing if it is a comment, empty, or the header, or if the spindle
    /// stands.
    fn row(&mut self) -> Result<Option<Row>, InputError> {
        let text = String::from_utf8_lossy(&self.line);
        let line = text.trim();
        if line.starts_with('#') || (line.is_empty() && !self.rest) {
            return Ok(None);
        }
        let at = format!("line {}", self.number);
        if self.rest {
            return Err(InputError::new(
                Problem::NotThisFormat,
                at,
                format!("{LONGEST} bytes, and no end of it"),
                "write one speed a line",
            ));
        }
        if matches!(text, Cow::Owned(_)) {
            return Err(not_text(at));
        }
        let is_first = self.dialect.is_none();
        let dialect = *self.dialect.get_or_insert_with(|| Dialect::of(line));
        let fields = dialect.fields(line);
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
        // The sign is the direction.
        let (t_s, rpm) = (number(0)?, number(1)?.abs());
        if rpm > RPM.1 {
            return Err(InputError::new(
                Problem::Range,
                at,
                format!("{rpm} 1/min is no speed: 300000 at most"),
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
        Ok((rpm >= RPM.0).then_some((t_s, rpm)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

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
    fn a_stop_a_direction_and_blanks_are_understood() {
        let mut speeds = read("0 0\n0.5  -4500\n2 0\n2.5\t4600\n").expect("speeds");
        assert_eq!(speeds.first(), 4500.0);
        let mut due = |t| speeds.due(t, |why| panic!("{why}"));
        assert_eq!(due(0.4), None);
        assert_eq!(due(2.2), Some(4500.0));
        assert_eq!(due(9.0), Some(4600.0));
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, line, word) in [
            ("0,4500\n2,4600\n1,4700\n", "line 3", "goes back"),
            ("0,4500\n1,NaN\n", "line 2", "not a number"),
            ("0,4500\n1\n", "line 2", "no value"),
            ("0,0\n1,0\n", "file", "no speed"),
            ("0,4500\n1,300001\n", "line 2", "no speed"),
            ("0,4500\n2,0\n1,4500\n", "line 3", "goes back"),
            ("time,rpm\n", "file", "no speed"),
        ] {
            let why = read(text).map(|_| ()).expect_err(text).to_string();
            assert!(why.contains(line) && why.contains(word), "{text}: {why}");
        }
    }

    #[test]
    fn a_pipe_is_followed_and_its_odd_lines_are_passed_over() {
        let pipe = &b"0,4500\nx,y,z\n0.5,nan\n0.4,5000\n"[..];
        let mut speeds = Speeds::follow(Path::new("pipe"), pipe).expect("speeds");
        let (mut told, mut odd) = (Vec::new(), 0);
        for _ in 0..1000 {
            told.extend(speeds.due(0.45, |_| odd += 1));
            if odd == 2 && told.last() == Some(&5000.0) {
                return;
            }
            thread::sleep(std::time::Duration::from_millis(5));
        }
        panic!("{told:?}, {odd} odd lines");
    }

    #[test]
    fn a_line_without_end_is_refused_whole_and_a_comment_may_be_long() {
        let long = "7".repeat(3000);
        let text = format!("\u{feff}0,4500\n# {long},1\n{long},4600\n1,4700\n");
        let lines: Vec<_> = Lines::of(text.as_bytes()).collect();
        let [Ok((0.0, 4500.0)), Err(why), Ok((1.0, 4700.0))] = &lines[..] else {
            panic!("{lines:?}");
        };
        assert!(why.to_string().contains("line 3: 1024 bytes"), "{why}");
    }

    #[test]
    fn a_pipe_without_end_is_read_only_so_far_ahead() {
        struct Endless(Arc<AtomicUsize>);
        impl Read for Endless {
            fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
                to.copy_from_slice(&b"0,4500\n".repeat(to.len())[..to.len()]);
                self.0.fetch_add(to.len(), Ordering::Relaxed);
                Ok(to.len())
            }
        }
        let read = Arc::default();
        let endless = Endless(Arc::clone(&read));
        let speeds = Speeds::follow(Path::new("pipe"), endless).expect("speeds");
        thread::sleep(std::time::Duration::from_millis(50));
        assert!(read.load(Ordering::Relaxed) < 64 * AHEAD);
        drop(speeds);
    }
}
