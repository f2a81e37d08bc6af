//! Parts of the documentation that tests write and compare.

use std::env;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use xtask::page::{self, Part};

/// Tests of one file run at once; each writes its part of a page after the other.
static WRITING: Mutex<()> = Mutex::new(());

/// Holds the part of a page (a path below the workspace, e.g. `docs/bench.md`) between
/// `<!-- NAME:begin -->` and `<!-- NAME:end -->` to be this text; with `RARMA_WRITE_TABLE`
/// set the text is written there instead.
///
/// # Panics
/// The part has other lines: they are named.
pub fn holds(path: &str, name: &'static str, text: &str) {
    compared(path, name, text, |a, b| a == b);
}

/// The same for figures of an image: its numbers to within [`page::TOLERANCE`].
///
/// # Panics
/// The part has other lines: they are named.
pub fn nearly_holds(path: &str, name: &'static str, text: &str) {
    compared(path, name, text, page::is_near);
}

fn compared(path: &str, name: &'static str, text: &str, is_same: fn(&str, &str) -> bool) {
    let _writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path);
    let document = page::read(&file).unwrap_or_else(|why| panic!("{why}"));
    let part = Part(name);
    if env::var_os("RARMA_WRITE_TABLE").is_some() {
        let new = part.written_into(&document, text);
        let new = new.unwrap_or_else(|why| panic!("{path}: {why}"));
        page::write(&file, &new).unwrap_or_else(|why| panic!("{why}"));
        return;
    }
    let (_, old, _) = part
        .split(&document)
        .unwrap_or_else(|why| panic!("{path}: {why}"));
    let told = differences(old, text, is_same);
    assert!(
        told.is_empty(),
        "{path} says what is no longer so (RARMA_WRITE_TABLE=1 writes it):\n{told}"
    );
}

/// The lines that only one of two texts has.
fn differences(page: &str, measured: &str, is_same: fn(&str, &str) -> bool) -> String {
    let lacks = |text: &str, line: &&str| !text.lines().any(|other| is_same(other, line));
    let gone = page.lines().filter(|line| lacks(measured, line));
    let new = measured.lines().filter(|line| lacks(page, line));
    gone.map(|line| format!("page:     {line}\n"))
        .chain(new.map(|line| format!("measured: {line}\n")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_no_longer_so_is_named_with_the_new_one() {
        let exact = |a: &str, b: &str| a == b;
        let told = differences("| a | 1 |\n| b | 2 |\n", "| a | 1 |\n| b | 3 |\n", exact);
        assert_eq!(told, "page:     | b | 2 |\nmeasured: | b | 3 |\n");
        assert_eq!(differences("same\n", "same\n", exact), "");
    }

    #[test]
    #[should_panic(expected = "<!-- no-such-part:begin -->")]
    fn a_page_without_the_part_is_refused() {
        holds("docs/bench.md", "no-such-part", "");
    }
}
