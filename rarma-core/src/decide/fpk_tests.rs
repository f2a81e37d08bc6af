extern crate std;
use super::*;
use crate::decide::{Amplitude, critical_scintillation};
use proptest::prelude::*;
use std::vec::Vec;

/// Uniform numbers in 0..1.
struct Draw(u64);

impl Draw {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn exponential(&mut self) -> f64 {
        -self.uniform().ln()
    }

    fn normal(&mut self) -> f64 {
        (2.0 * self.exponential()).sqrt() * (core::f64::consts::TAU * self.uniform()).cos()
    }
}

/// ζ of a mode (far up in frequency) so fast that every V counts as one.
const APART: f64 = 1.0;

fn judged<T: Real>(values: impl Iterator<Item = f64>, zeta: f64) -> AmplitudeReading<T> {
    let mut fpk = Fpk::<T>::new(0.002);
    let f = if zeta == APART { 98_000.0 } else { 980.0 };
    for v in values {
        fpk.push(T::from_f64(v), T::from_f64(f), T::from_f64(zeta));
    }
    fpk.reading()
}

#[test]
fn counts_independent_values_as_the_formula_says() {
    for (zeta, want) in [
        (f64::NAN, 0.0),
        (-0.01, 11.0),
        (0.0, 11.0),
        (1e-4, 11.0),
        (APART, 1000.0),
    ] {
        // 1000 values: seven closed eighths of 125 and an open one.
        let n = judged::<f64>((0..1000).map(|i| 1.0 + f64::from(i % 2)), zeta).effective;
        let whole = if want > 900.0 {
            875.0..1000.0
        } else {
            want * 0.85..want * 1.01 + 1e-9
        };
        assert!(whole.contains(&n) || n == want, "{zeta}: {n}");
    }
    // ζω·T·0.635 at three half-widths: 2 s at 2 % are worth 156 out of 246.
    let n = judged::<f64>((0..999).map(|_| 1.0), 0.02).effective;
    assert!((130.0..165.0).contains(&n), "{n}");
}

#[test]
fn exponential_values_are_forced_and_a_limit_cycle_is_not() {
    let mut counts = [0; 2];
    for seed in 0..200 {
        let mut draw = Draw(seed);
        let r = judged::<f32>((0..999).map(|_| 1e-9 * draw.exponential()), APART);
        assert!(
            (0.7..1.5).contains(&r.scintillation)
                && (r.kurtosis() - 1.5 * (1.0 + r.scintillation)).abs() < 1e-5
        );
        assert!((0.8e-9..1.2e-9).contains(&r.mean));
        counts[0] += usize::from(r.verdict != Amplitude::Forced);
        // A hump of S = 0.25.
        let r = judged::<f32>(
            (0..999).map(|_| (1.0 + 0.5 * draw.normal()).max(0.0)),
            APART,
        );
        counts[1] += usize::from(r.verdict != Amplitude::SelfExcited);
        assert!((0.18..0.31).contains(&r.scintillation), "{r:?}");
    }
    assert!(counts[0] <= 5 && counts[1] == 0, "{counts:?}");
}

#[test]
fn single_precision_agrees_with_double() {
    for (zeta, sway) in [(APART, 0.9), (0.005, 0.01), (0.02, 1e-3)] {
        let signal = || (0..3000).map(move |i| 1e-12 * (1.0 + sway * (f64::from(i) * 0.37).sin()));
        let (a, b) = (judged::<f32>(signal(), zeta), judged::<f64>(signal(), zeta));
        let off = |x: f32, y: f64| (f64::from(x) / y - 1.0).abs();
        assert!(off(a.scintillation, b.scintillation) < 2e-3, "{a:?} {b:?}");
        assert!(
            off(a.z, b.z) < 1e-3 && off(a.mean, b.mean) < 1e-6,
            "{a:?} {b:?}"
        );
        assert_eq!(a.verdict, b.verdict);
        assert!(off(b.scintillation as f32, sway * sway / 2.0) < 0.01);
    }
}

