//! The whole box: duties at their rates, one supervisor, one link.
//!
//! | duty | rate | deadline |
//! |---|---|---|
//! | current loop | once a PWM period, in the board's interrupt | 3 ms |
//! | samples | every pass | 10 ms |
//! | slow: contacts, sensors, supervisor, set points, watchdog | 1 kHz | 4 ms |
//! | link | every pass | 10 ms |
//!
//! The main loop is `loop { poll; wait }`; one turn of it is a pass. A late pass is noticed by the
//! next one. A pass that never ends is noticed by the current loop, because its order expires and
//! is not renewed, and by the watchdog.

mod findings;
mod obey;
mod report;
mod start;
mod tick;

use crate::board::{BoxBoard, LEAST_BROWN_OUT_MV};
use crate::commands::Commands;
use crate::control::Control;
use crate::listen::{self, Listening};
use crate::rig::RigDuty;
use crate::rig::RigPlan;
use crate::store::Store;
use crate::tell::{Teller, ToldFaults};
use findings::Findings;
use rarma_box::guard::{
    CheckIns, Denial, Duty, FaultCode, FaultRecord, InARow, Mode, RigState, RigWatch, Severity,
    Stage, Supervisor,
};
use rarma_box::settings::{CERS_ORDER, Settings};
use rarma_box::wire::{Handed, NOBODY, Refused, Started};
use rarma_core::Order;
use rarma_rigs::cers::Reach;

/// One pass of the supervisor, µs.
const TICK_US: u64 = 1_000;

/// The whole box.
#[derive(Debug)]
pub struct SensorBox {
    settings: Settings,
    store: Store,
    findings: Findings,
    supervisor: Supervisor,
    listening: Listening,
    rig: RigDuty,
    tell: Teller,
    told: ToldFaults,
    control: Control,
    started: Started,
    before: Option<FaultRecord>,
    /// Found at the start, and not told yet.
    unsaid: Option<FaultRecord>,
    loop_hz: f64,
    sample_hz: f64,
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

impl SensorBox {
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
    fn fault<B: BoxBoard>(
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
            self.rig.exciting.forget();
            if self.supervisor.fault() == Some(record) {
                board.keep(&record.to_kept());
            }
        }
        let mode = self.supervisor.mode();
        self.told
            .tell(&mut self.tell, board, record, severity, mode);
        if severity == Severity::Trip && record.code == FaultCode::HeartbeatLost {
            // What it may still send, once it is heard again, is of another time.
            self.hand_over(board, NOBODY, Handed::HostLost, record.at_us);
        }
    }

    /// Starts a mode and what belongs to it.
    fn start_mode<B: BoxBoard>(&mut self, board: &mut B, mode: Mode) -> Result<(), Denial> {
        if mode == Mode::Monitor {
            if self.supervisor.stage().energised() {
                return Err(Denial::Energised);
            }
            self.listening
                .begin(board, &self.settings, None, &mut self.tell)
                .map_err(|_| Denial::Settings)?;
            return self.supervisor.start(mode);
        }
        let order = self.settings.whole(CERS_ORDER).checked_sub(1);
        let order = order.and_then(|n| Order::ALL.get(n as usize));
        if mode == Mode::Cers && order.is_some() {
            let job = listen::job(&self.settings, self.sample_hz);
            job.monitor.check().map_err(|_| Denial::Settings)?;
        }
        self.supervisor.start(mode)?;
        if let Some(mv) = board.brown_out_mv()
            && mv < LEAST_BROWN_OUT_MV
        {
            let (volts, now_us) = (f32::from(mv) * 1e-3, board.now_us());
            self.fault(board, FaultCode::BrownOutLow, 0, volts, now_us);
        }
        self.rig.exciting.forget();
        self.listening.end(board, &mut self.tell);
        if mode == Mode::Cers && order.is_some() {
            self.listening
                .begin(board, &self.settings, order.copied(), &mut self.tell)
                .map_err(|_| Denial::Settings)?;
        }
        Ok(())
    }

    /// Arms the outputs with the settings of now.
    fn arm<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) -> Result<(), Refused> {
        let plan = RigPlan::new(&self.settings, self.loop_hz).map_err(Refused::Denied)?;
        if self.supervisor.mode() == Mode::Cers && self.supervisor.stage() == Stage::Off {
            let reach = self.reach(&plan, now_us);
            reach.bias().map_err(Refused::OutOfReach)?;
            self.rig
                .exciting
                .still_goes(&reach)
                .map_err(Refused::OutOfReach)?;
        }
        // The emergency stop may have been pressed within this millisecond.
        if !board.contacts().stop_chain {
            return Err(Refused::Denied(Denial::StopChainOpen));
        }
        self.supervisor.arm(now_us).map_err(Refused::Denied)?;
        self.rig.arm(plan);
        Ok(())
    }

    /// What the coils can do with a plan, the supply and the spindle of now.
    fn reach(&self, plan: &RigPlan, now_us: u64) -> Reach {
        let spindle_hz = self.spindle_hz(now_us).unwrap_or(0.0);
        plan.reach(self.state.supply_v, spindle_hz)
    }

    fn samples<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        // At most one of each kind in a pass.
        let mut wrong: [Option<(FaultCode, f32)>; 7] = [None; 7];
        self.listening
            .pass(board, now_us, &mut self.tell, &mut |code, value| {
                if let Some(free) = wrong.iter_mut().find(|w| w.is_none()) {
                    *free = Some((code, value));
                }
            });
        for (code, value) in wrong.into_iter().flatten() {
            self.fault(board, code, 0, value, now_us);
        }
        self.listening.change_over(board, now_us, &mut self.tell);
        self.check_ins.here(Duty::Samples, now_us);
    }

    fn link<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        if self.commands.receive(board) {
            self.obey(board, now_us);
        }
        self.check_ins.here(Duty::Link, now_us);
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
