//! How fast, per sample: the product's estimator, a textbook one, and a public crate's,
//! all on the same signal.
//!
//! `cargo bench -p host-tests --bench estimators`. A block is a thousand samples, so
//! that a time in µs is the nanoseconds of one sample. Figures are of the machine they
//! are run on.

use divan::{Bencher, black_box};
use host_tests::plain::{DurandKerner, PlainRpem};
use host_tests::signal;
use oxictl::adaptive::Rls;
use oxictl::core::scalar::ControlScalar;
use rarma_core::Real;
use rarma_core::estimate::{RarmaConfig, RecursiveArma};
use rarma_core::spectrum::{FactorTracker, modal};
use std::sync::LazyLock;

const FS: f64 = 6000.0;
const LAMBDA: f64 = 0.998;
const BLOCK: usize = 1000;
/// Samples before the first block: starts are over, roots are found.
const WARM_UP: usize = 5000;

/// Three modes, as the box hears them after decimation.
static SOUND: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let modes = [(600.0, 0.03), (900.0, 0.01), (1900.0, 0.02)];
    let sound = signal::modes(&modes, FS, 2).map(|x| x as f32);
    sound.take(WARM_UP + BLOCK).collect()
});

fn main() {
    divan::main();
}

/// What is timed: one sample in, something that depends on all work out.
trait Estimator: Default + Clone {
    fn step(&mut self, y: f32) -> f64;
}

fn time<E: Estimator>(bencher: Bencher<'_, '_>) {
    let (before, block) = SOUND.split_at(WARM_UP);
    let mut estimator = E::default();
    for &y in before {
        estimator.step(y);
    }
    // Every block starts from the same state: a dense covariance does not last for ever.
    bencher
        .counter(divan::counter::ItemsCount::new(BLOCK))
        .with_inputs(|| estimator.clone())
        .bench_local_refs(|estimator| {
            for &y in block {
                black_box(estimator.step(black_box(y)));
            }
        });
}

#[derive(Clone)]
struct Ours<T, const P: usize, const Q: usize, const N: usize>(RecursiveArma<T, P, Q, N>);