#[test]
fn entry_and_exit_are_not_stationary() {
    let level = |i: usize, from: usize, to: usize| if (from..to).contains(&i) { 1.0 } else { 1e-4 };
    let run = |from, to| {
        let mut draw = Draw(5);
        judged::<f64>(
            (0..990).map(move |i| level(i, from, to) * draw.exponential()),
            0.02,
        )
    };
    for (from, to) in [(500, 990), (0, 500), (800, 990), (0, 200), (400, 600)] {
        let r = run(from, to);
        assert_eq!(r.verdict, Amplitude::NotStationary, "{from} {to} {r:?}");
    }
    let r = run(500, 990);
    assert!(r.drift_z > 10.0 && r.z > 3.0, "{r:?}");
    assert_eq!(run(0, 990).verdict, Amplitude::Forced);
    // And it is forgotten: a second memory on, the cut is what it is.
    let mut draw = Draw(6);
    let r = judged::<f64>(
        (0..2000).map(|i| level(i, 500, 9999) * draw.exponential()),
        0.02,
    );
    assert_eq!(r.verdict, Amplitude::Forced, "{r:?}");
}

#[test]
fn little_data_says_so() {
    let r = judged::<f64>(core::iter::empty(), 0.02);
    assert_eq!((r.verdict, r.scintillation), (Amplitude::TooShort, 1.0));
    let mut draw = Draw(3);
    assert_eq!(
        judged::<f64>((0..124).map(|_| draw.exponential()), APART).verdict,
        Amplitude::TooShort
    );
    assert_eq!(
        judged::<f64>((0..999).map(|_| draw.exponential()), 0.002).verdict,
        Amplitude::TooShort
    );
    assert_eq!(
        judged::<f64>((0..999).map(|_| 0.0), 0.02).verdict,
        Amplitude::TooShort
    );
    // No damping read at all: nothing, however steady. None there: a limit cycle.
    let steady = |zeta| judged::<f64>((0..999).map(|_| 1.0), zeta).verdict;
    assert_eq!(steady(f64::NAN), Amplitude::TooShort);
    assert_eq!(steady(-0.001), Amplitude::SelfExcited);
    let mut fpk = Fpk::<f32>::new(0.002);
    for i in 0..3000 {
        fpk.push(1.0 + (i % 7) as f32, 980.0, 0.02);
    }
    fpk.reset();
    assert_eq!(fpk.reading().verdict, Amplitude::TooShort);
    assert_eq!(fpk.histogram().total(), 0);
}

#[test]
fn critical_values() {
    for (n, want) in [(32.0, 0.44), (64.0, 0.56), (128.0, 0.66), (256.0, 0.75)] {
        assert!(
            (critical_scintillation::<f64>(n) - want).abs() < 0.005,
            "{n}"
        );
    }
    assert_eq!(critical_scintillation(0.0f32), 0.0);
    assert_eq!(critical_scintillation(f32::NAN), 0.0);
}

#[test]
fn histogram_of_one_memory() {
    let mut draw = Draw(9);
    let mut fpk = Fpk::<f32>::new(0.002);
    let mut push = |fpk: &mut Fpk<f32>, n: usize| {
        for _ in 0..n {
            fpk.push(draw.exponential() as f32, 980.0, 0.02);
        }
    };
    push(&mut fpk, 100);
    assert_eq!(fpk.histogram().total(), 0, "no mean yet");
    push(&mut fpk, 125);
    assert!((20..30).contains(&fpk.histogram().total()));
    push(&mut fpk, 3000);
    let histogram = fpk.histogram();
    assert_eq!(histogram.total(), 250);
    assert!(
        (0.8..1.25).contains(&(4.0 * histogram.bin_width)),
        "{histogram:?}"
    );
    // 1 − e^(−1/4) of the values lie in the first bin, e^(−4) beyond the last.
    assert!((35..80).contains(&histogram.counts[0]), "{histogram:?}");
    assert!(histogram.beyond < 15 && histogram.decreasing().weight < 0.25);
}

proptest! {
    #[test]
    fn nothing_but_numbers_comes_out(
        values in prop::collection::vec(prop::num::f32::ANY, 600..900),
        f in prop::num::f32::ANY, zeta in prop::num::f32::ANY
    ) {
        let mut fpk = Fpk::<f32>::with_memory(0.002, 0.2);
        for v in values {
            fpk.push(v.abs(), f, zeta);
            fpk.push(v.abs(), 980.0, 0.02);
        }
        let r = fpk.reading();
        let numbers: Vec<f32> = std::vec![r.scintillation, r.scintillation_sd, r.effective, r.mean, r.z, r.drift_z];
        prop_assert!(numbers.iter().all(|x| x.is_finite()), "{:?}", r);
        prop_assert!(fpk.histogram().decreasing().weight.is_finite());
    }
}
