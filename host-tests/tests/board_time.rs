//! How much of its core the image for the NUCLEO-G474RE takes, waiting for the flash included: the
//! blocks that the unmodified image executes on the model of its chip, through a model of the
//! flash's accelerator (`xtask::chip::accelerator`). The table stands in docs/flash.md.

use host_tests::bars::{all_judged, holds};
use host_tests::board_model::{Host, NOBODYS, run};
use rarma_core::Order;
use rarma_core::guard::Mode;
use rarma_core::settings::{MONITOR_ORDER, MONITOR_SPINDLE, SettingValue};
use rarma_core::wire::Command as Word;
use serde_json::json;
use xtask::chip::accelerator::{Setup, Taken, halfword, program, run as through};
use xtask::chip::figures;

/// Cycles of an instruction with memory that never waits: ARM's table, the upper end of every
/// range, in the mean over the whole chain (README, the emulated chip).
const CYCLES_PER_INSTRUCTION: f64 = 1.7;
/// The core, Hz.
const CORE_HZ: f64 = 163.2e6;
/// What was asked for, percent of the core; what keeps up at all.
const ASKED: f64 = 55.0;
const ALL: f64 = 100.0;

/// The figures belong to a compiler, as those of the page do (`cargo xtask chip`).
fn made_by_another_compiler() -> bool {
    let elf = std::env::var_os("RARMA_BOARD_ELF").and_then(|path| std::fs::read(path).ok());
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/flash.md"));
    let compiler = figures::Figures::compiler_in(&page.expect("the page is there"));
    let said = compiler.expect("it names its compiler");
    let said = said.replace("rustc ", "rustc version ");
    let other = elf.is_some_and(|elf| !elf.windows(said.len()).any(|at| at == said.as_bytes()));
    if other {
        eprintln!(
            "SKIPPED: board_time: docs/flash.md has the figures of {said}, the image is another's"
        );
    }
    other
}

#[test]
fn what_the_core_takes_for_its_samples() {
    if made_by_another_compiler() {
        return;
    }
    println!("| order | speed | instructions a sample | never waits | as set up | no prefetch |");
    println!("|---|---|---:|---:|---:|---:|");
    for (order, told, most) in [
        ((4, 3), false, ALL),
        ((4, 3), true, ALL),
        ((8, 7), false, ASKED),
        ((8, 7), true, ASKED),
    ] {
        let Some((instructions, [bare, with, without])) = load(order, told) else {
            return;
        };
        let speed = if told { "told" } else { "not told" };
        let of = format!("({},{}), speed {speed}", order.0, order.1);
        println!(
            "| ({},{}) | {speed} | {instructions:.0} | {bare:.0} % | {with:.0} % | {without:.0} % |",
            order.0, order.1
        );
        assert!(bare < with && with < without, "{of}: waiting takes time");
        holds(
            &format!("board time: % of the core, {of}"),
            with,
            0.0..=most,
        );
    }
    all_judged("board time");
}

/// Instructions a sample, and percent of the core: with memory that never waits, as the image sets
/// the flash up, without prefetch. None where the model is not to be had.
fn load((p, q): (usize, usize), told: bool) -> Option<(f64, [f64; 3])> {
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
    let codes: Vec<u16> = figures::sound(1.6)
        .chunks_exact(2)
        .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
        .collect();
    let options = ["--bridge-every", "48", "--count-from", "1.5"];
    let seen = run("board_time", 1.6, &codes, &json!(host.steps), &options)?;
    let elf = std::env::var_os("RARMA_BOARD_ELF").expect("it has run");
    let flash = program(&std::fs::read(elf).expect("it has run")).expect("an image");
    let samples = seen.run["counted_samples"].as_f64().expect("a number");
    let taken = |prefetch| -> Taken {
        let setup = Setup {
            prefetch,
            cycles_per_instruction: CYCLES_PER_INSTRUCTION,
        };
        let blocks = seen.blocks.iter().copied();
        through(blocks, |at| halfword(&flash, at), setup)
    };
    let (with, without) = (taken(true), taken(false));
    let counted = seen.run["counted_instructions"].as_u64();
    assert_eq!(Some(with.instructions), counted, "every block was seen");
    let instructions = with.instructions as f64 / samples;
    let part = |cycles: f64| 100.0 * cycles / samples * 48_000.0 / CORE_HZ;
    let bare = with.instructions as f64 * CYCLES_PER_INSTRUCTION;
    let parts = [bare, with.cycles, without.cycles].map(part);
    Some((instructions, parts))
}
