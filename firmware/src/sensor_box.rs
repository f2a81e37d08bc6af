//! The whole box: duties at their rates, one supervisor, one link.
//!
//! | duty | rate | deadline |
//! |---|---|---|
//! | current loop | once a PWM period, in the board's interrupt | 3 ms |
//! | samples | every pass | 10 ms |
//! | slow: contacts, sensors, supervisor, set points, watchdog | 1 kHz | 4 ms |
//! | link | every pass | 10 ms |
//!
//! The main loop is `loop { poll; wait }`. A pass that is late is seen by the next one; one
//! that never ends is seen by the current loop, whose order runs out, and by the watchdog.

use crate::board::{BoxBoard, Lights, ResetCause};
use crate::commands::Commands;
use crate::listen::Listening;
use crate::rig::{self, RigDuty, RigPlan};
use crate::store::{self, Loaded};
use crate::tell::Teller;
use rarma_core::guard::{
    CheckIns, Denial, Duty, Facts, FaultCode, FaultRecord, InARow, KEPT_BYTES, Mode, RigSeen,
    RigState, RigWatch, Severity, Stage, Supervisor,
};
use rarma_core::settings::{
    BOX_START, LINK_HEARTBEAT, Settings, TACHO_PULSES, TACHO_SILENCE, TELL_HEALTH, TELL_STATUS,
};
use rarma_core::wire::{Health, Started, Status, Telemetry};

/// One pass of the supervisor, µs.
const TICK_US: u64 = 1_000;
/// Readings of the slow sensors in a row that failed and are a fault.
const SENSORS_LOST: u32 = 3;
/// A current sensor's zero further off than this is no zero, A.
const MOST_ZERO_A: f32 = 0.25;

/// See the module.
#[derive(Debug)]
pub struct SensorBox {
    pub(crate) settings: Settings,
    pub(crate) supervisor: Supervisor,
    pub(crate) listening: Listening,
    pub(crate) rig: RigDuty,
    pub(crate) tell: Teller,
    pub(crate) started: Started,
    pub(crate) before: Option<FaultRecord>,
    pub(crate) loop_hz: f64,
    pub(crate) sample_hz: f64,
    commands: Commands,
    watch: RigWatch,
    check_ins: CheckIns,
    next_tick_us: u64,
    next_status_us: u64,
    next_health_us: u64,
    state: RigState,
    sensors_lost: InARow,
    dropped_told: u32,
    alive: bool,
}

/// What a start has found, to be said once the box is in its place.
#[derive(Debug, Clone, Copy)]
pub struct Opening {
    now_us: u64,
    past: Option<FaultRecord>,
    loaded: Loaded,
}

impl SensorBox {
    /// Starts: reads why there was a reset and what is stored, and says so. Outputs are off.
    pub fn start<B: BoxBoard>(board: &mut B) -> Self {
        let (mut this, opening) = Self::prepare(board);
        this.open(board, opening);
        this
    }

    /// First half of [`Self::start`], for a board that keeps the box in a static because it
    /// is large: reads why there was a reset and what is stored.
    pub fn prepare<B: BoxBoard>(board: &mut B) -> (Self, Opening) {
        board.drop_outputs();
        let now_us = board.now_us();
        let (started, before, past) = past(board, now_us);
        // Read once: the next reset without a fault must not tell this one again.
        board.keep(&[0; KEPT_BYTES]);
        let mut settings = Settings::default();
        let loaded = store::load_from(board, &mut settings);
        // Not armed with this plan: arming makes its own and refuses settings that disagree.
        let plan = RigPlan::unchecked(&settings, B::LOOP_RATE_HZ);
        let this = Self {
            supervisor: Supervisor::new(past),
            listening: Listening::new(B::SAMPLE_RATE_HZ),
            rig: RigDuty::new(plan),
            tell: Teller::default(),
            commands: Commands::default(),
            watch: RigWatch::default(),
            check_ins: CheckIns::new(now_us),
            next_tick_us: now_us,
            next_status_us: now_us,
            next_health_us: now_us,
            state: RigState::default(),
            sensors_lost: InARow::default(),
            dropped_told: 0,
            alive: false,
            loop_hz: B::LOOP_RATE_HZ,
            sample_hz: B::SAMPLE_RATE_HZ,
            settings,
            started,
            before,
        };
        let opening = Opening {
            now_us,
            past,
            loaded,
        };
        (this, opening)
    }

