//! Who may change anything: one host at a time, each of its commands once.
//!
//! A turn of control is a number that the box draws whenever control changes hands, so that
//! nothing said in another turn, by whomever, counts in this one. Within a turn a window over
//! the sequence numbers tells a new command from one that has come before.

use crate::board::{BoxBoard, Origin};
use crate::sensor_box::SensorBox;
use rarma_box::settings::LINK_KEY;
use rarma_box::wire::{
    Answer, Arrival, Command, ControlMessage, Handed, NOBODY, Refused, Seal, Telemetry, Window,
};

/// Answers that are kept for a host that has missed them.
const KEPT: usize = 2;

#[derive(Debug, Clone)]
struct Kept {
    sequence: u32,
    crc: u16,
    answer: Answer,
}

/// See the module.
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

    /// Whether a command is by whoever has it.
    pub fn is(&self, by: u32) -> bool {
        self.is_held() && by == self.turn
    }

    /// Remembers the number of a command that is carried out now. What is kept is what the
    /// host may ask for again: a heartbeat's answer is not missed.
    fn remember(&mut self, sequence: u32, crc: u16, command: &Command, answer: &Answer) {
        self.window.take(sequence);
        if *command != Command::Heartbeat {
            self.kept.rotate_right(1);
            if let Some(first) = self.kept.first_mut() {
                *first = Some(Kept {
                    sequence,
                    crc,
                    answer: answer.clone(),
                });
            }
        }
    }

    /// The answer to a command that has come before, if it is kept.
    fn again(&self, sequence: u32, crc: u16) -> Option<Answer> {
        let same = |kept: &&Kept| (kept.sequence, kept.crc) == (sequence, crc);
        let kept = self.kept.iter().flatten().find(same);
        kept.map(|kept| kept.answer.clone())
    }
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

/// What becomes of a command.
pub(crate) enum Ruling {
    /// It is to be carried out.
    Do,
    /// It is answered already.
    Answered(Answer),
    /// It has come before, or too late.
    Doubled(Result<Answer, Refused>),
    /// It is refused.
    No(Refused),
}

impl SensorBox {
    /// Whether a command may be carried out, and what handing over of control it means.
    pub(crate) fn rule<B: BoxBoard>(
        &mut self,
        board: &mut B,
        said: &Said<'_>,
        now_us: u64,
    ) -> Ruling {
        if said.command == Command::Identify {
            return Ruling::Do;
        }
        if said.session != self.tell.session() {
            return Ruling::No(Refused::Session);
        }
        if said.command.only_asks() {
            return Ruling::Do;
        }
        let trusted = self.trusts(board, said);
        let is_controller = trusted.is_ok() && self.control.is(said.by);
        if said.command == Command::Stop && !is_controller {
            // Anybody may stop. What the controller has sent before it knew of that, an
            // `arm` on its way, must not count any more: its turn is over.
            if self.control.is_held() {
                self.hand_over(board, NOBODY, Handed::Stopped, now_us);
            }
            self.supervisor.stop(now_us);
            return Ruling::Answered(Answer::Done);
        }
        if let Err(why) = trusted {
            return Ruling::No(why);
        }
        if let Command::Take { turn } = said.command {
            if turn != self.control.turn {
                return Ruling::No(Refused::Turn);
            }
            self.hand_over(board, said.by, Handed::Taken, now_us);
            return Ruling::Answered(Answer::Done);
        }
        if !is_controller {
            return Ruling::No(Refused::NotInControl);
        }
        match self.control.window.look(said.sequence) {
            Arrival::New => Ruling::Do,
            // Late, and still on the safe side.
            Arrival::Overtaken if said.command == Command::Stop => Ruling::Do,
            Arrival::Overtaken => Ruling::Doubled(Err(Refused::Overtaken)),
            Arrival::Repeated => Ruling::Doubled(
                self.control
                    .again(said.sequence, said.crc)
                    .ok_or(Refused::Repeated),
            ),
            Arrival::Old => Ruling::Doubled(Err(Refused::Old)),
        }
    }

    /// A command has been carried out, or refused for what it asks for: its number is used.
    pub(crate) fn ruled(&mut self, said: &Said<'_>, answer: &Answer) {
        if !said.command.only_asks() {
            self.control
                .remember(said.sequence, said.crc, &said.command, answer);
        }
    }

    /// Whether a command comes from somebody who may change anything at all: with the key, or
    /// where there is none, at the box's own port. There the emergency stop, held pressed by
    /// somebody at the machine, stands for a key that was lost.
    fn trusts<B: BoxBoard>(&self, board: &mut B, said: &Said<'_>) -> Result<(), Refused> {
        let own_port = board.origin() == Origin::OwnPort;
        let changes_key = said.command.changes() == Some(LINK_KEY.number());
        if changes_key && !own_port {
            return Err(Refused::OwnPort);
        }
        match self.settings.link_key() {
            Some(key) if said.seal.is_of(key) => Ok(()),
            Some(_) if own_port && !board.contacts().stop_chain => Ok(()),
            Some(_) => Err(Refused::Seal),
            None if own_port => Ok(()),
            None => Err(Refused::NoKey),
        }
    }

    /// Control changes hands: another turn begins, outputs that are on go down in order, and
    /// everybody is told.
    pub(crate) fn hand_over<B: BoxBoard>(
        &mut self,
        board: &mut B,
        by: u32,
        why: Handed,
        now_us: u64,
    ) {
        let turn = other_than(self.control.turn, board.entropy());
        self.control = Control {
            by,
            why,
            ..Control::new(turn)
        };
        self.supervisor.hand_over(now_us);
        // A signal that waits for the next arming is the last host's wish.
        self.rig.exciting.quiet();
        let message = self.control_message();
        self.tell.tell(board, &Telemetry::Control(message));
    }

    /// Whose turn it is.
    pub(crate) fn control_message(&self) -> ControlMessage {
        ControlMessage {
            turn: self.control.turn,
            by: self.control.by,
            why: self.control.why,
            key: self.settings.link_key().is_some(),
        }
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
