//! `rarma connect`: a box on a wire, live.

use crate::args::ConnectArgs;
use crate::failure::Failure;
use crate::frames::{FrameReader, fault_words, to_json, words};
use crate::output::{RecordFile, stdout};
use crate::port::Port;
use crate::speech;
use console::Term;
use rarma_core::settings::SETTINGS;
use rarma_core::wire::{
    Answer, Command, Head, MAX_FRAME, NO_SESSION, Status, Telemetry, Verdict, encode,
};
use std::collections::VecDeque;
use std::io::{self, BufRead, IsTerminal};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::time::{Duration, Instant};

const HEARTBEAT: Duration = Duration::from_millis(100);
const REDRAW: Duration = Duration::from_millis(200);
/// An answer that has not come after this long does not come.
const ANSWER: Duration = Duration::from_secs(2);
/// Levels in the trend.
const TREND: usize = 48;
/// Lines of events kept on the screen.
const EVENTS: usize = 8;

pub(super) fn main(args: &ConnectArgs) -> Result<u8, Failure> {
    let mut first = Vec::new();
    for line in &args.say {
        first.push(speech::command(line).map_err(|why| Failure::Usage(format!("--say: {why}")))?);
    }
    let port = Port::open(&args.port, args.baud)?;
    if !port.answers() {
        return Err(Failure::Usage(format!(
            "{}: a box is needed that answers; use `rarma decode` for a file",
            args.port
        )));
    }
    let mut talk = Talk {
        port,
        reader: FrameReader::default(),
        record: args.record.as_deref().map(RecordFile::open).transpose()?,
        session: NO_SESSION,
        sequence: 0,
        waiting: Vec::new(),
    };
    // Ends whatever half frame the line still holds.
    talk.port.send(&[0])?;
    if args.settings {
        return settings(&mut talk);
    }
    live(&mut talk, args, &first)
}

struct Talk {
    port: Port,
    reader: FrameReader,
    record: Option<RecordFile>,
    /// The run of the box that commands are made for: that of the last frame.
    session: u32,
    sequence: u32,
    waiting: Vec<(u32, Command, Instant)>,
}

impl Talk {
    fn ask(&mut self, command: Command) -> Result<(), Failure> {
        let mut buffer = [0; MAX_FRAME];
        let frame = encode(&command, self.session, self.sequence, &mut buffer)
            .map_err(|why| Failure::System(format!("a command cannot be sent: {why:?}")))?;
        self.port.send(frame)?;
        if command != Command::Heartbeat {
            self.waiting.push((self.sequence, command, Instant::now()));
        }
        self.sequence = self.sequence.wrapping_add(1);
        Ok(())
    }

    /// What has come; false once the box is gone.
    fn listen(&mut self, mut with: impl FnMut(Head, Telemetry)) -> Result<bool, Failure> {
        let mut bytes = [0; 4096];
        let Some(n) = self.port.read(&mut bytes)? else {
            return Ok(true);
        };
        let came = bytes.get(..n).unwrap_or_default();
        if let Some(file) = &mut self.record {
            file.write(came)?;
        }
        let (waiting, session) = (&mut self.waiting, &mut self.session);
        self.reader.take(came, |head, message| {
            *session = head.session;
            if let Telemetry::Reply(reply) = &message {
                waiting.retain(|(to, ..)| *to != reply.to);
            }
            with(head, message);
        });
        Ok(n > 0)
    }

    /// Commands without an answer after [`ANSWER`].
    fn unanswered(&mut self) -> Vec<Command> {
        let late = |(_, command, at): &(u32, Command, Instant)| {
            (at.elapsed() > ANSWER).then_some(*command)
        };
        let lost = self.waiting.iter().filter_map(late).collect();
        self.waiting.retain(|(.., at)| at.elapsed() <= ANSWER);
        lost
    }
}

fn settings(talk: &mut Talk) -> Result<u8, Failure> {
    let mut found = vec![None; SETTINGS.len()];
    // Whatever the box says names the session that the questions are for.
    talk.ask(Command::Identify)?;
    let asked = Instant::now();
    while talk.session == NO_SESSION && asked.elapsed() < ANSWER && talk.listen(|_, _| {})? {}
    for (k, setting) in SETTINGS.iter().enumerate() {
        // Asked three times: a link may lose a frame.
        for _ in 0..3 {
            talk.ask(Command::Read {
                setting: setting.number,
            })?;
            let asked = Instant::now();
            while found[k].is_none() && asked.elapsed() < ANSWER / 4 {
                let here = talk.listen(|_, message| {
                    if let Telemetry::Reply(reply) = message
                        && let Answer::Setting(s) = reply.answer
                        && s.setting == setting.number
                    {
                        found[k] = Some(s);
                    }
                })?;
                if !here {
                    return Err(talk.port.closed());
                }
            }
            if found[k].is_some() {
                break;
            }
        }
        let Some(s) = found[k] else {
            return Err(Failure::System(format!(
                "the box does not answer for {} (is it one, and the baud rate right?)",
                setting.name
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
    let (mut beat, mut drawn) = (Instant::now() - HEARTBEAT, Instant::now());
    let mut first = first.iter();
    loop {
        if args
            .seconds
            .is_some_and(|s| begun.elapsed().as_secs_f64() > s)
        {
            break;
        }
        if !args.look && beat.elapsed() >= HEARTBEAT {
            beat = Instant::now();
            talk.ask(Command::Heartbeat)?;
        }
        // One at a time, in order, each after the answer to the last.
        if talk.waiting.is_empty()
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
        if drawn.elapsed() >= REDRAW {
            drawn = Instant::now();
            view.draw(&talk.reader)?;
        }
    }
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
