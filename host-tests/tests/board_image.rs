//! The unmodified image for the NUCLEO-G474RE on a model of its chip: it boots, samples,
//! writes frames that the host decodes, hears what the host itself hears in the same codes,
//! and its outputs fall with the break input.

use firmware::boards::nucleo_g474re::scaling;
use firmware::monitor::MonitorDuty;
use host_tests::board_model::{Host, SESSION, SETTINGS_AT, SETTINGS_BYTES, Seen, run};
use rarma_box::guard::{FaultCode, Severity};
use rarma_box::settings::Settings;
use rarma_box::wire::{FaultMessage, Head, Identity, Started, Telemetry};
use serde_json::{Value, json};

/// Noise through a resonance at 900 Hz that loses its damping at `onset_s`, as codes.
fn cut(seconds: f64, onset_s: f64) -> Vec<u16> {
    let fs = 48_000.0;
    let (mut seed, mut y1, mut y2) = (7u32, 0.0f64, 0.0f64);
    (0..(seconds * fs) as usize)
        .map(|n| {
            let zeta = if (n as f64) < onset_s * fs {
                0.03
            } else {
                0.0002
            };
            let w = std::f64::consts::TAU * 900.0 / fs;
            let r = (-zeta * w).exp();
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(seed >> 8) / 8_388_608.0 - 1.0;
            let y = 20.0 * noise + 2.0 * r * w.cos() * y1 - r * r * y2;
            (y2, y1) = (y1, y);
            (16_380.0 + y).clamp(0.0, 32_760.0) as u16
        })
        .collect()
}

fn verdicts(frames: impl IntoIterator<Item = Telemetry>) -> Vec<Telemetry> {
    let heard =
        |message: &Telemetry| matches!(message, Telemetry::Verdict(_) | Telemetry::Alarm(_));
    frames.into_iter().filter(heard).collect()
}

/// One source, one arithmetic: image and host give the same verdicts, bit by bit.
#[test]
fn the_image_hears_what_the_host_hears() {
    let (seconds, codes) = (2.0, cut(2.0, 1.0));
    let options = ["--bridge-every", "48"];
    let Some(seen) = run("the_image_hears", seconds, &codes, &json!([]), &options) else {
        return;
    };
    assert_eq!(seen.run["reset_by"], Value::Null);
    // The stack cannot reach the program below it: 20 KiB, at both addresses of that memory.
    let program = |at: u64| (0..5).map(move |k| json!([at + 0x1000 * k, 0x1000]));
    let parts: Vec<Value> = program(0x1000_0000).chain(program(0x2001_8000)).collect();
    assert_eq!(seen.run["read_only"], json!(parts));
    let sequence: Vec<u32> = seen.frames.iter().map(|(head, _)| head.sequence).collect();
    let expected: Vec<u32> = (0..sequence.len() as u32).collect();
    assert_eq!(sequence, expected, "frames are numbered without a gap");
    // The number that the chip's generator gave.
    assert!(seen.frames.iter().all(|(head, _)| head.session == SESSION));

    let job = firmware::listen::job(&Settings::default(), 48_000.0);
    let mut host = MonitorDuty::new(&job).expect("the default settings are in range");
    let mut said = Vec::new();
    for &code in &codes {
        host.samples(&[scaling::microphone(code)], &mut |message| {
            said.push(message.clone())
        });
    }
    let image = verdicts(seen.frames.into_iter().map(|(_, message)| message));
    let host = verdicts(said);
    // The last samples are still on their way when the model stops.
    assert!(image.len() + 1 >= host.len() && image.len() <= host.len());
    assert!(image.len() > 10, "{}", image.len());
    assert_eq!(image, host[..image.len()]);
    assert!(
        image
            .iter()
            .any(|message| matches!(message, Telemetry::Alarm(_))),
        "the lost damping is called"
    );
}

/// The clock tree and the converters make 48 kHz of the registers that the image wrote.
#[test]
fn samples_come_at_their_rate() {
    let Some(seen) = run(
        "samples_come",
        0.5,
        &[],
        &json!([]),
        &["--bridge-every", "48"],
    ) else {
        return;
    };
    let trace = seen.run["trace"].as_array().expect("a list");
    let sampling = trace.iter().find(|step| step["kind"] == "sampling");
    assert_eq!(sampling.expect("it samples")["value"], 3400);
    let samples = seen.run["samples"].as_u64().expect("a number");
    assert!((23_990..=24_000).contains(&samples), "{samples}");
}

