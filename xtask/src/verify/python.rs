//! The Python package (`rarma-py`): linted, built as a wheel and tested against the command in an
//! environment with what the tests need; installed as a user does into an empty one; and run beside
//! the packages of others, with its notebooks, in a third.

use std::fs;
use std::path::{Path, PathBuf};

use super::summary::Outcome;
use crate::python_environment::{Environment, run};
use crate::{Failure, Result, Workspace, process};

/// The package's own manifest: a workspace of its own.
pub const MANIFEST: &str = "rarma-py/Cargo.toml";
/// Below the folder of what is built.
const FOLDER: &str = "py";
/// Environments by their names, and the lists of their packages: what builds the wheel, what tests it, and what the
/// notebooks need.
const BUILDS: (&str, &str) = ("build", "rarma-py/requirements-build.txt");
const TESTS: (&str, &str) = ("test", "rarma-py/requirements-test.txt");
const NOTEBOOKS: (&str, &str) = ("notebooks", "rarma-py/notebooks/requirements.txt");
/// What runs the notebooks.
const RUN_NOTEBOOKS: &str = "rarma-py/notebooks/run.py";
/// Those that rarma is compared with: one sensor, and several. Each ends with 1 where rarma is not as
/// near as it states.
const COMPARE: &str = "rarma-py/compare";
const COMPARE_SEVERAL: &str = "rarma-py/compare/several.py";
/// Of the first, what takes seconds.
const SHORT: [&str; 4] = ["--check", "--seeds=20", "--cases=4", "--limit-s=5"];
/// The page whose first block of Python is the first thing that a user runs.
const PAGE: &str = "docs/python.md";
/// A recording of a shop for the notebook that takes one, where it is there: file, speed (1/min) and
/// teeth, of `labels.json` beside it.
const SHOP: [&str; 3] = [
    "../shared/data/recordings/rahimi_mill_sound/combined_chatter6567.wav",
    "3230",
    "4",
];
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
    let folder = workspace.target_dir().join(FOLDER);
    let of = |packages| environment(workspace, &python, packages);
    let (builds, tests) = match [BUILDS, TESTS].map(of) {
        [Ok(builds), Ok(tests)] => (builds, tests),
        [Err(failure), _] | [_, Err(failure)] => {
            return Ok(Outcome::Skipped(failure.to_string()));
        }
    };
    let program = process::rarma(workspace)?;
    let target = folder.join("target");
    let mut clippy = process::host_cargo(workspace);
    clippy
        .args(["clippy", "--release", "--locked", "--manifest-path"])
        .args([MANIFEST, "--", "--deny", "warnings"]);
    run(clippy.env("CARGO_TARGET_DIR", &target))?;
    let wheel = wheel(workspace, &builds, &folder, &target)?;
    tests.install(&["--no-deps", "--force-reinstall"], &wheel)?;
    let mut pytest = tests.python();
    pytest
        .args(["-m", "pytest", "-q", "--tb=short"])
        .current_dir(workspace.root().join("rarma-py"))
        .env(PROGRAM, &program);
    run(&mut pytest)?;
    let size = fs::metadata(&wheel).map_or(0, |about| about.len());
    let told = format!(
        "{}, {:.1} MB",
        wheel.file_name().unwrap_or_default().to_string_lossy(),
        size as f64 / 1e6
    );
    let mut left_out = Vec::new();
    // What it depends on may be out of reach.
    match Environment::of_wheel(&python, folder.join("clean"), &wheel) {
        Ok(clean) => first_minutes(workspace, &clean)?,
        Err(failure) => left_out.push(format!("not installed as a user does: {failure}")),
    }
    match of(NOTEBOOKS) {
        Ok(environment) => {
            environment.install(&["--no-deps", "--force-reinstall"], &wheel)?;
            beside_others(workspace, &environment)?;
            run_notebooks(workspace, &environment, &program)?;
        }
        // Packages of others, which a new Python may not have yet.
        Err(failure) => left_out.push(format!("notebooks and comparison were not run: {failure}")),
    }
    Ok(match left_out.is_empty() {
        true => Outcome::Passed(told),
        false => Outcome::Partly(format!("{told}; {}", left_out.join("; "))),
    })
}

/// The environment with the packages of a list.
fn environment(
    workspace: &Workspace,
    python: &Path,
    (name, packages): (&str, &str),
) -> Result<Environment> {
    let folder = workspace.target_dir().join(FOLDER).join(name);
    Environment::make(python, folder, &workspace.root().join(packages))
}

/// The first block of the page, with nothing but the wheel and what it depends on.
fn first_minutes(workspace: &Workspace, clean: &Environment) -> Result<()> {
    let page = crate::page::read(&workspace.root().join(PAGE))?;
    let block =
        first_block(&page).ok_or_else(|| Failure::new(format!("{PAGE} has no block of Python")))?;
    let mut python = clean.python();
    println!(
        "{} -c (the first block of {PAGE})",
        clean.program().display()
    );
    process::run(python.args(["-c", block]))
}

/// The first block of Python of a page.
fn first_block(page: &str) -> Option<&str> {
    let (_, rest) = page.split_once("```python\n")?;
    Some(rest.split_once("```")?.0)
}

fn beside_others(workspace: &Workspace, environment: &Environment) -> Result<()> {
    for (script, options) in [(COMPARE_SEVERAL, &[][..]), (COMPARE, &SHORT[..])] {
        let mut python = environment.python();
        python.arg(workspace.root().join(script)).args(options);
        run(&mut python)?;
    }
    Ok(())
}

fn run_notebooks(workspace: &Workspace, environment: &Environment, program: &Path) -> Result<()> {
    let mut notebooks = environment.python();
    notebooks
        .arg(workspace.root().join(RUN_NOTEBOOKS))
        .env(PROGRAM, program);
    let [recording, rpm, teeth] = SHOP;
    let recording = workspace.root().join(recording);
    if recording.is_file() {
        notebooks
            .env("RARMA_RECORDING", recording)
            .env("RARMA_RPM", rpm)
            .env("RARMA_TEETH", teeth);
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_block_of_the_page_needs_the_package_alone() {
        let workspace = Workspace::locate().expect("the workspace");
        let page = fs::read_to_string(workspace.root().join(PAGE)).expect("the page");
        let block = first_block(&page).expect("a block");
        assert!(block.contains("rarma.RecursiveArma"), "{block}");
        let imports = block.lines().filter(|line| line.starts_with("import "));
        let imports: Vec<&str> = imports.collect();
        assert_eq!(imports, ["import numpy as np", "import rarma"]);
    }
}
