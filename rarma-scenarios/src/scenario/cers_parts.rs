//! The sections `[excitation]`, `[spindle]` and `[magnets]` of a measurement.

use super::reader::{Allowed, Refusal, Section};
use crate::cers::{Drive, Signal};

/// How the magnets' constants are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Calibrated {
    /// Forty pairs of current and force at five gaps, on a bench.
    Points,
    /// From the drawing.
    Drawing,
}

pub(super) fn excitation(s: &mut Section<'_>) -> Result<Drive, Refusal> {
    let d = Drive::default();
    let signal = s.choice(
        "signal",
        &["multisine", "noise", "prbs"],
        false,
        "Multisine: lines without leakage; noise: band-limited, clipped at 3 deviations; prbs: shift register",
    )?;
    let axes = s.choice(
        "axes",
        &["both", "x", "y"],
        false,
        "Directions driven; both at once are told apart by their lines or their noise",
    )?;
    let low = s.number(
        "low_hz",
        Allowed::within(0.0, 4000.0),
        Some(d.band_hz.0),
        "Lower edge, Hz",
    )?;
    let high = s.number(
        "high_hz",
        Allowed::within(100.0, 8000.0),
        Some(d.band_hz.1),
        "Upper edge, Hz",
    )?;
    let rms = s.number(
        "rms_a",
        Allowed::within(1e-6, 20.0),
        Some(d.rms_a),
        "Current of each direction, A rms",
    )?;
    if !s.describes() && high < low + 50.0 {
        return Err(s.refuse(
            "high_hz",
            format!("is {high} (allowed: more than low_hz, which is {low})"),
        ));
    }
    Ok(Drive {
        signal: [Signal::Multisine, Signal::Noise, Signal::Prbs][signal],
        axes: [axes != 2, axes != 1],
        band_hz: (low, high),
        rms_a: rms,
        dodge_hz: 0.0,
    })
}

/// Speeds at both ends in revolutions/s; orders and their force at 300 revolutions/s, N.
pub(super) type Spindle = (f64, f64, Vec<(f64, f64)>);

pub(super) fn spindle(s: &mut Section<'_>) -> Result<Spindle, Refusal> {
    let speed = Allowed::within(0.0, 1e5);
    let from = s.number("rpm", speed, Some(0.0), "Speed at the start, 1/min")?;
    let given = s.has("to_rpm");
    let to = s.number(
        "to_rpm",
        speed,
        Some(0.0),
        "Speed at the end, 1/min; left out: as at the start",
    )?;
    let to = if given { to } else { from };
    let most = s.number(
        "most_rpm",
        Allowed::within(100.0, 24_000.0),
        Some(18_000.0),
        "Limit of the spindle with the rotor in it, 1/min",
    )?;
    for (field, rpm) in [("rpm", from), ("to_rpm", to)] {
        if !s.describes() && rpm > most {
            return Err(s.refuse(
                field,
                format!("is {rpm}: above the spindle's limit (allowed: up to most_rpm, {most})"),
            ));
        }
    }
    let lines = s.numbers(
        "lines",
        Allowed::within(0.0, 100.0),
        "Forces that turn with the spindle: order and N at 18 000 1/min by turns, growing with the square of the speed; left out: three bearing lines of half a newton",
    )?;
    if !s.describes() && !lines.len().is_multiple_of(2) {
        return Err(s.refuse(
            "lines",
            "is no list of orders and forces (allowed: order and N by turns)",
        ));
    }
    let lines = lines.chunks_exact(2).map(|p| (p[0], p[1])).collect();
    Ok((from / 60.0, to / 60.0, lines))
}

/// What is known of the magnets.
pub(super) struct Known {
    pub(super) calibrated: Calibrated,
    pub(super) gap_m: f64,
    pub(super) inductance_h: f64,
    pub(super) resistance_ohm: f64,
}

impl Default for Known {
    fn default() -> Self {
        Self {
            calibrated: Calibrated::Points,
            gap_m: 150e-6,
            inductance_h: 4.2e-3,
            resistance_ohm: 4.0,
        }
    }
}

pub(super) fn magnets(s: &mut Section<'_>) -> Result<Known, Refusal> {
    let d = Known::default();
    let calibrated = s.choice(
        "calibration",
        &["points", "drawing", "none"],
        false,
        "Points: forty pairs at five gaps, each magnet; drawing: ideal iron (30 % of the force); none: refused",
    )?;
    let sensors = s.choice(
        "gap_sensors",
        &["both", "x", "y", "none"],
        false,
        "Directions whose gap is measured; the force stands on both",
    )?;
    let gap = s.number(
        "gap_um",
        Allowed::within(80.0, 400.0),
        Some(1e6 * d.gap_m),
        "Gap with the rotor in the middle, µm",
    )?;
    let inductance = s.number(
        "inductance_mh",
        Allowed::within(0.2, 50.0),
        Some(1e3 * d.inductance_h),
        "Inductance of a coil, mH",
    )?;
    let resistance = s.number(
        "resistance_ohm",
        Allowed::within(0.1, 50.0),
        Some(d.resistance_ohm),
        "Resistance of a coil, Ω",
    )?;
    if !s.describes() {
        if calibrated == 2 {
            return Err(s.refuse(
                "calibration",
                "is \"none\": magnets +x, −x, +y, −y have no calibration, their force would be a guess (allowed: \"points\", \"drawing\")",
            ));
        }
        let absent = ["", "y", "x", "x and y"][sensors];
        if !absent.is_empty() {
            return Err(s.refuse(
                "gap_sensors",
                format!(
                    "leaves {absent} without a gap sensor: 1 µm of gap is 1.3 % of the force (allowed: \"both\")"
                ),
            ));
        }
    }
    Ok(Known {
        calibrated: [Calibrated::Points, Calibrated::Drawing][calibrated.min(1)],
        gap_m: 1e-6 * gap,
        inductance_h: 1e-3 * inductance,
        resistance_ohm: resistance,
    })
}
