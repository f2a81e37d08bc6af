//! The registers of the image for the NUCLEO-G474RE, judged by others' data: what it makes of the
//! chip is what its design says, and whatever configuration write is changed, something notices.
//!
//! The register file and every run's findings are the model's (tools/g474-model/registers.py);
//! the tests of `board_image` fail on a finding too.

use firmware::boards::nucleo_g474re::wiring::PINS;
use host_tests::board_model::{Host, NOBODYS, mutants, refused, run};
use rarma_box::guard::Mode;
use rarma_box::wire::Command as Word;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use xtask::page::Part;

const EXPECTED: &str = include_str!("board_registers.json");
const SURVIVORS: &str = include_str!("board_survivors.json");
const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/flash.md");

/// Noise, as codes.
fn noise(seconds: f64) -> Vec<u16> {
    let mut seed = 3u32;
    (0..(seconds * 48_000.0) as usize)
        .map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            16_000 + (seed >> 22) as u16
        })
        .collect()
}

/// What every pin and part is set to is what a committed file says in the design's units, and
/// every pin of the wiring page leads where the page says.
#[test]
fn the_chip_is_set_up_as_designed() {
    let options = ["--bridge-every", "48"];
    let Some(seen) = run("the_chip", 0.03, &noise(0.03), &json!([]), &options) else {
        return;
    };
    let facts = &seen.run["facts"];
    if std::env::var_os("RARMA_WRITE_TABLE").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/board_registers.json");
        let text = serde_json::to_string_pretty(facts).expect("it came as JSON");
        std::fs::write(path, text + "\n").expect("the tests' folder takes files");
        return;
    }
    let expected: Value = serde_json::from_str(EXPECTED).expect("a committed file of JSON");
    let (seen_facts, expected) = (facts.as_object(), expected.as_object());
    let (seen_facts, expected) = (seen_facts.expect("facts"), expected.expect("facts"));
    for (name, wanted) in expected {
        assert_eq!(seen_facts.get(name), Some(wanted), "{name}");
    }
    assert_eq!(seen_facts.len(), expected.len(), "{seen_facts:#?}");
    let analogue = facts["PA0 to PB15, analogue"].as_str().expect("pins");
    for pin in PINS {
        let set = facts[pin.pin].as_str().unwrap_or("");
        let wanted = pin.function.split(',').next().unwrap_or(pin.function);
        let leads = if set.is_empty() {
            analogue.split(' ').any(|name| name == pin.pin)
        } else {
            set.starts_with(wanted)
        };
        assert!(leads, "{}: wanted {wanted}, set to {set:?}", pin.pin);
    }
}

/// What is no image for this chip, and no register file of this model, is refused in one line.
#[test]
fn what_the_model_cannot_use_is_refused_in_one_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("the temporary folder takes files");
        path.display().to_string()
    };
    // An ELF file of 32 bits for ARM with one part, where the emulated board has its flash.
    let mut other = vec![0u8; 88];
    other[..7].copy_from_slice(b"\x7fELF\x01\x01\x01");
    other[18] = 40;
    other[28] = 52;
    other[42] = 32;
    other[44] = 1;
    other[52] = 1;
    other[56] = 84;
    other[68] = 4;
    let host = std::env::current_exe().expect("this test has a program");
    let host = host.display().to_string();
    let old = r#"{"format":1,"chip":"stm32g474re","made_from":{"stm32g4":"0.15.1"}}"#;
    for (arguments, wanted) in [
        (vec![file("other", &other)], "an image for another chip?"),
        (vec![host], "not of 32 bits for ARM"),
        (vec![file("text", b"image")], "no ELF file"),
        (vec![file("cut", &other[..60])], "ends within its header"),
        (
            vec!["".into(), "--registers".into(), "/nowhere".into()],
            "no register file",
        ),
        (
            vec!["".into(), "--registers".into(), file("cut.json", b"{")],
            "is broken",
        ),
        (
            vec![
                "".into(),
                "--registers".into(),
                file("old.json", old.as_bytes()),
            ],
            "made from",
        ),
        (
            vec!["".into(), "--microphone-1".into(), file("odd", &[1, 2, 3])],
            "ends within",
        ),
        (
            vec!["".into(), "--script".into(), file("script", b"[[0.1,")],
            "is broken",
        ),
    ] {
        let Some(said) = refused("refused", &arguments) else {
            return;
        };
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.contains(wanted), "{said}");
    }
}

