//! Who imports whom: the folders of the workspace by their manifests, the modules of one folder by the
//! `crate::` paths in their code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use crate::{Failure, Result};

/// What each room imports.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Graph(pub BTreeMap<String, BTreeSet<String>>);

impl Graph {
    /// Of the folders that the workspace's manifest names.
    ///
    /// # Errors
    /// When a manifest cannot be read.
    pub fn of_folders(root: &Path) -> Result<Self> {
        let members = manifest(&root.join("Cargo.toml"))?;
        let members = members
            .get("workspace")
            .and_then(|workspace| workspace.get("members"))
            .and_then(toml::Value::as_array)
            .map(Vec::as_slice)
            .unwrap_or_default();
        let mut folders = BTreeMap::new();
        for folder in members.iter().filter_map(toml::Value::as_str) {
            let manifest = manifest(&root.join(folder).join("Cargo.toml"))?;
            let name = manifest
                .get("package")
                .and_then(|package| package.get("name"))
                .and_then(toml::Value::as_str);
            let dependencies = manifest
                .get("dependencies")
                .and_then(toml::Value::as_table)
                .map(|table| table.keys().cloned().collect())
                .unwrap_or_default();
            folders.insert(name.unwrap_or(folder).to_owned(), dependencies);
        }
        let mut graph = Self(folders);
        let known: BTreeSet<String> = graph.0.keys().cloned().collect();
        for imports in graph.0.values_mut() {
            imports.retain(|name: &String| known.contains(name));
        }
        Ok(graph)
    }

    /// Of the modules at the top of a folder's `src`; tests do not count.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn of_modules(source: &Path) -> Result<Self> {
        let mut graph = Self::default();
        let files = files(source)?;
        let known: BTreeSet<String> = files.iter().filter_map(|f| module(source, f)).collect();
        for file in &files {
            let Some(own) = module(source, file) else {
                continue;
            };
            let imports = graph.0.entry(own.clone()).or_default();
            if file.to_string_lossy().ends_with("tests.rs") {
                continue;
            }
            for name in named(&read(file)?) {
                if name != own && known.contains(&name) {
                    imports.insert(name);
                }
            }
        }
        Ok(graph)
    }

    /// Rooms that import each other, by whatever way round.
    pub fn circles(&self) -> Vec<Vec<String>> {
        let reached: BTreeMap<&String, BTreeSet<&String>> =
            self.0.keys().map(|name| (name, self.reach(name))).collect();
        let mut circles: Vec<Vec<String>> = Vec::new();
        for (name, there) in &reached {
            let back = |other: &&&String| reached.get(**other).is_some_and(|r| r.contains(name));
            let circle: Vec<String> = there.iter().filter(back).map(|n| (*n).clone()).collect();
            if circle.len() > 1 && !circles.contains(&circle) {
                circles.push(circle);
            }
        }
        circles
    }

    /// What is imported and not also imported by way of another room.
    pub fn direct(&self, name: &str) -> Vec<&String> {
        let imports = self.0.get(name).into_iter().flatten();
        let by_others: BTreeSet<&String> = imports
            .clone()
            .flat_map(|other| self.reach(other))
            .collect();
        imports.filter(|other| !by_others.contains(other)).collect()
    }

    /// All that a room needs, in however many steps.
    fn reach(&self, name: &str) -> BTreeSet<&String> {
        let mut reached = BTreeSet::new();
        let mut left: Vec<&String> = self.0.get(name).into_iter().flatten().collect();
        while let Some(next) = left.pop() {
            if reached.insert(next) {
                left.extend(self.0.get(next).into_iter().flatten());
            }
        }
        reached
    }
}

/// All Rust files below a folder, in order.
///
/// # Errors
/// When a folder cannot be read.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let cannot =
        |why| Failure::new(format!("cannot read the folder {}", folder.display())).because(why);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        if path.is_dir() {
            found.extend(files(&path)?);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// The text of a file.
///
/// # Errors
/// When it cannot be read.
pub fn read(path: &Path) -> Result<String> {
    fs::read_to_string(path)
        .map_err(|why| Failure::new(format!("cannot read {}", path.display())).because(why))
}

/// The code without its tests and comments.
pub fn without_tests(text: &str) -> String {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

fn manifest(path: &Path) -> Result<toml::Table> {
    read(path)?
        .parse()
        .map_err(|why| Failure::new(format!("{} is no manifest", path.display())).because(why))
}

/// The module at the top that a file belongs to; none for `lib.rs`, programs and the prelude.
fn module(source: &Path, file: &Path) -> Option<String> {
    let inside = file.strip_prefix(source).ok()?;
    let first = inside.components().next()?.as_os_str().to_str()?;
    let name = first.trim_end_matches(".rs");
    let is_none = ["lib", "main", "bin", "prelude"].contains(&name);
    (!is_none).then(|| name.to_owned())
}

/// The first names of all `crate::` paths.
fn named(text: &str) -> BTreeSet<String> {
    let code = without_tests(text);
    let mut found = BTreeSet::new();
    for (at, start) in code.match_indices("crate::") {
        // Not the end of another word, like `super_crate::`.
        let before = code[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &code[at + start.len()..];
        let several = rest.strip_prefix('{').map(|list| {
            let end = list.find('}').unwrap_or(list.len());
            list[..end].split(',').collect::<Vec<_>>()
        });
        for path in several.unwrap_or_else(|| vec![rest]) {
            let path = path.trim_start();
            let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_'));
            found.insert(path[..end.unwrap_or(path.len())].to_owned());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(edges: &[(&str, &[&str])]) -> Graph {
        let owned = |(name, imports): &(&str, &[&str])| {
            let imports = imports.iter().map(|i| (*i).to_owned()).collect();
            ((*name).to_owned(), imports)
        };
        Graph(edges.iter().map(owned).collect())
    }

    #[test]
    fn names_are_found_alone_and_in_braces() {
        let text = "use crate::real::Real;\nuse crate::{ud::Ud, visit};\n// crate::no\nlet x = crate::order::O;\n#[cfg(test)]\nuse crate::bench;";
        let found: Vec<String> = named(text).into_iter().collect();
        assert_eq!(found, ["order", "real", "ud", "visit"]);
    }

    #[test]
    fn circles_are_found_and_ways_round_left_out() {
        let round = graph(&[("a", &["b"]), ("b", &["c"]), ("c", &["a"]), ("d", &["a"])]);
        assert_eq!(round.circles(), [vec!["a", "b", "c"]]);
        let straight = graph(&[("a", &[]), ("b", &["a"]), ("c", &["a", "b"])]);
        assert!(straight.circles().is_empty());
        assert_eq!(straight.direct("c"), ["b"]);
    }
}
