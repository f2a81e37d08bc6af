//! What must become of a command.

use super::run::Ended;
use std::path::Path;

/// What must become of a command.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Exit codes that are right.
    pub codes: Vec<i32>,
    /// It says something.
    pub speaks: bool,
    /// It goes on until `quit` is typed.
    pub typed: bool,
    /// Files and folders that are there afterwards.
    pub outputs: Vec<String>,
}

impl Wanted {
    /// An end with 0.
    pub fn well() -> Self {
        Self {
            codes: vec![0],
            ..Self::default()
        }
    }

    /// Compares.
    ///
    /// # Errors
    /// What differs.
    pub fn judge(&self, ended: &Ended, folder: &Path) -> Result<(), String> {
        if !ended.code.is_some_and(|code| self.codes.contains(&code)) {
            let code = ended.code.map_or("a signal".to_owned(), |c| c.to_string());
            return Err(format!(
                "ended with {code}, not {:?}: {}",
                self.codes, ended.last_words
            ));
        }
        if self.speaks && !ended.spoke {
            return Err("said nothing".to_owned());
        }
        for output in &self.outputs {
            let there = folder.join(output).metadata();
            if !there.is_ok_and(|meta| meta.is_dir() || meta.len() > 0) {
                return Err(format!("did not write {output}"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_judged() {
        let ended = |code, spoke| Ended {
            code,
            spoke,
            last_words: "why".to_owned(),
        };
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let want = Wanted {
            codes: vec![1],
            speaks: true,
            outputs: vec!["Cargo.toml".to_owned(), "src/".to_owned()],
            ..Wanted::default()
        };
        assert_eq!(want.judge(&ended(Some(1), true), here), Ok(()));
        assert!(want.judge(&ended(Some(0), true), here).is_err());
        assert!(want.judge(&ended(None, true), here).is_err());
        assert!(want.judge(&ended(Some(1), false), here).is_err());
        let missing = Wanted {
            outputs: vec!["no-such-file".to_owned()],
            ..want
        };
        assert!(missing.judge(&ended(Some(1), true), here).is_err());
    }
}
