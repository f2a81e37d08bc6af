//! A test to its findings.

use super::circularity::causes;
use super::errors::{AtForce, Circularity, With};
use super::options::Options;
use super::runs::steps;
use super::steady::steadied;
use super::stiffness::{AllRound, Cycle, all_round, moving_cycles, static_cycles, trace};
use rarma_recordings::input::{RunData, Static};
use rarma_rigs::ldbb::{
    Circle, Deviation, ErrorFit, LdbbError, MachineErrors, Measured, Sense, Spike, Terms,
    bidirectional, circular_deviation, spikes,
};
use serde::Serialize;

/// Everything.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Findings {
    /// Errors at every force on the way up, in rising order.
    pub errors: Vec<AtForce>,
    /// Stiffness all round; null with fewer than three forces.
    pub stiffness: Option<AllRound>,
    /// Hysteresis of a cycle while moving; null without a way down.
    pub moving: Option<Vec<Cycle>>,
    /// Load cycles while standing.
    pub standing: Vec<Cycle>,
}

/// Evaluates circles, and a static test where there is one.
///
/// # Errors
/// What cannot be evaluated; see [`LdbbError`].
pub fn evaluate(
    runs: &[RunData],
    readings: &[Static],
    options: &Options,
) -> Result<Findings, LdbbError> {
    let steady = steadied(runs, options)?;
    let runs = steady.as_deref().unwrap_or(runs);
    let rising = steps(runs.iter().filter(|r| r.rising));
    let errors = rising
        .iter()
        .map(|step| at_force(step, options))
        .collect::<Result<Vec<_>, _>>()?;
    let forces = rising.len();
    // More than one run a sense, all at one force.
    if forces == 1 && runs.iter().filter(|r| r.rising).count() > 2 {
        return Err(LdbbError::EqualForces);
    }
    Ok(Findings {
        errors,
        stiffness: if forces >= 3 {
            Some(all_round(runs, options)?)
        } else {
            None
        },
        moving: moving_cycles(runs)?,
        standing: if readings.is_empty() {
            Vec::new()
        } else {
            static_cycles(readings, options.bar_m_per_n)?
        },
    })
}

/// The fit of some runs together.
///
/// # Errors
/// As [`ErrorFit`].
pub fn fit(runs: &[&RunData], options: &Options) -> Result<ErrorFit<f64>, LdbbError> {
    let circle = Circle {
        radius_m: options.radius_m,
        feed_m_s: options.feed_m_s,
        pitch_m: options.pitch_m,
    };
    let both = [Sense::Ccw, Sense::Cw]
        .iter()
        .all(|s| runs.iter().any(|r| r.sense == *s));
    // How much is covered decides how many terms there can be: count first.
    let mut fit = ErrorFit::new(Terms::of(both, 0.0, false), circle)?;
    for run in runs {
        for (theta, dr) in &run.points {
            fit.add(*theta, run.sense, *dr)?;
        }
    }
    let covered = fit.covered_deg();
    if covered < 345.0 {
        return Ok(fit);
    }
    let mut fit = ErrorFit::new(Terms::of(both, covered, options.pitch_m > 0.0), circle)?;
    for run in runs {
        for (theta, dr) in &run.points {
            fit.add(*theta, run.sense, *dr)?;
        }
    }
    Ok(fit)
}

fn at_force(runs: &[&RunData], options: &Options) -> Result<AtForce, LdbbError> {
    let fit = fit(runs, options)?;
    let e: MachineErrors<f64> = fit.solve()?;
    let um = |m| With::scaled(m, 1e6);
    let pair = |p: [Measured<f64>; 2]| [um(p[0]), um(p[1])];
    let of = |sense| runs.iter().find(|r| r.sense == sense).map(|r| trace(r));
    let (ccw, cw) = (of(Sense::Ccw), of(Sense::Cw));
    let deviation: Deviation<f64> = match (&ccw, &cw) {
        (Some(a), Some(b)) => bidirectional(a, b)?,
        (Some(a), None) | (None, Some(a)) => circular_deviation(a)?,
        (None, None) => return Err(LdbbError::TooFew { needed: 1 }),
    };
    let both = ccw.is_some() && cw.is_some();
    let spiked = if e.backlash_m.is_some() {
        [(Sense::Ccw, &ccw), (Sense::Cw, &cw)]
            .into_iter()
            .filter_map(|(sense, t)| {
                let found: [Spike<f64>; 4] = spikes(t.as_ref()?, &fit, sense);
                Some((sense.name(), found.map(|s| 1e6 * s.height_m)))
            })
            .collect()
    } else {
        Vec::new()
    };
    let alone = |t: &Option<_>| t.as_ref().map(circular_deviation).transpose();
    let circularity = Circularity::of(
        alone(&ccw)?.as_ref(),
        alone(&cw)?.as_ref(),
        both.then_some(&deviation),
    );
    let mut at_force = AtForce {
        force_n: runs.iter().map(|r| r.force_n).sum::<f64>() / runs.len() as f64,
        runs: runs.iter().map(|r| r.number).collect(),
        centre_um: pair(e.centre_m),
        scale_mismatch_um: um(e.scale_mismatch_m),
        squareness_urad: um(e.squareness_rad),
        squareness_includes_servo: e.squareness_includes_servo,
        straightness_um: e.straightness_m.map(pair),
        backlash_um: e.backlash_m.map(pair),
        lateral_play_um: e.lateral_play_m.map(pair),
        servo_mismatch_ms: e.servo_mismatch_s.map(|m| With::scaled(m, 1e3)),
        cyclic_um: e.cyclic_m.map(pair),
        spikes_um: spiked,
        scatter_um: 1e6 * e.scatter_m,
        condition: e.condition,
        circular_um: 1e6 * deviation.least_squares_m,
        circular_least_um: 1e6 * deviation.least_zone_m,
        hysteresis_um: both.then_some(1e6 * deviation.hysteresis_m),
        hysteresis_at_deg: both.then_some(deviation.hysteresis_at_rad.to_degrees()),
        circularity,
        causes: Vec::new(),
    };
    at_force.causes = causes(&at_force, options, options.axes);
    Ok(at_force)
}
