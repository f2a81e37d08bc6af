//! Pages laid out as mdBook wants them: each checked, with its links into the source tree turned
//! to pages that show it, and SUMMARY.md.
//!
//! Every page keeps its path, so that links between pages stay as they are; only README.md is
//! called index.md, which a web server shows for a folder.

use crate::contents::{self, INDEX, Part};
use crate::gallery::Gallery;
use crate::links;
use crate::markdown::{Link, Page};
use crate::source::Source;
use anyhow::{Context, Result, bail};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Where pages are looked for that no part lists.
const PAGES: &str = "docs";
/// What a page of a folder is called on a code host, and in the book.
const README: &str = "README.md";
const FRONT: &str = "index.md";

/// The book before it is rendered.
#[derive(Debug)]
pub struct Stage {
    parts: Vec<Part>,
    /// Pages by their paths in the workspace.
    pages: BTreeMap<PathBuf, Page>,
    gallery: Option<Gallery>,
    root: PathBuf,
    /// Files and folders that pages link to.
    pub sources: BTreeSet<Source>,
    /// Pictures that pages show.
    pictures: BTreeSet<PathBuf>,
    /// Links that were followed.
    pub links: usize,
}

/// What a link goes to.
enum Goal {
    /// A page of the book.
    Page,
    /// A picture of a page.
    Picture(PathBuf),
    /// Something in the source tree.
    Source(Source),
}

impl Stage {
    /// Reads all pages and follows their links.
    ///
    /// # Errors
    /// A page is not listed or cannot be read, or links are dead: all of them.
    pub fn new(root: &Path, gallery: Option<&Path>) -> Result<Self> {
        let index = read(root, Path::new(INDEX))?;
        let parts = contents::read(&index)?;
        let mut pages = BTreeMap::from([(PathBuf::from(INDEX), index)]);
        for path in parts.iter().flat_map(|part| &part.pages) {
            pages.insert(path.clone(), read(root, path)?);
        }
        let mut stage = Self {
            parts,
            pages,
            gallery: gallery.map(Gallery::read).transpose()?,
            root: root.to_path_buf(),
            sources: BTreeSet::new(),
            pictures: BTreeSet::new(),
            links: 0,
        };
        let mut wrong = stage.unlisted()?;
        wrong.extend(stage.follow());
        if !wrong.is_empty() {
            bail!(
                "{} wrong places in the pages:\n  {}",
                wrong.len(),
                wrong.join("\n  ")
            );
        }
        Ok(stage)
    }

    /// How many chapters there are.
    pub fn chapters(&self) -> usize {
        self.pages.len() + usize::from(self.gallery.is_some())
    }

