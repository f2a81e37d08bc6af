//! What the checks came to, and the table that says so.

use std::fmt;
use std::time::Instant;

/// How a check ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// All well; the text is a remark, or empty.
    Passed(String),
    /// All well as far as it ran: why not all of it could.
    Partly(String),
    /// Something is wrong: what.
    Failed(String),
    /// It could not run here: why.
    Skipped(String),
}

impl Outcome {
    /// All well, nothing to remark.
    pub fn passed() -> Self {
        Self::Passed(String::new())
    }

    /// What [`Display`](fmt::Display) said.
    fn of_told(told: &str) -> Option<Self> {
        let (word, text) = told.split_once(": ").unwrap_or((told, ""));
        let all = [Self::Passed, Self::Partly, Self::Failed, Self::Skipped];
        all.into_iter()
            .map(|outcome| outcome(text.to_owned()))
            .find(|outcome| outcome.told().0 == word)
    }

    fn remark(&self) -> &str {
        self.told().1.lines().next().unwrap_or("")
    }

    /// The word for it, and what is said besides.
    fn told(&self) -> (&'static str, &str) {
        match self {
            Self::Passed(text) => ("passed", text),
            Self::Partly(text) => ("PARTLY", text),
            Self::Failed(text) => ("FAILED", text),
            Self::Skipped(text) => ("SKIPPED", text),
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, text) = self.told();
        if text.is_empty() {
            write!(out, "{word}")
        } else {
            write!(out, "{word}: {text}")
        }
    }
}

/// One line of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The check's name.
    pub name: &'static str,
    /// How it ended.
    pub outcome: Outcome,
    /// How long it took.
    pub seconds: f32,
}

impl Entry {
    /// The line that says how the check ended.
    pub fn line(&self) -> String {
        let Self {
            name,
            outcome,
            seconds,
        } = self;
        format!("<== {name} ({seconds:.0} s): {outcome}")
    }

    /// Of the first line of [`Self::line`], where it is of the check called `name`.
    pub fn of_line(name: &'static str, line: &str) -> Option<Self> {
        let rest = line.strip_prefix("<== ")?.strip_prefix(name)?;
        let (seconds, told) = rest.strip_prefix(" (")?.split_once(" s): ")?;
        Some(Self {
            name,
            outcome: Outcome::of_told(told)?,
            seconds: seconds.parse().ok()?,
        })
    }
}

/// All checks that ran.
#[derive(Debug, Clone)]
pub struct Summary {
    skips_fail: bool,
    begun: Instant,
    entries: Vec<Entry>,
}

impl Summary {
    /// Nothing ran yet; `skips_fail` counts as failed what did not run, or not all of it.
    pub fn new(skips_fail: bool) -> Self {
        Self {
            skips_fail,
            begun: Instant::now(),
            entries: Vec::new(),
        }
    }

    /// Adds a check.
    pub fn add(&mut self, entry: Entry) {
        self.entries.push(entry);
    }

    /// Checks that passed.
    pub fn passed(&self) -> usize {
        self.count(|outcome| matches!(outcome, Outcome::Passed(_)))
    }

    /// Checks that were skipped, whole or in part.
    pub fn skipped(&self) -> usize {
        self.count(|outcome| matches!(outcome, Outcome::Skipped(_) | Outcome::Partly(_)))
    }

    /// Checks that failed, those included whose skipping is a failure.
    pub fn failed(&self) -> usize {
        let skipped = if self.skips_fail { self.skipped() } else { 0 };
        skipped + self.count(|outcome| matches!(outcome, Outcome::Failed(_)))
    }

    fn count(&self, is: impl Fn(&Outcome) -> bool) -> usize {
        self.entries
            .iter()
            .filter(|entry| is(&entry.outcome))
            .count()
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self
            .entries
            .iter()
            .map(|entry| entry.name.len())
            .max()
            .unwrap_or(0);
        for entry in &self.entries {
            let (word, _) = entry.outcome.told();
            let (name, seconds, remark) = (entry.name, entry.seconds, entry.outcome.remark());
            let line = format!("{name:width$}  {word:<7}  {seconds:>6.1} s  {remark}");
            writeln!(out, "{}", line.trim_end())?;
        }
        let total = self.begun.elapsed().as_secs_f32();
        writeln!(out, "{:width$}  {:<7}  {total:>6.1} s", "all", "")?;
        if self.skipped() > 0 {
            let verdict = if self.skips_fail {
                "counted as failed"
            } else {
                "NOT VERIFIED HERE, reasons above"
            };
            writeln!(
                out,
                "\n{} skipped, whole or in part: {verdict}",
                self.skipped()
            )?;
        }
        writeln!(out, "\n{} passed, {} failed", self.passed(), self.failed())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(skips_fail: bool) -> Summary {
        let mut summary = Summary::new(skips_fail);
        let outcomes = [
            Outcome::passed(),
            Outcome::Failed("two tests\nlong story".into()),
            Outcome::Skipped("no compiler for it".into()),
            Outcome::Partly("without the chip".into()),
        ];
        for outcome in outcomes {
            summary.add(Entry {
                name: "a check",
                outcome,
                seconds: 1.0,
            });
        }
        summary
    }

    #[test]
    fn a_skip_is_loud_but_no_failure() {
        let text = summary(false).to_string();
        assert!(
            text.contains("SKIPPED") && text.contains("no compiler for it"),
            "{text}"
        );
        assert!(text.ends_with("\n1 passed, 1 failed\n"), "{text}");
        assert!(
            text.contains("PARTLY") && text.contains("without the chip"),
            "{text}"
        );
        assert!(
            text.contains("2 skipped, whole or in part: NOT VERIFIED"),
            "{text}"
        );
        assert!(
            !text.contains("long story"),
            "the table keeps to one line each: {text}"
        );
    }

    #[test]
    fn the_line_of_a_check_is_read_again() {
        for entry in summary(false).entries {
            let line = entry.line();
            let first = line.lines().next().expect("one line");
            let read = Entry::of_line("a check", first).expect("a line of it");
            assert_eq!(read.outcome.told().0, entry.outcome.told().0);
            assert_eq!(
                (read.outcome.remark(), read.seconds),
                (entry.outcome.remark(), 1.0)
            );
            assert_eq!(Entry::of_line("a", first), None);
        }
        assert_eq!(Entry::of_line("a check", "<== a check (1 s): odd"), None);
    }

    #[test]
    fn a_skip_fails_where_nothing_may_be_skipped() {
        assert!(
            summary(true)
                .to_string()
                .ends_with("\n1 passed, 3 failed\n")
        );
    }
}
