//! The link duty's receiving half: bytes in, commands carried out, every one answered.
//!
//! Called at every pass. A fixed number of bytes a pass, so that a flood takes time from
//! nobody else.

use crate::board::BoxBoard;
use crate::control::{Ruling, Said};
use crate::rig::RigPlan;
use crate::sensor_box::SensorBox;
use crate::store::{Kept, StoreError};
use rarma_box::guard::{Denial, FaultCode, Mode, Stage};
use rarma_box::settings::{
    MONITOR_SPINDLE, SCHEMA_VERSION, SETTINGS, SettingError, SettingValue, find,
};
use rarma_box::wire::{
    Answer, Command, Deframer, FrameError, Handed, Head, Identity, MAX_FRAME, NOBODY, Opened,
    Order, Refused, Reply, Seal, SettingMessage, Telemetry, VERSION, open,
};
use rarma_rigs::cers::ExcitationJob;

/// Bytes taken in one pass, and commands carried out in one.
const PASS_BYTES: usize = 128;
const PASS_COMMANDS: u32 = 4;
/// Passes in a row that were full: a flood.
const FLOOD_PASSES: u32 = 20;
/// Broken frames are told once this many have come.
const GARBAGE_FRAMES: u32 = 3;
/// Longest stream, s.
const MOST_STREAM_S: f32 = 3600.0;

/// What has come.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Commands answered.
    pub answered: u32,
    /// Of them, refused.
    pub refused: u32,
    /// Of them, not carried out because of their numbers: copies, overtaken, old.
    pub doubled: u32,
    /// Frames that were broken.
    pub garbage: u32,
}

/// See the module.
#[derive(Debug, Default)]
pub struct Commands {
    deframer: Deframer,
    /// Bytes taken from the link and not looked at yet.
    waiting: heapless::Deque<u8, PASS_BYTES>,
    counts: Counts,
    garbage_told: u32,
    full_passes: u32,
}

impl Commands {
    /// What has come.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Takes what has come. True if there is something to do in a [`Self::pass`].
    pub fn receive<B: BoxBoard>(&mut self, board: &mut B) -> bool {
        let mut bytes = [0; PASS_BYTES];
        let room = PASS_BYTES - self.waiting.len();
        let came = bytes
            .get_mut(..room)
            .and_then(|free| board.receive(free).ok())
            .unwrap_or(0);
        for &byte in bytes.iter().take(came) {
            // There is room: no more was asked for.
            let _ = self.waiting.push_back(byte);
        }
        self.full_passes = if came == room {
            self.full_passes.saturating_add(1)
        } else {
            0
        };
        !self.waiting.is_empty()
    }

    /// One pass over what [`Self::receive`] has taken.
    pub fn pass<B: BoxBoard>(&mut self, all: &mut SensorBox, board: &mut B, now_us: u64) {
        if self.full_passes >= FLOOD_PASSES {
            all.fault(board, FaultCode::LinkFlood, 0, PASS_BYTES as f32, now_us);
        }
        let mut plain = [0; MAX_FRAME];
        let mut done = 0;
        while done < PASS_COMMANDS
            && let Some(byte) = self.waiting.pop_front()
        {
            let frame = match self.deframer.collect(byte) {
                None => continue,
                Some(Ok(stuffed)) => open(stuffed, &mut plain),
                Some(Err(why)) => Err(why),
            };
            done += 1;
            match frame {
                Err(_) => self.counts.garbage = self.counts.garbage.saturating_add(1),
                Ok(frame) => self.answer(all, board, now_us, &frame),
            }
        }
        let broken = self.counts.garbage.wrapping_sub(self.garbage_told);
        if broken >= GARBAGE_FRAMES {
            self.garbage_told = self.counts.garbage;
            all.fault(board, FaultCode::LinkGarbage, 0, broken as f32, now_us);
        }
    }

