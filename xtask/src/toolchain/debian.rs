//! A sysroot for the target, built once from Debian's compiler and its sources.
//!
//! Debian ships no libraries for bare-metal ARM and for browsers, but the sources of its
//! compiler's own. They are compiled once into a sysroot of our own; a wrapper then calls
//! Debian's rustc with that sysroot, so that building an image needs no unstable flag.
//! It is built again when the compiler changes.

use std::fs::{self, File};
use std::io::Write as _;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use super::{Target, packages};
use crate::{Failure, Result, Workspace, process};

/// Compiler, cargo, the library's sources, the host's library.
pub const PACKAGES: &[&str] = &[
    "rustc-web",
    "cargo-web",
    "rust-web-src",
    "libstd-rust-web-dev",
];

/// Debian's cargo.
pub const CARGO: &str = "/usr/bin/cargo";

const RUSTC: &str = "/usr/bin/rustc";
const RUSTLIB: &str = "/usr/lib/rustlib";

/// A finished sysroot.
#[derive(Debug, Clone)]
pub struct Sysroot {
    target: Target,
    folder: PathBuf,
}

impl Sysroot {
    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Debian's rustc, called with this sysroot.
    pub fn rustc(&self) -> PathBuf {
        self.folder.join("bin/rustc")
    }

    fn stamp(&self) -> PathBuf {
        self.folder.join("made-with")
    }

    fn library(&self) -> PathBuf {
        self.folder
            .join("lib/rustlib")
            .join(self.target.triple)
            .join("lib")
    }
}

/// The sysroot in the build directory, installed and built first if need be.
///
/// # Errors
/// When packages cannot be installed, do not match each other, or the build fails.
pub fn find_or_build_sysroot(workspace: &Workspace, target: Target) -> Result<Sysroot> {
    let _lock = lock(workspace.target_dir(), target)?;
    packages::install(PACKAGES)?;
    check_sources_match_compiler()?;
    let linker = find_linker()?;
    let version = process::output(Command::new(RUSTC).arg("-vV"))?;
    let made_with = format!("{version}linker: {}\n", linker.display());

    let sysroot = Sysroot {
        target,
        folder: workspace.target_dir().join(target.folder),
    };
    if fs::read_to_string(sysroot.stamp()).is_ok_and(|stamp| stamp == made_with) {
        return Ok(sysroot);
    }
    let host = field(&version, "host: ")?;
    build(&sysroot, host, &linker).map_err(|failure| {
        Failure::new(format!(
            "cannot build the sysroot {}",
            sysroot.folder.display()
        ))
        .because(failure)
    })?;
    write(&sysroot.stamp(), &made_with)?;
    Ok(sysroot)
}

/// Two builds at once wait for each other here until the guard is dropped.
fn lock(folder: &Path, target: Target) -> Result<File> {
    let path = folder.join(format!("{}.lock", target.folder));
    fs::create_dir_all(folder)
        .and_then(|()| File::create(&path))
        .and_then(|file| file.lock().map(|()| file))
        .map_err(|why| Failure::new(format!("cannot lock {}", path.display())).because(why))
}

fn check_sources_match_compiler() -> Result<()> {
    let compiler = packages::version("rustc-web");
    let sources = packages::version("rust-web-src");
    if compiler == sources {
        return Ok(());
    }
    let name = |version: Option<String>| version.unwrap_or_else(|| "missing".to_owned());
    Err(
        Failure::new("Debian's compiler and its library sources differ in version")
            .because(format!(
                "rustc-web is {}, rust-web-src is {}",
                name(compiler),
                name(sources)
            ))
            .advise(format!(
                "bring both up to date: {}",
                packages::install_line(PACKAGES)
            )),
    )
}

/// The linker that rustup's toolchains bring; Debian's `lld` serves as well.
fn find_linker() -> Result<PathBuf> {
    let mut rustc = Command::new("rustc");
    process::forget_outer_cargo(&mut rustc).args(["--print", "target-libdir"]);
    let beside_library = process::output(&mut rustc)
        .ok()
        .and_then(|library| Some(Path::new(library.trim()).parent()?.join("bin/rust-lld")))
        .filter(|linker| linker.is_file());
    beside_library
        .or_else(|| process::find_program("rust-lld"))
        .or_else(|| process::find_program("lld"))
        .ok_or_else(|| {
            Failure::new("no linker for boards and browsers")
                .because("neither a rustup toolchain's rust-lld nor lld is here")
                .advise(format!("install one: {}", packages::install_line(&["lld"])))
        })
}