    /// Pages under docs that no part lists.
    fn unlisted(&self) -> Result<Vec<String>> {
        let mut out = Vec::new();
        let mut folders = vec![PathBuf::from(PAGES)];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(self.root.join(&folder))? {
                let path = folder.join(entry?.file_name());
                if self.root.join(&path).is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|e| e == "md")
                    && !self.pages.contains_key(&path)
                {
                    out.push(format!("{}: not listed in {INDEX}", path.display()));
                }
            }
        }
        out.sort();
        Ok(out)
    }

    /// Follows every link; the dead ones, with their places.
    fn follow(&mut self) -> Vec<String> {
        let mut wrong = Vec::new();
        for (path, page) in &self.pages {
            for link in page.links.iter().filter(|link| !links::outside(&link.to)) {
                self.links += 1;
                match self.goal(path, link) {
                    Ok(Goal::Source(source)) => drop(self.sources.insert(source)),
                    Ok(Goal::Picture(picture)) => drop(self.pictures.insert(picture)),
                    Ok(Goal::Page) => {}
                    Err(why) => {
                        wrong.push(format!(
                            "{}:{}: {}: {why}",
                            path.display(),
                            link.line,
                            link.to
                        ));
                    }
                }
            }
        }
        wrong
    }

    /// What a link goes to, or why it is dead.
    fn goal(&self, from: &Path, link: &Link) -> Result<Goal> {
        if link.place.is_none() {
            bail!("write it as [words](where)");
        }
        let folder = from.parent().unwrap_or(Path::new(""));
        let (mut path, anchor) =
            links::inside(folder, &link.to).context("it leaves the workspace")?;
        if link.to.starts_with('#') {
            path = from.to_path_buf();
        }
        let (goal, anchors) = if let Some(page) = self.pages.get(&path) {
            (Goal::Page, page.anchors.clone())
        } else if path.extension().is_some_and(|e| e == "md") {
            match self.root.join(&path).exists() {
                true => bail!("that page is not listed in {INDEX}"),
                false => bail!("there is no such page"),
            }
        } else if path.extension().is_some_and(|e| e == "svg") && self.root.join(&path).is_file() {
            (Goal::Picture(path), BTreeSet::new())
        } else {
            let source =
                Source::at(&self.root, &path).context("there is no such file or folder")?;
            let anchors = source.anchors(&self.root)?;
            (Goal::Source(source), anchors)
        };
        match anchor {
            Some(anchor) if !anchors.contains(&anchor) => bail!("it has no `#{anchor}`"),
            _ => Ok(goal),
        }
    }

    /// A page's text with the places that its links have in the book.
    fn staged(&self, path: &Path, page: &Page) -> String {
        page.relinked(|link| {
            if links::outside(&link.to) {
                return None;
            }
            let (to, anchor) = match link.to.split_once('#') {
                Some((to, anchor)) => (to, format!("#{anchor}")),
                None => (link.to.as_str(), String::new()),
            };
            match self.goal(path, link).ok()? {
                Goal::Page => {
                    let folder = to.strip_suffix(README)?;
                    Some(format!("{folder}{FRONT}{anchor}"))
                }
                Goal::Source(source) => {
                    let to = to.trim_end_matches('/');
                    Some(format!("{to}{}{anchor}", source.suffix()))
                }
                Goal::Picture(_) => None,
            }
        })
    }

    /// The chapters for mdBook, by their paths in the book.
    fn summary(&self) -> String {
        let mut out = "# Summary\n".to_owned();
        let line = |out: &mut String, path: &Path| {
            let title = &self.pages[path].title;
            // A String takes everything.
            let _ = writeln!(out, "- [{title}]({})", in_the_book(path).display());
        };
        // A reader who opens the book sees the first page; the list of all comes after it.
        let mut index = Some(Path::new(INDEX));
        for part in &self.parts {
            let _ = write!(out, "\n# {}\n\n", part.title);
            for page in &part.pages {
                line(&mut out, page);
                if let Some(index) = index.take() {
                    line(&mut out, index);
                }
            }
            if let (Some(gallery), true) = (&self.gallery, part == &self.parts[0]) {
                let _ = writeln!(out, "- [{}]({})", gallery.title(), Gallery::PAGE);
            }
        }
        out
    }

    /// Writes everything into a folder, which is made anew.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        if folder.exists() {
            fs::remove_dir_all(folder)
                .with_context(|| format!("cannot empty {}", folder.display()))?;
        }
        let src = folder.join("src");
        for (path, page) in &self.pages {
            put(
                &src.join(in_the_book(path)),
                self.staged(path, page).as_bytes(),
            )?;
        }
        for picture in &self.pictures {
            put(&src.join(picture), &fs::read(self.root.join(picture))?)?;
        }
        if let Some(gallery) = &self.gallery {
            gallery.write(&src)?;
        }
        put(&src.join("SUMMARY.md"), self.summary().as_bytes())
    }
}

fn read(root: &Path, path: &Path) -> Result<Page> {
    let text = fs::read_to_string(root.join(path))
        .with_context(|| format!("cannot read {}", path.display()))?;
    let page = Page::new(&text);
    if page.title.is_empty() {
        bail!(
            "{} has no first heading, which its chapter is called by",
            path.display()
        );
    }
    Ok(page)
}

