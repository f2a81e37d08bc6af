//! All that a recursive model knows, number by number: to be kept, and to go on from later.
//!
//! Slow path. Settings are not part of it: the model that takes a state in has been made with
//! the same order and the same settings as the one that gave it.

use super::bounded::BoundedArma;
use super::rarma::RecursiveArma;
use crate::real::Real;
use crate::visit::{StateVisitor, all, place};

impl<T: Real, const P: usize, const Q: usize, const N: usize> RecursiveArma<T, P, Q, N> {
    /// Shows every number of the state to `visitor`; false where what it has put in is not the
    /// state of a model of this order and these settings, and the model is then of no use.
    #[must_use]
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        // All of them by name, so that none is forgotten.
        let Self {
            theta,
            phi,
            psi,
            older,
            covariance,
            config: _,
            inverse_lambda: _,
            inverse_radius: _,
            sigma2,
            variance_gain,
            recent,
            power,
            known,
            count,
            turn,
            at_ceiling,
            start,
        } = self;
        for numbers in [theta, phi, psi, older] {
            all(numbers, visitor);
        }
        covariance.visit_state(visitor);
        all([sigma2, variance_gain, recent, power], visitor);
        visitor.count(known);
        visitor.count(count);
        place(turn, visitor);
        place(at_ceiling, visitor);
        start.visit_state(visitor) && *turn <= N && *at_ceiling <= N
    }
}

impl<T: Real> BoundedArma<T> {
    /// See [`RecursiveArma::visit_state`].
    #[must_use]
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        self.inner.visit_state(visitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::{Arma43, Gain, RarmaConfig};
    use crate::spectrum::FactorTracker;

    #[derive(Default)]
    struct Out(Vec<f64>);

    impl StateVisitor<f64> for Out {
        fn number(&mut self, x: &mut f64) {
            self.0.push(*x);
        }
        fn count(&mut self, n: &mut u32) {
            self.0.push(f64::from(*n));
        }
    }

    struct In(std::vec::IntoIter<f64>);

    impl StateVisitor<f64> for In {
        fn number(&mut self, x: &mut f64) {
            *x = self.0.next().expect("as many as were written");
        }
        fn count(&mut self, n: &mut u32) {
            *n = self.0.next().expect("as many as were written") as u32;
        }
    }

    /// Two tones in noise that repeats, so that every stage of the start-up is passed.
    fn sample(n: u32) -> f64 {
        let noise = n.wrapping_mul(1_664_525).wrapping_add(1_013_904_223) >> 8;
        let t = f64::from(n);
        libm::sin(0.7 * t) + libm::sin(1.9 * t) + f64::from(noise) / 8_388_608.0 - 1.0
    }

    #[test]
    fn goes_on_from_any_moment_as_if_nothing_had_been() {
        let settings = [
            RarmaConfig::default(),
            RarmaConfig {
                forgetting: 0.999,
                random_walk: 1e-8,
                ..RarmaConfig::default()
            },
            RarmaConfig {
                gain: Gain::normalised(),
                ..RarmaConfig::default()
            },
        ];
        for config in settings {
            // Collecting, lattice, rounds, catching up, running.
            for cut in [0, 7, 399, 410, 430, 600, 900, 1100, 3000] {
                let mut whole = Arma43::<f64>::new(config);
                let mut roots = FactorTracker::<f64, 4>::new();
                for n in 0..cut {
                    whole.update(sample(n));
                    roots.track(whole.a());
                }
                let mut kept = Out::default();
                assert!(whole.visit_state(&mut kept));
                roots.visit_state(&mut kept);
                let mut again = Arma43::<f64>::new(config);
                let mut roots_again = FactorTracker::<f64, 4>::new();
                let mut back = In(kept.0.into_iter());
                assert!(again.visit_state(&mut back));
                roots_again.visit_state(&mut back);
                assert_eq!(back.0.next(), None, "all of it is read");
                for n in cut..cut + 1500 {
                    let (x, y) = (whole.update(sample(n)), again.update(sample(n)));
                    assert_eq!(x.innovation.to_bits(), y.innovation.to_bits(), "{cut}: {n}");
                    roots.track(whole.a());
                    roots_again.track(again.a());
                    assert_eq!(roots.factors(4), roots_again.factors(4), "{cut}: {n}");
                }
                assert_eq!(whole.theta(), again.theta());
            }
        }
    }

    #[test]
    fn what_is_no_state_is_refused() {
        let mut model = Arma43::<f64>::new(RarmaConfig::default());
        let mut kept = Out::default();
        assert!(model.visit_state(&mut kept));
        for (from_end, nonsense) in [(0, 1e9), (1, 1e9), (2, 1e9)] {
            // Behind the estimate of a round, 7 numbers, nothing but places and counts ends it.
            let mut wrong = kept.0.clone();
            let at = wrong.len() - 1 - from_end;
            wrong[at] = nonsense;
            assert!(!model.visit_state(&mut In(wrong.into_iter())), "{from_end}");
        }
    }
}
