//! A measurement on the simulated exciter.

use crate::cers::{BLOCK, CersRecord, Commands, LOOP_HZ, RATE_HZ, Setup, Truth, tuning};
use crate::scenario::{Calibrated, CersScenario, MOST_DUTY};
use hal_sim::exciter::{Measurement, calibrated, measure};
use rarma_rigs::cers::{Eddy, Geometry};

/// Orders of the spindle taken out of every record; the bearings' come on top.
const SPINDLE_ORDERS: u32 = 6;

/// What was measured, and what is told about it.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The record.
    pub record: CersRecord,
    /// Odd, but not fatal: one sentence each.
    pub notes: Vec<String>,
}

/// Calibrates the magnets, holds the bias, commands the signal, records.
///
/// # Errors
/// In words: what the plant or the calibration refuses.
pub fn measured(s: &CersScenario) -> Result<Measured, String> {
    let mut notes = Vec::new();
    let drawing = Geometry::<f64> {
        gap_m: s.plant.gap_m,
        ..Geometry::textbook()
    };
    let magnets = match s.calibrated {
        Calibrated::Points => {
            let (_, all) = calibrated(&s.plant, &drawing, 100 * s.seed)
                .map_err(|why| format!("calibration: {why}"))?;
            let worst = all.iter().fold(0.0, |m: f64, c| m.max(c.residual_rms_part));
            notes.push(format!(
                "four magnets calibrated by 40 points each, {:.2} % left",
                100.0 * worst
            ));
            all.map(|c| c.magnet)
        }
        Calibrated::Drawing => {
            notes.push(
                "the magnets' constants are from the drawing: the force may be off by 30 %"
                    .to_owned(),
            );
            [drawing.magnet(); 4]
        }
    };
    let blocks = (s.seconds * RATE_HZ / BLOCK as f64).ceil();
    let settle_s = 2.0 * BLOCK as f64 / RATE_HZ;
    let record_s = blocks * BLOCK as f64 / RATE_HZ;
    let how = Measurement {
        bias_a: s.bias_a as f32,
        tuning: tuning(s.inductance_h, s.resistance_ohm, MOST_DUTY)?,
        every: (LOOP_HZ / RATE_HZ) as usize,
        settle_s,
        record_s,
    };
    let mut commands = Commands::new(&s.drive, s.seed);
    let (from, to) = s.spindle_hz;
    let speed = |t: f64| from + (to - from) * ((t - settle_s) / record_s).clamp(0.0, 1.0);
    let r = measure(&s.plant, &how, s.seed, |n| commands.at(n), speed)
        .map_err(|why| why.to_string())?;
    if r.limited > 0 {
        notes.push(format!(
            "the supply held a current back in {} periods",
            r.limited
        ));
    }
    let coil = &s.plant.coils[0];
    let mut orders: Vec<f64> = (1..=SPINDLE_ORDERS).map(f64::from).collect();
    for (order, _) in &s.plant.bearing_lines {
        if orders.iter().all(|o| (o - order).abs() > 1e-6) {
            orders.push(*order);
        }
    }
    let structure = &s.plant.structure;
    let setup = Setup {
        name: s.name.clone(),
        rate_hz: r.fs_hz,
        bias_a: s.bias_a,
        drive: s.drive,
        orders,
        tracks_hz: s.tracks_hz.clone(),
        magnets,
        gap_m: s.plant.gap_m,
        pole_angle_rad: drawing.pole_angle_rad,
        lag: Some(Eddy {
            lamination_m: coil.lamination_m,
            conductivity_s_per_m: coil.conductivity_s_per_m,
            permeability: coil.permeability,
            iron_path_m: coil.iron_path_m,
            gap_m: s.plant.gap_m,
        }),
        corner_hz: [
            s.plant.sensors.displacement_hz,
            s.plant.sensors.acceleration_hz,
        ],
        sensor_rate_hz: 2.0 * LOOP_HZ,
        truth: Some(Truth {
            modes: structure
                .modes
                .iter()
                .map(|m| [m.mode.f_hz, m.mode.zeta, m.x, m.y])
                .collect(),
            at_hz: structure.with_speed.at_hz,
            frequency_part: structure.with_speed.frequency_part,
            damping_part: structure.with_speed.damping_part,
        }),
    };
    Ok(Measured {
        record: CersRecord {
            setup,
            command_a: r.command_a,
            current_a: r.current_a,
            displacement_m: r.displacement_m,
            acceleration_m_per_s2: r.acceleration_m_per_s2,
            revolutions: r.revolutions,
        },
        notes,
    })
}
