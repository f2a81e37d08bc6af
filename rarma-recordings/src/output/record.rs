//! A record of a box: every byte, as it came.

use super::place::{one, resolved, taken, there};
use super::{WriteError, WriteProblem, failed};
use rarma_box::wire::{Deframer, head};
use std::fmt;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file with no whole frame in so many bytes is no record.
const LOOKED_AT: u64 = 1 << 16;

/// A record that is being written. What is there already stays: a new session is appended.
/// Each write goes to the system at once, so that a program that is killed loses at most the
/// frame it was in.
#[derive(Debug)]
pub struct RecordFile {
    /// As it was named.
    path: PathBuf,
    /// Where the name leads.
    end: PathBuf,
    file: File,
    /// It was not there, and nothing has been written.
    new: bool,
}

impl RecordFile {
    /// Opens a record to append to; one that is not there is made. `notice` is told where the disk
    /// has no locks.
    ///
    /// # Errors
    /// It cannot be written, somebody else records into it, or it is no record.
    pub fn open(path: &Path, notice: impl FnOnce(fmt::Arguments<'_>)) -> Result<Self, WriteError> {
        let cannot = |why: &std::io::Error| failed(path, "open", why);
        let end = resolved(path);
        let old = there(&end)?;
        let device = old.as_ref().is_some_and(|m| !m.is_file() && !m.is_dir());
        let mut options = OpenOptions::new();
        if device {
            options.write(true);
        } else {
            options.read(true).append(true).create(true);
        }
        let file = options.open(&end).map_err(|why| cannot(&why))?;
        let mut record = Self {
            path: path.to_path_buf(),
            end,
            file,
            new: old.is_none(),
        };
        if device {
            return Ok(record);
        }
        match record.file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                // Whose it is now.
                record.new = false;
                return Err(taken(path));
            }
            Err(TryLockError::Error(why)) => {
                notice(format_args!(
                    "{}: it cannot be locked ({why}): see to it that nobody else records into it",
                    path.display()
                ));
            }
        }
        // It may have been replaced between opening and locking.
        let (here, there) = (record.file.metadata(), fs::metadata(&record.end));
        match (here, there) {
            (Ok(here), Ok(there)) if one(&here, &there, &record.end, &record.end) => {}
            _ => {
                record.new = false;
                return Err(taken(path));
            }
        }
        record.go_on()?;
        Ok(record)
    }

    /// Ends the half frame that a record cut short may end in.
    fn go_on(&mut self) -> Result<(), WriteError> {
        let cannot = |why: &std::io::Error| failed(&self.path, "read", why);
        let length = self.file.seek(SeekFrom::End(0));
        let length = length.map_err(|why| cannot(&why))?;
        if length == 0 {
            return Ok(());
        }
        let mut start = Vec::new();
        let mut last = [0];
        self.file
            .seek(SeekFrom::Start(0))
            .and_then(|_| (&self.file).take(LOOKED_AT).read_to_end(&mut start))
            .and_then(|_| self.file.seek(SeekFrom::End(-1)))
            .and_then(|_| self.file.read_exact(&mut last))
            .map_err(|why| cannot(&why))?;
        if !holds_a_frame(&start) {
            return Err(WriteError::new(
                WriteProblem::NoRecord,
                &self.path,
                "open",
                "it is no record of a box, and a record is appended to what is there",
                "name another file",
            ));
        }
        if last != [0] {
            self.write(&[0])?;
        }
        Ok(())
    }

    /// Appends what has come.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        if !bytes.is_empty() {
            self.new = false;
        }
        let written = self.file.write_all(bytes);
        written.map_err(|why| failed(&self.path, "write", &why))
    }

    /// Sees it safely onto the disk.
    ///
    /// # Errors
    /// It cannot be written to its end.
    pub fn end(self) -> Result<(), WriteError> {
        let regular = self.file.metadata().is_ok_and(|meta| meta.is_file());
        if regular {
            let synced = self.file.sync_all();
            synced.map_err(|why| failed(&self.path, "write", &why))?;
        }
        Ok(())
    }
}

impl Drop for RecordFile {
    fn drop(&mut self) {
        // Nothing came: no empty file is left. It is locked, so nobody else has it.
        if self.new {
            let _ = fs::remove_file(&self.end);
        }
    }
}

/// Frames of any version.
fn holds_a_frame(bytes: &[u8]) -> bool {
    let mut deframer = Deframer::default();
    bytes.iter().any(|byte| {
        let frame = deframer.collect(*byte);
        frame.is_some_and(|stuffed| stuffed.is_ok_and(|stuffed| head(stuffed).is_ok()))
    })
}
