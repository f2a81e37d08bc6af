//! The section `[milling]`, and which of the two kinds of cut a file holds.

use super::reader::{Allowed, Refusal, Section};
use super::shared::{
    LENGTH_MM, MM, N_PER_MM, N_PER_MM2, PLACE_MM, SPEED_RPM, bare_mode, depth, noise,
    process_damping, speed, step_rate, variation,
};
use super::turning::turning;
use rarma_plants::cut::Process;
use rarma_plants::milling::{Engagement, Gap, MillingConfig, Workpiece};
use rarma_plants::modal::ShapedMode;
use rarma_plants::process::{Contact, Wear};

/// One of the two kinds of cut.
pub(super) fn process(file: &mut Section<'_>, seed: u64) -> Result<Process, Refusal> {
    let mill = file.table("milling", "A milling cut", |s| milling(s, seed))?;
    let lathe = file.table("turning", "A turning cut, if there is no [milling]", |s| {
        turning(s, seed)
    })?;
    match (mill, lathe) {
        (Some(m), _) if file.describes() => Ok(Process::Milling(Box::new(m))),
        (Some(m), None) => Ok(Process::Milling(Box::new(m))),
        (None, Some(t)) => Ok(Process::Turning(Box::new(t))),
        (Some(_), Some(_)) => Err(file.refuse(
            "turning",
            "cannot stand beside milling (allowed: one of [milling] and [turning])",
        )),
        (None, None) => Err(file.refuse(
            "milling",
            "is missing (allowed: one of the tables [milling] and [turning])",
        )),
    }
}

fn milling(s: &mut Section<'_>, seed: u64) -> Result<MillingConfig, Refusal> {
    let spindle_hz = s.number(
        "speed_rpm",
        SPEED_RPM,
        None,
        "Spindle speed, 1/min; the nominal one if `speed` changes it",
    )? / 60.0;
    let speed = speed(s, spindle_hz)?;
    let variation = variation(s)?;
    let teeth = s.whole("teeth", (1, 64), None, "Number of teeth")? as usize;
    let diameter_m = s.number("diameter_mm", LENGTH_MM, None, "Diameter of the cutter, mm")? * MM;
    let helix = s.number(
        "helix_deg",
        Allowed::within(0.0, 80.0),
        Some(0.0),
        "Helix angle, degrees",
    )?;
    let pitch = s.numbers(
        "pitch_deg",
        Allowed::within(1.0, 359.0),
        "Pitch from each tooth to the next, degrees, one per tooth, together 360; empty: equal",
    )?;
    let runout = s.numbers(
        "runout_um",
        Allowed::within(-1000.0, 1000.0),
        "Radial runout of each tooth, µm; empty: none",
    )?;
    let fz = s.number(
        "feed_per_tooth_mm",
        Allowed::within(0.0, 5.0),
        None,
        "Feed per tooth, mm",
    )?;
    let engagement = engagement(s)?;
    let kt = s.number(
        "kt_n_per_mm2",
        Allowed::within(1e-3, 1e5),
        None,
        "Tangential cutting coefficient, N/mm²",
    )?;
    let kn = s.number(
        "kn_n_per_mm2",
        Allowed::within(0.0, 1e5),
        None,
        "Radial cutting coefficient, N/mm²",
    )?;
    let kte = s.number(
        "kt_edge_n_per_mm",
        Allowed::within(0.0, 1e4),
        Some(0.0),
        "Tangential edge coefficient, N/mm",
    )?;
    let kne = s.number(
        "kn_edge_n_per_mm",
        Allowed::within(0.0, 1e4),
        Some(0.0),
        "Radial edge coefficient, N/mm",
    )?;
    let depth = depth(s)?;
    let modes = s.tables(
        "mode",
        "The modes of the structure at the tool; one table each",
        mode,
    )?;
    let describes = s.describes();
    if modes.is_empty() && !describes {
        return Err(s.refuse(
            "mode",
            "is missing (allowed: at least one table [[milling.mode]])",
        ));
    }
    let (noise, damping) = (noise(s)?, process_damping(s, diameter_m)?);
    let wear = s.table(
        "wear",
        "Slow growth of the coefficients from time 0 on",
        wear,
    )?;
    let workpiece = s.table(
        "workpiece",
        "Ends of the stock and gaps in it; without it there is material everywhere",
        workpiece,
    )?;
    let rate = step_rate(s)?;
    if !describes {
        for (field, entries) in [("pitch_deg", pitch.len()), ("runout_um", runout.len())] {
            if entries != 0 && entries != teeth {
                return Err(s.refuse(
                    field,
                    format!(
                        "has {entries} entries (allowed: one for each of the {teeth} teeth, or none)"
                    ),
                ));
            }
        }
        let sum: f64 = pitch.iter().sum();
        if !pitch.is_empty() && (sum - 360.0).abs() > 1e-6 {
            return Err(s.refuse(
                "pitch_deg",
                format!("adds up to {sum} (allowed: pitches that add up to 360)"),
            ));
        }
    }
    let only = |x: f64, y: f64| {
        move |m: &&ShapedMode| m.x == x && m.y == y && m.turn_rad_per_m == 0.0 && m.at_sensor == 1.0
    };
    let bare = |m: &ShapedMode| m.mode;
    Ok(MillingConfig {
        teeth,
        pitch_rad: pitch.iter().map(|p| p.to_radians()).collect(),
        runout_m: runout.iter().map(|r| r * 1e-6).collect(),
        spindle_hz,
        speed,
        variation,
        feed_per_tooth_m: fz * MM,
        kt_n_per_m2: kt * N_PER_MM2,
        kn_n_per_m2: kn * N_PER_MM2,
        kt_edge_n_per_m: kte * N_PER_MM,
        kn_edge_n_per_m: kne * N_PER_MM,
        engagement,
        diameter_m,
        helix_rad: helix.to_radians(),
        modes_x: modes.iter().filter(only(1.0, 0.0)).map(bare).collect(),
        modes_y: modes.iter().filter(only(0.0, 1.0)).map(bare).collect(),
        modes_other: modes
            .iter()
            .filter(|m| !only(1.0, 0.0)(m) && !only(0.0, 1.0)(m))
            .copied()
            .collect(),
        depth,
        workpiece,
        wear: wear.unwrap_or_default(),
        process_damping: damping,
        noise,
        contact: Contact::Real,
        min_step_rate_hz: rate,
        seed,
    })
}

