use super::*;
use core::f64::consts::TAU;

const FS: f64 = 6000.0;

/// Uniform noise in ±1, always the same.
fn noise(state: &mut u32) -> f64 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*state >> 8) / 8_388_608.0 - 1.0
}

/// A cut that begins after a second of quiet noise: multiples of `tooth_hz`, and another
/// line of amplitude `line`, Hz and parts of the first multiple.
struct Cut {
    tooth_hz: f64,
    line: (f64, f64),
    gain: f64,
    seconds: f64,
}

impl Cut {
    fn new(tooth_hz: f64, line: (f64, f64)) -> Self {
        Self {
            tooth_hz,
            line,
            gain: 1.0,
            seconds: 5.0,
        }
    }

    fn samples(&self) -> impl Iterator<Item = f64> + '_ {
        let mut state = 7;
        (0..(self.seconds * FS) as usize).map(move |n| {
            let t = n as f64 / FS;
            let quiet = 0.01 * noise(&mut state);
            if t < 1.0 {
                return self.gain * quiet;
            }
            let sin = |f: f64, phase: f64| (TAU * f * t + phase).sin();
            let teeth: f64 = (1..=8)
                .map(|k| sin(f64::from(k) * self.tooth_hz, f64::from(k * k)) / f64::from(k))
                .sum();
            self.gain
                * (quiet + 0.05 * noise(&mut state) + teeth + self.line.1 * sin(self.line.0, 0.3))
        })
    }
}

fn told(spindle_hz: Option<f64>, teeth: u32) -> Listening {
    Listening {
        fs_hz: FS,
        spindle_hz,
        teeth: Some(teeth),
        folding_hz: None,
    }
}

/// Judgements with their times, s.
fn judged<T: Real>(cut: &Cut, listening: &Listening) -> Vec<(f64, Judgement<T>)> {
    let mut verdict = Verdict::<T>::new(&VerdictConfig::default(), listening).expect("in range");
    cut.samples()
        .enumerate()
        .filter_map(|(n, x)| {
            let judgement = verdict.process(T::from_f64(x))?;
            Some((n as f64 / FS, *judgement))
        })
        .collect()
}

#[test]
fn a_line_that_the_rotation_does_not_make_is_called_soon_and_by_its_frequency() {
    let cut = Cut::new(180.0, (811.0, 2.0));
    let all = judged::<f32>(&cut, &told(Some(60.0), 3));
    let (called_s, judgement) = all.iter().find(|(_, j)| j.chatter).expect("called");
    assert!((1.2..2.2).contains(called_s), "{called_s}");
    assert!((judgement.f_hz - 811.0).abs() < 1.0, "{}", judgement.f_hz);
    assert!(judgement.over_idle_db.expect("idle was heard") > 25.0);
    assert!(judgement.forced.expect("a speed was told") < 0.2);
    let stood = all
        .iter()
        .filter(|(t, j)| t > called_s && j.chatter)
        .count();
    let after = all.iter().filter(|(t, _)| t > called_s).count();
    assert!(stood * 20 >= after * 19, "{stood} of {after}");
}

#[test]
fn lines_of_the_rotation_are_not_called_though_the_speed_is_told_wrong_by_three_percent() {
    for error in [0.0, -0.01, 0.01, 0.03, -0.03] {
        let cut = Cut::new(180.0, (0.0, 0.0));
        let all = judged::<f32>(&cut, &told(Some(60.0 * (1.0 + error)), 3));
        assert!(all.iter().all(|(_, j)| !j.chatter), "told {error}");
        let (_, last) = all.last().expect("judged");
        let (hz, sd) = last.spindle_hz.expect("a speed");
        assert!((hz - 60.0).abs() < 0.06, "told {error}: {hz}");
        assert!(sd < 0.3, "{sd}");
    }
}

