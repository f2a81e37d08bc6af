//! Runs whose force goes on while the machine moves, brought to one force a step.

use super::options::Options;
use super::runs::steps;
use super::stiffness::rising_map;
use rarma_recordings::input::RunData;
use rarma_rigs::ldbb::{Harmonics, LdbbError};

/// A force that goes on by less than this within a run stays, N: 0.09 µm at 11.8 N/µm.
const STAYS_N: f64 = 1.0;

/// Every reading as it would be at the mean force of its step:
///
/// ```text
/// Δr(θ) − c(θ)·(F − F_step)
/// ```
///
/// c is the smoothed compliance of the same readings as they are: a force that goes on alike at
/// every step tilts every run alike, which is in r0(θ) and not in c(θ); both senses
/// together are not tilted at all. A c that is 1 % off leaves 0.013 µm at 15 N. None where no
/// force goes on, or where fewer than three steps tell no compliance.
///
/// # Errors
/// As the fits of the compliance.
pub fn steadied(runs: &[RunData], options: &Options) -> Result<Option<Vec<RunData>>, LdbbError> {
    if runs.iter().all(|r| r.creep_n().abs() < STAYS_N) {
        return Ok(None);
    }
    let steps = steps(runs);
    if steps.iter().filter(|s| s[0].rising).count() < 3 {
        return Ok(None);
    }
    let map = rising_map(runs)?;
    let each = map.directions(0.0)?;
    let c = Harmonics::fit(
        each.map(|d| (d.angle_rad, d.compliance_m_per_n.value)),
        options.order,
    )?;
    let mut out = Vec::with_capacity(runs.len());
    for step in &steps {
        let force_n = step.iter().map(|r| r.force_n).sum::<f64>() / step.len() as f64;
        for run in step {
            let mut run = (*run).clone();
            let own = run.force_n;
            let forces = run.forces_n.iter().copied().chain(std::iter::repeat(own));
            for ((theta, dr), f) in run.points.iter_mut().zip(forces) {
                *dr -= c.at(*theta) * (f - force_n);
            }
            run.force_n = force_n;
            run.forces_n.clear();
            out.push(run);
        }
    }
    Ok(Some(out))
}
