//! What was found in the store of settings at the start, told one by one, by name.
//!
//! Slow path: one message a millisecond, and again for a host that says `identify`, for
//! nobody may have been there when the box started.

use super::SensorBox;
use crate::board::BoxBoard;
use crate::store::{Loaded, Marks};
use rarma_box::guard::FaultCode;
use rarma_box::settings::{COUNT, SETTINGS};

/// A setting's place in the table is told as a fault's place.
const _: () = assert!(COUNT <= u8::MAX as usize);

/// What was found in the store, and what has been told of it.
#[derive(Debug)]
pub(super) struct Findings {
    loaded: Loaded,
    next: u16,
}

impl Findings {
    pub fn new(loaded: Loaded) -> Self {
        Self { loaded, next: 0 }
    }

    /// Begins anew.
    pub fn tell_again(&mut self) {
        self.next = 0;
    }

    /// The next one, with place and value.
    fn take(&mut self) -> Option<(FaultCode, u8, f32)> {
        let loaded = &self.loaded;
        let kinds: [(FaultCode, &Marks); 5] = [
            (FaultCode::SettingDefault, &loaded.defaulted),
            (FaultCode::SettingOlder, &loaded.older),
            (FaultCode::SettingRefused, &loaded.refused),
            (FaultCode::SettingRepaired, &loaded.repaired),
            (FaultCode::SettingOnce, &loaded.once),
        ];
        loop {
            let number = usize::from(self.next);
            self.next = self.next.saturating_add(1);
            match number {
                0 if loaded.lost => return Some((FaultCode::SettingsLost, 0, 0.0)),
                1 if loaded.damaged_words > 0 => {
                    let words = loaded.damaged_words as f32;
                    return Some((FaultCode::FlashUnreadable, 0, words));
                }
                0 | 1 => continue,
                _ => {}
            }
            let (kind, place) = ((number - 2) / COUNT, (number - 2) % COUNT);
            let Some((code, marks)) = kinds.get(kind) else {
                self.next = number as u16;
                return None;
            };
            if marks.has(place)
                && let Some(setting) = SETTINGS.get(place)
            {
                return Some((*code, place as u8, f32::from(setting.number)));
            }
        }
    }
}

impl SensorBox {
    /// Tells one of what was found; one that the link does not take comes again with
    /// `identify`.
    pub(super) fn tell_findings<B: BoxBoard>(&mut self, board: &mut B, now_us: u64) {
        if let Some((code, place, value)) = self.findings.take() {
            self.fault(board, code, place, value, now_us);
        }
    }
}
