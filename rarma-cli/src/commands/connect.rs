//! `rarma connect`: a box on a wire, live.

mod talk;

use self::talk::Talk;
use crate::args::ConnectArgs;
use crate::failure::Failure;
use crate::frames::{FrameReader, control_words, fault_words, to_json, words};
use crate::key;
use crate::output::{RecordFile, stdout};
use crate::port::Port;
use crate::speech;
use console::Term;
use rarma_box::settings::SETTINGS;
use rarma_box::wire::{Answer, Command, Status, Telemetry, Verdict};
use std::collections::VecDeque;
use std::io::{self, BufRead, IsTerminal};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::time::{Duration, Instant};

const REDRAW: Duration = Duration::from_millis(200);
/// The box's answer to the last word of all is waited for so long.
const PARTING: Duration = Duration::from_millis(300);
/// Levels in the trend.
const TREND: usize = 48;
/// Lines of events kept on the screen.
const EVENTS: usize = 8;

pub(super) fn main(args: &ConnectArgs) -> Result<u8, Failure> {
    let mut first = Vec::new();
    for line in &args.say {
        first.push(speech::command(line).map_err(|why| Failure::Usage(format!("--say: {why}")))?);
    }
    let key = args.key.as_deref().map(key::read).transpose()?;
    let port = Port::open(&args.port, args.baud)?;
    if !port.answers() {
        return Err(Failure::Usage(format!(
            "{}: a box is needed that answers; use `rarma decode` for a file",
            args.port
        )));
    }
    let record = args.record.as_deref().map(RecordFile::open).transpose()?;
    let mut talk = Talk::new(port, record, key);
    talk.end_frame()?;
    if args.settings {
        return settings(&mut talk);
    }
    if let Some(file) = &args.set_key {
        let none = file.as_os_str() == "none";
        talk.set_key((!none).then(|| key::read(file)).transpose()?)?;
        say!(
            "{}: key {}",
            args.port,
            if none { "removed" } else { "set and kept" }
        );
        return Ok(0);
    }
    live(&mut talk, args, &first)
}

fn settings(talk: &mut Talk) -> Result<u8, Failure> {
    // Whatever the box says names the session that the questions are for.
    talk.answer(Command::Identify)?;
    for setting in &SETTINGS {
        let answer = talk.answer(Command::Read {
            setting: setting.number,
        })?;
        let Answer::Setting(s) = answer else {
            return Err(Failure::System(format!(
                "the box does not tell {}: {}",
                setting.name,
                crate::frames::answer_words(&answer)
            )));
        };
        let stored = s.stored.map_or("-".to_owned(), speech::shown);
        say!(
            "{:22} {:>12} {:6} stored {stored:>12}  {}",
            setting.name,
            speech::shown(s.value),
            setting.unit,
            setting.effect
        );
    }
    Ok(0)
}

fn live(talk: &mut Talk, args: &ConnectArgs, first: &[Command]) -> Result<u8, Failure> {
    let typed = typed_lines();
    let mut view = View::new(!args.json && io::stdout().is_terminal());
    talk.ask(Command::Identify)?;
    let begun = Instant::now();
    let mut drawn = Instant::now();
    let mut first = first.iter();
    // A host that does not only look takes control where nobody has it, once.
    let mut takes = !args.look;
    loop {
        if args
            .seconds
            .is_some_and(|s| begun.elapsed().as_secs_f64() > s)
        {
            break;
        }
        talk.keep_on()?;
        if takes && let Some(control) = talk.speaker.control() {
            takes = false;
            if talk.speaker.is_free() {
                talk.ask(Command::Take { turn: control.turn })?;
            } else {
                view.event(format!(
                    "host {:08x} is in control; `take` takes it, outputs that are on go down",
                    control.by
                ));
            }
        }
        // One at a time, in order, each after the answer to the last.
        if talk.is_answered()
            && let Some(command) = first.next()
        {
            talk.ask(*command)?;
        }
        match typed.try_recv() {
            Ok(line) if matches!(line.trim(), "quit" | "exit" | "q") => break,
            Ok(line) if line.trim().is_empty() => {}
            Ok(line) => match speech::command(&line) {
                Ok(command) => talk.ask(command)?,
                Err(why) => view.event(why),
            },
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => {}
        }
        let here = talk.listen(|head, message| {
            if args.json {
                say!("{}", to_json(head, &message));
            } else {
                view.take(&message);
            }
        })?;
        stdout::check()?;
        if !here {
            view.event("the box is gone".to_owned());
            break;
        }
        for command in talk.unanswered() {
            view.event(format!("no answer to {command:?}"));
        }
        for news in talk.news.drain(..) {
            view.event(news);
        }
        if drawn.elapsed() >= REDRAW {
            drawn = Instant::now();
            view.draw(&talk.reader)?;
        }
    }
    part(talk)?;
    talk.record.take().map_or(Ok(()), RecordFile::end)?;
    if let Some(losses) = talk.reader.losses() {
        eprintln!("{}: {losses}", args.port);
    }
    if talk.reader.whole == 0 {
        return Err(Failure::System(format!(
            "{}: no whole frame came (is it a box, and the baud rate right?)",
            args.port
        )));
    }
    Ok(0)
}

