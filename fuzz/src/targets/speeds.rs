//! Speeds of a spindle as a control tells them: a file that is read at once, and a pipe.

use crate::{Target, check, scratch};
use rarma_recordings::input::{InputError, Speeds};
use std::io::{self, Read};
use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::time::Duration;

pub(super) const SPEEDS: Target = Target {
    name: "speeds",
    reads: "speeds of a spindle over time, file and pipe",
    run: |bytes| {
        let path = scratch::file("case.csv", bytes);
        let (rows, refused) = piped(&path, bytes);
        match Speeds::open(&path, false) {
            Ok(speeds) => {
                assert_eq!(refused, None, "refused of a pipe only");
                assert_eq!(all(speeds), rows);
            }
            Err(why) => {
                check::refusal(&path, &why);
                assert_eq!(refused, Some(why.to_string()));
            }
        }
        if !rows.is_empty() {
            again(&rows);
        }
    },
    words: || {
        [
            "time,rpm\n",
            "time;rpm\n",
            "time\trpm\n",
            "# ",
            "0,4500\n",
            "1,5;4950\n",
            "\r\n",
            "\u{feff}",
            "nan",
            "inf",
            "-0",
            "-1",
            "1e-308",
            "1e308",
            "0.06",
            "300000",
        ]
        .map(str::to_owned)
        .to_vec()
    },
};

/// Time, s, and speed, 1/min.
type Row = (f64, f64);

/// Bytes as a pipe brings them: each piece as long as its first byte says. Those who hold the
/// other end of `_read` learn when the reader is done.
struct Pieces {
    left: io::Cursor<Vec<u8>>,
    _read: Sender<()>,
}

impl Read for Pieces {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let at = self.left.position() as usize;
        let next = self.left.get_ref().get(at).copied().unwrap_or_default();
        let length = to.len().min(1 + usize::from(next % 16));
        self.left.read(&mut to[..length])
    }
}

/// What a pipe of these bytes gives on, and the first refusal of it.
fn piped(path: &Path, bytes: &[u8]) -> (Vec<Row>, Option<String>) {
    let (_read, done) = mpsc::channel();
    let left = io::Cursor::new(bytes.to_vec());
    let mut refused = None;
    let mut odd = |why: InputError| {
        check::refusal(path, &why);
        refused.get_or_insert(why.to_string());
    };
    let mut rows = Vec::new();
    match Speeds::follow(path, Pieces { left, _read }) {
        Ok(mut speeds) => {
            let first = speeds.first();
            loop {
                // What was read before the end is there once the end is.
                let ended = done.recv_timeout(Duration::from_millis(1));
                rows.extend(std::iter::from_fn(|| {
                    speeds.next_until(f64::INFINITY, &mut odd)
                }));
                if ended != Err(RecvTimeoutError::Timeout) {
                    break;
                }
            }
            assert_eq!(rows.first().map(|row| row.1), Some(first));
        }
        Err(why) => odd(why),
    }
    sound(&rows);
    (rows, refused)
}

/// What is promised of every speed that is given on.
fn sound(rows: &[Row]) {
    for (t_s, rpm) in rows {
        assert!(t_s.is_finite(), "{t_s} s");
        assert!((0.06..=300_000.0).contains(rpm), "{rpm} 1/min");
    }
    assert!(rows.is_sorted_by_key(|row| row.0), "time goes back");
}

/// A file is refused, or all of its lines are good.
fn none_odd(why: InputError) {
    panic!("a file that was read has an odd line: {why}");
}

/// All that a file tells.
fn all(mut speeds: Speeds) -> Vec<Row> {
    let mut rows = Vec::new();
    while let Some(row) = speeds.next_until(f64::INFINITY, none_odd) {
        rows.push(row);
    }
    rows
}

/// Written out, they are the same speeds, and each counts from its time on.
fn again(rows: &[Row]) {
    let lines = rows.iter().map(|(t_s, rpm)| format!("{t_s:e},{rpm:e}\n"));
    let path = scratch::file("again.csv", lines.collect::<String>().as_bytes());
    let open = || Speeds::open(&path, false).expect("what was read is sound");
    assert_eq!(all(open()), rows);
    let mut speeds = open();
    for together in rows.chunk_by(|a, b| a.0 == b.0) {
        let (t_s, rpm) = together[together.len() - 1];
        assert_eq!(
            speeds.due(t_s.next_down(), none_odd),
            None,
            "before {t_s} s"
        );
        assert_eq!(speeds.due(t_s, none_odd), Some(rpm), "at {t_s} s");
    }
    assert_eq!(speeds.due(f64::INFINITY, none_odd), None);
}
