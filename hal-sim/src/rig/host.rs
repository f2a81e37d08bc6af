//! A host on the other end of the link: heartbeats, commands, and what it hears.

use rarma_core::wire::{Command, Deframer, MAX_FRAME, Telemetry, encode};

/// A message and when it came.
#[derive(Debug, Clone, PartialEq)]
pub struct Heard {
    /// World time, µs.
    pub at_us: u64,
    /// Sequence number.
    pub sequence: u16,
    /// The message.
    pub message: Telemetry,
}

/// The host.
#[derive(Debug)]
pub struct SimHost {
    deframer: Deframer,
    sequence: u16,
    next_heartbeat_us: u64,
    /// Heartbeats are sent this often, µs; none: never.
    pub heartbeat_us: Option<u64>,
    /// Everything that came since it was taken last.
    pub heard: Vec<Heard>,
    /// Raw samples are not kept in `heard` unless asked for.
    pub keep_all: bool,
    /// Frames that were broken.
    pub broken: u64,
    /// Frames that came whole.
    pub whole: u64,
    /// Frames missing by their numbers.
    pub missing: u64,
    expected: Option<u16>,
}

impl Default for SimHost {
    fn default() -> Self {
        Self {
            deframer: Deframer::default(),
            sequence: 0,
            next_heartbeat_us: 0,
            heartbeat_us: Some(100_000),
            heard: Vec::new(),
            keep_all: true,
            broken: 0,
            whole: 0,
            missing: 0,
            expected: None,
        }
    }
}

impl SimHost {
    /// The bytes of a command, and its sequence number.
    pub fn command(&mut self, command: &Command) -> (u16, Vec<u8>) {
        let mut buffer = [0; MAX_FRAME];
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        let frame = encode(command, sequence, &mut buffer).map(<[u8]>::to_vec);
        (sequence, frame.unwrap_or_default())
    }

    /// The heartbeat that is due, if one is.
    pub fn heartbeat(&mut self, now_us: u64) -> Option<Vec<u8>> {
        let every = self.heartbeat_us?;
        if now_us < self.next_heartbeat_us {
            return None;
        }
        self.next_heartbeat_us = now_us + every;
        Some(self.command(&Command::Heartbeat).1)
    }

    /// The box has started anew: its numbers begin again.
    pub fn expect_anew(&mut self) {
        self.expected = None;
    }

    /// Bytes have come.
    pub fn hears(&mut self, now_us: u64, bytes: &[u8]) {
        for &byte in bytes {
            match self.deframer.push::<Telemetry>(byte) {
                None => {}
                Some(Err(_)) => self.broken += 1,
                Some(Ok((sequence, message))) => {
                    self.whole += 1;
                    if let Some(expected) = self.expected {
                        self.missing += u64::from(sequence.wrapping_sub(expected));
                    }
                    self.expected = Some(sequence.wrapping_add(1));
                    if self.keep_all {
                        self.heard.push(Heard {
                            at_us: now_us,
                            sequence,
                            message,
                        });
                    }
                }
            }
        }
    }
}
