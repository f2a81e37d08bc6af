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
    /// A part of the state begins; `names` are its own and those of what is shown of it. Who keeps a
    /// state can tell by them, and by what comes after, whether another one is laid out as this is.
    fn part(&mut self, names: &'static str) {
        let _ = names;
    }
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

/// A part of a state: what changes while samples come. What was made of the settings is no part
/// of it, so that nothing that is put in can change it.
#[cfg_attr(
    not(feature = "monitor"),
    allow(
        dead_code,
        reason = "who asks for all of it is not there; older compilers do not say so"
    )
)]
pub(crate) trait State<T> {
    /// Shows every number of it; false where what was put in is none of its states.
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool;
}

mod parts {
    use super::{State, StateVisitor};
    use crate::real::Real;

    impl<T: Real> State<T> for T {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            visitor.number(self);
            true
        }
    }

    impl<T: Real> State<T> for u32 {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            visitor.count(self);
            true
        }
    }

    impl<T: Real> State<T> for u64 {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            let (mut high, mut low) = ((*self >> 32) as u32, *self as u32);
            visitor.count(&mut high);
            visitor.count(&mut low);
            *self = (u64::from(high) << 32) | u64::from(low);
            // More samples than a machine runs for: no sum of two of them wraps.
            high < 1 << 30
        }
    }

    macro_rules! small {
        ($($whole:ty)*) => {$(
            impl<T: Real> State<T> for $whole {
                fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
                    // None is as large as the largest.
                    let mut n = u32::try_from(*self).unwrap_or(u32::MAX);
                    visitor.count(&mut n);
                    match <$whole>::try_from(n) {
                        Ok(there) => *self = there,
                        Err(_) => return false,
                    }
                    n < u32::MAX
                }
            }
        )*};
    }

    small!(u8 u16 usize);

    impl<T: Real> State<T> for bool {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            let mut n = u32::from(*self);
            visitor.count(&mut n);
            *self = n == 1;
            n <= 1
        }
    }

    impl<T: Real, S: State<T>, const N: usize> State<T> for [S; N] {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            self.iter_mut().all(|part| part.visit_state(visitor))
        }
    }

    impl<T: Real, S: State<T> + Default> State<T> for Option<S> {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            let mut is = self.is_some();
            if !State::<T>::visit_state(&mut is, visitor) {
                return false;
            }
            if !is {
                *self = None;
                return true;
            }
            self.get_or_insert_default().visit_state(visitor)
        }
    }

    impl<T: Real, A: State<T>, B: State<T>> State<T> for (A, B) {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            self.0.visit_state(visitor) && self.1.visit_state(visitor)
        }
    }

    impl<T: Real, A: State<T>, B: State<T>, C: State<T>> State<T> for (A, B, C) {
        fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
            let both = self.0.visit_state(visitor) && self.1.visit_state(visitor);
            both && self.2.visit_state(visitor)
        }
    }
}

/// Makes a structure a [`State`]. All of its fields by name, so that none is forgotten: those that
/// are shown; behind `made`, parts that are there or not by the settings; behind `settings`, what
/// is not shown; behind `where`, what holds of every state, so that nothing reaches beyond an
/// array whatever was put in.
macro_rules! state {
    (@ [$($generic:tt)*] $name:ty, {
        $($field:ident),*
        $(; made $($made:ident),+)?
        $(; settings $($setting:ident),+)?
        $(; where $holds:expr)?
    }) => {
        impl<T: crate::real::Real $($generic)*> crate::visit::State<T> for $name {
            fn visit_state(&mut self, visitor: &mut impl crate::visit::StateVisitor<T>) -> bool {
                let Self { $($field,)* $($($made,)+)? $($($setting,)+)? } = self;
                $($(let _ = &$setting;)+)?
                visitor.part(concat!(stringify!($name) $(, " ", stringify!($field))*));
                $(if !crate::visit::State::<T>::visit_state($field, visitor) { return false; })*
                $($(if let Some(made) = $made
                    && !crate::visit::State::<T>::visit_state(made, visitor) { return false; })+)?
                true $(&& $holds)?
            }
        }
    };
    ($name:ident<T, const $n:ident> $fields:tt) => {
        crate::visit::state!(@ [, const $n: usize] $name<T, $n>, $fields);
    };
    ($name:ident<T> $fields:tt) => {
        crate::visit::state!(@ [] $name<T>, $fields);
    };
    ($name:ident $fields:tt) => {
        crate::visit::state!(@ [] $name, $fields);
    };
}

/// Makes a choice among a few a [`State`].
#[cfg(feature = "monitor")]
macro_rules! choice {
    ($name:ident: $($one:ident),+) => {
        impl<T: crate::real::Real> crate::visit::State<T> for $name {
            fn visit_state(&mut self, visitor: &mut impl crate::visit::StateVisitor<T>) -> bool {
                let all = [$(Self::$one),+];
                let mut n = all.iter().position(|one| one == self).unwrap_or(all.len());
                let fits = crate::visit::State::<T>::visit_state(&mut n, visitor);
                match all.get(n) {
                    Some(one) => *self = *one,
                    None => return false,
                }
                fits
            }
        }
    };
}

#[cfg(feature = "monitor")]
pub(crate) use choice;
pub(crate) use state;
