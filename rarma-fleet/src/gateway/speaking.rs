//! What the gateway says to a box: questions, and what a controller tells ([`Told`]). One command at a
//! time, each after the answer to the last.
//!
//! Questions may be asked by anybody. To tell a speed, a host has to be in control: the gateway takes control
//! only where nobody has it, and gives it up at once. It never takes it from a host that has it, and never
//! sends a heartbeat, without which no output stays on.

use super::link::Link;
use super::slots::{FRESH, Slots};
use super::told::Told;
use rarma_box::guard::Mode;
use rarma_box::settings::{MONITOR_SPINDLE, MONITOR_TEETH, SETTINGS};
use rarma_box::wire::{Answer, Command, Head, LinkKey, MAX_FRAME, Refused, Speaker, Telemetry};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// An answer that has not come after this long does not come.
const ANSWER: Duration = Duration::from_secs(2);

/// Sends commands to one box, one at a time.
pub(super) struct Speaking {
    speaker: Speaker,
    waiting: Option<(u32, Command, Instant)>,
    questions: VecDeque<u16>,
    /// Answers so far, `name=value` in the order of the table.
    answers: String,
    /// What is to be told: it goes when the box has taken it, when it is refused, and when it is old.
    told: Slots,
    /// What is being told, and its commands that are left. What is cut off is begun anew.
    telling: Option<(Told, VecDeque<Command>)>,
    /// Since when there is something to tell, or it was last said why it is not told.
    since: Option<Instant>,
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
            told: Slots::default(),
            telling: None,
            since: None,
            mode: None,
            identified: false,
        }
    }

    /// Something to tell to the box, and when it came; it overtakes what is older of the same kind.
    pub fn tell(&mut self, told: Told, at: Instant) {
        self.told.put(told, at);
        self.since.get_or_insert(at);
    }

    /// What was not told.
    pub fn rest(&mut self) -> Vec<(Told, Instant)> {
        self.told.drain()
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
            (self.waiting, self.telling, self.identified) = (None, None, false);
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
            (
                Command::Set { .. } | Command::Take { .. } | Command::Start(_),
                Answer::Refused(why),
            ) => {
                self.telling = None;
                // It has changed hands meanwhile: that is tried again.
                let again = [Refused::NotInControl, Refused::Turn, Refused::Session];
                if !again.contains(why) {
                    let _ = self.told.drain();
                    self.since = None;
                    news.push(News::Refused(format!("not told: {}", refused_words(why))));
                }
            }
            (Command::Set { .. } | Command::Start(_), _) => {
                let done = self.telling.take_if(|(_, left)| left.is_empty());
                if let Some((told, _)) = done {
                    self.told.done(&told);
                    self.since = self.told.first().map(|_| Instant::now());
                    news.push(News::Taken(told));
                }
            }
            _ => {}
        }
    }

    /// Drops what has become too old, and says why it was not told; and why not what is overtaken
    /// all the time.
    fn forget_old(&mut self, news: &mut Vec<News>) {
        let now = Instant::now();
        let old = self.told.old(now);
        let long = self.since.is_some_and(|since| now - since > FRESH);
        if old.is_empty() && !long {
            return;
        }
        self.since = self.told.first().map(|_| now);
        let what = old
            .first()
            .map_or(String::new(), |told| format!("{told}: "));
        let why = match self.speaker.control() {
            _ if !self.identified => "the box does not answer".to_owned(),
            Some(c) if !self.speaker.is_free() && !self.speaker.in_control() => {
                format!("host {:08x} is in control of the box", c.by)
            }
            _ => "the box has not taken it".to_owned(),
        };
        news.push(News::Refused(format!("not told: {what}{why}")));
    }

    /// Sends what is due.
    pub fn go_on(&mut self, link: &mut dyn Link, news: &mut Vec<News>) -> Result<(), String> {
        if let Some((_, _, at)) = self.waiting {
            if at.elapsed() < ANSWER {
                return Ok(());
            }
            (self.waiting, self.telling) = (None, None);
        }
        if let Some(command) = self.next(news) {
            self.send(link, command)?;
        }
        Ok(())
    }

    fn next(&mut self, news: &mut Vec<News>) -> Option<Command> {
        self.forget_old(news);
        if !self.identified {
            return Some(Command::Identify);
        }
        let in_control = self.speaker.in_control();
        if !in_control {
            self.telling = None;
        }
        if let Some((_, left)) = &mut self.telling
            && let Some(command) = left.pop_front()
        {
            return Some(command);
        }
        if let Some(told) = self.told.first().cloned() {
            if !in_control {
                return self.speaker.is_free().then(|| self.speaker.take())?;
            }
            let mut commands: VecDeque<Command> = told.commands(self.mode).into();
            let first = commands.pop_front();
            self.telling = Some((told, commands));
            return first;
        }
        if in_control {
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

#[cfg(test)]
#[path = "speaking_tests.rs"]
mod tests;
