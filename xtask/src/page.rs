//! Parts of a page that commands write and compare: what stands between two marker lines.

use std::fs;
use std::path::Path;

use crate::{Failure, Result};

/// The part between `<!-- NAME:begin -->` and `<!-- NAME:end -->`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part(pub &'static str);

impl Part {
    /// The document before, between and after the markers.
    ///
    /// # Errors
    /// Names the marker that is missing.
    pub fn split(self, document: &str) -> std::result::Result<(&str, &str, &str), String> {
        let marker = |end| format!("<!-- {}:{end} -->\n", self.0);
        let missing = |marker: &str| format!("it has no line `{}`", marker.trim());
        let (begin, end) = (marker("begin"), marker("end"));
        let (before, rest) = document.split_once(&begin).ok_or_else(|| missing(&begin))?;
        let (between, after) = rest.split_once(&end).ok_or_else(|| missing(&end))?;
        Ok((before, between, after))
    }

    /// `document` with this text between the markers.
    ///
    /// # Errors
    /// Names the marker that is missing.
    pub fn written_into(self, document: &str, text: &str) -> std::result::Result<String, String> {
        let (before, _, after) = self.split(document)?;
        let name = self.0;
        Ok(format!(
            "{before}<!-- {name}:begin -->\n{text}<!-- {name}:end -->\n{after}"
        ))
    }
}

/// How far two figures of one image may be apart and count as equal: where an image is built decides
/// where its constants lie, and that a few cycles.
pub const TOLERANCE: f64 = 0.02;

/// Whether two lines say the same, their numbers to within [`TOLERANCE`] or one of their last digit.
pub fn is_near(is: &str, was: &str) -> bool {
    let (is, was) = (pieces(is), pieces(was));
    is.len() == was.len() && is.iter().zip(&was).all(|(is, was)| are_near(is, was))
}

/// A line cut into numbers and what stands between them.
fn pieces(line: &str) -> Vec<&str> {
    line.split_inclusive(|c: char| !is_of_number(c))
        .flat_map(|piece| {
            let end = piece.trim_end_matches(|c| !is_of_number(c)).len();
            let (number, other) = piece.split_at(end);
            [number, other]
        })
        .filter(|piece| !piece.is_empty())
        .collect()
}

fn is_of_number(c: char) -> bool {
    c.is_ascii_digit() || c == '.'
}

fn are_near(is: &str, was: &str) -> bool {
    let (Ok(a), Ok(b)) = (is.parse::<f64>(), was.parse::<f64>()) else {
        return is == was;
    };
    let decimals = |text: &str| text.split_once('.').map_or(0, |(_, after)| after.len());
    if decimals(is) != decimals(was) {
        return false;
    }
    let last = 0.1f64.powi(i32::try_from(decimals(was)).unwrap_or(0));
    (a - b).abs() <= (TOLERANCE * b.abs()).max(1.001 * last)
}

/// Reads a page.
///
/// # Errors
/// Names the page that cannot be read.
pub fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path)
        .map_err(|why| Failure::new(format!("cannot read {}", path.display())).because(why))
}

/// Writes a page beside the old one, then takes its place: it is never half there.
///
/// # Errors
/// Names the page that cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    let beside = path.with_extension("new");
    fs::write(&beside, text)
        .and_then(|()| fs::rename(&beside, path))
        .map_err(|why| Failure::new(format!("cannot write {}", path.display())).because(why))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PART: Part = Part("some");

    #[test]
    fn replaces_what_stands_between_the_markers_and_no_more() {
        let page = "a\n<!-- some:begin -->\nold\n<!-- some:end -->\nb\n";
        let new = PART.written_into(page, "new\n").expect("has markers");
        assert_eq!(new, "a\n<!-- some:begin -->\nnew\n<!-- some:end -->\nb\n");
        assert_eq!(PART.split(&new), Ok(("a\n", "new\n", "b\n")));
    }

    #[test]
    fn figures_are_near_within_two_percent_or_one_of_the_last_digit() {
        for (is, was) in [
            ("| noise | 1583 to 1888 |", "| noise | 1583 to 1887 |"),
            ("385.0", "390.0"),
            ("31 to 38 %", "32 to 38 %"),
            ("2.41 ms", "2.41 ms"),
            ("(4,3)", "(4,3)"),
        ] {
            assert!(is_near(is, was), "{is}: {was}");
        }
        for (is, was) in [
            ("385.0", "395.0"),
            ("| noise | 3 |", "| steps | 3 |"),
            ("1 to 2 %", "1 to 4 %"),
            ("0.5", "0.50"),
            ("12 ms", "12 s"),
            ("1 2", "1"),
        ] {
            assert!(!is_near(is, was), "{is}: {was}");
        }
    }

    #[test]
    fn a_page_without_markers_is_refused_by_the_marker() {
        assert!(PART.split("a").is_err_and(|why| why.contains("some:begin")));
        let half = "<!-- some:begin -->\n";
        assert!(PART.split(half).is_err_and(|why| why.contains("some:end")));
    }
}
