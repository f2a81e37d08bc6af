//! The pictures of `cargo xtask gallery` as a chapter.

use crate::source::escape;
use crate::stage::put;
use anyhow::{Context, Result};
use serde::Deserialize;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The list that the command leaves beside its pictures.
const LIST: &str = "gallery.json";

/// What is in the list.
#[derive(Debug, Clone, Deserialize)]
struct List {
    commands: Vec<Command>,
}

/// A command and what it drew.
#[derive(Debug, Clone, Deserialize)]
struct Command {
    title: String,
    lines: Vec<String>,
    pictures: Vec<Picture>,
}

#[derive(Debug, Clone, Deserialize)]
struct Picture {
    file: String,
    words: String,
    caption: String,
}

/// A folder of pictures.
#[derive(Debug)]
pub struct Gallery {
    folder: PathBuf,
    list: List,
}

impl Gallery {
    /// The chapter's page.
    pub const PAGE: &str = "gallery.md";

    /// Reads the list of a folder.
    ///
    /// # Errors
    /// There is none, or it is not one.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(LIST);
        let text = fs::read_to_string(&path).with_context(|| {
            format!(
                "no list of pictures {} (cargo xtask gallery)",
                path.display()
            )
        })?;
        let list = serde_json::from_str(&text)
            .with_context(|| format!("{} is no list of pictures", path.display()))?;
        Ok(Self {
            folder: folder.to_path_buf(),
            list,
        })
    }

    /// What the chapter is called.
    pub fn title(&self) -> &'static str {
        "Gallery"
    }

    /// Writes the chapter and its pictures.
    ///
    /// # Errors
    /// A picture is missing, or cannot be written.
    pub fn write(&self, src: &Path) -> Result<()> {
        let pictures = self.list.commands.iter().flat_map(|c| &c.pictures);
        for picture in pictures {
            let from = self.folder.join(&picture.file);
            let bytes = fs::read(&from)
                .with_context(|| format!("cannot read the picture {}", from.display()))?;
            put(&src.join("gallery").join(&picture.file), &bytes)?;
        }
        put(&src.join(Self::PAGE), self.page().as_bytes())
    }

    fn page(&self) -> String {
        let mut out = format!(
            "# {}\n\nEvery picture that a command makes. `cargo xtask gallery` runs them.\n",
            self.title()
        );
        for command in &self.list.commands {
            // A String takes everything.
            let _ = write!(
                out,
                "\n## {}\n\n```sh\n{}\n```\n",
                command.title,
                command.lines.join("\n")
            );
            for picture in &command.pictures {
                let _ = write!(
                    out,
                    "\n<p><a href=\"gallery/{file}\"><img src=\"gallery/{file}\" alt=\"{alt}\" loading=\"lazy\"></a></p>\n<p>{caption}</p>\n",
                    file = picture.file,
                    alt = escape(&picture.words),
                    caption = escape(&picture.caption),
                );
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::tree;

    #[test]
    fn every_picture_stands_under_its_command() {
        let folder = tree(&[
            (
                LIST,
                r#"{"commands":[{"title":"T","lines":["rarma x"],"pictures":[{"file":"p/a.svg","words":"w \"q\"","caption":"c < d"}]}]}"#,
            ),
            ("p/a.svg", "<svg/>"),
        ]);
        let src = tempfile::tempdir().expect("a folder");
        let gallery = Gallery::read(folder.path()).expect("a list");
        gallery.write(src.path()).expect("written");
        let page = fs::read_to_string(src.path().join(Gallery::PAGE)).expect("a page");
        assert!(page.contains("## T\n\n```sh\nrarma x\n```"), "{page}");
        assert!(
            page.contains("src=\"gallery/p/a.svg\" alt=\"w &quot;q&quot;\""),
            "{page}"
        );
        assert!(page.contains("<p>c &lt; d</p>"), "{page}");
        assert!(src.path().join("gallery/p/a.svg").is_file());
        assert!(Gallery::read(src.path()).is_err());
    }
}
