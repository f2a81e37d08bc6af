//! Is anything being cut? The level of the band against its level at idle.
//!
//! Rate: decision rate. Idle is either told (a stretch of time) or found: the
//! quietest tenth of a second so far, once the signal has shown that it knows two
//! levels. Until then nothing is called idle, because a recording that starts in
//! the cut has no idle to compare with.

use crate::real::Real;
use crate::visit::state;

/// A level above this multiple of the idle level is a cut (6 dB).
pub(crate) const CUT_RATIO: f64 = 2.0;
/// Found idle counts only after a level this much above it has been seen (12 dB).
const CONTRAST: f64 = 4.0;
/// Smoothing of the level that looks for the quietest stretch, s.
const FLOOR_TAU_S: f64 = 0.1;
/// The found idle level rises by a factor e in this time, so that a machine
/// whose fan has come on is learnt again, s.
const FLOOR_RISE_S: f64 = 60.0;

/// Finds the idle level and says whether the signal is above it.
#[derive(Debug, Clone)]
pub(crate) struct IdleFinder<T> {
    smooth: T,
    gain: T,
    rise: T,
    floor: Option<T>,
    contrast: bool,
    told: Option<(T, T)>,
    cutting: bool,
}

state! { IdleFinder<T> { smooth, gain, rise, floor, contrast, told, cutting } }

impl<T: Real> IdleFinder<T> {
    /// For decisions every `period_s` seconds.
    pub fn new(period_s: f64) -> Self {
        Self {
            smooth: T::ZERO,
            gain: T::from_f64((period_s / FLOOR_TAU_S).min(1.0)),
            rise: T::from_f64(1.0 + period_s / FLOOR_RISE_S),
            floor: None,
            contrast: false,
            told: None,
            cutting: true,
        }
    }

    /// One decision: the band's level (root mean square, input units), whether the
    /// user says that now is idle, and whether the level may be learnt from.
    ///
    /// Returns true if something is being cut, as far as is known.
    pub fn update(&mut self, level: T, told_idle: bool, learn: bool) -> bool {
        if !learn || !level.is_finite() {
            return self.cutting;
        }
        if self.smooth == T::ZERO {
            self.smooth = level;
        }
        self.smooth += self.gain * (level - self.smooth);
        if told_idle {
            let (sum, n) = self.told.unwrap_or((T::ZERO, T::ZERO));
            self.told = Some((sum + level, n + T::ONE));
            self.cutting = false;
            return false;
        }
        let Some(idle) = self.idle_level_after(self.smooth) else {
            self.cutting = true;
            return true;
        };
        // Six decibels up starts a cut, half of that ends it.
        let ratio = T::from_f64(if self.cutting {
            0.7 * CUT_RATIO
        } else {
            CUT_RATIO
        });
        self.cutting = level > idle * ratio;
        self.cutting
    }

    /// Something is being cut, as far as is known.
    pub fn is_cutting(&self) -> bool {
        self.cutting
    }

    /// The idle level in use, if any.
    pub fn idle_level(&self) -> Option<T> {
        match self.told {
            Some((sum, n)) => Some(sum / n),
            None => self.floor.filter(|_| self.contrast),
        }
    }

    fn idle_level_after(&mut self, smooth: T) -> Option<T> {
        if self.told.is_none() {
            let floor = match self.floor {
                Some(floor) => (floor * self.rise).min(smooth),
                None => smooth,
            };
            self.floor = Some(floor);
            self.contrast |= smooth > floor * T::from_f64(CONTRAST);
        }
        self.idle_level()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn idle_needs_contrast_unless_told() {
        let mut finder = IdleFinder::<f64>::new(0.002);
        for _ in 0..1000 {
            assert!(
                finder.update(0.1, false, true),
                "one level only: not called idle"
            );
        }
        for _ in 0..1000 {
            assert!(finder.update(1.0, false, true));
        }
        for _ in 0..1000 {
            finder.update(0.1, false, true);
        }
        assert!(!finder.update(0.1, false, true));
        assert!((0.09..0.13).contains(&finder.idle_level().unwrap()));

        let mut told = IdleFinder::<f64>::new(0.002);
        for _ in 0..100 {
            assert!(!told.update(0.1, true, true));
        }
        assert!(!told.update(0.13, false, true));
        assert!(told.update(0.3, false, true));
        assert!(
            told.update(f64::NAN, false, true),
            "a bad level changes nothing"
        );
    }
}
