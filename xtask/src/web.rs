//! `cargo xtask web [--serve [PORT]]`: the page in a browser, as a folder that any web server or
//! none can hold.

mod serve;

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};

use crate::toolchain::{Toolchain, WEB};
use crate::{Failure, Result, Workspace, process};

pub use serve::Server;

/// The page's own files.
const PAGE: &str = "rarma-web/page";
/// What the program is called there.
const PROGRAM: &str = "rarma.wasm";
/// The file that keeps all others for when there is no network.
const KEEPER: &str = "sw.js";
/// In it, what is replaced by a list of all files and by what tells this build from others.
const FILES_HERE: &str = "/* files */";
const BUILD_HERE: &str = "/* build */";
/// The style sheet, and in it what is replaced by the colours of the report.
const STYLE: &str = "style.css";
const COLOURS_HERE: &str = "/* colours */";
/// The report's style sheet, and where its colours end.
const REPORT_STYLE: &str = "rarma-pictures/src/style.css";
const COLOURS_END: &str = "* { box-sizing";

/// The page, built.
#[derive(Debug, Clone)]
pub struct Page {
    folder: PathBuf,
    bytes: u64,
    program_bytes: u64,
}

impl Page {
    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Its size and where it lies, for people.
    pub fn description(&self) -> String {
        format!(
            "{}: {:.0} kB, {:.0} kB of it {PROGRAM}",
            self.folder.display(),
            self.bytes as f64 / 1e3,
            self.program_bytes as f64 / 1e3
        )
    }
}

/// The compiler for browsers.
///
/// # Errors
/// There is none, and none can be had.
pub fn toolchain(workspace: &Workspace) -> Result<Toolchain> {
    Toolchain::find_or_make(workspace, WEB)
}

/// Builds it.
///
/// # Errors
/// There is no compiler for browsers, the build fails, or the folder cannot be written.
pub fn build(workspace: &Workspace) -> Result<Page> {
    let toolchain = toolchain(workspace)?;
    eprintln!("page: {}", toolchain.description());
    let built = workspace.target_dir().join("web-build");
    let mut cargo = toolchain.cargo(workspace);
    cargo
        .args(["build", "--quiet", "--package", "rarma-web", "--lib"])
        .args(["--profile", "web", "--target", WEB.triple])
        .env("CARGO_TARGET_DIR", &built);
    process::run(&mut cargo)?;
    let program = built.join(WEB.triple).join("web/rarma_web.wasm");
    lay_out(workspace, &program)
}

/// The page's files and the program in a folder of their own.
fn lay_out(workspace: &Workspace, program: &Path) -> Result<Page> {
    let folder = workspace.target_dir().join("web");
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|why| cannot("remove", &folder, &why))?;
    }
    fs::create_dir_all(&folder).map_err(|why| cannot("make", &folder, &why))?;
    let from = workspace.root().join(PAGE);
    let entries = fs::read_dir(&from).map_err(|why| cannot("list", &from, &why))?;
    let mut files: Vec<(String, PathBuf)> = entries
        .flatten()
        .map(|entry| {
            (
                entry.file_name().to_string_lossy().into_owned(),
                entry.path(),
            )
        })
        .collect();
    files.push((PROGRAM.to_owned(), program.to_path_buf()));
    files.sort();
    let mut page = Page {
        folder: folder.clone(),
        bytes: 0,
        program_bytes: 0,
    };
    let mut build = DefaultHasher::new();
    let mut keeper = String::new();
    for (name, path) in &files {
        let mut bytes = fs::read(path).map_err(|why| cannot("read", path, &why))?;
        if name == STYLE {
            bytes = coloured(workspace, &bytes)?.into_bytes();
        }
        (name, &bytes).hash(&mut build);
        page.bytes += bytes.len() as u64;
        match name.as_str() {
            PROGRAM => page.program_bytes = bytes.len() as u64,
            KEEPER => {
                keeper = String::from_utf8_lossy(&bytes).into_owned();
                continue;
            }
            _ => {}
        }
        write(&folder.join(name), bytes)?;
    }
    let names = files.iter().map(|(name, _)| name.as_str());
    let keeper = filled(&keeper, names, build.finish())?;
    write(&folder.join(KEEPER), keeper.into_bytes())?;
    Ok(page)
}

fn write(to: &Path, bytes: Vec<u8>) -> Result<()> {
    fs::write(to, bytes).map_err(|why| cannot("write", to, &why))
}

/// The style sheet with the colours of the report, so that they are said once.
fn coloured(workspace: &Workspace, style: &[u8]) -> Result<String> {
    let path = workspace.root().join(REPORT_STYLE);
    let report = fs::read_to_string(&path).map_err(|why| cannot("read", &path, &why))?;
    let style = String::from_utf8_lossy(style);
    match report.split_once(COLOURS_END) {
        Some((colours, _)) if style.contains(COLOURS_HERE) => {
            Ok(style.replace(COLOURS_HERE, colours))
        }
        _ => Err(Failure::new(format!(
            "no `{COLOURS_END}` in {REPORT_STYLE}, or no {COLOURS_HERE} in {STYLE}"
        ))),
    }
}

/// The keeper with the names of all other files, and the number of this build.
fn filled<'a>(keeper: &str, names: impl Iterator<Item = &'a str>, build: u64) -> Result<String> {
    for mark in [FILES_HERE, BUILD_HERE] {
        if !keeper.contains(mark) {
            return Err(Failure::new(format!("{KEEPER} has no place {mark}")));
        }
    }
    let names: Vec<String> = names
        .filter(|name| *name != KEEPER)
        .map(|name| format!("'{name}'"))
        .collect();
    Ok(keeper
        .replace(FILES_HERE, &names.join(", "))
        .replace(BUILD_HERE, &format!("'{build:016x}'")))
}

fn cannot(verb: &str, path: &Path, why: &std::io::Error) -> Failure {
    Failure::new(format!("cannot {verb} {}", path.display())).because(why)
}

/// The command `web`.
///
/// # Errors
/// Wrong arguments, or as [`build`].
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let port = match words[..] {
        [] => None,
        ["--serve"] => Some(8080),
        ["--serve", port] => Some(port.parse().map_err(|_| {
            Failure::usage(format!("`{port}` is no port")).advise("cargo xtask web --serve 8080")
        })?),
        _ => {
            return Err(
                Failure::usage("wrong arguments").advise("cargo xtask web [--serve [PORT]]")
            );
        }
    };
    let page = build(workspace)?;
    println!("{}", page.description());
    if let Some(port) = port {
        let server = Server::start(page.folder(), port)?;
        println!("{} (Ctrl-C ends)", server.address());
        server.wait();
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keeper_lists_every_file_but_itself() {
        let keeper = "const B = /* build */; const F = [/* files */];";
        let names = ["index.html", "sw.js", "rarma.wasm"];
        assert_eq!(
            filled(keeper, names.into_iter(), 255),
            Ok("const B = '00000000000000ff'; const F = ['index.html', 'rarma.wasm'];".to_owned())
        );
        assert!(filled("const F = [];", names.into_iter(), 1).is_err());
    }
}
