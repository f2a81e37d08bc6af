//! Measurements of `rarma cers run`: TOML files beside the scenarios, read the same way.
//!
//! What the rig may not do is refused here, before a coil is energised even in simulation.

use super::cers_parts::{Calibrated, Known, excitation, magnets, spindle};
use super::file;
use super::reader::{Allowed, Refusal, Section};
use crate::cers::{Commands, Drive, needed_volts};
use crate::error::ScenarioError;
use rarma_plants::cers::ExciterConfig;
use serde_json::{Value, json};

/// The shipped measurements: name and text.
pub const SHIPPED_CERS: [(&str, &str); 3] = [
    ("cers-rest", include_str!("../../scenarios/cers-rest.toml")),
    (
        "cers-turning",
        include_str!("../../scenarios/cers-turning.toml"),
    ),
    (
        "cers-sweep",
        include_str!("../../scenarios/cers-sweep.toml"),
    ),
];

/// Largest part of a period that a switch may be on.
pub const MOST_DUTY: f64 = 0.95;

/// A measurement and the rig it is made on.
#[derive(Debug, Clone, PartialEq)]
pub struct CersScenario {
    /// Name of the structure.
    pub name: String,
    /// What it shows, in a line.
    pub about: String,
    /// Length of the record, s.
    pub seconds: f64,
    /// Seed of noise and calibration.
    pub seed: u64,
    /// Bias of every coil, A.
    pub bias_a: f64,
    /// Inductance the regulator is tuned for, H.
    pub inductance_h: f64,
    /// Resistance of a coil, Ω.
    pub resistance_ohm: f64,
    /// The excitation.
    pub drive: Drive,
    /// Speed of the spindle at the start and at the end, revolutions/s.
    pub spindle_hz: (f64, f64),
    /// How the magnets were calibrated.
    pub calibrated: Calibrated,
    /// Bands of the tracks of a sweep, Hz.
    pub tracks_hz: Vec<(f64, f64)>,
    /// The plant.
    pub plant: ExciterConfig,
}

/// A measurement from a file, or a shipped one by name.
///
/// # Errors
/// One line: file, line, field, what is allowed.
pub fn load_cers(name: &str) -> Result<CersScenario, ScenarioError> {
    parse_cers(name, &file::text(name, &SHIPPED_CERS)?)
}

/// A measurement from its text; `file` is what messages call it.
///
/// # Errors
/// As [`load_cers`].
pub fn parse_cers(file: &str, text: &str) -> Result<CersScenario, ScenarioError> {
    file::parse(file, text, &cers_schema(), read)
}

/// JSON schema of a measurement's file, from the same calls that read it.
pub fn cers_schema() -> Value {
    let mut root = Section::description();
    // A description answers every question: there is nothing to refuse.
    let _ = read(&mut root);
    let mut schema = root.schema();
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("Measurement of rarma cers");
    schema
}

