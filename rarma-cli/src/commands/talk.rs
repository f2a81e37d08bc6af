//! What is said to a box and what comes back: numbered, sealed, waited for; and heartbeats.

use crate::failure::Failure;
use crate::output::RecordFile;
use crate::port::Port;
use rarma_box::guard::Severity;
use rarma_box::settings::{LINK_KEY, SettingValue};
use rarma_box::wire::{Answer, Command, Head, LinkKey, MAX_FRAME, Refused, Speaker, Telemetry};
use rarma_recordings::FrameReader;
use std::time::{Duration, Instant};

const HEARTBEAT: Duration = Duration::from_millis(100);
/// An answer that has not come after this long does not come.
pub(super) const ANSWER: Duration = Duration::from_secs(2);

pub(super) struct Talk {
    port: Port,
    pub reader: FrameReader,
    pub record: Option<RecordFile>,
    pub speaker: Speaker,
    waiting: Vec<(u32, Command, Instant)>,
    /// Numbers of what nobody has typed.
    own: Vec<u32>,
    beats: Beats,
    next_beat: Instant,
    /// What there is to tell whoever looks on.
    pub news: Vec<String>,
}

/// Whether heartbeats are sent. They keep outputs on, so that somebody must have asked for
/// outputs first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Beats {
    No,
    /// `arm` has been said; the box has not shown outputs in use yet.
    Arming,
    On,
}

impl Talk {
    pub fn new(port: Port, record: Option<RecordFile>, key: Option<LinkKey>) -> Self {
        Self {
            port,
            reader: FrameReader::default(),
            record,
            speaker: Speaker::new(rand::random(), key),
            waiting: Vec::new(),
            own: Vec::new(),
            beats: Beats::No,
            next_beat: Instant::now(),
            news: Vec::new(),
        }
    }

    /// Ends whatever half frame the line still holds.
    pub fn end_frame(&mut self) -> Result<(), Failure> {
        self.port.send(&[0])
    }

    /// What is said when the box is gone.
    pub fn closed(&self) -> Failure {
        self.port.closed()
    }

    pub fn ask(&mut self, command: Command) -> Result<(), Failure> {
        match command {
            Command::Arm => {
                // The box arms for a host that it has heard lately.
                self.beat()?;
                if self.beats == Beats::No {
                    self.news.push(
                        "heartbeats begin: outputs stay on while this program runs and reaches the box; it does not know whether anybody is there"
                            .to_owned(),
                    );
                }
                self.beats = Beats::Arming;
            }
            Command::Stop | Command::Release | Command::Take { .. } => {
                self.no_beats("it was told to stop")
            }
            _ => {}
        }
        self.send(command)
    }

    /// Asks what nobody has typed.
    pub fn ask_itself(&mut self, command: Command) -> Result<(), Failure> {
        self.send(command)?;
        self.own.extend(self.waiting.last().map(|(to, ..)| *to));
        Ok(())
    }

    /// Whether this answers what nobody has typed.
    pub fn answers_itself(&self, message: &Telemetry) -> bool {
        matches!(message, Telemetry::Reply(reply) if self.own.contains(&reply.to) && self.speaker.is_addressed(reply.by))
    }

    fn send(&mut self, command: Command) -> Result<(), Failure> {
        let mut buffer = [0; MAX_FRAME];
        let (sequence, frame) = self
            .speaker
            .frame(&command, &mut buffer)
            .map_err(|why| Failure::System(format!("a command cannot be sent: {why:?}")))?;
        self.port.send(frame)?;
        if command != Command::Heartbeat {
            self.waiting.push((sequence, command, Instant::now()));
        }
        Ok(())
    }

    fn beat(&mut self) -> Result<(), Failure> {
        self.next_beat = Instant::now() + HEARTBEAT;
        self.send(Command::Heartbeat)
    }

    /// The heartbeat that is due, if any is.
    pub fn keep_on(&mut self) -> Result<(), Failure> {
        if self.beats != Beats::No && Instant::now() >= self.next_beat {
            self.beat()?;
        }
        Ok(())
    }

    fn no_beats(&mut self, why: &str) {
        if self.beats != Beats::No {
            self.news.push(format!("heartbeats end: {why}"));
        }
        self.beats = Beats::No;
    }

    /// Every command has been answered, or given up.
    pub fn is_answered(&self) -> bool {
        self.waiting.is_empty()
    }

