//! Finder and lines together, on autoregressive noise.

use super::*;
use crate::condition::Band;
use crate::real::Real;
use core::f64::consts::TAU;

const FS: f64 = 6000.0;
const BAND: Band = Band {
    low_hz: 300.0,
    high_hz: 2500.0,
};

/// AR(2) noise of a resonance at 980 Hz, 2 % damping, of variance about 1.
struct Noise {
    seed: u32,
    past: [f64; 2],
}

impl Noise {
    fn new(seed: u32) -> Self {
        Self {
            seed,
            past: [0.0; 2],
        }
    }

    fn next(&mut self) -> f64 {
        let mut e = 0.0;
        for _ in 0..3 {
            self.seed = self
                .seed
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            e += f64::from(self.seed >> 8) / 8_388_608.0 - 1.0;
        }
        let w = TAU * 980.0 / FS;
        let r = (-0.02 * w).exp();
        let y = 0.17 * e + 2.0 * r * w.cos() * self.past[0] - r * r * self.past[1];
        self.past = [y, self.past[0]];
        y
    }
}

fn finder<T: Real>(told_hz: Option<f64>, teeth: Option<u32>) -> SpeedFinder<T> {
    SpeedFinder::new(&SpeedFinderConfig {
        fs_hz: FS,
        band: BAND,
        told_hz,
        teeth,
    })
    .expect("settings")
}

fn bank<T: Real>(teeth: Option<u32>) -> SpindleLines<T, 32> {
    SpindleLines::new(&SpindleLinesConfig {
        teeth,
        ..SpindleLinesConfig::new(FS, BAND)
    })
    .expect("settings")
}

/// Answers of a finder to tones (Hz, amplitude) in the noise.
fn answers(told: Option<f64>, tones: &[(f64, f64)], seed: u32) -> Vec<Finding<f32>> {
    let mut finder = finder::<f32>(told, None);
    let mut noise = Noise::new(seed);
    (0..60_000)
        .filter_map(|n| {
            let t = f64::from(n) / FS;
            let tones: f64 = tones.iter().map(|(f, a)| a * (TAU * f * t).sin()).sum();
            finder.push((noise.next() + tones) as f32)
        })
        .collect()
}

#[test]
fn one_or_two_tones_are_no_comb() {
    let tones: [&[(f64, f64)]; 5] = [
        &[],
        &[(733.0, 10.0)],
        &[(898.6, 10.0), (1797.2, 3.0)],
        &[(500.0, 10.0), (1000.0, 10.0)],
        &[(640.0, 10.0), (1411.0, 10.0)],
    ];
    for (tones, seed) in tones.iter().zip(1..) {
        for told in [None, Some(75.0)] {
            let answers = answers(told, tones, seed);
            assert!((8..20).contains(&answers.len()), "{}", answers.len());
            for answer in answers {
                assert_eq!(answer, Finding::NotEstimable, "{tones:?} {told:?}");
            }
        }
    }
}

#[test]
fn a_comb_is_found_beside_a_chatter_and_a_wrong_speed_is_named() {
    let mut tones: Vec<(f64, f64)> = (4..30).map(|n| (76.4 * f64::from(n), 0.7)).collect();
    tones.push((1173.0, 20.0));
    for (told, seed) in [(None, 1), (Some(75.0), 2), (Some(90.0), 3)] {
        let answers = answers(told, &tones, seed);
        let good = answers.iter().filter(|answer| match answer {
            Finding::Found(comb) => {
                told != Some(90.0) && (comb.spacing_hz - 76.4).abs() < 0.05 && comb.chance < 1e-3
            }
            Finding::Contradiction { told_hz, found_hz } => {
                told == Some(90.0)
                    && (told_hz - 90.0).abs() < 0.01
                    && (found_hz - 76.4).abs() < 0.05
            }
            Finding::NotEstimable => false,
        });
        assert!(good.count() + 1 >= answers.len(), "{told:?}: {answers:?}");
    }
}

/// Speed at the end, and rms of what is left of the lines in the last half.
fn locked<T: Real>(seconds: f64, at: (f64, f64)) -> (f64, f64, SpindleLines<T, 32>) {
    let mut lines = bank::<T>(Some(5));
    lines.start(T::from_f64(at.1), T::from_f64(0.05));
    let mut noise = Noise::new(4);
    let samples = (seconds * FS) as u32;
    let (mut squares, mut count) = (0.0, 0.0);
    for n in 0..samples {
        let turns = at.0 * f64::from(n) / FS;
        let y: f64 = (1..=6)
            .map(|k| (TAU * (5.0 * f64::from(k) * turns).fract()).sin())
            .sum();
        let rest = 0.1 * noise.next();
        let out = lines.process(T::from_f64(3.0 * y + rest)).to_f64();
        if n > samples / 2 {
            squares += (out - rest) * (out - rest);
            count += 1.0;
        }
    }
    let hz = lines.spindle_hz().map_or(T::ZERO, |(hz, _)| hz).to_f64();
    (hz, (squares / count).sqrt(), lines)
}

