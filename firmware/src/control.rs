//! Who may change anything: one host at a time, each of its commands once.
//!
//! A turn of control is a number that the box draws whenever control changes hands, so that
//! nothing said in another turn, by whomever, counts in this one. Within a turn a window over
//! the sequence numbers tells a new command from one that has come before.

use crate::board::{BoxBoard, Origin};
use crate::commands::Said;
use rarma_box::settings::LINK_KEY;
use rarma_box::wire::{
    Answer, Arrival, Command, ControlMessage, Handed, LinkKey, NOBODY, Refused, Window,
};

/// Answers that are kept for a host that has missed them.
const KEPT: usize = 2;

#[derive(Debug, Clone)]
struct Kept {
    sequence: u32,
    crc: u16,
    answer: Answer,
}

/// Which host is in control.
#[derive(Debug)]
pub(crate) struct Control {
    turn: u32,
    by: u32,
    why: Handed,
    window: Window,
    kept: [Option<Kept>; KEPT],
}

impl Control {
    /// Nobody has it.
    pub fn new(turn: u32) -> Self {
        Self {
            turn,
            by: NOBODY,
            why: Handed::Start,
            window: Window::default(),
            kept: [const { None }; KEPT],
        }
    }

    /// Whether somebody has it.
    pub fn is_held(&self) -> bool {
        self.by != NOBODY
    }

    /// Whether `by` is the host in control.
    fn is(&self, by: u32) -> bool {
        self.is_held() && by == self.turn
    }

    /// Whether a command may be carried out, in the `session` of now, with the link's `key` if there is one.
    pub fn rule<B: BoxBoard>(
        &self,
        board: &mut B,
        said: &Said<'_>,
        session: u32,
        key: Option<&LinkKey>,
    ) -> Ruling {
        if said.command == Command::Identify {
            return Ruling::Do;
        }
        if said.session != session {
            return Ruling::No(Refused::Session);
        }
        if said.command.only_asks() {
            return Ruling::Do;
        }
        let trusted = trusts(board, said, key);
        let is_controller = trusted.is_ok() && self.is(said.by);
        if said.command == Command::Stop && !is_controller {
            // Anybody may stop. What the controller has sent before it knew of that, an
            // `arm` on its way, must not count any more: its turn is over.
            return Ruling::Stop;
        }
        if let Err(why) = trusted {
            return Ruling::No(why);
        }
        if let Command::Take { turn } = said.command {
            return if turn == self.turn {
                Ruling::Take
            } else {
                Ruling::No(Refused::Turn)
            };
        }
        if !is_controller {
            return Ruling::No(Refused::NotInControl);
        }
        match self.window.look(said.sequence) {
            Arrival::New => Ruling::Do,
            // A stop is carried out though a later command has come before it: stopping is safe.
            Arrival::Overtaken if said.command == Command::Stop => Ruling::Do,
            Arrival::Overtaken => Ruling::Doubled(Err(Refused::Overtaken)),
            Arrival::Repeated => {
                Ruling::Doubled(self.again(said.sequence, said.crc).ok_or(Refused::Repeated))
            }
            Arrival::Old => Ruling::Doubled(Err(Refused::Old)),
        }
    }

    /// Marks the sequence number of a command as used, once it was carried out or refused for what it asks. The answer is
    /// kept in case the host asks again; that to a heartbeat is not, for nobody does.
    pub fn remember(&mut self, said: &Said<'_>, answer: &Answer) {
        if said.command.only_asks() {
            return;
        }
        self.window.take(said.sequence);
        if said.command != Command::Heartbeat {
            self.kept.rotate_right(1);
            if let Some(first) = self.kept.first_mut() {
                *first = Some(Kept {
                    sequence: said.sequence,
                    crc: said.crc,
                    answer: answer.clone(),
                });
            }
        }
    }

    /// Control changes hands: another turn begins, by a number that was drawn ([`other_than`]).
    pub fn hand_over(&mut self, by: u32, why: Handed, drawn: u32) {
        *self = Self {
            by,
            why,
            ..Self::new(other_than(self.turn, drawn))
        };
    }

    /// Whose turn it is; `key`: the link has one.
    pub fn message(&self, key: bool) -> ControlMessage {
        ControlMessage {
            turn: self.turn,
            by: self.by,
            why: self.why,
            key,
        }
    }

    /// The answer to a command that has come before, if it is kept.
    fn again(&self, sequence: u32, crc: u16) -> Option<Answer> {
        let same = |kept: &&Kept| (kept.sequence, kept.crc) == (sequence, crc);
        let kept = self.kept.iter().flatten().find(same);
        kept.map(|kept| kept.answer.clone())
    }
}

/// What becomes of a command.
pub(crate) enum Ruling {
    /// It is to be carried out.
    Do,
    /// A host that is not in control asks for a stop: outputs go down, and the turn of the host in control ends.
    Stop,
    /// The sender gets control.
    Take,
    /// It has come before, or too late.
    Doubled(Result<Answer, Refused>),
    /// It is refused.
    No(Refused),
}

/// Whether the sender of a command may change anything at all: it has the key, or, where none is set, it is at the box's own
/// port. At that port a pressed emergency stop replaces a key that was lost: somebody stands at the machine.
fn trusts<B: BoxBoard>(
    board: &mut B,
    said: &Said<'_>,
    key: Option<&LinkKey>,
) -> Result<(), Refused> {
    let own_port = board.origin() == Origin::OwnPort;
    let changes_key = said.command.changes() == Some(LINK_KEY.number());
    if changes_key && !own_port {
        return Err(Refused::OwnPort);
    }
    match key {
        Some(key) if said.seal.is_of(key) => Ok(()),
        Some(_) if own_port && !board.contacts().stop_chain => Ok(()),
        Some(_) => Err(Refused::Seal),
        None if own_port => Ok(()),
        None => Err(Refused::NoKey),
    }
}

/// A number drawn, unless it is 0 or the one before.
pub(crate) fn other_than(before: u32, drawn: u32) -> u32 {
    if drawn == 0 || drawn == before {
        before.wrapping_add(1).max(1)
    } else {
        drawn
    }
}
