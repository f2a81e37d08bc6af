//! Promise: where no speed is stable a swing of the speed is proposed, and how often it makes the
//! cut stable, and leaves the monitor quiet, is known, and the documentation says the same.
//!
//! Always: a few cuts. The table of docs/bench.md:
//! `cargo test --release -p host-tests --test speed_variation -- --ignored --nocapture`.

use firmware::monitor::MonitorDuty;
use host_tests::advice::{Case, F_NOISE, HEARD_HZ};
use host_tests::page;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rarma_box::wire::{MonitorJob, Telemetry};
use rarma_core::advice::{HeardChatter, VariationConfig, vary};
use rarma_core::monitor::MonitorConfig;
use rarma_plants::cut::Process;
use rarma_plants::population::Cut;
use rarma_plants::truth::roots;
use rarma_plants::variation::SpeedVariation;
use rayon::prelude::*;
use std::fmt::Write as _;

/// Seeds that no number of the swing was set on.
const SEEDS: u64 = 130_000;
/// Cuts of the long form.
const LONG: usize = 30;
/// Seeds that are drawn at once, at most.
const BATCH: usize = 16;
/// Length of a cut that is listened to, s, and from when on an alarm counts: a chatter that the
/// entry starts has died by then.
const LENGTH_S: f64 = 5.0;
const FROM_S: f64 = 1.5;
/// Between two tellings of the speed, s, by an encoder and by a control.
const ENCODER_S: f64 = 0.01;
const CONTROL_S: f64 = 0.1;
/// What is turned: nothing, a swing that anybody may try, what is proposed.
const TURNED: [&str; 4] = [
    "constant speed",
    "RVA 0.1, once a second",
    "proposed, without a structure",
    "proposed, with a structure",
];
/// How the speed is told.
const TOLD: [&str; 3] = ["by an encoder", "by a control", "its mean"];

/// One swing, or none, of one cut.
struct Swung {
    /// Said of it: whether it helps.
    helps: bool,
    /// By the delay equation.
    stable: bool,
    /// Alarms that begin or stand after [`FROM_S`], for each way of telling the speed; none
    /// where nobody could hear.
    alarmed: Option<[bool; TOLD.len()]>,
}

struct Judged {
    milled: bool,
    swung: Vec<Swung>,
}

fn growth(process: &Process, depth_m: f64) -> f64 {
    let roots = roots(process, 0.0, depth_m, 1);
    // What cannot be told is not stable.
    roots
        .ok()
        .and_then(|r| Some(r.first()?.growth_per_s))
        .unwrap_or(f64::INFINITY)
}

/// Whether the monitor has an alarm after a while.
fn alarmed(cut: &Cut, samples: &[f32], fs_hz: f64, told: usize) -> bool {
    let monitor = MonitorConfig {
        full_scale: Some(1.0),
        spindle_hz: Some(cut.spindle_hz()),
        teeth: Some(cut.teeth() as u32),
        aliased: cut.sensor.folds > 1,
        ..MonitorConfig::new(fs_hz)
    };
    let job = MonitorJob {
        monitor,
        channel: 0,
        every_s: 0.05,
    };
    let mut duty = MonitorDuty::new(&job).expect("a job");
    let (mut stands, mut any) = (false, false);
    let mut take = |message: &Telemetry| {
        if let Telemetry::Alarm(alarm) = message {
            stands = alarm.on;
            any |= alarm.on && alarm.sample as f64 / fs_hz > FROM_S;
        }
    };
    let every = [ENCODER_S, CONTROL_S, f64::INFINITY][told];
    let late = [0.0, cut.delay_s, 0.0][told];
    let mut next = every;
    for (n, x) in samples.iter().enumerate() {
        let t = n as f64 / fs_hz;
        duty.samples(&[*x], &mut take);
        if t >= next {
            next += every;
            let hz = cut.speed_at((t - late).max(0.0));
            duty.tell_speed((60.0 * hz).round() as f32 / 60.0)
                .expect("a speed");
        }
    }
    any || stands
}

fn swung(case: &Case, variation: Option<SpeedVariation>, helps: bool) -> Swung {
    let hz = case.cut.spindle_hz();
    let process = case.process.at_spindle_hz(hz).with_variation(variation);
    let stable = growth(&process, case.depth_m) < 0.0;
    let cut = case.cut.steady(variation, LENGTH_S).ok();
    let heard = !case.cut.undecidable() && HEARD_HZ.contains(&case.cut.operational().0);
    let alarmed = cut.filter(|_| heard).map(|cut| {
        let played = cut.hear().expect("a sound");
        [0, 1, 2].map(|told| alarmed(&cut, &played.samples, played.fs_hz, told))
    });
    Swung {
        helps,
        stable,
        alarmed,
    }
}

