//! Whether the tests a command names are there: cargo and the tests themselves are asked.

use super::plan::Tests;
use crate::{Failure, Result, Workspace, process};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// A program of tests.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Program {
    package: String,
    /// Name of the test file; none: the library.
    file: Option<String>,
    path: PathBuf,
}

/// All programs of tests of the workspace, built as the stage of the host tests builds them.
#[derive(Debug)]
pub struct Lookup {
    root: PathBuf,
    programs: Vec<Program>,
}

impl Lookup {
    /// Asks cargo.
    ///
    /// # Errors
    /// They cannot be built.
    pub fn new(workspace: &Workspace) -> Result<Self> {
        let mut cargo = process::host_cargo(workspace);
        cargo.args(["test", "--release", "--lib", "--bins", "--tests"]);
        cargo.args(process::HOST);
        cargo.args(["--no-run", "--quiet", "--message-format", "json"]);
        let messages = process::output(&mut cargo)?;
        Ok(Self {
            root: workspace.root().to_path_buf(),
            programs: messages.lines().filter_map(program).collect(),
        })
    }

    /// Fails unless every file that is named is there and holds a test that would run.
    ///
    /// # Errors
    /// What is missing.
    pub fn check(
        &self,
        tests: &Tests,
        variables: &[(String, String)],
    ) -> std::result::Result<(), String> {
        let wanted: Vec<Option<&String>> = match tests.files[..] {
            [] => vec![None],
            _ => tests.files.iter().map(Some).collect(),
        };
        for file in wanted {
            let there = |p: &&Program| p.package == tests.package && p.file.as_ref() == file;
            let program = self.programs.iter().find(there).ok_or_else(|| {
                let name = file.map_or("--lib", String::as_str);
                format!("package {} has no tests {name}", tests.package)
            })?;
            let mut list = Command::new(&program.path);
            list.args(["--list", "--format", "terse"]);
            list.args(tests.ignored.then_some("--ignored"));
            list.args(&tests.filter);
            let names =
                process::output(list.current_dir(&self.root)).map_err(|why| why.to_string())?;
            let names = || names.lines().filter_map(|line| line.strip_suffix(": test"));
            if names().next().is_none() {
                return Err("no test has such a name".to_owned());
            }
            if file.is_none() {
                let package = self.root.join(&tests.package);
                let text = |name| fs::read_to_string(package.join(name)).unwrap_or_default();
                there_as_typed(
                    names(),
                    &text("src/lib.rs"),
                    &text("Cargo.toml"),
                    &tests.features,
                )?;
            }
            for (name, _) in variables {
                self.reads(&tests.package, file, name)?;
            }
        }
        Ok(())
    }

    /// A variable that is set is one that the tests read.
    fn reads(
        &self,
        package: &str,
        file: Option<&String>,
        variable: &str,
    ) -> std::result::Result<(), String> {
        let Some(file) = file else {
            return Err(format!(
                "{variable}: only tests in files are looked through"
            ));
        };
        let path = self
            .root
            .join(package)
            .join("tests")
            .join(format!("{file}.rs"));
        let text = fs::read_to_string(&path).map_err(|why| format!("{}: {why}", path.display()))?;
        let named = text.contains(variable);
        named
            .then_some(())
            .ok_or(format!("{} does not read {variable}", path.display()))
    }

    /// Fails unless there is such a bench.
    ///
    /// # Errors
    /// There is none.
    pub fn bench(workspace: &Workspace, name: &str) -> Result<()> {
        let path = workspace
            .root()
            .join("host-tests/benches")
            .join(format!("{name}.rs"));
        let there = path.is_file();
        there
            .then_some(())
            .ok_or_else(|| Failure::new(format!("there is no bench {name}")))
    }
}

