//! The link duty's receiving half: bytes in, commands out, as values that the box carries out.
//!
//! Called at every pass. A fixed number of bytes a pass, so that a flood takes time from
//! nobody else.

use crate::board::BoxBoard;
use rarma_box::wire::{
    Answer, Command, Deframer, FrameError, MAX_FRAME, Opened, Refused, Seal, VERSION, open,
};

/// Bytes taken in one pass, and frames looked at in one.
pub(crate) const PASS_BYTES: usize = 128;
pub(crate) const PASS_FRAMES: usize = 4;
/// Passes in a row that were full: a flood.
const FLOOD_PASSES: u32 = 20;
/// Broken frames are told once this many have come.
const GARBAGE_FRAMES: u32 = 3;

/// What has come.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Counts {
    /// Commands answered.
    pub answered: u32,
    /// Of them, refused.
    pub refused: u32,
    /// Of them, not carried out because of their numbers: copies, overtaken, old.
    pub doubled: u32,
    /// Frames that were broken.
    pub garbage: u32,
}

/// A command with what is known of where it comes from.
#[derive(Debug)]
pub(crate) struct Said<'a> {
    pub by: u32,
    pub command: Command,
    pub session: u32,
    pub sequence: u32,
    pub crc: u16,
    pub seal: Seal<'a>,
}

/// What a frame was.
#[derive(Debug)]
pub(crate) enum Came<'a> {
    /// Broken.
    Garbage,
    /// Whole, with this sequence number, and no command of this version.
    Unknown(u32, Refused),
    /// A command.
    Command(Said<'a>),
}

impl<'a> Came<'a> {
    fn of(frame: &Opened<'a>) -> Self {
        let head = frame.head;
        match frame.order() {
            Ok((order, seal)) => Self::Command(Said {
                by: order.by,
                command: order.command,
                session: head.session,
                sequence: head.sequence,
                crc: head.crc,
                seal,
            }),
            Err(FrameError::Version { .. }) => {
                let box_version = VERSION;
                Self::Unknown(head.sequence, Refused::Version { box_version })
            }
            Err(_) => Self::Unknown(head.sequence, Refused::NotACommand),
        }
    }
}

/// Receives bytes and gives the commands in them.
#[derive(Debug, Default)]
pub(crate) struct Commands {
    deframer: Deframer,
    /// Bytes taken from the link and not looked at yet.
    waiting: heapless::Deque<u8, PASS_BYTES>,
    counts: Counts,
    garbage_told: u32,
    full_passes: u32,
}

impl Commands {
    /// What has come.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Takes what has come. True if there is something to take out with [`Self::next`].
    pub fn receive<B: BoxBoard>(&mut self, board: &mut B) -> bool {
        let mut bytes = [0; PASS_BYTES];
        let room = PASS_BYTES - self.waiting.len();
        let came = bytes
            .get_mut(..room)
            .and_then(|free| board.receive(free).ok())
            .unwrap_or(0);
        for &byte in bytes.iter().take(came) {
            // There is room: no more was asked for.
            let _ = self.waiting.push_back(byte);
        }
        self.full_passes = if came == room {
            self.full_passes.saturating_add(1)
        } else {
            0
        };
        !self.waiting.is_empty()
    }

    /// More has come than can be looked at, for some time.
    pub fn is_flooded(&self) -> bool {
        self.full_passes >= FLOOD_PASSES
    }

    /// The next frame of what [`Self::receive`] has taken, read into `plain`; none if there is no whole one.
    pub fn next<'a>(&mut self, plain: &'a mut [u8; MAX_FRAME]) -> Option<Came<'a>> {
        while let Some(byte) = self.waiting.pop_front() {
            let frame = match self.deframer.collect(byte) {
                None => continue,
                Some(Ok(stuffed)) => open(stuffed, plain),
                Some(Err(why)) => Err(why),
            };
            if frame.is_err() {
                self.counts.garbage = self.counts.garbage.saturating_add(1);
            }
            return Some(frame.map_or(Came::Garbage, |frame| Came::of(&frame)));
        }
        None
    }

    /// Counts an answer.
    pub fn count(&mut self, answer: &Answer) {
        self.counts.answered = self.counts.answered.wrapping_add(1);
        if matches!(answer, Answer::Refused(_)) {
            self.counts.refused = self.counts.refused.wrapping_add(1);
        }
    }

    /// Counts one that has come before, or too late.
    pub fn count_doubled(&mut self) {
        self.counts.doubled = self.counts.doubled.wrapping_add(1);
    }

    /// Broken frames since this said so last, once they are enough to be told.
    pub fn garbage(&mut self) -> Option<u32> {
        let broken = self.counts.garbage.wrapping_sub(self.garbage_told);
        (broken >= GARBAGE_FRAMES).then(|| {
            self.garbage_told = self.counts.garbage;
            broken
        })
    }
}
