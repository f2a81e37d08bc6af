//! An estimator under watch: is everything a number, is the covariance definite, is
//! C stable, sample by sample; and how soon and how well it reads a good signal
//! afterwards.

use crate::bound::{Bound, ModeBound};
use crate::hostile::{FS, GOOD_MODE, good_noise};
use crate::statistics::{quantile, rms};
use rarma_core::Real;
use rarma_core::estimate::{RarmaConfig, RecursiveArma, Status};
use rarma_core::spectrum::{FactorTracker, modal};

/// Memory of the box at [`FS`], samples: 0.1 s.
pub const MEMORY: usize = 600;
/// Samples that exponential forgetting is worth: (1 + λ)/(1 − λ).
pub const WORTH: f64 = 2.0 * MEMORY as f64 - 1.0;
/// The covariance and C are looked at once in so many samples; innovation and
/// parameters at every one.
pub const LOOK: u64 = 8;

/// Seeds of the good signal.
const SEEDS: u64 = 8;
/// Samples of it.
const GOOD: usize = 60 * MEMORY;
/// The mode is read once in so many samples.
const READ: usize = 60;
/// Recovered: within so many standard deviations of the bound ...
const CLOSE: f64 = 3.0;
/// ... at so many readings on end (one memory).
const STAY: usize = MEMORY / READ;

/// Settings of the box at [`FS`], as the monitor makes them from its 0.1 s.
#[must_use]
pub fn box_settings<T: Real>() -> RarmaConfig<T> {
    let gain = 1.0 / MEMORY as f64;
    RarmaConfig {
        forgetting: T::from_f64(1.0 - gain),
        variance_gain: T::from_f64(gain),
        ..RarmaConfig::default()
    }
}

/// What went wrong, in samples or looks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Samples taken.
    pub samples: u64,
    /// Samples after which the innovation or a parameter was no finite number.
    pub not_finite: u64,
    /// Looks at which the covariance was not positive definite.
    pub indefinite: u64,
    /// Looks at which C had a root on or outside the unit circle.
    pub unstable: u64,
    /// Samples that were refused, rightly or not.
    pub rejected: u64,
    /// First sample at which something was wrong.
    pub first: Option<u64>,
}

impl Tally {
    /// Nothing was ever wrong.
    #[must_use]
    pub fn healthy(&self) -> bool {
        self.not_finite == 0 && self.indefinite == 0 && self.unstable == 0
    }
}

/// How the good signal is read after a hard one; errors of ζ over the bound's
/// standard deviation for the memory ([`WORTH`]).
#[derive(Debug, Clone)]
pub struct Recovery {
    /// Samples until ζ and f stayed close for a memory, one for each seed; none if
    /// never.
    pub samples: Vec<Option<usize>>,
    /// Root mean square error after the expected time, over the bound.
    pub rms: f64,
    /// The same of the median.
    pub median: f64,
    /// Part of the readings after that time without the mode or off by more than
    /// five times the bound; left out of `rms`.
    pub failed: f64,
}

impl Recovery {
    /// The slowest seed; none if one never came back.
    #[must_use]
    pub fn slowest(&self) -> Option<usize> {
        let all: Option<Vec<usize>> = self.samples.iter().copied().collect();
        all?.into_iter().max()
    }

    /// The median seed; none if half never came back.
    #[must_use]
    pub fn typical(&self) -> Option<usize> {
        let mut all: Vec<usize> = self
            .samples
            .iter()
            .map(|n| n.unwrap_or(usize::MAX))
            .collect();
        all.sort_unstable();
        Some(all[all.len() / 2]).filter(|n| *n != usize::MAX)
    }
}

/// An estimator of any order and precision under watch.
pub trait Watched: Send {
    /// p and q.
    fn order(&self) -> (usize, usize);
    /// Takes samples and watches.
    fn feed(&mut self, samples: &[f32]);
    /// What was seen so far.
    fn tally(&self) -> Tally;
    /// Reads good signals from here on, with copies of itself; errors count from
    /// sample `after` on.
    fn recover(&self, bound: &ModeBound, after: usize) -> Recovery;
}

/// The bound of the good signal at the memory of the box.
#[must_use]
pub fn good_bound() -> ModeBound {
    let one = Bound::of_modes(&good_noise(0)).mode(GOOD_MODE.0, GOOD_MODE.1, FS);
    ModeBound {
        frequency: one.frequency / WORTH.sqrt(),
        damping: one.damping / WORTH.sqrt(),
    }
}

/// Every order of the box, in one precision.
#[must_use]
pub fn all_orders<T: Real + Send + 'static>(config: RarmaConfig<T>) -> Vec<Box<dyn Watched>> {
    vec![
        Box::new(Watch::<T, 2, 1, 3>::new(config)),
        Box::new(Watch::<T, 2, 2, 4>::new(config)),
        Box::new(Watch::<T, 4, 3, 7>::new(config)),
        Box::new(Watch::<T, 4, 4, 8>::new(config)),
        Box::new(Watch::<T, 6, 5, 11>::new(config)),
        Box::new(Watch::<T, 6, 6, 12>::new(config)),
        Box::new(Watch::<T, 8, 7, 15>::new(config)),
        Box::new(Watch::<T, 8, 8, 16>::new(config)),
    ]
}

