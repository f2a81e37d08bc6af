//! A file for the decoder, as long as it says it is.
//!
//! The reader of MPEG-4 gives up where a box is longer than the file. One that was cut off
//! is read as far as it goes: it is told the length that the boxes promise, and finds the
//! end of the file when it is there.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use symphonia::core::io::MediaSource;

/// A file, or a pipe with the name of one.
pub(super) struct Source {
    file: File,
    /// Length in bytes; none of a pipe.
    length: Option<u64>,
}

impl Source {
    pub(super) fn new(file: File, length: Option<u64>) -> Self {
        Self { file, length }
    }
}

impl Read for Source {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.file.read(bytes)
    }
}

impl Seek for Source {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match (to, self.length) {
            (SeekFrom::End(from), Some(length)) => {
                let at = length.checked_add_signed(from);
                let at = at.ok_or(io::ErrorKind::InvalidInput)?;
                self.file.seek(SeekFrom::Start(at))
            }
            (to, _) => self.file.seek(to),
        }
    }
}

impl MediaSource for Source {
    fn is_seekable(&self) -> bool {
        self.length.is_some()
    }

    fn byte_len(&self) -> Option<u64> {
        self.length
    }
}
