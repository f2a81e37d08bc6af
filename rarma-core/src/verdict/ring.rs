//! The last samples, two bytes each.
//!
//! Rate: once a decimated sample; now and then all of them are scaled anew.

use super::frame::FRAME;
use crate::real::Real;
use crate::visit::{State, StateVisitor, place};

/// A sample is at most this many units.
const MOST: i16 = i16::MAX;
/// Where the loudest of a whole ring is below this many units they become smaller, so that it is
/// always kept to 12 bits at the least: a step is 72 dB below its amplitude, and what all steps do
/// is spread over the whole spectrum.
const LEAST: u16 = 1 << 12;
/// The unit of a ring that has heard nothing, and the largest: powers of two.
const FIRST: i16 = -60;
const LARGEST: i16 = 60;

/// From here to twice this the numbers of single precision are the whole ones, and 2^16 divides it.
const ROUNDING: f32 = 12_582_912.0;

/// Samples in units of a power of two, which goes with the loudest of them.
#[derive(Debug, Clone)]
pub(super) struct Ring<T> {
    samples: [i16; FRAME],
    /// Where the next sample goes.
    next: usize,
    /// The loudest since `next` was 0, units.
    loudest: u16,
    /// The unit is two to this.
    exponent: i16,
    /// The unit, and one over it.
    unit: T,
    per_unit: T,
}

impl<T: Real> Ring<T> {
    /// Zeros, until [`Self::restart`].
    pub(super) const BLANK: Self = Self {
        samples: [0; FRAME],
        next: 0,
        loudest: 0,
        exponent: 0,
        unit: T::ZERO,
        per_unit: T::ZERO,
    };

    /// Forgets everything, in place.
    pub(super) fn restart(&mut self) {
        self.samples.fill(0);
        (self.next, self.loudest) = (0, 0);
        self.set_unit(FIRST);
    }

    fn set_unit(&mut self, exponent: i16) {
        let two = T::from_u32(2);
        self.exponent = exponent;
        self.unit = T::ONE;
        self.per_unit = T::ONE;
        for _ in 0..exponent.unsigned_abs() {
            self.unit *= two;
            self.per_unit /= two;
        }
        if exponent < 0 {
            (self.unit, self.per_unit) = (self.per_unit, self.unit);
        }
    }

    /// Takes a sample, which is finite.
    #[inline(always)]
    pub(super) fn push(&mut self, x: T) {
        let mut units = x * self.per_unit;
        if units.abs() > T::from_u32(MOST as u32) {
            self.make_room(units.abs());
            units = x * self.per_unit;
        }
        // The last bits of this sum are the nearest whole number.
        let units = (units.to_f32() + ROUNDING).to_bits() as u16 as i16;
        self.loudest = self.loudest.max(units.unsigned_abs());
        self.samples[self.next & (FRAME - 1)] = units;
        self.next = (self.next + 1) & (FRAME - 1);
        if self.next == 0 {
            if self.loudest < LEAST && self.exponent > FIRST {
                self.refine();
            }
            self.loudest = 0;
        }
    }

    /// A sample of so many units: the unit becomes so much larger that it is a quarter to half of
    /// what there is room for.
    #[cold]
    #[inline(never)]
    fn make_room(&mut self, units: T) {
        let half = T::from_f64(0.5);
        let (mut left, mut by) = (units, 1);
        while left > T::from_u32(MOST as u32) && by < FIRST.abs() + LARGEST {
            left *= half;
            by += 1;
        }
        let by = by.min(LARGEST - self.exponent);
        self.set_unit(self.exponent + by);
        for sample in &mut self.samples {
            *sample = sample.checked_shr(by.unsigned_abs().into()).unwrap_or(0);
        }
        self.loudest = self
            .loudest
            .checked_shr(by.unsigned_abs().into())
            .unwrap_or(0);
    }

    /// All samples are small: the unit becomes so much smaller that the loudest is so, too; of silence,
    /// by 14 bits.
    #[cold]
    #[inline(never)]
    fn refine(&mut self) {
        let by = (self.loudest.leading_zeros() as i16 - 2).min(self.exponent - FIRST);
        self.set_unit(self.exponent - by);
        for sample in &mut self.samples {
            *sample = sample.checked_shl(by.unsigned_abs().into()).unwrap_or(0);
        }
    }

