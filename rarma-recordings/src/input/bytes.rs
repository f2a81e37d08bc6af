//! A file or a pipe, read forward with a look ahead.

use super::InputError;
use std::io::{ErrorKind, Read};

/// Read at once.
const BLOCK: usize = 1 << 16;

/// Bytes of a source in order; a few of the next may be looked at.
pub(super) struct Bytes {
    source: Box<dyn Read>,
    buffer: Vec<u8>,
    from: usize,
    at: u64,
    ended: bool,
}

impl Bytes {
    pub(super) fn new(source: Box<dyn Read>) -> Self {
        Self {
            source,
            buffer: Vec::with_capacity(2 * BLOCK),
            from: 0,
            at: 0,
            ended: false,
        }
    }

    /// Place of the next byte.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// What has been read and not yet taken.
    pub(super) fn waiting(&self) -> &[u8] {
        &self.buffer[self.from..]
    }

    /// Reads what there is, once; false at the end.
    pub(super) fn more(&mut self) -> Result<bool, InputError> {
        if self.ended {
            return Ok(false);
        }
        self.buffer.drain(..self.from);
        self.from = 0;
        let before = self.buffer.len();
        self.buffer.resize(before + BLOCK, 0);
        let read = loop {
            match self.source.read(&mut self.buffer[before..]) {
                Err(why) if why.kind() == ErrorKind::Interrupted => {}
                other => break other,
            }
        };
        self.buffer
            .truncate(before + read.as_ref().copied().unwrap_or(0));
        let read = read.map_err(|why| InputError::from_io(&why))?;
        self.ended = read == 0;
        Ok(read > 0)
    }

    /// The next `n` bytes, fewer at the end; they stay.
    pub(super) fn look(&mut self, n: usize) -> Result<&[u8], InputError> {
        while self.waiting().len() < n && self.more()? {}
        let n = n.min(self.waiting().len());
        Ok(&self.buffer[self.from..self.from + n])
    }

    /// Goes on by `n` of the waiting bytes.
    pub(super) fn take(&mut self, n: usize) {
        let n = n.min(self.waiting().len());
        self.from += n;
        self.at += n as u64;
    }

    /// Goes on by `n` bytes; false if there are fewer.
    pub(super) fn skip(&mut self, mut n: u64) -> Result<bool, InputError> {
        while n > 0 {
            if self.waiting().is_empty() && !self.more()? {
                return Ok(false);
            }
            let here = (self.waiting().len() as u64).min(n);
            self.take(here as usize);
            n -= here;
        }
        Ok(true)
    }
}
