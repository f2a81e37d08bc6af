//! Commands are carried out here, and every one is answered. What comes and what may be done are known
//! elsewhere ([`Commands`](crate::commands::Commands), [`Control`](crate::control::Control)).

use super::SensorBox;
use crate::board::BoxBoard;
use crate::commands::{Came, PASS_BYTES, PASS_FRAMES, Said};
use crate::control::Ruling;
use crate::rig::RigPlan;
use crate::store::{Kept, StoreError};
use rarma_box::guard::{Denial, FaultCode, Mode, Stage};
use rarma_box::settings::{MONITOR_SPINDLE, SettingError, SettingValue, find};
use rarma_box::wire::{
    Answer, Command, Handed, MAX_FRAME, NOBODY, Refused, Reply, SettingMessage, Telemetry,
};
use rarma_rigs::cers::ExcitationJob;

/// Longest stream, s.
const MOST_STREAM_S: f32 = 3600.0;

impl SensorBox {
    /// One pass over what has come.
    #[inline(never)]
    pub(super) fn obey<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        if self.commands.is_flooded() {
            self.fault(board, FaultCode::LinkFlood, 0, PASS_BYTES as f32, now_us);
        }
        let mut plain = [0; MAX_FRAME];
        for _ in 0..PASS_FRAMES {
            let (by, to, result) = match self.commands.next(&mut plain) {
                None => break,
                Some(Came::Garbage) => continue,
                Some(Came::Unknown(sequence, why)) => (NOBODY, sequence, Err(why)),
                Some(Came::Command(said)) => {
                    (said.by, said.sequence, self.decide(board, now_us, &said))
                }
            };
            let answer = result.unwrap_or_else(Answer::Refused);
            self.commands.count(&answer);
            self.tell
                .tell(board, &Telemetry::Reply(Reply { by, to, answer }));
        }
        if let Some(broken) = self.commands.garbage() {
            self.fault(board, FaultCode::LinkGarbage, 0, broken as f32, now_us);
        }
    }

    fn decide<B: BoxBoard>(
        &mut self,
        board: &mut B,
        now_us: u64,
        said: &Said<'_>,
    ) -> Result<Answer, Refused> {
        let (session, key) = (self.tell.session(), self.settings.link_key());
        match self.control.rule(board, said, session, key) {
            Ruling::Do => {
                let result = self.carry_out(board, now_us, said.command);
                let answer = result.unwrap_or_else(Answer::Refused);
                self.control.remember(said, &answer);
                Ok(answer)
            }
            Ruling::Stop => {
                if self.control.is_held() {
                    self.hand_over(board, NOBODY, Handed::Stopped, now_us);
                }
                self.supervisor.stop(now_us);
                Ok(Answer::Done)
            }
            Ruling::Take => {
                self.hand_over(board, said.by, Handed::Taken, now_us);
                Ok(Answer::Done)
            }
            Ruling::Doubled(result) => {
                self.commands.count_doubled();
                result
            }
            Ruling::No(why) => Err(why),
        }
    }

    /// Control changes hands: another turn begins, outputs that are on go down in order, and
    /// everybody is told.
    pub(super) fn hand_over<B: BoxBoard>(
        &mut self,
        board: &mut B,
        by: u32,
        why: Handed,
        now_us: u64,
    ) {
        self.control.hand_over(by, why, board.entropy());
        self.supervisor.hand_over(now_us);
        // A signal that waits for the next arming is the last host's wish.
        self.rig.exciting.quiet();
        let message = self.control_message();
        self.tell.tell(board, &Telemetry::Control(message));
    }

    fn carry_out<B: BoxBoard>(
        &mut self,
        board: &mut B,
        now_us: u64,
        command: Command,
    ) -> Result<Answer, Refused> {
        let done =
            |result: Result<(), Denial>| result.map(|()| Answer::Done).map_err(Refused::Denied);
        match command {
            Command::Identify => {
                // Who asks may not have been there at the start.
                self.findings.tell_again();
                Ok(Answer::Identity(self.identity::<B>()))
            }
            Command::Heartbeat => {
                self.supervisor.heartbeat(now_us);
                Ok(Answer::Done)
            }
            Command::Read { setting } => self.shown(board, setting),
            Command::Set { setting, value } => {
                self.settings
                    .set(setting, value)
                    .map_err(Refused::Setting)?;
                // What a duty has read already; a speed it knows is no news to it.
                self.listening
                    .tell_speed(self.settings.real(MONITOR_SPINDLE));
                self.shown(board, setting)
            }
            Command::Save { setting } => {
                let value = self.settings.to_store(setting);
                self.keep(board, setting, value, now_us)
            }
            Command::Reset { setting } => {
                let (_, row) = find(setting).ok_or(Refused::Setting(SettingError::Unknown))?;
                self.settings
                    .set(setting, row.default_value())
                    .map_err(Refused::Setting)?;
                self.listening
                    .tell_speed(self.settings.real(MONITOR_SPINDLE));
                self.keep(board, setting, None, now_us)
            }
            Command::Start(mode) => done(self.start_mode(board, mode)),
            Command::Stop => {
                self.supervisor.stop(now_us);
                Ok(Answer::Done)
            }
            Command::Arm => self.arm(board, now_us).map(|()| Answer::Done),
            Command::Clear => {
                let energised = board.energised();
                let result = self.supervisor.clear(now_us, energised);
                if result.is_ok() {
                    self.told.forget();
                    self.rig.clear();
                }
                done(result)
            }
            Command::Stream { seconds } => {
                if !(0.0..=MOST_STREAM_S).contains(&seconds) {
                    return Err(Refused::Denied(Denial::Limit));
                }
                self.listening.stream(seconds);
                Ok(Answer::Done)
            }
            Command::Pressure { pa } => {
                self.ready(Mode::Ldbb)?;
                done(self.rig.want_pressure(pa))
            }
            Command::Current { a } => {
                self.ready(Mode::Cers)?;
                done(self.rig.want_current(a))
            }
            Command::Circle(job) => {
                self.ready(Mode::Ldbb)?;
                done(self.rig.want_circle(&job))
            }
            Command::Excite(job) => self.excite(&job, now_us),
            Command::Quiet => {
                self.rig.exciting.quiet();
                Ok(Answer::Done)
            }
            Command::Stand(job) => {
                self.ready(Mode::Ldbb)?;
                done(self.rig.want_stand(&job))
            }
            Command::Go => {
                self.ready(Mode::Ldbb)?;
                done(self.rig.bar.go())
            }
            // The ruling has handed control over already.
            Command::Take { .. } => Ok(Answer::Done),
            Command::Release => {
                self.hand_over(board, NOBODY, Handed::GivenUp, now_us);
                Ok(Answer::Done)
            }
            Command::Status => {
                self.tell_status(board, now_us);
                Ok(Answer::Done)
            }
        }
    }

    /// A signal is checked against the plan in force where there is one, and against the
    /// settings of now where outputs are off: it is refused before anything is energised.
    fn excite(&mut self, job: &ExcitationJob, now_us: u64) -> Result<Answer, Refused> {
        if self.supervisor.mode() != Mode::Cers {
            return Err(Refused::Denied(Denial::Mode));
        }
        let plan = match self.supervisor.stage() {
            Stage::Off => RigPlan::new(&self.settings, self.loop_hz).map_err(Refused::Denied)?,
            Stage::Ready => *self.rig.plan(),
            Stage::Faulted => return Err(Refused::Denied(Denial::FaultLatched)),
            _ => return Err(Refused::Denied(Denial::NotReady)),
        };
        let reach = self.reach(&plan, now_us);
        self.rig
            .exciting
            .want(job, &reach)
            .map_err(Refused::OutOfReach)?;
        Ok(Answer::Done)
    }

    /// Set points are taken at the working point of the mode that owns them.
    fn ready(&self, mode: Mode) -> Result<(), Refused> {
        if self.supervisor.mode() != mode {
            Err(Refused::Denied(Denial::Mode))
        } else if self.supervisor.stage() != Stage::Ready {
            Err(Refused::Denied(Denial::NotReady))
        } else {
            Ok(())
        }
    }

    fn shown<B: BoxBoard>(&self, board: &mut B, number: u16) -> Result<Answer, Refused> {
        let (_, setting) = find(number).ok_or(Refused::Setting(SettingError::Unknown))?;
        let value = self.settings.get(number).unwrap_or(setting.default_value());
        let (flash, range) = board.flash();
        // An unreadable or outdated record counts as none: the default follows.
        let stored = self
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
        &mut self,
        board: &mut B,
        number: u16,
        value: Option<SettingValue>,
        now_us: u64,
    ) -> Result<Answer, Refused> {
        let (place, setting) = find(number).ok_or(Refused::Setting(SettingError::Unknown))?;
        // An erase stalls the processor for longer than an order of the current loop lasts.
        if self.supervisor.stage().in_use() {
            return Err(Refused::Denied(Denial::Energised));
        }
        let (flash, range) = board.flash();
        match self.store.write(flash, range, setting, value) {
            Ok(Kept::Twice) => self.shown(board, number),
            Ok(Kept::Once) => {
                let (code, place) = (FaultCode::SettingOnce, place as u8);
                self.fault(board, code, place, f32::from(number), now_us);
                self.shown(board, number)
            }
            Err(StoreError::Full) => {
                self.fault(board, FaultCode::FlashFull, 0, f32::from(number), now_us);
                Err(Refused::FlashFull)
            }
            Err(StoreError::Flash | StoreError::Range) => {
                self.fault(board, FaultCode::FlashWrite, 0, f32::from(number), now_us);
                Err(Refused::Flash)
            }
        }
    }
}
