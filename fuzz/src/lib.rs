//! Fuzz targets: every parser of `rarma` and of the box, each a function of bytes.
//!
//! A case that panics, takes more than [`MEMORY_BYTES`], takes longer than [`CASE_S`], or is
//! refused in other words than one line that names file, place, reason and remedy, is a
//! defect. Where what was read can be written, or the other way round, both are compared.
//!
//! The engine is libFuzzer (`src/main.rs`, feature `libfuzzer`; `cargo xtask fuzz`); the cases
//! in `corpus/` run in every `cargo test` (`tests/corpus.rs`).

pub mod check;
pub mod scratch;
mod targets;

use std::path::{Path, PathBuf};

/// No case may have more in hand at once, bytes.
pub const MEMORY_BYTES: usize = 1 << 30;
/// No case may take longer, s.
pub const CASE_S: u64 = 20;

/// One parser, or several of one kind.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Name, and folder of its corpus.
    pub name: &'static str,
    /// What is read, for people.
    pub reads: &'static str,
    /// Runs one case.
    ///
    /// # Panics
    /// The case shows a defect.
    pub run: fn(&[u8]),
    /// Words that its inputs are made of.
    pub words: fn() -> Vec<String>,
}

/// All of them.
pub static TARGETS: [Target; 21] = targets::ALL;

/// The target of a name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|t| t.name == name)
}

impl Target {
    /// The folder of its committed cases.
    pub fn corpus(&self) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("corpus")
            .join(self.name)
    }

    /// Its words as libFuzzer reads them: one a line, in quotes.
    pub fn dictionary(&self) -> String {
        let mut words = (self.words)();
        words.sort();
        words.dedup();
        let quoted = |word: &String| {
            let bytes = word.bytes().map(|b| match b {
                b' '..=b'~' if b != b'"' && b != b'\\' => char::from(b).to_string(),
                _ => format!("\\x{b:02X}"),
            });
            format!("\"{}\"\n", bytes.collect::<String>())
        };
        let short = words
            .iter()
            .filter(|word| !word.is_empty() && word.len() <= 40);
        short.map(quoted).collect()
    }
}
