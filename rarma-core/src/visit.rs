//! How a state is shown, number by number, to be kept and gone on from later.
//!
//! Slow path.

/// Reads or replaces the numbers of a state, one after the other, in an order that is kept.
///
/// ```
/// use rarma_core::estimate::{Arma21, RarmaConfig, StateVisitor};
/// /// Writes numbers down.
/// #[derive(Default)]
/// struct Out(Vec<f64>);
/// impl StateVisitor<f64> for Out {
///     fn number(&mut self, x: &mut f64) {
///         self.0.push(*x);
///     }
///     fn count(&mut self, n: &mut u32) {
///         self.0.push(f64::from(*n));
///     }
/// }
/// /// Puts them back.
/// struct In(std::vec::IntoIter<f64>);
/// impl StateVisitor<f64> for In {
///     fn number(&mut self, x: &mut f64) {
///         *x = self.0.next().unwrap();
///     }
///     fn count(&mut self, n: &mut u32) {
///         *n = self.0.next().unwrap() as u32;
///     }
/// }
/// let mut model = Arma21::<f64>::new(RarmaConfig::default());
/// for n in 0..3000 {
///     model.update((0.7 * n as f64).sin());
/// }
/// let mut kept = Out::default();
/// assert!(model.visit_state(&mut kept));
/// let mut other = Arma21::<f64>::new(RarmaConfig::default());
/// assert!(other.visit_state(&mut In(kept.0.into_iter())));
/// assert_eq!(other.update(0.1).innovation, model.update(0.1).innovation);
/// ```
pub trait StateVisitor<T> {
    /// A number of the model.
    fn number(&mut self, x: &mut T);
    /// A count, a place, or a choice among a few.
    fn count(&mut self, n: &mut u32);
}

pub(crate) fn all<'a, T: 'a>(
    numbers: impl IntoIterator<Item = &'a mut T>,
    visitor: &mut impl StateVisitor<T>,
) {
    numbers.into_iter().for_each(|x| visitor.number(x));
}

pub(crate) fn place<T>(n: &mut usize, visitor: &mut impl StateVisitor<T>) {
    let mut count = u32::try_from(*n).unwrap_or(u32::MAX);
    visitor.count(&mut count);
    *n = count as usize;
}