/// Steps that bring CERS to its bias.
fn armed(seconds: f64) -> Vec<Value> {
    Host::armed(seconds, &[], None).steps
}

/// When the outputs went on first, and how and when they went off after that.
fn on_and_off(run: &Value) -> (f64, Option<(f64, String)>) {
    let trace = run["trace"].as_array().expect("a list");
    let mut outputs = trace.iter().filter(|step| step["kind"] == "outputs");
    let moment = |step: &Value| step["s"].as_f64().expect("a number");
    // The timer's driver sets the master enable before any output is enabled.
    let on = outputs
        .find(|step| step["value"] == 1)
        .expect("the outputs go on");
    let off = outputs.find(|step| step["value"] == 0);
    let off = off.map(|step| (moment(step), step["name"].as_str().unwrap_or("").to_owned()));
    assert!(
        outputs.next().is_none(),
        "what is off stays off: {trace:#?}"
    );
    (moment(on), off)
}

fn told(frames: &[(Head, Telemetry)], code: FaultCode) -> bool {
    frames
        .iter()
        .any(|(_, message)| matches!(message, Telemetry::Fault(fault) if fault.record.code == code))
}

/// A moment with coils driven, between two conversions of their currents: at one of them the
/// loop itself would see a current that trips a comparator.
const BETWEEN_S: f64 = 0.200_005;

/// What opens the switches, when, and what the host is told of it.
fn drops(name: &str, event: (&str, Value), by: &str, code: Option<FaultCode>) {
    let (pressed, end) = (BETWEEN_S, 0.23);
    let mut steps = armed(end);
    steps.push(json!([pressed, event.0, event.1]));
    let Some(seen) = run(name, end, &[], &json!(steps), &[]) else {
        return;
    };
    let (on, off) = on_and_off(&seen.run);
    // Armed at 0.03 s; 50 ms of a steady supply, 20 ms for the zeros.
    assert!((0.09..0.13).contains(&on), "{name}: on at {on} s");
    let (off, how) = off.unwrap_or_else(|| panic!("{name}: the outputs stay on"));
    assert_eq!(how, by, "{name}");
    // One PWM period: a break is no matter of software.
    assert!(
        (pressed..pressed + 21e-6).contains(&off),
        "{name}: off at {off} s"
    );
    if let Some(code) = code {
        assert!(told(&seen.frames, code), "{name}: {:?}", seen.frames);
    }
}

#[test]
fn the_emergency_stop_opens_all_switches_without_software() {
    let stop = Some(FaultCode::EmergencyStop);
    drops("emergency_stop", ("PA6", json!(0)), "break", stop);
}

#[test]
fn a_comparator_opens_all_switches_without_software() {
    for pin in ["PB1", "PB0", "PB13", "PB14"] {
        let comparator = Some(FaultCode::Comparator);
        drops(pin, (pin, json!(3.1)), "break", comparator);
    }
}

/// The supply's monitor: the timer breaks by itself, the power stage follows.
#[test]
fn a_falling_supply_opens_all_switches_without_software() {
    drops(
        "supply",
        ("supply-low", json!(1)),
        "break",
        Some(FaultCode::Bridge),
    );
}

/// What is shorter than a break's filter breaks nothing, what is longer does.
#[test]
fn spikes_break_nothing() {
    // A line of 256 ticks for the stop, 64 for the comparators (163.2 MHz).
    for (pin, bad, good, filter_s) in [
        ("PA6", json!(0), json!(1), 256.0 / 163.2e6),
        ("PB0", json!(3.1), Value::Null, 64.0 / 163.2e6),
    ] {
        let (at, end) = (BETWEEN_S, 0.22);
        for (lasts_s, breaks) in [(0.9 * filter_s, false), (1.1 * filter_s, true)] {
            let mut steps = armed(end);
            steps.push(json!([at, pin, bad]));
            steps.push(json!([at + lasts_s, pin, good]));
            let Some(seen) = run("spikes", end, &[], &json!(steps), &[]) else {
                return;
            };
            let (_, off) = on_and_off(&seen.run);
            assert_eq!(off.is_some(), breaks, "{pin} {lasts_s:e} s");
            if let Some((off, how)) = off {
                assert_eq!(how, "break", "{pin}");
                let waited = off - at;
                let one_tick = 1.0 / 163.2e6;
                assert!((waited - filter_s).abs() <= 2.0 * one_tick, "{waited:e} s");
            }
        }
    }
}

