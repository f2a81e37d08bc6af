//! Before a command begins: nothing is written onto what it reads.

use super::place::{folder_of, hold, resolved, same, there};
use super::{WriteError, WriteProblem, failed};
use std::io;
use std::path::{Path, PathBuf};

/// What a command reads and writes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    /// Files that are read.
    reads: Vec<PathBuf>,
    writes: Vec<Written>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Written {
    option: &'static str,
    path: PathBuf,
    /// Its folder is made where it is not there.
    makes_folder: bool,
    /// It is appended to.
    record: bool,
}

impl Files {
    /// Adds files that are read; names that are no files do no harm.
    #[must_use]
    pub fn read(mut self, paths: impl IntoIterator<Item = impl Into<PathBuf>>) -> Self {
        self.reads.extend(paths.into_iter().map(Into::into));
        self
    }

    /// Adds a file that an option has written.
    #[must_use]
    pub fn file(self, option: &'static str, path: Option<&PathBuf>) -> Self {
        self.written(option, path.cloned(), false, false)
    }

    /// Adds a record that an option has appended to.
    #[must_use]
    pub fn record(self, option: &'static str, path: Option<&PathBuf>) -> Self {
        self.written(option, path.cloned(), false, true)
    }

    /// Adds files of these names that an option has written into a folder.
    #[must_use]
    pub fn folder(
        mut self,
        option: &'static str,
        folder: Option<&PathBuf>,
        names: &[&str],
    ) -> Self {
        for name in names {
            self = self.written(option, folder.map(|f| f.join(name)), true, false);
        }
        self
    }

    fn written(
        mut self,
        option: &'static str,
        path: Option<PathBuf>,
        makes_folder: bool,
        record: bool,
    ) -> Self {
        self.writes.extend(path.map(|path| Written {
            option,
            path,
            makes_folder,
            record,
        }));
        self
    }
}

/// Refuses what could only spoil a file, before anything is done.
///
/// # Errors
/// Something would be written onto what is read, or two outputs into one file
/// ([`WriteProblem::Clash`]). A folder is not there, or another program records into the file.
pub fn check(files: &Files) -> Result<(), WriteError> {
    for (k, written) in files.writes.iter().enumerate() {
        let (option, path) = (written.option, &written.path);
        let usage = |what: &str| {
            Err(WriteError {
                option: Some(option),
                ..WriteError::new(WriteProblem::Clash, path, "", what, "name another file")
            })
        };
        if is_device(path) {
            continue;
        }
        if files
            .reads
            .iter()
            .any(|read| read.is_file() && same(read, path))
        {
            return usage("it is what is read");
        }
        if let Some(other) = files.writes[..k].iter().find(|o| same(&o.path, path)) {
            return usage(&format!("{} writes it, too", other.option));
        }
        possible(written)?;
    }
    Ok(())
}

fn possible(written: &Written) -> Result<(), WriteError> {
    let end = resolved(&written.path);
    let folder = folder_of(&end);
    let cannot = |file: &Path, kind: io::ErrorKind| Err(failed(file, "open", &kind.into()));
    match there(folder) {
        Ok(None) if written.makes_folder => return Ok(()),
        Ok(None) => return cannot(&written.path, io::ErrorKind::NotFound),
        Ok(Some(meta)) if !meta.is_dir() => return cannot(folder, io::ErrorKind::NotADirectory),
        Ok(Some(_)) => {}
        Err(why) => return Err(why),
    }
    if there(&end)?.is_some_and(|meta| meta.is_dir()) {
        return cannot(&written.path, io::ErrorKind::IsADirectory);
    }
    if !written.record {
        hold(&end)?;
    }
    Ok(())
}

/// Neither a file nor a folder: it may be read and written at once.
fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}
