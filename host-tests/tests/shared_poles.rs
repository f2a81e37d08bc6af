//! `RecursiveChannels` beside what can be known at best: channels that share their poles, one to
//! four of them, one to three modes, in noise.
//!
//! ```sh
//! cargo test --release -p host-tests --test shared_poles -- --nocapture
//! cargo test --release -p host-tests --test shared_poles -- --ignored --nocapture
//! ```
//!
//! The second makes the table of docs/channels.md.

#[path = "../../rarma-fit/tests/structure/mod.rs"]
mod structure;

use rarma_core::estimate::RarmaConfig;
use rarma_fit::{Bound, RecursiveChannels, SharedMode, Weights};
use structure::bound::Least;
use structure::{FS, Force, Structure};

const SAMPLES: usize = 5000;
const MODES: [(f64, f64); 3] = [(400.0, 0.02), (900.0, 0.02), (1600.0, 0.015)];
const SHAPES: [[f64; 4]; 3] = [
    [1.0, 0.8, 0.5, -0.3],
    [0.6, -0.7, 1.0, 0.5],
    [-0.5, 0.9, 0.4, 1.0],
];

fn structure(modes: usize, channels: usize, force: Force, snr_db: f64) -> Structure {
    Structure {
        modes: MODES[..modes].to_vec(),
        shapes: SHAPES[..modes]
            .iter()
            .map(|shape| shape[..channels].to_vec())
            .collect(),
        force,
        noise: 0.0,
    }
    .with_snr(snr_db)
}

type Record = Vec<Vec<f64>>;

/// Modes by frequency of these channels of a record, if there are as many as there should be.
fn read(
    y: &Record,
    channels: &[usize],
    modes: usize,
    weights: Weights,
    config: RarmaConfig<f64>,
) -> Option<Vec<SharedMode>> {
    let order = 2 * modes;
    let mut model = RecursiveChannels::new(order, order, channels.len(), weights, config)
        .expect("settings in range");
    for y in y {
        let row: Vec<f64> = channels.iter().map(|k| y[*k]).collect();
        model.update(&row);
    }
    let found = model.modes(FS);
    (found.len() == modes).then_some(found)
}

/// Errors over the bound of many records.
#[derive(Default, Clone, Copy)]
struct Tally {
    records: f64,
    lost: f64,
    /// Of f and of ζ: sums over records and modes.
    square: [f64; 2],
    held: [f64; 2],
    count: f64,
}

impl Tally {
    fn add(&mut self, found: Option<&[SharedMode]>, truth: &[(f64, f64)], least: &Least) {
        self.records += 1.0;
        let Some(found) = found else {
            self.lost += 1.0;
            return;
        };
        for ((mode, truth), least) in found.iter().zip(truth).zip(least) {
            let off = [mode.frequency - truth.0, mode.damping - truth.1];
            let sd = [mode.frequency_sd, mode.damping_sd];
            for (k, least) in [least.0, least.1].into_iter().enumerate() {
                self.square[k] += (off[k] / least).powi(2);
                self.held[k] += f64::from(u8::from(off[k].abs() <= 1.96 * sd[k]));
            }
            self.count += 1.0;
        }
    }

    /// Root mean square over the bound, of f and of ζ.
    fn rms(&self) -> [f64; 2] {
        self.square.map(|s| (s / self.count).sqrt())
    }

    /// Part of the ±1.96 deviations that hold the truth.
    fn held(&self) -> [f64; 2] {
        self.held.map(|h| h / self.count)
    }
}

/// Reads many records, and the mean of what their channels say alone.
fn judge(
    records: u64,
    make: &(dyn Fn(u64) -> Record + Sync),
    truth: &[(f64, f64)],
    least: &Least,
    weights: Weights,
    config: RarmaConfig<f64>,
) -> (Tally, Tally) {
    let (mut together, mut mean) = (Tally::default(), Tally::default());
    for seed in 0..records {
        let y = make(seed);
        let all: Vec<usize> = (0..y[0].len()).collect();
        let found = read(&y, &all, truth.len(), weights, config);
        together.add(found.as_deref(), truth, least);
        if all.len() > 1 {
            let alone: Option<Vec<_>> = all
                .iter()
                .map(|k| read(&y, &[*k], truth.len(), weights, config))
                .collect();
            let found = alone.map(|alone| average(&alone));
            mean.add(found.as_deref(), truth, least);
        }
    }
    (together, mean)
}