/// Whatever stands where settings are, the box starts: every page is erased if need be, each
/// takes 24.5 ms, and the watchdog waits 94 ms at the worst (its oscillator at 34 kHz).
#[test]
fn spoilt_settings_do_not_outlast_the_watchdog() {
    let mut seed = 1u32;
    let garbage = (0..SETTINGS_BYTES).map(|_| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 24) as u8
    });
    let all: [(&str, Vec<u8>); 2] = [
        ("garbage", garbage.collect()),
        ("zeros", vec![0; SETTINGS_BYTES]),
    ];
    for (name, bytes) in all {
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let steps = json!([[0.0, "flash-holds", [SETTINGS_AT, hex]]]);
        let Some(seen) = run(name, 0.6, &[], &steps, &["--bridge-every", "48"]) else {
            return;
        };
        assert_eq!(seen.run["reset_by"], Value::Null, "{name}");
        let trace = seen.run["trace"].as_array().expect("a list");
        let erases = trace.iter().filter(|step| step["kind"] == "erase").count();
        assert!(erases >= 16, "{name}: {erases} erases");
        let unfed_s = seen.run["longest_unfed_s"].as_f64().expect("a number");
        assert!((0.024..0.03).contains(&unfed_s), "{name}: {unfed_s} s");
        let is_heard = |(_, m): &(Head, Telemetry)| matches!(m, Telemetry::Verdict(_));
        assert!(seen.frames.iter().any(is_heard), "{name}: it listens");
    }
}

/// The option byte that nobody has set is told to who starts a rig, and not once it is set.
#[test]
fn a_brown_out_level_that_protects_nothing_is_told() {
    // BOR_LEV in bits 8 to 10.
    for (options, low) in [(0xFFEF_F8AA_u32, true), (0xFFEF_FCAA, false)] {
        let mut steps = armed(0.06);
        steps.push(json!([0.0, "options", options]));
        let Some(seen) = run("options", 0.06, &[], &json!(steps), &[]) else {
            return;
        };
        assert_eq!(told(&seen.frames, FaultCode::BrownOutLow), low);
    }
}

/// The last `Hello`, and what is told after it.
fn after_reset(seen: &Seen) -> (&Identity, Vec<&FaultMessage>) {
    let is_hello = |(_, message): &(Head, Telemetry)| matches!(message, Telemetry::Hello(_));
    let last = seen.frames.iter().rposition(is_hello).expect("a hello");
    let (before, after) = seen.frames.split_at(last);
    assert!(before.iter().any(is_hello), "the box has started once");
    let sessions: Vec<u32> = [before, after]
        .iter()
        .flat_map(|run| run.iter().map(|(head, _)| head.session))
        .collect();
    let changes = sessions.windows(2).filter(|pair| pair[0] != pair[1]);
    assert_eq!(changes.count(), 1, "a reset is a session of its own");
    let faults = after.iter().filter_map(|(_, message)| match message {
        Telemetry::Fault(fault) => Some(fault),
        _ => None,
    });
    let Telemetry::Hello(hello) = &after[0].1 else {
        unreachable!("the position of one");
    };
    (hello, faults.collect())
}

/// Something ends the program while coils are driven: the switches open within `within_s`,
/// and after the reset the box says why.
fn ends(
    name: &str,
    event: (&str, Value),
    (by, within_s): (&str, f64),
    (started, code): (Started, FaultCode),
) -> Option<Seen> {
    let moment = 0.2;
    let end = moment
        + if started == Started::Watchdog {
            0.2
        } else {
            0.05
        };
    let mut steps = armed(moment);
    steps.push(json!([moment, event.0, event.1]));
    let seen = run(name, end, &[], &json!(steps), &["--resets", "1"])?;
    let (on, off) = on_and_off(&seen.run);
    // Armed at 0.03 s; 50 ms of a steady supply, 20 ms for the zeros.
    assert!((0.09..0.13).contains(&on), "{name}: on at {on} s");
    let (off, how) = off.unwrap_or_else(|| panic!("{name}: the outputs stay on"));
    assert_eq!(how, by, "{name}");
    let limits = moment..moment + within_s;
    assert!(limits.contains(&off), "{name}: off at {off} s");
    let (hello, faults) = after_reset(&seen);
    assert_eq!(hello.started, started, "{name}");
    let latched = faults.iter().find(|fault| fault.record.code == code);
    let latched = latched.unwrap_or_else(|| panic!("{name}: told {faults:?}"));
    assert_eq!(latched.severity, Severity::Trip, "{name}");
    assert_eq!(seen.run["reset_by"], Value::Null, "{name}: it runs again");
    Some(seen)
}

