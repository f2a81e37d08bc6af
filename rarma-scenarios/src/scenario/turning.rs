//! The section `[turning]`.

use super::reader::{Allowed, Refusal, Section};
use super::shared::{
    LENGTH_MM, MM, N_PER_MM, N_PER_MM2, SPEED_RPM, bare_mode, depth, noise, process_damping,
    step_rate, variation,
};
use rarma_plants::process::Contact;
use rarma_plants::turning::TurningConfig;

pub(super) fn turning(s: &mut Section<'_>, seed: u64) -> Result<TurningConfig, Refusal> {
    let spindle_hz = s.number(
        "speed_rpm",
        SPEED_RPM,
        None,
        "Spindle speed, 1/min; the mean one if it swings",
    )? / 60.0;
    let variation = variation(s)?;
    let diameter_m = s.number(
        "diameter_mm",
        LENGTH_MM,
        None,
        "Diameter that is turned, mm",
    )? * MM;
    let feed = s.number(
        "feed_mm",
        Allowed::within(0.0, 5.0),
        None,
        "Feed per revolution, mm",
    )?;
    let ks = s.number(
        "ks_n_per_mm2",
        Allowed::within(1e-3, 1e5),
        None,
        "Cutting coefficient in the direction of the chip thickness, N/mm²",
    )?;
    let edge = s.number(
        "edge_n_per_mm",
        Allowed::within(0.0, 1e4),
        Some(0.0),
        "Edge coefficient, N/mm",
    )?;
    let nose = s.number(
        "nose_radius_mm",
        Allowed::within(1e-3, 50.0),
        Some(0.8),
        "Nose radius of the tool, mm; for the surface",
    )?;
    let width = depth(s)?;
    let modes = s.tables(
        "mode",
        "The modes in the direction of the chip thickness; one table each",
        bare_mode,
    )?;
    if modes.is_empty() && !s.describes() {
        return Err(s.refuse(
            "mode",
            "is missing (allowed: at least one table [[turning.mode]])",
        ));
    }
    Ok(TurningConfig {
        spindle_hz,
        variation,
        feed_m: feed * MM,
        ks_n_per_m2: ks * N_PER_MM2,
        edge_n_per_m: edge * N_PER_MM,
        nose_radius_m: nose * MM,
        modes,
        width,
        process_damping: process_damping(s, diameter_m)?,
        noise: noise(s)?,
        contact: Contact::Real,
        min_step_rate_hz: step_rate(s)?,
        seed,
    })
}
