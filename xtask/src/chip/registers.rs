//! The register file of the model: made once from two published packages, which are fetched for
//! nothing else, never linked and never shipped (both MIT or Apache-2.0).
//!
//! `stm32-metapac` is what the image's own driver layer is made of; `stm32g4` is made from the
//! maker's SVD file by others. Versions are exact, check sums are those of the workspace's
//! Cargo.lock.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::{Failure, Result, Workspace, page, process};

/// The packages in the order in which `vendor.py` takes them. The versions are in
/// `registers.py` too, which refuses a file that is made from others.
const SOURCES: [(&str, &str); 2] = [("stm32g4", "0.16.0"), ("stm32-metapac", "21.0.0")];

/// The name of the file in the folder of the packages (`registers.py`, `NAME`).
const NAME: &str = "stm32g474re.json";

/// Makes the register file unless one is there that the model can use.
///
/// # Errors
/// When a package cannot be had, or is not laid out as expected.
pub fn find_or_make(workspace: &Workspace, packages: &Path) -> Result<()> {
    let tools = workspace.root().join("tools/g474-model");
    let file = packages.join(NAME);
    let mut judge = Command::new("python3");
    judge.arg(tools.join("registers.py")).arg(&file);
    if process::output(&mut judge).is_ok() {
        return Ok(());
    }
    let names = SOURCES.map(|(name, version)| format!("{name} {version}"));
    eprintln!(
        "model: making its register file from {}",
        names.join(" and ")
    );
    let folders = fetched(workspace)?;
    let mut make = Command::new("python3");
    make.arg(tools.join("vendor.py")).args(folders).arg(&file);
    process::run(&mut make)
}

/// The folders of the packages, fetched as dependencies of a package that is never built.
fn fetched(workspace: &Workspace) -> Result<Vec<PathBuf>> {
    let folder = workspace.target_dir().join("registers");
    let write = |name: &str, text: &str| page::write(&folder.join(name), text);
    std::fs::create_dir_all(folder.join("src"))
        .map_err(|why| Failure::new(format!("cannot make {}", folder.display())).because(why))?;
    let mut manifest = String::from(
        "[package]\nname = \"registers\"\nversion = \"0.0.0\"\nedition = \"2021\"\n\n[workspace]\n\n[dependencies]\n",
    );
    for (name, version) in SOURCES {
        manifest += &format!("{name} = {{ version = \"={version}\", default-features = false }}\n");
    }
    write("Cargo.toml", &manifest)?;
    write("src/lib.rs", "")?;
    // Its check sums are those of this workspace.
    write(
        "Cargo.lock",
        &page::read(&workspace.root().join("Cargo.lock"))?,
    )?;
    let mut cargo = process::host_cargo(workspace);
    cargo
        .args(["metadata", "--format-version", "1", "--manifest-path"])
        .arg(folder.join("Cargo.toml"));
    let text = process::output(&mut cargo).map_err(|failure| {
        Failure::new("cannot fetch the packages of the register file")
            .because(failure)
            .advise("cargo fetch, where crates can be had")
    })?;
    let found: Value = serde_json::from_str(&text)
        .map_err(|why| Failure::new("cargo metadata gave no JSON").because(why))?;
    let folder_of = |wanted: &str| {
        let packages = found["packages"].as_array()?;
        let package = packages.iter().find(|package| package["name"] == wanted)?;
        Some(
            Path::new(package["manifest_path"].as_str()?)
                .parent()?
                .to_owned(),
        )
    };
    SOURCES
        .iter()
        .map(|(name, _)| {
            folder_of(name).ok_or_else(|| Failure::new(format!("cargo metadata has no `{name}`")))
        })
        .collect()
}
