//! Running the commands, and the folder with what they drew: pictures, and a list of them for
//! pages and for later comparison.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use super::list::Shown;
use super::pictures;
use crate::inputs::Maker;
use crate::side_by_side::side_by_side;
use crate::{Failure, Result, process};

/// The list beside the pictures.
pub const LIST: &str = "gallery.json";
/// The folder of the pictures in that of the gallery.
const PICTURES: &str = "pictures";
/// Exit codes of a command that did its work: 1 says that there was chatter.
const DONE: [i32; 2] = [0, 1];

/// A picture in the list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Its file, from the folder of the gallery.
    pub file: String,
    /// Its title.
    pub title: String,
    /// What is to be seen, in words.
    pub words: String,
    /// How to read it.
    pub caption: String,
}

/// A command and what it drew.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chapter {
    /// Its name in [`super::list::SHOWN`].
    pub name: String,
    /// What it is about.
    pub title: String,
    /// The command, after those that make what it reads.
    pub lines: Vec<String>,
    /// Its pictures, in order.
    pub pictures: Vec<Listed>,
}

impl Chapter {
    fn without_pictures(shown: &Shown) -> Self {
        Self {
            name: shown.name.to_owned(),
            title: shown.title.to_owned(),
            lines: shown.lines().map(str::to_owned).collect(),
            pictures: Vec::new(),
        }
    }
}

/// What becomes of a command that fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failing {
    /// The whole gallery fails.
    Fails,
    /// It has no pictures: an older program did not know it yet.
    PassedOver,
}

/// A folder of pictures.
#[derive(Debug, Clone)]
pub struct Gallery {
    /// Where it is.
    pub folder: PathBuf,
    /// What is in it.
    pub chapters: Vec<Chapter>,
}

impl Gallery {
    /// Has `rarma` draw what is shown, working in `work`.
    ///
    /// # Errors
    /// The folder holds something else, or a command fails and that is not to be passed over.
    pub fn make(
        rarma: &Path,
        shown: &[Shown],
        (folder, work): (&Path, &Path),
        failing: Failing,
    ) -> Result<Self> {
        empty(folder)?;
        let mut gallery = Self {
            folder: folder.to_path_buf(),
            chapters: Vec::new(),
        };
        // One that is not finished is a gallery as well, and may be made anew.
        gallery.keep()?;
        let drawn = side_by_side(shown, |one| {
            eprintln!("gallery: {}", one.line);
            gallery.draw(rarma, one, &work.join(one.name))
        });
        for (one, drawn) in shown.iter().zip(drawn) {
            match drawn {
                Ok(chapter) => gallery.chapters.push(chapter),
                Err(why) if failing == Failing::PassedOver => {
                    eprintln!("gallery: no pictures: {why}");
                    gallery.chapters.push(Chapter::without_pictures(one));
                }
                Err(why) => return Err(why),
            }
        }
        gallery.keep()?;
        Ok(gallery)
    }

    /// Writes the list.
    fn keep(&self) -> Result<()> {
        write(&self.folder.join(LIST), format!("{:#}\n", self.json()))
    }

