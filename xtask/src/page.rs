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
    fn a_page_without_markers_is_refused_by_the_marker() {
        assert!(PART.split("a").is_err_and(|why| why.contains("some:begin")));
        let half = "<!-- some:begin -->\n";
        assert!(PART.split(half).is_err_and(|why| why.contains("some:end")));
    }
}
