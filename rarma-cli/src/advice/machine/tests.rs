use super::curve::{CELLS, Curve, Point, Span};
use super::likelihood::{Conditions, of_chatter, of_known};
use super::vibration::Vibration;
use super::*;
use rand::SeedableRng;
use rarma_core::advice::{Advice, AdviceConfig, HeardChatter, KnownCut};
use rarma_plants::delay::DepthSearch;
use rarma_plants::forced::milling_forced_m;
use rarma_plants::milling::{Engagement, MillingConfig};
use rarma_plants::process::Schedule;
use rarma_plants::truth::limit_of;

const HZ: f64 = 150.0;

/// One mode along x, 1000 Hz, 2 %, milled by two teeth, so many times as deep as its limit.
fn mill(depth: f64) -> Machine {
    let process = Process::Milling(Box::new(MillingConfig {
        teeth: 2,
        spindle_hz: HZ,
        kt_n_per_m2: 8e8,
        kn_n_per_m2: 2.4e8,
        feed_per_tooth_m: 1e-4,
        engagement: Engagement::up(0.5),
        modes_x: vec![Mode {
            f_hz: 1000.0,
            zeta: 0.02,
            stiffness_n_per_m: 1e7,
        }],
        depth: Schedule::constant(1e-3),
        ..MillingConfig::default()
    }));
    let search = DepthSearch {
        low_m: 0.05e-3,
        high_m: 50e-3,
        ratio: 1.2,
        tolerance: 1e-3,
    };
    let limit = limit_of(&process, f64::INFINITY, &search).expect("a limit");
    Machine::of(process.at_depth(Schedule::constant(depth * limit.depth_m)))
}

fn heard(f_hz: f64) -> HeardChatter<f64> {
    HeardChatter {
        f_hz,
        f_sd_hz: 0.002 * f_hz,
        spindle_hz: HZ,
        spindle_sd_hz: 0.1,
        teeth: 2,
    }
}

/// Where it chatters at this speed.
fn chatter_hz(machine: &Machine, spindle_hz: f64) -> Option<f64> {
    let roots = machine.roots(spindle_hz, 1.0, 1).unwrap();
    (roots[0].growth_per_s >= 0.0).then_some(roots[0].f_hz)
}

const DEEP: f64 = 1.4;

#[test]
fn a_machine_like_it_is_off_by_the_spread() {
    let told = mill(DEEP);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let spread = Spread::USUAL;
    let mut squares = [0.0; 5];
    let count = 2000;
    for _ in 0..count {
        let Process::Milling(c) = told.like(&spread, &mut rng).process else {
            panic!("milled")
        };
        let m = c.modes_other[0];
        let offs = [
            (m.mode.f_hz / 1000.0).ln() / spread.frequency,
            (m.mode.zeta / 0.02).ln() / spread.damping,
            (m.mode.stiffness_n_per_m / 1e7).ln() / spread.stiffness,
            (c.kt_n_per_m2 / 8e8).ln() / spread.cutting,
            (c.kn_n_per_m2 / c.kt_n_per_m2 / 0.3).ln() / spread.radial,
        ];
        assert!((m.x.hypot(m.y) - 1.0).abs() < 1e-12 && c.modes_x.is_empty());
        for (sum, off) in squares.iter_mut().zip(offs) {
            *sum += off * off / f64::from(count);
        }
    }
    assert!(
        squares.iter().all(|s| (s - 1.0).abs() < 0.15),
        "{squares:?}"
    );
    // Half as wrong, and the same again from the same seed.
    let one = |factor, seed| told.like(&spread.times(factor), &mut ChaCha8Rng::seed_from_u64(seed));
    assert_eq!(one(0.5, 7), one(0.5, 7));
    assert!(one(0.5, 7) != one(0.5, 8) && one(0.5, 7) != one(1.0, 7));
}

