//! What the box tells of itself: who it is, status and health at their rates, the lights.

use super::{SensorBox, TICK_US};
use crate::board::{BoxBoard, Lights};
use rarma_box::guard::FaultCode;
use rarma_box::settings::{SCHEMA_VERSION, SETTINGS, TELL_HEALTH, TELL_STATUS};
use rarma_box::wire::{ControlMessage, Health, Identity, Status, Telemetry};

impl SensorBox {
    /// Status and health at their rates, and the lights.
    pub(super) fn report<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
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

    pub(super) fn tell_status<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
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
            press_again: self.supervisor.press_again(),
            control: self.control_message(),
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

    /// Whose turn it is.
    pub(super) fn control_message(&self) -> ControlMessage {
        self.control.message(self.settings.link_key().is_some())
    }

    /// Who this is.
    pub(super) fn identity<B: BoxBoard>(&self) -> Identity {
        // Names are the program's own and short; one that is too long would be cut to nothing.
        Identity {
            board: B::NAME.try_into().unwrap_or_default(),
            version: env!("CARGO_PKG_VERSION").try_into().unwrap_or_default(),
            schema: SCHEMA_VERSION,
            settings: SETTINGS.len() as u16,
            sample_rate_hz: self.sample_hz as f32,
            loop_rate_hz: self.loop_hz as f32,
            started: self.started,
            before: self.before,
            control: self.control_message(),
        }
    }
}

/// The next multiple of a period after now.
fn next(now_us: u64, last_us: u64, period_s: f32) -> u64 {
    let period = ((f64::from(period_s) * 1e6) as u64).max(TICK_US);
    (last_us + period).max(now_us + 1)
}
