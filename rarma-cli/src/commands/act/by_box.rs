//! A box hears, over its link: it says what it hears, and is told the speed that turns.

use crate::advice::USUAL_HZ;
use crate::args::{ActArgs, USUAL_EVERY_S};
use crate::collect::{Collector, News};
use crate::commands::monitor::Beside;
use crate::commands::talk::Talk;
use crate::controller::words;
use crate::failure::Failure;
use crate::frames::{self, answer_words, to_json};
use crate::output::stdout;
use crate::port::Port;
use crate::{key, signals};
use rarma_box::guard::Mode;
use rarma_box::settings::{MONITOR_SPINDLE, MONITOR_TEETH, SettingValue};
use rarma_box::wire::{Answer, Command, Telemetry};
use rarma_core::monitor::MonitorConfig;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What an input that is a box begins with.
pub(super) const BOX: &str = "box:";
/// A speed is told at most this often.
const TELL_EVERY: Duration = Duration::from_millis(20);
/// It is told again after so long, as it is: a frame may be lost.
const TELL_AGAIN: Duration = Duration::from_secs(1);
/// And else if it differs by so much from what was told last, as a part of it: a tenth of what the box believes of a told
/// speed.
const TOLD_APART: f64 = 0.0005;

/// A box that is to hear.
pub(super) struct Listener {
    talk: Talk,
    name: String,
    teeth: u32,
    /// Rate of its microphone.
    fs_hz: f64,
    /// It is told the speed, and is started; else it is only looked at.
    controls: bool,
    told: Option<(f64, Instant)>,
    interrupted: Arc<AtomicBool>,
}

/// The port of the box, where the input is one.
pub(super) fn port_of(args: &ActArgs) -> Option<&str> {
    args.monitor.input.input.to_str()?.strip_prefix(BOX)
}

impl Listener {
    /// Asks the box who it is and what it knows of the cutter; `controls`: and takes control.
    ///
    /// # Errors
    /// There is no box, somebody else is in control of it, or nobody knows the teeth.
    pub(super) fn open(args: &ActArgs, name: &str, controls: bool) -> Result<Self, Failure> {
        own_settings(args)?;
        let key = args.key.as_deref().map(key::read).transpose()?;
        let port = Port::open(name, args.box_baud)?.impatient()?;
        if !port.answers() {
            return Err(Failure::Usage(format!(
                "{BOX}{name}: a box is needed that answers (a serial port such as /dev/ttyACM0, or tcp:HOST:PORT)"
            )));
        }
        let mut talk = Talk::new(port, None, key);
        talk.end_frame()?;
        let fs_hz = match talk.answer(Command::Identify)? {
            Answer::Identity(id) => f64::from(id.sample_rate_hz),
            _ => USUAL_HZ,
        };
        let setting = MONITOR_TEETH.number();
        let known = match talk.answer(Command::Read { setting })? {
            Answer::Setting(said) => said.value,
            _ => SettingValue::Whole(0),
        };
        let SettingValue::Whole(known) = known else {
            return Err(Failure::System(format!(
                "{name}: it does not tell the teeth"
            )));
        };
        let teeth = match args.monitor.teeth {
            Some(teeth) if !controls && teeth != known => {
                return Err(Failure::Usage(format!(
                    "--teeth {teeth}: the box is only looked at, and has {known} (leave it out, or set monitor.teeth on the box)"
                )));
            }
            Some(teeth) => teeth,
            None if known > 0 => known,
            None => {
                return Err(Failure::Usage(
                    "--teeth: the box does not know the number of teeth either, and without it no speed can be proposed"
                        .to_owned(),
                ));
            }
        };
        let interrupted = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&interrupted);
        signals::on_interrupt(move || set.store(true, Ordering::SeqCst))?;
        let mut this = Self {
            talk,
            name: name.to_owned(),
            teeth,
            fs_hz,
            controls,
            told: None,
            interrupted,
        };
        if controls {
            this.take()?;
        }
        Ok(this)
    }

    /// Teeth of the cutter.
    pub(super) fn teeth(&self) -> u32 {
        self.teeth
    }

    fn take(&mut self) -> Result<(), Failure> {
        let Some(take) = self
            .talk
            .speaker
            .take()
            .filter(|_| self.talk.speaker.is_free())
        else {
            let by = self.talk.speaker.control().map_or(0, |control| control.by);
            return Err(Failure::Usage(format!(
                "{BOX}{}: host {by:08x} is in control of the box, and must tell it the speed (let that one `release`, or end it)",
                self.name
            )));
        };
        self.done(take)
    }

    /// Has something done that the box must not refuse.
    fn done(&mut self, command: Command) -> Result<(), Failure> {
        match self.talk.answer(command)? {
            Answer::Refused(why) => Err(Failure::Input(format!(
                "{BOX}{}: {command:?}: {}",
                self.name,
                answer_words(&Answer::Refused(why))
            ))),
            _ => Ok(()),
        }
    }

    /// Tells the speed, 1/min.
    fn tell(&mut self, rpm: f64) -> Result<(), Failure> {
        let new = |(told, at): (f64, Instant)| {
            let moved = (rpm / told - 1.0).abs() > TOLD_APART;
            at.elapsed() >= if moved { TELL_EVERY } else { TELL_AGAIN }
        };
        if self.controls && rpm > 0.0 && self.told.is_none_or(new) && self.talk.is_answered() {
            self.told = Some((rpm, Instant::now()));
            self.talk.ask_itself(set_speed(rpm))?;
        }
        Ok(())
    }

    /// Starts the box at this speed, 1/min.
    fn start(&mut self, rpm: Option<f64>) -> Result<(), Failure> {
        if !self.controls {
            return Ok(());
        }
        if let Some(rpm) = rpm.filter(|rpm| *rpm > 0.0) {
            self.done(set_speed(rpm))?;
            self.told = Some((rpm, Instant::now()));
        }
        let setting = MONITOR_TEETH.number();
        let value = SettingValue::Whole(self.teeth);
        self.done(Command::Set { setting, value })?;
        self.done(Command::Start(Mode::Monitor))
    }

    /// Hears until somebody ends it; the exit code.
    ///
    /// # Errors
    /// The box is gone, or another host has taken control; what was said cannot be passed on.
    pub(super) fn hear(&mut self, beside: &mut dyn Beside, json: bool) -> Result<u8, Failure> {
        self.start(beside.speed_rpm(0.0))?;
        let mut collector = Collector::of_rate(self.fs_hz);
        let mut heard_s = 0.0;
        while !self.interrupted.load(Ordering::SeqCst) && !beside.failed() {
            let mut came = Vec::new();
            let here = self
                .talk
                .listen(|head, message| came.push((head, message)))?;
            for (head, message) in came {
                let own = self.talk.answers_itself(&message);
                let news = collector.take(&message);
                match &news {
                    News::Line(line) => heard_s = line.t,
                    News::On(alarm) => heard_s = alarm.on,
                    _ => {}
                }
                // Only what it hears: that the box lives is no sound.
                if matches!(news, News::Line(_) | News::On(_) | News::Off(_)) {
                    beside.take(&news);
                }
                if json {
                    say!("{}", to_json(head, &message, None));
                } else if let (false, Some(text)) = (own, shown(&message)) {
                    say!("{heard_s:8.3} s  {text}");
                }
            }
            while let Some(record) = beside.said() {
                if json {
                    say!(
                        "{}",
                        serde_json::to_string(&record).map_err(std::io::Error::from)?
                    );
                } else {
                    say!("{}", words(&record));
                }
            }
            stdout::check()?;
            if !here {
                return Err(self.talk.closed());
            }
            if self.controls && !self.talk.speaker.in_control() {
                return Err(Failure::System(format!(
                    "{BOX}{}: another host has taken control of the box, so that it cannot be told the speed any more",
                    self.name
                )));
            }
            self.talk.news.clear();
            self.talk.unanswered();
            if let Some(rpm) = beside.speed_rpm(heard_s) {
                self.tell(rpm)?;
            }
        }
        // As the command's other ways of hearing end.
        Ok(signals::INTERRUPTED as u8)
    }
}

