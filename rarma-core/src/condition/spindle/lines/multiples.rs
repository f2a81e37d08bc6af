//! Which multiples of the spindle frequency are looked at.

use crate::real::Real;
use crate::visit::state;

/// Flip lobes lie where a vibration takes 2, 2/3, 2/5 … tooth periods; beyond this odd
/// number of half tooth frequencies they are lost among the others.
const HIGHEST_FLIP_HALVES: u32 = 9;
/// Highest multiple: bounds the work of a sample.
pub(super) const HIGHEST: u32 = 255;

/// Multiple `n` of the spindle is an odd multiple of half the tooth frequency, where period-two
/// (flip) chatter lives: with an even number of teeth, and up to [`HIGHEST_FLIP_HALVES`] of
/// them.
pub(crate) fn is_home_of_flip(teeth: Option<u32>, n: u32) -> bool {
    teeth.is_some_and(|z| {
        let half = z / 2;
        let times = n.checked_div(half).unwrap_or(0);
        z % 2 == 0 && times * half == n && times % 2 == 1 && times <= HIGHEST_FLIP_HALVES
    })
}

/// Rule by which multiples are chosen, and the range it was applied to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice {
    teeth: Option<u32>,
    range: (u32, u32),
}

state! { Choice {
    range;
    settings teeth
} }

impl Choice {
    pub fn new(teeth: Option<u32>) -> Self {
        Self {
            teeth,
            range: (0, 0),
        }
    }

    /// Flip chatter lives there.
    pub fn is_flip(&self, n: u16) -> bool {
        is_home_of_flip(self.teeth, u32::from(n))
    }

    fn of_teeth(&self, n: u32) -> bool {
        self.teeth.is_some_and(|z| n.is_multiple_of(z))
    }

    /// The multiples of `f`, at most `H`, ascending, and how many; none if they are
    /// those of the last time. A multiple stays until it is 0.5 % outside the band;
    /// `anew` says that none are held.
    pub fn renew<T: Real, const H: usize>(
        &mut self,
        f: T,
        band: (T, T),
        anew: bool,
    ) -> Option<([u16; H], usize)> {
        if !(f > T::ZERO) {
            return None;
        }
        let below = |edge: T| ((edge / f).to_f32() as u32).min(HIGHEST);
        let (first, last) = (below(band.0) + 1, below(band.1));
        // A line on the edge would come and go.
        let near = |n: u32, edge: T| {
            let off = T::from_u32(n) * f / edge - T::ONE;
            off.abs() < T::from_f64(0.005)
        };
        let (a, b) = self.range;
        let same_first = first == a || (first.abs_diff(a) == 1 && near(first.min(a), band.0));
        let same_last = last == b || (last.abs_diff(b) == 1 && near(last.max(b), band.1));
        if !anew && same_first && same_last {
            return None;
        }
        self.range = (first, last);
        let all = || first..=last;
        let foremost = |n: u32| self.of_teeth(n) || is_home_of_flip(self.teeth, n);
        let of_teeth = all().filter(|n| foremost(*n)).count().min(H);
        let mut others = if all().count() <= H { H } else { H - of_teeth };
        let mut chosen = ([0; H], 0);
        for n in all() {
            let first = foremost(n);
            let Some(place) = chosen.0.get_mut(chosen.1).filter(|_| first || others > 0) else {
                continue;
            };
            *place = n as u16;
            chosen.1 += 1;
            others -= usize::from(!first);
        }
        Some(chosen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen<const H: usize>(teeth: Option<u32>, f: f64) -> Vec<u16> {
        let mut choice = Choice::new(teeth);
        let band = (300.0, 2500.0);
        let chosen = choice.renew::<f64, H>(f, band, true);
        chosen.map_or(Vec::new(), |(n, used)| n[..used].to_vec())
    }

    #[test]
    fn all_that_fit_or_those_of_the_teeth() {
        assert_eq!(chosen::<8>(None, 400.0), [1, 2, 3, 4, 5, 6]);
        assert_eq!(chosen::<3>(None, 400.0), [1, 2, 3]);
        // Teeth at 375, 750 … 2250 Hz, six of them; two places for the lowest others.
        assert_eq!(chosen::<8>(Some(5), 75.0), [5, 6, 7, 10, 15, 20, 25, 30]);
        assert!(chosen::<8>(None, 4000.0).is_empty());
        assert!(chosen::<8>(None, f64::NAN).is_empty());
    }

    #[test]
    fn flip_lines_are_those_of_an_even_number_of_teeth() {
        let flips = |teeth| {
            (1..40)
                .filter(|n| is_home_of_flip(teeth, *n))
                .collect::<Vec<_>>()
        };
        // Four teeth: half the tooth frequency is twice the spindle's; up to 4.5 times it.
        assert_eq!(flips(Some(4)), [2, 6, 10, 14, 18]);
        assert_eq!(flips(Some(2)), [1, 3, 5, 7, 9]);
        assert!(flips(Some(3)).is_empty() && flips(Some(0)).is_empty() && flips(None).is_empty());
        // They go before other multiples, as those of the teeth do.
        assert_eq!(chosen::<6>(Some(4), 100.0), [4, 6, 8, 10, 12, 14]);
    }

    #[test]
    fn a_line_on_the_edge_does_not_come_and_go() {
        let mut choice = Choice::new(None);
        let band = (300.0, 2500.0);
        let mut renewed = 0;
        for i in 0..100 {
            let f = if i % 2 == 0 { 100.01 } else { 99.99 };
            renewed += u32::from(choice.renew::<f64, 64>(f, band, i == 0).is_some());
        }
        assert_eq!(renewed, 1);
        assert!(choice.renew::<f64, 64>(105.0, band, false).is_some());
    }
}
