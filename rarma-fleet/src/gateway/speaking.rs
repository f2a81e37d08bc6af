//! What the gateway says to a box: questions, and what a controller tells ([`Told`]). One command at a
//! time, each after the answer to the last.
//!
//! Questions may be asked by anybody. To tell a speed, a host has to be in control: the gateway takes control
//! only where nobody has it, and gives it up at once. It never takes it from a host that has it, and never
//! sends a heartbeat, without which no output stays on.

use super::link::Link;
use super::told::Told;
use rarma_box::guard::Mode;
use rarma_box::settings::{MONITOR_SPINDLE, MONITOR_TEETH, SETTINGS};
use rarma_box::wire::{Answer, Command, Head, LinkKey, MAX_FRAME, Refused, Speaker, Telemetry};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// An answer that has not come after this long does not come.
const ANSWER: Duration = Duration::from_secs(2);
/// Another host is waited for so long.
const HELD: Duration = Duration::from_secs(10);

/// See the module.
pub(super) struct Speaking {
    speaker: Speaker,
    waiting: Option<(u32, Command, Instant)>,
    questions: VecDeque<u16>,
    /// Answers so far, `name=value` in the order of the table.
    answers: String,
    speed: Option<Told>,
    teeth: Option<Told>,
    /// When the oldest of them came.
    since: Option<Instant>,
    commands: VecDeque<Command>,
    mode: Option<Mode>,
    identified: bool,
}

/// What came of it.
#[derive(Debug, PartialEq)]
pub(super) enum News {
    /// All settings have been read: their text.
    Settings(String),
    /// The box has taken what it was told.
    Taken(Told),
    /// It has not; in words.
    Refused(String),
}

impl Speaking {
    pub fn new(own: u32, key: Option<LinkKey>) -> Self {
        Self {
            speaker: Speaker::new(own, key),
            waiting: None,
            questions: VecDeque::new(),
            answers: String::new(),
            speed: None,
            teeth: None,
            since: None,
            commands: VecDeque::new(),
            mode: None,
            identified: false,
        }
    }

    /// Something to tell; what has not been told yet of the same kind is overtaken.
    pub fn tell(&mut self, told: Told) {
        match told {
            Told::Speed(_) => self.speed = Some(told),
            Told::Teeth(_) => self.teeth = Some(told),
        }
        self.since.get_or_insert_with(Instant::now);
    }

    /// Asks for all settings but those that a controller tells all the time.
    pub fn ask_settings(&mut self) {
        let told = [MONITOR_SPINDLE.number(), MONITOR_TEETH.number()];
        self.questions = SETTINGS
            .iter()
            .map(|s| s.number)
            .filter(|n| !told.contains(n))
            .collect();
        self.answers.clear();
    }

    pub fn hears(&mut self, head: &Head, message: &Telemetry, news: &mut Vec<News>) {
        let before = self.speaker.session();
        let _ = self.speaker.hears(head, message);
        if self.speaker.session() != before && before != 0 {
            // Commands of the run before are lost with it; questions are asked anew.
            (self.waiting, self.identified) = (None, false);
            self.commands.clear();
        }
        match message {
            Telemetry::Status(status) => self.mode = Some(status.mode),
            Telemetry::Hello(_) => self.ask_settings(),
            Telemetry::Reply(reply) if self.speaker.is_addressed(reply.by) => {
                let Some((to, command, _)) = self.waiting else {
                    return;
                };
                if reply.to != to {
                    return;
                }
                self.waiting = None;
                self.answered(command, &reply.answer, news);
            }
            _ => {}
        }
    }

    fn answered(&mut self, command: Command, answer: &Answer, news: &mut Vec<News>) {
        match (command, answer) {
            (Command::Identify, Answer::Identity(_)) => {
                self.identified = true;
                self.ask_settings();
            }
            (Command::Read { .. }, Answer::Setting(s)) => {
                use std::fmt::Write as _;
                let _ = writeln!(self.answers, "{}={:?}", s.setting, s.value);
                if self.questions.is_empty() {
                    news.push(News::Settings(std::mem::take(&mut self.answers)));
                }
            }
            (Command::Set { setting, .. }, Answer::Done | Answer::Setting(_)) => {
                let slot = if setting == MONITOR_TEETH.number() {
                    &mut self.teeth
                } else {
                    &mut self.speed
                };
                news.extend(slot.take().map(News::Taken));
                if self.speed.is_none() && self.teeth.is_none() {
                    self.since = None;
                }
            }
            (
                Command::Set { .. } | Command::Take { .. } | Command::Start(_),
                Answer::Refused(why),
            ) if !matches!(
                // It has changed hands meanwhile: that is tried again.
                why,
                Refused::NotInControl | Refused::Turn | Refused::Session
            ) =>
            {
                self.give_up(format!("not told: {}", refused_words(why)), news);
            }
            _ => {}
        }
    }

    fn give_up(&mut self, why: String, news: &mut Vec<News>) {
        (self.speed, self.teeth, self.since) = (None, None, None);
        self.commands.clear();
        news.push(News::Refused(why));
    }

    /// Sends what is due.
    pub fn go_on(&mut self, link: &mut dyn Link, news: &mut Vec<News>) -> Result<(), String> {
        if let Some((_, _, at)) = self.waiting {
            if at.elapsed() < ANSWER {
                return Ok(());
            }
            self.waiting = None;
        }
        if let Some(command) = self.next(news) {
            self.send(link, command)?;
        }
        Ok(())
    }

    fn next(&mut self, news: &mut Vec<News>) -> Option<Command> {
        if !self.identified {
            return Some(Command::Identify);
        }
        if self.speed.is_some() || self.teeth.is_some() || !self.commands.is_empty() {
            if !self.speaker.in_control() {
                if self.speaker.is_free() {
                    return self.speaker.take();
                }
                if self.since.is_some_and(|since| since.elapsed() > HELD) {
                    let by = self.speaker.control().map_or(0, |c| c.by);
                    self.give_up(
                        format!("not told: host {by:08x} is in control of the box"),
                        news,
                    );
                }
                return None;
            }
            if let Some(command) = self.commands.pop_front() {
                return Some(command);
            }
            let told = self.speed.or(self.teeth)?;
            let mut commands = told.commands(self.mode).into_iter();
            let first = commands.next();
            self.commands.extend(commands);
            return first;
        }
        if self.speaker.in_control() {
            return Some(Command::Release);
        }
        self.questions
            .pop_front()
            .map(|setting| Command::Read { setting })
    }

    fn send(&mut self, link: &mut dyn Link, command: Command) -> Result<(), String> {
        let mut buffer = [0; MAX_FRAME];
        let (sequence, frame) = self
            .speaker
            .frame(&command, &mut buffer)
            .map_err(|why| format!("a command cannot be sent: {why:?}"))?;
        link.send(frame)?;
        self.waiting = Some((sequence, command, Instant::now()));
        Ok(())
    }
}

fn refused_words(why: &Refused) -> String {
    match why {
        Refused::NoKey => {
            "the box has no key, so that over a network it is told nothing (docs/box.md, the key)"
                .to_owned()
        }
        Refused::Seal => {
            "the key is missing or another one (`key` in the gateway's file)".to_owned()
        }
        other => format!("{other:?}"),
    }
}
