//! Who imports whom: the folders of the workspace by their manifests, the modules of one folder by the
//! paths in their code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::paths::{self, Named};
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
            let mut dependencies = BTreeSet::new();
            let targets = manifest.get("target").and_then(toml::Value::as_table);
            let of_targets = targets
                .iter()
                .flat_map(|all| all.values().filter_map(toml::Value::as_table));
            for part in core::iter::once(&manifest).chain(of_targets) {
                let table = part.get("dependencies").and_then(toml::Value::as_table);
                dependencies.extend(table.iter().flat_map(|table| table.keys().cloned()));
            }
            folders.insert(name.unwrap_or(folder).to_owned(), dependencies);
        }
        let mut graph = Self(folders);
        let known: BTreeSet<String> = graph.0.keys().cloned().collect();
        for imports in graph.0.values_mut() {
            imports.retain(|name: &String| known.contains(name));
        }
        Ok(graph)
    }

    /// Of the modules that lie in `folder` (none: at the top) of a package's code, with what lies in them; tests do not
    /// count.
    pub fn of_modules(code: &Modules, folder: &[String]) -> Self {
        let depth = folder.len();
        let mut graph = Self::default();
        for module in code
            .known
            .iter()
            .filter(|m| m.len() > depth && m.starts_with(folder))
        {
            graph.0.entry(module[depth].clone()).or_default();
        }
        for (module, imports) in &code.imports {
            let Some(own) = module.get(depth).filter(|_| module.starts_with(folder)) else {
                continue;
            };
            let others = imports.iter().filter(|import| import.starts_with(folder));
            let others = others
                .filter_map(|import| import.get(depth))
                .filter(|other| *other != own);
            graph
                .0
                .entry(own.clone())
                .or_default()
                .extend(others.cloned());
        }
        graph
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

/// The modules of a package's code, and which others each of them names.
#[derive(Debug, Clone, Default)]
pub struct Modules {
    known: BTreeSet<Module>,
    imports: BTreeMap<Module, BTreeSet<Module>>,
}

/// A module by the names that lead to it.
type Module = Vec<String>;

impl Modules {
    /// Of a package's `src`. Programs and the prelude are none.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn read(source: &Path) -> Result<Self> {
        let mut named = BTreeMap::new();
        for file in files(source)? {
            if let Some(module) = module(source, &file) {
                let is_test = file.to_string_lossy().ends_with("tests.rs");
                let code = if is_test {
                    String::new()
                } else {
                    without_tests(&read(&file)?)
                };
                named.insert(module, paths::named(&code));
            }
        }
        Ok(Self::of(&named))
    }

    fn of(named: &BTreeMap<Module, Vec<Named>>) -> Self {
        let mut modules = Self::default();
        for module in named.keys() {
            modules
                .known
                .extend((0..=module.len()).map(|n| module[..n].to_vec()));
        }
        // What a module gives on of another is that of the other.
        let mut given_on = BTreeMap::new();
        let mut whole: BTreeMap<&Module, BTreeSet<Module>> = BTreeMap::new();
        for (module, paths) in named {
            for path in paths {
                let Some(target) = modules.absolute(module, &path.path) else {
                    continue;
                };
                if let (true, Some(name)) = (path.given_on, target.last()) {
                    let seen: Module = module.iter().chain([name]).cloned().collect();
                    given_on.insert(seen, target.clone());
                }
                whole.entry(module).or_default().insert(target);
            }
        }
        for (module, targets) in whole {
            let found = targets
                .iter()
                .map(|target| modules.home(target, &given_on, 5))
                .collect();
            modules.imports.insert(module.clone(), found);
        }
        modules
    }

    /// Folders that hold modules, each by the names that lead to it.
    pub fn folders(&self) -> BTreeSet<Vec<String>> {
        self.known
            .iter()
            .filter_map(|module| module.split_last())
            .map(|(_, folder)| folder.to_vec())
            .collect()
    }

    /// Modules of one folder that import each other, by whatever way round; `folder: a, b`.
    pub fn circles(&self) -> Vec<String> {
        let of = |folder: Vec<String>| {
            let circles = Graph::of_modules(self, &folder).circles();
            let name = folder.join("/");
            circles
                .into_iter()
                .map(move |circle| format!("{name}: {}", circle.join(", ")))
        };
        self.folders().into_iter().flat_map(of).collect()
    }

    /// A path from the root of the package; none where it begins with something else than its modules.
    fn absolute(&self, module: &Module, path: &[String]) -> Option<Module> {
        let (mut at, mut rest) = match path.first()?.as_str() {
            "crate" => (Vec::new(), &path[1..]),
            "super" | "self" => (module.clone(), path),
            own => {
                let child: Module = module
                    .iter()
                    .map(String::as_str)
                    .chain([own])
                    .map(str::to_owned)
                    .collect();
                self.known.contains(&child).then_some(())?;
                (module.clone(), path)
            }
        };
        while let Some(("super" | "self", behind)) =
            rest.split_first().map(|(f, b)| (f.as_str(), b))
        {
            if rest[0] == "super" {
                at.pop();
            }
            rest = behind;
        }
        at.extend_from_slice(rest);
        Some(at)
    }

    /// The module in which a path ends, what is given on being followed so many times.
    fn home(&self, path: &[String], given_on: &BTreeMap<Module, Module>, times: u32) -> Module {
        for n in (1..=path.len()).rev() {
            if self.known.contains(&path[..n]) {
                return path[..n].to_vec();
            }
            if let (Some(target), true) = (given_on.get(&path[..n]), times > 0) {
                let whole: Module = target.iter().chain(&path[n..]).cloned().collect();
                return self.home(&whole, given_on, times - 1);
            }
        }
        Vec::new()
    }
}

/// The module that a file is; none for programs and the prelude.
fn module(source: &Path, file: &Path) -> Option<Module> {
    let inside = file.strip_prefix(source).ok()?.with_extension("");
    let mut module: Module = inside
        .iter()
        .map(|part| part.to_string_lossy().into_owned())
        .collect();
    if module.last().is_some_and(|name| name == "mod") {
        module.pop();
    }
    match module.first()?.as_str() {
        "lib" => Some(Vec::new()),
        "main" | "bin" | "prelude" => None,
        _ => Some(module),
    }
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
    fn modules_of_any_folder_are_seen_to_import_in_a_circle() {
        let modules = |all: &[(&str, &str)]| {
            let named = all.iter().map(|(module, code)| {
                let module = module
                    .split('/')
                    .filter(|n| !n.is_empty())
                    .map(str::to_owned)
                    .collect();
                (module, paths::named(code))
            });
            Modules::of(&named.collect())
        };
        let straight = [
            ("", "mod a;\npub use a::One;"),
            ("a", "mod c;\nmod d;\npub use c::Two;\nuse crate::b::Three;"),
            ("a/c", "use super::Up;\nuse std::fmt;"),
            ("a/d", "use super::Two;"),
            ("b", ""),
        ];
        assert!(modules(&straight).circles().is_empty());
        let mut round = straight;
        // By what the folder gives on, not by the module's own name.
        round[2].1 = "use super::d::Four;";
        assert_eq!(modules(&round).circles(), ["a: c, d"]);
        let mut round = straight;
        round[4].1 = "use crate::One;\nuse crate::a::c::Two;";
        assert_eq!(modules(&round).circles(), [": a, b"]);
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