    /// Second half of [`Self::start`]: says what was found, and begins to listen if the
    /// settings say so.
    pub fn open<B: BoxBoard>(&mut self, board: &mut B, opening: Opening) {
        let hello = crate::commands::identity::<B>(self);
        self.tell.tell(board, &Telemetry::Hello(hello));
        if let Some(record) = opening.past {
            self.tell.fault(board, record, Severity::Trip, Mode::Safe);
        }
        self.tell_loaded(board, opening.now_us, opening.loaded);
        if self.settings.whole(BOX_START) == 1 {
            // Settings that do not fit leave the box in Safe; the host sees the mode.
            let _ = self.start_mode(board, Mode::Monitor);
        }
    }

    fn tell_loaded<B: BoxBoard>(&mut self, board: &mut B, now_us: u64, loaded: Loaded) {
        if loaded.lost {
            self.fault(board, FaultCode::SettingsLost, 0, 0.0, now_us);
        }
        if let Some(number) = loaded.refused {
            self.fault(
                board,
                FaultCode::SettingRefused,
                0,
                f32::from(number),
                now_us,
            );
        }
    }

    /// Runs for ever.
    pub fn run<B: BoxBoard>(&mut self, board: &mut B) -> ! {
        loop {
            self.poll(board);
            board.wait();
        }
    }

    /// One pass of the main loop. Does not wait.
    pub fn poll<B: BoxBoard>(&mut self, board: &mut B) {
        let now_us = board.now_us();
        if now_us >= self.next_tick_us {
            // A late pass does not try to catch up: the deadline has been looked at.
            self.next_tick_us = (self.next_tick_us + TICK_US).max(now_us + 1);
            self.tick(board, now_us);
        }
        self.samples(board, now_us);
        self.link(board, now_us);
    }

    /// Something is wrong: trips at once where it must, keeps and tells it.
    pub(crate) fn fault<B: BoxBoard>(
        &mut self,
        board: &mut B,
        code: FaultCode,
        place: u8,
        value: f32,
        now_us: u64,
    ) {
        let record = FaultRecord {
            code,
            place,
            value,
            at_us: now_us,
        };
        let severity = self.supervisor.report(record);
        self.consequences(board, record, severity);
    }

    fn consequences<B: BoxBoard>(
        &mut self,
        board: &mut B,
        record: FaultRecord,
        severity: Severity,
    ) {
        if severity == Severity::Trip {
            board.drop_outputs();
            self.rig.fall();
            if self.supervisor.fault() == Some(record) {
                board.keep(&record.to_kept());
            }
        }
        self.tell
            .fault(board, record, severity, self.supervisor.mode());
    }

    /// Starts a mode and what belongs to it.
    pub(crate) fn start_mode<B: BoxBoard>(
        &mut self,
        board: &mut B,
        mode: Mode,
    ) -> Result<(), Denial> {
        if mode == Mode::Monitor {
            if self.supervisor.stage().energised() {
                return Err(Denial::Energised);
            }
            self.listening
                .begin(board, &self.settings, &mut self.tell)
                .map_err(|_| Denial::Settings)?;
            return self.supervisor.start(mode);
        }
        self.supervisor.start(mode)?;
        self.listening.end(board, &mut self.tell);
        Ok(())
    }

