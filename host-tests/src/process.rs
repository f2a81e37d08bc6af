//! The real program, run as a user runs it.

use serde_json::Value;
use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

/// The program under test; see [`rarma!`](crate::rarma).
#[derive(Debug, Clone, Copy)]
pub struct Rarma {
    program: &'static str,
}

/// The real `rarma`. To be used in `tests/` and `benches/`: only there cargo tells
/// where the program is.
#[macro_export]
macro_rules! rarma {
    () => {
        $crate::process::Rarma::at(env!("CARGO_BIN_EXE_rarma-under-test"))
    };
}

/// What a run left behind.
#[derive(Debug, Clone)]
pub struct Ended {
    /// Exit code; none if a signal ended it.
    pub code: Option<i32>,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Rarma {
    /// The program at this path.
    #[must_use]
    pub fn at(program: &'static str) -> Self {
        Self { program }
    }

    /// Where it is.
    pub(crate) fn program(self) -> &'static str {
        self.program
    }

    /// Runs it to the end.
    ///
    /// # Panics
    /// It cannot be started, or prints what is not UTF-8.
    pub fn run(self, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Ended {
        let output = Command::new(self.program)
            .args(arguments)
            .output()
            .unwrap_or_else(|why| panic!("{}: {why}", self.program));
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8 on the terminal");
        Ended {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// `rarma COMMAND FILE OPTIONS…`, the options split at blanks.
    pub fn on(self, command: &str, file: &Path, options: &str) -> Ended {
        let options = options.split_whitespace().map(OsStr::new);
        self.run(
            [OsStr::new(command), file.as_os_str()]
                .into_iter()
                .chain(options),
        )
    }
}

impl Ended {
    /// Standard output as one JSON value a line.
    ///
    /// # Panics
    /// A line is not JSON, or there is none.
    #[must_use]
    pub fn json_lines(&self) -> Vec<Value> {
        let parse =
            |line| serde_json::from_str(line).unwrap_or_else(|why| panic!("{why} in line: {line}"));
        let lines: Vec<Value> = self.stdout.lines().map(parse).collect();
        assert!(!lines.is_empty(), "nothing on standard output; {self:?}");
        lines
    }

    /// Standard output as one JSON value, on however many lines.
    ///
    /// # Panics
    /// It is none, or the program did not end well.
    #[must_use]
    pub fn json(&self) -> Value {
        assert_eq!(self.code, Some(0), "{self:?}");
        serde_json::from_str(&self.stdout).unwrap_or_else(|why| panic!("{why}: {self:?}"))
    }

    /// Telemetry lines and the summary of `monitor --json`.
    ///
    /// # Panics
    /// The output is not of that form.
    #[must_use]
    pub fn monitored(&self) -> (Vec<Value>, Value) {
        let mut lines = self.json_lines();
        let last = lines.pop().expect("at least one line");
        let summary = last.get("summary").cloned();
        (lines, summary.expect("the last line is the summary"))
    }
}
