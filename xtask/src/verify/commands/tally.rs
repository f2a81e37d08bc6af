//! How many commands were found, and what became of them.

use crate::verify::summary::Outcome;
use std::collections::BTreeMap;

/// What became of the commands.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Commands in the pages.
    pub found: usize,
    /// Run here, as documented.
    pub ran: usize,
    /// Left to `cargo verify --long`.
    pub long: usize,
    stages: BTreeMap<String, usize>,
    not: Vec<String>,
    failures: Vec<String>,
    slowest: Option<(f64, String)>,
}

impl Tally {
    /// Some were run; `what` names them.
    pub fn ran(&mut self, count: usize, what: String, seconds: f64) {
        println!("{seconds:7.1} s  {what}");
        self.ran += count;
        if self
            .slowest
            .as_ref()
            .is_none_or(|(most, _)| seconds > *most)
        {
            self.slowest = Some((seconds, what));
        }
    }

    /// Another stage runs it.
    pub fn by(&mut self, stage: &str) {
        *self.stages.entry(stage.to_owned()).or_default() += 1;
    }

    /// Nobody runs it.
    pub fn not(&mut self, what: &str, why: &str) {
        self.not.push(format!("{what}: {why}"));
    }

    /// It failed, or is not known.
    pub fn fail(&mut self, what: String) {
        println!("  FAILED   {what}");
        self.failures.push(what);
    }

    /// Says it all, and how it ended.
    pub fn outcome(self) -> Outcome {
        for what in &self.not {
            println!("  not run  {what}");
        }
        for (stage, count) in &self.stages {
            println!("{count:9}  by the stage `{stage}`");
        }
        if let Some((seconds, what)) = &self.slowest {
            println!("the longest: {seconds:.1} s, {what}");
        }
        let elsewhere: usize = self.stages.values().sum();
        let counts = format!(
            "{} found: {} run, {elsewhere} by other stages, {} with --long, {} not",
            self.found,
            self.ran,
            self.long,
            self.not.len()
        );
        if self.failures.is_empty() {
            return Outcome::Passed(counts);
        }
        let mut text = format!("{counts}; {} FAILED", self.failures.len());
        for failure in &self.failures {
            text = format!("{text}\n  {failure}");
        }
        Outcome::Failed(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_failure_is_enough() {
        let mut tally = Tally {
            found: 3,
            ..Tally::default()
        };
        tally.ran(1, "a".to_owned(), 1.0);
        tally.by("host tests");
        let Outcome::Passed(text) = tally.clone().outcome() else {
            panic!("nothing failed")
        };
        assert_eq!(
            text,
            "3 found: 1 run, 1 by other stages, 0 with --long, 0 not"
        );
        tally.fail("README.md:1: b: why".to_owned());
        let Outcome::Failed(text) = tally.outcome() else {
            panic!("one failed")
        };
        assert!(text.contains("1 FAILED\n  README.md:1: b: why"), "{text}");
    }
}
