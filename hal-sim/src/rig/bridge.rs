//! The fast side: what the current loop's interrupt sees and does.

use super::plant::{COILS, GAPS, Plant};
use firmware::BoardErrorKind;
use firmware::board::{AdcCode, CoilBridge};

/// State of bridges and their sensors.
#[derive(Debug, Clone, Default)]
pub struct SimBridge {
    /// Duty of the next period; it takes effect at that period's start (PWM delay).
    pub(super) next: Option<[f32; COILS]>,
    /// Duty of this period; none: switches open.
    pub(super) now: Option<[f32; COILS]>,
    /// A comparator has broken the timers.
    pub(super) break_latched: Option<u8>,
    pub(super) break_new: bool,
    pub(super) codes: [AdcCode; COILS],
    pub(super) gaps: [AdcCode; GAPS],
    pub(super) refuse: bool,
    pub(super) dead: bool,
}

impl SimBridge {
    /// Samples the sensors of this period; `lost` and `stuck` name coils by bits.
    pub(super) fn sample(&mut self, plant: &mut Plant, lost: u8, stuck: u8) {
        for k in 0..COILS {
            let code = plant.current_code(k);
            if lost & (1 << k) != 0 {
                self.codes[k] = AdcCode(0);
            } else if stuck & (1 << k) == 0 {
                self.codes[k] = AdcCode(code);
            }
        }
    }

    /// The comparator of a coil trips: no software is needed for this.
    pub(super) fn trip(&mut self, coil: u8) {
        if self.break_latched.is_none() {
            self.break_latched = Some(coil);
            self.break_new = true;
        }
        self.now = None;
        self.next = None;
    }
}

impl CoilBridge for SimBridge {
    type Error = BoardErrorKind;

    fn currents(&mut self) -> Result<[AdcCode; COILS], BoardErrorKind> {
        if self.dead {
            Err(BoardErrorKind::Refused)
        } else {
            Ok(self.codes)
        }
    }

    fn gaps(&mut self) -> [AdcCode; GAPS] {
        self.gaps
    }

    fn set_duty(&mut self, duty: [f32; COILS]) -> Result<(), BoardErrorKind> {
        if self.refuse {
            self.off();
            return Err(BoardErrorKind::Refused);
        }
        if self.break_latched.is_none() {
            self.next = Some(duty);
        }
        Ok(())
    }

    fn off(&mut self) {
        self.next = None;
        self.now = None;
    }

    fn broken(&mut self) -> Option<u8> {
        if std::mem::take(&mut self.break_new) {
            self.break_latched
        } else {
            None
        }
    }

    fn rearm(&mut self) {
        self.break_latched = None;
    }
}
