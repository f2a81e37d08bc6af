//! Systems of `rarma els`: TOML files beside the scenarios, read the same way.

use super::els_parts::{STIFFNESS, cut, link, ring, segment};
use super::file;
use super::reader::{Allowed, Refusal, Section};
use super::shared::{MM, N_PER_UM};
use crate::error::ScenarioError;
use rarma_plants::els::beam::{Segment, Theory};
use rarma_plants::els::link::{Link, LinkLaw};
use rarma_plants::els::{Clamping, ElsConfig};
use rarma_rigs::els::CutConfig;
use serde_json::{Value, json};

/// The shipped systems: name and text.
pub const SHIPPED_ELS: [(&str, &str); 3] = [
    (
        "els-holder",
        include_str!("../../scenarios/els-holder.toml"),
    ),
    (
        "els-load-bar",
        include_str!("../../scenarios/els-load-bar.toml"),
    ),
    (
        "els-short-tool",
        include_str!("../../scenarios/els-short-tool.toml"),
    ),
];

/// A system and what is asked of it.
#[derive(Debug, Clone, PartialEq)]
pub struct ElsScenario {
    /// Its name.
    pub name: String,
    /// What it shows, in a line.
    pub about: String,
    /// The system.
    pub config: ElsConfig,
    /// Loads of the frequencies, N.
    pub loads_n: Vec<f64>,
    /// Loads of the deflections, N.
    pub deflection_loads_n: Vec<f64>,
    /// Place half-way up the holder, m from the tool joint.
    pub middle_m: f64,
    /// Modes shown.
    pub modes: usize,
    /// Top of the receptance, Hz.
    pub top_hz: f64,
    /// Cutting coefficients.
    pub cut: CutConfig<f64>,
    /// From the force to the chip thickness, rad.
    pub chip_angle_rad: f64,
}

/// A system from a file, or a shipped one by name.
///
/// # Errors
/// One line: file, line, field, what is allowed.
pub fn load_els(name: &str) -> Result<ElsScenario, ScenarioError> {
    parse_els(name, &file::text(name, &SHIPPED_ELS)?)
}

/// A system from its text; `file` is what messages call it.
///
/// # Errors
/// As [`load_els`].
pub fn parse_els(file: &str, text: &str) -> Result<ElsScenario, ScenarioError> {
    let out = file::parse(file, text, &els_schema(), read)?;
    out.config
        .validate()
        .map_err(|why| file::whole(file, why))?;
    Ok(out)
}

/// JSON schema of a system's file, from the same calls that read it.
pub fn els_schema() -> Value {
    let mut root = Section::description();
    // A description answers every question: there is nothing to refuse.
    let _ = read(&mut root);
    let mut schema = root.schema();
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("System of rarma els");
    schema
}

/// Nodes of a system at most: five coordinates each, in dense matrices.
const MOST_NODES: usize = 100;
const PER_NODE: f64 = 5.0;
/// Loads at most.
const MOST_LOADS: usize = 100;
/// Cube of the coordinates times the top of the receptance, Hz, at most: a minute or so.
const MOST_WORK: f64 = 1e11;
const LOAD_N: Allowed = Allowed::within(0.0, 1e5);

