//! The gallery as one page, alone or beside an older one.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use super::made::{Chapter, Gallery, Listed};
use crate::{Failure, Result};

/// An older gallery's pictures in the folder of the newer one.
const BEFORE: &str = "before";

const STYLE: &str = "\
:root { color-scheme: light dark; --line: #8886; }
body { margin: 0 auto; padding: 1rem; max-width: 70rem; font: 16px/1.5 sans-serif; }
body.two { max-width: 110rem; }
nav a { display: inline-block; margin-right: 1.2em; }
h2 { margin: 2.5rem 0 0.5rem; }
pre { overflow-x: auto; padding: 0.5rem 0.8rem; border: 1px solid var(--line); }
figure { margin: 1rem 0 2rem; }
figcaption { max-width: 60rem; font-size: 0.9rem; }
.scroll { overflow-x: auto; }
.scroll img { width: 100%; min-width: 48rem; height: auto; display: block; }
.two .beside { display: grid; grid-template-columns: 1fr 1fr; gap: 0.5rem; }
.two .scroll img { min-width: 30rem; }
.two p { margin: 0.2rem 0; font-size: 0.85rem; }
@media (max-width: 60rem) { .two .beside { grid-template-columns: 1fr; } }
";

/// What became of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    New,
    Gone,
    Same,
    Changed,
}

impl Change {
    fn word(self) -> &'static str {
        match self {
            Self::New => "new",
            Self::Gone => "gone",
            Self::Same => "unchanged",
            Self::Changed => "changed",
        }
    }
}

/// Writes `index.html`, and says how many pictures changed where there are older ones.
///
/// # Errors
/// A picture cannot be copied, or the page cannot be written.
pub fn write(gallery: &Gallery, before: Option<(&Gallery, &str)>) -> Result<Option<String>> {
    let index = gallery.folder.join("index.html");
    let (html, told) = match before {
        None => (alone(gallery), None),
        Some((older, name)) => {
            take(older, &gallery.folder.join(BEFORE))?;
            let (html, told) = beside(gallery, older, name);
            (html, Some(told))
        }
    };
    crate::page::write(&index, &html)?;
    Ok(told)
}

fn take(older: &Gallery, into: &Path) -> Result<()> {
    let cannot = |path: &Path, why: std::io::Error| {
        Failure::new(format!("cannot copy a picture to {}", path.display())).because(why)
    };
    if into.exists() {
        fs::remove_dir_all(into).map_err(|why| cannot(into, why))?;
    }
    for picture in older.chapters.iter().flat_map(|chapter| &chapter.pictures) {
        let to = into.join(&picture.file);
        let folder = to.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        fs::create_dir_all(&folder).map_err(|why| cannot(&folder, why))?;
        fs::copy(older.folder.join(&picture.file), &to).map_err(|why| cannot(&to, why))?;
    }
    Ok(())
}

fn alone(gallery: &Gallery) -> String {
    let mut html = head(gallery, "", "Every picture that a command makes.");
    for chapter in &gallery.chapters {
        opened(&mut html, chapter);
        for picture in &chapter.pictures {
            put(
                &mut html,
                &format!(
                    "<figure>{}<figcaption>{}</figcaption></figure>\n",
                    image("", picture),
                    escape(&picture.caption)
                ),
            );
        }
    }
    html + "</body>\n</html>\n"
}

/// Both pages in one, and how many pictures changed.
fn beside(gallery: &Gallery, older: &Gallery, name: &str) -> (String, String) {
    let mut body = String::new();
    let mut counts = [0; 4];
    let chapters = gallery.chapters.iter().chain(
        older
            .chapters
            .iter()
            .filter(|old| gallery.chapters.iter().all(|new| new.name != old.name)),
    );
    for chapter in chapters {
        opened(&mut body, chapter);
        let of = |all: &Gallery| -> Vec<Listed> {
            let found = all.chapters.iter().find(|c| c.name == chapter.name);
            found.map(|c| c.pictures.clone()).unwrap_or_default()
        };
        let (new, old) = (of(gallery), of(older));
        let gone = old.iter().filter(|o| new.iter().all(|n| n.file != o.file));
        for picture in new.iter().chain(gone) {
            let was = old.iter().find(|o| o.file == picture.file);
            let is = new.iter().find(|n| n.file == picture.file);
            let change = match (was, is) {
                (None, _) => Change::New,
                (_, None) => Change::Gone,
                _ if alike(gallery, older, &picture.file) => Change::Same,
                _ => Change::Changed,
            };
            counts[change as usize] += 1;
            let side = |folder: &str, picture: Option<&Listed>, word: &str| match picture {
                Some(picture) => format!("<div><p>{word}</p>{}</div>", image(folder, picture)),
                None => format!("<div><p>{word}: not there</p></div>"),
            };
            put(
                &mut body,
                &format!(
                    "<figure><p><strong>{}</strong></p><div class=\"beside\">{}{}</div><figcaption>{}</figcaption></figure>\n",
                    change.word(),
                    side("before/", was, "before"),
                    side("", is, "after"),
                    escape(&picture.caption)
                ),
            );
        }
    }
    let told: Vec<String> = [Change::Changed, Change::New, Change::Gone, Change::Same]
        .iter()
        .map(|change| format!("{} {}", counts[*change as usize], change.word()))
        .collect();
    let told = told.join(", ");
    let words = format!("Before: {name}. After: as it is now. {told}.");
    let html = head(gallery, "two", &words) + &body + "</body>\n</html>\n";
    (html, told)
}

