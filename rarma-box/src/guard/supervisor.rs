//! Who may energise what, and when: modes, stages, trips.
//!
//! ```text
//! Off --arm--> Precharge --steady--> Calibrating --20 ms--> Ramping --ramp--> Ready
//! Ready <--signal--> Exciting,   either --stop--> Stopping --> Off
//!   any of them --trip--> Faulted --clear, causes gone--> Off
//! ```
//! After a trip the enable input has to be released and pressed again: its level allows
//! outputs to stay on, only its edge allows them to come back.
//!
//! Rate: once a millisecond, and at every command. The answer of [`Supervisor::tick`] is the
//! only permission there is: nothing else in the box closes the output gate.

use super::fault::{FaultCode, FaultRecord, Severity};
use super::mode::{Mode, Stage};
use serde::{Deserialize, Serialize};

/// Time for the zeros of the sensors, µs.
pub const CALIBRATION_US: u64 = 20_000;
/// A supply that is not steady by then is a fault, µs.
pub const PRECHARGE_US: u64 = 2_000_000;

/// Why a command is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Denial {
    /// Not in this mode.
    Mode,
    /// Only while outputs are off.
    Energised,
    /// Only while outputs are at their working point.
    NotReady,
    /// A fault is latched: clear it first.
    FaultLatched,
    /// The cause of the fault is still there.
    FaultStands,
    /// The enable input is open.
    EnableOpen,
    /// The enable input has not been released since the last trip or the last change of control: release it and
    /// press it again.
    EnableHeld,
    /// The emergency-stop chain is open.
    StopChainOpen,
    /// The host has sent no heartbeat lately.
    NoHeartbeat,
    /// Beyond a limit, or not a number.
    Limit,
    /// Settings contradict each other.
    Settings,
}

/// What the supervisor sees each millisecond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facts {
    /// Now, µs.
    pub now_us: u64,
    /// Enable input closed.
    pub enable: bool,
    /// Emergency-stop chain closed.
    pub stop_chain: bool,
    /// The output gate's read-back.
    pub energised: bool,
    /// The set point has arrived where the stage sends it.
    pub arrived: bool,
    /// The supply has not moved for a while.
    pub steady: bool,
    /// A signal runs on top of the working point.
    pub exciting: bool,
}

/// What is allowed from now on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Permission {
    /// The output gate is to be closed.
    pub gate: bool,
    /// Zeros are to be measured.
    pub calibrate: bool,
    /// Set points go to the working point; otherwise to nothing.
    pub rise: bool,
}

/// The gate's read-back may lag behind the order by this, µs.
const GATE_LAG_US: u64 = 3_000;

/// The enable input counts as released only after so long, µs: a loose contact or a bouncing relay is shorter.
pub const RELEASED_US: u64 = 50_000;

/// Decides which outputs may be energised, and trips them.
#[derive(Debug, Clone)]
pub struct Supervisor {
    mode: Mode,
    stage: Stage,
    since_us: u64,
    gate: bool,
    gate_since_us: u64,
    heartbeat_us: Option<u64>,
    heartbeat_limit_us: u64,
    fault: Option<FaultRecord>,
    contacts: (bool, bool),
    press_again: bool,
    open_since_us: Option<u64>,
}

impl Supervisor {
    /// A supervisor at start-up. `past` is the fault that a reset has left behind: it is
    /// latched.
    pub fn new(past: Option<FaultRecord>) -> Self {
        Self {
            mode: Mode::Safe,
            stage: if past.is_some() {
                Stage::Faulted
            } else {
                Stage::Off
            },
            since_us: 0,
            gate: false,
            gate_since_us: 0,
            heartbeat_us: None,
            heartbeat_limit_us: 500_000,
            fault: past,
            contacts: (false, false),
            press_again: past.is_some(),
            open_since_us: None,
        }
    }

    /// The mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The stage.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// The fault that is latched.
    pub fn fault(&self) -> Option<FaultRecord> {
        self.fault
    }

