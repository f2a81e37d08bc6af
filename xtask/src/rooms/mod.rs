//! `cargo xtask rooms [--markdown FILE]`: the picture of the rooms, who imports whom, and how large
//! each is, made from the code. `--at FOLDER`: how large those of another checkout are.

pub mod graph;
pub mod paths;

use std::fmt::{self, Write};
use std::path::{Path, PathBuf};

use crate::page::{self, Part};
use crate::{Failure, Result, Workspace};
use graph::{Graph, Modules, files, read, without_tests};

/// The page that holds it.
pub const PAGE: &str = "docs/rooms.md";
const PART: Part = Part("rooms");
/// Folders whose modules are drawn.
const DRAWN: [&str; 2] = ["rarma-core", "rarma-box"];
/// Packages that do not lie in a folder of their name.
const ELSEWHERE: [(&str, &str); 1] = [("fast-path", "firmware/fast")];

/// The command.
///
/// # Errors
/// When the arguments are wrong, or a file cannot be read or written.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    match arguments {
        [] => print!("{}", markdown(workspace.root())?),
        [option, folder] if option == "--at" => print!("{}", table(Path::new(folder))?),
        [option, file] if option == "--markdown" => {
            let text = markdown(workspace.root())?;
            let path = PathBuf::from(file);
            let document = page::read(&path)?;
            let written = PART.written_into(&document, &text).map_err(|why| {
                Failure::new(format!("cannot write into {}", path.display())).because(why)
            })?;
            page::write(&path, &written)?;
        }
        _ => {
            return Err(Failure::usage(
                "`rooms` takes nothing, `--markdown FILE` or `--at FOLDER`",
            ));
        }
    }
    Ok(0)
}

/// Pictures and tables.
///
/// # Errors
/// When a file of the workspace cannot be read.
pub fn markdown(root: &Path) -> Result<String> {
    let mut text = String::new();
    draw(&mut text, &Graph::of_folders(root)?);
    text += "\n";
    text += &table(root)?;
    for name in DRAWN {
        let _ = write!(text, "\nWithin `{name}`:\n\n");
        draw(
            &mut text,
            &Graph::of_modules(&Modules::read(&folder(root, name).join("src"))?, &[]),
        );
    }
    Ok(text)
}

/// How large each package is.
fn table(root: &Path) -> Result<String> {
    let mut text = "| package | lines of Rust | of these tests | declared `pub` | modules import in a circle |\n|---|---:|---:|---:|---|\n".to_owned();
    let mut all = Size::default();
    for name in Graph::of_folders(root)?.0.keys() {
        let folder = folder(root, name);
        let size = Size::of(&folder)?;
        all.add(&size);
        let circles = Modules::read(&folder.join("src"))?.circles();
        let circles = if circles.is_empty() {
            "none".to_owned()
        } else {
            circles.join("; ")
        };
        let _ = writeln!(text, "| {name} | {size} | {circles} |");
    }
    let _ = writeln!(text, "| all | {all} | |");
    Ok(text)
}

fn folder(root: &Path, package: &str) -> PathBuf {
    let elsewhere = ELSEWHERE.iter().find(|(name, _)| *name == package);
    root.join(elsewhere.map_or(package, |(_, folder)| folder))
}

/// An arrow leads from what is imported to who imports it: the way that data flow. What is imported by
/// way of another as well has no arrow.
fn draw(text: &mut String, graph: &Graph) {
    *text += "```mermaid\nflowchart LR\n";
    for name in graph.0.keys() {
        let imports = graph.direct(name);
        let is_imported = graph.0.values().any(|imports| imports.contains(name));
        if imports.is_empty() && !is_imported {
            let _ = writeln!(text, "    {name}");
        }
        for import in imports {
            let _ = writeln!(text, "    {import} --> {name}");
        }
    }
    *text += "```\n";
}

#[derive(Default)]
struct Size {
    lines: usize,
    tests: usize,
    public: usize,
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} | {} | {}", self.lines, self.tests, self.public)
    }
}

