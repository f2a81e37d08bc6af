//! Where a name leads, and who else is there.

use super::{WriteError, WriteProblem, failed};
use std::fs::{self, File, Metadata, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// Links that are followed before it is called a circle.
const LINKS: usize = 40;

/// The file that a name leads to through symbolic links, there or not: it is what is
/// replaced, and the links stay.
pub(super) fn resolved(path: &Path) -> PathBuf {
    let mut at = path.to_path_buf();
    for _ in 0..LINKS {
        let Ok(next) = fs::read_link(&at) else { break };
        at = match at.parent() {
            Some(folder) => folder.join(next),
            None => next,
        };
    }
    at
}

/// The folder a file lies in.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Whether both names lead to one file, by whatever links. Files that are not there are one
/// if their folders and names are.
pub(super) fn same(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(of_a), Ok(of_b)) => one(&of_a, &of_b, a, b),
        (Err(_), Err(_)) => place(a).is_some_and(|of_a| place(b) == Some(of_a)),
        _ => false,
    }
}

#[cfg(unix)]
pub(super) fn one(a: &Metadata, b: &Metadata, _: &Path, _: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
pub(super) fn one(_: &Metadata, _: &Metadata, a: &Path, b: &Path) -> bool {
    place(a).is_some_and(|of_a| place(b) == Some(of_a))
}

fn place(path: &Path) -> Option<PathBuf> {
    let end = resolved(path);
    let folder = fs::canonicalize(folder_of(&end)).ok()?;
    Some(folder.join(end.file_name()?))
}

/// Holds a file that is about to be replaced, so that no record is begun in it meanwhile;
/// none if there is no such file.
///
/// # Errors
/// A record is being written into it.
pub(super) fn hold(path: &Path) -> Result<Option<File>, WriteError> {
    // One that may not be read is not locked by us either.
    let Ok(file) = File::open(path) else {
        return Ok(None);
    };
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Err(taken(path)),
        // Not every disk has locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(Some(file)),
    }
}

/// What is said where somebody else records.
pub(super) fn taken(path: &Path) -> WriteError {
    WriteError::new(
        WriteProblem::System,
        path,
        "open",
        "another program is recording into it",
        "name another file, or end that one",
    )
}

/// Writes what the folder knows of its files to disk, where that can be done.
pub(super) fn sync_folder(path: &Path) {
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
}

/// Metadata of what is there; none if nothing is.
pub(super) fn there(path: &Path) -> Result<Option<Metadata>, WriteError> {
    match fs::metadata(path) {
        Ok(meta) => Ok(Some(meta)),
        Err(why) if why.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(why) => Err(failed(path, "open", &why)),
    }
}
