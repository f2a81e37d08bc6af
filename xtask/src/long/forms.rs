//! Which tests are long forms: asked of the built tests themselves.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::{Failure, Result, Workspace, process};

/// How the name of a long form ends.
const ENDING: &str = "_long";

/// One test that is ignored unless it is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LongForm {
    package: String,
    /// The test file; none for tests of the library itself.
    file: Option<String>,
    test: String,
}

impl LongForm {
    /// Its name in the table.
    pub fn name(&self) -> String {
        format!(
            "{}::{}",
            self.file.as_ref().unwrap_or(&self.package),
            self.test
        )
    }

    /// Its package, and its test file.
    pub(super) fn place(&self) -> (&str, Option<&str>) {
        (&self.package, self.file.as_deref())
    }

    /// What cargo is told to run it.
    pub fn arguments(&self) -> Vec<&str> {
        let mut words = vec!["test", "--release", "--package", &self.package];
        match &self.file {
            Some(file) => words.extend(["--test", file]),
            None => words.push("--lib"),
        }
        words.extend(["--", "--ignored", "--exact", "--nocapture", &self.test]);
        words
    }
}

/// The long forms of the workspace.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Forms {
    /// In the order of the test files.
    pub long: Vec<LongForm>,
}

impl Forms {
    /// Builds the tests and asks each for its names: of the whole workspace, or only of these
    /// test files, whatever package has them.
    ///
    /// # Errors
    /// When the tests do not build, or a long form has no short one.
    pub fn find(workspace: &Workspace, files: &[String]) -> Result<Self> {
        let mut cargo = process::host_cargo(workspace);
        cargo.args(["test", "--release", "--no-run", "--message-format", "json"]);
        if files.is_empty() {
            cargo.args(process::HOST).args(["--lib", "--tests"]);
        } else {
            let packages: BTreeSet<String> = files
                .iter()
                .map(|file| package_of(workspace, file))
                .collect();
            cargo.args(packages.iter().flat_map(|package| ["--package", package]));
            cargo.args(files.iter().flat_map(|file| ["--test", file]));
        }
        let messages = process::output(&mut cargo)?;
        let mut programs: Vec<Program> = messages.lines().filter_map(Program::read).collect();
        programs.sort_by(|a, b| (&a.package, &a.file).cmp(&(&b.package, &b.file)));
        let mut forms = Self::default();
        let mut objections = Vec::new();
        for program in programs {
            let all = program.tests(&[])?;
            let ignored = program.tests(&["--ignored"])?;
            objections
                .extend(without_short_form(&all, &ignored).map(|test| program.form(test).name()));
            forms
                .long
                .extend(ignored.iter().map(|test| program.form(test)));
        }
        if objections.is_empty() {
            return Ok(forms);
        }
        Err(Failure::new("ignored tests without a short form")
            .because(format!("\n  {}", objections.join("\n  ")))
            .advise("name a long form NAME_long, beside a test NAME that judges the same promise"))
    }
}

/// The package that has a test file of this name; cargo says what it looked for where none has.
fn package_of(workspace: &Workspace, file: &str) -> String {
    let sources = [format!("tests/{file}.rs"), format!("tests/{file}/main.rs")];
    let folders = std::fs::read_dir(workspace.root()).into_iter().flatten();
    let mut packages = folders
        .flatten()
        .filter(|f| sources.iter().any(|s| f.path().join(s).is_file()));
    let found = packages.find_map(|folder| folder.file_name().into_string().ok());
    found.unwrap_or_else(|| "host-tests".to_owned())
}

/// Ignored tests that are not called `NAME_long`, or beside which no `NAME` runs every day.
fn without_short_form<'a>(
    all: &'a [String],
    ignored: &'a [String],
) -> impl Iterator<Item = &'a String> {
    let has = move |test: &String| {
        test.strip_suffix(ENDING).is_some_and(|short| {
            let is = |name: &String| name == short;
            all.iter().any(is) && !ignored.iter().any(is)
        })
    };
    ignored.iter().filter(move |test| !has(test))
}

/// A built test program.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Program {
    package: String,
    file: Option<String>,
    executable: String,
}

impl Program {
    /// Reads one line of what cargo says while it builds; none if it is about something else.
    fn read(message: &str) -> Option<Self> {
        let message: Value = serde_json::from_str(message).ok()?;
        let text = |value: &Value| value.as_str().map(str::to_owned);
        let target = message.get("target")?;
        // Every package of this workspace lies in a folder of its own name.
        let manifest = text(message.get("manifest_path")?)?;
        let package = Path::new(&manifest).parent()?.file_name()?.to_str()?;
        let is_library = target
            .get("kind")?
            .as_array()?
            .iter()
            .any(|kind| kind == "lib");
        Some(Self {
            package: package.to_owned(),
            file: text(target.get("name")?).filter(|_| !is_library),
            executable: text(message.get("executable")?)?,
        })
        .filter(|_| message["profile"]["test"] == true)
    }

    fn tests(&self, options: &[&str]) -> Result<Vec<String>> {
        let mut command = Command::new(&self.executable);
        command.args(["--list", "--format", "terse"]).args(options);
        let list = process::output(&mut command)?;
        let names = list.lines().filter_map(|line| line.strip_suffix(": test"));
        Ok(names.map(str::to_owned).collect())
    }

    fn form(&self, test: &str) -> LongForm {
        LongForm {
            package: self.package.clone(),
            file: self.file.clone(),
            test: test.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_form_needs_its_short_one() {
        let names =
            |line: &str| -> Vec<String> { line.split_whitespace().map(str::to_owned).collect() };
        let all = names("a a_long b_long c d_long d");
        let ignored = names("a_long b_long c d_long d");
        let objections: Vec<&String> = without_short_form(&all, &ignored).collect();
        // One has none, one is not named as one, one's short form is ignored, too (twice).
        assert_eq!(objections, ["b_long", "c", "d_long", "d"]);
    }

    #[test]
    fn reads_what_cargo_says_of_a_test() {
        let say = |kind: &str, test: bool| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"/w/host-tests/Cargo.toml","target":{{"kind":["{kind}"],"name":"health"}},"profile":{{"test":{test}}},"executable":"/t/health-1"}}"#
            )
        };
        let program = Program::read(&say("test", true)).expect("a test");
        let words = "test --release --package host-tests --test health -- --ignored --exact --nocapture x_long";
        assert_eq!(program.form("x_long").arguments().join(" "), words);
        assert_eq!(program.form("x_long").name(), "health::x_long");
        let library = Program::read(&say("lib", true)).expect("a library's tests");
        assert_eq!(library.form("m::x_long").name(), "host-tests::m::x_long");
        assert_eq!(Program::read(&say("test", false)), None);
        assert_eq!(Program::read(r#"{"reason":"build-finished"}"#), None);
        assert_eq!(Program::read("no JSON"), None);
    }
}
