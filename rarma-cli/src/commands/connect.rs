//! `rarma connect`: a box on a wire, live.

use super::talk::Talk;
use crate::advice::AtBox;
use crate::args::ConnectArgs;
use crate::failure::Failure;
use crate::frames::Teller;
use crate::key;
use crate::output::{self, RecordFile, stdout};
use crate::port::Port;
use crate::screen::{self, Screen};
use crate::signals;
use rarma_box::settings::SETTINGS;
use rarma_box::wire::{Answer, Command, Head, Telemetry};
use rarma_recordings::FrameReader;
use rarma_scenarios::speech;
use std::io::{self, BufRead};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender, TryRecvError};
use std::time::{Duration, Instant};

/// The box's answer to the last word of all is waited for so long.
const PARTING: Duration = Duration::from_millis(300);

pub(super) fn main(args: &ConnectArgs) -> Result<u8, Failure> {
    let mut first = Vec::new();
    for line in &args.say {
        first.push(speech::command(line).map_err(|why| Failure::Usage(format!("--say: {why}")))?);
    }
    let key = args.key.as_deref().map(key::read).transpose()?;
    if !args.settings && args.set_key.is_none() {
        // What cannot be shown is said before the port is opened.
        screen::wanted(args.screen, args.json, false)?;
    }
    let port = Port::open(&args.port, args.baud)?;
    if !port.answers() {
        return Err(Failure::Usage(format!(
            "{}: a box is needed that answers; use `rarma decode` for a file",
            args.port
        )));
    }
    let record = args.record.as_deref().map(output::record).transpose()?;
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
    // Typed faster than said: whoever types waits.
    let (say, typed) = mpsc::sync_channel(16);
    let left = Arc::new(AtomicBool::new(false));
    let (interrupted, leave) = (Arc::clone(&left), Arc::clone(&left));
    signals::on_interrupt(move || interrupted.store(true, Ordering::Relaxed))?;
    let mut view = if screen::wanted(args.screen, args.json, false)? {
        let title = args.port.clone();
        let leave = Box::new(move || leave.store(true, Ordering::Relaxed));
        View::Screen(Screen::of_box(title, say, leave)?)
    } else {
        type_lines(say);
        let teller = Box::default();
        if args.json {
            View::Json(teller)
        } else {
            View::Lines(teller)
        }
    };
    let talked = talked(talk, args, first, &typed, (&mut view, &left));
    let parted = part(talk);
    let recorded = talk.record.take().map_or(Ok(()), RecordFile::end);
    let shown = view.close();
    if let Some(losses) = talk.reader.losses() {
        eprintln!("{}: {losses}", args.port);
    }
    talked
        .and(parted)
        .and(recorded.map_err(Failure::from))
        .and(shown)?;
    if talk.reader.whole == 0 {
        return Err(Failure::System(format!(
            "{}: no whole frame came (is it a box, and the baud rate right?)",
            args.port
        )));
    }
    Ok(0)
}

/// Until somebody goes.
///
/// # Errors
/// The box is gone, or what it said cannot be passed on.
fn talked(
    talk: &mut Talk,
    args: &ConnectArgs,
    first: &[Command],
    typed: &Receiver<String>,
    (view, left): (&mut View, &AtomicBool),
) -> Result<(), Failure> {
    talk.ask(Command::Identify)?;
    // The picture needs to know some settings, and advice the teeth.
    let reads = match view {
        View::Screen(_) => screen::settings(),
        View::Lines(_) | View::Json(_) => vec![AtBox::setting()],
    };
    let mut reads = reads.into_iter().map(|setting| Command::Read { setting });
    let mut first = first.iter();
    let begun = Instant::now();
    // A host that does not only look takes control where nobody has it, once.
    let mut takes = !args.look;
    while !left.load(Ordering::Relaxed)
        && args
            .seconds
            .is_none_or(|s| begun.elapsed().as_secs_f64() <= s)
    {
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
        if talk.is_answered() {
            if let Some(read) = reads.next() {
                talk.ask_itself(read)?;
            } else if let Some(command) = first.next() {
                talk.ask(*command)?;
            }
        }
        match typed.try_recv() {
            Ok(line) if line.trim().is_empty() => {}
            Ok(line) if speech::goes(&line) => return Ok(()),
            Ok(line) => match speech::command(&line) {
                Ok(command) => talk.ask(command)?,
                Err(why) => view.event(why),
            },
            Err(TryRecvError::Empty | TryRecvError::Disconnected) => {}
        }
        let mut came = Vec::new();
        let here = talk.listen(|head, message| came.push((head, message)))?;
        for (head, message) in came {
            view.take(head, &message, talk.answers_itself(&message));
        }
        view.frames(&talk.reader);
        stdout::check()?;
        if !here && talk.reader.whole > 0 {
            return Err(talk.closed());
        } else if !here {
            // It is told that it may be no box.
            return Ok(());
        }
        for command in talk.unanswered() {
            view.event(format!("no answer to {command:?}"));
        }
        for news in talk.news.drain(..) {
            view.event(news);
        }
    }
    Ok(())
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

/// Lines of standard input.
fn type_lines(say: SyncSender<String>) {
    std::thread::spawn(move || {
        for line in io::stdin().lock().lines() {
            let Ok(line) = line else { break };
            if say.send(line).is_err() {
                break;
            }
        }
    });
}

/// Who is told what the box says.
enum View {
    Screen(Screen),
    /// Lines as they come.
    Lines(Box<Teller>),
    /// For a program.
    Json(Box<Teller>),
}

impl View {
    fn event(&self, text: String) {
        match self {
            Self::Screen(screen) => screen.event(text),
            Self::Lines(_) | Self::Json(_) => eprintln!("{text}"),
        }
    }

    /// `own`: it answers what nobody has typed.
    fn take(&mut self, head: Head, message: &Telemetry, own: bool) {
        match self {
            Self::Screen(screen) => screen.message(message, own),
            Self::Json(teller) => say!("{}", teller.json(head, message)),
            Self::Lines(teller) => {
                let text = teller.words(message);
                match message {
                    Telemetry::Reply(reply) if own || reply.answer == Answer::Done => {}
                    Telemetry::Health(_) => {}
                    _ => text.into_iter().for_each(|text| say!("{text}")),
                }
            }
        }
    }

    fn frames(&self, reader: &FrameReader) {
        if let Self::Screen(screen) = self {
            screen.frames(reader.whole, reader.losses());
        }
    }

    fn close(self) -> Result<(), Failure> {
        match self {
            Self::Screen(screen) => screen.close(),
            Self::Lines(_) | Self::Json(_) => Ok(()),
        }
    }
}
