//! `cargo xtask gallery [DIR] [--against REV|DIR]`: every picture of every command on one page,
//! each with the command that draws it and how to read it, and beside it the same of before.

mod before;
pub mod list;
pub mod made;
mod page;
pub mod pictures;

use std::path::{Path, PathBuf};

use crate::{Failure, Result, Workspace, process, screens};
pub use made::{Failing, Gallery};

const USAGE: &str = "cargo xtask gallery [DIR] [--against REV|DIR] [--only NAME]";

/// Has all pictures drawn by `rarma` as it is, into `folder`.
///
/// # Errors
/// The program does not build, a command fails, or the folder cannot be written.
pub fn make(workspace: &Workspace, folder: &Path, only: Option<&str>) -> Result<Gallery> {
    let rarma = process::rarma(workspace)?;
    let work = workspace.target_dir().join("gallery-work");
    let mut gallery = Gallery::make(&rarma, &chosen(only)?, (folder, &work), Failing::Fails)?;
    if only.is_none() {
        let screens = screens::folder(workspace);
        gallery.take_in(&screens, "cargo xtask screens", "The live screen")?;
        let page = workspace.target_dir().join("web-pictures");
        let line = "cargo verify --only \"browser page\"";
        gallery.take_in(&page, line, "The page in a browser")?;
    }
    page::write(&gallery, None)?;
    Ok(gallery)
}

/// Where it goes unless told otherwise.
pub fn usual_folder(workspace: &Workspace) -> PathBuf {
    workspace.target_dir().join("gallery")
}

fn chosen(only: Option<&str>) -> Result<Vec<list::Shown>> {
    let all = list::SHOWN.iter().copied();
    let Some(only) = only else {
        return Ok(all.collect());
    };
    let chosen: Vec<list::Shown> = all.filter(|shown| shown.name == only).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = list::SHOWN.iter().map(|shown| shown.name).collect();
        return Err(Failure::usage(format!("`{only}` is not in the gallery"))
            .advise(format!("one of {}", names.join(", "))));
    }
    Ok(chosen)
}

/// A parsed command line.
#[derive(Debug, Default, PartialEq, Eq)]
struct Request {
    folder: Option<PathBuf>,
    against: Option<String>,
    only: Option<String>,
}

impl Request {
    fn parse(arguments: &[String]) -> Result<Self> {
        let usage = |what: String| Failure::usage(what).advise(USAGE);
        let mut request = Self::default();
        let mut words = arguments.iter();
        while let Some(word) = words.next() {
            let slot = match word.as_str() {
                "--against" => &mut request.against,
                "--only" => &mut request.only,
                option if option.starts_with('-') => {
                    return Err(usage(format!("`gallery` knows no `{option}`")));
                }
                folder if request.folder.is_none() => {
                    request.folder = Some(folder.into());
                    continue;
                }
                second => return Err(usage(format!("a second folder `{second}`"))),
            };
            let value = words
                .next()
                .ok_or_else(|| usage(format!("`{word}` needs a value")))?;
            *slot = Some(value.clone());
        }
        Ok(request)
    }
}

/// The command `gallery`.
///
/// # Errors
/// Wrong arguments, or as [`make`].
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let request = Request::parse(arguments)?;
    let folder = request.folder.unwrap_or_else(|| usual_folder(workspace));
    let only = request.only.as_deref();
    // What is compared with is looked up first: it is the quicker to be wrong.
    let mut older = match &request.against {
        Some(name) => Some(before::find(workspace, name, &chosen(only)?, &folder)?),
        None => None,
    };
    if let (Some(older), Some(only)) = (&mut older, only) {
        older.chapters.retain(|chapter| chapter.name == only);
    }
    let gallery = make(workspace, &folder, only)?;
    let compared = older.as_ref().zip(request.against.as_deref());
    let told = page::write(&gallery, compared)?;
    println!(
        "{} pictures of {} commands: {}",
        gallery.count(),
        gallery.chapters.len(),
        folder.join("index.html").display()
    );
    if let Some(told) = told {
        println!("{told}");
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Request> {
        let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
        Request::parse(&words)
    }

    #[test]
    fn arguments() {
        let want = Request {
            folder: Some("out".into()),
            against: Some("HEAD~1".to_owned()),
            only: None,
        };
        assert_eq!(parse("out --against HEAD~1"), Ok(want));
        assert_eq!(parse(""), Ok(Request::default()));
        for wrong in ["a b", "--against", "--frobnicate"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
        assert!(chosen(Some("none")).is_err());
        assert_eq!(chosen(Some("lobes")).map(|one| one.len()), Ok(1));
    }
}
