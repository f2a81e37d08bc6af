//! Frames of a box, from wherever they come: decoded and counted.

use rarma_box::wire::{Deframer, FrameError, Head, Telemetry};

/// Takes bytes, gives messages, and counts what is lost.
#[derive(Debug, Default)]
pub struct FrameReader {
    deframer: Deframer,
    /// Session and number of the next frame, if none is lost.
    expected: Option<(u32, u32)>,
    /// Frames that were whole.
    pub whole: u64,
    /// Frames that were not.
    pub broken: u64,
    /// Frames missing by their numbers.
    pub missing: u64,
    /// Runs of the box the frames are of: it was started anew between them.
    pub runs: u64,
    /// Version of frames that another version of the protocol made.
    pub foreign: Option<u8>,
}

impl FrameReader {
    /// Takes bytes; hands on each message with the head of its frame.
    pub fn take(&mut self, bytes: &[u8], mut with: impl FnMut(Head, Telemetry)) {
        for &byte in bytes {
            match self.deframer.push::<Telemetry>(byte) {
                None => {}
                Some(Err(why)) => {
                    self.broken += 1;
                    if let FrameError::Version { found } = why {
                        self.foreign = Some(found);
                    }
                }
                Some(Ok((head, message))) => {
                    self.whole += 1;
                    // In another session the numbers begin again.
                    match self.expected {
                        Some((session, number)) if session == head.session => {
                            let jump = head.sequence.wrapping_sub(number);
                            if jump <= u32::MAX / 2 {
                                self.missing += u64::from(jump);
                            }
                        }
                        _ => self.runs += 1,
                    }
                    self.expected = Some((head.session, head.sequence.wrapping_add(1)));
                    with(head, message);
                }
            }
        }
    }

    /// What was lost, for people; none if nothing was.
    pub fn losses(&self) -> Option<String> {
        if let Some(found) = self.foreign {
            return Some(format!(
                "frames of protocol version {found}; this program speaks {}: use the version of rarma that came with the firmware",
                rarma_box::wire::VERSION
            ));
        }
        (self.broken + self.missing > 0 || self.runs > 1).then(|| {
            let runs = match self.runs {
                0 | 1 => String::new(),
                n => format!(", of {n} runs of the box"),
            };
            format!(
                "{} frames, {} broken, {} missing{runs}",
                self.whole, self.broken, self.missing
            )
        })
    }
}