    /// One that was made before.
    ///
    /// # Errors
    /// There is none in that folder.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(LIST);
        let strange = || {
            Failure::new(format!("no gallery in {}", folder.display()))
                .advise("`cargo xtask gallery DIR` makes one")
        };
        let text = fs::read_to_string(&path).map_err(|why| strange().because(why))?;
        let list: Value = serde_json::from_str(&text).map_err(|why| strange().because(why))?;
        let chapters = chapters(&list).ok_or_else(strange)?;
        Ok(Self {
            folder: folder.to_path_buf(),
            chapters,
        })
    }

    /// Whether this command is in it, as it is now.
    pub fn has(&self, shown: &Shown) -> bool {
        let mut chapters = self.chapters.iter();
        chapters.any(|c| c.name == shown.name && c.lines.iter().eq(shown.lines()))
    }

    /// How many pictures there are.
    pub fn count(&self) -> usize {
        self.chapters
            .iter()
            .map(|chapter| chapter.pictures.len())
            .sum()
    }

    /// Takes in the pictures that `line` has left in a folder; says so where it has not run.
    ///
    /// # Errors
    /// They cannot be copied, or the list not be written.
    pub fn take_in(&mut self, left_in: &Path, line: &str, title: &str) -> Result<()> {
        let is_picture = |path: &PathBuf| {
            let kind = path.extension().and_then(|kind| kind.to_str());
            kind.is_some_and(|kind| ["svg", "png"].contains(&kind))
        };
        let entries = fs::read_dir(left_in).into_iter().flatten().flatten();
        let mut found: Vec<PathBuf> = entries.map(|e| e.path()).filter(is_picture).collect();
        found.sort();
        let name = left_in.file_name().unwrap_or_default().to_string_lossy();
        if found.is_empty() {
            eprintln!("gallery: none of {name}: `{line}` makes them");
            return Ok(());
        }
        let mut pictures = Vec::new();
        for path in found {
            let own = path.file_name().unwrap_or_default().to_string_lossy();
            let file = format!("{PICTURES}/{name}-{own}");
            fs::copy(&path, self.folder.join(&file)).map_err(|why| {
                Failure::new(format!("cannot copy {}", path.display())).because(why)
            })?;
            let title = own.trim_end_matches(".svg").trim_end_matches(".png");
            pictures.push(Listed {
                file,
                title: title.to_owned(),
                words: title.replace('-', ", "),
                caption: title.replace('-', ", "),
            });
        }
        self.chapters.push(Chapter {
            name: name.into_owned(),
            title: title.to_owned(),
            lines: vec![line.to_owned()],
            pictures,
        });
        self.keep()
    }

    fn draw(&self, rarma: &Path, shown: &Shown, work: &Path) -> Result<Chapter> {
        let cannot = |why| Failure::new(format!("cannot make {}", work.display())).because(why);
        if work.exists() {
            fs::remove_dir_all(work).map_err(cannot)?;
        }
        // Apart from where they are put: a file is not copied onto itself.
        let made = work.join("made");
        fs::create_dir_all(&made).map_err(cannot)?;
        let mut maker = Maker::new(rarma, &made);
        for (input, name) in shown.inputs {
            maker.put(*input, &work.join(name))?;
        }
        for line in shown.lines() {
            run(rarma, line, work)?;
        }
        let page = work.join("page/index.html");
        let html = crate::page::read(&page)?;
        let found = pictures::of_page(&html)
            .map_err(|why| Failure::new(format!("{}: {why}", page.display())))?;
        if found.is_empty() {
            return Err(Failure::new(format!("`{}` drew nothing", shown.line)));
        }
        let mut names = BTreeSet::new();
        let mut listed = Vec::new();
        for picture in found {
            let file = free(
                &mut names,
                &format!("{PICTURES}/{}-{}", shown.name, slug(&picture.title)),
            );
            let file = format!("{file}.svg");
            write(&self.folder.join(&file), picture.svg)?;
            listed.push(Listed {
                file,
                title: picture.title,
                words: picture.words,
                caption: picture.caption,
            });
        }
        Ok(Chapter {
            pictures: listed,
            ..Chapter::without_pictures(shown)
        })
    }

    fn json(&self) -> Value {
        let picture = |p: &Listed| json!({"file": p.file, "title": p.title, "words": p.words, "caption": p.caption});
        let chapter = |c: &Chapter| {
            let pictures: Vec<Value> = c.pictures.iter().map(picture).collect();
            json!({"name": c.name, "title": c.title, "lines": c.lines, "pictures": pictures})
        };
        json!({"commands": self.chapters.iter().map(chapter).collect::<Vec<_>>()})
    }
}

fn chapters(list: &Value) -> Option<Vec<Chapter>> {
    let text = |value: &Value, name: &str| Some(value.get(name)?.as_str()?.to_owned());
    let picture = |value: &Value| {
        Some(Listed {
            file: text(value, "file")?,
            title: text(value, "title")?,
            words: text(value, "words")?,
            caption: text(value, "caption")?,
        })
    };
    let chapter = |value: &Value| {
        let lines = value.get("lines")?.as_array()?.iter();
        let pictures = value.get("pictures")?.as_array()?.iter();
        Some(Chapter {
            name: text(value, "name")?,
            title: text(value, "title")?,
            lines: lines
                .map(|line| Some(line.as_str()?.to_owned()))
                .collect::<Option<_>>()?,
            pictures: pictures.map(picture).collect::<Option<_>>()?,
        })
    };
    list.get("commands")?
        .as_array()?
        .iter()
        .map(chapter)
        .collect()
}

