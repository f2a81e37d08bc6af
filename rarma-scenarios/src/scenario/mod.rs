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
mod file;
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
pub use cers::{CersScenario, MOST_DUTY, SHIPPED_CERS, cers_schema, load_cers, parse_cers};
pub use cers_parts::Calibrated;
pub use cers_record::{parse_record, read_cers, record_schema};
pub use els::{ElsScenario, SHIPPED_ELS, els_schema, load_els, parse_els};
pub use ldbb::{LdbbScenario, SHIPPED_LDBB, ldbb_schema, load_ldbb, parse_ldbb};
pub use listen::BoxHints;

use crate::error::ScenarioError;
use rarma_core::condition::Band;
use rarma_plants::cut::Scenario;
use reader::{Allowed, Refusal, Section};
use serde_json::{Value, json};

/// The shipped scenarios: name and text.
pub const SHIPPED: [(&str, &str); 12] = [
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
        "override-turned",
        include_str!("../../scenarios/override-turned.toml"),
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

impl Loaded {
    /// The band its box listens to.
    pub fn band(&self) -> Band {
        self.hints
            .band
            .unwrap_or_else(|| Band::usual(self.scenario.microphone.sample_rate_hz))
    }
}

/// A scenario from a file, or a shipped one by name; `seed` wins over the file's.
///
/// # Errors
/// One line: file, line, field, what is allowed.
pub fn load(name: &str, seed: Option<u64>) -> Result<Loaded, ScenarioError> {
    parse(name, &file::text(name, &SHIPPED)?, seed)
}

/// A scenario from its text; `file` is what messages call it.
///
/// # Errors
/// As [`load`].
pub fn parse(file: &str, text: &str, seed: Option<u64>) -> Result<Loaded, ScenarioError> {
    let loaded = file::parse(file, text, &schema(), |root| read(root, seed))?;
    rarma_plants::cut::VirtualCut::new(&loaded.scenario).map_err(|why| file::whole(file, why))?;
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
