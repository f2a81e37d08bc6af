//! Room for the belief's work on one window, lent by the spectrum.

use super::SPEEDS;
use crate::real::Real;
use crate::verdict::frame::HALF;

/// Pairs of which the second numbers are the room.
type Places<T> = [(T, T)];

/// Room for one window's work, in what the spectrum leaves free of its transform: how likely each
/// speed made the line at hand, and behind it each speed's probability, not normed.
#[derive(Debug)]
pub(in crate::verdict) struct Desk<'a, T>(pub(in crate::verdict) &'a mut [(T, T); HALF]);

const _: () = assert!(2 * SPEEDS <= HALF);

impl<T: Real> Desk<'_, T> {
    #[inline(always)]
    fn places(&mut self, from: usize, count: usize) -> impl ExactSizeIterator<Item = &mut T> {
        let places = self.0.get_mut(from..from + count).unwrap_or_default();
        places.iter_mut().map(|(_, free)| free)
    }

    pub(super) fn mixed(&mut self) -> impl ExactSizeIterator<Item = &mut T> {
        self.places(0, SPEEDS)
    }

    pub(super) fn clear_mixed(&mut self) {
        let (fours, rest) = self.0[..SPEEDS].as_chunks_mut::<4>();
        for four in fours {
            four.iter_mut().for_each(|place| place.1 = T::ZERO);
        }
        rest.iter_mut().for_each(|place| place.1 = T::ZERO);
    }

    /// Of the speeds from one to another, both included.
    pub(super) fn near(&mut self, from: usize, to: usize) -> impl ExactSizeIterator<Item = &mut T> {
        self.places(from, (to.min(SPEEDS - 1) + 1).saturating_sub(from))
    }

    pub(super) fn chance(&mut self) -> impl ExactSizeIterator<Item = &mut T> {
        self.places(SPEEDS, SPEEDS)
    }

    /// What is mixed of each speed, and the speeds' chances.
    pub(super) fn both(&self) -> (&Places<T>, &Places<T>) {
        (&self.0[..SPEEDS], &self.0[SPEEDS..2 * SPEEDS])
    }
}

/// Hands the number of each place and what it holds to `each`, where that is above 0; it is never below. Four are asked at
/// once, for most speeds have no chance, and most of the others no part in a line.
#[inline(always)]
pub(super) fn above_zero<T: Real>(places: &Places<T>, mut each: impl FnMut(usize, T)) {
    let (fours, rest) = places.as_chunks::<4>();
    for (n, four) in fours.iter().enumerate() {
        if four[0].1 + four[1].1 + four[2].1 + four[3].1 > T::ZERO {
            for (i, (_, held)) in four.iter().enumerate() {
                if *held > T::ZERO {
                    each(4 * n + i, *held);
                }
            }
        }
    }
    for (i, (_, held)) in rest.iter().enumerate() {
        if *held > T::ZERO {
            each(4 * fours.len() + i, *held);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_place_above_zero_is_passed_over() {
        let mut seed = 3u32;
        for count in 0..40 {
            let places: Vec<(f64, f64)> = (0..count)
                .map(|_| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (1.0, f64::from((seed >> 24).saturating_sub(200)))
                })
                .collect();
            let mut seen = Vec::new();
            above_zero(&places, |i, held| seen.push((i, held)));
            let wanted = places.iter().map(|place| place.1).enumerate();
            let wanted: Vec<(usize, f64)> = wanted.filter(|(_, held)| *held > 0.0).collect();
            assert_eq!(seen, wanted);
        }
    }
}