    fn answer<B: BoxBoard>(
        &mut self,
        all: &mut SensorBox,
        board: &mut B,
        now_us: u64,
        frame: &Opened<'_>,
    ) {
        self.counts.answered = self.counts.answered.wrapping_add(1);
        let (by, result) = match frame.order() {
            Ok((order, seal)) => {
                let said = said(frame.head, order, seal);
                (order.by, self.obey(all, board, now_us, &said))
            }
            Err(FrameError::Version { .. }) => {
                let box_version = VERSION;
                (NOBODY, Err(Refused::Version { box_version }))
            }
            Err(_) => (NOBODY, Err(Refused::NotACommand)),
        };
        let answer = result.unwrap_or_else(Answer::Refused);
        if matches!(answer, Answer::Refused(_)) {
            self.counts.refused = self.counts.refused.wrapping_add(1);
        }
        let to = frame.head.sequence;
        all.tell
            .tell(board, &Telemetry::Reply(Reply { by, to, answer }));
    }

    fn obey<B: BoxBoard>(
        &mut self,
        all: &mut SensorBox,
        board: &mut B,
        now_us: u64,
        said: &Said<'_>,
    ) -> Result<Answer, Refused> {
        match all.rule(board, said, now_us) {
            Ruling::Do => {
                let result = carry_out(all, board, now_us, said.command);
                let answer = result.unwrap_or_else(Answer::Refused);
                all.ruled(said, &answer);
                Ok(answer)
            }
            Ruling::Answered(answer) => Ok(answer),
            Ruling::Doubled(result) => {
                self.counts.doubled = self.counts.doubled.wrapping_add(1);
                result
            }
            Ruling::No(why) => Err(why),
        }
    }
}

fn said<'a>(head: Head, order: Order, seal: Seal<'a>) -> Said<'a> {
    Said {
        by: order.by,
        command: order.command,
        session: head.session,
        sequence: head.sequence,
        crc: head.crc,
        seal,
    }
}

fn carry_out<B: BoxBoard>(
    all: &mut SensorBox,
    board: &mut B,
    now_us: u64,
    command: Command,
) -> Result<Answer, Refused> {
    let done = |result: Result<(), Denial>| result.map(|()| Answer::Done).map_err(Refused::Denied);
    match command {
        Command::Identify => {
            // Who asks may not have been there at the start.
            all.findings.tell_again();
            Ok(Answer::Identity(identity::<B>(all)))
        }
        Command::Heartbeat => {
            all.supervisor.heartbeat(now_us);
            Ok(Answer::Done)
        }
        Command::Read { setting } => shown(all, board, setting),
        Command::Set { setting, value } => {
            all.settings.set(setting, value).map_err(Refused::Setting)?;
            // What a duty has read already; a speed it knows is no news to it.
            all.listening.tell_speed(all.settings.real(MONITOR_SPINDLE));
            shown(all, board, setting)
        }
        Command::Save { setting } => {
            let value = all.settings.to_store(setting);
            keep(all, board, setting, value, now_us)
        }
        Command::Reset { setting } => {
            let (_, row) = find(setting).ok_or(Refused::Setting(SettingError::Unknown))?;
            all.settings
                .set(setting, row.default_value())
                .map_err(Refused::Setting)?;
            all.listening.tell_speed(all.settings.real(MONITOR_SPINDLE));
            keep(all, board, setting, None, now_us)
        }
        Command::Start(mode) => done(all.start_mode(board, mode)),
        Command::Stop => {
            all.supervisor.stop(now_us);
            Ok(Answer::Done)
        }
        Command::Arm => all.arm(board, now_us).map(|()| Answer::Done),
        Command::Clear => {
            let energised = board.energised();
            let result = all.supervisor.clear(now_us, energised);
            if result.is_ok() {
                all.tell.forget_faults();
                all.rig.clear();
            }
            done(result)
        }
        Command::Stream { seconds } => {
            if !(0.0..=MOST_STREAM_S).contains(&seconds) {
                return Err(Refused::Denied(Denial::Limit));
            }
            all.listening.stream(seconds);
            Ok(Answer::Done)
        }
        Command::Pressure { pa } => {
            ready(all, Mode::Ldbb)?;
            done(all.rig.want_pressure(pa))
        }
        Command::Current { a } => {
            ready(all, Mode::Cers)?;
            done(all.rig.want_current(a))
        }
        Command::Circle(job) => {
            ready(all, Mode::Ldbb)?;
            done(all.rig.want_circle(&job))
        }
        Command::Excite(job) => excite(all, &job, now_us),
        Command::Quiet => {
            all.rig.exciting.quiet();
            Ok(Answer::Done)
        }
        Command::Stand(job) => {
            ready(all, Mode::Ldbb)?;
            done(all.rig.want_stand(&job))
        }
        Command::Go => {
            ready(all, Mode::Ldbb)?;
            done(all.rig.bar.go())
        }
        // The ruling has handed control over already.
        Command::Take { .. } => Ok(Answer::Done),
        Command::Release => {
            all.hand_over(board, NOBODY, Handed::GivenUp, now_us);
            Ok(Answer::Done)
        }
        Command::Status => {
            all.tell_status(board, now_us);
            Ok(Answer::Done)
        }
    }
}