fn average(alone: &[Vec<SharedMode>]) -> Vec<SharedMode> {
    let k = alone.len() as f64;
    let mut out = alone[0].clone();
    for (m, mode) in out.iter_mut().enumerate() {
        mode.frequency = alone.iter().map(|a| a[m].frequency).sum::<f64>() / k;
        mode.damping = alone.iter().map(|a| a[m].damping).sum::<f64>() / k;
    }
    out
}

/// A row of the table: data of the model itself with `Joint`, of structures with `Own`.
struct Row {
    modes: usize,
    channels: usize,
    snr_db: f64,
}

impl Row {
    /// Judged in three columns, each with the bound of ζ in % of it.
    fn judge(&self, records: u64) -> [(f64, Tally, Tally); 3] {
        let of = |force| structure(self.modes, self.channels, force, self.snr_db);
        let config = RarmaConfig::default();
        let percent = |least: &Least| {
            let all = least.iter().zip(MODES).map(|(l, (_, zeta))| l.1 / zeta);
            100.0 * all.sum::<f64>() / self.modes as f64
        };
        let shared = of(Force::Each).shared();
        let least = shared.least(SAMPLES);
        let truth = &MODES[..self.modes];
        let make = |seed| shared.record(SAMPLES, seed);
        let (together, mean) = judge(records, &make, truth, &least, Weights::Joint, config);
        let first = (percent(&least), together, mean);
        let [second, third] = [Force::Each, Force::One].map(|force| {
            let structure = of(force);
            let least = structure.least(SAMPLES);
            let make = |seed| structure.record(SAMPLES, seed);
            let (together, mean) = judge(records, &make, truth, &least, Weights::Own, config);
            (percent(&least), together, mean)
        });
        [first, second, third]
    }
}

/// Rows on two threads, results in their order.
fn all(rows: &[Row], records: u64) -> Vec<[(f64, Tally, Tally); 3]> {
    let half = rows.len().div_ceil(2);
    std::thread::scope(|scope| {
        let (one, two) = rows.split_at(half);
        let other = scope.spawn(|| two.iter().map(|r| r.judge(records)).collect::<Vec<_>>());
        let mut out: Vec<_> = one.iter().map(|r| r.judge(records)).collect();
        out.extend(other.join().expect("judged"));
        out
    })
}

fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for channels in [1, 2, 4] {
        for snr_db in [20.0, 10.0] {
            for modes in 1..=3 {
                rows.push(Row {
                    modes,
                    channels,
                    snr_db,
                });
            }
        }
    }
    // Long ones of both threads at first.
    rows.sort_by_key(|row| row.modes % 2);
    rows
}

fn cell(bound: f64, tally: &Tally, mean: &Tally) -> String {
    let (rms, held) = (tally.rms(), tally.held());
    let gain = if mean.count > 0.0 {
        format!("; alone {:.2}", mean.rms()[1])
    } else {
        String::new()
    };
    let lost = tally.lost + mean.lost;
    let lost = if lost > 0.0 {
        format!("; lost {:.0} of one, {:.0} alone", tally.lost, mean.lost)
    } else {
        String::new()
    };
    format!(
        "{bound:.1}: {:.2} ({:.2}); {:.2} ({:.2}){gain}{lost}",
        rms[1], rms[0], held[1], held[0]
    )
}