/// Control is given up; the box listens on.
impl Drop for Listener {
    fn drop(&mut self) {
        if self.talk.speaker.in_control() {
            // One that is gone need not know.
            let _ = self.talk.answer(Command::Release);
        }
    }
}

fn set_speed(rpm: f64) -> Command {
    Command::Set {
        setting: MONITOR_SPINDLE.number(),
        value: SettingValue::Real((rpm / 60.0) as f32),
    }
}

/// What is worth a line: not how the box stands, nor what it answers.
fn shown(message: &Telemetry) -> Option<String> {
    match message {
        Telemetry::Status(_) | Telemetry::Health(_) | Telemetry::Reply(_) => None,
        _ => frames::words(message),
    }
}

/// What the box has settings of its own for is refused, and not passed over.
fn own_settings(args: &ActArgs) -> Result<(), Failure> {
    let of = &args.monitor;
    let same = |a: f64, b: f64| (a - b).abs() < f64::EPSILON;
    let usual = MonitorConfig::new(USUAL_HZ).threshold;
    let given = [
        (of.input.channel != 0, "--channel"),
        (of.input.fs.is_some(), "--fs"),
        (of.input.stream.is_some(), "--stream"),
        (of.input.raw.is_some(), "--raw"),
        (of.order != (8, 7), "--order"),
        (of.band.is_some(), "--band"),
        (!same(of.threshold, usual), "--threshold"),
        (of.idle.is_some(), "--idle"),
        (of.second.is_some(), "--second"),
        (of.tacho.is_some(), "--tacho"),
        (of.speed_from.is_some(), "--speed-from"),
        (of.rpm.is_some(), "--rpm"),
        (of.aliased, "--aliased"),
        (!of.numbers.set.is_empty(), "--set"),
        (!same(of.every, USUAL_EVERY_S), "--every"),
        (of.report.is_some(), "--report"),
        (!of.notes.is_empty(), "--note"),
    ];
    match given.iter().find(|(is, _)| *is) {
        Some((_, option)) => Err(Failure::Usage(format!(
            "{option}: a box hears by its own settings (`rarma connect PORT` sets them; leave the option out)"
        ))),
        None => Ok(()),
    }
}
