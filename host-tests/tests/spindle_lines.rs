//! Promise: what the spindle forces is found in the sound and taken out of it, at a
//! speed that is told, told wrongly by a few percent, or not told at all, also while
//! the speed changes; chatter beside the lines stays.
//!
//! Print the table with
//! `cargo test --release -p host-tests --test spindle_lines -- --nocapture --test-threads 1`.

use host_tests::signal;
use host_tests::statistics::rms;
use rarma_core::condition::{
    Band, Finding, Lock, SpeedFinder, SpeedFinderConfig, SpindleLines, SpindleLinesConfig,
};
use rarma_core::real::Real;
use std::f64::consts::TAU;

const FS: f64 = 6000.0;
const BAND: Band = Band {
    low_hz: 300.0,
    high_hz: 2500.0,
};
const MODES: [(f64, f64); 3] = [(980.0, 0.02), (450.0, 0.03), (1500.0, 0.025)];

/// A cut: noise of modes (variance 1 each), lines of the teeth, of runout, a chatter.
#[derive(Clone, Copy)]
struct Cut {
    name: &'static str,
    modes: usize,
    spindle_hz: f64,
    teeth: u32,
    told_hz: Option<f64>,
    teeth_told: bool,
    /// Power of the lines over that of the modes, dB.
    lines_db: f64,
    /// Power of runout lines at the other multiples, over that of the teeth, dB.
    runout_db: Option<f64>,
    /// Relative change of the speed per second, from 3 s to 5 s.
    ramp: f64,
    /// Chatter: frequency, Hz, and amplitude over that of a tooth line.
    chatter: Option<(f64, f64)>,
    seconds: f64,
}

const CUT: Cut = Cut {
    name: "",
    modes: 3,
    spindle_hz: 76.4,
    teeth: 5,
    told_hz: Some(76.4),
    teeth_told: true,
    lines_db: 20.0,
    runout_db: None,
    ramp: 0.0,
    chatter: None,
    seconds: 6.0,
};

/// Samples: lines, the rest, chatter; and the speed, Hz.
struct Sound {
    lines: Vec<f64>,
    rest: Vec<f64>,
    chatter: Vec<f64>,
    speed_hz: Vec<f64>,
}

impl Cut {
    fn play(&self, seed: u64) -> Sound {
        let n = (self.seconds * FS) as usize;
        let rest: Vec<f64> = signal::modes(&MODES[..self.modes], FS, 500 + seed)
            .take(n)
            .collect();
        let z = self.teeth;
        let inside = |k: &u32| {
            let f = f64::from(*k) * self.spindle_hz;
            f > BAND.low_hz && f < 2000.0
        };
        let last = (2500.0 / self.spindle_hz) as u32;
        let tooth: Vec<u32> = (1..=last).filter(|k| k % z == 0).filter(inside).collect();
        let other: Vec<u32> = (1..=last).filter(|k| k % z != 0).filter(inside).collect();
        let power = self.modes as f64 * 10f64.powf(self.lines_db / 10.0);
        let a = (2.0 * power / tooth.len() as f64).sqrt();
        let b = self.runout_db.map_or(0.0, |db| {
            (2.0 * power * 10f64.powf(db / 10.0) / other.len() as f64).sqrt()
        });
        let (mut phase, mut speed) = (0.1 * seed as f64, self.spindle_hz);
        let mut sound = Sound {
            lines: vec![],
            rest,
            chatter: vec![],
            speed_hz: vec![],
        };
        for i in 0..n {
            let t = i as f64 / FS;
            if (3.0..5.0).contains(&t) {
                speed += self.ramp * self.spindle_hz / FS;
            }
            phase += TAU * speed / FS;
            let line = |k: &u32| (f64::from(*k) * phase + f64::from(k * k) + seed as f64).sin();
            let lines = a * tooth.iter().map(line).sum::<f64>();
            let lines = lines + b * other.iter().map(line).sum::<f64>();
            let chatter = self
                .chatter
                .map_or(0.0, |(f, part)| part * a * (TAU * f * t + 1.0).sin());
            sound.lines.push(lines);
            sound.chatter.push(chatter);
            sound.speed_hz.push(speed);
        }
        sound
    }
}