#[test]
fn single_precision_holds_the_lines_for_long() {
    // Ten minutes; 76.4321 Hz, started a tenth of a percent off.
    let (hz, left, lines) = locked::<f32>(600.0, (76.4321, 76.5));
    assert!((hz - 76.4321).abs() < 1e-3, "{hz}");
    // Noise of 0.1 in notches of 0.5 Hz, 26 of them; the lines have an rms of 5.2.
    assert!((1e-3..0.03).contains(&left), "{left}");
    assert!((lines.power() - 27.0).abs() < 0.3, "{}", lines.power());
    assert!((lines.amplitude(10).expect("a tooth line") - 3.0).abs() < 0.05);
    assert!(lines.amplitude(3).is_none());
    assert!((lines.notch_hz() - 0.53).abs() < 0.01);
    let (exact, left64, _) = locked::<f64>(20.0, (76.4321, 76.5));
    let (single, left32, _) = locked::<f32>(20.0, (76.4321, 76.5));
    assert!((exact - single).abs() < 2e-4 && (left32 / left64 - 1.0).abs() < 0.05);
}

#[test]
fn what_holds_nothing_passes_the_signal() {
    let mut lines = bank::<f64>(None);
    let mut noise = Noise::new(9);
    for start in [false, true] {
        if start {
            lines.start(76.4, 0.05);
        }
        let mut passed = 0;
        for _ in 0..12_000 {
            let y = noise.next();
            passed += u32::from(lines.process(y).to_bits() == y.to_bits());
        }
        assert_eq!(passed, 12_000);
    }
    assert_eq!(lines.lock(), Lock::Lost);
    assert_eq!((lines.power(), lines.lines().count()), (0.0, 0));
    lines.reset();
    assert_eq!((lines.lock(), lines.spindle_hz()), (Lock::Searching, None));
}

#[test]
fn samples_that_are_no_numbers_change_nothing() {
    let (_, _, mut lines) = locked::<f32>(2.0, (76.4, 76.4));
    let before = lines.power();
    for y in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let out = lines.process(y);
        assert!(!out.is_finite());
    }
    for _ in 0..10 {
        assert!(lines.process(1.0).is_finite());
    }
    assert!((lines.power() / before - 1.0).abs() < 0.3);
    lines.start(f32::NAN, 0.1);
    lines.measure_speed(f32::NAN, 0.1);
    assert!(
        lines
            .spindle_hz()
            .is_some_and(|(hz, _)| (hz - 76.4).abs() < 0.1)
    );
    let mut finder = finder::<f32>(None, None);
    for n in 0..20_000 {
        let y = if n % 1000 == 0 { f32::NAN } else { 1.0 };
        // Never a whole frame without a bad sample.
        assert!(finder.push(y).is_none());
    }
}

#[test]
fn a_line_that_stops_is_let_go() {
    let (_, _, mut lines) = locked::<f64>(2.0, (76.4, 76.4));
    assert_eq!(lines.lock(), Lock::Locked);
    let mut noise = Noise::new(5);
    let until = (0..30_000).find(|_| {
        lines.process(noise.next());
        lines.lock() == Lock::Lost
    });
    let seconds = until.map_or(f64::NAN, |n: i32| f64::from(n) / FS);
    assert!((0.1..2.0).contains(&seconds), "{seconds}");
}

/// Runs lines at multiples of 163 Hz, (multiple, amplitude), through a bank on top of
/// noise; gives the rms of what is left beside the noise over the last 0.2 s.
fn left(
    lines: &mut SpindleLines<f64, 32>,
    at: &mut u32,
    seconds: f64,
    tones: &[(u32, f64)],
) -> f64 {
    let mut noise = Noise::new(7);
    let samples = (seconds * FS) as u32;
    let (mut squares, mut count) = (0.0, 0.0);
    for n in 0..samples {
        let turns = 163.0 * f64::from(*at) / FS;
        *at += 1;
        let y: f64 = tones
            .iter()
            .map(|(k, a)| a * (TAU * (f64::from(*k) * turns).fract()).sin())
            .sum();
        let rest = 0.02 * noise.next();
        let out = lines.process(y + rest);
        if samples - n < (0.2 * FS) as u32 {
            squares += (out - rest) * (out - rest);
            count += 1.0;
        }
    }
    (squares / count).sqrt()
}

