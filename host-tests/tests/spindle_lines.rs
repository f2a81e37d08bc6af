//! Promise: what the spindle forces is found in the sound and taken out of it, at a
//! speed that is told, told wrongly by a few percent, or not told at all, also while
//! the speed changes; chatter beside the lines stays.
//!
//! Print the table with
//! `cargo test --release -p host-tests --test spindle_lines -- --nocapture --test-threads 1`.

use host_tests::spindle_cut::{CUT, Cut, Outcome, header, print, run};
use host_tests::statistics::rms;

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
