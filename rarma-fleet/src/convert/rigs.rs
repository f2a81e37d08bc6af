//! The JSON of the rigs.

use super::{ConvertError, list, number, text};
use crate::record::{
    Body, DirectionLimit, DirectionStiffness, Hysteresis, Limits, MachineError, Modes, Name,
    Stiffness, StructuralMode,
};
use serde_json::Value;
use std::collections::BTreeMap;

/// Of `ldbb run` and `ldbb analyse`.
pub(super) fn stiffness(said: &Value) -> Result<Body, ConvertError> {
    let findings = &said["findings"];
    let stiffness = &findings["stiffness"];
    let rays = list(stiffness, "rays").map_err(|_| {
        ConvertError::Nothing("it has no stiffness: that needs three forces at least")
    })?;
    // The raw ones: neighbours of the smoothed share their noise.
    let ray = |ray: &Value| -> Result<DirectionStiffness, ConvertError> {
        Ok(DirectionStiffness {
            angle_deg: number(ray, "angle_deg")?,
            n_per_um: number(ray, "raw_n_per_um")?,
            sd_n_per_um: number(ray, "raw_sd_n_per_um")?,
        })
    };
    // Of the loops while it moves one in thirty: they come at every degree.
    let moving = list(findings, "moving")
        .unwrap_or_default()
        .iter()
        .step_by(30);
    let cycles = moving.chain(list(findings, "standing").unwrap_or_default());
    let hysteresis = cycles.map(|c| {
        Ok(Hysteresis {
            angle_deg: number(c, "angle_deg")?,
            um: number(c, "most_um")?,
            sd_um: 0.0,
        })
    });
    let mut errors = Vec::new();
    for at_force in list(findings, "errors").unwrap_or_default() {
        let force_n = number(at_force, "force_n")?;
        for (name, value) in at_force.as_object().into_iter().flatten() {
            estimates(name, value, force_n, &mut errors)?;
        }
    }
    Ok(Body::Stiffness(Stiffness {
        plane: Name::new(text(said, "plane")?)?,
        radius_mm: number(said, "radius_mm")?,
        inclination_deg: number(said, "inclination_deg").unwrap_or(0.0),
        directions: rays.iter().map(ray).collect::<Result<_, ConvertError>>()?,
        scale_sd: number(stiffness, "scale_sd").unwrap_or(0.0),
        hysteresis: hysteresis.collect::<Result<_, ConvertError>>()?,
        errors,
    }))
}

/// Every `{value, sd}` of an error, or of a list of them: `backlash_um.0`.
fn estimates(
    name: &str,
    value: &Value,
    force_n: f64,
    out: &mut Vec<MachineError>,
) -> Result<(), ConvertError> {
    if let (Ok(value), Ok(sd)) = (number(value, "value"), number(value, "sd")) {
        out.push(MachineError {
            name: Name::new(name)?,
            force_n,
            value,
            sd,
        });
    } else if let Some(list) = value.as_array() {
        for (n, one) in list.iter().enumerate() {
            estimates(&format!("{name}.{n}"), one, force_n, out)?;
        }
    }
    Ok(())
}

/// Of `cers run` and `cers analyse`: the modes of a record at one speed.
pub(super) fn modes(said: &Value) -> Result<Body, ConvertError> {
    let speeds: Vec<f64> = list(said, "rpm")?
        .iter()
        .filter_map(Value::as_f64)
        .collect();
    let Some(&first) = speeds.first() else {
        return Err(ConvertError::Field("rpm".to_owned()));
    };
    let found = list(said, "modes")?.iter().map(|mode| {
        Ok(StructuralMode {
            axis: Name::new(&text(mode, "axis")?.to_uppercase())?,
            f_hz: number(mode, "f")?,
            f_sd_hz: number(mode, "f_sd").unwrap_or(0.0),
            zeta: number(mode, "zeta")?,
            zeta_sd: number(mode, "zeta_sd").unwrap_or(0.0),
            n_per_um: None,
        })
    });
    let modes: Vec<StructuralMode> = found.collect::<Result<_, ConvertError>>()?;
    if modes.is_empty() {
        return Err(ConvertError::Nothing("it has no modes"));
    }
    Ok(Body::Modes(Modes { rpm: first, modes }))
}

/// Speeds of a sweep at which modes are kept, 1/min apart: from test to test the same.
const SPEED_STEP: f64 = 500.0;

/// A mode of a track: how far from the speed of its record it was read, and what.
type Nearest = (f64, StructuralMode);

/// Of the sweep of `cers run` and `cers analyse`: one record a speed. Of each track the reading next to that speed that
/// is believed, by the method that knows the force, else by the other.
pub(super) fn sweep(said: &Value) -> Result<Vec<Body>, ConvertError> {
    let tracks = list(said, "tracks")?;
    let mut speeds: BTreeMap<i64, BTreeMap<String, Nearest>> = BTreeMap::new();
    // What comes later takes the place of what there is of the same band.
    for method in ["rarma", "arx"] {
        for track in tracks.iter().filter(|t| t["method"] == method) {
            let axis = Name::new(&text(track, "axis")?.to_uppercase())?;
            let band = format!("{axis} {}", track["band_hz"]);
            let mut of_track: BTreeMap<i64, Nearest> = BTreeMap::new();
            for point in list(track, "points")? {
                if point["believed"] != true {
                    continue;
                }
                let rpm = number(point, "rpm")?;
                let step = (rpm / SPEED_STEP).round();
                let off = (rpm - step * SPEED_STEP).abs();
                #[allow(clippy::cast_possible_truncation, reason = "saturates")]
                let step = step as i64;
                if of_track.get(&step).is_none_or(|found| off < found.0) {
                    let mode = StructuralMode {
                        axis: axis.clone(),
                        f_hz: number(point, "f")?,
                        f_sd_hz: number(point, "f_sd")?,
                        zeta: number(point, "zeta")?,
                        zeta_sd: number(point, "zeta_sd")?,
                        n_per_um: None,
                    };
                    of_track.insert(step, (off, mode));
                }
            }
            for (step, found) in of_track {
                (speeds.entry(step).or_default()).insert(band.clone(), found);
            }
        }
    }
    if speeds.is_empty() {
        return Err(ConvertError::Nothing(
            "it is a sweep without a reading that is believed",
        ));
    }
    #[allow(clippy::cast_precision_loss, reason = "a speed over 500")]
    let record = |(step, modes): (i64, BTreeMap<String, Nearest>)| {
        Body::Modes(Modes {
            rpm: step as f64 * SPEED_STEP,
            modes: modes.into_values().map(|(_, mode)| mode).collect(),
        })
    };
    Ok(speeds.into_iter().map(record).collect())
}

/// Of `els limit`.
pub(super) fn limits(said: &Value) -> Result<Body, ConvertError> {
    // `null` where every width is stable: no limit to keep.
    let limited = list(said, "polar")?
        .iter()
        .filter(|p| p["width_mm"].is_number());
    let direction = |p: &Value| {
        Ok(DirectionLimit {
            angle_deg: number(p, "angle_deg")?,
            width_mm: number(p, "width_mm")?,
            sd_mm: 0.0,
            chatter_hz: number(p, "chatter_hz").ok(),
        })
    };
    let directions: Vec<DirectionLimit> = limited
        .map(direction)
        .collect::<Result<_, ConvertError>>()?;
    if directions.is_empty() {
        return Err(ConvertError::Nothing("it has no limit in any direction"));
    }
    Ok(Body::Limits(Limits {
        ks_n_per_mm2: number(said, "ks_n_per_mm2")?,
        directions,
    }))
}
