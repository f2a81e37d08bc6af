//! The wire to a box, as the gateway sees it. Ports, sockets and files are the program's.

use rarma_box::wire::{Head, LinkKey, Telemetry};
use std::path::Path;

/// What was lost on the way, since the link was opened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames that came whole.
    pub whole: u64,
    /// Frames that came broken.
    pub broken: u64,
    /// Frames that did not come, by their numbers.
    pub missing: u64,
    /// Version of frames that another version of the protocol made.
    pub foreign: Option<u8>,
}

/// An open wire.
pub trait Link: Send {
    /// Hands on what has come; waits for at most some 50 ms. False: there is nothing more to come (a
    /// recording has ended).
    ///
    /// # Errors
    /// The other end has gone; in one line.
    fn listen(&mut self, with: &mut dyn FnMut(Head, Telemetry)) -> Result<bool, String>;

    /// Sends a frame.
    ///
    /// # Errors
    /// The other end has gone; in one line.
    fn send(&mut self, frame: &[u8]) -> Result<(), String>;

    /// Whether there is somebody who could answer; of a recording there is not.
    fn answers(&self) -> bool;

    /// What was lost.
    fn counts(&self) -> Counts;
}

/// Who opens wires and reads keys.
pub trait Open: Send + Sync {
    /// Opens what `port` names.
    ///
    /// # Errors
    /// It cannot be opened; in one line.
    fn open(&self, port: &str, baud: u32) -> Result<Box<dyn Link>, String>;

    /// Reads the key of a link.
    ///
    /// # Errors
    /// No such file, or no key in it; in one line, without a digit of it.
    fn key(&self, path: &Path) -> Result<LinkKey, String>;
}