fn field<'a>(version: &'a str, name: &str) -> Result<&'a str> {
    version
        .lines()
        .find_map(|line| line.strip_prefix(name))
        .ok_or_else(|| Failure::new(format!("`{RUSTC} -vV` has no line `{name}`")).because(version))
}

fn build(sysroot: &Sysroot, host: &str, linker: &Path) -> Result<()> {
    let begun = Instant::now();
    let Target {
        triple, libraries, ..
    } = sysroot.target;
    eprintln!("toolchain: building {libraries} for {triple}, once (about half a minute)");
    let folder = &sysroot.folder;
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(|why| cannot("remove", folder, &why))?;
    }
    make_folder(&sysroot.library())?;
    lay_out_host_side(sysroot, host, linker)?;

    let seed = folder.join("build");
    build_libraries(&seed, sysroot.target)?;
    copy_libraries(
        &seed.join("target").join(triple).join("release/deps"),
        &sysroot.library(),
    )?;
    fs::remove_dir_all(&seed).map_err(|why| cannot("remove", &seed, &why))?;
    eprintln!("toolchain: built in {:.0} s", begun.elapsed().as_secs_f32());
    Ok(())
}

/// Links to Debian's host library and sources, the linker, and the rustc wrapper.
fn lay_out_host_side(sysroot: &Sysroot, host: &str, linker: &Path) -> Result<()> {
    let rustlib = sysroot.folder.join("lib/rustlib");
    let host_bin = rustlib.join(host).join("bin");
    make_folder(&host_bin)?;
    make_folder(&sysroot.folder.join("bin"))?;
    let links = [
        (
            Path::new(RUSTLIB).join(host).join("lib"),
            rustlib.join(host).join("lib"),
        ),
        (Path::new(RUSTLIB).join("src"), rustlib.join("src")),
        (linker.to_path_buf(), host_bin.join("rust-lld")),
    ];
    for (to, link) in links {
        symlink(&to, &link).map_err(|why| cannot("make the link", &link, &why))?;
    }
    let wrapper = sysroot.rustc();
    let folder = sysroot.folder.display();
    write(
        &wrapper,
        &format!("#!/bin/sh\nexec {RUSTC} --sysroot '{folder}' \"$@\"\n"),
    )?;
    fs::set_permissions(&wrapper, fs::Permissions::from_mode(0o755))
        .map_err(|why| cannot("make executable", &wrapper, &why))
}

/// Builds an empty crate whose only purpose is that cargo builds the libraries for it.
fn build_libraries(seed: &Path, target: Target) -> Result<()> {
    make_folder(&seed.join("src"))?;
    write(
        &seed.join("Cargo.toml"),
        "[package]\nname = \"seed\"\nversion = \"0.0.0\"\nedition = \"2021\"\n[workspace]\n\
         [profile.release]\nopt-level = 3\npanic = \"abort\"\ndebug = 1\n",
    )?;
    write(&seed.join("src/lib.rs"), "#![no_std]\n")?;
    let mut cargo = Command::new(CARGO);
    process::forget_outer_cargo(&mut cargo)
        .current_dir(seed)
        .args([
            "build",
            "--quiet",
            "--release",
            &format!("-Zbuild-std={}", target.libraries),
            "--target",
            target.triple,
        ])
        .env("CARGO_TARGET_DIR", seed.join("target"))
        .env("RUSTC", RUSTC)
        // Allows -Z in this one build; the bitcode lets images use fat LTO.
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTFLAGS", "-Cembed-bitcode=yes")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    process::run(&mut cargo)
}

fn copy_libraries(from: &Path, to: &Path) -> Result<()> {
    let entries = fs::read_dir(from).map_err(|why| cannot("list", from, &why))?;
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default();
        let is_library = path
            .extension()
            .is_some_and(|extension| extension == "rlib");
        if is_library && !name.to_string_lossy().starts_with("libseed") {
            fs::copy(&path, to.join(name)).map_err(|why| cannot("copy", &path, &why))?;
        }
    }
    Ok(())
}

fn make_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|why| cannot("make the folder", path, &why))
}

fn write(path: &Path, text: &str) -> Result<()> {
    File::create(path)
        .and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|why| cannot("write", path, &why))
}

fn cannot(verb: &str, path: &Path, why: &std::io::Error) -> Failure {
    Failure::new(format!("cannot {verb} {}", path.display())).because(why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_host_from_the_compilers_version() {
        let version =
            "rustc 1.90.0\nbinary: rustc\nhost: x86_64-unknown-linux-gnu\nrelease: 1.90.0\n";
        assert_eq!(field(version, "host: "), Ok("x86_64-unknown-linux-gnu"));
        assert!(field(version, "LLVM version: ").is_err());
    }
}
