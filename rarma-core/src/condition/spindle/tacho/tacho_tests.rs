use super::{Tacho, TachoConfig, TachoError, TachoFault, TachoReading};

const FS: f64 = 48_000.0;

fn noise(seed: &mut u32) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (f64::from(*seed >> 8) / 8_388_608.0 - 1.0) * 3f64.sqrt()
}

/// Plays pulses at `turns(t)` (angle in turns over time, s), with jitter in intervals;
/// `drop` and `double` tell which pulse is lost or doubled. Reading at the last pulse.
fn play(
    turns: impl Fn(f64) -> f64,
    seconds: f64,
    jitter: f64,
    drop: impl Fn(u32) -> bool,
    double: impl Fn(u32) -> bool,
) -> (Tacho<f32>, Vec<TachoReading<f32>>, u64) {
    let mut tacho = Tacho::<f32>::new(&TachoConfig::new(FS)).expect("settings");
    let (mut count, mut seed, mut readings, mut end) = (0u32, 7, vec![], 0);
    // Two days in: time stamps are large.
    let start = 48_000u64 * 86_400 * 2;
    for n in 0..(seconds * FS) as u64 {
        let (a, b) = (turns(n as f64 / FS), turns((n + 1) as f64 / FS));
        if a.floor() == b.floor() {
            continue;
        }
        let part = (b.floor() - a) / (b - a);
        let interval = 1.0 / (b - a);
        let time = n as f64 + part + jitter * interval * noise(&mut seed);
        count += 1;
        end = start + n + 1;
        if !drop(count) {
            let at = time.floor().max(0.0);
            tacho.pulse(start + at as u64, (time - at) as f32);
            if double(count) {
                tacho.pulse(start + (time + 0.3 * interval) as u64, 0.0);
            }
        }
        readings.push(tacho.read(end));
    }
    (tacho, readings, end)
}

fn never(_: u32) -> bool {
    false
}

fn speed(reading: &TachoReading<f32>) -> f32 {
    reading.spindle_hz.map_or(f32::NAN, |(hz, _)| hz)
}

#[test]
fn single_bad_pulses_change_nothing() {
    let (_, readings, _) = play(|t| 76.4 * t, 2.0, 0.0, |n| n % 37 == 20, |n| n % 41 == 22);
    for reading in &readings[8..] {
        assert!((speed(reading) / 76.4 - 1.0).abs() < 1e-4, "{reading:?}");
        assert_eq!(reading.fault, None);
    }
}

#[test]
fn faults_that_persist_are_named_and_the_speed_is_kept() {
    // Every second pulse lost from the 60th on; an extra one with each.
    let (_, lost, _) = play(|t| 50.0 * t, 2.0, 0.0, |n| n > 60 && n % 2 == 0, never);
    let last = lost.last().expect("readings");
    assert_eq!(last.fault, Some(TachoFault::Missing));
    assert!((speed(last) - 50.0).abs() < 0.01);
    let (_, extra, _) = play(|t| 50.0 * t, 2.0, 0.0, never, |n| n > 60);
    let last = extra.last().expect("readings");
    assert_eq!(last.fault, Some(TachoFault::Doubled));
    assert!((speed(last) - 50.0).abs() < 0.01);
    let (_, noisy, _) = play(|t| 50.0 * t, 2.0, 0.08, never, never);
    let bad = noisy.iter().filter(|r| r.fault == Some(TachoFault::Noisy));
    assert!(bad.count() > noisy.len() / 2);
    let (_, calm, _) = play(|t| 50.0 * t, 2.0, 0.02, never, never);
    let bad = calm.iter().skip(8).filter(|r| r.fault.is_some());
    assert!(bad.count() < calm.len() / 50);
}

