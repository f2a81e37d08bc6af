//! The program that fuzzes: built once, started for each target.

use std::env;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Log, Run, folder_of};
use crate::toolchain::packages;
use crate::{Failure, Result, Workspace, process};

/// No case may take longer, s.
pub const TIMEOUT_S: u32 = 20;
/// Nor leave the program larger, MB.
const MEMORY_MB: u32 = 1024;
/// Longest case, bytes.
const LONGEST: u32 = 4096;
/// Debian's package with a C++ compiler.
const CXX_PACKAGE: &str = "g++";

/// Counters at every edge, a table of their places, and the operands of comparisons: what
/// `cargo fuzz` asks of a compiler, less the address sanitizer, which only nightly has.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
-Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
-Cllvm-args=-sanitizer-coverage-trace-compares --cfg fuzzing";

/// The program, built.
#[derive(Debug, Clone)]
pub struct Engine {
    program: PathBuf,
    corpus: PathBuf,
    target_dir: PathBuf,
}

impl Engine {
    /// Whether the machine has what the build needs; installed if it may be.
    ///
    /// # Errors
    /// There is no C++ compiler, and none can be installed.
    pub fn needs() -> Result<()> {
        let compiler = env::var("CXX").unwrap_or_else(|_| "c++".to_owned());
        if process::find_program(&compiler).is_some() {
            return Ok(());
        }
        packages::install(&[CXX_PACKAGE]).map_err(|failure| {
            Failure::new("libFuzzer needs a C++ compiler")
                .because(failure)
                .advise(format!(
                    "on Debian, as root: {}",
                    packages::install_line(&[CXX_PACKAGE])
                ))
        })
    }

    /// Builds the program.
    ///
    /// # Errors
    /// There is no C++ compiler, or the build fails.
    pub fn build(workspace: &Workspace) -> Result<Self> {
        Self::needs()?;
        let host = host()?;
        let built = workspace.target_dir().join("fuzz/build");
        let mut cargo = process::host_cargo(workspace);
        cargo
            .args(["build", "--quiet", "--package", "fuzz", "--bin", "fuzz"])
            .args(["--features", "libfuzzer", "--profile", "fuzz"])
            // With a target named, build scripts and macros are spared the counters.
            .args(["--target", &host])
            .env("CARGO_TARGET_DIR", &built)
            .env("RUSTFLAGS", COVERAGE);
        println!("{}", process::spelled(&cargo));
        process::run(&mut cargo)?;
        Ok(Self {
            program: built.join(host).join("fuzz/fuzz"),
            corpus: workspace.root().join("fuzz/corpus"),
            target_dir: workspace.target_dir().to_path_buf(),
        })
    }

    /// Runs one target for so long, or until it finds something.
    ///
    /// # Errors
    /// It cannot be started, or its files cannot be written.
    pub fn run(&self, target: &str, seconds: u64, seed: u32) -> Result<Run> {
        let folder = folder_of(&self.target_dir, target);
        let own = folder.join("corpus");
        let failed = |path: &Path, why| {
            Failure::new(format!("cannot write {}", path.display())).because(why)
        };
        fs::create_dir_all(&own).map_err(|why| failed(&own, why))?;
        let before = cases_in(&folder);
        let log = folder.join("log");
        let out = File::create(&log).map_err(|why| failed(&log, why))?;
        let err = out.try_clone().map_err(|why| failed(&log, why))?;
        let scratch = Scratch::new(target)?;
        let mut command = self.command(target, &scratch)?;
        command
            .arg(format!("-max_total_time={seconds}"))
            .arg(format!("-seed={seed}"))
            .arg(format!("-max_len={LONGEST}"))
            .arg("-print_final_stats=1")
            .arg(&own)
            .arg(self.corpus.join(target))
            .stdout(out)
            .stderr(err);
        let status = process::status(&mut command)?;
        let text = fs::read(&log).map_err(|why| failed(&log, why))?;
        let found = Log::read(&String::from_utf8_lossy(&text));
        let new = cases_in(&folder)
            .into_iter()
            .find(|case| !before.contains(case));
        let defect = match (status.success(), new) {
            (true, _) => None,
            (false, Some(case)) => Some((case, log)),
            // The same case as in an earlier run, or none at all.
            (false, None) => {
                let case = found.case.clone().unwrap_or_else(|| log.clone());
                Some((case, log))
            }
        };
        Ok(Run {
            target: target.to_owned(),
            log: found,
            defect,
        })
    }

    /// Runs one case again, its words on the terminal; the exit code of the program.
    ///
    /// # Errors
    /// It cannot be started.
    pub fn again(&self, target: &str, case: &Path) -> Result<u8> {
        let scratch = Scratch::new(target)?;
        let mut command = self.command(target, &scratch)?;
        let status = process::status(command.arg(case))?;
        Ok(process::exit_code(status))
    }

    fn command(&self, target: &str, scratch: &Scratch) -> Result<Command> {
        let folder = folder_of(&self.target_dir, target);
        fs::create_dir_all(&folder).map_err(|why| {
            Failure::new(format!("cannot write {}", folder.display())).because(why)
        })?;
        let dictionary = folder.join("dictionary");
        let mut command = Command::new(&self.program);
        command
            .env("RARMA_FUZZ_TARGET", target)
            .env("RARMA_FUZZ_DICTIONARY", &dictionary)
            .env("TMPDIR", &scratch.0)
            .arg(format!("-dict={}", dictionary.display()))
            .arg(format!("-timeout={TIMEOUT_S}"))
            .arg(format!("-rss_limit_mb={MEMORY_MB}"))
            .arg(format!("-artifact_prefix={}/", folder.display()));
        Ok(command)
    }
}

/// A folder for the files of a run; it goes with it. In memory where there is such a place:
/// a reader that takes a path gets ten thousand files a second.
struct Scratch(PathBuf);

impl Scratch {
    fn new(target: &str) -> Result<Self> {
        let memory = Path::new("/dev/shm");
        let base = if memory.is_dir() {
            memory.to_path_buf()
        } else {
            env::temp_dir()
        };
        let folder = base.join(format!("rarma-fuzz-{}-{target}", std::process::id()));
        fs::create_dir_all(&folder).map_err(|why| {
            Failure::new(format!("cannot write {}", folder.display())).because(why)
        })?;
        Ok(Self(folder))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What is left would be memory lost until the next start of the machine.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Cases that libFuzzer kept because they show something.
fn cases_in(folder: &Path) -> Vec<PathBuf> {
    let kinds = ["crash-", "timeout-", "oom-", "slow-unit-", "leak-"];
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .filter(|entry| {
            let name = entry.file_name();
            kinds
                .iter()
                .any(|kind| name.to_string_lossy().starts_with(kind))
        })
        .map(|entry| entry.path())
        .collect()
}

/// The triple of this machine.
fn host() -> Result<String> {
    let version = process::output(Command::new("rustc").arg("-vV"))?;
    let line = version.lines().find_map(|line| line.strip_prefix("host: "));
    line.map(str::to_owned)
        .ok_or_else(|| Failure::new("`rustc -vV` names no host"))
}
