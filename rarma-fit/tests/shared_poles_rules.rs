//! `RecursiveChannels` beside the recursion of one channel, and its rules: bad samples, silence,
//! sensors that say the same, states that are kept.

mod structure;

use rarma_core::estimate::{Arma44, RarmaConfig, StateVisitor};
use rarma_fit::{ChannelError, ChannelStatus, RecursiveChannels, Weights};
use structure::{FS, Force, Structure};

fn two_modes(channels: usize) -> Structure {
    let shapes = [[1.0, 0.8, 0.5], [0.6, -0.7, 1.0]];
    Structure {
        modes: vec![(400.0, 0.02), (900.0, 0.03)],
        shapes: shapes.iter().map(|s| s[..channels].to_vec()).collect(),
        force: Force::Each,
        noise: 0.0,
    }
    .with_snr(20.0)
}

fn model(channels: usize, weights: Weights, forgetting: f64) -> RecursiveChannels {
    let config = RarmaConfig {
        forgetting,
        ..RarmaConfig::default()
    };
    RecursiveChannels::new(4, 4, channels, weights, config).expect("settings in range")
}

/// With one channel it is the core's recursion, with both weights, also through outliers.
#[test]
fn one_channel_is_the_model_of_one_channel() {
    let mut y = two_modes(1).record(8000, 3);
    for t in [3000, 3001, 5500] {
        y[t][0] += 30.0;
    }
    for (forgetting, random_walk) in [(1.0, 0.0), (0.999, 0.0), (0.9995, 1e-9)] {
        let config = RarmaConfig {
            forgetting,
            random_walk,
            ..RarmaConfig::default()
        };
        for weights in [Weights::Own, Weights::Joint] {
            let mut single = Arma44::<f64>::new(config);
            let mut shared = RecursiveChannels::new(4, 4, 1, weights, config).expect("settings");
            let mut largest = 0.0f64;
            for y in &y {
                single.update(y[0]);
                shared.update(y);
                if single.ready() {
                    let pairs = single.a().iter().chain(single.c());
                    for (x, z) in pairs.zip(shared.a().iter().chain(shared.c())) {
                        largest = largest.max((x - z).abs());
                    }
                }
            }
            let sigma2 = shared.innovation_covariance(0, 0);
            println!("{forgetting} {weights:?}: {largest:e}");
            assert!(shared.ready() && largest < 1e-11, "{largest:e}");
            assert!((sigma2 / single.sigma2() - 1.0).abs() < 1e-8);
            let factor = shared.covariance_factor();
            assert!((factor - single.covariance_factor()).abs() < 1e-12);
            let (p, q) = (shared.covariance(), single.covariance());
            for i in 0..8 {
                assert!((p.element(8, i, i) / q.element(8, i, i) - 1.0).abs() < 1e-6);
            }
        }
    }
}

/// The same sensor three times tells what it tells once, with the deviations of once.
#[test]
fn a_sensor_that_is_copied_tells_no_more() {
    for seed in 0..8 {
        let y = two_modes(1).record(6000, seed);
        let mut once = model(1, Weights::Own, 1.0);
        let mut thrice = model(3, Weights::Own, 1.0);
        for y in &y {
            once.update(y);
            thrice.update(&[y[0], -2.0 * y[0], 0.1 * y[0]]);
        }
        let (once, thrice) = (once.modes(FS), thrice.modes(FS));
        assert_eq!((once.len(), thrice.len()), (2, 2));
        for (x, z) in once.iter().zip(&thrice) {
            assert!((x.frequency - z.frequency).abs() < 0.1 * x.frequency_sd);
            assert!((x.damping - z.damping).abs() < 0.1 * x.damping_sd);
            for ratio in [z.frequency_sd / x.frequency_sd, z.damping_sd / x.damping_sd] {
                assert!((0.6..=1.05).contains(&ratio), "{ratio}");
            }
            // And they are where they belong, in proportion.
            let parts: Vec<f64> = z.parts.iter().map(|p| p.re).collect();
            assert!((parts[1] - 1.0).abs() < 1e-6);
            assert!((parts[0] + 0.5).abs() < 1e-3 && (parts[2] + 0.05).abs() < 1e-3);
            assert!((z.parts[0].amplitude / x.parts[0].amplitude - 1.0).abs() < 0.02);
        }
    }
    // Innovations that are the same are no contradiction for joint weights either.
    let mut joint = model(2, Weights::Joint, 0.999);
    for y in two_modes(1).record(6000, 1) {
        let step = joint.update(&[y[0], y[0]]);
        assert!(step.innovations.iter().all(|e| e.is_finite()));
    }
    assert!(joint.ready() && joint.a().iter().all(|a| a.is_finite()));
}

