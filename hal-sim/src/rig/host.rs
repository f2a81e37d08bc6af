//! A host on the other end of the link: heartbeats, commands, and what it hears.

use rarma_core::wire::{Command, Deframer, MAX_FRAME, NO_SESSION, Telemetry, encode};

/// A message and when it came.
#[derive(Debug, Clone, PartialEq)]
pub struct Heard {
    /// World time, µs.
    pub at_us: u64,
    /// The run of the box that said it.
    pub session: u32,
    /// Sequence number.
    pub sequence: u32,
    /// The message.
    pub message: Telemetry,
}

/// The host.
#[derive(Debug)]
pub struct SimHost {
    deframer: Deframer,
    /// The session of the last frame that came; commands are made for it.
    pub session: u32,
    sequence: u32,
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
    expected: Option<u32>,
}

impl Default for SimHost {
    fn default() -> Self {
        Self {
            deframer: Deframer::default(),
            session: NO_SESSION,
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
    pub fn command(&mut self, command: &Command) -> (u32, Vec<u8>) {
        let mut buffer = [0; MAX_FRAME];
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        let frame = encode(command, self.session, sequence, &mut buffer).map(<[u8]>::to_vec);
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

    /// Learns the session from the first frame of bytes that have not been taken yet.
    pub(super) fn greet(&mut self, bytes: &[u8]) {
        let mut deframer = Deframer::default();
        let head = bytes
            .iter()
            .find_map(|&byte| deframer.push::<Telemetry>(byte).and_then(Result::ok));
        if let Some((head, _)) = head {
            self.session = head.session;
        }
    }

    /// Bytes have come.
    pub fn hears(&mut self, now_us: u64, bytes: &[u8]) {
        for &byte in bytes {
            match self.deframer.push::<Telemetry>(byte) {
                None => {}
                Some(Err(_)) => self.broken += 1,
                Some(Ok((head, message))) => {
                    self.whole += 1;
                    // In another session the numbers begin again.
                    let same = head.session == self.session;
                    if let Some(expected) = self.expected.filter(|_| same) {
                        self.missing += u64::from(head.sequence.wrapping_sub(expected));
                    }
                    self.session = head.session;
                    self.expected = Some(head.sequence.wrapping_add(1));
                    if self.keep_all {
                        self.heard.push(Heard {
                            at_us: now_us,
                            session: head.session,
                            sequence: head.sequence,
                            message,
                        });
                    }
                }
            }
        }
    }
}
