//! Tests of `rarma ldbb run`: TOML files beside the scenarios, read the same way.

use super::reader::{Allowed, Refusal, Section, Text, unknown};
use super::shared::N_PER_UM;
use crate::failure::Failure;
use crate::ldbb::Conditions;
use hal_sim::plant::ldbb::{AirConfig, Around, BenchConfig, GaugeConfig, Geometry, MachineConfig};
use rarma_core::ldbb::{ForceLaw, Inclination, ProcedureConfig, Setting};
use serde_json::{Value, json};
use std::fs;
use toml::de::DeTable;

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
pub fn load_ldbb(name: &str) -> Result<LdbbScenario, Failure> {
    if let Some((_, text)) = SHIPPED_LDBB.iter().find(|(n, _)| *n == name) {
        return parse_ldbb(name, text);
    }
    let text = fs::read_to_string(name).map_err(|why| {
        let names: Vec<&str> = SHIPPED_LDBB.iter().map(|(n, _)| *n).collect();
        Failure::Input(format!(
            "{name}: open: {} (a TOML file, or one of {})",
            why.to_string().to_lowercase(),
            names.join(", ")
        ))
    })?;
    parse_ldbb(name, &text)
}

/// A test from its text; `file` is what messages call it.
///
/// # Errors
/// As [`load_ldbb`].
pub fn parse_ldbb(file: &str, text: &str) -> Result<LdbbScenario, Failure> {
    let lines = Text(text);
    let table = DeTable::parse(text).map_err(|why| {
        let line = why.span().map_or(1, |span| lines.line(&span));
        let what = why.message().lines().next().unwrap_or_default();
        Failure::Input(format!("{file}: line {line}: not TOML: {what}"))
    })?;
    let refused =
        |r: Refusal| Failure::Input(format!("{file}: line {}: {} {}", r.line, r.field, r.what));
    if let Some(refusal) = unknown(lines, table.get_ref(), &ldbb_schema()) {
        return Err(refused(refusal));
    }
    read(&mut Section::root(lines, table.get_ref())).map_err(refused)
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
const STIFFNESS: Allowed = Allowed::above(0.0, 1e4);
const SMALL_UM: Allowed = Allowed::within(-500.0, 500.0);
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
        return Err(root.refuse("forces_n", "does not rise from force to force"));
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
        Err(why) => return Err(root.refuse("inclination_deg", format!("does not go: {why}"))),
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
    let defaults = ProcedureConfig::default();
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
            // Dither would shake loose the friction whose hysteresis is sought.
            dither_s: if down { 0.0 } else { defaults.dither_s },
            ..defaults
        },
        settings,
        both,
        down,
        directions_rad: directions.iter().map(|d| d.to_radians()).collect(),
    })
}

fn gauge(s: &mut Section<'_>) -> Result<GaugeConfig, Refusal> {
    let d = GaugeConfig::default();
    Ok(GaugeConfig {
        noise_m: 1e-6
            * s.number(
                "noise_um",
                Allowed::within(0.0, 50.0),
                Some(1e6 * d.noise_m),
                "Noise, standard deviation, µm",
            )?,
        step_m: 1e-6
            * s.number(
                "step_um",
                Allowed::within(0.0, 50.0),
                Some(1e6 * d.step_m),
                "Steps of the reading, µm",
            )?,
        bar_m_per_n: 1e-6
            * s.number(
                "bar_um_per_n",
                Allowed::within(0.0, 1.0),
                Some(0.0),
                "Compliance of the bar and its joints, µm/N",
            )?,
    })
}

