//! The slow duty, once a millisecond: contacts, sensors, supervisor, set points, watchdog.

use super::SensorBox;
use crate::board::BoxBoard;
use crate::rig;
use heapless::Vec;
use rarma_box::guard::{Duty, Facts, FaultCode, Mode, Permission, RigSeen, Stage};
use rarma_box::settings::{LINK_HEARTBEAT, TACHO_PULSES, TACHO_SILENCE};
use rarma_box::wire::Telemetry;

/// So many failed readings of the slow sensors in a row are a fault.
const SENSORS_LOST: u32 = 3;
/// At most so many findings of the rig's watch are taken in one millisecond.
const MOST_FOUND: usize = 8;
/// A current sensor that reads more than this without current is faulty, A.
const MOST_ZERO_A: f32 = 0.25;

impl SensorBox {
    #[inline(never)]
    pub(super) fn tick<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        // Deadlines first: the pass after a stall checks in again and would hide it.
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
        let valve = self.rig.step(board, mode, permission, gate, &self.state);
        if !valve {
            self.fault(board, FaultCode::Valve, 0, 0.0, now_us);
        }
        if let Some(trip) = self.rig.report().trip {
            self.fault(board, trip.code, trip.coil, trip.value, now_us);
        }
        self.zeros(board, now_us);
        // Without coils the current loop need not run, and must not be missed.
        if self.rig.loop_ran() || mode != Mode::Cers {
            self.check_ins.here(Duty::Loop, now_us);
        }
        self.tacho(board, now_us);
        // At most one message of each kind in a millisecond.
        if let Some(news) = self.rig.bar.news() {
            self.tell.tell(board, &Telemetry::Circle(news));
        }
        if let Some(news) = self.rig.exciting.news() {
            self.tell.tell(board, &Telemetry::Excitation(news));
        }
        self.tell_findings(board, now_us);
        let seen = board.flash_seen();
        for (code, words) in [
            (FaultCode::FlashUnreadable, seen.unreadable_words),
            (FaultCode::FlashCorrected, seen.corrected_words),
        ] {
            if words > 0 {
                self.fault(board, code, 0, words as f32, now_us);
            }
        }
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
        // What does not fit is found again in the next millisecond.
        let mut found = Vec::<_, MOST_FOUND>::new();
        self.watch
            .update(mode, &limits, &seen, &mut |code, place, value| {
                let _ = found.push((code, place, value));
            });
        for (code, place, value) in found {
            self.fault(board, code, place, value, now_us);
        }
    }

    fn supervise<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) -> Permission {
        let contacts = board.contacts();
        let facts = Facts {
            now_us,
            enable: contacts.enable,
            stop_chain: contacts.stop_chain,
            energised: board.energised(),
            arrived: self.rig.arrived(),
            steady: self.rig.steady(),
            exciting: self.rig.exciting.runs(),
        };
        // Two at most: the gate, and the first of stop chain, enable input and host.
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

    pub(super) fn spindle_hz(&self, now_us: u64) -> Option<f32> {
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
}
