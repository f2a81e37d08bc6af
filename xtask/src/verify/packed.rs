//! The crates as a registry would hold them: described, packed, built from what was packed, and one of them
//! used by a program that knows nothing of this workspace.

use std::fs;
use std::path::{Path, PathBuf};

use super::bench::Bench;
use super::manifests;
use super::summary::Outcome;
use crate::arm_image::ArmImage;
use crate::toolchain::Toolchain;
use crate::{Failure, Result, TARGET, process};

/// What is meant for others; none of them needs std.
pub(super) const CRATES: [&str; 4] = ["rarma-core", "rarma-fit", "rarma-rigs", "rarma-box"];
/// The program, as a folder of the workspace.
const PROGRAM: &str = "tools/outside";
/// Lines of code that it may have.
const MOST_LINES: usize = 20;

/// The check.
pub(super) fn check(bench: &mut Bench<'_>) -> Result<Outcome> {
    let metadata =
        process::output(&mut bench.cargo(&["metadata", "--no-deps", "--format-version", "1"]))?;
    let objections = manifests::objections(&metadata, &CRATES)
        .ok_or_else(|| Failure::new("cannot read `cargo metadata`"))?;
    if !objections.is_empty() {
        let why = format!("\n  {}", objections.join("\n  "));
        return Err(Failure::new("manifests are not fit to be published").because(why));
    }
    // What is not committed yet is packed as well.
    let mut package = bench.cargo(&["package", "--allow-dirty", "--quiet"]);
    for name in CRATES {
        package.args(["--package", name]);
    }
    bench.pass_if(&mut package)?;
    let toolchain = match bench.toolchain() {
        Ok(toolchain) => toolchain,
        Err(why) => return Ok(Outcome::Partly(format!("packed, but {why}"))),
    };
    let program = Program::lay_out(bench.workspace.root(), bench.workspace.target_dir())?;
    let image = program.build(bench, &toolchain)?;
    let bytes = ArmImage::read(&image)?.flash_bytes();
    Ok(Outcome::Passed(format!(
        "{} crates; a program of {} lines is {bytes} bytes of flash",
        CRATES.len(),
        program.lines
    )))
}

/// The program, laid out beside the unpacked crate.
struct Program {
    folder: PathBuf,
    lines: usize,
}

impl Program {
    fn lay_out(root: &Path, target: &Path) -> Result<Self> {
        let version = env!("CARGO_PKG_VERSION");
        let core = target.join("package").join(format!("rarma-core-{version}"));
        let (from, folder) = (root.join(PROGRAM), target.join("outside"));
        let cannot = |what: &Path, why| {
            Failure::new(format!("cannot lay out {}", what.display())).because(why)
        };
        fs::create_dir_all(folder.join("src")).map_err(|why| cannot(&folder, why))?;
        for name in ["src/main.rs", "memory.x"] {
            let to = folder.join(name);
            fs::copy(from.join(name), &to).map_err(|why| cannot(&to, why))?;
        }
        let manifest = fs::read_to_string(from.join("Cargo.toml.in"))
            .map_err(|why| cannot(&from, why))?
            .replace("RARMA_CORE", &core.display().to_string());
        let to = folder.join("Cargo.toml");
        fs::write(&to, manifest).map_err(|why| cannot(&to, why))?;
        // The versions of the workspace, which are known to be there.
        let lock = folder.join("Cargo.lock");
        fs::copy(root.join("Cargo.lock"), &lock).map_err(|why| cannot(&lock, why))?;
        let code = from.join("src/main.rs");
        let lines = fs::read_to_string(&code).map_err(|why| cannot(&code, why))?;
        let lines = lines.lines().filter(|line| !line.trim().is_empty()).count();
        if lines > MOST_LINES {
            return Err(Failure::new(format!(
                "{} has {lines} lines, {MOST_LINES} were promised",
                code.display()
            )));
        }
        Ok(Self { folder, lines })
    }

    fn build(&self, bench: &Bench<'_>, toolchain: &Toolchain) -> Result<PathBuf> {
        let mut cargo = toolchain.cargo(bench.workspace);
        cargo
            .current_dir(&self.folder)
            .args(["build", "--release", "--target", TARGET, "--config"])
            .arg(format!(
                "target.{TARGET}.rustflags=[\"-Clink-arg=-Tlink.x\", \"-L{}\"]",
                self.folder.display()
            ))
            .env("CARGO_TARGET_DIR", self.folder.join("target"));
        process::run(&mut cargo)?;
        Ok(self
            .folder
            .join("target")
            .join(TARGET)
            .join("release/outside"))
    }
}