fn read(root: &mut Section<'_>) -> Result<CersScenario, Refusal> {
    let name = root.words("name", "Name of the structure")?;
    let about = root.words("about", "What the measurement shows, in a line")?;
    let seconds = root.number(
        "seconds",
        Allowed::within(0.5, 300.0),
        Some(3.3),
        "Length of the record, s; rounded up to whole blocks",
    )?;
    let seed = root.whole(
        "seed",
        (0, i64::from(u32::MAX)),
        Some(1),
        "Seed of noise and calibration",
    )? as u64;
    let supply = root.number(
        "supply_v",
        Allowed::within(6.0, 200.0),
        Some(48.0),
        "Supply of the amplifiers, V",
    )?;
    let bias = root.number(
        "bias_a",
        Allowed::within(0.05, 20.0),
        Some(0.8),
        "Bias of every coil, A",
    )?;
    let tracks = root.numbers(
        "tracks_hz",
        Allowed::within(50.0, 4500.0),
        "Bands of the tracks over the speed, low and high by turns, Hz",
    )?;
    let excitation = root.table("excitation", "What is superposed on the bias", excitation)?;
    let mut drive = excitation.unwrap_or_default();
    let spindle = root.table("spindle", "The spindle's speed", spindle)?;
    let (from, to, lines) = spindle.unwrap_or((0.0, 0.0, Vec::new()));
    let magnets = root.table("magnets", "Coils, gaps and what is known of them", magnets)?;
    let known = magnets.unwrap_or_default();
    drive.dodge_hz = if from == to { from } else { 0.0 };
    if !root.describes() {
        within_limits(root, &known, &drive, supply, bias)?;
        if tracks.chunks(2).any(|b| b.len() != 2 || b[1] <= b[0]) {
            return Err(root.refuse(
                "tracks_hz",
                "is no list of bands (allowed: low and high by turns, each band rising)",
            ));
        }
    }
    let mut plant = ExciterConfig {
        substeps: 8,
        supply_v: supply,
        gap_m: known.gap_m,
        ..ExciterConfig::default()
    };
    // Gaps that are not what they are thought to be, current sensors with gain errors.
    for (coil, off) in plant.coils.iter_mut().zip([4e-6, -3e-6, 2e-6, -5e-6]) {
        coil.gap_error_m = off;
        coil.resistance_ohm = known.resistance_ohm;
    }
    if !lines.is_empty() {
        plant.bearing_lines = lines;
    }
    plant.sensors.current_gain_error = [0.01, -0.008, 0.006, -0.01];
    Ok(CersScenario {
        name,
        about,
        seconds,
        seed,
        bias_a: bias,
        inductance_h: known.inductance_h,
        resistance_ohm: known.resistance_ohm,
        drive,
        spindle_hz: (from, to),
        calibrated: known.calibrated,
        tracks_hz: tracks.chunks_exact(2).map(|b| (b[0], b[1])).collect(),
        plant,
    })
}

/// Bias and excitation against supply and iron.
fn within_limits(
    root: &Section<'_>,
    known: &Known,
    drive: &Drive,
    supply: f64,
    bias: f64,
) -> Result<(), Refusal> {
    let has = MOST_DUTY * supply;
    let needs = bias * known.resistance_ohm;
    if needs > has {
        return Err(root.refuse(
            "bias_a",
            format!(
                "is {bias}: {:.1} Ω need {needs:.1} V, the supply of {supply} V gives {has:.1} V (allowed: what the supply can drive)",
                known.resistance_ohm
            ),
        ));
    }
    // Made once: with gaps for the spindle's orders that takes a tenth of a second.
    let commands = Commands::new(drive, 1);
    let peak = commands.peak_a();
    if peak > bias {
        return Err(root.refuse(
            "bias_a",
            format!(
                "is {bias}: the excitation's peak of {peak:.2} A exceeds it, a coil would reach zero and the force be rectified (allowed: a bias above that peak)"
            ),
        ));
    }
    let magnet = rarma_rigs::cers::Geometry::<f64>::textbook().magnet();
    let flux = magnet.force(bias + peak, known.gap_m).flux_part;
    if flux > rarma_rigs::cers::TRUSTED_PART {
        return Err(root.refuse(
            "bias_a",
            format!(
                "is {bias}: with the excitation {:.2} A take the iron to {flux:.2} of its knee, the force is trusted up to {} (allowed: less bias_a or rms_a)",
                bias + peak,
                rarma_rigs::cers::TRUSTED_PART
            ),
        ));
    }
    let volts = needed_volts(&commands, bias, known.inductance_h, known.resistance_ohm);
    if volts > has {
        return Err(root.refuse(
            "excitation",
            format!(
                "needs {volts:.1} V at its peak, the supply of {supply} V gives {has:.1} V (less rms_a, or a lower high_hz)"
            ),
        ));
    }
    Ok(())
}
