//! All of a monitor that knows the model's order: the model, and the roots of its A.
//!
//! Rate: [`Identifier::update`] once a decimated sample, one call of straight code for each
//! order; what is read off it at the decision rate.

use crate::estimate::{RarmaConfig, RecursiveArma, Status};
use crate::order::Order;
use crate::real::Real;
use crate::spectrum::{FactorTracker, ModalDeviation, Quadratic, Tracking, deviation, isolate};
use crate::visit::{State, StateVisitor};

/// Most modes that are read, and that a report holds: half the largest p.
pub const MAX_MODES: usize = 4;

/// A model and its roots, of one order.
#[derive(Debug, Clone)]
struct Fixed<T, const P: usize, const Q: usize, const N: usize> {
    model: RecursiveArma<T, P, Q, N>,
    roots: FactorTracker<T, P>,
    lost: bool,
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> Fixed<T, P, Q, N> {
    /// Zeros, until [`Self::restart`].
    const BLANK: Self = Self {
        model: RecursiveArma::BLANK,
        roots: FactorTracker::BLANK,
        lost: false,
    };

    fn restart(&mut self, config: RarmaConfig<T>) {
        const { assert!(N == P + Q, "N must be P + Q") };
        const { assert!(P.div_ceil(2) <= MAX_MODES, "more modes than a report holds") };
        let Self { model, roots, lost } = self;
        model.restart(config);
        roots.restart();
        *lost = true;
    }

    /// See [`Identifier::update`]. A function of its own, so that the registers and the
    /// stack of one order are not those of all.
    #[inline(never)]
    fn update(&mut self, y: T, own: &mut [T; MAX_MODES]) -> usize {
        let step = self.model.update(y);
        match step.status {
            Status::Rejected => {}
            // No model yet: its roots are sought when it is there.
            Status::Starting => {
                self.roots.search();
                self.lost = true;
            }
            _ => self.lost = self.roots.track(self.model.a()) == Tracking::Searching,
        }
        let a = self.model.a();
        let filtered = self.model.filtered_outputs();
        for (own, factor) in own.iter_mut().zip(self.roots.factors(P)) {
            *own = isolate(a, factor, filtered);
        }
        P.div_ceil(2)
    }

    /// See [`Identifier::deviations`].
    fn deviations(&self, fs: T) -> [Option<ModalDeviation<T>>; MAX_MODES] {
        let model = &self.model;
        let scale = model.covariance_factor();
        let mut all = [None; MAX_MODES];
        for (sd, factor) in all.iter_mut().zip(self.roots.factors(P)) {
            *sd = deviation(model.a(), N, factor, fs, model.covariance(), scale);
        }
        all
    }
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> State<T> for Fixed<T, P, Q, N> {
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        let Self { model, roots, lost } = self;
        visitor.part("Fixed model roots lost");
        roots.visit_state(visitor);
        State::<T>::visit_state(lost, visitor) && model.visit_state(visitor)
    }
}

macro_rules! identifier {
    ($($order:ident: $p:literal, $q:literal, $n:literal;)*) => {
        #[derive(Debug, Clone, Default)]
        // The sizes differ on purpose: one value lives in static memory for ever.
        #[allow(clippy::large_enum_variant)]
        enum Any<T> {
            #[default]
            Unstarted,
            $($order(Fixed<T, $p, $q, $n>),)*
        }

        impl<T: Real> Any<T> {
            fn order(&self) -> Option<Order> {
                match self {
                    Self::Unstarted => None,
                    $(Self::$order(_) => Some(Order::$order),)*
                }
            }

            /// What is blank is written where it lies: no model is built elsewhere.
            fn restart(&mut self, order: Order, config: RarmaConfig<T>) {
                match order {
                    $(Order::$order => {
                        if !matches!(self, Self::$order(_)) {
                            *self = Self::$order(Fixed::BLANK);
                        }
                        if let Self::$order(fixed) = self {
                            fixed.restart(config);
                        }
                    })*
                }
            }
        }

        /// The model of whatever order it is, and what there is without one.
        macro_rules! of {
            ($any:expr, $fixed:ident => $work:expr, else $nothing:expr) => {
                match $any {
                    Any::Unstarted => $nothing,
                    $(Any::$order($fixed) => $work,)*
                }
            };
        }
    };
}

identifier! {
    O21: 2, 1, 3;
    O22: 2, 2, 4;
    O43: 4, 3, 7;
    O44: 4, 4, 8;
    O65: 6, 5, 11;
    O66: 6, 6, 12;
    O87: 8, 7, 15;
    O88: 8, 8, 16;
}

impl<T: Real> State<T> for Identifier<T> {
    /// Its order is one of the settings.
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        of!(&mut self.0, fixed => fixed.visit_state(visitor), else true)
    }
}