fn judged(seed: u64) -> Option<Judged> {
    let case = Case::draw_without(seed)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let f_hz = case.cut.operational().0;
    let hz = case.cut.spindle_hz();
    let heard = HeardChatter {
        f_hz: f_hz * (1.0 + F_NOISE * rng.sample::<f64, _>(StandardNormal)),
        f_sd_hz: F_NOISE * f_hz,
        spindle_hz: hz,
        spindle_sd_hz: 0.001 * hz,
        teeth: case.cut.teeth() as u32,
    };
    let simple = SpeedVariation {
        amplitude: 0.1,
        frequency_ratio: 1.0 / hz,
    };
    let mut all = vec![swung(&case, None, false), swung(&case, Some(simple), true)];
    for structure in [None, Some(&case.structure)] {
        let said = vary(&VariationConfig::default(), &heard, structure).expect("sound");
        let variation = SpeedVariation {
            amplitude: said.amplitude,
            frequency_ratio: said.frequency_ratio,
        };
        all.push(swung(&case, Some(variation), said.helps()));
        let last = all.last().expect("one");
        println!(
            "{seed} structure {} teeth {} waves {:.1}: rva {:.3} swing {:.2} Hz phase {:.1} rad chance {:.2} ratio {:.2}; stable {} alarmed {:?}",
            structure.is_some(),
            heard.teeth,
            heard.waves(),
            said.amplitude,
            said.swing_hz,
            said.phase_swing,
            said.chance,
            said.growth_ratio,
            last.stable,
            last.alarmed
        );
    }
    Some(Judged {
        milled: matches!(case.process, Process::Milling(_)),
        swung: all,
    })
}

/// So many cuts without a stable speed.
fn cuts(count: usize) -> Vec<Judged> {
    let mut out = Vec::new();
    let mut begin = SEEDS;
    let batch = count.min(BATCH) as u64;
    while out.len() < count {
        let seeds = (begin..begin + batch).into_par_iter();
        let judged: Vec<Option<Judged>> = seeds.map(judged).collect();
        out.extend(judged.into_iter().flatten());
        begin += batch;
    }
    out.truncate(count);
    out
}

/// `part of whole`.
fn of(part: usize, whole: usize) -> String {
    format!("{part} of {whole}")
}

/// Counts of the cuts, and of those of them, for which it holds.
fn count<'a>(
    all: impl Iterator<Item = &'a Swung>,
    holds: impl Fn(&Swung) -> bool,
) -> (usize, usize) {
    let (mut part, mut whole) = (0, 0);
    for one in all {
        whole += 1;
        part += usize::from(holds(one));
    }
    (part, whole)
}

fn table(all: &[Judged]) -> String {
    let mut out = "| turned | stable: turned | milled | where it is said to help | where not | quiet where stable, speed told by an encoder | by a control | its mean | quiet where not stable, by an encoder |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
    for (i, name) in TURNED.iter().enumerate() {
        let of_kind = |milled: bool| {
            let kind = all.iter().filter(move |one| one.milled == milled);
            count(kind.map(|one| &one.swung[i]), |s| s.stable)
        };
        let said = |helps: bool| {
            let those = all.iter().map(|one| &one.swung[i]);
            count(those.filter(|s| s.helps == helps), |s| s.stable)
        };
        let quiet = |stable: bool, told: usize| {
            let those = all.iter().map(|one| &one.swung[i]);
            let heard = those.filter(|s| s.stable == stable && s.alarmed.is_some());
            count(heard, |s| s.alarmed.is_some_and(|a| !a[told]))
        };
        let word = |(part, whole): (usize, usize)| of(part, whole);
        let (helps, not) = match i {
            0 | 1 => (String::new(), String::new()),
            _ => (word(said(true)), word(said(false))),
        };
        writeln!(
            out,
            "| {name} | {} | {} | {helps} | {not} | {} | {} | {} | {} |",
            word(of_kind(false)),
            word(of_kind(true)),
            word(quiet(true, 0)),
            word(quiet(true, 1)),
            word(quiet(true, 2)),
            word(quiet(false, 0)),
        )
        .expect("a string");
    }
    out
}

#[test]
fn a_swing_makes_cuts_stable_that_no_speed_does() {
    let all = cuts(5);
    print!("{}", table(&all));
    assert!(all.iter().all(|one| !one.swung[0].stable));
    let turned = all.iter().filter(|one| !one.milled);
    let (stable, whole) = count(turned.map(|one| &one.swung[3]), |s| s.stable);
    assert!(whole > 0 && stable + 1 >= whole, "{stable} of {whole}");
    // Of those that are said to help at least as large a part does as of those that are not.
    let those = |helps: bool| {
        let all = all.iter().map(|one| &one.swung[3]);
        count(all.filter(move |s| s.helps == helps), |s| s.stable)
    };
    let ((right, said), (missed, not)) = (those(true), those(false));
    assert!(said > 0 && 2 * right >= said, "{right} of {said}");
    assert!(missed * said <= right * not, "{missed} of {not}");
}

#[test]
#[ignore = "minutes"]
fn a_swing_makes_cuts_stable_that_no_speed_does_long() {
    let all = cuts(LONG);
    let table = table(&all);
    print!("{table}");
    page::holds("docs/bench.md", "speed-variation", &table);
}