fn alike(gallery: &Gallery, older: &Gallery, file: &str) -> bool {
    let read = |all: &Gallery| fs::read(all.folder.join(file)).ok();
    read(gallery) == read(older)
}

fn head(gallery: &Gallery, class: &str, words: &str) -> String {
    let mut html = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>rarma: gallery</title>\n<style>\n{STYLE}</style>\n</head>\n<body class=\"{class}\">\n<h1>Gallery</h1>\n<p>{}</p>\n<nav>\n",
        escape(words)
    );
    for chapter in &gallery.chapters {
        put(
            &mut html,
            &format!("<a href=\"#{0}\">{0}</a>\n", chapter.name),
        );
    }
    html + "</nav>\n"
}

fn opened(html: &mut String, chapter: &Chapter) {
    put(
        html,
        &format!(
            "<h2 id=\"{}\">{}</h2>\n<pre>{}</pre>\n",
            chapter.name,
            escape(&chapter.title),
            escape(&chapter.lines.join("\n"))
        ),
    );
}

fn image(folder: &str, picture: &Listed) -> String {
    format!(
        "<div class=\"scroll\"><img src=\"{folder}{}\" alt=\"{}\" loading=\"lazy\"></div>",
        picture.file,
        escape(&picture.words)
    )
}

fn put(html: &mut String, text: &str) {
    // A String takes everything.
    let _ = html.write_str(text);
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gallery(name: &str, files: &[(&str, &str)]) -> Gallery {
        let folder = std::env::temp_dir().join(format!("rarma-page-{name}-{}", std::process::id()));
        fs::create_dir_all(folder.join("pictures")).expect("a folder");
        let mut pictures = Vec::new();
        for (file, svg) in files {
            fs::write(folder.join(file), svg).expect("a file");
            pictures.push(Listed {
                file: (*file).to_owned(),
                title: "t".to_owned(),
                words: "a < b".to_owned(),
                caption: "c".to_owned(),
            });
        }
        let chapters = vec![Chapter {
            name: "monitor".to_owned(),
            title: "T".to_owned(),
            lines: vec!["rarma monitor cut.wav".to_owned()],
            pictures,
        }];
        Gallery { folder, chapters }
    }

    #[test]
    fn two_galleries_side_by_side_tell_what_changed() {
        let old = gallery(
            "old",
            &[
                ("pictures/a.svg", "1"),
                ("pictures/b.svg", "2"),
                ("pictures/gone.svg", "3"),
            ],
        );
        let new = gallery(
            "new",
            &[
                ("pictures/a.svg", "1"),
                ("pictures/b.svg", "4"),
                ("pictures/new.svg", "5"),
            ],
        );
        let told = write(&new, Some((&old, "v1"))).expect("written");
        assert_eq!(
            told.as_deref(),
            Some("1 changed, 1 new, 1 gone, 1 unchanged")
        );
        let html = fs::read_to_string(new.folder.join("index.html")).expect("a page");
        for word in [
            "src=\"before/pictures/gone.svg\"",
            "src=\"pictures/new.svg\"",
            "Before: v1.",
            "alt=\"a &lt; b\"",
        ] {
            assert!(html.contains(word), "{word}: {html}");
        }
        assert_eq!(
            fs::read(new.folder.join("before/pictures/b.svg")).expect("a copy"),
            b"2"
        );
        assert_eq!(write(&old, None).expect("written"), None);
        for gallery in [old, new] {
            fs::remove_dir_all(&gallery.folder).expect("removed");
        }
    }
}
