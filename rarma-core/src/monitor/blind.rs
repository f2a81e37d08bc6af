//! Would a chatter be heard? A line of the rotation that rises by itself may be one that
//! hides under it, in the notch of a removed line.
//!
//! Rate: decision rate. Forced lines rise together when a cut deepens; that one of them
//! rises while everything else stays is told as blindness, never as chatter.

use super::spindle::LINES;
use crate::real::Real;
use crate::visit::state;

/// A line that has this many times (6 dB) the power it had …
const ROSE: f64 = 4.0;
/// … while everything else has no more than this many times (3 dB) has risen by itself.
const OTHERS: f64 = 2.0;
/// What it had is the least power of late, which follows a rise by e in this time, s: one
/// that rises slower is no news. A line that swings by 6 dB blinds, too: two that lie
/// within the notch beat.
const RISE_S: f64 = 1.0;
/// Least part of the band's power at a line that may hide a chatter.
const LOUD: f64 = 0.05;
/// It is told for this long, s.
const HOLD_S: f64 = 1.0;

/// The least power of late, of a line and of all but it, input units squared.
#[derive(Debug, Clone, Copy, Default)]
struct Least<T> {
    multiple: u32,
    line: T,
    rest: T,
}

state! { Least<T> { multiple, line, rest } }

/// The lines of the rotation, each by itself.
#[derive(Debug, Clone)]
pub(super) struct Blindness<T> {
    lines: [Option<Least<T>>; LINES],
    hold_s: T,
}

state! { Blindness<T> { lines, hold_s } }

impl<T: Real> Default for Blindness<T> {
    fn default() -> Self {
        Self {
            lines: [None; LINES],
            hold_s: T::ZERO,
        }
    }
}

impl<T: Real> Blindness<T> {
    /// A decision: multiple and power of each line that is removed, and the power of all
    /// of the band. `changing` says that the cut or the speed changes, so that a line that
    /// rises says nothing.
    pub(super) fn note(
        &mut self,
        lines: impl Iterator<Item = (u32, T)>,
        power: T,
        changing: bool,
        period_s: T,
    ) {
        self.hold_s = (self.hold_s - period_s).max(T::ZERO);
        let up = T::ONE + period_s / T::from_f64(RISE_S);
        let mut lines = lines;
        for least in &mut self.lines {
            let Some((multiple, line)) = lines.next().filter(|_| !changing) else {
                *least = None;
                continue;
            };
            let rest = (power - line).max(T::ZERO);
            let before = least.filter(|least| least.multiple == multiple);
            let Some(before) = before.filter(|_| line.is_finite() && rest.is_finite()) else {
                *least = Some(Least {
                    multiple,
                    line,
                    rest,
                });
                continue;
            };
            if line > power * T::from_f64(LOUD)
                && line > before.line * T::from_f64(ROSE)
                && rest < before.rest * T::from_f64(OTHERS)
            {
                self.hold_s = T::from_f64(HOLD_S);
            }
            *least = Some(Least {
                multiple,
                line: line.min(before.line * up),
                rest: rest.min(before.rest * up),
            });
        }
    }

    /// A line rose by itself within the last second.
    pub(super) fn is_blind(&self) -> bool {
        self.hold_s > T::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(parts: &[(f64, f64, f64)]) -> bool {
        let mut blind = Blindness::<f64>::default();
        for (line, rest, seconds) in parts {
            for _ in 0..(seconds / 0.002) as usize {
                let lines = [(3, 1.0), (5, *line)];
                blind.note(lines.into_iter(), line + rest + 1.0, false, 0.002);
            }
        }
        blind.is_blind()
    }

    #[test]
    fn only_a_line_that_rises_by_itself_blinds() {
        assert!(!after(&[(1.0, 1.0, 2.0)]));
        assert!(after(&[(1.0, 1.0, 2.0), (5.0, 1.0, 0.1)]));
        assert!(
            after(&[(1.0, 40.0, 2.0), (5.0, 40.0, 0.5)]),
            "not the loudest"
        );
        assert!(!after(&[(1.0, 200.0, 2.0), (5.0, 200.0, 0.5)]), "a whisper");
        assert!(!after(&[(1.0, 1.0, 2.0), (3.0, 1.0, 0.5)]), "too little");
        assert!(!after(&[(1.0, 1.0, 2.0), (5.0, 5.0, 0.5)]), "all rose");
        assert!(!after(&[(1.0, 1.0, 2.0), (5.0, 1.0, 9.0)]), "long ago");
        assert!(!after(&[(5.0, 1.0, 2.0)]), "there from the beginning");
        let gone = (0.2, 1.0, 0.5);
        assert!(
            after(&[(1.0, 1.0, 2.0), gone, (1.0, 1.0, 0.1)]),
            "it swings"
        );
        assert!(!after(&[(f64::NAN, 1.0, 1.0), (9.0, f64::NAN, 0.3)]));
        let mut entering = Blindness::<f64>::default();
        for n in 0..1000 {
            let line = if n < 900 { 1.0 } else { 9.0 };
            entering.note([(5, line)].into_iter(), 10.0, true, 0.002);
        }
        assert!(!entering.is_blind(), "the cut begins");
    }

    #[test]
    fn a_line_is_compared_with_itself() {
        let mut blind = Blindness::<f64>::default();
        for n in 0..1000 {
            // The speed has changed, and with it which multiple comes first.
            let lines = if n < 900 { (3, 1.0) } else { (4, 9.0) };
            blind.note([lines].into_iter(), 10.0, false, 0.002);
        }
        assert!(!blind.is_blind());
    }
}
