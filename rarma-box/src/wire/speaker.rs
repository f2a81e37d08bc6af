//! The host's half of the link: which session, whose turn, which number, which key.
//!
//! ```text
//! host                                box
//! Identify (session 0)            ->
//!                                 <-  Identity: session in the head, turn, who has it
//! Take { turn }                   ->
//!                                 <-  Control: a new turn, drawn by the box, and whose it is
//! commands by that turn, numbered ->
//! ```

use super::command::{Answer, Command, ControlMessage, NOBODY, Order};
use super::frame::{FrameError, Head, MAX_FRAME, NO_SESSION, encode_order};
use super::message::Telemetry;
use crate::key::LinkKey;

/// What a host keeps to send commands to a box.
#[derive(Debug, Clone)]
pub struct Speaker {
    own: u32,
    key: Option<LinkKey>,
    session: u32,
    control: Option<ControlMessage>,
    /// The last turn that was this host's.
    last_turn: u32,
    sequence: u32,
}

impl Speaker {
    /// A host of this number, which it draws; two hosts of one box draw different ones. With
    /// a key it seals everything it says.
    pub fn new(own: u32, key: Option<LinkKey>) -> Self {
        Self {
            own: own.max(NOBODY + 1),
            key,
            session: NO_SESSION,
            control: None,
            last_turn: own.max(NOBODY + 1),
            sequence: 0,
        }
    }

    /// From now on, another key or none.
    pub fn set_key(&mut self, key: Option<LinkKey>) {
        self.key = key;
    }

    /// The session of the last frame that was heard.
    pub fn session(&self) -> u32 {
        self.session
    }

    /// Whose turn it is, as far as it has been told.
    pub fn control(&self) -> Option<ControlMessage> {
        self.control
    }

    /// This host is in control.
    pub fn in_control(&self) -> bool {
        self.control.is_some_and(|c| c.by == self.own)
    }

    /// Nobody is in control, and it has been said.
    pub fn is_free(&self) -> bool {
        self.control.is_some_and(|c| c.by == NOBODY)
    }

    /// What takes control from whoever has it; none while it is not known whose turn it is.
    pub fn take(&self) -> Option<Command> {
        self.control.map(|c| Command::Take { turn: c.turn })
    }

    /// The next frame; its number and its bytes. A `Take` of turn 0 is one of the turn that
    /// is under way.
    ///
    /// # Errors
    /// [`FrameError::TooLong`]: the command does not fit a frame.
    pub fn frame<'a>(
        &mut self,
        command: &Command,
        out: &'a mut [u8; MAX_FRAME],
    ) -> Result<(u32, &'a [u8]), FrameError> {
        self.sequence = self.sequence.wrapping_add(1);
        let mine = self.control.filter(|c| c.by == self.own);
        let command = match (command, self.control) {
            (Command::Take { turn: 0 }, Some(control)) => Command::Take { turn: control.turn },
            _ => *command,
        };
        let order = Order {
            by: mine.map_or(self.own, |c| c.turn),
            command,
        };
        let frame = encode_order(&order, self.session, self.sequence, self.key.as_ref(), out)?;
        Ok((self.sequence, frame))
    }

    /// Whether an answer is to this host.
    pub fn is_addressed(&self, by: u32) -> bool {
        by == self.own || by == self.last_turn
    }

    /// A frame of the box. True if control has changed hands, or the box has started anew.
    pub fn hears(&mut self, head: &Head, message: &Telemetry) -> bool {
        let before = (self.session, self.control);
        if head.session != self.session {
            self.session = head.session;
            self.control = None;
        }
        let told = match message {
            Telemetry::Hello(identity) => Some(identity.control),
            Telemetry::Control(control) => Some(*control),
            Telemetry::Status(status) => Some(status.control),
            Telemetry::Reply(reply) => match &reply.answer {
                Answer::Identity(identity) => Some(identity.control),
                _ => None,
            },
            _ => None,
        };
        self.control = told.or(self.control);
        if let Some(mine) = self.control.filter(|c| c.by == self.own) {
            self.last_turn = mine.turn;
        }
        before != (self.session, self.control)
    }
}