/// What one of cargo's messages says of a program of tests.
fn program(message: &str) -> Option<Program> {
    let message: Value = serde_json::from_str(message).ok()?;
    let path = message["executable"].as_str()?;
    message["profile"]["test"].as_bool().filter(|test| *test)?;
    let target = &message["target"];
    let kind = target["kind"][0].as_str()?;
    let file = match kind {
        "test" => Some(target["name"].as_str()?.to_owned()),
        "lib" => None,
        _ => return None,
    };
    // `path+file:///…/host-tests#0.1.0`, or `…#name@0.1.0` where the folder is called otherwise.
    let (folder, version) = message["package_id"].as_str()?.rsplit_once('#')?;
    let package = match version.split_once('@') {
        Some((name, _)) => name,
        None => folder.rsplit('/').next()?,
    };
    Some(Program {
        package: package.to_owned(),
        file,
        path: PathBuf::from(path),
    })
}

/// Fails where all of these tests of a library lie in modules that a feature brings which neither the
/// command names nor the package has on by itself: the programs that are asked have all features.
fn there_as_typed<'a>(
    mut names: impl Iterator<Item = &'a str>,
    library: &str,
    manifest: &str,
    features: &[String],
) -> std::result::Result<(), String> {
    let default = manifest.lines().find(|line| line.starts_with("default = "));
    let quoted =
        |feature: &str| default.is_some_and(|line| line.contains(&format!("\"{feature}\"")));
    let mut before = "";
    let mut gated = Vec::new();
    for line in library.lines().map(str::trim) {
        let module = line.trim_start_matches("pub ").strip_prefix("mod ");
        let feature = before.strip_prefix("#[cfg(feature = \"");
        if let (Some(module), Some(feature)) = (module, feature) {
            let feature = feature.trim_end_matches("\")]");
            if !quoted(feature) && !features.iter().any(|on| on == feature) {
                gated.push((module.trim_end_matches(';'), feature));
            }
        }
        before = line;
    }
    let lacks = |name: &str| {
        let module = name.split("::").next();
        let found = gated.iter().find(|(gate, _)| Some(*gate) == module);
        found.map(|(_, feature)| *feature)
    };
    let first = names.next().and_then(lacks);
    match first.filter(|_| names.all(|name| lacks(name).is_some())) {
        Some(feature) => Err(format!(
            "its tests are there with `--features {feature}` only"
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_out_of_cargos_messages() {
        let message = |id: &str, kind: &str, test: bool| {
            format!(
                r#"{{"reason":"compiler-artifact","package_id":"{id}","target":{{"kind":["{kind}"],"name":"health"}},"profile":{{"test":{test}}},"executable":"/t/health-1"}}"#
            )
        };
        let found = program(&message("path+file:///a/host-tests#0.1.0", "test", true));
        let want = Program {
            package: "host-tests".to_owned(),
            file: Some("health".to_owned()),
            path: PathBuf::from("/t/health-1"),
        };
        assert_eq!(found, Some(want));
        let found = program(&message("path+file:///a/b#core@0.1.0", "lib", true));
        assert!(found.is_some_and(|p| p.package == "core" && p.file.is_none()));
        assert_eq!(
            program(&message("path+file:///a/b#0.1.0", "bin", true)),
            None
        );
        assert_eq!(
            program(&message("path+file:///a/b#0.1.0", "test", false)),
            None
        );
        assert_eq!(program(r#"{"reason":"build-finished"}"#), None);
    }

    #[test]
    fn a_test_that_a_feature_brings_is_not_there_without() {
        let library = "mod arx;\n#[cfg(feature = \"channels\")]\nmod channels;\n#[cfg(feature = \"more\")]\npub mod more;\n";
        let manifest = "[features]\ndefault = [\"more\"]\nchannels = []\nmore = []\n";
        let check = |names: &[&str], features: &[&str]| {
            let features: Vec<String> = features.iter().map(|f| (*f).to_owned()).collect();
            there_as_typed(names.iter().copied(), library, manifest, &features)
        };
        let why = check(&["channels::a::b", "channels::c"], &[]).expect_err("nothing runs");
        assert!(why.contains("--features channels"), "{why}");
        assert_eq!(check(&["channels::a::b"], &["channels"]), Ok(()));
        assert_eq!(check(&["channels::a", "arx::b"], &[]), Ok(()), "one runs");
        assert_eq!(check(&["more::a"], &[]), Ok(()), "on by itself");
    }
}