fn machine(s: &mut Section<'_>) -> Result<MachineConfig, Refusal> {
    let mean = s.number(
        "mean_n_per_um",
        STIFFNESS,
        Some(11.8),
        "Mean stiffness, N/µm",
    )?;
    let most = extreme(
        s,
        "most",
        "Largest stiffness, N/µm, and its direction, degrees",
    )?;
    let least = extreme(
        s,
        "least",
        "Smallest stiffness, N/µm, and its direction, degrees",
    )?;
    let stiffness = match (most, least) {
        (Some(a), Some(b)) => Around::through(N_PER_UM * mean, a, b).map_err(|_| {
            s.refuse(
                "most",
                "and least are not the extremes of any smooth course",
            )
        })?,
        _ => Around::constant(N_PER_UM * mean),
    };
    let hysteresis = s.number(
        "hysteresis_um",
        SMALL_UM,
        Some(0.0),
        "Width of the hysteresis, mean over the directions, µm",
    )?;
    let wave = s.number(
        "hysteresis_wave_um",
        SMALL_UM,
        Some(0.0),
        "It is this much wider towards 0°, µm",
    )?;
    let standing = s.number(
        "standing_percent",
        Allowed::within(0.0, 100.0),
        Some(0.0),
        "Compliance while standing beyond that while moving, mean, percent",
    )?;
    let curvature = s.number(
        "curvature_per_kn",
        Allowed::within(-1.0, 1.0),
        Some(0.0),
        "Deflection c·F·(1 + q·F), q in 1/kN",
    )?;
    let tilt = s.number(
        "per_inclination",
        Allowed::within(-0.9, 10.0),
        Some(0.0),
        "Stiffness grows by this part times the sine of the inclination",
    )?;
    let pitch = s.number(
        "pitch_mm",
        Allowed::within(1.0, 100.0),
        Some(10.0),
        "Pitch of cyclic errors, mm",
    )?;
    let unloaded = s.table("errors", "Geometric errors without load", errors)?;
    let growth = s.table(
        "errors_per_kn",
        "What is added to them for every kN",
        errors,
    )?;
    let ideal = MachineConfig::ideal(N_PER_UM * mean);
    Ok(MachineConfig {
        pitch_m: 1e-3 * pitch,
        geometry: unloaded.unwrap_or_default(),
        per_newton: Geometry::default().grown(&growth.unwrap_or_default(), 1e-3),
        stiffness_n_per_m: stiffness,
        standing: Around::constant(0.01 * standing),
        curvature_per_n: 1e-3 * curvature,
        hysteresis_m: Around {
            mean: 1e-6 * hysteresis,
            waves: [(1e-6 * wave, 0.0), (0.0, 0.0), (0.0, 0.0)],
        },
        per_inclination: tilt,
        ..ideal
    })
}

fn extreme(
    s: &mut Section<'_>,
    field: &'static str,
    doc: &str,
) -> Result<Option<(f64, f64)>, Refusal> {
    let pair = s.numbers(field, Allowed::within(-360.0, 1e4), doc)?;
    match pair[..] {
        [k, deg] if k > 0.0 => Ok(Some((N_PER_UM * k, deg.to_radians()))),
        [] => Ok(None),
        _ if s.describes() => Ok(None),
        _ => Err(s.refuse(field, "is no pair of stiffness and angle")),
    }
}

fn errors(s: &mut Section<'_>) -> Result<Geometry, Refusal> {
    let mut pair = |a: &'static str, b: &'static str, doc: &str, unit: f64| {
        Ok([
            unit * s.number(a, SMALL_UM, Some(0.0), doc)?,
            unit * s.number(b, SMALL_UM, Some(0.0), doc)?,
        ])
    };
    Ok(Geometry {
        centre_m: pair(
            "centre_x_um",
            "centre_y_um",
            "Centre off the ball, µm",
            1e-6,
        )?,
        scale: pair(
            "scale_x_um_m",
            "scale_y_um_m",
            "Scale error of an axis, µm/m",
            1e-6,
        )?,
        bow_m: pair(
            "straightness_x_um",
            "straightness_y_um",
            "Bow of an axis, µm",
            1e-6,
        )?,
        backlash_m: pair("backlash_x_um", "backlash_y_um", "Backlash, µm", 1e-6)?,
        play_m: pair("play_x_um", "play_y_um", "Lateral play, µm", 1e-6)?,
        lag_s: pair("lag_x_ms", "lag_y_ms", "Servo lag, ms", 1e-3)?,
        cyclic_m: pair("cyclic_x_um", "cyclic_y_um", "Cyclic error, µm", 1e-6)?,
        spike_m: pair(
            "spike_x_um",
            "spike_y_um",
            "Spike after a reversal, µm",
            1e-6,
        )?,
        squareness_rad: 1e-6
            * s.number(
                "squareness_urad",
                SMALL_UM,
                Some(0.0),
                "Squareness, µrad; positive: more than 90°",
            )?,
        ..Geometry::default()
    })
}