impl<T: Real, const P: usize, const Q: usize, const N: usize> Default for Ours<T, P, Q, N> {
    fn default() -> Self {
        Self(RecursiveArma::new(RarmaConfig {
            forgetting: T::from_f64(LAMBDA),
            variance_gain: T::from_f64(1.0 - LAMBDA),
            ..RarmaConfig::default()
        }))
    }
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> Estimator for Ours<T, P, Q, N> {
    fn step(&mut self, y: f32) -> f64 {
        self.0.update(T::from_f32(y)).innovation.to_f64()
    }
}

/// With the roots of A.
#[derive(Clone, Default)]
struct OursRoots<T: Real, const P: usize, const Q: usize, const N: usize> {
    model: Ours<T, P, Q, N>,
    roots: FactorTracker<T, P>,
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> Estimator for OursRoots<T, P, Q, N> {
    fn step(&mut self, y: f32) -> f64 {
        self.model.0.update(T::from_f32(y));
        self.roots.track(self.model.0.a());
        self.roots.factors(P)[0].u.to_f64()
    }
}

/// With the roots of A, and frequency and damping of each mode.
#[derive(Clone, Default)]
struct OursDamping<T: Real, const P: usize, const Q: usize, const N: usize>(OursRoots<T, P, Q, N>);

impl<T: Real, const P: usize, const Q: usize, const N: usize> Estimator
    for OursDamping<T, P, Q, N>
{
    fn step(&mut self, y: f32) -> f64 {
        self.0.step(y);
        let modes = self.0.roots.factors(P).iter();
        modes
            .filter_map(|factor| modal(factor, T::from_f64(FS)))
            .fold(T::ZERO, |sum, mode| sum + mode.damping)
            .to_f64()
    }
}

#[derive(Clone)]
struct Plain<T, const P: usize, const Q: usize, const N: usize>(PlainRpem<T, P, Q, N>);

impl<T: Real, const P: usize, const Q: usize, const N: usize> Default for Plain<T, P, Q, N> {
    fn default() -> Self {
        let (lambda, gain) = (T::from_f64(LAMBDA), T::from_f64(1.0 - LAMBDA));
        Self(PlainRpem::new(lambda, gain, T::from_f64(0.1)))
    }
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> Estimator for Plain<T, P, Q, N> {
    fn step(&mut self, y: f32) -> f64 {
        self.0.update(T::from_f32(y)).to_f64()
    }
}

/// With the roots of A by Durand and Kerner, and the damping of each mode.
#[derive(Clone, Default)]
struct PlainDamping<T: Real, const P: usize, const Q: usize, const N: usize> {
    model: Plain<T, P, Q, N>,
    roots: DurandKerner<T, P>,
}

impl<T: Real, const P: usize, const Q: usize, const N: usize> Estimator
    for PlainDamping<T, P, Q, N>
{
    fn step(&mut self, y: f32) -> f64 {
        self.model.0.update(T::from_f32(y));
        self.roots.damping(&self.model.0.theta()[..P]).to_f64()
    }
}

/// The recursive least squares of `oxictl`, made extended least squares (RPLR) by
/// handing it past residuals as regressors. Its own extended least squares is a batch
/// for a model with a known input; on an ARMA without input it does not converge at
/// (2,1) and meets a singular matrix at (6,5).
struct Crate<T: ControlScalar, const P: usize, const Q: usize, const N: usize> {
    rls: Rls<T, N>,
    phi: [T; N],
}

impl<T: ControlScalar, const P: usize, const Q: usize, const N: usize> Default
    for Crate<T, P, Q, N>
{
    fn default() -> Self {
        Self {
            rls: Rls::new(T::from_f64(LAMBDA), T::from_f64(1.0)),
            phi: [T::from_f64(0.0); N],
        }
    }
}

impl<T: ControlScalar, const P: usize, const Q: usize, const N: usize> Clone for Crate<T, P, Q, N> {
    fn clone(&self) -> Self {
        let mut rls = Rls::new(self.rls.lambda, T::from_f64(1.0));
        rls.theta = self.rls.theta;
        rls.p = self.rls.p;
        Self { rls, phi: self.phi }
    }
}

impl<T: ControlScalar, const P: usize, const Q: usize, const N: usize> Estimator
    for Crate<T, P, Q, N>
{
    fn step(&mut self, y: f32) -> f64 {
        let y = T::from_f64(f64::from(y));
        self.rls.update(&self.phi, y);
        let residual = self.rls.prediction_error(&self.phi, y);
        self.phi.copy_within(0..N - 1, 1);
        self.phi[0] = -y;
        self.phi[P] = residual;
        residual.to_f64()
    }
}

macro_rules! orders {
    ($($name:ident $p:literal $q:literal $n:literal;)*) => {$(
        mod $name {
            use super::*;

            #[divan::bench(types = [
                Ours<f32, $p, $q, $n>, Ours<f64, $p, $q, $n>,
                OursRoots<f32, $p, $q, $n>, OursRoots<f64, $p, $q, $n>,
                OursDamping<f32, $p, $q, $n>, OursDamping<f64, $p, $q, $n>,
                Plain<f32, $p, $q, $n>, Plain<f64, $p, $q, $n>,
                PlainDamping<f32, $p, $q, $n>, PlainDamping<f64, $p, $q, $n>,
                Crate<f32, $p, $q, $n>, Crate<f64, $p, $q, $n>,
            ])]
            fn a_thousand_samples<E: Estimator>(bencher: Bencher<'_, '_>) {
                time::<E>(bencher);
            }
        }
    )*};
}

orders! {
    order_21 2 1 3;
    order_22 2 2 4;
    order_43 4 3 7;
    order_44 4 4 8;
    order_65 6 5 11;
    order_66 6 6 12;
    order_87 8 7 15;
    order_88 8 8 16;
}
