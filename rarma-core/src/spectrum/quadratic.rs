//! A real quadratic factor of A, and arithmetic modulo one.

use crate::real::Real;

/// z² − u·z + v: sum u and product v of two roots.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Quadratic<T> {
    /// Sum of the two roots.
    pub u: T,
    /// Product of the two roots; |z|² of a conjugate pair.
    pub v: T,
}

/// The two roots of a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Roots<T> {
    /// re ± j·im, im > 0.
    Pair {
        /// Real part.
        re: T,
        /// Imaginary part, positive.
        im: T,
    },
    /// Two real roots, smaller first.
    Real(T, T),
}

/// An element α + β·z of the numbers modulo one factor.
#[derive(Clone, Copy)]
pub(super) struct Residue<T> {
    pub alpha: T,
    pub beta: T,
}

impl<T: Real> Quadratic<T> {
    /// Both roots at 0.
    #[cfg(feature = "monitor")]
    pub(super) const BLANK: Self = Self {
        u: T::ZERO,
        v: T::ZERO,
    };

    /// The two roots.
    pub fn roots(&self) -> Roots<T> {
        let half = self.u * T::from_f64(0.5);
        let d = half * half - self.v;
        if d < T::ZERO {
            return Roots::Pair {
                re: half,
                im: (-d).sqrt(),
            };
        }
        // The larger root by the formula, the other by the product: no cancellation.
        let s = d.sqrt();
        let far = if half >= T::ZERO { half + s } else { half - s };
        let near = if far == T::ZERO {
            T::ZERO
        } else {
            self.v / far
        };
        Roots::Real(far.min(near), far.max(near))
    }

    /// Product modulo this factor, where z² = u·z − v.
    #[inline(always)]
    pub(super) fn multiply(&self, x: Residue<T>, y: Residue<T>) -> Residue<T> {
        let square = x.beta * y.beta;
        Residue {
            alpha: x.alpha * y.alpha - self.v * square,
            beta: x.alpha * y.beta + x.beta * y.alpha + self.u * square,
        }
    }
}
