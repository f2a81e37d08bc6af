//! What controllers have told a box and nobody has taken up yet: one place for each kind, the newest
//! stands. So a controller that tells without end takes no memory, and a box that comes back is not told
//! the speed of an hour ago.

use super::told::Told;
use std::time::{Duration, Instant};

/// A speed or a number of teeth that is older than this is not told any more.
pub(super) const FRESH: Duration = Duration::from_secs(10);

/// The newest of each kind that a controller has told.
#[derive(Debug, Default)]
pub(super) struct Slots {
    of: [Option<(Told, Instant)>; Told::KINDS],
    closed: bool,
}

impl Slots {
    /// Takes what was told at a time, unless something newer of the same kind is there. False: they
    /// are closed.
    pub fn put(&mut self, told: Told, at: Instant) -> bool {
        let slot = &mut self.of[told.kind()];
        if !self.closed && slot.as_ref().is_none_or(|(_, there)| *there <= at) {
            *slot = Some((told, at));
        }
        !self.closed
    }

    /// All, each with when it was told.
    pub fn drain(&mut self) -> Vec<(Told, Instant)> {
        self.of.iter_mut().filter_map(Option::take).collect()
    }

    /// What has become too old by `now`. A tool does not: it is not told to the box.
    pub fn old(&mut self, now: Instant) -> Vec<Told> {
        let is_old = |(told, at): &mut (Told, Instant)| {
            !matches!(told, Told::Tool(_)) && now.saturating_duration_since(*at) > FRESH
        };
        let old = self.of.iter_mut().filter_map(|slot| slot.take_if(is_old));
        old.map(|(told, _)| told).collect()
    }

    /// Nothing is taken any more; what was there.
    pub fn close(&mut self) -> Vec<Told> {
        self.closed = true;
        self.drain().into_iter().map(|(told, _)| told).collect()
    }

    /// The first in the order of the kinds.
    pub fn first(&self) -> Option<&Told> {
        self.of.iter().flatten().map(|(told, _)| told).next()
    }

    /// Takes out what has been done, unless something newer stands there.
    pub fn done(&mut self, told: &Told) {
        self.of[told.kind()].take_if(|(there, _)| there == told);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_of_each_kind_stands_and_old_ones_go() {
        let now = Instant::now();
        let s = Duration::from_secs;
        let mut slots = Slots::default();
        for k in 0..100_000_u32 {
            assert!(slots.put(Told::Speed(f64::from(k)), now));
        }
        assert!(slots.put(Told::Teeth(4), now + s(6)));
        assert!(slots.put(Told::Tool(None), now));
        // What comes back later than something newer does not stand in its way.
        assert!(slots.put(Told::Teeth(3), now));
        assert_eq!(slots.first(), Some(&Told::Speed(99_999.0)));
        assert!(slots.old(now + s(10)).is_empty());
        assert_eq!(slots.old(now + s(11)), [Told::Speed(99_999.0)]);
        slots.done(&Told::Teeth(3));
        assert_eq!(
            slots.drain(),
            [(Told::Teeth(4), now + s(6)), (Told::Tool(None), now)]
        );
        assert!(slots.put(Told::Teeth(4), now));
        slots.done(&Told::Teeth(4));
        assert_eq!(slots.first(), None);
    }

    #[test]
    fn closed_they_take_nothing() {
        let mut slots = Slots::default();
        assert!(slots.put(Told::Speed(1.0), Instant::now()));
        assert_eq!(slots.close(), [Told::Speed(1.0)]);
        assert!(!slots.put(Told::Speed(2.0), Instant::now()));
        assert!(slots.drain().is_empty());
    }
}