#[test]
fn where_flip_chatter_grows_only_what_stands_is_removed() {
    let teeth: [(u32, f64); 3] = [(2, 3.0), (4, 3.0), (6, 3.0)];
    let with = |flip: f64| [&teeth[..], &[(5, flip)]].concat();
    let mut lines = bank::<f64>(Some(2));
    let mut at = 0;
    lines.start(163.0, 0.05);
    let steady = left(&mut lines, &mut at, 6.0, &with(1.0));
    assert!(steady < 0.05, "runout of rms 0.7 leaves {steady}");
    assert!((lines.loudest_slow() / 0.5 - 1.0).abs() < 0.05);
    // It grows by 2: rms 1.4. A line of the teeth would be gone after 0.5 s.
    let grown = left(&mut lines, &mut at, 0.5, &with(3.0));
    assert!((1.1..1.45).contains(&grown), "{grown}");
    lines.hold(true);
    let held = left(&mut lines, &mut at, 5.0, &with(3.0));
    assert!((held / grown - 1.0).abs() < 0.1, "{held}");
    // The cut ends: nothing is subtracted any more that is not there.
    let mut ended = lines.clone();
    let ghost = left(&mut ended, &mut at.clone(), 0.7, &teeth);
    assert!(ghost < 0.2, "{ghost}");
    lines.hold(false);
    let gone = left(&mut lines, &mut at, 15.0, &with(3.0));
    assert!(gone < 0.05, "{gone}");
}

#[test]
fn a_comb_in_doubt_goes_as_it_stands() {
    let comb = |loud: f64| [(2, 1.0), (3, 1.0), (4, loud), (5, 1.0)];
    let mut lines = bank::<f64>(None);
    let mut at = 0;
    lines.start_slowly(163.0, 0.05);
    assert!(lines.are_slow() && lines.is_running());
    let steady = left(&mut lines, &mut at, 6.0, &comb(1.0));
    assert_eq!(lines.lock(), Lock::Locked);
    assert!(steady < 0.05, "{steady}");
    let grown = left(&mut lines, &mut at, 0.5, &comb(3.0));
    assert!((1.1..1.45).contains(&grown), "{grown}");
    lines.start(163.0, 0.05);
    assert!(!lines.are_slow());
}

#[test]
fn a_speed_that_is_only_tried_needs_lines_that_stand_out_by_far() {
    // Noise of 0.02 in notches of half a hertz.
    for (amplitude, expected) in [(0.002, Lock::Lost), (0.3, Lock::Locked)] {
        let mut lines = bank::<f64>(Some(5));
        lines.try_speed(163.0, 0.2);
        let mut at = 0;
        left(&mut lines, &mut at, 3.0, &[(5, amplitude), (10, amplitude)]);
        assert_eq!(lines.lock(), expected, "{amplitude}");
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let base = SpindleLinesConfig::new(FS, BAND);
    let error = |config| SpindleLines::<f32, 8>::new(&config).err();
    assert_eq!(error(base), None);
    let fs_hz = f64::NAN;
    assert_eq!(
        error(SpindleLinesConfig { fs_hz, ..base }),
        Some(SpindleLinesError::Rate)
    );
    let teeth = Some(0);
    assert_eq!(
        error(SpindleLinesConfig { teeth, ..base }),
        Some(SpindleLinesError::Teeth)
    );
    let tau_s = 0.0;
    assert_eq!(
        error(SpindleLinesConfig { tau_s, ..base }),
        Some(SpindleLinesError::Memory)
    );
    let wander = 1.0;
    assert_eq!(
        error(SpindleLinesConfig { wander, ..base }),
        Some(SpindleLinesError::Wander)
    );
    let mut finder = finder::<f32>(Some(75.0), Some(5));
    assert_eq!(finder.tell(Some(2.0)), Err(SpeedFinderError::Told));
    assert_eq!(finder.tell(Some(f32::NAN)), Err(SpeedFinderError::Told));
    assert_eq!(finder.tell(None), Ok(()));
}

#[test]
fn state_is_as_large_as_stated() {
    assert!((8_192..9_000).contains(&size_of::<SpeedFinder<f32>>()));
    assert!((1_000..1_700).contains(&size_of::<SpindleLines<f32, 32>>()));
    assert!((100..400).contains(&size_of::<Tacho<f32>>()));
}
