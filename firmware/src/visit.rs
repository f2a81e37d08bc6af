//! Numbers of a state that are no counts of 32 bits, shown as such. Slow path.

use rarma_core::estimate::StateVisitor;

/// Yes or no.
pub(crate) fn flag(is: &mut bool, visitor: &mut impl StateVisitor<f32>) {
    let mut n = u32::from(*is);
    visitor.count(&mut n);
    *is = n != 0;
}

/// A count of 64 bits; of what is put in the upper two are left out, so that no sum of two wraps.
pub(crate) fn long(n: &mut u64, visitor: &mut impl StateVisitor<f32>) {
    let (mut high, mut low) = ((*n >> 32) as u32, *n as u32);
    visitor.count(&mut high);
    visitor.count(&mut low);
    *n = (u64::from(high & (u32::MAX >> 2)) << 32) | u64::from(low);
}
