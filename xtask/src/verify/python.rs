//! The Python package (`rarma-py`): linted, built as a wheel, installed into a clean environment
//! and tested there against the command; its notebooks run in another one.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::summary::Outcome;
use crate::{Failure, Result, Workspace, process};

/// The package's own manifest: a workspace of its own.
pub const MANIFEST: &str = "rarma-py/Cargo.toml";
/// What builds the wheel, and what tests it, with their versions.
const BUILDS: &str = "rarma-py/requirements-build.txt";
const TESTS: &str = "rarma-py/requirements-test.txt";
/// What the notebooks need, and what runs them.
const NOTEBOOKS: &str = "rarma-py/notebooks/requirements.txt";
const RUN_NOTEBOOKS: &str = "rarma-py/notebooks/run.py";
/// Tells tests and notebooks where the command is.
const PROGRAM: &str = "RARMA_PROGRAM";

/// The check.
///
/// # Errors
/// The package does not build, or a test fails. Without Python, or where its packages cannot be
/// had, the check is skipped.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let Some(python) = process::find_program("python3") else {
        return Ok(Outcome::Skipped(
            "no python3 (install Python 3.9 or later with venv and pip)".to_owned(),
        ));
    };
    let folder = workspace.target_dir().join("py");
    let needed = [("build", BUILDS), ("test", TESTS)];
    let environments = needed.map(|(name, packages)| {
        Environment::make(&python, folder.join(name), &workspace.root().join(packages))
    });
    let (builds, tests) = match environments {
        [Ok(builds), Ok(tests)] => (builds, tests),
        [Err(failure), _] | [_, Err(failure)] => {
            return Ok(Outcome::Skipped(failure.to_string()));
        }
    };
    let target = folder.join("target");
    let mut clippy = process::host_cargo(workspace);
    clippy
        .args(["clippy", "--release", "--locked", "--manifest-path"])
        .args([MANIFEST, "--", "--deny", "warnings"]);
    run(clippy.env("CARGO_TARGET_DIR", &target))?;
    let wheel = wheel(workspace, &builds, &folder, &target)?;
    let program = process::rarma(workspace)?;
    tests.install(&["--no-deps", "--force-reinstall"], &wheel)?;
    let mut pytest = tests.python();
    pytest
        .args(["-m", "pytest", "-q", "--tb=short"])
        .current_dir(workspace.root().join("rarma-py"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env(PROGRAM, &program);
    run(&mut pytest)?;
    let size = fs::metadata(&wheel).map_or(0, |about| about.len());
    let told = format!(
        "{}, {:.1} MB",
        wheel.file_name().unwrap_or_default().to_string_lossy(),
        size as f64 / 1e6
    );
    let list = workspace.root().join(NOTEBOOKS);
    match Environment::make(&python, folder.join("notebooks"), &list) {
        Ok(environment) => {
            run_notebooks(workspace, &environment, &wheel, &program)?;
            Ok(Outcome::Passed(told))
        }
        // Packages of others, which a new Python may not have yet.
        Err(failure) => Ok(Outcome::Partly(format!(
            "{told}; the notebooks were not run: {failure}"
        ))),
    }
}

fn run_notebooks(
    workspace: &Workspace,
    environment: &Environment,
    wheel: &Path,
    program: &Path,
) -> Result<()> {
    environment.install(&["--no-deps", "--force-reinstall"], wheel)?;
    let mut notebooks = environment.python();
    notebooks
        .arg(workspace.root().join(RUN_NOTEBOOKS))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env(PROGRAM, program);
    run(&mut notebooks)
}

/// Builds the one wheel.
fn wheel(
    workspace: &Workspace,
    builds: &Environment,
    folder: &Path,
    target: &Path,
) -> Result<PathBuf> {
    let wheels = folder.join("wheels");
    let cannot = |why| Failure::new(format!("cannot empty {}", wheels.display())).because(why);
    if wheels.exists() {
        fs::remove_dir_all(&wheels).map_err(cannot)?;
    }
    let mut maturin = builds.python();
    maturin
        .args(["-m", "maturin", "build", "--release", "--locked"])
        .args(["--manifest-path", MANIFEST, "--out"])
        .arg(&wheels)
        .current_dir(workspace.root())
        .env("CARGO_TARGET_DIR", target);
    run(&mut maturin)?;
    let found = fs::read_dir(&wheels).ok().and_then(|entries| {
        let mut paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        paths.find(|path| path.extension().is_some_and(|e| e == "whl"))
    });
    found.ok_or_else(|| Failure::new(format!("no wheel in {}", wheels.display())))
}

fn run(command: &mut Command) -> Result<()> {
    println!("{}", process::spelled(command));
    process::run(command)
}

/// A list of packages, those of the lists it names included.
fn listed(packages: &Path) -> Result<String> {
    let mut list = crate::page::read(packages)?;
    let folder = packages.parent().unwrap_or(Path::new(""));
    let others: Vec<PathBuf> = list
        .lines()
        .filter_map(|line| line.strip_prefix("-r "))
        .map(|other| folder.join(other.trim()))
        .collect();
    for other in others {
        list.push_str(&listed(&other)?);
    }
    Ok(list)
}

/// A Python environment apart from that of the machine.
pub(super) struct Environment {
    folder: PathBuf,
}

impl Environment {
    /// Makes one with the packages of a list; one that has them already is used again.
    pub(super) fn make(python: &Path, folder: PathBuf, packages: &Path) -> Result<Self> {
        let environment = Self { folder };
        let list = listed(packages)?;
        let stamp = environment.folder.join("packages.txt");
        if fs::read_to_string(&stamp).is_ok_and(|had| had == list) {
            return Ok(environment);
        }
        let cannot = |failure: Failure| {
            Failure::new(format!(
                "no Python environment with the packages of {}: is there a network, and does python3 have venv and pip?",
                packages.display()
            ))
            .because(failure)
        };
        let mut venv = Command::new(python);
        venv.args(["-m", "venv", "--clear"])
            .arg(&environment.folder);
        run(&mut venv).map_err(cannot)?;
        environment.install(&["-r"], packages).map_err(cannot)?;
        fs::write(&stamp, list).map_err(|why| {
            Failure::new(format!("cannot write {}", stamp.display())).because(why)
        })?;
        Ok(environment)
    }

    fn install(&self, options: &[&str], what: &Path) -> Result<()> {
        let mut pip = self.python();
        pip.args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
        ]);
        run(pip.args(options).arg(what))
    }

    fn python(&self) -> Command {
        Command::new(self.program())
    }

    /// Its interpreter.
    pub(super) fn program(&self) -> PathBuf {
        let place = match cfg!(windows) {
            true => "Scripts/python.exe",
            false => "bin/python",
        };
        self.folder.join(place)
    }
}