/// Shapes and amplitudes are those of the structure, whatever shakes it, in noise of 10 and 20 dB.
#[test]
fn shapes_are_those_of_the_structure() {
    for force in [Force::Each, Force::One] {
        let mut structure = two_modes(3);
        structure.force = force;
        for (seed, snr_db) in [(0, 20.0), (1, 20.0), (2, 10.0), (3, 10.0)] {
            let structure = structure.clone().with_snr(snr_db);
            let mut model = model(3, Weights::Own, 1.0);
            structure.record(20_000, seed).iter().for_each(|y| {
                model.update(y);
            });
            let modes = model.modes(FS);
            for (mode, shape) in modes.iter().zip(&structure.shapes) {
                let largest = shape
                    .iter()
                    .fold(0.0f64, |m, x| if x.abs() > m.abs() { *x } else { m });
                for (part, x) in mode.parts.iter().zip(shape) {
                    let off = (part.re - x / largest).hypot(part.im);
                    assert!(off < 0.12, "{force:?} {snr_db}: {mode:?}");
                    let off = (part.amplitude - x.abs()).abs();
                    assert!(off < 0.25, "{force:?} {snr_db}: {mode:?}");
                }
            }
            assert_eq!(modes.len(), 2);
        }
    }
}

#[test]
fn bad_samples_change_nothing_and_are_named() {
    let y = two_modes(3).record(4000, 5);
    for from in [100, 3000] {
        let mut clean = model(3, Weights::Own, 0.999);
        let mut other = clean.clone();
        for y in &y[..from] {
            clean.update(y);
            other.update(y);
        }
        for (bad, channel) in [
            (vec![0.1, f64::NAN, 0.2], 1),
            (vec![0.1, 0.2, f64::NEG_INFINITY], 2),
            (vec![1e15, f64::NAN, 0.0], 0),
            (vec![0.1, 0.2], 2),
            (vec![0.1, 0.2, 0.3, 0.4], 3),
            (vec![], 0),
        ] {
            let step = other.update(&bad);
            assert_eq!(step.status, ChannelStatus::Rejected { channel });
            assert!(step.innovations.iter().all(|e| *e == 0.0));
        }
        for y in &y[from..] {
            clean.update(y);
            other.update(y);
        }
        assert_eq!(clean.count(), other.count());
        assert_eq!(clean.modes(FS), other.modes(FS));
        assert!(clean.modes(FS).len() == 2);
    }
}

/// A sensor that dies, and one that is loud for a moment, leave the rest its modes.
#[test]
fn a_sensor_that_dies_leaves_the_modes_to_the_others() {
    let structure = two_modes(3);
    let mut y = structure.record(20_000, 9);
    for (t, y) in y.iter_mut().enumerate() {
        if (4000..8000).contains(&t) {
            y[1] = 0.0;
        }
        if (12_000..12_020).contains(&t) {
            y[2] += 1000.0;
        }
    }
    for weights in [Weights::Own, Weights::Joint] {
        let mut model = model(3, weights, 0.9995);
        for (t, y) in y.iter().enumerate() {
            model.update(y);
            if [7900, 11_900, 19_999].contains(&t) {
                let modes = model.modes(FS);
                assert_eq!(modes.len(), 2, "{weights:?} at {t}");
                for (mode, (f, zeta)) in modes.iter().zip(&structure.modes) {
                    let off = (mode.frequency / f - 1.0).abs();
                    assert!(off < 0.02, "{weights:?} at {t}: {mode:?}");
                    let ratio = mode.damping / zeta;
                    assert!((0.4..=1.9).contains(&ratio), "{weights:?} at {t}: {mode:?}");
                }
            }
        }
    }
}