#[test]
fn a_curve_is_the_delay_equation_between_what_was_looked_at() {
    let machine = mill(DEEP);
    let mut curve = Curve::new(Span::new(75.0, 225.0));
    curve.look_at(&machine, 2.0, |_, _| true);
    let mut stable = 0;
    for i in 0..=300 {
        let hz = 75.0 + 0.5 * f64::from(i);
        let truth = machine.roots(hz, 1.0, 1).unwrap()[0];
        let point = curve.at(hz);
        stable += usize::from(truth.growth_per_s < 0.0);
        // Growth is a few tens a second; flanks are told to a part of that.
        let alike = (point.growth_per_s < 0.0) == (truth.growth_per_s < 0.0);
        assert!(
            alike || truth.growth_per_s.abs() < 4.0,
            "{hz}: {point:?} {truth:?}"
        );
    }
    assert!((20..280).contains(&stable), "{stable}");
    assert!(curve.looks() < 129, "{}", curve.looks());
    // What nobody looked at is not stable.
    let mut part = Curve::new(Span::new(75.0, 225.0));
    part.look_at(&machine, 2.0, |from, to| curve.span.holds(100.0, from, to));
    assert!(part.at(200.0).growth_per_s > 0.0 && part.looks() < 12);
    assert_eq!(part.at(100.0).growth_per_s, curve.at(100.0).growth_per_s);
}

#[test]
fn a_frequency_that_the_machine_has_weighs_more() {
    let at = |growth_per_s, f_hz| Point { growth_per_s, f_hz };
    let roots = [at(20.0, 1000.0), at(-5.0, 1500.0)];
    let cut = Conditions {
        spindle_hz: 150.0,
        teeth: 2,
        modes_hz: &[940.0, 1490.0],
    };
    let of = |f: f64| of_chatter(&roots, (f, 0.003 * f), &cut);
    assert!(of(1002.0).weight > 20.0 * of(1025.0).weight);
    // What stands has lost some of its load: it lies between the mode and the root.
    assert!(
        of(970.0).weight > 20.0 * of(1030.0).weight && of(970.0).weight > 20.0 * of(915.0).weight
    );
    assert!(of(1000.0).weight > 5.0 * of(970.0).weight);
    // A bell and a flat: all of it is a chance.
    let all: f64 = (0..8000)
        .map(|k| 300.0 * (f64::from(k) / 2000.0).exp())
        .map(|f| of(f).explained / 2000.0)
        .sum();
    assert!((all - 0.95).abs() < 0.01, "{all}");
    // A root that does not swing, and one whose sideband is no vibration.
    for f_hz in [0.0, 300.0] {
        let one = of_chatter(&[at(20.0, f_hz)], (700.0, 2.0), &cut);
        assert!(
            one.weight > 0.0 && one.weight.is_finite(),
            "{f_hz}: {one:?}"
        );
    }
    // Of what decays nothing is heard; a sideband is, now and then.
    assert!(of(1300.0).weight > 3.0 * of(1500.0).weight);
    assert!(of(1500.0).explained < 0.1 * of(1500.0).weight);
    let quiet = of_chatter(&roots[1..], (1500.0, 3.0), &cut);
    assert!(quiet.explained == 0.0 && quiet.weight < of(1500.0).weight);
    // What came of other cuts.
    let stable = of_known(&roots, &KnownCut::stable(150.0), &cut);
    let chatter = of_known(&roots, &KnownCut::chattered(150.0, None), &cut);
    assert!(stable.weight < chatter.weight);
    assert_eq!(
        of_known(&roots[1..], &KnownCut::stable(150.0), &cut),
        chatter
    );
}

