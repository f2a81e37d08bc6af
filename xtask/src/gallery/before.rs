//! The gallery to compare with: a folder of an earlier one, or a commit whose program draws it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::list::Shown;
use super::made::{Failing, Gallery};
use crate::{Failure, Result, Workspace, process};

/// The gallery of a folder, or of a commit.
///
/// # Errors
/// It is neither, or that commit's program does not build.
pub fn find(workspace: &Workspace, name: &str, shown: &[Shown], new: &Path) -> Result<Gallery> {
    let folder = Path::new(name);
    if folder.is_dir() {
        if same(folder, new) {
            return Err(Failure::usage(format!("{name} is where the new one goes"))
                .advise("name another folder for the new one"));
        }
        return Gallery::read(folder);
    }
    let mut ask = git(workspace);
    ask.args(["rev-parse", "--verify", "--quiet"])
        .arg(format!("{name}^{{commit}}"));
    let commit = process::output(&mut ask).map_err(|_| {
        Failure::usage(format!("`{name}` is neither a folder nor a commit"))
            .advise("see `git log` for commits")
    })?;
    drawn_by(workspace, commit.trim(), shown)
}

fn same(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

fn git(workspace: &Workspace) -> Command {
    let mut git = Command::new("git");
    git.current_dir(workspace.root());
    git
}

/// Builds the program of a commit, in a work tree of its own, and has it draw.
fn drawn_by(workspace: &Workspace, commit: &str, shown: &[Shown]) -> Result<Gallery> {
    let around = workspace.target_dir().join("gallery-before");
    let folder = around.join(commit);
    // A commit draws the same picture every time.
    if let Ok(gallery) = Gallery::read(&folder)
        && shown.iter().all(|shown| gallery.has(shown))
    {
        return Ok(gallery);
    }
    let tree = WorkTree::new(workspace, around.join("tree"), commit)?;
    let target = around.join("target");
    let mut build = Command::new("cargo");
    build
        .args(["build", "--release", "--quiet", "-p", "rarma-cli"])
        .current_dir(&tree.folder)
        .env("CARGO_TARGET_DIR", &target);
    if has_plant(&tree.folder) {
        build.args(["--features", "fleet"]);
    }
    eprintln!("gallery before: building {commit}");
    process::run(&mut build)?;
    Gallery::make(
        &target.join("release/rarma"),
        shown,
        (&folder, &around.join("work")),
        Failing::PassedOver,
    )
}

/// Whether that commit's program draws pictures of a plant, which it is built with on request only.
fn has_plant(tree: &Path) -> bool {
    let manifest = fs::read_to_string(tree.join("rarma-cli/Cargo.toml"));
    manifest.is_ok_and(|text| text.lines().any(|line| line.starts_with("fleet = ")))
}

/// Another work tree of this repository, gone with this.
struct WorkTree<'a> {
    workspace: &'a Workspace,
    folder: PathBuf,
}

impl<'a> WorkTree<'a> {
    fn new(workspace: &'a Workspace, folder: PathBuf, commit: &str) -> Result<Self> {
        let tree = Self { workspace, folder };
        tree.remove();
        let mut add = git(workspace);
        add.args(["worktree", "add", "--quiet", "--detach", "--force"]);
        process::output(add.arg(&tree.folder).arg(commit))?;
        Ok(tree)
    }

    fn remove(&self) {
        let mut remove = git(self.workspace);
        remove
            .args(["worktree", "remove", "--force"])
            .arg(&self.folder);
        // One that is not there needs no removing; one that stays is replaced the next time.
        let _ = process::output(&mut remove);
    }
}

impl Drop for WorkTree<'_> {
    fn drop(&mut self) {
        self.remove();
    }
}