#[test]
fn silence_is_named() {
    let (tacho, readings, end) = play(|t| 50.0 * t, 1.0, 0.0, never, never);
    assert_eq!(readings.last().expect("readings").fault, None);
    // 4 turns, then two intervals of the slowest speed, 2 Hz.
    assert_eq!(tacho.read(end + 3840).fault, Some(TachoFault::Missing));
    let silent = tacho.read(end + 48_100);
    assert_eq!(silent.fault, Some(TachoFault::Silent));
    assert_eq!((silent.spindle_hz, silent.turn), (None, None));
    let new = Tacho::<f64>::new(&TachoConfig::new(FS)).expect("settings");
    assert_eq!(new.read(0).fault, Some(TachoFault::Silent));
}

#[test]
fn the_stated_error_is_the_error() {
    let mut squares = [0.0, 0.0];
    let mut count = 0.0;
    let (_, readings, _) = play(|t| 50.0 * t, 60.0, 0.01, never, never);
    // Every twelfth: independent pulses.
    for reading in readings[12..].iter().step_by(12) {
        let (hz, sd) = reading.spindle_hz.expect("a speed");
        squares[0] += f64::from(hz - 50.0).powi(2);
        squares[1] += f64::from(sd).powi(2);
        count += 1.0;
    }
    let ratio = f64::sqrt(squares[0] / squares[1]);
    assert!((0.85..1.15).contains(&ratio), "{ratio}");
    let rms = f64::sqrt(squares[0] / count);
    assert!((0.05..0.3).contains(&rms), "{rms}");
}

#[test]
fn a_ramp_is_read_at_its_end() {
    // 10 % per second.
    let (_, readings, _) = play(|t| 50.0 * (t + 0.05 * t * t), 2.0, 0.0, never, never);
    let last = speed(readings.last().expect("readings"));
    assert!((last / 60.0 - 1.0).abs() < 2e-3, "{last}");
    // A jump by a third is a new rhythm.
    let jump = |t: f64| {
        if t < 1.0 {
            50.0 * t
        } else {
            50.0 + 80.0 * (t - 1.0)
        }
    };
    let (_, readings, _) = play(jump, 2.0, 0.0, never, never);
    let last = readings.last().expect("readings");
    assert!((speed(last) - 80.0).abs() < 0.01 && last.fault.is_none());
}

#[test]
fn the_angle_runs_from_pulse_to_pulse() {
    let mut tacho = Tacho::<f64>::new(&TachoConfig {
        pulses_per_turn: 2,
        ..TachoConfig::new(FS)
    })
    .expect("settings");
    for n in 0..20 {
        tacho.pulse(480 * n, 0.0);
    }
    for (ahead, turn) in [(0, 0.0), (120, 0.125), (479, 0.499), (720, 0.75)] {
        let reading = tacho.read(480 * 19 + ahead);
        assert!((reading.turn.expect("an angle") - turn).abs() < 1e-3);
        assert!((reading.spindle_hz.expect("a speed").0 - 50.0).abs() < 1e-9);
    }
    // No later pulse, and no number: nothing happens.
    let before = tacho.read(480 * 19);
    tacho.pulse(480 * 19, 0.0);
    tacho.pulse(480 * 20, f64::NAN);
    assert_eq!(tacho.read(480 * 19), before);
}

#[test]
fn settings_out_of_range_are_named() {
    let config = TachoConfig::new(FS);
    let error = |config: TachoConfig| Tacho::<f32>::new(&config).err();
    let fs_hz = f64::NAN;
    assert_eq!(
        error(TachoConfig { fs_hz, ..config }),
        Some(TachoError::Rate)
    );
    let pulses_per_turn = 0;
    assert_eq!(
        error(TachoConfig {
            pulses_per_turn,
            ..config
        }),
        Some(TachoError::PulsesPerTurn)
    );
    let least_hz = 0.0;
    assert_eq!(
        error(TachoConfig { least_hz, ..config }),
        Some(TachoError::LeastSpeed)
    );
    let noisy_fraction = 0.9;
    assert_eq!(
        error(TachoConfig {
            noisy_fraction,
            ..config
        }),
        Some(TachoError::NoisyFraction)
    );
}
