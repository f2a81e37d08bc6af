//! What libFuzzer's log says of a run.

use std::path::PathBuf;

/// The figures, and why it ended if it ended early.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Log {
    /// Seed of the run.
    pub seed: Option<u32>,
    /// Cases run.
    pub cases: u64,
    /// How long, s; none if it ended at a find.
    pub seconds: Option<u64>,
    /// Edges that the cases reach with which the run began.
    pub edges_of_corpus: u64,
    /// Edges reached in the end.
    pub edges: u64,
    /// Largest size of the program, MB.
    pub peak_mb: u64,
    /// What broke, in the words of the panic or of libFuzzer.
    pub why: Option<String>,
    /// The case that broke it.
    pub case: Option<PathBuf>,
}

impl Log {
    /// Reads a log.
    pub fn read(text: &str) -> Self {
        let mut log = Self::default();
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if let Some(seed) = line.strip_prefix("INFO: Seed: ") {
                log.seed = seed.trim().parse().ok();
            } else if line.starts_with('#')
                && let Some(edges) = after(line, " cov: ")
            {
                if line.contains("INITED") {
                    log.edges_of_corpus = edges;
                }
                log.edges = log.edges.max(edges);
            } else if line.starts_with("Done ") {
                log.seconds = after(line, " runs in ");
            } else if let Some(count) = after(line, "stat::number_of_executed_units:") {
                log.cases = count;
            } else if let Some(mb) = after(line, "stat::peak_rss_mb:") {
                log.peak_mb = mb;
            } else if line.starts_with("thread ") && line.contains(" panicked at ") {
                // The place; the words stand in the next line.
                let place = line.split(" panicked at ").nth(1).unwrap_or_default();
                let words = lines.next().unwrap_or_default();
                log.why.get_or_insert(format!("{place} {words}"));
            } else if let Some((_, what)) = line.split_once("ERROR: libFuzzer: ") {
                log.why.get_or_insert(what.to_owned());
            } else if line.starts_with("memory allocation of ") {
                log.why.get_or_insert(line.to_owned());
            } else if let Some((_, path)) = line.split_once("Test unit written to ") {
                log.case = Some(PathBuf::from(path));
            }
        }
        log
    }

    /// Cases in a minute, as fast as the run went; none if it ended at a find.
    pub fn cases_a_minute(&self) -> Option<u64> {
        Some(60 * self.cases / self.seconds?.max(1))
    }
}

/// The number after a word.
fn after(line: &str, word: &str) -> Option<u64> {
    let rest = line.split_once(word)?.1.trim_start();
    let digits = rest
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(rest.len());
    rest[..digits].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "\
INFO: Seed: 42
#3\tINITED cov: 310 ft: 400 corp: 2/80b exec/s: 0 rss: 30Mb
#100\tNEW    cov: 320 ft: 420 corp: 3/90b lim: 80 exec/s: 0 rss: 31Mb L: 9/40 MS: 1 ChangeByte-
#7000\tDONE   cov: 331 ft: 500 corp: 9/200b lim: 80 exec/s: 700 rss: 33Mb
Done 7000 runs in 10 second(s)
stat::number_of_executed_units: 7000
stat::peak_rss_mb:              33
";

    #[test]
    fn a_run_that_found_nothing() {
        let log = Log::read(GOOD);
        assert_eq!(
            (log.seed, log.cases, log.seconds),
            (Some(42), 7000, Some(10))
        );
        assert_eq!((log.edges_of_corpus, log.edges), (310, 331));
        assert_eq!((log.peak_mb, log.cases_a_minute()), (33, Some(42_000)));
        assert_eq!((log.why, log.case), (None, None));
    }

    #[test]
    fn a_run_that_found_something_says_what() {
        let panicked = "\
INFO: Seed: 9
thread '<unnamed>' (12) panicked at fuzz/src/check.rs:30:5:
names no remedy: a: b
==12== ERROR: libFuzzer: deadly signal
artifact_prefix='t/'; Test unit written to t/crash-ab
";
        let log = Log::read(panicked);
        assert_eq!(log.cases_a_minute(), None);
        let why = log.why.expect("a reason");
        assert_eq!(why, "fuzz/src/check.rs:30:5: names no remedy: a: b");
        assert_eq!(log.case, Some("t/crash-ab".into()));
        let slow = Log::read("==3== ERROR: libFuzzer: timeout after 21 seconds\n");
        assert_eq!(slow.why.as_deref(), Some("timeout after 21 seconds"));
    }
}