    /// What has come; false once the box is gone.
    pub fn listen(&mut self, mut with: impl FnMut(Head, Telemetry)) -> Result<bool, Failure> {
        let mut bytes = [0; 4096];
        let Some(n) = self.port.read(&mut bytes)? else {
            return Ok(true);
        };
        let came = bytes.get(..n).unwrap_or_default();
        if let Some(file) = &mut self.record {
            file.write(came)?;
        }
        let mut messages = Vec::new();
        self.reader
            .take(came, |head, message| messages.push((head, message)));
        for (head, message) in messages {
            self.hear(&head, &message);
            with(head, message);
        }
        Ok(n > 0)
    }

    fn hear(&mut self, head: &Head, message: &Telemetry) {
        let had = self.speaker.in_control();
        self.speaker.hears(head, message);
        match (had, self.speaker.in_control()) {
            (false, true) => self.news.push("this host is in control".to_owned()),
            (true, false) => {
                self.no_beats("control is gone");
                self.news
                    .push("this host is not in control any more".to_owned());
            }
            _ => {}
        }
        match message {
            Telemetry::Reply(reply) if self.speaker.is_addressed(reply.by) => {
                let asked = self.waiting.iter().position(|(to, ..)| *to == reply.to);
                let command = asked.map(|k| self.waiting.remove(k).1);
                if command == Some(Command::Arm) && matches!(reply.answer, Answer::Refused(_)) {
                    self.no_beats("the box does not arm");
                }
            }
            Telemetry::Fault(fault) if fault.severity == Severity::Trip => {
                self.no_beats("a fault has switched the outputs off");
            }
            Telemetry::Status(status) => match (self.beats, status.stage.in_use()) {
                (Beats::Arming, true) => self.beats = Beats::On,
                (Beats::On, false) => self.no_beats("the outputs are off"),
                _ => {}
            },
            _ => {}
        }
    }

    /// Commands without an answer after [`ANSWER`].
    pub fn unanswered(&mut self) -> Vec<Command> {
        let late = |(_, command, at): &(u32, Command, Instant)| {
            (at.elapsed() > ANSWER).then_some(*command)
        };
        let lost = self.waiting.iter().filter_map(late).collect();
        self.waiting.retain(|(.., at)| at.elapsed() <= ANSWER);
        lost
    }

    /// Asks one thing and waits for what is answered.
    pub fn answer(&mut self, command: Command) -> Result<Answer, Failure> {
        // Asked three times: a link may lose a frame.
        for _ in 0..3 {
            self.send(command)?;
            let sequence = self.waiting.last().map_or(0, |(sequence, ..)| *sequence);
            let asked = Instant::now();
            while asked.elapsed() < ANSWER / 4 {
                let mut answer = None;
                let mut replies = Vec::new();
                let here = self.listen(|_, message| {
                    if let Telemetry::Reply(reply) = message {
                        replies.push(reply);
                    }
                })?;
                for reply in replies {
                    if reply.to == sequence && self.speaker.is_addressed(reply.by) {
                        answer = Some(reply.answer);
                    }
                }
                if let Some(answer) = answer {
                    return Ok(answer);
                }
                if !here {
                    return Err(Failure::System("the box is gone".to_owned()));
                }
            }
        }
        Err(Failure::System(format!(
            "the box does not answer to {command:?} (is it one, and the baud rate right?)"
        )))
    }

    /// Puts a key in the place of the one there is, or of none, and keeps it.
    pub fn set_key(&mut self, key: Option<LinkKey>) -> Result<(), Failure> {
        self.answer(Command::Identify)?;
        let take = self.speaker.take().unwrap_or(Command::Identify);
        let setting = LINK_KEY.number();
        let value = key.map_or(SettingValue::Hidden(false), SettingValue::Key);
        for command in [take, Command::Set { setting, value }] {
            done(&self.answer(command)?)?;
        }
        self.speaker.set_key(key);
        for command in [Command::Save { setting }, Command::Release] {
            done(&self.answer(command)?)?;
        }
        Ok(())
    }
}

fn done(answer: &Answer) -> Result<(), Failure> {
    match answer {
        Answer::Refused(Refused::Repeated) => Ok(()),
        Answer::Refused(_) => Err(Failure::System(format!(
            "the box has {}",
            crate::frames::answer_words(answer)
        ))),
        _ => Ok(()),
    }
}