/// Whoever goes gives control up: outputs that are on go down in order, and the next host
/// finds the box free.
fn part(talk: &mut Talk) -> Result<(), Failure> {
    if !talk.speaker.in_control() || talk.ask(Command::Release).is_err() {
        return Ok(());
    }
    let asked = Instant::now();
    while !talk.is_answered() && asked.elapsed() < PARTING {
        if !talk.listen(|_, _| {}).unwrap_or(false) {
            break;
        }
    }
    Ok(())
}

fn typed_lines() -> Receiver<String> {
    // Typed faster than said: the keyboard waits.
    let (send, receive) = mpsc::sync_channel(16);
    std::thread::spawn(move || {
        for line in io::stdin().lock().lines() {
            let Ok(line) = line else { break };
            if send.send(line).is_err() {
                break;
            }
        }
    });
    receive
}

/// What is on the screen; without a terminal, lines as they come.
struct View {
    terminal: Option<Term>,
    lines: usize,
    status: Option<Status>,
    verdict: Option<Verdict>,
    levels: VecDeque<f32>,
    events: VecDeque<String>,
}

impl View {
    fn new(live: bool) -> Self {
        Self {
            terminal: live.then(Term::stdout),
            lines: 0,
            status: None,
            verdict: None,
            levels: VecDeque::new(),
            events: VecDeque::new(),
        }
    }

    fn event(&mut self, text: String) {
        if self.terminal.is_none() {
            eprintln!("{text}");
        }
        self.events.push_back(text);
        if self.events.len() > EVENTS {
            self.events.pop_front();
        }
    }

    fn take(&mut self, message: &Telemetry) {
        match message {
            Telemetry::Status(status) => {
                self.status = Some(*status);
                if self.terminal.is_none()
                    && let Some(text) = words(message)
                {
                    say!("{text}");
                }
            }
            Telemetry::Verdict(verdict) => {
                self.levels.push_back(verdict.level);
                if self.levels.len() > TREND {
                    self.levels.pop_front();
                }
                self.verdict = Some(verdict.clone());
            }
            Telemetry::Reply(reply) if reply.answer == Answer::Done => {}
            Telemetry::Health(_) => {}
            _ => {
                if let Some(text) = words(message) {
                    if self.terminal.is_none() {
                        say!("{text}");
                    }
                    self.events.push_back(text);
                    if self.events.len() > EVENTS {
                        self.events.pop_front();
                    }
                }
            }
        }
    }

    fn draw(&mut self, reader: &FrameReader) -> Result<(), Failure> {
        let Some(terminal) = &self.terminal else {
            return Ok(());
        };
        let mut lines = Vec::new();
        if let Some(s) = &self.status {
            lines.extend(words(&Telemetry::Status(*s)));
            lines.push(match &s.fault {
                Some(fault) => format!(
                    "FAULT {}: `clear` when its cause is gone",
                    fault_words(fault)
                ),
                None => "no fault".to_owned(),
            });
            lines.push(control_words(&s.control));
        }
        if let Some(v) = &self.verdict {
            lines.push(format!(
                "{:?} ({:?}), level {:.4}",
                v.state, v.reason, v.level
            ));
            for mode in &v.modes {
                lines.push(format!(
                    "  {:8.1} Hz ±{:5.1}   damping {:6.2} % ±{:5.2}   {:?}",
                    mode.frequency,
                    mode.frequency_sd,
                    100.0 * mode.damping,
                    100.0 * mode.damping_sd,
                    mode.label
                ));
            }
        }
        lines.push(trend(&self.levels));
        lines.push(
            reader
                .losses()
                .unwrap_or_else(|| format!("{} frames, none lost", reader.whole)),
        );
        lines.extend(self.events.iter().cloned());
        lines.push("type a command and Enter; quit ends".to_owned());
        stdout::wrote(terminal.clear_last_lines(self.lines))?;
        let width = usize::from(terminal.size().1).max(20);
        for line in &lines {
            let short: String = line.chars().take(width - 1).collect();
            stdout::wrote(terminal.write_line(&short))?;
        }
        self.lines = lines.len();
        Ok(())
    }
}

/// Levels as bars, the loudest at the top.
fn trend(levels: &VecDeque<f32>) -> String {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let most = levels.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    levels
        .iter()
        .map(|x| BARS[((7.0 * x / most) as usize).min(7)])
        .collect()
}