#[test]
fn silence_ends_no_start_and_empties_no_range() {
    let mut model = model(2, Weights::Own, 0.998);
    for _ in 0..2000 {
        assert_eq!(model.update(&[0.0, 0.0]).status, ChannelStatus::Starting);
    }
    let y = two_modes(2).record(3000, 2);
    // Begun in the middle of a stretch of 400: that one is heard, and starts the model.
    let ready = y.iter().position(|y| {
        model.update(y);
        model.ready()
    });
    assert!((100..=800).contains(&ready.expect("a model")), "{ready:?}");
    y.iter().for_each(|y| {
        model.update(y);
    });
    let anew =
        (0..300_000).position(|_| model.update(&[0.0, 0.0]).status == ChannelStatus::Starting);
    assert!(
        (1000..200_000).contains(&anew.expect("a new start")),
        "{anew:?}"
    );
}

#[derive(Default)]
struct Out(Vec<u64>);

impl StateVisitor<f64> for Out {
    fn number(&mut self, x: &mut f64) {
        self.0.push(x.to_bits());
    }
    fn count(&mut self, n: &mut u32) {
        self.0.push(u64::from(*n));
    }
}

struct In(std::vec::IntoIter<u64>);

impl StateVisitor<f64> for In {
    fn number(&mut self, x: &mut f64) {
        *x = f64::from_bits(self.0.next().expect("as many as were written"));
    }
    fn count(&mut self, n: &mut u32) {
        *n = self.0.next().expect("as many as were written") as u32;
    }
}

#[test]
fn goes_on_from_any_moment_as_if_nothing_had_been() {
    let y = two_modes(3).record(4000, 7);
    for weights in [Weights::Own, Weights::Joint] {
        for cut in [0, 7, 399, 400, 401, 1000, 2049] {
            let mut whole = model(3, weights, 0.999);
            y[..cut].iter().for_each(|y| {
                whole.update(y);
            });
            let mut kept = Out::default();
            assert!(whole.visit_state(&mut kept));
            let mut again = model(3, weights, 0.999);
            let mut back = In(kept.0.into_iter());
            assert!(again.visit_state(&mut back));
            assert_eq!(back.0.next(), None, "all of it is read");
            for y in &y[cut..] {
                let one: Vec<u64> = whole
                    .update(y)
                    .innovations
                    .iter()
                    .map(|e| e.to_bits())
                    .collect();
                let two = again.update(y).innovations;
                assert!(one.iter().zip(two).all(|(x, y)| *x == y.to_bits()), "{cut}");
            }
            assert_eq!(whole.modes(FS), again.modes(FS));
            assert!(whole.modes(FS).len() == 2);
        }
    }
}

#[test]
fn a_short_signal_is_finished_early() {
    let structure = two_modes(2);
    for (samples, modes) in [(30, 0), (39, 0), (40, 2), (350, 2)] {
        let mut found = 0;
        for seed in 0..10 {
            let mut model = model(2, Weights::Own, 1.0);
            structure.record(samples, seed).iter().for_each(|y| {
                model.update(y);
            });
            assert!(!model.ready());
            model.finish_start();
            assert_eq!(model.ready(), modes > 0, "{samples}");
            found = found.max(model.modes(FS).len());
        }
        assert!(
            found <= modes && (samples != 350 || found == 2),
            "{samples}: {found}"
        );
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let refused = |p, q, k, change: &dyn Fn(&mut RarmaConfig<f64>)| {
        let mut config = RarmaConfig::default();
        change(&mut config);
        RecursiveChannels::new(p, q, k, Weights::Own, config).err()
    };
    let named = |setting| Some(ChannelError::OutOfRange { setting });
    assert_eq!(refused(4, 4, 0, &|_| {}), Some(ChannelError::NoChannel));
    assert_eq!(refused(31, 4, 1, &|_| {}), named("p"));
    assert_eq!(refused(4, 31, 1, &|_| {}), named("q"));
    assert_eq!(refused(4, 4, 17, &|_| {}), named("channels"));
    assert_eq!(refused(0, 0, 2, &|_| {}), named("p + q·channels"));
    assert_eq!(refused(20, 14, 8, &|_| {}), named("p + q·channels"));
    assert_eq!(
        refused(4, 4, 2, &|c| c.start_samples = 0),
        named("start_samples")
    );
    assert_eq!(refused(4, 4, 2, &|c| c.forgetting = 0.5), named("settings"));
    let pseudo = |c: &mut RarmaConfig<f64>| c.gradient = rarma_core::estimate::Gradient::Pseudo;
    assert_eq!(refused(4, 4, 2, &pseudo), named("gradient, gain"));
    assert_eq!(refused(16, 14, 8, &|_| {}), None);
    // Without C they are autoregressions.
    assert_eq!(refused(4, 0, 3, &|_| {}), None);
}