/// A signal is checked against the plan in force where there is one, and against the
/// settings of now where outputs are off: it is refused before anything is energised.
fn excite(all: &mut SensorBox, job: &ExcitationJob, now_us: u64) -> Result<Answer, Refused> {
    if all.supervisor.mode() != Mode::Cers {
        return Err(Refused::Denied(Denial::Mode));
    }
    let plan = match all.supervisor.stage() {
        Stage::Off => RigPlan::new(&all.settings, all.loop_hz).map_err(Refused::Denied)?,
        Stage::Ready => *all.rig.plan(),
        Stage::Faulted => return Err(Refused::Denied(Denial::FaultLatched)),
        _ => return Err(Refused::Denied(Denial::NotReady)),
    };
    let reach = all.reach(&plan, now_us);
    all.rig
        .exciting
        .want(job, &reach)
        .map_err(Refused::OutOfReach)?;
    Ok(Answer::Done)
}

/// Set points are taken at the working point of the mode that owns them.
fn ready(all: &SensorBox, mode: Mode) -> Result<(), Refused> {
    if all.supervisor.mode() != mode {
        Err(Refused::Denied(Denial::Mode))
    } else if all.supervisor.stage() != Stage::Ready {
        Err(Refused::Denied(Denial::NotReady))
    } else {
        Ok(())
    }
}

pub(crate) fn identity<B: BoxBoard>(all: &SensorBox) -> Identity {
    // Names are the program's own and short; one that is too long would be cut to nothing.
    Identity {
        board: B::NAME.try_into().unwrap_or_default(),
        version: env!("CARGO_PKG_VERSION").try_into().unwrap_or_default(),
        schema: SCHEMA_VERSION,
        settings: SETTINGS.len() as u16,
        sample_rate_hz: all.sample_hz as f32,
        loop_rate_hz: all.loop_hz as f32,
        started: all.started,
        before: all.before,
        control: all.control_message(),
    }
}

fn shown<B: BoxBoard>(all: &SensorBox, board: &mut B, number: u16) -> Result<Answer, Refused> {
    let (_, setting) = find(number).ok_or(Refused::Setting(SettingError::Unknown))?;
    let value = all.settings.get(number).unwrap_or(setting.default_value());
    let (flash, range) = board.flash();
    // An unreadable or outdated record counts as none: the default follows.
    let stored = all
        .store
        .read(flash, range, setting)
        .ok()
        .and_then(Result::ok)
        .flatten()
        .map(SettingValue::shown);
    Ok(Answer::Setting(SettingMessage {
        setting: number,
        value,
        stored,
    }))
}

fn keep<B: BoxBoard>(
    all: &mut SensorBox,
    board: &mut B,
    number: u16,
    value: Option<SettingValue>,
    now_us: u64,
) -> Result<Answer, Refused> {
    let (place, setting) = find(number).ok_or(Refused::Setting(SettingError::Unknown))?;
    // An erase stalls the processor for longer than an order of the current loop lasts.
    if all.supervisor.stage().in_use() {
        return Err(Refused::Denied(Denial::Energised));
    }
    let (flash, range) = board.flash();
    match all.store.write(flash, range, setting, value) {
        Ok(Kept::Twice) => shown(all, board, number),
        Ok(Kept::Once) => {
            let (code, place) = (FaultCode::SettingOnce, place as u8);
            all.fault(board, code, place, f32::from(number), now_us);
            shown(all, board, number)
        }
        Err(StoreError::Full) => {
            all.fault(board, FaultCode::FlashFull, 0, f32::from(number), now_us);
            Err(Refused::FlashFull)
        }
        Err(StoreError::Flash | StoreError::Range) => {
            all.fault(board, FaultCode::FlashWrite, 0, f32::from(number), now_us);
            Err(Refused::Flash)
        }
    }
}
