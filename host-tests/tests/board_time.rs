//! How much of its core the image for the NUCLEO-G474RE takes: what the unmodified image executes on
//! the model of its chip, through the model of its time (`xtask::chip::timing`). The table stands in
//! docs/flash.md; `RARMA_WRITE_TABLE=1` writes it.

use host_tests::bars::{all_judged, holds};
use host_tests::board_model::{Host, NOBODYS, Seen, made_by_another_compiler, run};
use host_tests::page;
use rarma_box::guard::Mode;
use rarma_box::settings::{MONITOR_ORDER, MONITOR_SPINDLE, SettingValue};
use rarma_box::wire::Command as Word;
use rarma_core::Order;
use serde_json::json;
use std::fmt::Write as _;
use xtask::arm_image::ArmImage;
use xtask::chip::figures;
use xtask::chip::profile::{self, by_function};
use xtask::chip::schedule::longest;
use xtask::chip::timing::{Form, Setup, Taken, run as through};

/// The core, Hz.
const CORE_HZ: f64 = 163.2e6;
/// What was asked for, percent of the core; what keeps up at all.
const ASKED: f64 = 55.0;
const ALL: f64 = 100.0;
/// The exception of the current loop, which rests here.
const LOOP: u32 = 16 + 47;

#[test]
fn what_the_core_takes_for_its_samples() {
    if made_by_another_compiler("board_time") {
        return;
    }
    let mut table =
        "| order | speed | instructions a sample | cycles of one, no waiting | as set up | \
        without prefetch | longest pass |\n|---|---|---:|---:|---:|---:|---:|\n"
            .to_owned();
    for (order, told, most) in [
        ((4, 3), false, ALL),
        ((4, 3), true, ALL),
        ((8, 7), false, ASKED),
        ((8, 7), true, ASKED),
    ] {
        let Some(load) = load(order, told) else {
            return;
        };
        let speed = if told { "told" } else { "not told" };
        let of = format!("({},{}), speed {speed}", order.0, order.1);
        let [least, full] = load.as_set_up;
        // Writing to a String cannot fail.
        let _ = writeln!(
            table,
            "| ({},{}) | {speed} | {:.0} | {:.2} to {:.2} | {least:.0} to {full:.0} % | to {:.0} % | {:.0} µs |",
            order.0, order.1, load.instructions, load.own[0], load.own[1], load.bare, load.pass_us
        );
        assert!(least < full && full < load.bare, "{of}: waiting takes time");
        holds(
            &format!("board time: % of the core, {of}"),
            full,
            0.0..=most,
        );
    }
    println!("{table}");
    all_judged("board time");
    page::nearly_holds("docs/flash.md", "board-time", &table);
}

/// What an order takes: the least and the most by the manual, where there are two.
struct Load {
    /// Instructions a sample.
    instructions: f64,
    /// Cycles of an instruction with memory that never waits.
    own: [f64; 2],
    /// Percent of the core as the image sets the flash up, and at the most without prefetch.
    as_set_up: [f64; 2],
    bare: f64,
    /// The longest from a wake to the next sleep, at the most, µs.
    pass_us: f64,
}

/// None where the model is not to be had.
fn load(order: (usize, usize), told: bool) -> Option<Load> {
    let seen = listens(order, told)?;
    let samples = seen.run["counted_samples"].as_f64().expect("a number");
    let part = |cycles: u64| 100.0 * cycles as f64 / samples * 48_000.0 / CORE_HZ;
    let setup = |prefetch, form| Setup { prefetch, form };
    let of = |prefetch, form| through(&seen.program, &seen.trace, setup(prefetch, form));
    let both = [Form::Least, Form::Most].map(|form| of(true, form));
    let instructions = seen.trace.instructions() as f64;
    if told {
        let image = ArmImage::read(&seen.image).expect("the image was read before");
        let shares = by_function(&image, &seen.program, &seen.trace, setup(true, Form::Most));
        let all = shares.iter().map(|share| share.taken);
        let all = all.fold(Taken::default(), |sum, taken| sum + taken);
        assert_eq!(all, both[1], "every cycle is some function's");
        println!(
            "({},{}), speed told:\n{}",
            order.0,
            order.1,
            profile::markdown(&shares, samples)
        );
    }
    let longest = longest(&seen.program, &seen.trace, setup(true, Form::Most), LOOP);
    Some(Load {
        instructions: instructions / samples,
        own: both.map(|t| (t.cycles - t.waited - t.waited_for_data) as f64 / instructions),
        as_set_up: both.map(|taken| part(taken.cycles)),
        bare: part(of(false, Form::Most).cycles),
        pass_us: 1e6 * longest.pass as f64 / CORE_HZ,
    })
}

/// The image listens to noise with a resonance.
fn listens((p, q): (usize, usize), told: bool) -> Option<Seen> {
    let place = Order::ALL.iter().position(|o| (o.p(), o.q()) == (p, q));
    let order = SettingValue::Whole(place.expect("the box has it") as u32);
    let hz = SettingValue::Real(if told { 27.6 } else { 0.0 });
    let mut host = Host::default();
    host.say(0.01, Word::Take { turn: NOBODYS });
    for (at, setting, value) in [
        (0.012, MONITOR_ORDER.number(), order),
        (0.014, MONITOR_SPINDLE.number(), hz),
    ] {
        host.say(at, Word::Set { setting, value });
    }
    host.say(0.016, Word::Start(Mode::Monitor));
    let codes = figures::sound(1.6);
    let options = ["--bridge-every", "48", "--count-from", "1.5"];
    run("board_time", 1.6, &codes, &json!(host.steps), &options)
}
