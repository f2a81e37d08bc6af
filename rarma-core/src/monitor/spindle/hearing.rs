//! What follows from the lines that are found in the sound: whose speed it is, and what is
//! removed.

use super::Spindle;
use crate::condition::{Finding, Lock};
use crate::decide::SPEED_ACCURACY;
use crate::real::Real;

/// Parts of the told speed up to which a speed that is heard may stand for it: most
/// machines' overrides reach further down, where the sound contradicts the setting.
const OVERRIDE: (f64, f64) = (0.75, 1.25);
/// So many times in a row the sound must contradict the setting with the same speed, within
/// this part of it, and it is not believed; deviation of that speed, as a part of it.
const DENIED: u8 = 3;
const SAME_CONTRADICTION: f64 = 0.015;
const CONTRADICTION_SD: f64 = 1e-3;

impl<T: Real> Spindle<T> {
    /// What the search for lines has found.
    pub(super) fn take(&mut self, finding: Finding<T>) {
        let (speed, sd) = match finding {
            Finding::NotEstimable => {
                self.try_told();
                return;
            }
            // A chatter and its overtones are a comb as well: one that nobody told of,
            // with its first line in the band, proves no rotation.
            Finding::Found(comb) if self.told.is_none() && self.is_in_band(comb.spacing_hz) => {
                self.hear_doubtful(comb.spacing_hz, comb.sd_hz);
                return;
            }
            Finding::Found(comb) => {
                self.contradiction = None;
                self.denied = 0;
                self.unconfirmed_s = None;
                (comb.spacing_hz, comb.sd_hz)
            }
            Finding::Contradiction { told_hz, found_hz } => {
                self.contradict(told_hz, found_hz);
                let sd_hz = found_hz * T::from_f64(CONTRADICTION_SD);
                if !self.is_denied() || self.is_in_band(found_hz) {
                    self.hear_doubtful(found_hz, sd_hz);
                    return;
                }
                (found_hz, sd_hz)
            }
        };
        self.found = Some(((speed, sd), T::ZERO));
        self.found_at_entry = self.is_entering();
        self.retell(speed);
        // Started on the mean over an entry, the lines lock a percent beside the speed.
        if let Some(lines) = &mut self.lines
            && (lines.lock() != Lock::Locked || lines.are_slow())
            && self.tacho_reading.is_none()
            && !self.found_at_entry
        {
            lines.start(speed, sd);
        }
    }

    /// A comb with its first line in the band may be the overtones of a chatter.
    fn is_in_band(&self, spacing_hz: T) -> bool {
        spacing_hz >= self.low_hz
    }

    /// The sound shows another speed than the told one. Each time the same one: then the
    /// setting is wrong, unless it is a chatter's own lines that show it.
    fn contradict(&mut self, told_hz: T, found_hz: T) {
        let same = self.contradiction.is_some_and(|(_, before)| {
            (found_hz - before).abs() < before * T::from_f64(SAME_CONTRADICTION)
        });
        self.denied = match (self.standing.is_held(), same) {
            (true, _) => self.denied,
            (false, true) => self.denied.saturating_add(1),
            (false, false) => 1,
        };
        self.contradiction = Some((self.setting.unwrap_or(told_hz), found_hz));
    }

    /// The told speed is not believed any more.
    pub(super) fn is_denied(&self) -> bool {
        self.denied >= DENIED
    }

    /// Too few lines for a comb: if the told speed is right they are found at its multiples.
    fn try_told(&mut self) {
        if self.is_denied() {
            return;
        }
        if let (Some(told), Some(lines)) = (self.told, &mut self.lines)
            && lines.lock() != Lock::Locked
            && !lines.is_running()
            && self.tacho_reading.is_none()
        {
            lines.try_speed(told, told * T::from_f64(SPEED_ACCURACY));
        }
    }

    /// What was heard stands for what was told, as far as an override reaches.
    pub(super) fn carry(&mut self, speed: T) -> bool {
        let (least, most) = OVERRIDE;
        let within = self.setting.is_some_and(|setting| {
            speed > setting * T::from_f64(least) && speed < setting * T::from_f64(most)
        });
        if within {
            self.told = Some(speed);
            self.denied = 0;
        }
        within
    }

    /// The same, and the search looks there from now on.
    fn retell(&mut self, speed: T) {
        if self.carry(speed)
            && let Some(finder) = &mut self.finder
        {
            // Out of its range it keeps what it was told.
            let _ = finder.tell(Some(speed));
        }
    }
}
