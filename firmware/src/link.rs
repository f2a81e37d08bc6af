//! Frames out: numbers them, writes them, counts those the link did not take.

use embedded_io::Write;
use rarma_box::wire::{MAX_FRAME, Telemetry, encode};

/// The session of a job over a recording: there is one run and one stream.
pub const RECORDING_SESSION: u32 = 1;

/// Sends telemetry as frames.
#[derive(Debug, Default)]
pub struct FrameSender {
    sequence: u32,
    dropped: u32,
}

impl FrameSender {
    /// Sends one message. A message the link refuses is counted and left behind:
    /// listening goes on, and the gap in the sequence numbers tells the host.
    pub fn send<L: Write>(&mut self, link: &mut L, message: &Telemetry) {
        let mut buffer = [0u8; MAX_FRAME];
        let sent = match encode(message, RECORDING_SESSION, self.sequence, &mut buffer) {
            Ok(frame) => link.write_all(frame).is_ok(),
            Err(_) => false,
        };
        if !sent {
            self.dropped = self.dropped.saturating_add(1);
        }
        self.sequence = self.sequence.wrapping_add(1);
    }

    /// Frames the link did not take.
    pub fn dropped(&self) -> u32 {
        self.dropped
    }
}
