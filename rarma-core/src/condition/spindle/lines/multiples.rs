//! Which multiples of the spindle frequency are looked at.

use crate::real::Real;

/// Highest odd multiple of half the tooth frequency that is left alone: 4.5 teeth.
const FLIP_MULTIPLES: u32 = 9;
/// Highest multiple: bounds the work of a sample.
const HIGHEST: u32 = 255;

/// Rule by which multiples are chosen, and the range it was applied to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice {
    teeth: Option<u32>,
    range: (u32, u32),
}

impl Choice {
    pub fn new(teeth: Option<u32>) -> Self {
        Self {
            teeth,
            range: (0, 0),
        }
    }

    /// Flip chatter lives there: odd multiples of half the tooth frequency that are
    /// multiples of the spindle's.
    pub fn left_alone(&self, n: u32) -> bool {
        self.teeth.is_some_and(|z| {
            let half = z / 2;
            let times = n.checked_div(half).unwrap_or(0);
            z % 2 == 0 && times * half == n && times % 2 == 1 && times <= FLIP_MULTIPLES
        })
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
        let free = || (first..=last).filter(|n| !self.left_alone(*n));
        let teeth = free().filter(|n| self.of_teeth(*n)).count().min(H);
        let mut others = if free().count() <= H { H } else { H - teeth };
        let mut chosen = ([0; H], 0);
        for n in free() {
            let tooth = self.of_teeth(n);
            let Some(place) = chosen.0.get_mut(chosen.1).filter(|_| tooth || others > 0) else {
                continue;
            };
            *place = n as u16;
            chosen.1 += 1;
            others -= usize::from(!tooth);
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
    fn the_home_of_flip_chatter_is_left_alone() {
        // Four teeth: half the tooth frequency is twice the spindle's.
        let all = chosen::<64>(Some(4), 50.0);
        for n in [10, 14, 18] {
            assert!(!all.contains(&n), "{n}");
        }
        // 5.5 times the tooth frequency, tooth multiples, and the rest.
        for n in [22, 12, 16, 7, 9, 11] {
            assert!(all.contains(&n), "{n}");
        }
        // Two teeth: odd multiples of the spindle up to the ninth.
        assert_eq!(chosen::<64>(Some(2), 250.0), [2, 4, 6, 8, 10]);
        // Odd numbers of teeth have no such multiple.
        assert_eq!(chosen::<64>(Some(3), 250.0).len(), 9);
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
