//! A Python apart from that of the machine, with the packages of a list.

use crate::{Failure, Result, Workspace, process};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A Python environment apart from that of the machine.
pub(crate) struct Environment {
    folder: PathBuf,
}

impl Environment {
    /// Makes one with the packages of a list; one that has them already is used again.
    pub(crate) fn make(python: &Path, folder: PathBuf, packages: &Path) -> Result<Self> {
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

    /// The interpreter of one below the target folder, with the packages of a list of the workspace.
    ///
    /// # Errors
    /// There is no Python, or the packages cannot be had.
    pub(crate) fn kept(workspace: &Workspace, name: &str, packages: &str) -> Result<PathBuf> {
        let packages = workspace.root().join(packages);
        let Some(python) = process::find_program("python3") else {
            return Err(Failure::new(format!(
                "no python3 for the packages of {}",
                packages.display()
            ))
            .advise("install Python 3.9 or later with venv and pip"));
        };
        let folder = workspace.target_dir().join(name);
        Ok(Self::make(&python, folder, &packages)?.program())
    }

    /// A new one with a wheel and what it depends on, each time.
    pub(crate) fn of_wheel(python: &Path, folder: PathBuf, wheel: &Path) -> Result<Self> {
        let environment = Self { folder };
        let mut venv = Command::new(python);
        venv.args(["-m", "venv", "--clear"])
            .arg(&environment.folder);
        run(&mut venv)?;
        environment.install(&[], wheel)?;
        Ok(environment)
    }

    /// Installs a wheel, or with `-r` the packages of a list.
    pub(crate) fn install(&self, options: &[&str], what: &Path) -> Result<()> {
        let mut pip = self.python();
        pip.args([
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            // Most of it is never imported; what is, is compiled then.
            "--no-compile",
        ]);
        run(pip.args(options).arg(what))
    }

    /// Its interpreter, to be given what to run; what it compiles of the modules it imports is kept in the environment, and
    /// not beside the project's own files.
    pub(crate) fn python(&self) -> Command {
        let mut python = Command::new(self.program());
        python.env("PYTHONPYCACHEPREFIX", self.folder.join("compiled"));
        python
    }

    /// Its interpreter.
    pub(crate) fn program(&self) -> PathBuf {
        let place = match cfg!(windows) {
            true => "Scripts/python.exe",
            false => "bin/python",
        };
        self.folder.join(place)
    }
}

/// Runs a command and says which.
///
/// # Errors
/// It fails.
pub(crate) fn run(command: &mut Command) -> Result<()> {
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