/// Writes a file, its folder, too.
///
/// # Errors
/// Names the file that cannot be written.
pub fn put(path: &Path, bytes: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}

fn in_the_book(path: &Path) -> PathBuf {
    match path.ends_with(README) {
        true => path.with_file_name(FRONT),
        false => path.to_path_buf(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::tree;

    const SOUND: [(&str, &str); 5] = [
        (
            "docs/README.md",
            "# The book\n## Use\n[five](../README.md) [a](a.md#one-two)\n## Why\n[d](why/1.md)\n",
        ),
        (
            "README.md",
            "# Five\n[all](docs/README.md#use) [code](src/lib.rs) ![p](docs/p.svg)\n",
        ),
        (
            "docs/a.md",
            "# A\n## One two\n[up](../README.md#five), [here](#one-two), [dir](../src/)\n",
        ),
        (
            "docs/why/1.md",
            "# 1\n[line](../../src/lib.rs#L2) [far](https://a.b)\n",
        ),
        ("src/lib.rs", "//! One.\nfn two() {}\n"),
    ];

    fn with(more: &[(&str, &str)]) -> tempfile::TempDir {
        let mut files = SOUND.to_vec();
        files.push(("docs/p.svg", "<svg/>"));
        files.extend_from_slice(more);
        tree(&files)
    }

    #[test]
    fn links_go_to_the_same_things_in_the_book() {
        let root = with(&[]);
        let stage = Stage::new(root.path(), None).expect("sound pages");
        assert_eq!((stage.chapters(), stage.links), (4, 10));
        let out = tempfile::tempdir().expect("a folder");
        stage.write(out.path()).expect("written");
        let read = |path: &str| {
            fs::read_to_string(out.path().join("src").join(path)).expect("a staged page")
        };
        assert_eq!(
            read("index.md"),
            "# Five\n[all](docs/index.md#use) [code](src/lib.rs.html) ![p](docs/p.svg)\n"
        );
        assert_eq!(
            read("docs/a.md"),
            "# A\n## One two\n[up](../index.md#five), [here](#one-two), [dir](../src/index.html)\n"
        );
        assert!(read("docs/why/1.md").contains("[line](../../src/lib.rs.html#L2)"));
        assert_eq!(
            read("SUMMARY.md"),
            "# Summary\n\n# Use\n\n- [Five](index.md)\n- [The book](docs/index.md)\n- [A](docs/a.md)\n\n# Why\n\n- [1](docs/why/1.md)\n"
        );
        assert_eq!(read("docs/p.svg"), "<svg/>");
    }

    #[test]
    fn a_dead_link_is_told_with_its_place() {
        for (page, want) in [
            (
                "[x](none.md)",
                "docs/a.md:2: none.md: there is no such page",
            ),
            ("[x](../src/none.rs)", "no such file or folder"),
            ("[x](why/1.md#two)", "it has no `#two`"),
            ("[x](../src/lib.rs#L3)", "it has no `#L3`"),
            ("[x](#nowhere)", "it has no `#nowhere`"),
            ("[x](../../x.md)", "it leaves the workspace"),
            ("[x](../OTHER.md)", "that page is not listed"),
            ("![x](q.svg)", "no such file or folder"),
            ("[x][y]\n\n[y]: a.md", "write it as"),
        ] {
            let text = format!("# A\n{page}\n## One two\n");
            let root = with(&[("docs/a.md", &text), ("OTHER.md", "# O\n")]);
            let why = Stage::new(root.path(), None).expect_err(page).to_string();
            assert!(why.contains(want), "{page}: {why}");
        }
    }

    #[test]
    fn a_page_that_is_not_listed_is_told() {
        let root = with(&[("docs/why/2.md", "# 2\n")]);
        let why = Stage::new(root.path(), None)
            .expect_err("one is missing")
            .to_string();
        assert!(
            why.contains("docs/why/2.md: not listed in docs/README.md"),
            "{why}"
        );
    }
}
