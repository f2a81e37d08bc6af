//! What is in the book, in reading order: what docs/README.md lists, nothing else says it.

use crate::links;
use crate::markdown::Page;
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};

/// The page that lists all others.
pub const INDEX: &str = "docs/README.md";

/// A heading of the index with the pages that are listed under it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The heading.
    pub title: String,
    /// Pages by their paths from the root, in order.
    pub pages: Vec<PathBuf>,
}

/// Reads the index. A page belongs where it is named first.
///
/// # Errors
/// The index lists no page.
pub fn read(index: &Page) -> Result<Vec<Part>> {
    let folder = Path::new(INDEX).parent().unwrap_or(Path::new(""));
    let mut parts: Vec<Part> = Vec::new();
    let mut seen = vec![PathBuf::from(INDEX)];
    for (heading, links) in index.parts() {
        let mut pages = Vec::new();
        for link in links {
            let Some((path, _)) = links::inside(folder, &link.to) else {
                continue;
            };
            if path.extension().is_some_and(|e| e == "md") && !seen.contains(&path) {
                seen.push(path.clone());
                pages.push(path);
            }
        }
        if !pages.is_empty() {
            parts.push(Part {
                title: heading,
                pages,
            });
        }
    }
    if parts.is_empty() {
        bail!("{INDEX} lists no page under a heading");
    }
    Ok(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_headings_with_pages_and_a_page_is_in_one_of_them() {
        let index = Page::new(
            "# Book\n[first](a.md)\n## Use\n| [a](a.md) | [up](../README.md) |\n|---|---|\n| [far](https://a.b/c.md) | [x](b/c.md#d) |\n\n## Words\nnone\n## Why\n1. [a](a.md#e)\n2. [d](d.md)\n",
        );
        let part = |title: &str, pages: &[&str]| Part {
            title: title.to_owned(),
            pages: pages.iter().map(PathBuf::from).collect(),
        };
        assert_eq!(
            read(&index).expect("a sound index"),
            [
                part("Use", &["docs/a.md", "README.md", "docs/b/c.md"]),
                part("Why", &["docs/d.md"]),
            ]
        );
        assert!(read(&Page::new("# Book\n")).is_err());
    }
}
