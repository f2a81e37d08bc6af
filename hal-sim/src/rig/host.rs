//! A host on the other end of the link: heartbeats, commands, and what it hears.

use rarma_box::wire::{Command, Deframer, LinkKey, MAX_FRAME, Speaker, Telemetry};

/// Control that is free is asked for again after so long, µs: a frame may be lost.
const ASK_AGAIN_US: u64 = 300_000;

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
    /// What it has to say, in the words of the link.
    pub speaker: Speaker,
    next_heartbeat_us: u64,
    /// Heartbeats are sent this often while it is in control, µs; none: never.
    pub heartbeat_us: Option<u64>,
    /// Takes control whenever nobody has it.
    pub takes_control: bool,
    asked: Option<(u32, u64)>,
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
    expected: Option<(u32, u32)>,
}

impl Default for SimHost {
    fn default() -> Self {
        Self::new(1, None)
    }
}

impl SimHost {
    /// A host of this number, with or without the key.
    pub fn new(own: u32, key: Option<LinkKey>) -> Self {
        Self {
            deframer: Deframer::default(),
            speaker: Speaker::new(own, key),
            next_heartbeat_us: 0,
            heartbeat_us: Some(100_000),
            takes_control: true,
            asked: None,
            heard: Vec::new(),
            keep_all: true,
            broken: 0,
            whole: 0,
            missing: 0,
            expected: None,
        }
    }

    /// The bytes of a command, and its sequence number.
    pub fn command(&mut self, command: &Command) -> (u32, Vec<u8>) {
        let mut buffer = [0; MAX_FRAME];
        let frame = self.speaker.frame(command, &mut buffer);
        frame.map_or((0, Vec::new()), |(n, bytes)| (n, bytes.to_vec()))
    }

    /// What it says by itself: it takes control that is free, and sends the heartbeat that is
    /// due.
    pub fn by_itself(&mut self, now_us: u64) -> Vec<u8> {
        if self.takes_control && self.speaker.is_free() {
            let turn = self.speaker.control().map_or(0, |c| c.turn);
            let waits = |(asked, at_us)| asked == turn && now_us < at_us + ASK_AGAIN_US;
            if self.asked.is_some_and(waits) {
                return Vec::new();
            }
            self.asked = Some((turn, now_us));
            let command = self.speaker.take();
            return command.map_or(Vec::new(), |c| self.command(&c).1);
        }
        match self.heartbeat_us {
            Some(every) if self.speaker.in_control() && now_us >= self.next_heartbeat_us => {
                self.next_heartbeat_us = now_us + every;
                self.command(&Command::Heartbeat).1
            }
            _ => Vec::new(),
        }
    }

    /// The session of the last frame that came.
    pub fn session(&self) -> u32 {
        self.speaker.session()
    }

    /// Learns session and turn from bytes that are still to be heard.
    pub(super) fn greet(&mut self, bytes: &[u8]) {
        let mut deframer = Deframer::default();
        for &byte in bytes {
            if let Some(Ok((head, message))) = deframer.push::<Telemetry>(byte) {
                self.speaker.hears(&head, &message);
            }
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
                    if let Some((session, number)) = self.expected
                        && session == head.session
                    {
                        self.missing += u64::from(head.sequence.wrapping_sub(number));
                    }
                    self.expected = Some((head.session, head.sequence.wrapping_add(1)));
                    self.speaker.hears(&head, &message);
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