/// A recursive model ([`RecursiveArma`]) and the roots of its A ([`FactorTracker`]), of an
/// order that is chosen while the program runs. As large as the largest order.
///
/// ```
/// use rarma_core::Order;
/// use rarma_core::estimate::RarmaConfig;
/// use rarma_core::monitor::Identifier;
/// let mut identifier = Identifier::<f32>::default();
/// identifier.restart(Order::O43, RarmaConfig::default());
/// let mut own = [0.0; 4];
/// for n in 0..2000 {
///     let y = (0.7 * n as f32).sin() + 0.5 * (1.9 * n as f32).sin();
///     assert_eq!(identifier.update(y, &mut own), 2);
/// }
/// assert!(identifier.is_ready() && !identifier.is_lost());
/// assert_eq!(identifier.factors().len(), 2);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Identifier<T>(Any<T>);

impl<T: Real> Identifier<T> {
    /// Forgets everything and begins with this order and these settings, in place: no
    /// second model lies on the stack meanwhile. Settings out of range are replaced as a
    /// whole by the defaults.
    pub fn restart(&mut self, order: Order, config: RarmaConfig<T>) {
        self.0.restart(order, config);
    }

    /// Takes one sample: a new model, and its roots. Each mode's own part of the signal
    /// ([`isolate`]) goes to `own`, in the order of [`Self::factors`]; returns how many
    /// there are. Before the first [`Self::restart`] none.
    #[inline(always)]
    pub fn update(&mut self, y: T, own: &mut [T; MAX_MODES]) -> usize {
        of!(&mut self.0, fixed => fixed.update(y, own), else 0)
    }

    /// The order, once it has been started.
    pub fn order(&self) -> Option<Order> {
        self.0.order()
    }

    /// The model's start-up is over.
    pub fn is_ready(&self) -> bool {
        of!(&self.0, fixed => fixed.model.ready(), else false)
    }

    /// The roots are not those of the model: they are being searched for.
    pub fn is_lost(&self) -> bool {
        of!(&self.0, fixed => fixed.lost, else true)
    }

    /// Real quadratic factors of A, half of p, in an order that is kept.
    pub fn factors(&self) -> &[Quadratic<T>] {
        of!(&self.0, fixed => fixed.roots.factors(fixed.model.a().len()), else &[])
    }

    /// Coefficients a₁…a_p of A(q), without the leading 1.
    pub fn a(&self) -> &[T] {
        of!(&self.0, fixed => fixed.model.a(), else &[])
    }

    /// Coefficients c₁…c_q of C(q), without the leading 1.
    pub fn c(&self) -> &[T] {
        of!(&self.0, fixed => fixed.model.c(), else &[])
    }

    /// Innovation variance σ², input units squared.
    pub fn sigma2(&self) -> T {
        of!(&self.0, fixed => fixed.model.sigma2(), else T::ZERO)
    }

    /// Standard deviations of frequency and damping of each mode, in the order of [`Self::factors`], at
    /// `fs` samples a second; none for real roots. Decision rate.
    pub fn deviations(&self, fs: T) -> [Option<ModalDeviation<T>>; MAX_MODES] {
        of!(&self.0, fixed => fixed.deviations(fs), else [None; MAX_MODES])
    }

    /// The covariance of the parameters is finite and positive definite. Slow path.
    pub fn is_definite(&self) -> bool {
        let n = self.a().len() + self.c().len();
        of!(&self.0, fixed => fixed.model.covariance().is_definite(n), else true)
    }
}

#[cfg(test)]
#[path = "identifier_tests.rs"]
mod tests;