fn read(root: &mut Section<'_>) -> Result<ElsScenario, Refusal> {
    let name = root.words("name", "Name of the system")?;
    let about = root.words("about", "What it shows, in a line")?;
    let holder = root.tables(
        "holder",
        "Tool and holder from the tool joint upward: round stretches",
        segment,
    )?;
    let spindle = root.tables(
        "spindle",
        "Spindle from its nose upward; without it the holder's upper end is fixed",
        segment,
    )?;
    let joints = root.tables(
        "joint",
        "Rings of springs between holder and spindle",
        |s| {
            let at = s.number(
                "at_mm",
                Allowed::within(0.0, 2000.0),
                None,
                "Place on the holder from the tool joint, mm",
            )?;
            let on = s.number(
                "spindle_at_mm",
                Allowed::within(0.0, 2000.0),
                None,
                "Place on the spindle from its nose, mm",
            )?;
            Ok((at * MM, on * MM, ring(s)?))
        },
    )?;
    let bearings = root.tables("bearing", "Bearings of the spindle", |s| {
        let at = s.number(
            "at_mm",
            Allowed::within(0.0, 2000.0),
            None,
            "Place on the spindle from its nose, mm",
        )?;
        Ok((at * MM, ring(s)?))
    })?;
    let link = root.table("link", "Elastic link at the tool joint", link)?;
    let tool_joint = root.number(
        "tool_joint_n_per_um",
        STIFFNESS,
        Some(1e6),
        "Stiffness of the tool joint itself, N/µm",
    )?;
    let slender = root.flag("slender", false, "Beams without shear and rotary inertia")?;
    let loads_n = root.numbers("loads_n", LOAD_N, "Loads of the frequencies, N")?;
    let deflection_loads_n =
        root.numbers("deflection_loads_n", LOAD_N, "Loads of the deflections, N")?;
    let length_m: f64 = holder.iter().map(|s| s.length_m).sum();
    let middle = root.number(
        "middle_mm",
        Allowed::within(0.0, 2000.0),
        Some(0.0),
        "Place on the holder whose deflection is shown, mm from the tool joint; 0: half-way",
    )?;
    let modes = root.whole("modes", (1, 40), Some(6), "Modes shown")?;
    let top_hz = root.number(
        "top_hz",
        Allowed::within(100.0, 50_000.0),
        Some(4000.0),
        "Top of the receptance, Hz",
    )?;
    let cut = root.table("cut", "What is cut", cut)?;
    if !root.describes() {
        for (list, field) in [
            (holder.is_empty(), "holder"),
            (loads_n.is_empty(), "loads_n"),
        ] {
            if list {
                return Err(root.refuse(field, "is missing (allowed: at least one)"));
            }
        }
        let nodes = |s: &[Segment]| 1 + s.iter().map(|s| s.elements).sum::<usize>();
        let places = nodes(&holder) + nodes(&spindle) + 2 * joints.len() + bearings.len();
        if places > MOST_NODES {
            let what = format!(
                "has {places} nodes with spindle, joints and bearings (allowed: up to {MOST_NODES}; fewer elements)"
            );
            return Err(root.refuse("holder", what));
        }
        let conditions = loads_n.len() + deflection_loads_n.len();
        if conditions > MOST_LOADS {
            let what = format!(
                "has {conditions} entries with those of the deflections (allowed: up to {MOST_LOADS})"
            );
            return Err(root.refuse("loads_n", what));
        }
        let work = (PER_NODE * places as f64).powi(3) * top_hz;
        if work > MOST_WORK {
            let what = format!(
                "is {top_hz} (allowed: up to {:.0} with {places} nodes)",
                top_hz * MOST_WORK / work
            );
            return Err(root.refuse("top_hz", what));
        }
        if spindle.is_empty() && !(joints.is_empty() && bearings.is_empty()) {
            return Err(root.refuse(
                "spindle",
                "is missing (allowed: at least one table [[spindle]] beside joint or bearing)",
            ));
        }
    }
    let clamping = if spindle.is_empty() {
        Clamping::Fixed
    } else {
        Clamping::Spindle {
            segments: spindle,
            joints,
            bearings,
        }
    };
    let (cut, chip_angle_rad) = cut.unwrap_or((CutConfig::orthogonal(2e9), 0.0));
    Ok(ElsScenario {
        name,
        about,
        config: ElsConfig {
            holder,
            clamping,
            link: link.unwrap_or(Link {
                law: LinkLaw::Constant(0.0),
                across: 0.0,
                angle_rad: 0.0,
                loss: 0.0,
            }),
            tool_joint_n_per_m: tool_joint * N_PER_UM,
            theory: if slender {
                Theory::EulerBernoulli
            } else {
                Theory::Timoshenko
            },
        },
        deflection_loads_n: if deflection_loads_n.is_empty() {
            loads_n.iter().copied().filter(|n| *n > 0.0).collect()
        } else {
            deflection_loads_n
        },
        loads_n,
        middle_m: if middle > 0.0 {
            middle * MM
        } else {
            0.5 * length_m
        },
        modes: modes as usize,
        top_hz,
        cut,
        chip_angle_rad,
    })
}
