//! Files for readers that take a path.

use std::cell::OnceCell;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

thread_local! {
    static FOLDER: OnceCell<TempDir> = const { OnceCell::new() };
}

/// The folder of this thread's files, in memory where the machine has such a place.
///
/// # Panics
/// There is no room for a temporary folder.
pub fn folder() -> PathBuf {
    FOLDER.with(|cell| {
        let made = cell.get_or_init(|| tempfile::tempdir().expect("a temporary folder"));
        made.path().to_path_buf()
    })
}

/// A file of this name and content; the next of the same name takes its place.
///
/// # Panics
/// It cannot be written.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    fs::write(&path, bytes).expect("a file in a temporary folder");
    path
}
