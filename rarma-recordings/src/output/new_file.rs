//! A file that takes its name when it is whole.

use super::place::{folder_of, hold, resolved, sync_folder, there};
use super::{WriteError, failed};
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile, TempPath};

/// A file in the making. It is written beside its place under a name of its own
/// (`.rarma-….part`) and renamed when it is whole and kept; dropped, it is gone, and what was there
/// before is as it was. A device or a pipe is written as it is.
#[derive(Debug)]
pub struct NewFile {
    /// As it was named.
    path: PathBuf,
    /// Where the name leads.
    end: PathBuf,
    part: Part,
}

#[derive(Debug)]
enum Part {
    Beside(NamedTempFile),
    Device(File),
}

impl NewFile {
    /// Begins a file.
    ///
    /// # Errors
    /// Its folder cannot be written, it is a folder itself, or a record is being written
    /// into it.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        let cannot = |why: &io::Error| failed(path, "open", why);
        let end = resolved(path);
        let old = there(&end)?;
        if old.as_ref().is_some_and(|meta| meta.is_dir()) {
            return Err(cannot(&io::ErrorKind::IsADirectory.into()));
        }
        let part = if old.as_ref().is_some_and(|meta| !meta.is_file()) {
            let device = OpenOptions::new().write(true).open(&end);
            Part::Device(device.map_err(|why| cannot(&why))?)
        } else {
            drop(hold(&end)?);
            let part = beside(folder_of(&end)).map_err(|why| cannot(&why))?;
            if let Some(meta) = old {
                let same = part.as_file().set_permissions(meta.permissions());
                same.map_err(|why| cannot(&why))?;
            }
            Part::Beside(part)
        };
        Ok(Self {
            path: path.to_path_buf(),
            end,
            part,
        })
    }

    /// All of its bytes at once; it is still to be kept.
    ///
    /// # Errors
    /// As [`Self::create`], or it cannot be written.
    pub fn whole(path: &Path, bytes: &[u8]) -> Result<Whole, WriteError> {
        let mut new = Self::create(path)?;
        let written = new.write_all(bytes);
        written.map_err(|why| failed(path, "write", &why))?;
        new.done()
    }

    /// As it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file, to be written from elsewhere, too.
    pub(super) fn file(&self) -> &File {
        match &self.part {
            Part::Beside(part) => part.as_file(),
            Part::Device(file) => file,
        }
    }

    /// It is whole, and safely on disk.
    ///
    /// # Errors
    /// It cannot be written to its end.
    pub fn done(self) -> Result<Whole, WriteError> {
        let part = match self.part {
            Part::Device(_) => None,
            Part::Beside(part) => {
                let synced = part.as_file().sync_all();
                synced.map_err(|why| failed(&self.path, "write", &why))?;
                Some(part.into_temp_path())
            }
        };
        Ok(Whole {
            path: self.path,
            end: self.end,
            part,
        })
    }
}

/// A file that is whole and waits for its name; dropped, it is gone.
#[derive(Debug)]
pub struct Whole {
    path: PathBuf,
    end: PathBuf,
    part: Option<TempPath>,
}

impl Whole {
    /// Gives it its name. See [`keep`].
    ///
    /// # Errors
    /// It cannot be put into its place.
    pub fn keep(self) -> Result<(), WriteError> {
        keep(vec![self])
    }
}

/// Gives several files their names, all of which are safely on disk: where the disk is full
/// it does not come to this, and every old one is as it was.
///
/// # Errors
/// One cannot be put into its place.
pub fn keep(files: Vec<Whole>) -> Result<(), WriteError> {
    for new in files {
        let Some(part) = new.part else { continue };
        // Until it is done: one that begins a record now is told that the file is taken.
        let held = hold(&new.end)?;
        part.persist(&new.end)
            .map_err(|why| failed(&new.path, "rename", &why.error))?;
        drop(held);
        sync_folder(&new.end);
    }
    Ok(())
}

/// A whole file at once.
///
/// # Errors
/// See [`NewFile::create`] and [`keep`].
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), WriteError> {
    NewFile::whole(path, bytes.as_ref())?.keep()
}

/// Several files of a folder, which is made if it is not there: all, or none.
///
/// # Errors
/// See [`NewFile::create`] and [`keep`].
pub fn write_all(
    folder: &Path,
    files: impl IntoIterator<Item = (String, Vec<u8>)>,
) -> Result<(), WriteError> {
    super::folder(folder)?;
    let mut all = Vec::new();
    for (name, bytes) in files {
        all.push(NewFile::whole(&folder.join(name), &bytes)?);
    }
    keep(all)
}

fn beside(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".rarma-").suffix(".part");
    #[cfg(unix)]
    {
        // As any new file: what the user's mask leaves of it.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file().flush()
    }
}

impl Seek for NewFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file().seek(to)
    }
}
