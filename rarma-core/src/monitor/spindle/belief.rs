//! How far the speed is believed, and what follows for a line.
//!
//! Rate: decision rate.

use super::{ENTERING, HEARD_FRAMES, SpeedSource, Spindle, UNCONFIRMED};
use crate::condition::SpeedFinder;
use crate::decide::{Rotation, SPEED_ACCURACY};
use crate::real::Real;

/// A speed that moves is in doubt by this part of it at most.
const MOST_DRIFT: f64 = 0.02;
/// What a speed read off lines or a tacho is taken for at best, as a part of it, and
/// the standard deviations that stand for its width.
const READ_ACCURACY: f64 = 3e-4;
const READ_WIDTH: f64 = 3.0;

/// A speed found this near to the setting, as a part of it, is not certain to be another.
const FOUND_BESIDE: f64 = 0.01;

/// How far it may be off in the end, as a part of it: so far the lines are looked for.
const OFF: f64 = 0.03;
/// Up to this multiple of the teeth: where more of them lie in the band they are heard.
const FEW: f64 = 2.0;

impl<T: Real> Spindle<T> {
    /// The speed in use: its value, its relative uncertainty, who says so.
    pub(super) fn speed(&self) -> Option<(T, T, SpeedSource)> {
        let read = |(speed, sd): (T, T), source| {
            let width = (sd * T::from_f64(READ_WIDTH) / speed).max(T::from_f64(READ_ACCURACY));
            (speed, width, source)
        };
        if let Some(tacho) = self.tacho_reading {
            return Some(read(tacho, SpeedSource::Tacho));
        }
        if let Some(locked) = self.locked() {
            return Some(read(locked, SpeedSource::Sound));
        }
        if let Some((found, _)) = self.found {
            let (speed, width, source) = read(found, SpeedSource::Sound);
            return Some((speed, width.max(T::from_f64(SPEED_ACCURACY)), source));
        }
        self.told
            .filter(|_| !self.is_denied())
            .map(|told| (told, T::from_f64(SPEED_ACCURACY), SpeedSource::Told))
    }

    /// The multiples that count as forced now.
    pub(in crate::monitor) fn rotation(&self) -> Rotation<T> {
        let Some((speed, width, source)) = self.speed() else {
            return Rotation::default();
        };
        let doubt = match source {
            SpeedSource::Tacho => T::ZERO,
            _ => self.doubt(speed),
        };
        let unheard = source == SpeedSource::Told && self.is_unheard();
        Rotation {
            spindle_hz: Some(speed),
            // Half the tooth frequency means something for the spindle's own multiples.
            teeth: self.teeth,
            accuracy: width,
            doubt,
            doubt_of_first: T::from_f64(if unheard { UNCONFIRMED.1 } else { 0.0 }),
        }
    }

    /// A told speed has been cut with for less than this, s, and has not been confirmed.
    fn is_unconfirmed(&self, for_s: T) -> bool {
        self.unconfirmed_s.is_some_and(|t| t < for_s)
    }

    /// The search for lines is slow and has not had the time to confirm a told speed.
    fn is_unheard(&self) -> bool {
        let frame_s = self.finder.as_ref().map_or(T::ZERO, SpeedFinder::frame_s);
        frame_s > T::from_f64(UNCONFIRMED.0)
            && self.is_unconfirmed(frame_s * T::from_f64(HEARD_FRAMES))
    }

    /// How far a speed that no tacho measures may be off, as a part of it.
    fn doubt(&self, speed: T) -> T {
        let snapshot = self.found_at_entry && !self.was_locked;
        let mut doubt = T::ZERO;
        if self.entering_s > T::ZERO || snapshot {
            doubt = T::from_f64(ENTERING.1);
        }
        if self.is_unconfirmed(T::from_f64(UNCONFIRMED.0)) && !self.was_locked {
            doubt = doubt.max(T::from_f64(UNCONFIRMED.1));
        }
        // Found once and not yet followed: the setting may be right, the finding a mean over
        // a speed that moves.
        if !self.was_locked && self.found.is_some() {
            let off = self.setting.map(|setting| (setting / speed - T::ONE).abs());
            let off = off.filter(|off| *off < T::from_f64(FOUND_BESIDE));
            let reach = off.map_or(T::ZERO, |off| off + T::from_f64(SPEED_ACCURACY));
            doubt = doubt.max(reach);
        }
        // One that moves may move on, and what follows it is late.
        let drift = self.drift.of(speed).min(T::from_f64(MOST_DRIFT));
        doubt.max(drift)
    }

    /// The speed is merely told, and `f` would be a line of it if it were off: within its
    /// first moments any line may be, unless idle was heard without it; later one beside a
    /// multiple of the teeth.
    pub(in crate::monitor) fn is_unproven(&self, f: T, idle_known: bool) -> bool {
        let Some((speed, _, SpeedSource::Told)) = self.speed() else {
            return false;
        };
        let beside_teeth = self.teeth.is_some_and(|teeth| {
            let ratio = f / (speed * T::from_u32(teeth));
            let multiple = ratio.round().max(T::ONE);
            multiple <= T::from_f64(FEW) && (ratio - multiple).abs() < multiple * T::from_f64(OFF)
        });
        beside_teeth || (!idle_known && self.is_unconfirmed(T::from_f64(UNCONFIRMED.0)))
    }

    /// `f` lies on a comb that may be one of rotation or the overtones of a chatter.
    pub(in crate::monitor) fn is_doubtful(&self, f: T, sd: T) -> bool {
        let comb = Rotation {
            spindle_hz: self.doubtful.map(|(speed, _)| speed),
            teeth: None,
            accuracy: T::from_f64(SPEED_ACCURACY),
            ..Rotation::default()
        };
        comb.harmonic(f, sd).is_some()
    }
}
