//! Lines that stand still are removed although they may be self-excited: those of a comb
//! that may be a chatter's own overtones, and those where flip chatter may grow.
//!
//! They are drawn over seconds. What is steady goes, so that it no longer takes the model's
//! pole pairs; what changes stays in the signal and is judged; and what has gone is told if
//! it was loud, for nobody knows where it came from.

use super::Spindle;
use crate::condition::{Lock, SpindleLines};
use crate::real::Real;
use crate::visit::state;

/// A comb that has been heard for so long, s, and has not been called, stands.
const STANDING_S: f64 = 2.0;
/// The same comb has the same spacing within this part of it.
const SAME_COMB: f64 = 0.005;

/// A comb in doubt: the deviation of its spacing, Hz, for how long it has been heard, s, and
/// whether an alarm stands.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct DoubtfulComb<T> {
    sd_hz: T,
    heard_s: T,
    held: bool,
}

state! { DoubtfulComb<T> { sd_hz, heard_s, held } }

impl<T> DoubtfulComb<T> {
    /// An alarm stands.
    pub(super) fn is_held(&self) -> bool {
        self.held
    }
}

impl<T: Real> Spindle<T> {
    /// A comb was heard that may be one of rotation, or the overtones of a chatter.
    pub(super) fn hear_doubtful(&mut self, spacing_hz: T, sd_hz: T) {
        let same =
            |(before, _): &(T, T)| (spacing_hz - *before).abs() < *before * T::from_f64(SAME_COMB);
        if !self.doubtful.as_ref().is_some_and(same) {
            self.standing.heard_s = T::ZERO;
        }
        self.standing.sd_hz = sd_hz;
        self.doubtful = Some((spacing_hz, T::ZERO));
    }

    /// A decision: a comb that stands is removed.
    pub(super) fn remove_standing(&mut self, period_s: T) {
        let Some((spacing_hz, _)) = self.doubtful else {
            self.standing.heard_s = T::ZERO;
            return;
        };
        self.standing.heard_s += period_s;
        let stands = self.standing.heard_s >= T::from_f64(STANDING_S) && !self.standing.held;
        let believed = self.told.is_some() && !self.is_denied();
        let known = believed || self.tacho.is_some() || self.found.is_some();
        if let Some(lines) = &mut self.lines
            && lines.lock() != Lock::Locked
            && stands
            && !known
        {
            lines.start_slowly(spacing_hz, self.standing.sd_hz);
            self.standing.heard_s = T::ZERO;
        }
    }

    /// While an alarm stands, nothing more is removed of what may be self-excited.
    pub(in crate::monitor) fn hold_standing(&mut self, held: bool) {
        self.standing.held = held;
        if let Some(lines) = &mut self.lines {
            lines.hold(held);
        }
    }

    /// Power of the loudest line that was removed although it may be self-excited, input
    /// units squared.
    pub(in crate::monitor) fn loudest_standing(&self) -> T {
        let lines = self.lines.as_ref();
        lines.map_or(T::ZERO, SpindleLines::loudest_slow)
    }
}
