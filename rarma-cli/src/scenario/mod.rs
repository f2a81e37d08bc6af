//! Scenarios of the virtual machine tool: TOML files, and the shipped ones.
//!
//! Units are in the names, as a machinist says them; the plants get SI. What is
//! wrong with a file is said in one line: file, line, field, what is allowed.

mod at_work;
mod cers;
mod cers_parts;
mod cers_record;
mod els;
mod els_parts;
mod ldbb;
mod ldbb_parts;
mod listen;
mod process;
mod reader;
mod shared;
mod turning;
mod value;
mod work;

pub use at_work::{AtWork, BOX_SHIPPED, box_schema, load_box, parse_box};
pub use cers::{
    Calibrated, CersScenario, MOST_DUTY, SHIPPED_CERS, cers_schema, load_cers, parse_cers,
};
pub use cers_record::read_cers;
pub use els::{ElsScenario, SHIPPED_ELS, els_schema, load_els, parse_els};
pub use ldbb::{LdbbScenario, SHIPPED_LDBB, ldbb_schema, load_ldbb, parse_ldbb};
pub use listen::BoxHints;

use crate::failure::Failure;
use hal_sim::plant::cut::Scenario;
use reader::{Allowed, Refusal, Section, Text, unknown};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use toml::de::DeTable;

/// The shipped scenarios: name and text.
pub const SHIPPED: [(&str, &str); 11] = [
    (
        "chatter-onset",
        include_str!("../../scenarios/chatter-onset.toml"),
    ),
    (
        "three-mode-resonance",
        include_str!("../../scenarios/three-mode-resonance.toml"),
    ),
    (
        "three-mode-chatter",
        include_str!("../../scenarios/three-mode-chatter.toml"),
    ),
    (
        "spindle-10000",
        include_str!("../../scenarios/spindle-10000.toml"),
    ),
    (
        "slotted-workpiece",
        include_str!("../../scenarios/slotted-workpiece.toml"),
    ),
    (
        "slender-bar",
        include_str!("../../scenarios/slender-bar.toml"),
    ),
    (
        "damped-bar",
        include_str!("../../scenarios/damped-bar.toml"),
    ),
    (
        "turning-980",
        include_str!("../../scenarios/turning-980.toml"),
    ),
    (
        "two-tooth-benchmark",
        include_str!("../../scenarios/two-tooth-benchmark.toml"),
    ),
    (
        "two-tooth-up",
        include_str!("../../scenarios/two-tooth-up.toml"),
    ),
    (
        "helix-run-up",
        include_str!("../../scenarios/helix-run-up.toml"),
    ),
];

/// A scenario, and what its file says beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The cut.
    pub scenario: Scenario,
    /// What it shows, in a line.
    pub about: String,
    /// Settings of the box.
    pub hints: BoxHints,
}

/// A scenario from a file, or a shipped one by name; `seed` wins over the file's.
///
/// # Errors
/// One line: file, line, field, what is allowed.
pub fn load(name: &str, seed: Option<u64>) -> Result<Loaded, Failure> {
    if let Some((_, text)) = SHIPPED.iter().find(|(n, _)| *n == name) {
        return parse(name, text, seed);
    }
    let text = fs::read_to_string(Path::new(name)).map_err(|why| {
        let names: Vec<&str> = SHIPPED.iter().map(|(n, _)| *n).collect();
        Failure::Input(format!(
            "{name}: open: {} (a TOML file, or one of {})",
            why.to_string().to_lowercase(),
            names.join(", ")
        ))
    })?;
    parse(name, &text, seed)
}

/// A scenario from its text; `file` is what messages call it.
///
/// # Errors
/// As [`load`].
pub fn parse(file: &str, text: &str, seed: Option<u64>) -> Result<Loaded, Failure> {
    let lines = Text(text);
    let table = DeTable::parse(text).map_err(|why| {
        let line = why.span().map_or(1, |span| lines.line(&span));
        let what = why.message().lines().next().unwrap_or_default();
        Failure::Input(format!("{file}: line {line}: not TOML: {what}"))
    })?;
    let refused =
        |r: Refusal| Failure::Input(format!("{file}: line {}: {} {}", r.line, r.field, r.what));
    // Unknown names first: a misspelt field is not a missing one.
    if let Some(refusal) = unknown(lines, table.get_ref(), &schema()) {
        return Err(refused(refusal));
    }
    let mut root = Section::root(lines, table.get_ref());
    let loaded = read(&mut root, seed).map_err(refused)?;
    // What the plants themselves would refuse, and no single field shows.
    hal_sim::plant::cut::VirtualCut::new(&loaded.scenario)
        .map_err(|why| Failure::Input(format!("{file}: whole file: {why}")))?;
    Ok(loaded)
}

fn read(root: &mut Section<'_>, seed: Option<u64>) -> Result<Loaded, Refusal> {
    let name = root.words("name", "Name of the scenario")?;
    let about = root.words("about", "What it shows, in a line")?;
    let duration_s = root.number(
        "duration_s",
        Allowed::within(0.05, 3600.0),
        None,
        "Length of the recording, s",
    )?;
    let own = root.whole("seed", (0, i64::MAX), Some(1), "Seed of everything random")?;
    let seed = seed.unwrap_or(own as u64);
    let scenario = Scenario {
        name,
        process: process::process(root, seed)?,
        microphone: listen::microphone(root, seed.wrapping_add(1))?,
        duration_s,
    };
    let hints = listen::hints(root)?;
    if !root.describes() {
        work::check(root, &scenario)?;
    }
    Ok(Loaded {
        scenario,
        about,
        hints,
    })
}

/// JSON schema of a scenario file, from the same calls that read it.
pub fn schema() -> Value {
    let mut root = Section::description();
    // A description answers every question: there is nothing to refuse.
    let _ = read(&mut root, None);
    let mut schema = root.schema();
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("Scenario of the virtual machine tool");
    schema["oneOf"] = json!([{ "required": ["milling"] }, { "required": ["turning"] }]);
    schema
}
