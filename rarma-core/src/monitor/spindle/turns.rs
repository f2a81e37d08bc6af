//! The search for the speed in the sound, on the samples and the transform that the verdict by lines
//! keeps: it has them while these rest.
//!
//! Rate: once a decimated sample.

use crate::condition::{FRAME, Finding, SpeedFinderConfig, SpeedFinderError, SpeedSearch};
use crate::real::Real;
use crate::verdict::{HOP_S, Verdict};
use crate::visit::state;

/// Samples between an answer and the frame of the next one, beyond those of the frame: the search
/// takes as much of the whole work as when it had samples of its own. A quarter of a frame, half and
/// double of it find the same speeds; which samples a frame happens to hold is chance.
const PAUSE: usize = FRAME / 4;
/// Part of the time between two windows of the verdict in which the transform is used.
const BUSY: f64 = 0.25;

/// The search, and when it has its turn.
#[derive(Debug, Clone)]
pub(super) struct Turns<T> {
    search: SpeedSearch<T>,
    /// Samples until a frame is there.
    wait: usize,
    /// Place of the frame's first sample, and the next one.
    from: usize,
    next: usize,
    /// Pushes a sample while it has the transform.
    pace: usize,
}

state! { Turns<T> {
    search, wait, from, next;
    settings pace;
    where *wait <= FRAME + PAUSE && *from < FRAME && *next <= FRAME
} }

impl<T: Real> Turns<T> {
    /// Nothing at all, until [`Self::restart`]. Every bit is 0: where it is put, no copy of
    /// it is made first.
    pub(super) const BLANK: Self = Self {
        search: SpeedSearch::BLANK,
        wait: 0,
        from: 0,
        next: 0,
        pace: 0,
    };

    /// Forgets everything, in place.
    ///
    /// # Errors
    /// See [`SpeedFinderError`].
    pub(super) fn restart(&mut self, config: &SpeedFinderConfig) -> Result<(), SpeedFinderError> {
        let samples = (BUSY * HOP_S * config.fs_hz) as usize;
        self.pace = SpeedSearch::<T>::WITH_ROOM / samples.max(1) + 1;
        self.begin_anew();
        self.search.restart(config)
    }

    /// Another told speed, Hz; what was found before is forgotten.
    ///
    /// # Errors
    /// [`SpeedFinderError::Told`]; nothing has changed then.
    pub(super) fn tell(&mut self, told_hz: T) -> Result<(), SpeedFinderError> {
        self.search.tell(Some(told_hz))?;
        self.begin_anew();
        Ok(())
    }

    /// See [`SpeedFinder::frame_s`](crate::condition::SpeedFinder::frame_s).
    pub(super) fn frame_s(&self) -> T {
        self.search.frame_s()
    }

    /// Waits for a whole frame.
    fn begin_anew(&mut self) {
        (self.wait, self.from, self.next) = (FRAME, 0, 0);
    }

    /// A sample has come to those that `sources` keeps; gives an answer at the end of a cycle.
    #[inline]
    pub(super) fn go_on(&mut self, sources: &mut Verdict<T>) -> Option<Finding<T>> {
        if self.wait > 0 {
            self.wait -= 1;
            return None;
        }
        if !self.search.needs_room() {
            return self.take_turn(sources, 1);
        }
        if self.next == 0 {
            if !sources.rests_for(SpeedSearch::<T>::WITH_ROOM / self.pace.max(1) + 1) {
                return None;
            }
            self.from = sources.oldest();
        } else if !sources.rests() {
            // It has the transform now, and its own samples in it.
            self.search.reset();
            self.next = 0;
            return None;
        }
        self.take_turn(sources, self.pace)
    }

    #[inline(never)]
    fn take_turn(&mut self, sources: &mut Verdict<T>, pace: usize) -> Option<Finding<T>> {
        let had_room = self.search.needs_room();
        for _ in 0..pace {
            let (y, fft) = sources.lend(self.from, self.next);
            self.next = (self.next + 1).min(FRAME);
            if let Some(finding) = self.search.push(y, fft) {
                (self.wait, self.next) = (FRAME + PAUSE, 0);
                return Some(finding);
            }
            if had_room && !self.search.needs_room() {
                break;
            }
        }
        None
    }
}