/// Where the teeth meet a mode there is one strong line, and the peaks of the noise far below
/// it tell of no speed.
#[test]
fn a_lone_tooth_line_at_the_told_speed_is_not_called() {
    let listening = told(Some(326.0), 3);
    let mut verdict = Verdict::<f32>::new(&VerdictConfig::default(), &listening).expect("in range");
    let mut state = 5;
    for n in 0..40_000 {
        let t = f64::from(n) / FS;
        let quiet = 1e-4 * noise(&mut state);
        let line = if t < 0.3 {
            0.0
        } else {
            (TAU * 978.0 * t).sin()
        };
        let x = quiet + line + 3e-3 * line * noise(&mut state);
        if let Some(judgement) = verdict.process(x as f32) {
            assert!(!judgement.chatter, "at {t}: {judgement:?}");
        }
    }
    let forced = verdict.judgement().forced.expect("a speed was told");
    assert!(forced > 0.8, "{forced}");
}

/// A clamp or a door is hit while the machine idles, at its peak 30 dB louder than the cut to come two seconds later.
#[test]
fn a_knock_before_the_cut_does_not_hide_chatter() {
    const BEFORE_S: f64 = 2.0;
    let mut state = 11;
    let idle = (0..(BEFORE_S * FS) as usize).map(|n| {
        let since_s = n as f64 / FS - 1.0;
        let knock = if since_s < 0.0 {
            0.0
        } else {
            60.0 * (-since_s / 0.02).exp() * (TAU * 530.0 * since_s).sin()
        };
        knock + 0.01 * noise(&mut state)
    });
    let cut = Cut::new(180.0, (811.0, 2.0));
    let mut verdict =
        Verdict::<f32>::new(&VerdictConfig::default(), &told(Some(60.0), 3)).expect("in range");
    let called_s = idle.chain(cut.samples()).enumerate().find_map(|(n, x)| {
        let judgement = verdict.process(x as f32)?;
        judgement.chatter.then_some(n as f64 / FS - BEFORE_S)
    });
    let called_s = called_s.expect("called");
    assert!((1.2..2.2).contains(&called_s), "{called_s}");
}

/// In a ramp the teeth's lines glide out of the belief's reach.
#[test]
fn a_speed_that_is_turned_untold_is_not_called() {
    for rate in [0.1, -0.1, 0.4, -0.4] {
        let listening = told(Some(60.0), 3);
        let mut verdict =
            Verdict::<f32>::new(&VerdictConfig::default(), &listening).expect("in range");
        let (mut state, mut phase) = (11, 0.0);
        for n in 0..48_000 {
            let t = f64::from(n) / FS;
            let turned = (t - 3.0).clamp(0.0, 0.15 / f64::abs(rate));
            phase += TAU * 180.0 * (1.0 + rate * turned) / FS;
            let teeth: f64 = (1..=8)
                .map(|k| (f64::from(k) * phase).sin() / f64::from(k))
                .sum();
            let quiet = 0.01 * noise(&mut state);
            let x = if t < 1.0 {
                quiet
            } else {
                quiet + teeth + 0.05 * noise(&mut state)
            };
            if let Some(judgement) = verdict.process(x as f32) {
                assert!(!judgement.chatter, "{rate}: at {t}: {judgement:?}");
            }
        }
        let (hz, _) = verdict.judgement().spindle_hz.expect("a speed");
        let true_hz = 60.0 * (1.0 + 0.15 * f64::signum(rate));
        assert!(
            (f64::from(hz) / true_hz - 1.0).abs() < 0.01,
            "{rate}: {hz} for {true_hz}"
        );
    }
}

/// A mode that noise rings, a second of it 40 dB quieter.
fn ringing(f_hz: f64, zeta: f64, seed: u32) -> impl Iterator<Item = f64> {
    let w = TAU * f_hz / FS;
    let (r, c) = ((-zeta * w).exp(), (w * (1.0 - zeta * zeta).sqrt()).cos());
    let (mut y1, mut y2, mut state) = (0.0, 0.0, seed);
    (0..).map(move |n| {
        let level = if n < 6000 { 0.01 } else { 1.0 };
        let y = 2.0 * r * c * y1 - r * r * y2 + level * noise(&mut state);
        (y1, y2) = (y, y1);
        y
    })
}

#[test]
fn a_mode_that_noise_rings_is_not_called() {
    let listening = told(Some(60.0), 3);
    let mut verdict = Verdict::<f32>::new(&VerdictConfig::default(), &listening).expect("in range");
    for (n, y) in ringing(700.0, 0.03, 3).take(30_000).enumerate() {
        if let Some(judgement) = verdict.process(y as f32) {
            assert!(!judgement.chatter, "at {n}");
        }
    }
}