impl Size {
    fn add(&mut self, other: &Self) {
        self.lines += other.lines;
        self.tests += other.tests;
        self.public += other.public;
    }

    fn of(folder: &Path) -> Result<Self> {
        let mut size = Self::default();
        for file in files(folder)? {
            let text = read(&file)?;
            let inside = file
                .strip_prefix(folder)
                .unwrap_or(&file)
                .to_string_lossy()
                .into_owned();
            let is_other = ["fast/", "target/"]
                .iter()
                .any(|other| inside.starts_with(other));
            if is_other {
                continue;
            }
            let lines = text.lines().count();
            size.lines += lines;
            let is_test = inside.starts_with("tests/") || inside.ends_with("tests.rs");
            let before = text
                .split("#[cfg(test)]\nmod tests {")
                .next()
                .unwrap_or_default();
            size.tests += if is_test {
                lines
            } else {
                lines - before.lines().count()
            };
            if !is_test {
                let code = without_tests(&text);
                size.public += code
                    .lines()
                    .filter(|line| line.trim_start().starts_with("pub "))
                    .count();
            }
        }
        Ok(size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Folders in which no module may import in a circle.
    const STRAIGHT: [&str; 18] = [
        "rarma-core",
        "rarma-fit",
        "rarma-rigs",
        "rarma-box",
        "firmware",
        "rarma-recordings",
        "rarma-pictures",
        "rarma-fourier",
        "rarma-plants",
        "hal-sim",
        "rarma-scenarios",
        "rarma-population",
        "rarma-cli",
        "rarma-fleet",
        "rarma-web",
        "host-tests",
        "fuzz",
        "xtask",
    ];

    #[test]
    fn the_modules_of_a_room_import_in_no_circle() {
        let workspace = Workspace::locate().expect("a workspace");
        for name in STRAIGHT {
            let modules = Modules::read(&folder(workspace.root(), name).join("src"));
            assert_eq!(
                modules.expect("readable").circles(),
                Vec::<String>::new(),
                "{name}"
            );
        }
        let folders = Graph::of_folders(workspace.root()).expect("manifests");
        assert_eq!(folders.circles(), Vec::<Vec<String>>::new());
        // The listener knows nobody.
        assert!(folders.0["rarma-core"].is_empty());
    }

    /// The pictures are compared; lines and items change with every commit.
    #[test]
    fn the_page_shows_the_rooms_as_they_are() {
        let workspace = Workspace::locate().expect("a workspace");
        let pictures = |text: &str| -> Vec<String> {
            let arrows = text.lines().filter(|line| line.contains(" --> "));
            arrows
                .filter(|line| !line.starts_with("<!--"))
                .map(str::to_owned)
                .collect()
        };
        let page = read(&workspace.root().join(PAGE)).expect("the page");
        let now = markdown(workspace.root()).expect("readable");
        let (_, page, _) = PART.split(&page).expect("its markers");
        assert_eq!(
            pictures(page),
            pictures(&now),
            "cargo xtask rooms --markdown {PAGE}"
        );
    }

    /// Each step of docs/walks.md, `function` in a file, is there.
    #[test]
    fn every_step_of_the_walks_exists() {
        let workspace = Workspace::locate().expect("a workspace");
        let page = read(&workspace.root().join("docs/walks.md")).expect("the page");
        // A line may end within a step.
        let words = page.split_whitespace().collect::<Vec<_>>();
        let steps = words
            .windows(3)
            .filter(|three| three[1] == "in" && three[2].contains(".rs"));
        let mut number = 0;
        for three in steps {
            let function = three[0].trim_matches(|c: char| !c.is_alphanumeric() && c != '_');
            let file = three[2].trim_matches(|c: char| !c.is_alphanumeric());
            let code = read(&workspace.root().join(file)).expect("the file of a step");
            let is_there = [format!("fn {function}("), format!("fn {function}<")]
                .iter()
                .any(|start| code.contains(start.as_str()));
            assert!(is_there, "{file} has no function `{function}`");
            number += 1;
        }
        assert!(number > 25, "{number} steps");
    }
}