/// What came of it.
#[derive(Default, Debug)]
struct Outcome {
    found: u32,
    none: u32,
    contradictions: u32,
    found_error: Vec<f64>,
    found_over_sd: Vec<f64>,
    /// Of the lines' own speed, over its standard deviation, once settled.
    tracked_over_sd: Vec<f64>,
    tracked_error: Vec<f64>,
    lock_s: Vec<f64>,
    lost: u32,
    /// Power of lines left over that of the lines, dB, in the last second; and while
    /// the speed changes.
    left_db: Vec<f64>,
    left_ramp_db: Vec<f64>,
    kept: Vec<f64>,
}

fn db(x: f64) -> f64 {
    10.0 * x.log10()
}

/// Amplitude of `x` at `f`.
fn amplitude(x: &[f64], f: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (i, x) in x.iter().enumerate() {
        let angle = TAU * f * i as f64 / FS;
        re += x * angle.cos();
        im += x * angle.sin();
    }
    2.0 * re.hypot(im) / x.len() as f64
}

fn run<T: Real>(cut: &Cut, seeds: u64) -> Outcome {
    let mut outcome = Outcome::default();
    for seed in 0..seeds {
        let sound = cut.play(seed);
        let teeth = cut.teeth_told.then_some(cut.teeth);
        let mut finder = SpeedFinder::<T>::new(&SpeedFinderConfig {
            fs_hz: FS,
            band: BAND,
            told_hz: cut.told_hz,
            teeth,
        })
        .expect("settings");
        let mut lines = SpindleLines::<T, 32>::new(&SpindleLinesConfig {
            teeth,
            ..SpindleLinesConfig::new(FS, BAND)
        })
        .expect("settings");
        let mut out = vec![];
        let mut locked = None;
        let mut started = false;
        for i in 0..sound.rest.len() {
            let y = sound.lines[i] + sound.rest[i] + sound.chatter[i];
            match finder.push(T::from_f64(y)) {
                Some(Finding::Found(comb)) => {
                    outcome.found += 1;
                    let hz = comb.spacing_hz.to_f64();
                    let truth = sound.speed_hz[i];
                    let ratio = (hz / truth).round().max(1.0);
                    if cut.ramp == 0.0 {
                        let error = hz / ratio - truth;
                        outcome.found_error.push(error);
                        outcome
                            .found_over_sd
                            .push(error * ratio / comb.sd_hz.to_f64());
                    }
                    if !started || lines.lock() == Lock::Lost {
                        outcome.lost += u32::from(started);
                        started = true;
                        lines.start(comb.spacing_hz, comb.sd_hz);
                    }
                }
                Some(Finding::NotEstimable) => outcome.none += 1,
                Some(Finding::Contradiction { .. }) => outcome.contradictions += 1,
                None => {}
            }
            out.push(lines.process(T::from_f64(y)).to_f64());
            if lines.lock() == Lock::Locked && locked.is_none() {
                locked = Some(i as f64 / FS);
            }
            if i % 1500 == 0
                && i as f64 > 2.0 * FS
                && lines.lock() == Lock::Locked
                && let Some((hz, sd)) = lines.spindle_hz()
            {
                let truth = sound.speed_hz[i];
                let ratio = (hz.to_f64() / truth).round().max(1.0);
                let error = hz.to_f64() / ratio - truth;
                outcome.tracked_error.push(error);
                if cut.ramp == 0.0 {
                    outcome.tracked_over_sd.push(error * ratio / sd.to_f64());
                }
            }
        }
        if lines.lock() == Lock::Lost {
            outcome.lost += 1;
        }
        outcome.lock_s.extend(locked);
        let part = |from: f64, to: f64| {
            let (from, to) = ((from * FS) as usize, (to * FS) as usize);
            let left: Vec<f64> = (from..to)
                .map(|i| out[i] - sound.rest[i] - sound.chatter[i])
                .collect();
            db((rms(&left) / rms(&sound.lines[from..to])).powi(2))
        };
        if cut.lines_db > -100.0 {
            outcome.left_db.push(part(cut.seconds - 1.0, cut.seconds));
            if cut.ramp != 0.0 {
                outcome.left_ramp_db.push(part(3.0, 5.0));
            }
        }
        if let Some((f, _)) = cut.chatter {
            let from = (2.0 * FS) as usize;
            let rest: Vec<f64> = (from..out.len()).map(|i| out[i] - sound.rest[i]).collect();
            outcome
                .kept
                .push(amplitude(&rest, f) / amplitude(&sound.chatter[from..], f));
        }
    }
    outcome
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn print(cut: &Cut, o: &Outcome) {
    let max = |x: &[f64]| x.iter().fold(f64::NAN, |a: f64, b| a.max(*b));
    println!(
        "| {} | {}/{}/{} | {:.3} ({:.2} sd) | {:.3} ({:.2} sd) | {} × {:.2}, {:.2} | {} | {:.1}, {:.1} | {:.1} | {:.2} |",
        cut.name,
        o.found,
        o.none,
        o.contradictions,
        rms(&o.found_error),
        rms(&o.found_over_sd),
        rms(&o.tracked_error),
        rms(&o.tracked_over_sd),
        o.lock_s.len(),
        mean(&o.lock_s),
        max(&o.lock_s),
        o.lost,
        mean(&o.left_db),
        max(&o.left_db),
        max(&o.left_ramp_db),
        o.kept.iter().fold(f64::NAN, |a: f64, b| a.min(*b)),
    );
}

fn header() {
    println!(
        "| cut | found/none/contradicted | error of the finder, Hz rms | of the tracking | locked: seeds × mean, latest s | lost | lines left, dB: mean, worst | while ramping | chatter kept, least |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
}

const SEEDS: u64 = 10;

fn tooth(k: f64) -> f64 {
    k * 5.0 * 76.4
}

/// Standard deviations are those of the errors.
fn assert_calibrated(cut: &Cut, o: &Outcome) {
    for ratio in [rms(&o.found_over_sd), rms(&o.tracked_over_sd)] {
        assert!((0.4..2.0).contains(&ratio), "{}: {ratio}", cut.name);
    }
}

/// Every seed locked, by this time, and none was lost.
fn assert_locked(cut: &Cut, o: &Outcome, by_s: f64) {
    assert_eq!((o.lock_s.len() as u64, o.lost), (SEEDS, 0), "{}", cut.name);
    for t in &o.lock_s {
        assert!((0.4..by_s).contains(t), "{}: locked at {t} s", cut.name);
    }
}

#[test]
fn a_steady_speed_is_found_and_its_lines_are_taken_out() {
    let d = |name| Cut { name, ..CUT };
    let told_hz = Some(75.0);
    let blind = |cut: Cut| Cut {
        told_hz: None,
        teeth_told: false,
        ..cut
    };
    header();
    // What is left: the noise in the notches, so the same under louder lines.
    for (cut, by_s, left_db) in [
        (
            Cut {
                modes: 1,
                ..d("1 mode, 20 dB, told")
            },
            0.6,
            -30.0,
        ),
        (d("3 modes, 20 dB, told"), 0.6, -32.0),
        (
            Cut {
                told_hz,
                ..d("told 1.8 % off")
            },
            0.6,
            -32.0,
        ),
        (
            Cut {
                told_hz,
                teeth_told: false,
                ..d("told 1.8 % off, no teeth")
            },
            0.6,
            -32.0,
        ),
        (blind(d("not told")), 1.5, -36.0),
        (
            Cut {
                runout_db: Some(-10.0),
                ..d("runout at -10 dB")
            },
            0.6,
            -32.0,
        ),
        (
            blind(Cut {
                runout_db: Some(-10.0),
                ..d("runout at -10 dB, not told")
            }),
            1.9,
            -32.0,
        ),
        (
            Cut {
                lines_db: 0.0,
                ..d("0 dB")
            },
            1.2,
            -12.0,
        ),
        (
            Cut {
                lines_db: -10.0,
                ..d("-10 dB")
            },
            1.8,
            -3.0,
        ),
    ] {
        let o = run::<f32>(&cut, SEEDS);
        print(&cut, &o);
        assert_locked(&cut, &o, by_s);
        assert_calibrated(&cut, &o);
        for left in &o.left_db {
            assert!(
                (left_db - 16.0..left_db).contains(left),
                "{}: {left}",
                cut.name
            );
        }
        assert!(rms(&o.found_error) < 0.015 && rms(&o.tracked_error) < 0.03);
    }
}

#[test]
fn a_ramp_of_ten_percent_a_second_is_followed() {
    header();
    for (ramp, lines_db, runout_db, worst_db) in [
        (0.1, 20.0, None, -23.0),
        (-0.1, 20.0, None, -18.0),
        (0.1, 20.0, Some(-20.0), -23.0),
        (-0.1, 10.0, None, -10.0),
    ] {
        let cut = Cut {
            name: "ramp",
            ramp,
            lines_db,
            runout_db,
            ..CUT
        };
        let o = run::<f32>(&cut, SEEDS);
        print(&cut, &o);
        assert_locked(&cut, &o, 0.6);
        for left in &o.left_ramp_db {
            assert!((worst_db - 15.0..worst_db).contains(left), "{left}");
        }
        // 15 Hz on the way.
        assert!((0.01..0.2).contains(&rms(&o.tracked_error)));
    }
}

#[test]
fn chatter_stays_and_does_not_pull() {
    header();
    for (name, f, part) in [
        ("chatter between", 1310.0, 1.0),
        ("3 Hz beside a tooth line", tooth(3.0) + 3.0, 1.0),
        ("8 Hz beside a tooth line", tooth(3.0) + 8.0, 1.0),
        ("3 Hz beside, 20 dB louder", tooth(3.0) + 3.0, 10.0),
        ("-8 Hz beside, 20 dB louder", tooth(3.0) - 8.0, 10.0),
        ("3 Hz beside a multiple, 20 dB", 18.0 * 76.4 + 3.0, 10.0),
    ] {
        let cut = Cut {
            name,
            chatter: Some((f, part)),
            ..CUT
        };
        let o = run::<f32>(&cut, SEEDS);
        print(&cut, &o);
        assert_locked(&cut, &o, 1.2);
        assert!(rms(&o.tracked_error) < 0.03, "{name}");
        for kept in &o.kept {
            assert!((0.8..1.1).contains(kept), "{name}: {kept}");
        }
    }
}

#[test]
fn noise_is_no_speed_and_a_wrong_one_is_named() {
    header();
    let lines_db = -200.0;
    let noise = Cut {
        name: "noise, told",
        lines_db,
        ..CUT
    };
    let blind = Cut {
        name: "noise, not told",
        told_hz: None,
        ..noise
    };
    for cut in [noise, blind] {
        let o = run::<f32>(&cut, SEEDS);
        print(&cut, &o);
        assert_eq!((o.found, o.contradictions), (0, 0));
        assert!(o.none > 50);
    }
    let wrong = Cut {
        name: "told 18 % wrong",
        told_hz: Some(90.0),
        ..CUT
    };
    let o = run::<f32>(&wrong, SEEDS);
    print(&wrong, &o);
    // The first comb of a run is not yet believed.
    assert_eq!((o.found, o.none), (0, SEEDS as u32));
    assert!(o.contradictions > 50);
}

#[test]
fn single_precision_does_as_double_does() {
    let cut = Cut {
        name: "f64",
        seconds: 4.0,
        runout_db: Some(-10.0),
        ..CUT
    };
    header();
    let (single, double) = (run::<f32>(&cut, 5), run::<f64>(&cut, 5));
    print(&cut, &double);
    assert_eq!(single.found, double.found);
    for (a, b) in single.left_db.iter().zip(&double.left_db) {
        assert!((a - b).abs() < 0.5, "{a} and {b} dB");
    }
    for (a, b) in single.tracked_error.iter().zip(&double.tracked_error) {
        assert!((a - b).abs() < 2e-3, "{a} and {b} Hz");
    }
}