/// Calls, and part of the time in alarm, of such modes at 30 frequencies.
fn rung(zeta: f64) -> (u32, f64) {
    let (mut calls, mut alarmed, mut windows) = (0, 0, 0);
    for seed in 0..30_u32 {
        let listening = told(Some(60.0), 3);
        let mut verdict =
            Verdict::<f32>::new(&VerdictConfig::default(), &listening).expect("in range");
        let mut was = false;
        let sound = ringing(400.0 + 55.0 * f64::from(seed), zeta, 7 * seed + 3);
        for y in sound.take(66_000) {
            if let Some(judgement) = verdict.process(y as f32) {
                calls += u32::from(judgement.chatter && !was);
                was = judgement.chatter;
                alarmed += u32::from(was);
                windows += 1;
            }
        }
    }
    (calls, f64::from(alarmed) / f64::from(windows))
}

/// A mode that is all there is, 40 dB over idle, rung by noise alone for ten seconds at 30
/// frequencies: the worst case of a stable cut.
#[test]
fn modes_that_noise_rings_are_rarely_called() {
    for (zeta, most_calls, most_time) in [
        (0.01, 30, 0.3),
        (0.02, 12, 0.08),
        (0.03, 5, 0.03),
        (0.05, 0, 0.0),
    ] {
        let (calls, time) = rung(zeta);
        println!("damping {zeta}: {calls} calls in 5 min, {time:.3} of the time");
        assert!(
            calls <= most_calls && time <= most_time,
            "{zeta}: {calls}, {time}"
        );
    }
}

#[test]
fn loudness_changes_nothing() {
    let said = |gain: f64| -> Vec<bool> {
        let cut = Cut {
            gain,
            ..Cut::new(180.0, (811.0, 2.0))
        };
        judged::<f32>(&cut, &told(Some(60.0), 3))
            .iter()
            .map(|(_, j)| j.chatter)
            .collect()
    };
    let usual = said(1.0);
    for gain in [1e-6, 1e-3, 1e3, 1e6] {
        assert_eq!(said(gain), usual, "{gain}");
    }
}

#[test]
fn single_precision_believes_what_double_does() {
    for line in [(811.0, 2.0), (811.0, 0.5), (0.0, 0.0)] {
        let cut = Cut::new(180.0, line);
        let listening = told(Some(60.3), 3);
        let single = judged::<f32>(&cut, &listening);
        let double = judged::<f64>(&cut, &listening);
        assert_eq!(single.len(), double.len());
        for ((t, s), (_, d)) in single.iter().zip(&double) {
            let apart = (f64::from(s.evidence) - d.evidence).abs();
            assert!(
                apart < 0.2,
                "{line:?} at {t}: {} {}",
                s.evidence,
                d.evidence
            );
        }
    }
}

#[test]
fn a_judgement_comes_twenty_times_a_second_at_every_rate() {
    for fs_hz in [400.0, 1650.0, 6000.0, 7350.0, 12_000.0, 20_000.0] {
        let listening = Listening {
            fs_hz,
            ..told(Some(60.0), 3)
        };
        let config = VerdictConfig::default();
        let mut verdict = Verdict::<f32>::new(&config, &listening).expect("in range");
        let mut state = 5;
        let count = (0..(4.0 * fs_hz) as usize)
            .filter(|_| verdict.process(noise(&mut state) as f32).is_some())
            .count();
        assert!((55..=80).contains(&count), "{fs_hz}: {count}");
    }
}

#[test]
fn bad_samples_are_forgotten_with_their_window() {
    let cut = Cut::new(180.0, (811.0, 2.0));
    let listening = told(Some(60.0), 3);
    let mut verdict = Verdict::<f32>::new(&VerdictConfig::default(), &listening).expect("in range");
    let mut last = Judgement::NONE;
    for (n, x) in cut.samples().enumerate() {
        let bad = (9000..9010).contains(&n);
        let x = if bad { f32::NAN } else { x as f32 };
        if let Some(judgement) = verdict.process(x) {
            assert!(judgement.evidence.is_finite(), "at {n}");
            last = *judgement;
        }
    }
    assert!(last.chatter && (last.f_hz - 811.0).abs() < 1.0);
}