/// A run that drives coils, and what can happen after it.
fn scene() -> Value {
    let driven = 0.17;
    let mut host = Host::default();
    host.steps = vec![json!([0.0, "PA6", 1]), json!([0.0, "PC8", 1])];
    for pulse in 1..17 {
        host.steps
            .push(json!([0.01 * f64::from(pulse), "tacho", 1]));
    }
    host.say(0.015, Word::Take { turn: NOBODYS });
    host.say(0.016, Word::Stream { seconds: 0.02 });
    host.say(0.06, Word::Start(Mode::Cers));
    host.say(0.062, Word::Heartbeat);
    host.say(0.064, Word::Arm);
    host.say(0.15, Word::Heartbeat);
    host.say(0.165, Word::Status);
    let script = host.steps.clone();
    let mut valve = host.clone();
    valve.steps.clear();
    valve.say(0.171, Word::Stop);
    valve.say(0.173, Word::Start(Mode::Ldbb));
    valve
        .steps
        .extend([json!([0.174, "PC8", 0]), json!([0.235, "PC8", 1])]);
    valve.say(0.23, Word::Heartbeat);
    valve.say(0.24, Word::Arm);
    valve.say(0.33, Word::Pressure { pa: 2e5 });
    valve.say(0.34, Word::Heartbeat);
    let at = 0.170_005;
    let short = 0.1705;
    let mut events = json!({
        "stop": [short, [[at, "PA6", 0]]],
        "supply": [short, [[at, "supply-low", 1]]],
        "crystal": [0.172, [[at, "crystal-fails", 1]]],
        "memory": [0.172, [[at, "flash-fails", 0x0804_1238]]],
        "brown-out": [0.2, [[at, "reset", "brown-out"]]],
        "debugger": [0.3, [[at, "halt", 1]]],
        "valve": [0.38, valve.steps],
    });
    for pin in ["PB1", "PB0", "PB13", "PB14"] {
        events[pin] = json!([short, [[at, pin, 3.1]]]);
    }
    json!({"seconds": driven, "driven_from": 0.06, "script": script, "events": events})
}

/// Mutants that nothing notices, by the reason.
fn survivors() -> BTreeMap<String, Vec<String>> {
    serde_json::from_str(SURVIVORS).expect("a committed file of JSON")
}

/// Every mutant of a part of them is killed, or is listed as one that may live, and why.
fn judged(name: &str, part: &str) -> Option<Vec<Value>> {
    let found = mutants(name, &noise(0.4), &scene(), part)?;
    let listed: Vec<String> = survivors().into_values().flatten().collect();
    let text = |mutant: &Value| mutant["mutant"].as_str().expect("a name").to_owned();
    let mut wrong = Vec::new();
    for mutant in found
        .iter()
        .filter(|mutant| mutant.get("killed_by").is_some())
    {
        let is_listed = listed.contains(&text(mutant));
        match (mutant["killed_by"].as_str(), is_listed) {
            (None, false) => wrong.push(format!("{}: nothing notices", text(mutant))),
            (Some(by), true) => wrong.push(format!("{}: listed, but {by}", text(mutant))),
            _ => {}
        }
    }
    for name in &listed {
        if !found.iter().any(|mutant| text(mutant) == *name) {
            wrong.push(format!("{name}: listed, but there is no such mutant"));
        }
    }
    for mutant in &found {
        let by = mutant.get("killed_by");
        println!("{} -> {}: {by:?}", text(mutant), mutant["instead"]);
    }
    assert!(wrong.is_empty(), "{}: {wrong:#?}", wrong.len());
    Some(found)
}

/// The page's table: accesses by source, mutants by what killed them.
fn table(found: &[Value], run: &Value) -> String {
    let judged = &run["judged"];
    let number = |name: &str| judged["accesses"][name].to_string();
    let source = |name: &str| judged["sources"][name].as_str().unwrap_or("?").to_owned();
    let mut text = format!(
        "| judged in a start and 0.1 s | by | accesses | findings |\n|---|---|---:|---:|\n\
         | a register that exists, its access, reserved bits, listed values: reads | `stm32g4` {} | {} | {} |\n\
         | the same: writes | the same | {} | |\n\
         | clock and reset of its peripheral | `stm32-metapac` {} | {} | |\n\
         | registers of the core | ours | {} | |\n\
         | registers touched | | {} | |\n\n",
        source("stm32g4"),
        number("read"),
        judged["findings"].as_array().map_or(0, Vec::len),
        number("written"),
        source("stm32-metapac"),
        number("clocks"),
        number("core"),
        judged["registers"],
    );
    let mut killed = BTreeMap::<String, usize>::new();
    for mutant in found {
        let by = mutant["killed_by"].as_str().unwrap_or("nothing: listed");
        let by = by.split(':').next().unwrap_or(by);
        *killed.entry(by.to_owned()).or_default() += 1;
    }
    text += "| mutants of configuration writes | number |\n|---|---:|\n";
    text += &format!("| all | {} |\n", found.len());
    for (by, count) in killed {
        text += &format!("| noticed by {by} | {count} |\n");
    }
    text += "\n| why nothing notices | number | which |\n|---|---:|---|\n";
    for (why, names) in survivors() {
        text += &format!("| {why} | {} | `{}` |\n", names.len(), names.join("`, `"));
    }
    text
}

#[test]
fn every_configuration_write_matters() {
    judged("every_configuration_write", "0/16");
}

#[test]
#[ignore = "long: cargo verify --long"]
fn every_configuration_write_matters_long() {
    let Some(found) = judged("every_configuration_write", "0/1") else {
        return;
    };
    let Some(seen) = run("registers", 0.1, &noise(0.1), &json!([]), &[]) else {
        return;
    };
    let table = table(&found, &seen.run);
    println!("{table}");
    let page = std::fs::read_to_string(PAGE).expect("the page is there");
    let part = Part("registers");
    if std::env::var_os("RARMA_WRITE_TABLE").is_some() {
        let page = part
            .written_into(&page, &table)
            .expect("the page has the markers");
        std::fs::write(PAGE, page).expect("the page can be written");
    }
}
