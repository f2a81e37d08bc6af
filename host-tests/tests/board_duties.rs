//! How long the duties of the image for the NUCLEO-G474RE take, and how late its current loop may be:
//! what the unmodified image executes on the model of its chip, laid out in time
//! (`xtask::chip::schedule`). The tables stand in docs/flash.md; `RARMA_WRITE_TABLE=1` writes them.

use host_tests::bars::{all_judged, holds};
use host_tests::board_model::{Host, NOBODYS, Seen, made_by_another_compiler, run};
use host_tests::page;
use rarma_core::cers::{Direction, ExcitationJob, Signal};
use rarma_core::guard::Mode;
use rarma_core::settings::{
    CERS_GAIN_XM, CERS_GAIN_XP, CERS_GAIN_YM, CERS_GAIN_YP, CERS_ORDER, MONITOR_THRESHOLD,
    SettingValue, TELL_STATUS,
};
use rarma_core::wire::{Command as Word, ExcitationMessage, Telemetry};
use serde_json::{Value, json};
use std::fmt::Write as _;
use xtask::chip::figures;
use xtask::chip::schedule::{Preempted, longest, preempted};
use xtask::chip::timing::{Form, Setup};

/// Cycles a second, and of the loop's period.
const CORE_HZ: f64 = 163.2e6;
const PERIOD: f64 = 3400.0;
/// The exception of the current loop, and the registers of its new duty: ADC3, TIM1's compares.
const LOOP: u32 = 16 + 47;
const DUTY: core::ops::Range<u32> = 0x4001_2C34..0x4001_2C44;
/// The rate that the loop was asked for, against that of this board.
const ASKED_RATE: f64 = 50_000.0 / 48_000.0;

fn setup(form: Form) -> Setup {
    Setup {
        prefetch: true,
        form,
    }
}

fn us(cycles: u64) -> f64 {
    1e6 * cycles as f64 / CORE_HZ
}

fn sound(seconds: f64) -> Vec<u16> {
    let bytes = figures::sound(seconds);
    let pairs = bytes.chunks_exact(2);
    pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

/// CERS at its bias, listening at (4,3); a signal from 0.13 s on.
fn cers(signal: Option<Signal>) -> Option<Seen> {
    let (from, end) = (0.4_f64, 0.42);
    let gain = SettingValue::Real(2.9e-7);
    let magnets = [CERS_GAIN_XP, CERS_GAIN_XM, CERS_GAIN_YP, CERS_GAIN_YM];
    let mut settings: Vec<_> = magnets.iter().map(|m| (m.number(), gain)).collect();
    // Order 3 of its list is (4,3).
    settings.push((CERS_ORDER.number(), SettingValue::Whole(3)));
    let job = signal.map(|signal| {
        Word::Excite(ExcitationJob {
            signal,
            direction: Direction::X,
            rms_a: 0.15,
            low_hz: 250.0,
            high_hz: 3000.0,
            seconds: 40.0,
            lines: 160,
        })
    });
    let host = Host::armed(end, &settings, job);
    std::fs::write(format!("/tmp/script-{signal:?}.json"), json!(host.steps).to_string()).unwrap();
    let from = from.to_string();
    let options = ["--count-from", from.as_str()];
    let seen = run("cers", end, &sound(end), &json!(host.steps), &options)?;
    let started = |m: &Telemetry| {
        matches!(m, Telemetry::Excitation(ExcitationMessage::Started(_)))
    };
    let driven = seen.frames.iter().any(|(_, message)| started(message));
    assert_eq!(driven, signal.is_some(), "{:?}", seen.frames);
    Some(seen)
}

#[test]
fn look() {
    for signal in [None, Some(Signal::Steps), Some(Signal::Noise)] {
    let seen = cers(signal).unwrap();
    for form in [Form::Least, Form::Most] {
        println!("{signal:?} {form:?} {:?} {:?}", longest(&seen.program, &seen.trace, setup(form), LOOP), preempted(&seen.program, &seen.trace, setup(form), LOOP, DUTY));
    }
    }
}