#[test]
fn a_speed_told_in_the_cut_moves_the_lines_with_it() {
    let listening = told(Some(60.0), 3);
    let mut verdict = Verdict::<f32>::new(&VerdictConfig::default(), &listening).expect("in range");
    let (mut state, mut phase) = (9, 0.0);
    for n in 0..42_000 {
        // An override of 10 % in steps of a percent, told as it happens.
        let step = ((n as f64 / FS - 2.0) / 0.2).clamp(0.0, 10.0).floor();
        let hz = 60.0 * (1.0 + 0.01 * step);
        if n % 600 == 0 {
            verdict.tell_speed(hz as f32);
        }
        phase += TAU * hz * 3.0 / FS;
        let teeth: f64 = (1..=8)
            .map(|k| (f64::from(k) * phase).sin() / f64::from(k))
            .sum();
        let loud = if n < 6000 { 0.0 } else { 1.0 };
        let x = loud * teeth + 0.01 * noise(&mut state);
        if let Some(judgement) = verdict.process(x as f32) {
            assert!(!judgement.chatter, "at {n}");
        }
    }
    let (hz, _) = verdict.judgement().spindle_hz.expect("a speed");
    assert!((hz - 66.0).abs() < 0.2, "{hz}");
}

/// Without a speed every line is free, the teeth's too. What was held of them then is void.
#[test]
fn the_first_speed_that_is_told_calls_none_of_the_lines_that_it_explains() {
    let cut = Cut::new(180.0, (0.0, 0.0));
    let mut verdict =
        Verdict::<f32>::new(&VerdictConfig::default(), &told(None, 3)).expect("in range");
    let told_at = (2.51 * FS) as usize;
    let (mut suspected, mut called) = (false, 0);
    for (n, x) in cut.samples().enumerate() {
        if n == told_at {
            verdict.tell_speed(60.0);
        }
        let _ = verdict.process(x as f32);
        let chatter = verdict.judgement().chatter;
        if n < told_at {
            suspected |= chatter;
        } else {
            called += usize::from(chatter);
        }
    }
    assert!(suspected, "else the promise would be empty");
    assert_eq!(called, 0);
}

#[test]
fn without_a_speed_nothing_is_said_of_the_rotation() {
    let all = judged::<f32>(&Cut::new(180.0, (811.0, 2.0)), &told(None, 1));
    assert!(
        all.iter()
            .all(|(_, j)| j.forced.is_none() && j.spindle_hz.is_none())
    );
}

#[test]
fn what_is_out_of_range_is_named() {
    let config = VerdictConfig::default();
    let refused = |listening: Listening| Verdict::<f32>::new(&config, &listening).err();
    let rate = |fs_hz| Listening {
        fs_hz,
        ..told(None, 1)
    };
    assert_eq!(refused(rate(f64::NAN)), Some(VerdictError::Rate));
    assert_eq!(refused(rate(48_000.0)), Some(VerdictError::Rate));
    assert_eq!(refused(told(Some(0.0), 1)), Some(VerdictError::Speed));
    assert_eq!(refused(told(None, 0)), Some(VerdictError::Teeth));
}

#[test]
fn it_has_this_size() {
    let bytes = size_of::<Verdict<f32>>();
    assert!((29_000..31_000).contains(&bytes), "{bytes}");
}

/// The work on a window ends before the next one begins, at the lowest rate, too.
#[test]
fn every_window_is_judged_at_every_rate() {
    for fs_hz in [100.0, 120.0, 150.0, 200.0, 407.0, 1650.0, 6000.0, 20_000.0] {
        for spindle_hz in [None, Some(0.1 * fs_hz)] {
            let listening = Listening {
                fs_hz,
                spindle_hz,
                teeth: None,
                folding_hz: None,
            };
            let mut verdict = Verdict::<f32>::new(&VerdictConfig::default(), &listening).unwrap();
            let mut state = 5;
            let count = (20.0 * fs_hz) as usize;
            let judged = (0..count)
                .filter(|_| verdict.process(noise(&mut state) as f32).is_some())
                .count();
            let windows = (count - verdict.frame.window) / verdict.frame.hop;
            assert!(
                judged.abs_diff(windows) <= 1,
                "{fs_hz}: {judged} of {windows}"
            );
        }
    }
}
