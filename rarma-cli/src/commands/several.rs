//! `rarma monitor A B … --report DIR`: recordings one after another with the same options, a
//! page each, and one that compares them.

use super::monitor::{self, Manner};
use crate::args::MonitorArgs;
use crate::failure::Failure;
use crate::report::comparison::{Compared, comparison};
use crate::report::{Provenance, sheet_into};
use std::path::Path;

/// Letters of a file's name that its folder keeps.
const LETTERS: usize = 60;

pub(super) fn main(args: &MonitorArgs) -> Result<u8, Failure> {
    let Some(dir) = &args.report else {
        return Err(Failure::Usage(
            "several recordings: --report DIR is needed, for the page that compares them"
                .to_owned(),
        ));
    };
    if args.json {
        return Err(Failure::Usage(
            "--json: is for one recording at a time (the lines of several would not be told apart)"
                .to_owned(),
        ));
    }
    let files = [&args.input.input].into_iter().chain(&args.more);
    if files.clone().any(|file| file == Path::new("-")) {
        return Err(Failure::Usage(
            "-: standard input is no recording to compare with others; give files".to_owned(),
        ));
    }
    let mut all = Vec::new();
    let (mut code, mut failed) = (0, None);
    for (k, file) in files.enumerate() {
        let folder = folder(k + 1, file);
        let mut one = args.clone();
        one.input.input.clone_from(file);
        one.more = Vec::new();
        one.report = Some(dir.join(&folder));
        say!("{}", file.display());
        let heard = match monitor::heard(&one, Manner::default()) {
            Ok(finished) => {
                code = code.max(finished.code);
                Ok(finished.summary)
            }
            // What is wrong with the options is wrong with them for every file.
            Err(why @ (Failure::Usage(_) | Failure::Closed)) => return Err(why),
            Err(why) => {
                say!("  {why}");
                let words = why.to_string();
                failed.get_or_insert(why);
                Err(words)
            }
        };
        all.push(Compared {
            name: file.display().to_string(),
            page: format!("{folder}/index.html"),
            heard,
        });
    }
    let provenance = Provenance {
        notes: args.notes.clone(),
        ..Provenance::of_this_run()
    };
    let page = comparison(&all, &provenance, env!("CARGO_PKG_VERSION"));
    let path = sheet_into(dir, page)?;
    eprintln!("comparison: {}", path.display());
    match failed {
        Some(why) => Err(why),
        None => Ok(code),
    }
}

/// Where the page of the `k`-th recording goes: a name that every system takes.
fn folder(k: usize, file: &Path) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let stem: String = stem.chars().take(LETTERS).map(plain).collect();
    format!("{k}-{stem}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_told_apart_and_stay_inside() {
        assert_eq!(folder(1, Path::new("a/cut 1.wav")), "1-cut-1");
        assert_eq!(folder(2, Path::new("b/cut 1.wav")), "2-cut-1");
        assert_eq!(folder(3, Path::new("../..")), "3-");
        assert_eq!(folder(4, Path::new("ä/é.wav")), "4--");
    }
}
