//! What a machine can do, as a test found it.

use super::name::Name;
use serde::{Deserialize, Serialize};

/// Stiffness and machine errors, of the loaded ball bar.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stiffness {
    /// Plane of the circle, for instance `XY`.
    pub plane: Name,
    /// Radius of the circle, mm.
    pub radius_mm: f64,
    /// Inclination of the bar out of the plane, degrees.
    #[serde(default)]
    pub inclination_deg: f64,
    /// Stiffness by direction.
    pub directions: Vec<DirectionStiffness>,
    /// Relative deviation that all directions have in common (the gain of the force), 1.
    #[serde(default)]
    pub scale_sd: f64,
    /// Loops by direction, where the test came down again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hysteresis: Vec<Hysteresis>,
    /// Errors of the machine at one force.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub errors: Vec<MachineError>,
}

/// Stiffness in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DirectionStiffness {
    /// Direction in the plane, degrees from its first axis.
    pub angle_deg: f64,
    /// Stiffness, N/µm.
    pub n_per_um: f64,
    /// Its standard deviation without the common part, N/µm.
    pub sd_n_per_um: f64,
}

/// The loop of one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Hysteresis {
    /// Direction, degrees.
    pub angle_deg: f64,
    /// Widest place of the loop, µm.
    pub um: f64,
    /// Its standard deviation, µm; 0 where it was not estimated.
    #[serde(default)]
    pub sd_um: f64,
}

/// One error of the machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachineError {
    /// Which, with its unit, as in the JSON of `ldbb`: `squareness_urad`, `backlash_um.0`.
    pub name: Name,
    /// Force at which it was found, N.
    pub force_n: f64,
    /// Value, in the unit of the name.
    pub value: f64,
    /// Its standard deviation.
    pub sd: f64,
}

/// Modes of the structure at one speed. A sweep is one record a speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    /// Spindle speed, 1/min; 0 at rest.
    pub rpm: f64,
    /// The modes.
    pub modes: Vec<StructuralMode>,
}

/// One mode of the structure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StructuralMode {
    /// Axis in which it was found, for instance `X`.
    pub axis: Name,
    /// Natural frequency, Hz.
    pub f_hz: f64,
    /// Its standard deviation, Hz.
    pub f_sd_hz: f64,
    /// Damping ratio, 1.
    pub zeta: f64,
    /// Its standard deviation, 1.
    pub zeta_sd: f64,
    /// Modal stiffness, N/µm, where the test told it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub n_per_um: Option<f64>,
}

/// Widest stable cut by direction, of the elastic linked system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Specific cutting force, N/mm².
    pub ks_n_per_mm2: f64,
    /// By direction.
    pub directions: Vec<DirectionLimit>,
}

/// Widest stable cut in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DirectionLimit {
    /// Direction, degrees.
    pub angle_deg: f64,
    /// Width, mm.
    pub width_mm: f64,
    /// Its standard deviation, mm; 0 where it was not estimated.
    #[serde(default)]
    pub sd_mm: f64,
    /// Frequency of the chatter beyond it, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chatter_hz: Option<f64>,
}

/// Operational damping over many readings with one tool (the record's) at one speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OdrStatistics {
    /// Spindle speed, 1/min.
    pub rpm: f64,
    /// Frequency of the mode, median, Hz.
    pub f_hz: f64,
    /// Readings.
    pub count: u64,
    /// How long was listened, s.
    pub seconds: f64,
    /// Mean of the damping ratio, 1.
    pub zeta_mean: f64,
    /// Standard deviation of that mean (neighbouring readings are not independent: it is more than
    /// the scatter over the root of `count`), 1.
    pub zeta_mean_sd: f64,
    /// Lowest tenth, median and highest tenth of the readings, 1.
    pub zeta_tenths: [f64; 3],
}