#[test]
fn advice_is_a_speed_at_which_the_machine_is_stable() {
    let machine = mill(DEEP);
    let f_hz = chatter_hz(&machine, HZ).expect("it chatters");
    let belief = Belief::new(machine.clone(), Spread::USUAL, 1);
    let config = AdviceConfig::reach(75.0, 225.0);
    let advise = |heard: &HeardChatter<f64>, known: &[KnownCut<f64>]| {
        belief.advise(&config, heard, known, || ()).unwrap()
    };
    let advice = advise(&heard(f_hz), &[]).expect("explained");
    assert!(advice.explains);
    let first = *advice.advice.first().expect("a speed");
    assert_eq!(chatter_hz(&machine, first.spindle_hz), None, "{first:?}");
    assert!(first.chance > 0.6, "{first:?}");
    // The same again; and a speed that was tried is not proposed.
    assert_eq!(advise(&heard(f_hz), &[]), Some(advice));
    let tried = [KnownCut::chattered(first.spindle_hz, None)];
    let next = advise(&heard(f_hz), &tried).expect("explained");
    let other =
        |p: &rarma_core::advice::Proposal<f64>| (p.spindle_hz / first.spindle_hz - 1.0).abs();
    assert!(
        next.advice.first().is_none_or(|p| other(p) > 0.01),
        "{next:?}"
    );
    // The chart that is made before says about the same.
    let chart = belief.chart(HZ, (75.0, 225.0), || ());
    let at_once = chart.advise(&config, &heard(f_hz), &[]).unwrap();
    let at_once = at_once.expect("explained").advice;
    let is_stable = |advice: &Advice<f64>| {
        let first = *advice.first().expect("a speed");
        assert_eq!(chatter_hz(&machine, first.spindle_hz), None, "{first:?}");
    };
    is_stable(&at_once);
    // A chatter that it does not have, in a cut in which it chatters; and one in which it does not.
    let odd = advise(&heard(1.17 * f_hz), &[]).expect("it chatters");
    let odd_at_once = chart.advise(&config, &heard(1.17 * f_hz), &[]).unwrap();
    for odd in [odd, odd_at_once.expect("it chatters")] {
        assert!(!odd.explains);
        is_stable(&odd.advice);
    }
    let shallow = Belief::new(mill(0.1), Spread::USUAL, 1);
    assert_eq!(shallow.advise(&config, &heard(f_hz), &[], || ()), Ok(None));
    // Something chatters where it was to be stable: what agreed at the first speed still counts, and alone it would not.
    let there = HeardChatter {
        spindle_hz: first.spindle_hz,
        ..heard(1.17 * f_hz)
    };
    let before = [KnownCut::chattered(HZ, Some((f_hz, 0.002 * f_hz)))];
    assert_eq!(belief.advise(&config, &there, &[], || ()), Ok(None));
    let next = advise(&there, &before).expect("agreed before");
    assert!(
        next.explains && next.advice.first().is_none_or(|p| other(p) > 0.01),
        "{next:?}"
    );
    let stable = [KnownCut::stable(HZ)];
    assert_eq!(belief.advise(&config, &there, &stable, || ()), Ok(None));
}

#[test]
fn the_vibration_is_that_of_the_told_machine_at_its_depth() {
    let machine = mill(0.3);
    let Process::Milling(config) = &machine.process else {
        panic!("milled")
    };
    let span = Span::new(75.0, 225.0);
    let vibration = Vibration::new(&machine, span, |cell| cell % 8 == 0);
    for spindle_hz in (0..=CELLS).step_by(8).map(|cell| span.speed_hz(cell)) {
        let there = MillingConfig {
            spindle_hz,
            ..(**config).clone()
        };
        let ratio = vibration.at(spindle_hz) / milling_forced_m(&there, machine.depth_m).unwrap();
        assert!((ratio - 1.0).abs() < 1e-3, "{spindle_hz}: {ratio}");
    }
    // Nobody asked: as much as anywhere. Nothing is forced: alike everywhere.
    let most = vibration.at(span.speed_hz(4));
    assert!((0..=CELLS).all(|cell| vibration.at(span.speed_hz(cell)) <= most));
    let turned = Machine::load("turning-980", None).expect("shipped");
    let even = Vibration::new(&turned, span, |_| true);
    assert_eq!(even.at(100.0), even.at(200.0));
}

#[test]
fn a_file_of_another_cut_is_refused() {
    let why = |name: &str, teeth| Machine::load(name, teeth).unwrap_err().to_string();
    assert!(Machine::load("three-mode-chatter", Some(3)).is_ok());
    assert!(why("three-mode-chatter", Some(2)).contains("with 3 teeth, and --teeth is 2"));
    assert!(why("turning-980", Some(4)).contains("turned with 1 edge"));
    assert!(why("no-such-file.toml", None).contains("no-such-file.toml"));
}