    /// Silence of the host that is too long, s.
    pub fn set_heartbeat_limit(&mut self, limit_s: f32) {
        self.heartbeat_limit_us = (limit_s * 1e6) as u64;
    }

    /// The host is there.
    pub fn heartbeat(&mut self, now_us: u64) {
        self.heartbeat_us = Some(now_us);
    }

    /// Time since the last heartbeat, µs.
    pub fn heartbeat_age_us(&self, now_us: u64) -> Option<u64> {
        self.heartbeat_us.map(|at| now_us.saturating_sub(at))
    }

    /// Starts a mode.
    ///
    /// # Errors
    /// Outputs are on, or an output mode is asked for while a fault is latched.
    pub fn start(&mut self, mode: Mode) -> Result<(), Denial> {
        if self.stage.in_use() {
            return Err(Denial::Energised);
        }
        if self.stage == Stage::Faulted && mode.owns_outputs() {
            return Err(Denial::FaultLatched);
        }
        self.mode = mode;
        Ok(())
    }

    /// The enable input has to be released and pressed before outputs can be armed: there has
    /// been a trip since it was pressed, or control has changed hands over outputs that were on.
    pub fn press_again(&self) -> bool {
        self.press_again
    }

    /// Control has changed: outputs in use are let down in order, and the enable input has to be pressed anew before the
    /// next arming.
    pub fn hand_over(&mut self, now_us: u64) {
        if self.stage.in_use() {
            self.want_press();
            self.stop(now_us);
        }
    }

    fn want_press(&mut self) {
        self.press_again = true;
        self.open_since_us = None;
    }

    /// Arms the outputs of the mode.
    ///
    /// # Errors
    /// What is missing.
    pub fn arm(&mut self, now_us: u64) -> Result<(), Denial> {
        if !self.mode.owns_outputs() {
            return Err(Denial::Mode);
        }
        match self.stage {
            Stage::Off => {}
            Stage::Faulted => return Err(Denial::FaultLatched),
            _ => return Err(Denial::Energised),
        }
        let (enable, stop_chain) = self.contacts;
        if !stop_chain {
            return Err(Denial::StopChainOpen);
        }
        if !enable {
            return Err(Denial::EnableOpen);
        }
        if self.press_again {
            return Err(Denial::EnableHeld);
        }
        if !self.heard(now_us) {
            return Err(Denial::NoHeartbeat);
        }
        self.go(Stage::Precharge, now_us);
        Ok(())
    }

    /// Lets the outputs down in order, from any stage; does nothing if they are off.
    pub fn stop(&mut self, now_us: u64) {
        match self.stage {
            Stage::Ramping | Stage::Ready | Stage::Exciting => self.go(Stage::Stopping, now_us),
            Stage::Precharge | Stage::Calibrating => self.go(Stage::Off, now_us),
            Stage::Off | Stage::Stopping | Stage::Faulted => {}
        }
    }

    /// Forgets the fault.
    ///
    /// # Errors
    /// Its cause is still there: the emergency-stop chain is open, or the gate is closed
    /// although it should not be.
    pub fn clear(&mut self, now_us: u64, energised: bool) -> Result<(), Denial> {
        if self.stage != Stage::Faulted {
            return Ok(());
        }
        if !self.contacts.1 || energised {
            return Err(Denial::FaultStands);
        }
        self.fault = None;
        self.go(Stage::Off, now_us);
        Ok(())
    }

    /// Reports a fault, and returns how grave it is in this mode. A trip takes effect at once: [`Self::gate`] is false from
    /// now on, and the next [`Self::tick`] permits nothing.
    pub fn report(&mut self, record: FaultRecord) -> Severity {
        let severity = record.code.severity(self.mode);
        let in_use =
            !matches!(self.stage, Stage::Off) || record.code.severity(Mode::Safe) == Severity::Trip;
        match severity {
            Severity::Trip if in_use => {
                // The first fault is the cause; what follows are its consequences.
                if self.fault.is_none() {
                    self.fault = Some(record);
                }
                self.gate = false;
                self.gate_since_us = record.at_us;
                if self.stage != Stage::Faulted {
                    self.want_press();
                    self.go(Stage::Faulted, record.at_us);
                }
                Severity::Trip
            }
            // A part of an output that is off: worth a word, and arming will find it.
            Severity::Trip => Severity::Notice,
            other => other,
        }
    }