fn engagement(s: &mut Section<'_>) -> Result<Engagement, Refusal> {
    let kind = s.choice(
        "cut",
        &["slot", "up", "down"],
        true,
        "Where in the arc the cutter is engaged",
    )?;
    let a = s.number(
        "immersion",
        Allowed::within(1e-3, 1.0),
        Some(1.0),
        "Width of cut over diameter, 1; for up and down",
    )?;
    if kind == 0 && a != 1.0 {
        return Err(s.refuse(
            "immersion",
            format!("is {a} (allowed: 1, or nothing, in a slot)"),
        ));
    }
    Ok(match kind {
        1 => Engagement::up(a),
        2 => Engagement::down(a),
        _ => Engagement::SLOT,
    })
}

fn mode(s: &mut Section<'_>) -> Result<ShapedMode, Refusal> {
    let mode = bare_mode(s)?;
    let shape = Allowed::within(-10.0, 10.0);
    let shaped = ShapedMode {
        mode,
        x: s.number(
            "x",
            shape,
            Some(0.0),
            "How far the mode moves the tool in x (feed) per its coordinate, 1",
        )?,
        y: s.number("y", shape, Some(0.0), "The same in y")?,
        at_sensor: s.number(
            "at_sensor",
            Allowed::within(-10.0, 10.0),
            Some(1.0),
            "How far it moves the place of the sensor over how far it moves the tool, 1",
        )?,
        turn_rad_per_m: s.number(
            "turn_rad_per_m",
            Allowed::within(-1e4, 1e4),
            Some(0.0),
            "How far it turns the cutter in the sense of the spindle, rad/m (torsion)",
        )?,
    };
    let moves = shaped.x != 0.0 || shaped.y != 0.0 || shaped.turn_rad_per_m != 0.0;
    if !moves && !s.describes() {
        let state = if s.has("x") { "is 0" } else { "is missing" };
        let what = format!(
            "{state} (allowed: one of x, y and turn_rad_per_m that is not 0: how the mode moves the tool)"
        );
        return Err(s.refuse("x", what));
    }
    Ok(shaped)
}

fn wear(s: &mut Section<'_>) -> Result<Wear, Refusal> {
    let growth = Allowed::within(0.0, 10.0);
    Ok(Wear {
        cutting_per_s: s.number(
            "cutting_per_s",
            growth,
            Some(0.0),
            "Relative growth of kt and kn, 1/s",
        )?,
        edge_per_s: s.number(
            "edge_per_s",
            growth,
            Some(0.0),
            "Relative growth of the edge coefficients, 1/s",
        )?,
    })
}

fn workpiece(s: &mut Section<'_>) -> Result<Workpiece, Refusal> {
    let from = s.number(
        "from_mm",
        PLACE_MM,
        None,
        "Where the stock begins along the feed, mm; the axis of the cutter starts at 0",
    )?;
    let to = s.number("to_mm", PLACE_MM, None, "Where it ends, mm")?;
    if to <= from && !s.describes() {
        return Err(s.refuse("to_mm", format!("is {to} (allowed: more than from_mm)")));
    }
    let mut gaps = s.tables("slot", "Rectangles without material", |s| {
        let mut side =
            |name, default| s.number(name, PLACE_MM, default, "Edge of the rectangle, mm");
        let x = [side("from_mm", None)?, side("to_mm", None)?];
        let y = [
            side("y_from_mm", Some(-10_000.0))?,
            side("y_to_mm", Some(10_000.0))?,
        ];
        for (ends, to, from) in [(x, "to_mm", "from_mm"), (y, "y_to_mm", "y_from_mm")] {
            if ends[1] <= ends[0] && !s.describes() {
                let what = format!("is {} (allowed: more than {from})", ends[1]);
                return Err(s.refuse(to, what));
            }
        }
        Ok(Gap::Slot {
            x_m: x.map(|v| v * MM),
            y_m: y.map(|v| v * MM),
        })
    })?;
    gaps.extend(s.tables("hole", "Round places without material", |s| {
        Ok(Gap::Hole {
            at_m: [
                s.number("x_mm", PLACE_MM, None, "Centre along the feed, mm")? * MM,
                s.number("y_mm", PLACE_MM, None, "Centre across it, mm")? * MM,
            ],
            diameter_m: s.number("diameter_mm", LENGTH_MM, None, "Diameter, mm")? * MM,
        })
    })?);
    Ok(Workpiece {
        x_m: [from * MM, to * MM],
        gaps,
    })
}
