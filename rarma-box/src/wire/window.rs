//! Which sequence numbers have come: a frame counts once.
//!
//! The highest number, and a bit for each of the 64 up to it, as IPsec keeps it (RFC 4303,
//! 3.4.3). One difference: a number below the highest that has not come is told apart, for
//! here the order counts. An `arm` that a `stop` has overtaken is not carried out.

/// Numbers below the highest that are remembered.
pub const WINDOW: u32 = 64;

/// What a number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrival {
    /// Higher than all that have come.
    New,
    /// It has not come, but a later one has.
    Overtaken,
    /// It has come.
    Repeated,
    /// Too old to tell, or 0, which is no number.
    Old,
}

/// Which sequence numbers have come.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Window {
    highest: u32,
    /// Bit k: the number `highest - k` has come.
    seen: u64,
}

impl Window {
    /// What a number is, without taking it.
    pub fn look(&self, number: u32) -> Arrival {
        if number == 0 {
            return Arrival::Old;
        }
        match self.highest.checked_sub(number) {
            None => Arrival::New,
            Some(age) if age >= WINDOW => Arrival::Old,
            Some(age) if self.seen >> age & 1 == 1 => Arrival::Repeated,
            Some(_) => Arrival::Overtaken,
        }
    }

    /// Remembers a number that is new or was overtaken.
    pub fn take(&mut self, number: u32) {
        match self.highest.checked_sub(number) {
            None => {
                let step = number - self.highest;
                self.seen = self.seen.checked_shl(step).unwrap_or(0) | 1;
                self.highest = number;
            }
            Some(age) if age < WINDOW => self.seen |= 1 << age,
            Some(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn numbers_at_the_edges() {
        let mut window = Window::default();
        assert_eq!(window.look(0), Arrival::Old);
        assert_eq!(window.look(1), Arrival::New);
        window.take(100);
        assert_eq!(window.look(100), Arrival::Repeated);
        assert_eq!(window.look(37), Arrival::Overtaken);
        assert_eq!(window.look(36), Arrival::Old);
        window.take(37);
        assert_eq!(window.look(37), Arrival::Repeated);
        window.take(u32::MAX);
        assert_eq!(window.look(100), Arrival::Old);
        assert_eq!(window.look(u32::MAX), Arrival::Repeated);
        assert_eq!(window.look(u32::MAX - 1), Arrival::Overtaken);
    }

    proptest! {
        /// Against a set of everything that has come.
        #[test]
        fn no_number_counts_twice(numbers in proptest::collection::vec(0u32..300, 1..400)) {
            let mut window = Window::default();
            let mut come = BTreeSet::new();
            for n in numbers {
                let most = come.last().copied().unwrap_or(0);
                let expected = if n == 0 || n + WINDOW <= most {
                    Arrival::Old
                } else if come.contains(&n) {
                    Arrival::Repeated
                } else if n > most {
                    Arrival::New
                } else {
                    Arrival::Overtaken
                };
                prop_assert_eq!(window.look(n), expected);
                if matches!(expected, Arrival::New | Arrival::Overtaken) {
                    window.take(n);
                    come.insert(n);
                }
            }
        }
    }
}
