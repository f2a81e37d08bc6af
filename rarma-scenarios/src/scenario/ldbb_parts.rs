//! Machine and gauge of a test of `rarma ldbb run`.

use super::reader::{Allowed, Refusal, Section};
use super::shared::N_PER_UM;
use rarma_plants::ldbb::{Around, GaugeConfig, Geometry, MachineConfig};

const STIFFNESS: Allowed = Allowed::within(1e-3, 1e4);
const SMALL_UM: Allowed = Allowed::within(-500.0, 500.0);

pub(super) fn gauge(s: &mut Section<'_>) -> Result<GaugeConfig, Refusal> {
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

pub(super) fn machine(s: &mut Section<'_>) -> Result<MachineConfig, Refusal> {
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
                "and least are not the extremes of any smooth course (allowed: most above least, their directions apart)",
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
        _ => Err(s.refuse(
            field,
            "is no pair (allowed: a stiffness above 0 in N/µm, and its angle in degrees)",
        )),
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
