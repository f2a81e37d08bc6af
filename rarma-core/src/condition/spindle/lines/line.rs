//! One line of the spindle: its amplitude, and how loud the rest is where it lies.

use super::multiples::HIGHEST;
use crate::real::Real;
use crate::visit::state;

/// Part of its power that a line has left that shrinks.
const SHRUNK: f64 = 0.4;

/// One line.
#[derive(Debug, Clone, Copy)]
pub(super) struct RotationLine<T> {
    pub multiple: u16,
    pub age: u16,
    /// Amplitude c of Re(c·e^(j·n·φ)).
    pub c: (T, T),
    /// Σ e·e^(−j·n·φ) of the block.
    pub sum: (T, T),
    /// Smoothed errors, radial and across less what the common phase explains, and
    /// the variance of a block's error by them.
    pub radial: T,
    pub across: T,
    pub variance: T,
}

state! { RotationLine<T> {
    multiple, age, c, sum, radial, across, variance;
    where *multiple <= HIGHEST as u16
} }

impl<T: Real> RotationLine<T> {
    pub(super) fn new(multiple: u16) -> Self {
        let zero = (T::ZERO, T::ZERO);
        Self {
            multiple,
            age: 0,
            c: zero,
            sum: zero,
            radial: T::ZERO,
            across: T::ZERO,
            variance: T::ZERO,
        }
    }

    /// It has lost more than half of its power: then it goes at once, whatever it was, for
    /// what is still subtracted of it would be heard as a line.
    pub(super) fn shrinks(&self) -> bool {
        let square = self.square();
        let along = square.sqrt() + self.radial;
        along * along + self.across * self.across < square * T::from_f64(SHRUNK)
    }

    /// |c|².
    pub(super) fn square(&self) -> T {
        self.c.0 * self.c.0 + self.c.1 * self.c.1
    }
}

/// Part of an error that a line of this age takes over.
pub(super) fn gain<T: Real>(age: u16, most: T, least: T) -> T {
    (T::ONE / T::from_u32(u32::from(age.max(1))))
        .min(most)
        .max(least)
}