/// One PWM period, s.
const PERIOD_S: f64 = 21e-6;

/// The handler of a fault of the core switches off before it does anything else, and what it
/// keeps is told after the reset.
#[test]
fn a_hard_fault_opens_all_switches_and_is_told_after_the_reset() {
    let cause = (Started::Software, FaultCode::HardFault);
    for (name, number) in [("hard_fault", 3), ("unbound_interrupt", 16 + 5)] {
        let event = ("exception", json!(number));
        let Some(seen) = ends(name, event, ("software", PERIOD_S), cause) else {
            return;
        };
        let before = after_reset(&seen).0.before.expect("kept across the reset");
        assert_eq!(before.code, FaultCode::HardFault);
        assert!((190_000..210_000).contains(&before.at_us), "{before:?}");
    }
}

#[test]
fn a_program_that_hangs_is_let_go_by_the_loop_and_reset_by_the_watchdog() {
    let cause = (Started::Watchdog, FaultCode::Watchdog);
    let event = ("hang", json!(1));
    let Some(seen) = ends("hang", event, ("software", 3.5e-3), cause) else {
        return;
    };
    let trace = seen.run["trace"].as_array().expect("a list");
    let reset = trace.iter().find(|step| step["kind"] == "reset");
    let at = reset.expect("a reset")["s"].as_f64().expect("a number");
    assert!((0.295..0.305).contains(&at), "reset at {at} s");
}

/// A crystal that stops: the timer breaks by itself, and the core lives to say so.
#[test]
fn a_crystal_that_stops_opens_all_switches_and_is_told_after_the_reset() {
    let cause = (Started::Software, FaultCode::ClockFailed);
    let event = ("crystal-fails", json!(1));
    ends("crystal", event, ("break", PERIOD_S), cause);
}

/// A debugger that halts the core opens the switches; the watchdog goes on and takes the rest.
#[test]
fn a_debugger_that_halts_the_core_opens_all_switches() {
    let cause = (Started::Watchdog, FaultCode::Watchdog);
    let event = ("halt", json!(1));
    ends("halt", event, ("debugger", PERIOD_S), cause);
}

#[test]
fn a_brown_out_is_told_after_it() {
    let cause = (Started::BrownOut, FaultCode::BrownOut);
    ends(
        "brown_out",
        ("reset", json!("brown-out")),
        ("reset", PERIOD_S),
        cause,
    );
}

/// A double error of the flash where the program is: it cannot be trusted.
#[test]
fn flash_that_fails_under_the_program_opens_all_switches() {
    let cause = (Started::Software, FaultCode::MemoryError);
    let event = ("flash-fails", json!(0x0804_1238));
    let Some(seen) = ends("flash_fails", event, ("break", PERIOD_S), cause) else {
        return;
    };
    let before = after_reset(&seen).0.before.expect("kept across the reset");
    assert_eq!(before.value, 0x4_1238 as f32);
}

/// A double error of the flash where settings are: told, and the box goes on.
#[test]
fn a_spoilt_word_of_the_settings_is_told() {
    for (spoilt, expected) in [(0x0807_8000, true), (0x0807_7FF8, false)] {
        let steps = json!([[0.0, "spoilt", spoilt]]);
        let Some(seen) = run("spoilt_word", 0.1, &[], &steps, &["--bridge-every", "48"]) else {
            return;
        };
        assert_eq!(seen.run["reset_by"], Value::Null);
        assert_eq!(told(&seen.frames, FaultCode::FlashUnreadable), expected);
        let is_heard = |(_, m): &(Head, Telemetry)| matches!(m, Telemetry::Verdict(_));
        assert!(seen.frames.iter().any(is_heard), "it listens");
    }
}