    /// Whether the gate may be closed at this moment.
    pub fn gate(&self) -> bool {
        self.gate
    }

    /// One millisecond: looks at the contacts, the host and the gate, moves the stage on.
    /// `trip` is told what has just gone wrong, if anything.
    pub fn tick(
        &mut self,
        facts: &Facts,
        trip: &mut impl FnMut(FaultRecord, Severity),
    ) -> Permission {
        let now = facts.now_us;
        self.contacts = (facts.enable, facts.stop_chain);
        let mut wrong = |this: &mut Self, code: FaultCode, value: f32| {
            let record = FaultRecord {
                code,
                place: 0,
                value,
                at_us: now,
            };
            let severity = this.report(record);
            trip(record, severity);
        };
        if !facts.stop_chain {
            if self
                .fault
                .is_none_or(|f| f.code != FaultCode::EmergencyStop)
            {
                wrong(self, FaultCode::EmergencyStop, 0.0);
            }
        } else if self.stage.in_use() {
            if !facts.enable {
                wrong(self, FaultCode::EnableLost, 0.0);
            } else if !self.heard(now) {
                let age = self.heartbeat_age_us(now).unwrap_or(0);
                wrong(self, FaultCode::HeartbeatLost, age as f32 * 1e-6);
            }
        }
        self.look_at_enable(facts);
        let settled = now.saturating_sub(self.gate_since_us) > GATE_LAG_US;
        if settled
            && facts.energised != self.gate
            && self.fault.is_none_or(|f| f.code != FaultCode::Gate)
        {
            wrong(self, FaultCode::Gate, f32::from(u8::from(facts.energised)));
        }
        let in_stage = now.saturating_sub(self.since_us);
        match self.stage {
            Stage::Precharge if facts.steady => self.go(Stage::Calibrating, now),
            Stage::Precharge if in_stage >= PRECHARGE_US => {
                wrong(self, FaultCode::SupplyUnsteady, in_stage as f32 * 1e-6);
            }
            Stage::Calibrating if in_stage >= CALIBRATION_US => self.go(Stage::Ramping, now),
            Stage::Ramping if facts.arrived && in_stage > 1000 => self.go(Stage::Ready, now),
            Stage::Ready if facts.exciting => self.go(Stage::Exciting, now),
            Stage::Exciting if !facts.exciting => self.go(Stage::Ready, now),
            Stage::Stopping if facts.arrived && in_stage > 1000 => self.go(Stage::Off, now),
            _ => {}
        }
        let gate = self.stage.energised();
        if gate != self.gate {
            self.gate = gate;
            self.gate_since_us = now;
        }
        Permission {
            gate,
            calibrate: self.stage == Stage::Calibrating,
            rise: matches!(self.stage, Stage::Ramping | Stage::Ready | Stage::Exciting),
        }
    }

    /// A release and a press after it, both with the emergency-stop chain closed.
    fn look_at_enable(&mut self, facts: &Facts) {
        if !facts.stop_chain {
            self.want_press();
        } else if !facts.enable {
            self.open_since_us = self.open_since_us.or(Some(facts.now_us));
        } else if let Some(since_us) = self.open_since_us.take()
            && facts.now_us.saturating_sub(since_us) >= RELEASED_US
        {
            self.press_again = false;
        }
    }

    fn heard(&self, now_us: u64) -> bool {
        self.heartbeat_age_us(now_us)
            .is_some_and(|age| age <= self.heartbeat_limit_us)
    }

    fn go(&mut self, stage: Stage, now_us: u64) {
        self.stage = stage;
        self.since_us = now_us;
    }
}
