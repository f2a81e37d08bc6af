//! Machine errors at one force, and what a report says of the circle.

use rarma_rigs::ldbb::Measured;
use serde::Serialize;

/// Deviations of one direction, µm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OneWay {
    /// Circular deviation G: distance of the two concentric circles that hold the path, about
    /// the centre that makes it smallest.
    pub g_um: f64,
    /// Largest radial deviation F from the nominal radius, about the least-squares centre; means
    /// something with a calibrated length only.
    pub f_max_um: f64,
    /// Smallest, likewise.
    pub f_min_um: f64,
}

/// Deviations of a circle, µm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Circularity {
    /// Counter-clockwise; null if it was not run.
    pub ccw: Option<OneWay>,
    /// Clockwise, likewise.
    pub cw: Option<OneWay>,
    /// Bidirectional circular deviation G(b): both paths in one pair of circles; null for one
    /// direction.
    pub g_b_um: Option<f64>,
    /// Mean bidirectional radial deviation D; null for one direction.
    pub d_um: Option<f64>,
}

/// A machine error, and what it does to the circle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cause {
    /// Which, with its axis.
    pub name: String,
    /// Circular deviation that it alone makes, µm.
    pub um: f64,
    /// That over the sum of all causes', 0 to 1.
    pub share: f64,
}

/// A value and its standard deviation, in the unit its field says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct With {
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub sd: f64,
}

impl With {
    pub(super) fn scaled(m: Measured<f64>, factor: f64) -> Self {
        Self {
            value: factor * m.value,
            sd: factor.abs() * m.sd,
        }
    }
}

/// Machine errors at one force; µm, µrad, ms.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AtForce {
    /// Force in the plane, N.
    pub force_n: f64,
    /// Runs it is made of.
    pub runs: Vec<u32>,
    /// Centre.
    pub centre_um: [With; 2],
    /// Travel of the first axis less that of the second.
    pub scale_mismatch_um: With,
    /// Squareness.
    pub squareness_urad: With,
    /// One direction: the squareness holds the servo mismatch as well.
    pub squareness_includes_servo: bool,
    /// Straightness of both axes; null for part of a circle.
    pub straightness_um: Option<[With; 2]>,
    /// Backlash of both axes; null for part of a circle.
    pub backlash_um: Option<[With; 2]>,
    /// Lateral play of both axes; null for one direction.
    pub lateral_play_um: Option<[With; 2]>,
    /// Servo mismatch; null for one direction.
    pub servo_mismatch_ms: Option<With>,
    /// Cyclic error of both axes; null if none was sought.
    pub cyclic_um: Option<[With; 2]>,
    /// Heights of the spikes after 0°, 90°, 180°, 270°, by direction; null for part of a
    /// circle.
    pub spikes_um: Vec<(&'static str, [f64; 4])>,
    /// Scatter about the fit.
    pub scatter_um: f64,
    /// Condition of the fit.
    pub condition: f64,
    /// Circular deviation about the least-squares centre, and the least one there is.
    pub circular_um: f64,
    /// See [`Self::circular_um`].
    pub circular_least_um: f64,
    /// Deviations of each direction and of both together.
    pub circularity: Circularity,
    /// Which errors make it, the largest first.
    pub causes: Vec<Cause>,
    /// Distance of the two directions; null for one.
    pub hysteresis_um: Option<f64>,
    /// Where, degrees.
    pub hysteresis_at_deg: Option<f64>,
}
