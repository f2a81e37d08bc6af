//! The model of the STM32G474 (tools/g474-model): its emulator installed, one run, what it saw.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use super::registers;
use crate::{Failure, Result, Workspace, process};

/// Packages that tests use, never linked or shipped: the emulator (GPL), and readers of
/// universal files (MIT) and MATLAB files (BSD) that are not ours.
const PACKAGES: [&str; 3] = ["unicorn==2.1.4", "pyuff==2.5.8", "scipy>=1.13,<2"];

/// The model, ready to run.
#[derive(Debug, Clone)]
pub struct Model {
    program: PathBuf,
    packages: PathBuf,
}

/// What a run is given.
#[derive(Debug, Clone, Default)]
pub struct Run<'a> {
    /// Seconds to run.
    pub seconds: f64,
    /// Count instructions from this moment on.
    pub count_from: Option<f64>,
    /// Codes of the first microphone.
    pub microphone: Option<&'a Path>,
    /// One PWM period in so many is made.
    pub bridge_every: u32,
}

impl Model {
    /// The model, the packages installed into the build directory if need be.
    ///
    /// # Errors
    /// When there is no Python, or the package cannot be had.
    pub fn find_or_make(workspace: &Workspace) -> Result<Self> {
        let model = Self {
            program: workspace.root().join("tools/g474-model/run.py"),
            packages: workspace.target_dir().join("python"),
        };
        if process::find_program("python3").is_none() {
            return Err(Failure::new("no python3 for the model of the chip")
                .advise("install Python 3.9 or later with pip"));
        }
        if !model.has_packages() {
            model.install_packages()?;
        }
        registers::find_or_make(workspace, &model.packages)?;
        Ok(model)
    }

    fn install_packages(&self) -> Result<()> {
        eprintln!(
            "model: installing {} into {}",
            PACKAGES.join(", "),
            self.packages.display()
        );
        let mut pip = Command::new("python3");
        pip.args(["-m", "pip", "install", "--quiet", "--upgrade", "--target"])
            .arg(&self.packages)
            .args(PACKAGES);
        process::run(&mut pip).map_err(|failure| {
            Failure::new("cannot install the packages of the model and the tests")
                .because(failure)
                .advise(format!("python3 -m pip install {}", PACKAGES.join(" ")))
        })
    }

    fn has_packages(&self) -> bool {
        let mut python = self.python();
        process::output(python.args(["-c", "import unicorn, pyuff, scipy"])).is_ok()
    }

    fn python(&self) -> Command {
        let mut python = Command::new("python3");
        python.env("PYTHONPATH", &self.packages);
        python
    }

    /// The variables by which tests find the model.
    pub fn tell(&self, tests: &mut Command) {
        tests
            .env("RARMA_G474_MODEL", &self.program)
            .env("RARMA_G474_PACKAGES", &self.packages);
    }

    /// Runs an image and returns what was seen.
    ///
    /// # Errors
    /// When the model cannot be started, or the image gets stuck.
    pub fn run(&self, image: &Path, folder: &Path, run: &Run<'_>) -> Result<Value> {
        let mut command = self.python();
        command
            .arg(&self.program)
            .args([image, folder])
            .args(["--seconds", &run.seconds.to_string()])
            .args(["--bridge-every", &run.bridge_every.max(1).to_string()]);
        if let Some(from) = run.count_from {
            command.args(["--count-from", &from.to_string()]);
        }
        if let Some(codes) = run.microphone {
            command.arg("--microphone-1").arg(codes);
        }
        process::run(&mut command)?;
        let path = folder.join("run.json");
        let text = std::fs::read_to_string(&path)
            .map_err(|why| Failure::new(format!("cannot read {}", path.display())).because(why))?;
        serde_json::from_str(&text)
            .map_err(|why| Failure::new(format!("{} is no JSON", path.display())).because(why))
    }
}