fn judge_rows(rows: &[Row], records: u64, margin: f64) {
    let results = all(rows, records);
    for (row, columns) in rows.iter().zip(&results) {
        let cells: Vec<String> = columns.iter().map(|(b, t, m)| cell(*b, t, m)).collect();
        println!(
            "| {} | {} | {} dB | {} |",
            row.modes,
            row.channels,
            row.snr_db,
            cells.join(" | ")
        );
    }
    for (row, columns) in rows.iter().zip(&results) {
        let name = format!(
            "{} modes, {} channels, {} dB",
            row.modes, row.channels, row.snr_db
        );
        for (column, (_, tally, _)) in columns.iter().enumerate() {
            assert_eq!(tally.lost, 0.0, "{name}, column {column}");
            let (rms, held) = (tally.rms(), tally.held());
            for k in 0..2 {
                // Nothing is far below a bound. With one force for all modes several sensors
                // know more of damping than any model with white innovations of each takes in.
                let most = if column == 2 && row.channels > 1 && k == 1 {
                    6.0
                } else {
                    1.25 + margin
                };
                let range = 0.9 - margin..=most;
                assert!(
                    range.contains(&rms[k]),
                    "{name}, column {column}: rms {rms:?}"
                );
                let range = 0.92 - margin..=0.985 + margin / 2.0;
                assert!(
                    range.contains(&held[k]),
                    "{name}, column {column}: held {held:?}"
                );
            }
        }
    }
}

/// Two rows of the table: the errors are those of the bound and the stated deviations hold.
#[test]
fn errors_are_those_of_the_bound() {
    let rows: Vec<Row> = [(2, 2), (1, 4)]
        .map(|(modes, channels)| Row {
            modes,
            channels,
            snr_db: 10.0,
        })
        .into();
    judge_rows(&rows, 60, 0.15);
}

/// All of the table, with bounds three times as narrow.
#[test]
#[ignore = "minutes"]
fn errors_are_those_of_the_bound_long() {
    println!(
        "| modes | channels | SNR | joint, innovations white together | own, a force for each mode | own, one force |"
    );
    println!("|---|---|---|---|---|---|");
    judge_rows(&rows(), 200, 0.05);
}

#[test]
fn the_oracle_agrees_with_closed_forms() {
    // One channel: Lyapunov's equation of rarma_fit::Bound. Two independent ones alike: √2.
    let mut shared = structure(2, 1, Force::One, 20.0).shared();
    let mut a = vec![1.0];
    for (f, zeta) in &shared.modes {
        let z = structure::pole(*f, *zeta);
        a = structure::product(&a, &[1.0, -2.0 * z.re, z.norm_sqr()]);
    }
    let bound = Bound::<f64, 8>::of(&a[1..], &shared.c[0]).expect("a bound");
    let one = shared.least(SAMPLES);
    for (least, (f, zeta)) in one.iter().zip(shared.modes.clone()) {
        let other = bound.mode(f, zeta, FS, SAMPLES).expect("a mode");
        assert!(
            (least.0 / other.frequency - 1.0).abs() < 1e-3,
            "{least:?} {other:?}"
        );
        assert!(
            (least.1 / other.damping - 1.0).abs() < 1e-3,
            "{least:?} {other:?}"
        );
    }
    shared.c.push(shared.c[0].clone());
    shared.lambda = nalgebra::DMatrix::from_diagonal_element(2, 2, shared.lambda[(0, 0)]);
    for (two, one) in shared.least(SAMPLES).iter().zip(one) {
        assert!((two.1 * 2f64.sqrt() / one.1 - 1.0).abs() < 1e-3);
    }
}

/// With a memory: the bound is that of (1 + λ)/(1 − λ) samples.
#[test]
fn a_memory_costs_what_it_should() {
    let structure = structure(1, 2, Force::Each, 20.0);
    let lambda: f64 = 0.9995;
    let config = RarmaConfig {
        forgetting: lambda,
        ..RarmaConfig::default()
    };
    let least = structure.least(((1.0 + lambda) / (1.0 - lambda)) as usize);
    let make = |seed| structure.record(12_000, seed);
    let (tally, _) = judge(60, &make, &structure.modes, &least, Weights::Own, config);
    let (rms, held) = (tally.rms(), tally.held());
    println!("memory of 2000: {}", cell(0.0, &tally, &Tally::default()));
    for k in 0..2 {
        assert!((0.75..=1.4).contains(&rms[k]), "{rms:?}");
        assert!((0.8..=1.0).contains(&held[k]), "{held:?}");
    }
}