/// One estimator and what was seen of it.
#[derive(Clone)]
pub struct Watch<T, const P: usize, const Q: usize, const N: usize> {
    model: RecursiveArma<T, P, Q, N>,
    tally: Tally,
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> Watch<T, P, Q, N> {
    /// A fresh estimator.
    #[must_use]
    pub fn new(config: RarmaConfig<T>) -> Self {
        Self {
            model: RecursiveArma::new(config),
            tally: Tally::default(),
        }
    }

    #[inline(always)]
    fn watch(&mut self, y: f32) {
        let step = self.model.update(T::from_f32(y));
        let tally = &mut self.tally;
        tally.rejected += u64::from(step.status == Status::Rejected);
        // One sum is finite only if all its terms are: θ is far below overflow.
        let sum = self.model.theta().iter().fold(T::ZERO, |sum, x| sum + *x);
        let mut wrong = false;
        if !(sum.is_finite() && step.innovation.is_finite()) {
            tally.not_finite += 1;
            wrong = true;
        }
        if tally.samples.is_multiple_of(LOOK) {
            let indefinite = !self.model.covariance().is_definite(N);
            let unstable = !stable(self.model.c());
            tally.indefinite += u64::from(indefinite);
            tally.unstable += u64::from(unstable);
            wrong |= indefinite || unstable;
        }
        if wrong && tally.first.is_none() {
            tally.first = Some(tally.samples);
        }
        tally.samples += 1;
    }

    /// Errors of the mode nearest to the good one over the bound: ζ and f.
    fn off(&self, bound: &ModeBound) -> Option<(f64, f64)> {
        let a: [f64; P] = core::array::from_fn(|i| self.model.a()[i].to_f64());
        let mut roots = FactorTracker::<f64, P>::new();
        roots.solve(&a, 500)?;
        let found = roots.factors(P).iter().filter_map(|q| modal(q, FS));
        let mode = found.min_by(|x, y| {
            let off = |f: f64| (f - GOOD_MODE.0).abs();
            off(x.frequency).total_cmp(&off(y.frequency))
        })?;
        Some((
            (mode.damping - GOOD_MODE.1) / bound.damping,
            (mode.frequency - GOOD_MODE.0) / bound.frequency,
        ))
    }
}

impl<T, const P: usize, const Q: usize, const N: usize> Watched for Watch<T, P, Q, N>
where
    T: Real + Send,
{
    fn order(&self) -> (usize, usize) {
        (P, Q)
    }

    fn feed(&mut self, samples: &[f32]) {
        for &y in samples {
            self.watch(y);
        }
    }

    fn tally(&self) -> Tally {
        self.tally
    }

    fn recover(&self, bound: &ModeBound, after: usize) -> Recovery {
        let (mut times, mut sizes) = (Vec::new(), Vec::new());
        for seed in 0..SEEDS {
            let mut copy = self.clone();
            let (mut close, mut back) = (0, None);
            for (k, y) in good_noise(1000 + seed).take(GOOD).enumerate() {
                copy.watch(y as f32);
                if k % READ != 0 {
                    continue;
                }
                let off = copy.off(bound);
                if back.is_none() {
                    let here = off.is_some_and(|(z, f)| z.abs().max(f.abs()) < CLOSE);
                    close = if here { close + 1 } else { 0 };
                    if close == STAY {
                        back = Some(k - (STAY - 1) * READ);
                    }
                }
                if k >= after {
                    sizes.push(off.map_or(f64::INFINITY, |(z, _)| z.abs()));
                }
            }
            times.push(back);
        }
        let near: Vec<f64> = sizes.iter().copied().filter(|x| *x < 5.0).collect();
        Recovery {
            samples: times,
            rms: rms(&near),
            median: quantile(&sizes, 0.5) / 0.6745,
            failed: 1.0 - near.len() as f64 / sizes.len() as f64,
        }
    }
}

/// Every root of z^q + c₁ z^(q−1) + … inside the unit circle: step-down in double
/// precision, nothing of the product. What is no number is not stable.
#[must_use]
pub fn stable<T: Real>(c: &[T]) -> bool {
    let mut a = [0.0; 32];
    for (a, c) in a.iter_mut().zip(c) {
        *a = c.to_f64();
    }
    for m in (1..=c.len()).rev() {
        let k = a[m - 1];
        if !(k.abs() < 1.0) {
            return false;
        }
        let scale = 1.0 / (1.0 - k * k);
        for i in 0..m / 2 {
            let (x, y) = (a[i], a[m - 2 - i]);
            a[i] = (x - k * y) * scale;
            a[m - 2 - i] = (y - k * x) * scale;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::polynomial;

    #[test]
    fn stable_means_inside_the_circle() {
        let inside = polynomial(&[(900.0, 0.001), (300.0, 0.1), (2500.0, 0.3)], FS);
        assert!(stable(&inside));
        let outside = polynomial(&[(900.0, -0.001), (300.0, 0.1), (2500.0, 0.3)], FS);
        assert!(!stable(&outside));
        assert!(stable(&[0.999]) && !stable(&[-1.0]) && !stable(&[0.1, f32::NAN]));
        assert!(stable::<f32>(&[]));
    }
}
