//! How long the duties of the image for the NUCLEO-G474RE take, and how late its current loop may be:
//! what the unmodified image executes on the model of its chip, laid out in time
//! (`xtask::chip::schedule`). The tables stand in docs/flash.md; `RARMA_WRITE_TABLE=1` writes them.

use embedded_storage::nor_flash::ReadNorFlash;
use firmware::store::Store;
use hal_sim::rig::{SECTOR, SimFlash};
use host_tests::bars::{all_judged, holds};
use host_tests::board_model::{
    Host, NOBODYS, SETTINGS_AT, SETTINGS_BYTES, Seen, made_by_another_compiler, run,
};
use host_tests::cers_rig::JOB;
use host_tests::page;
use rarma_box::guard::Mode;
use rarma_box::settings::{
    CERS_GAIN_XM, CERS_GAIN_XP, CERS_GAIN_YM, CERS_GAIN_YP, CERS_ORDER, MONITOR_THRESHOLD,
    SettingValue, Settings, find,
};
use rarma_box::wire::{Answer, Command as Word, ExcitationMessage, Telemetry};
use rarma_rigs::cers::{ExcitationJob, Signal};
use serde_json::json;
use std::fmt::Write as _;
use xtask::chip::figures::sound;
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

/// CERS at its bias, listening at (4,3); a signal from 0.13 s on.
fn cers(signal: Option<Signal>) -> Option<Seen> {
    let (from, end) = (0.4_f64, 0.42);
    let gain = SettingValue::Real(2.9e-7);
    let magnets = [CERS_GAIN_XP, CERS_GAIN_XM, CERS_GAIN_YP, CERS_GAIN_YM];
    let mut settings: Vec<_> = magnets.iter().map(|m| (m.number(), gain)).collect();
    // Order 3 of its list is (4,3).
    settings.push((CERS_ORDER.number(), SettingValue::Whole(3)));
    let job = signal.map(|signal| Word::Excite(ExcitationJob { signal, ..JOB }));
    let host = Host::armed(end, &settings, job);
    let from = from.to_string();
    let options = ["--count-from", from.as_str()];
    let seen = run("cers", end, &sound(end), &json!(host.steps), &options)?;
    let started = |m: &Telemetry| matches!(m, Telemetry::Excitation(ExcitationMessage::Started(_)));
    let driven = seen.frames.iter().any(|(_, message)| started(message));
    assert_eq!(driven, signal.is_some(), "{:?}", seen.frames);
    Some(seen)
}

/// The current loop among a listening monitor.
#[test]
fn the_loop_breaks_into_listening() {
    if made_by_another_compiler("board_duties") {
        return;
    }
    let mut table = "| signal | handler | cause to new duty | longest | parts of half a period | \
        of the core | with listening at (4,3) | longest pass |\n|---|---:|---:|---:|---:|---:|---:|---:|\n"
        .to_owned();
    for (name, signal) in [
        ("none", None),
        ("noise", Some(Signal::Noise)),
        ("stepped sine", Some(Signal::Steps)),
    ] {
        let Some(seen) = cers(signal) else { return };
        let of = |form| preempted(&seen.program, &seen.trace, setup(form), LOOP, DUTY);
        let [least, most] = [Form::Least, Form::Most].map(|f| of(f).expect("the loop runs"));
        let all = |p: &Preempted| 100.0 * (p.busy + p.handler * (ASKED_RATE - 1.0));
        // It hangs on what happens to run when the period ends, so that either may have the longer one.
        let longest = least.worst.max(most.worst);
        let halves = longest as f64 / (0.5 * PERIOD);
        // Writing to a String cannot fail.
        let _ = writeln!(
            table,
            "| {name} | {:.0} to {:.0} | {:.0} to {:.0} | {:.0} to {:.0} | {halves:.2} | {:.0} to {:.0} % | {:.0} to {:.0} % | {:.2} ms |",
            least.cold,
            most.cold,
            least.mean,
            most.mean,
            least.worst.min(most.worst),
            longest,
            100.0 * least.handler * ASKED_RATE,
            100.0 * most.handler * ASKED_RATE,
            all(&least),
            all(&most),
            1e-3 * us(most.pass),
        );
        holds(
            &format!("board duties: latency of the loop, half periods, signal {name}"),
            halves,
            0.0..=1.0,
        );
        if signal == Some(Signal::Steps) {
            holds(
                "board duties: % of the core, loop at 50 kHz with a stepped sine, monitor (4,3)",
                all(&most),
                0.0..=60.0,
            );
        }
        assert!(
            least.cold < most.cold && least.mean < most.mean,
            "{name}: {least:?}, {most:?}"
        );
    }
    println!("{table}");
    all_judged("board duties");
    page::nearly_holds("docs/flash.md", "board-loop", &table);
}