/// Runs a line of the list.
fn run(rarma: &Path, line: &str, folder: &Path) -> Result<()> {
    let mut command = Command::new(rarma);
    command
        .args(line.split_whitespace().skip(1))
        .current_dir(folder)
        .stdin(Stdio::null());
    let ended = command
        .output()
        .map_err(|why| process::cannot_start(&command, &why))?;
    if ended.status.code().is_some_and(|code| DONE.contains(&code)) {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&ended.stderr);
    Err(Failure::new(format!("`{line}` failed")).because(said.trim_end()))
}

/// Makes a folder empty that holds a gallery; any other must be empty already.
fn empty(folder: &Path) -> Result<()> {
    let cannot = |why| Failure::new(format!("cannot make {}", folder.display())).because(why);
    let filled = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if filled && !folder.join(LIST).is_file() {
        return Err(Failure::usage(format!(
            "{} holds something that is no gallery",
            folder.display()
        ))
        .advise("name a new folder"));
    }
    let pictures = folder.join(PICTURES);
    if pictures.exists() {
        fs::remove_dir_all(&pictures).map_err(cannot)?;
    }
    fs::create_dir_all(&pictures).map_err(cannot)
}

fn write(path: &Path, text: String) -> Result<()> {
    fs::write(path, text)
        .map_err(|why| Failure::new(format!("cannot write {}", path.display())).because(why))
}

/// A title as part of a file's name; without its numbers, which another version may have others of.
fn slug(title: &str) -> String {
    title
        .to_lowercase()
        .split(|c: char| !c.is_ascii_lowercase())
        .filter(|word| !word.is_empty())
        .collect::<Vec<_>>()
        .join("-")
}

fn free(taken: &mut BTreeSet<String>, name: &str) -> String {
    let name = std::iter::once(name.to_owned())
        .chain((2..).map(|k| format!("{name}-{k}")))
        .find(|name| !taken.contains(name))
        .unwrap_or_default();
    taken.insert(name.clone());
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_pictures_have_no_numbers_and_are_not_given_twice() {
        assert_eq!(
            slug("Where the deviation at 47 N comes from"),
            "where-the-deviation-at-n-comes-from"
        );
        assert_eq!(slug("(c) Damping"), "c-damping");
        let mut taken = BTreeSet::new();
        let names = ["a", "a", "b", "a"].map(|name| free(&mut taken, name));
        assert_eq!(names, ["a", "a-2", "b", "a-3"]);
    }

    #[test]
    fn the_list_is_read_as_it_was_written_and_other_folders_are_kept() {
        let folder = std::env::temp_dir().join(format!("rarma-gallery-{}", std::process::id()));
        empty(&folder).expect("a new folder");
        let picture = Listed {
            file: "pictures/a.svg".to_owned(),
            title: "A \"b\"".to_owned(),
            words: "w".to_owned(),
            caption: "c".to_owned(),
        };
        let gallery = Gallery {
            folder: folder.clone(),
            chapters: vec![Chapter {
                name: "n".to_owned(),
                title: "t".to_owned(),
                lines: vec!["rarma x".to_owned()],
                pictures: vec![picture],
            }],
        };
        assert!(Gallery::read(&folder).is_err());
        assert!(
            empty(&folder).is_err(),
            "pictures without a list are somebody's"
        );
        gallery.keep().expect("written");
        let mut gallery = gallery;
        let left = folder.join("screens");
        gallery
            .take_in(&left, "cargo xtask screens", "T")
            .expect("none yet");
        assert_eq!(gallery.count(), 1);
        fs::create_dir_all(&left).expect("a folder");
        for name in ["b-80x24.svg", "a.png", "cut.wav"] {
            fs::write(left.join(name), name).expect("written");
        }
        gallery
            .take_in(&left, "cargo xtask screens", "T")
            .expect("taken");
        let files: Vec<&str> = gallery.chapters[1]
            .pictures
            .iter()
            .map(|picture| picture.file.as_str())
            .collect();
        assert_eq!(
            files,
            ["pictures/screens-a.png", "pictures/screens-b-80x24.svg"]
        );
        assert!(folder.join(files[0]).is_file());
        assert_eq!(
            Gallery::read(&folder).expect("a list").chapters,
            gallery.chapters
        );
        empty(&folder).expect("a gallery is made anew");
        fs::remove_dir_all(&folder).expect("removed");
    }
}
