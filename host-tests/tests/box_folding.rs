//! Promise: what lies above the band of the box's microphones is hardly heard within it: a
//! sound that its converter samples folds back by known decibels, with the low-pass of
//! docs/wiring.md and without.
//!
//! The chain is that of the board: conversions of 12 bits, eight added up to a sample, then
//! the band's own decimation. `--nocapture` prints the table of docs/bench.md.

use firmware::boards::nucleo_g474re::{scaling, timing};
use host_tests::bars::{all_judged, holds};
use rarma_core::condition::{Band, BandFilter};
use std::f64::consts::TAU;

/// The usual band of the box, Hz.
const BAND: Band = Band {
    low_hz: 300.0,
    high_hz: 2500.0,
};
const SECONDS: f64 = 0.5;
/// The first part, in which filters settle, is left out, s.
const SETTLED_S: f64 = 0.1;
/// Corner of the first-order low-pass that the wiring page asks for, Hz.
const CORNER_HZ: f64 = 10_000.0;
/// Amplitude of the tone, parts of the converter's half range.
const AMPLITUDE: f64 = 0.5;

/// Root of the mean square in the band of a tone at the microphone's pin.
fn heard(tone_hz: f64) -> f64 {
    let fs_hz = f64::from(timing::SAMPLE_HZ);
    let mut band = BandFilter::<f32>::new(BAND, fs_hz).expect("in range");
    let convert = |n: u32| {
        let t_s = f64::from(n) / f64::from(timing::TRIGGER_HZ);
        let code = 4095.0 * 0.5 * (1.0 + AMPLITUDE * (TAU * tone_hz * t_s).sin());
        code.round() as u16
    };
    let (mut power, mut count) = (0.0, 0);
    for sample in 0..(SECONDS * fs_hz) as u32 {
        let first = sample * timing::OVERSAMPLING;
        let sum = (first..first + timing::OVERSAMPLING).map(convert).sum();
        if let Some(y) = band.process(scaling::microphone(sum))
            && f64::from(sample) > SETTLED_S * fs_hz
        {
            power += f64::from(y).powi(2);
            count += 1;
        }
    }
    (power / f64::from(count)).sqrt()
}

/// Attenuation of the low-pass before the pin, dB.
fn low_pass_db(tone_hz: f64) -> f64 {
    10.0 * (1.0 + (tone_hz / CORNER_HZ).powi(2)).log10()
}

#[test]
fn what_lies_above_the_band_is_hardly_heard() {
    let reference = heard(1000.0);
    let below_db = |tone_hz: f64| 20.0 * (reference / heard(tone_hz)).log10();
    println!("| tones, kHz | fold | at least so many dB below | with the low-pass |");
    println!("|---|---|---:|---:|");
    let fs_hz = f64::from(timing::SAMPLE_HZ);
    let trigger_hz = f64::from(timing::TRIGGER_HZ);
    let steps =
        |from: f64, to: f64| (0..=40).map(move |k| from + (to - from) * f64::from(k) / 40.0);
    let around = |centre: f64| steps(centre - BAND.high_hz, centre + BAND.high_hz);
    let cases: [(&str, &str, Vec<f64>, f64); 4] = [
        (
            "4 to 24",
            "in the decimation",
            steps(4_000.0, 24_000.0).collect(),
            55.0,
        ),
        (
            "45.5 to 50.5",
            "in the sum of eight",
            around(fs_hz).collect(),
            24.0,
        ),
        (
            "93.5 to 98.5",
            "in the sum of eight",
            around(2.0 * fs_hz).collect(),
            24.0,
        ),
        (
            "381.5 to 386.5",
            "in the conversion",
            around(trigger_hz).collect(),
            -0.5,
        ),
    ];
    for (tones, fold, all, asked_db) in cases {
        let worst = |filter: &dyn Fn(f64) -> f64| {
            all.iter()
                .map(|hz| below_db(*hz) + filter(*hz))
                .fold(f64::INFINITY, f64::min)
        };
        let (bare, filtered) = (worst(&|_| 0.0), worst(&low_pass_db));
        println!("| {tones} | {fold} | {bare:.0} | {filtered:.0} |");
        holds(
            &format!("folding: dB below, {tones} kHz"),
            bare,
            asked_db..=200.0,
        );
        let with = if tones == "4 to 24" { 55.0 } else { 30.0 };
        holds(
            &format!("folding: dB below with the low-pass, {tones} kHz"),
            filtered,
            with..=200.0,
        );
    }
    all_judged("folding");
}
