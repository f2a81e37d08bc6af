//! One override on its way: whether what is reported is what was ordered.

/// Two overrides this near are one: half a step of a controller that counts in percent, and
/// what rounding adds. Half of it would take such steps for the operator's hand; twice of it
/// would miss a step of his.
pub(super) const SAME: f64 = 0.0065;

/// What a report means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Seen {
    /// On its way.
    Toward,
    /// Where it was ordered to.
    There,
    /// Somewhere it was not ordered to: somebody else has turned it.
    Away,
}

/// An override that goes from one value to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lever {
    start: f64,
    pub(super) to: f64,
    /// How near it has come.
    nearest: f64,
    /// That counts from so near on: until then what was ordered before may still arrive.
    counts: f64,
}

impl Lever {
    pub(super) fn new(start: f64, to: f64) -> Self {
        Self {
            start,
            to,
            nearest: (start - to).abs(),
            counts: f64::INFINITY,
        }
    }

    /// Back to what was before, from a place between what is reported now and what was sent
    /// last, which may still arrive: it goes away for a moment then. Orders arrive one after the other, so that one step
    /// back shows that all of them have.
    pub(super) fn back(now: f64, sent: f64, before: f64) -> Self {
        let (now_off, sent_off) = (now - before, sent - before);
        let crosses = now_off * sent_off <= 0.0;
        Self {
            start: if crosses { before } else { now },
            to: before,
            nearest: now_off.abs().max(sent_off.abs()),
            counts: now_off.abs() - SAME,
        }
    }

    /// Takes a report. What goes back, or past its end, was moved by somebody else.
    pub(super) fn see(&mut self, value: f64) -> Seen {
        let left = (value - self.to).abs();
        let past = (value - self.to) * (self.start - self.to) < 0.0;
        if left > self.nearest + SAME || (past && left > SAME) {
            return Seen::Away;
        }
        if left < self.counts {
            self.nearest = self.nearest.min(left);
        }
        if left <= SAME {
            Seen::There
        } else {
            Seen::Toward
        }
    }
}
