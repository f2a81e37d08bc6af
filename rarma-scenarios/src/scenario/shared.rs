//! What the sections `[milling]` and `[turning]` share.

use super::reader::{Allowed, Refusal, Section};
use rarma_plants::modal::Mode;
use rarma_plants::process::{ForceNoise, ProcessDamping, Schedule};
use rarma_plants::variation::{FREQUENCY_RATIOS, MOST_AMPLITUDE, SpeedVariation};

pub(super) const MM: f64 = 1e-3;
pub(super) const N_PER_MM2: f64 = 1e6;
pub(super) const N_PER_MM: f64 = 1e3;
pub(super) const N_PER_UM: f64 = 1e6;
/// Depths and distances, mm.
pub(super) const LENGTH_MM: Allowed = Allowed::within(0.01, 1000.0);
pub(super) const PLACE_MM: Allowed = Allowed::within(-10_000.0, 10_000.0);
pub(super) const DEPTH_MM: Allowed = Allowed::within(0.0, 200.0);
pub(super) const TIME_S: Allowed = Allowed::within(0.0, 3600.0);
pub(super) const SPEED_RPM: Allowed = Allowed::within(60.0, 200_000.0);

pub(super) fn step_rate(s: &mut Section<'_>) -> Result<f64, Refusal> {
    s.number("step_rate_hz", Allowed::within(10_000.0, 5e6), Some(192_000.0), "Least integration rate, Hz; at least 50 steps per period of the fastest mode, and not below the sample rate")
}

/// A constant `depth_mm`, or a list `depth` of times and depths.
pub(super) fn depth(s: &mut Section<'_>) -> Result<Schedule, Refusal> {
    let (constant, list) = (s.has("depth_mm"), s.has("depth"));
    let depth = s.number(
        "depth_mm",
        DEPTH_MM,
        Some(0.0),
        "Axial depth (milling) or width of cut (turning), mm; or give `depth`",
    )?;
    let points = s.tables(
        "depth",
        "Depth over time instead of `depth_mm`: straight lines between these points",
        |p| {
            let t = p.number("t_s", TIME_S, None, "Time, s")?;
            Ok((
                t,
                p.number("depth_mm", DEPTH_MM, None, "Depth then, mm")? * MM,
            ))
        },
    )?;
    if s.describes() {
        return Ok(Schedule::constant(0.0));
    }
    match (constant, list) {
        (true, false) => Ok(Schedule::constant(depth * MM)),
        (false, true) => schedule(s, "depth", &points),
        (true, true) => Err(s.refuse(
            "depth",
            "cannot stand beside depth_mm (allowed: one of the two)",
        )),
        (false, false) => Err(s.refuse(
            "depth_mm",
            format!(
                "is missing (allowed: {}, or a list `depth`)",
                "a number from 0 to 200"
            ),
        )),
    }
}

pub(super) fn speed(s: &mut Section<'_>, nominal_hz: f64) -> Result<Option<Schedule>, Refusal> {
    let points = s.tables("speed", "Spindle speed over time: straight lines between these points, from half to twice `speed_rpm`", |p| {
        let t = p.number("t_s", TIME_S, None, "Time, s")?;
        Ok((t, p.number("speed_rpm", SPEED_RPM, None, "Speed then, 1/min")? / 60.0))
    })?;
    if points.is_empty() || s.describes() {
        return Ok(None);
    }
    if let Some((_, v)) = points
        .iter()
        .find(|(_, v)| *v < 0.5 * nominal_hz || *v > 2.0 * nominal_hz)
    {
        return Err(s.refuse(
            "speed",
            format!(
                "reaches {} 1/min (allowed: from half to twice speed_rpm)",
                60.0 * v
            ),
        ));
    }
    schedule(s, "speed", &points).map(Some)
}

/// A swing of the speed about its mean, if the table is there.
pub(super) fn variation(s: &mut Section<'_>) -> Result<Option<SpeedVariation>, Refusal> {
    let (least, most) = FREQUENCY_RATIOS;
    s.table(
        "variation",
        "Swing of the spindle speed about its mean: n(t) = n0*(1 + rva*sin(2*pi*rvf*n0*t))",
        |v| {
            Ok(SpeedVariation {
                amplitude: v.number(
                    "rva",
                    Allowed::within(0.0, MOST_AMPLITUDE),
                    None,
                    "Amplitude of the speed over its mean, 1",
                )?,
                frequency_ratio: v.number(
                    "rvf",
                    Allowed::within(least, most),
                    None,
                    "Swings a turn: the frequency of the swing over the spindle's, 1",
                )?,
            })
        },
    )
}

pub(super) fn schedule(
    s: &Section<'_>,
    field: &str,
    points: &[(f64, f64)],
) -> Result<Schedule, Refusal> {
    Schedule::new(points).map_err(|_| {
        s.refuse(
            field,
            "is not in order (allowed: at least one point, times that increase)",
        )
    })
}

pub(super) fn bare_mode(s: &mut Section<'_>) -> Result<Mode, Refusal> {
    let f = s.number(
        "f_hz",
        Allowed::within(1.0, 20_000.0),
        None,
        "Undamped natural frequency, Hz",
    )?;
    let zeta = s.number("zeta", Allowed::within(1e-5, 0.9), None, "Damping ratio, 1")?;
    let k = s.number(
        "stiffness_n_per_um",
        Allowed::within(1e-6, 1e6),
        None,
        "Modal stiffness, N/µm",
    )?;
    Ok(Mode::from_stiffness(f, zeta, k * N_PER_UM))
}

pub(super) fn noise(s: &mut Section<'_>) -> Result<ForceNoise, Refusal> {
    let read = s.table("noise", "Broadband force", |s| {
        Ok(ForceNoise {
            relative: s.number(
                "relative",
                Allowed::within(0.0, 2.0),
                Some(0.0),
                "Standard deviation of the cutting force relative to its value, 1",
            )?,
            background_n: s.number(
                "background_n",
                Allowed::within(0.0, 1e4),
                Some(0.0),
                "Standard deviation of a force that is there even in air, N",
            )?,
            bandwidth_hz: s.number(
                "bandwidth_hz",
                Allowed::within(10.0, 1e5),
                Some(8000.0),
                "Corner of the low-pass both have passed, Hz",
            )?,
        })
    })?;
    Ok(read.unwrap_or_default())
}

pub(super) fn process_damping(
    s: &mut Section<'_>,
    diameter_m: f64,
) -> Result<Option<ProcessDamping>, Refusal> {
    s.table(
        "process_damping",
        "Rubbing of the flank on the waves",
        |s| {
            Ok(ProcessDamping {
                c_n_per_m: s.number(
                    "c_n_per_m",
                    Allowed::within(0.0, 1e8),
                    None,
                    "C of the force C·(b/V)·velocity, N/m",
                )?,
                friction: s.number(
                    "friction",
                    Allowed::within(0.0, 2.0),
                    Some(0.0),
                    "Tangential over radial part, 1",
                )?,
                diameter_m,
            })
        },
    )
}
