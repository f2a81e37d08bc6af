//! Tests of `rarma ldbb run`: TOML files beside the scenarios, read the same way.

use super::file;
use super::ldbb_parts::{gauge, machine};
use super::reader::{Allowed, Refusal, Section};
use crate::error::ScenarioError;
use rarma_plants::ldbb::{AirConfig, BenchConfig, MachineConfig};
use rarma_recordings::input::Conditions;
use rarma_rigs::ldbb::{ForceLaw, Inclination, ProcedureConfig, Setting};
use serde_json::{Value, json};

/// The shipped tests: name and text.
pub const SHIPPED_LDBB: [(&str, &str); 3] = [
    ("ldbb-m3", include_str!("../../scenarios/ldbb-m3.toml")),
    ("ldbb-m5", include_str!("../../scenarios/ldbb-m5.toml")),
    ("ldbb-weak", include_str!("../../scenarios/ldbb-weak.toml")),
];

/// A test and the machine it is made on.
#[derive(Debug, Clone, PartialEq)]
pub struct LdbbScenario {
    /// What it shows, in a line.
    pub about: String,
    /// Under which conditions.
    pub conditions: Conditions,
    /// Machine, bar and air.
    pub bench: BenchConfig,
    /// The circle.
    pub procedure: ProcedureConfig,
    /// What is set for each force.
    pub settings: Vec<Setting<f64>>,
    /// Clockwise runs as well.
    pub both: bool,
    /// Down again.
    pub down: bool,
    /// Directions of the static test, rad.
    pub directions_rad: Vec<f64>,
}

/// A test from a file, or a shipped one by name.
///
/// # Errors
/// One line: file, line, field, what is allowed.
pub fn load_ldbb(name: &str) -> Result<LdbbScenario, ScenarioError> {
    parse_ldbb(name, &file::text(name, &SHIPPED_LDBB)?)
}

/// A test from its text; `file` is what messages call it.
///
/// # Errors
/// As [`load_ldbb`].
pub fn parse_ldbb(file: &str, text: &str) -> Result<LdbbScenario, ScenarioError> {
    file::parse(file, text, &ldbb_schema(), read)
}

/// JSON schema of a test's file, from the same calls that read it.
pub fn ldbb_schema() -> Value {
    let mut root = Section::description();
    // A description answers every question: there is nothing to refuse.
    let _ = read(&mut root);
    let mut schema = root.schema();
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("Test of rarma ldbb");
    schema
}

const ANGLE_DEG: Allowed = Allowed::within(-360.0, 720.0);
const PLANES: [&str; 3] = ["XY", "YZ", "ZX"];

fn read(root: &mut Section<'_>) -> Result<LdbbScenario, Refusal> {
    let name = root.words("name", "Name of the machine")?;
    let about = root.words("about", "What the test shows, in a line")?;
    let plane = root.choice("plane", &PLANES, false, "Plane of the circle")?;
    let feed = root.number(
        "feed_mm_min",
        Allowed::within(100.0, 10_000.0),
        Some(1000.0),
        "Feed of the level test, mm/min",
    )?;
    let length = root.number(
        "length_mm",
        Allowed::within(50.0, 600.0),
        Some(150.0),
        "Length from ball to ball, mm",
    )?;
    let inclination = root.number(
        "inclination_deg",
        Allowed::within(-80.0, 80.0),
        Some(0.0),
        "Inclination of the bar above the plane, degrees",
    )?;
    let along = root.flag(
        "force_along_bar",
        false,
        "Keep the force along an inclined bar, not its part in the plane",
    )?;
    let weight = root.number(
        "weight_n",
        Allowed::within(0.0, 100.0),
        Some(0.0),
        "Weight of the bar on its upper ball, N",
    )?;
    let forces = root.numbers(
        "forces_n",
        Allowed::within(20.0, 2000.0),
        "Forces of the level test, N, rising; left out: the eight of 0.4 and 1 to 7 bar",
    )?;
    let most = root.number(
        "regulator_bar",
        Allowed::within(1.0, 20.0),
        Some(9.0),
        "Greatest pressure of the regulator, bar",
    )?;
    let both = root.flag("both_directions", true, "Clockwise runs as well")?;
    let down = root.flag("down", true, "Down again, for the hysteresis while moving")?;
    let directions = root.numbers(
        "directions_deg",
        ANGLE_DEG,
        "Directions of the static test, degrees; none: no static test",
    )?;
    let seed = root.whole(
        "seed",
        (0, i64::from(u32::MAX)),
        Some(1),
        "Seed of the noise",
    )?;
    let machine = root.table("machine", "The machine", machine)?;
    let gauge = root.table("gauge", "The gauge and the bar", gauge)?;
    let friction = root.number(
        "seal_n",
        Allowed::within(0.0, 50.0),
        Some(1.5),
        "Friction of the cylinder's seal, N",
    )?;
    let law = ForceLaw::<f64>::standard();
    let forces = if forces.is_empty() {
        [0.4, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]
            .map(|bar| law.force_n(1e5 * bar))
            .to_vec()
    } else {
        forces
    };
    if !root.describes() && forces.windows(2).any(|w| w[1] <= w[0]) {
        return Err(root.refuse(
            "forces_n",
            "does not rise (allowed: every force above the one before)",
        ));
    }
    let incline = Inclination {
        angle_rad: inclination.to_radians(),
        length_m: 1e-3 * length,
        feed_m_s: feed / 6e4,
        weight_n: weight,
        in_plane: !along,
    };
    let settings: Result<Vec<_>, _> = forces
        .iter()
        .map(|f| incline.setting(&law, *f, 1e5 * most))
        .collect();
    let settings = match settings {
        Ok(s) => s,
        Err(_) if root.describes() => Vec::new(),
        Err(why) => {
            return Err(root.refuse(
                "inclination_deg",
                format!("does not go: {why} (allowed: an angle and forces that the bar can hold)"),
            ));
        }
    };
    let first = settings.first().copied().unwrap_or(Setting {
        radius_m: 0.15,
        feed_m_s: 1.0 / 60.0,
        force_n: 36.4,
        in_plane_n: 36.4,
        pressure_pa: 4e4,
    });
    let mut machine = machine.unwrap_or_else(|| MachineConfig::ideal(11.8e6));
    machine.radius_m = first.radius_m;
    let mut defaults = ProcedureConfig::default();
    if down {
        defaults = defaults.with_way_down();
    }
    Ok(LdbbScenario {
        about,
        conditions: Conditions {
            machine: name,
            plane: PLANES[plane].to_owned(),
            radius_m: first.radius_m,
            feed_m_s: first.feed_m_s,
            inclination_rad: incline.angle_rad,
        },
        bench: BenchConfig {
            machine,
            air: AirConfig {
                friction_n: friction,
                span_pa: 1e5 * most,
                ..AirConfig::default()
            },
            gauge: gauge.unwrap_or_default(),
            inclination_rad: incline.angle_rad,
            seed: seed as u64,
        },
        procedure: ProcedureConfig {
            radius_m: first.radius_m as f32,
            feed_m_s: first.feed_m_s as f32,
            lead_s: (f64::from(defaults.trigger_m) / first.feed_m_s + 0.5) as f32,
            holding_pa: law.pressure_pa(36.0) as f32,
            ..defaults
        },
        settings,
        both,
        down,
        directions_rad: directions.iter().map(|d| d.to_radians()).collect(),
    })
}