/// Why `Own` is the default: noisy sensors of one structure are no model with white joint
/// innovations, and weights that take them for one are biased and too sure of themselves.
#[test]
fn joint_weights_are_too_sure_of_a_structure() {
    let structure = structure(2, 4, Force::One, 20.0);
    let least = structure.least(SAMPLES);
    let make = |seed| structure.record(SAMPLES, seed);
    let of = |weights| {
        let config = RarmaConfig::default();
        let mut tally = Tally::default();
        for seed in 0..40 {
            let found = read(&make(seed), &[0, 1, 2, 3], 2, weights, config);
            tally.add(found.as_deref(), &structure.modes, &least);
        }
        tally
    };
    let (own, joint) = (of(Weights::Own), of(Weights::Joint));
    println!(
        "own {}, joint {}",
        cell(0.0, &own, &Tally::default()),
        cell(0.0, &joint, &Tally::default())
    );
    assert!(joint.held()[1] < 0.6 && joint.rms()[1] > 1.5 * own.rms()[1]);
    assert!((0.85..=1.0).contains(&own.held()[1]));
}

/// Each sensor sits in the node of one mode: together they read both, alone neither does.
#[test]
fn what_is_in_the_node_of_one_is_read_by_the_other() {
    let mut structure = structure(2, 2, Force::Each, 20.0);
    structure.shapes = vec![vec![1.0, 0.0], vec![0.0, 1.0]];
    let least = structure.least(SAMPLES);
    let config = RarmaConfig::default();
    let (mut both, mut alone) = (Tally::default(), [0.0; 2]);
    let records = 40;
    for seed in 0..records {
        let y = structure.record(SAMPLES, seed);
        let found = read(&y, &[0, 1], 2, Weights::Own, config);
        both.add(found.as_deref(), &structure.modes, &least);
        // What each shows of the other's mode is next to nothing.
        for (m, mode) in found.expect("two modes").iter().enumerate() {
            let part = mode.parts[1 - m];
            assert!(part.re.hypot(part.im) < 0.1, "{mode:?}");
            assert!((0.7..=1.3).contains(&mode.parts[m].amplitude), "{mode:?}");
        }
        for (k, alone) in alone.iter_mut().enumerate() {
            let unseen = structure.modes[1 - k];
            let mut model =
                RecursiveChannels::new(4, 4, 1, Weights::Own, config).expect("settings");
            y.iter().for_each(|y| {
                model.update(&y[k..=k]);
            });
            let near = |mode: &SharedMode| {
                (mode.frequency / unseen.0 - 1.0).abs() < 0.02
                    && (mode.damping / unseen.1 - 1.0).abs() < 0.5
            };
            *alone += f64::from(u8::from(model.modes(FS).iter().any(near)));
        }
    }
    println!(
        "both: {}; alone {alone:?} of {records}",
        cell(0.0, &both, &Tally::default())
    );
    assert!(both.lost == 0.0);
    assert!((0.8..=1.3).contains(&both.rms()[0]) && (0.8..=1.3).contains(&both.rms()[1]));
    assert!(both.held()[1] > 0.88);
    assert!(
        alone.iter().all(|n| *n <= 0.1 * records as f64),
        "{alone:?}"
    );
}

/// A sensor that hears little does not spoil it, as it does the mean of what each says alone.
#[test]
fn a_poor_sensor_weighs_little() {
    let mut structure = structure(1, 3, Force::Each, 20.0);
    structure.shapes = vec![vec![1.0, 0.15, -0.1]];
    structure.noise = 0.05;
    let least = structure.least(SAMPLES);
    let make = |seed| structure.record(SAMPLES, seed);
    let config = RarmaConfig::default();
    let (tally, mean) = judge(40, &make, &structure.modes, &least, Weights::Own, config);
    println!("together, mean: {}", cell(0.0, &tally, &mean));
    assert!((0.75..=1.35).contains(&tally.rms()[1]), "{:?}", tally.rms());
    assert!(mean.rms()[1] > 1.2 * tally.rms()[1], "{:?}", mean.rms());
}