    /// Arms the outputs with the settings of now.
    pub(crate) fn arm<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) -> Result<(), Denial> {
        let plan = RigPlan::new(&self.settings, self.loop_hz)?;
        // The emergency stop may have been pressed within this millisecond.
        if !board.contacts().stop_chain {
            return Err(Denial::StopChainOpen);
        }
        self.supervisor.arm(now_us)?;
        self.rig.arm(plan);
        Ok(())
    }

    fn tick<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        // First of all: who was not here? A stall must not be cured by the pass after it.
        if let Some((duty, age)) = self.check_ins.late(now_us) {
            let seconds = age as f32 * 1e-6;
            let code = match duty {
                Duty::Loop => FaultCode::LoopSilent,
                _ => FaultCode::DeadlineMissed,
            };
            self.fault(board, code, duty as u8, seconds, now_us);
        }
        self.supervisor
            .set_heartbeat_limit(self.settings.real(LINK_HEARTBEAT));
        self.watch(board, now_us);
        let permission = self.supervise(board, now_us);
        let gate = self.gate(board, permission.gate, now_us);
        let mode = self.supervisor.mode();
        let valve = self
            .rig
            .step(board, mode, permission, gate, self.state.supply_v);
        if !valve {
            self.fault(board, FaultCode::Valve, 0, 0.0, now_us);
        }
        if let Some(trip) = self.rig.report().trip {
            self.fault(board, trip.code, trip.coil, trip.value, now_us);
        }
        self.zeros(board, now_us);
        // Where coils are not in use the loop may sleep.
        if self.rig.loop_ran() || mode != Mode::Cers {
            self.check_ins.here(Duty::Loop, now_us);
        }
        self.tacho(board, now_us);
        self.report(board, now_us);
        self.check_ins.here(Duty::Slow, now_us);
        if self.check_ins.feed() {
            board.feed_watchdog();
        }
    }

    /// The zeros of the current sensors, once they have been measured.
    fn zeros<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        if self.supervisor.mode() != Mode::Cers || self.supervisor.stage() != Stage::Ramping {
            return;
        }
        let zeros = self.rig.report().zero_a;
        for (coil, zero) in zeros.into_iter().enumerate() {
            if !(zero.abs() <= MOST_ZERO_A) {
                self.fault(
                    board,
                    FaultCode::CurrentSensorOffset,
                    coil as u8,
                    zero,
                    now_us,
                );
            }
        }
    }

    /// Reads the slow sensors and judges them.
    fn watch<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        let Ok(sensors) = board.sensors() else {
            if self.sensors_lost.bad(true, SENSORS_LOST) {
                self.fault(board, FaultCode::SensorsLost, 0, 0.0, now_us);
            }
            return;
        };
        self.sensors_lost.bad(false, SENSORS_LOST);
        let mode = self.supervisor.mode();
        let limits = *self.rig.plan().limits();
        let codes = rig::codes(&sensors);
        self.state = limits.state(&codes);
        let seen = RigSeen {
            codes,
            coils: self.rig.coils(),
            set_pa: (mode == Mode::Ldbb && self.supervisor.stage().energised())
                .then_some(self.rig.set_pa()),
            spindle_hz: self.spindle_hz(now_us),
        };
        let mut watch = core::mem::take(&mut self.watch);
        watch.update(mode, &limits, &seen, &mut |code, place, value| {
            self.fault(board, code, place, value, now_us);
        });
        self.watch = watch;
    }

    fn supervise<B: BoxBoard>(
        &mut self,
        board: &mut B,
        now_us: u64,
    ) -> rarma_core::guard::Permission {
        let contacts = board.contacts();
        let facts = Facts {
            now_us,
            enable: contacts.enable,
            stop_chain: contacts.stop_chain,
            energised: board.energised(),
            arrived: self.rig.arrived(),
        };
        // At most one of the stop, the enable input and the host, and the gate.
        let mut trips = [None; 2];
        let permission = self.supervisor.tick(&facts, &mut |record, severity| {
            if let Some(free) = trips.iter_mut().find(|t| t.is_none()) {
                *free = Some((record, severity));
            }
        });
        for (record, severity) in trips.into_iter().flatten() {
            self.consequences(board, record, severity);
        }
        permission
    }

    /// Makes the gate what the supervisor wants. Off is ordered again every millisecond.
    fn gate<B: BoxBoard>(&mut self, board: &mut B, wanted: bool, now_us: u64) -> bool {
        if !(wanted && self.supervisor.gate()) {
            board.drop_outputs();
            return false;
        }
        if !board.energised() && board.energise().is_err() {
            self.fault(board, FaultCode::Gate, 0, 0.0, now_us);
            return false;
        }
        true
    }

    fn spindle_hz(&self, now_us: u64) -> Option<f32> {
        let pulses = self.settings.whole(TACHO_PULSES);
        if pulses == 0 {
            return None;
        }
        let (hz, _) = self.listening.pulses(now_us);
        hz.map(|hz| hz / pulses as f32)
    }

    fn tacho<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        if self.settings.whole(TACHO_PULSES) == 0 {
            return;
        }
        let (_, silence_us) = self.listening.pulses(now_us);
        let silence = silence_us as f32 * 1e-6;
        if silence > self.settings.real(TACHO_SILENCE) {
            self.listening.forget_tacho();
            self.fault(board, FaultCode::TachoSilent, 0, silence, now_us);
        }
    }

    fn samples<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        // At most one of each kind in a pass.
        let mut wrong: [Option<(FaultCode, f32)>; 6] = [None; 6];
        self.listening
            .pass(board, now_us, &mut self.tell, &mut |code, value| {
                if let Some(free) = wrong.iter_mut().find(|w| w.is_none()) {
                    *free = Some((code, value));
                }
            });
        for (code, value) in wrong.into_iter().flatten() {
            self.fault(board, code, 0, value, now_us);
        }
        self.check_ins.here(Duty::Samples, now_us);
    }

    fn link<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        let mut commands = core::mem::take(&mut self.commands);
        commands.pass(self, board, now_us);
        self.commands = commands;
        self.check_ins.here(Duty::Link, now_us);
    }

    /// Status and health at their rates, and the lights.
    fn report<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        if now_us >= self.next_status_us {
            self.next_status_us =
                next(now_us, self.next_status_us, self.settings.real(TELL_STATUS));
            self.tell_status(board, now_us);
            self.tell_dropped(board, now_us);
            self.alive = !self.alive;
            let energised = board.energised();
            board.lights(Lights {
                alive: self.alive,
                energised,
                warning: self.supervisor.fault().is_some(),
            });
        }
        if now_us >= self.next_health_us {
            self.next_health_us =
                next(now_us, self.next_health_us, self.settings.real(TELL_HEALTH));
            let health = self.health(now_us);
            self.tell.tell(board, &Telemetry::Health(health));
        }
    }

    /// The link takes frames again after it had not.
    fn tell_dropped<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        let dropped = self.tell.dropped();
        if dropped != self.dropped_told {
            let lost = dropped.wrapping_sub(self.dropped_told);
            self.fault(board, FaultCode::LinkBlocked, 0, lost as f32, now_us);
            if self.tell.dropped() == dropped {
                self.dropped_told = dropped;
            }
        }
    }

    pub(crate) fn tell_status<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        let contacts = board.contacts();
        let report = self.rig.report();
        let status = Status {
            now_us,
            mode: self.supervisor.mode(),
            stage: self.supervisor.stage(),
            energised: board.energised(),
            contacts: (contacts.enable, contacts.stop_chain),
            fault: self.supervisor.fault(),
            current_a: report.current_a,
            heat: self.watch.theta().into_iter().fold(0.0, f32::max),
            gap_m: self.state.gap_m,
            pressure_pa: self.state.pressure_pa,
            gauge_m: self.state.gauge_m,
            supply_v: self.state.supply_v,
            limiting: report.limiting,
        };
        self.tell.tell(board, &Telemetry::Status(status));
    }

    /// Counts since start-up.
    pub fn health(&self, now_us: u64) -> Health {
        let (samples, missing, verdicts) = self.listening.counts();
        let counts = self.commands.counts();
        Health {
            now_us,
            samples,
            missing,
            verdicts,
            frames: self.tell.frames(),
            dropped: self.tell.dropped(),
            commands: counts.answered,
            refused: counts.refused,
            doubled: counts.doubled,
            garbage: counts.garbage,
            late: self.check_ins.times_late(),
            longest_us: self
                .check_ins
                .longest_us()
                .map(|us| u32::try_from(us).unwrap_or(u32::MAX)),
        }
    }

    /// Mode, stage and latched fault.
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}

/// The next multiple of a period after now.
fn next(now_us: u64, last_us: u64, period_s: f32) -> u64 {
    let period = ((f64::from(period_s) * 1e6) as u64).max(TICK_US);
    (last_us + period).max(now_us + 1)
}

/// Why the box started, the record that was kept, and what of it is to be latched.
fn past<B: BoxBoard>(
    board: &mut B,
    now_us: u64,
) -> (Started, Option<FaultRecord>, Option<FaultRecord>) {
    let kept = FaultRecord::from_kept(&board.kept());
    let of = |code| FaultRecord {
        code,
        place: 0,
        value: 0.0,
        at_us: now_us,
    };
    match board.reset_cause() {
        // After a power-up the memory holds anything.
        ResetCause::PowerOn => (Started::PowerOn, None, None),
        ResetCause::BrownOut => (Started::BrownOut, kept, Some(of(FaultCode::BrownOut))),
        ResetCause::Watchdog => (Started::Watchdog, kept, Some(of(FaultCode::Watchdog))),
        ResetCause::Software => (Started::Software, kept, kept.or(Some(of(FaultCode::Panic)))),
        ResetCause::Pin => (Started::Pin, kept, None),
    }
}
