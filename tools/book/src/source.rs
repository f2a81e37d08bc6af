//! A file or a folder of the source tree as a page of its own, for a link to go to.

use anyhow::{Context, Result};
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// A page of source.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// The text of a file, its lines numbered.
    File(PathBuf),
    /// The names in a folder.
    Folder(PathBuf),
}

/// The page in its own dress: readable in light and dark, nothing to load.
const STYLE: &str = "\
:root { color-scheme: light dark; }
body { margin: 0 auto; padding: 1rem; max-width: 70rem; font: 16px/1.5 sans-serif; }
pre { overflow-x: auto; font: 13px/1.45 monospace; }
pre a { display: inline-block; width: 3.5em; padding-right: 1em; text-align: right; color: gray; text-decoration: none; user-select: none; }
pre a:target { background: gold; color: black; }
";

impl Source {
    /// What is at a path of the workspace.
    pub fn at(root: &Path, path: &Path) -> Option<Self> {
        let there = root.join(path);
        if there.is_file() {
            Some(Self::File(path.to_path_buf()))
        } else {
            there.is_dir().then(|| Self::Folder(path.to_path_buf()))
        }
    }

    /// What is put after a link to it.
    pub fn suffix(&self) -> &'static str {
        match self {
            Self::File(_) => ".html",
            Self::Folder(_) => "/index.html",
        }
    }

    /// What a link to it may name after `#`: the lines of a file.
    ///
    /// # Errors
    /// The file cannot be read as text.
    pub fn anchors(&self, root: &Path) -> Result<BTreeSet<String>> {
        Ok(match self {
            Self::File(path) => {
                let count = text(root, path)?.lines().count();
                (1..=count).map(|k| format!("L{k}")).collect()
            }
            Self::Folder(_) => BTreeSet::new(),
        })
    }

    fn path(&self) -> &Path {
        match self {
            Self::File(path) | Self::Folder(path) => path,
        }
    }

    /// Writes it where links to it go.
    ///
    /// # Errors
    /// It cannot be read or written; which.
    pub fn write(&self, root: &Path, out: &Path) -> Result<()> {
        let body = match self {
            Self::File(path) => numbered(&text(root, path)?),
            Self::Folder(path) => names(&root.join(path))?,
        };
        let path = self.path().display().to_string();
        let page = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{path}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<p><a href=\"{up}index.html\">rarma</a></p>\n<h1>{path}</h1>\n{body}</body>\n</html>\n",
            path = escape(&path),
            up = "../".repeat(self.depth()),
        );
        let to = out.join(format!("{path}{}", self.suffix()));
        if let Some(folder) = to.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(&to, page).with_context(|| format!("cannot write {}", to.display()))
    }

    fn depth(&self) -> usize {
        let names = self.path().components().count();
        match self {
            Self::File(_) => names - 1,
            Self::Folder(_) => names,
        }
    }
}

fn text(root: &Path, path: &Path) -> Result<String> {
    fs::read_to_string(root.join(path)).with_context(|| format!("cannot read {}", path.display()))
}

fn numbered(text: &str) -> String {
    let mut out = "<pre>".to_owned();
    for (number, line) in (1..).zip(text.lines()) {
        // A String takes everything.
        let _ = writeln!(
            out,
            "<a id=\"L{number}\" href=\"#L{number}\">{number}</a>{}",
            escape(line)
        );
    }
    out + "</pre>\n"
}

fn names(folder: &Path) -> Result<String> {
    let mut names = Vec::new();
    for entry in
        fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?
    {
        let entry = entry?;
        let slash = if entry.path().is_dir() { "/" } else { "" };
        names.push(format!("{}{slash}", entry.file_name().to_string_lossy()));
    }
    names.retain(|name| !name.starts_with('.'));
    names.sort();
    Ok(format!("<pre>{}</pre>\n", escape(&names.join("\n"))))
}

/// Makes text safe between tags and in quoted attributes.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::tree;

    #[test]
    fn a_file_has_numbered_lines_and_a_folder_its_names() {
        let root = tree(&[("a/b.rs", "let x = 1 < 2;\n\n"), ("a/c/d.rs", "")]);
        let out = tempfile::tempdir().expect("a folder");
        let file = Source::at(root.path(), Path::new("a/b.rs")).expect("a file");
        let folder = Source::at(root.path(), Path::new("a")).expect("a folder");
        assert_eq!(Source::at(root.path(), Path::new("a/none")), None);
        let anchors = file.anchors(root.path()).expect("text");
        assert!(anchors.iter().eq(["L1", "L2"]), "{anchors:?}");
        for source in [&file, &folder] {
            source.write(root.path(), out.path()).expect("written");
        }
        let read = |path: &str| fs::read_to_string(out.path().join(path)).expect("a page");
        let page = read("a/b.rs.html");
        assert!(
            page.contains("<a id=\"L1\" href=\"#L1\">1</a>let x = 1 &lt; 2;"),
            "{page}"
        );
        assert!(page.contains("href=\"../index.html\""), "{page}");
        assert!(read("a/index.html").contains("<pre>b.rs\nc/</pre>"));
    }
}