    /// Place of the first of the newest `length` samples.
    pub(super) fn first_of_newest(&self, length: usize) -> usize {
        (self.next + FRAME - length) & (FRAME - 1)
    }

    /// The sample `i` places behind `from`, in units.
    #[inline(always)]
    pub(super) fn units(&self, from: usize, i: usize) -> T {
        T::from_f32(self.samples[(from + i) & (FRAME - 1)].into())
    }

    /// What a unit is.
    #[inline(always)]
    pub(super) fn unit(&self) -> T {
        self.unit
    }

    /// The sample `i` places behind `from`.
    #[inline(always)]
    pub(super) fn sample(&self, from: usize, i: usize) -> T {
        self.units(from, i) * self.unit
    }
}

impl<T: Real> State<T> for Ring<T> {
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        let Self {
            samples,
            next,
            loudest,
            exponent,
            unit: _,
            per_unit: _,
        } = self;
        visitor.part("Ring samples next loudest exponent");
        for sample in samples {
            let mut bits = u32::from(*sample as u16);
            visitor.count(&mut bits);
            *sample = bits as u16 as i16;
        }
        place(next, visitor);
        let mut up = (*exponent - FIRST) as u32;
        let fits = State::<T>::visit_state(loudest, visitor);
        visitor.count(&mut up);
        let there = i16::try_from(up).ok().map(|up| up + FIRST);
        let there = there.filter(|exponent| (FIRST..=LARGEST).contains(exponent));
        let sound = fits && *next < FRAME && there.is_some();
        self.set_unit(there.unwrap_or(FIRST));
        sound
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error of the last samples, as a part of the loudest of them.
    fn error(ring: &Ring<f64>, last: &[f64]) -> f64 {
        let from = ring.first_of_newest(last.len());
        let most = last.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let off = |(i, x): (usize, &f64)| (ring.sample(from, i) - x).abs();
        last.iter().enumerate().map(off).fold(0.0, f64::max) / most
    }

    #[test]
    fn the_loudest_is_kept_to_twelve_bits_however_loud() {
        let mut ring = Ring::<f64>::BLANK;
        ring.restart();
        let mut x = Vec::new();
        // A whisper, a blow, silence, what is absurd, and a whisper again.
        for (loud, count) in [
            (1e-9, 15_000),
            (0.3, 3000),
            (1e-4, 15_000),
            (0.0, 9000),
            (1e9, 200),
            (1e-3, 15_000),
        ] {
            for n in 0..count {
                x.push(loud * (f64::from(n) * 0.7).sin());
                ring.push(x[x.len() - 1]);
                let last = &x[x.len().saturating_sub(FRAME)..];
                // Once it is louder at once, and once it is quieter when some rings are full.
                let is_known = (0.1..1e8).contains(&loud) || n > 6 * FRAME as i32;
                if is_known && loud > 0.0 && n % 997 == 99 {
                    let off = error(&ring, last);
                    assert!((1e-6..2.6e-4).contains(&off), "{loud} {n}: {off}");
                }
            }
        }
    }

    /// Keeps what is shown, or puts it back.
    struct Kept(Vec<u32>, bool);

    impl StateVisitor<f64> for Kept {
        fn number(&mut self, _: &mut f64) {}
        fn count(&mut self, n: &mut u32) {
            if self.1 {
                *n = self.0.remove(0);
            } else {
                self.0.push(*n);
            }
        }
    }

    #[test]
    fn whispers_and_blows_can_be_kept() {
        for loud in [1e-12, 0.3, 1e5, 1e9] {
            let mut ring = Ring::<f64>::BLANK;
            ring.restart();
            for n in 0..5000 {
                ring.push(loud * (f64::from(n) * 0.7).sin());
            }
            let mut kept = Kept(Vec::new(), false);
            assert!(ring.visit_state(&mut kept));
            kept.1 = true;
            let mut again = Ring::<f64>::BLANK;
            assert!(again.visit_state(&mut kept) && kept.0.is_empty());
            let from = ring.first_of_newest(FRAME);
            assert_eq!(from, again.first_of_newest(FRAME));
            assert!((0..FRAME).all(|i| ring.sample(from, i) == again.sample(from, i)));
        }
    }
}