/// What stands in the flash of a box whose settings have been saved so often that both halves of the store are
/// full, and the next save of one that was never saved has to erase a page.
fn much_used() -> Vec<u8> {
    let mut flash = SimFlash::new(SETTINGS_BYTES / SECTOR, 1);
    let range = flash.range();
    let mut store = Store::default();
    let saved = |store: &mut Store, flash: &mut SimFlash, setting, n: u32| {
        let (_, setting) = find(setting).expect("in the table");
        let value = SettingValue::Real(2e-7 + 1e-10 * n as f32);
        store
            .write(flash, range.clone(), setting, Some(value))
            .expect("room");
    };
    for n in 0..10_000 {
        saved(&mut store, &mut flash, CERS_GAIN_XP.number(), n);
        if flash.wear().contains(&0) {
            continue;
        }
        // What the box will find itself doing.
        let mut next = flash.clone();
        let (mut started, _) = Store::load(&mut next, range.clone(), &mut Settings::default());
        let before: u32 = next.wear().iter().sum();
        saved(&mut started, &mut next, MONITOR_THRESHOLD.number(), 0);
        if next.wear().iter().sum::<u32>() > before {
            let mut bytes = vec![0; SETTINGS_BYTES];
            flash.read(0, &mut bytes).expect("inside");
            return bytes;
        }
    }
    panic!("no page is ever erased");
}

/// LDBB armed; commands and settings that are saved while it listens, the first ones and in a store that is full.
fn on_the_link() -> Option<[(&'static str, Seen); 3]> {
    let mut bar = Host::default();
    bar.steps = vec![json!([0.0, "PA6", 1]), json!([0.0, "PC8", 1])];
    bar.say(0.015, Word::Take { turn: NOBODYS });
    bar.say(0.02, Word::Start(Mode::Ldbb));
    bar.say(0.025, Word::Heartbeat);
    bar.say(0.03, Word::Arm);
    let saving = || {
        let mut box_ = Host::default();
        box_.say(0.015, Word::Take { turn: NOBODYS });
        for (n, at) in [0.105, 0.205].into_iter().enumerate() {
            let setting = MONITOR_THRESHOLD.number();
            let value = SettingValue::Real(0.011 + 0.001 * n as f32);
            box_.say(at, Word::Set { setting, value });
            box_.say(at + 0.002, Word::Save { setting });
            box_.say(at + 0.004, Word::Status);
        }
        box_
    };
    let mut used = saving();
    let hex: String = much_used()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    used.steps
        .insert(0, json!([0.0, "flash-holds", [SETTINGS_AT, hex]]));
    let of = |name, host: Host, from: &str, end: f64| {
        let options = ["--bridge-every", "48", "--count-from", from];
        run(name, end, &sound(end), &json!(host.steps), &options)
    };
    Some([
        ("LDBB, armed", of("ldbb", bar, "0.015", 0.1)?),
        (
            "a setting set, saved, status asked",
            of("saved", saving(), "0.1", 0.25)?,
        ),
        (
            "the same where the store is full: a page is erased",
            of("used", used, "0.1", 0.25)?,
        ),
    ])
}

#[test]
fn passes_of_the_main_loop_are_short() {
    if made_by_another_compiler("board_duties") {
        return;
    }
    let Some(all) = on_the_link() else { return };
    let mut passes_ms = Vec::new();
    let mut table = "| | longest pass | longest with interrupts masked | watchdog unfed while the flash is busy |\n|---|---:|---:|---:|\n"
        .to_owned();
    for (name, seen) in &all {
        let longest = longest(&seen.program, &seen.trace, setup(Form::Most), LOOP);
        let unfed_ms = 1e3 * seen.run["longest_unfed_s"].as_f64().expect("a number");
        // Writing to a String cannot fail.
        let _ = writeln!(
            table,
            "| {name} | {:.2} ms | {:.1} µs | {unfed_ms:.1} ms |",
            1e-3 * us(longest.pass),
            us(longest.masked)
        );
        passes_ms.push(1e-3 * us(longest.pass));
        // The model's own time has the flash's, not the instructions': at the watchdog's shortest.
        assert!(unfed_ms + 1e-3 * us(longest.pass) < 94.0, "{name}");
    }
    let [armed_ms, saved_ms, used_ms] = passes_ms[..] else {
        unreachable!("one for each");
    };
    // The deadline of a duty.
    let deadline_ms = 0.0..=10.0;
    holds(
        "board passes: LDBB, armed, ms",
        armed_ms,
        deadline_ms.clone(),
    );
    holds(
        "board passes: a setting is saved, ms",
        saved_ms,
        deadline_ms.clone(),
    );
    holds(
        "board passes: a setting is saved in a full store, ms",
        used_ms,
        deadline_ms,
    );
    all_judged("board passes");
    let [(_, bar), saved @ ..] = &all;
    let done = |(_, m): &&(_, Telemetry)| matches!(m, Telemetry::Reply(reply) if reply.answer == Answer::Done);
    // Taken, started, alive, armed.
    assert_eq!(
        bar.frames.iter().filter(done).count(),
        4,
        "{:?}",
        bar.frames
    );
    let kept = |(_, m): &&(_, Telemetry)| {
        matches!(m, Telemetry::Reply(reply)
            if matches!(reply.answer, Answer::Setting(s) if s.stored == Some(s.value)))
    };
    for (name, saved) in saved {
        let kept = saved.frames.iter().filter(kept).count();
        assert_eq!(kept, 2, "{name}: {:?}", saved.frames);
    }
    println!("{table}");
    page::nearly_holds("docs/flash.md", "board-passes", &table);
}
