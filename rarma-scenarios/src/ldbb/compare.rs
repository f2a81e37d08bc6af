//! Several machines side by side.

use serde::Serialize;
use serde_json::Value;

/// What is compared of a machine; N/µm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machine {
    /// Its name.
    pub name: String,
    /// Feed, mm/min.
    pub feed_mm_min: f64,
    /// Inclination of the bar, degrees.
    pub inclination_deg: f64,
    /// Mean stiffness.
    pub mean: f64,
    /// Largest, and its direction in degrees.
    pub most: (f64, f64),
    /// Smallest, and its direction in degrees.
    pub least: (f64, f64),
    /// Greatest standard deviation of the two.
    pub sd: f64,
    /// Force, N, scale mismatch, µm, and squareness, µrad, of the largest force.
    pub at_most: (f64, f64, f64),
    /// Angle, degrees, and stiffness all round.
    pub polar: Vec<(f64, f64)>,
}

impl Machine {
    /// From the JSON that `rarma ldbb analyse` writes.
    ///
    /// # Errors
    /// The field that is missing.
    pub fn from_json(value: &Value) -> Result<Self, String> {
        let number = |pointer: &str| {
            value
                .pointer(pointer)
                .and_then(Value::as_f64)
                .ok_or_else(|| format!("no number at {pointer}"))
        };
        let k = "/findings/stiffness";
        let list = |pointer: &str| {
            value
                .pointer(pointer)
                .and_then(Value::as_array)
                .ok_or_else(|| format!("no list at {pointer}"))
        };
        let polar = list(&format!("{k}/rays"))?
            .iter()
            .filter_map(|r| Some((r.get("angle_deg")?.as_f64()?, r.get("n_per_um")?.as_f64()?)))
            .collect();
        let errors = list("/findings/errors")?;
        let last = errors.last().ok_or("no errors at any force")?;
        let of = |pointer: &str| last.pointer(pointer).and_then(Value::as_f64).unwrap_or(0.0);
        Ok(Self {
            name: value
                .get("machine")
                .and_then(Value::as_str)
                .ok_or("no name at /machine")?
                .to_owned(),
            feed_mm_min: number("/feed_mm_min")?,
            inclination_deg: number("/inclination_deg")?,
            mean: number(&format!("{k}/mean_n_per_um"))?,
            most: (
                number(&format!("{k}/most/n_per_um"))?,
                number(&format!("{k}/most/angle_deg"))?,
            ),
            least: (
                number(&format!("{k}/least/n_per_um"))?,
                number(&format!("{k}/least/angle_deg"))?,
            ),
            sd: number(&format!("{k}/most/sd_n_per_um"))?
                .max(number(&format!("{k}/least/sd_n_per_um"))?),
            at_most: (
                of("/force_n"),
                of("/scale_mismatch_um/value"),
                of("/squareness_urad/value"),
            ),
            polar,
        })
    }
}

/// Stiffest first.
pub fn rank(machines: &mut [Machine]) {
    machines.sort_by(|a, b| b.mean.total_cmp(&a.mean));
}

/// Largest mean less the smallest over their middle, 1.
pub fn spread(machines: &[Machine]) -> f64 {
    let least = machines.iter().fold(f64::INFINITY, |m, x| m.min(x.mean));
    let most = machines.iter().fold(0.0, |m: f64, x| m.max(x.mean));
    2.0 * (most - least) / (most + least)
}
