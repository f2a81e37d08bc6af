//! Memory and work of a scenario, estimated before any of it is done.
//!
//! Every single field has its range; these are the products. The estimates are of the
//! right size, not exact: what is refused would take minutes or gigabytes.

use super::reader::{Refusal, Section};
use rarma_plants::cut::{Process, Scenario};
use rarma_plants::delay::{MOST_NUMBERS, MOST_STEPS, MOST_VARIED_STEPS};
use rarma_plants::milling::MillingConfig;
use rarma_plants::truth::STEPS_PER_PERIOD;

/// Modes of a structure at most.
const MOST_MODES: usize = 32;
/// Cells of the surface at most, 8 bytes each.
const MOST_CELLS: f64 = 2e7;
/// Steps of the simulation for each sample at most: the filter between them holds 50 KB
/// for each.
const MOST_STEPS_PER_SAMPLE: f64 = 2000.0;
/// Additions and multiplications of a whole simulation at most: some minutes.
const MOST_WORK: f64 = 2e11;
/// The same of everything that is true of it.
const MOST_TRUTH: f64 = 1e11;
/// Slices of a helical edge, at least so many, rad and at most.
const SLICE_RAD: f64 = 0.05;
const MOST_SLICES: f64 = 64.0;
/// Multiplications for each mode, and for each edge in the cut, at each step.
const PER_MODE: f64 = 20.0;
const PER_EDGE: f64 = 10.0;
/// Conditions at which a cut is looked at: the search for its limit, and over time.
const SEARCH_LOOKS: f64 = 80.0;
const TIME_LOOKS: f64 = 150.0;
/// Vectors in the basis of eigenvalues, as a rule.
const BASIS: f64 = 60.0;

/// That a scenario can be simulated and worked out.
pub(super) fn check(root: &Section<'_>, scenario: &Scenario) -> Result<(), Refusal> {
    let modes = scenario.process.modes().len();
    let section = match scenario.process {
        Process::Milling(_) => "milling",
        Process::Turning(_) => "turning",
    };
    if modes > MOST_MODES {
        let what = format!("has {modes} modes (allowed: up to {MOST_MODES})");
        return Err(root.refuse(section, what));
    }
    let (rate_hz, cells, edges) = match &scenario.process {
        Process::Milling(c) => {
            let per_tooth = (c.min_step_rate_hz / (c.slowest_hz() * c.teeth as f64)).max(4.0);
            let cells = per_tooth * c.teeth as f64;
            let slices = slices(c);
            (
                c.fastest_hz() * cells,
                cells * slices,
                c.teeth as f64 * slices,
            )
        }
        Process::Turning(c) => {
            let (slowest, fastest) = c.speeds_hz();
            let cells = (c.min_step_rate_hz / slowest).max(4.0);
            (fastest * cells, cells, 1.0)
        }
    };
    if cells > MOST_CELLS {
        let what = format!(
            "needs {cells:.1e} cells of surface (allowed: up to {MOST_CELLS:.0e}; a higher speed_rpm, less helix_deg or a lower step_rate_hz needs fewer)"
        );
        return Err(root.refuse(section, what));
    }
    let per_sample = rate_hz / scenario.microphone.sample_rate_hz;
    if per_sample > MOST_STEPS_PER_SAMPLE {
        let what = format!(
            "takes {per_sample:.0} steps a sample (allowed: up to {MOST_STEPS_PER_SAMPLE}; a higher sample_rate_hz or a lower step_rate_hz needs fewer)"
        );
        return Err(root.refuse("microphone", what));
    }
    let work = scenario.duration_s * rate_hz * (PER_MODE * modes as f64 + PER_EDGE * edges);
    if work > MOST_WORK {
        let most = scenario.duration_s * MOST_WORK / work;
        let what = format!(
            "is {} (allowed: up to {most:.3} with {rate_hz:.0} steps a second, {modes} modes and {edges:.0} edges)",
            scenario.duration_s
        );
        return Err(root.refuse("duration_s", what));
    }
    truth(root, section, &scenario.process)
}

fn slices(c: &MillingConfig) -> f64 {
    let lag = c.helix_lag_rad(c.depth.largest());
    (lag / SLICE_RAD).ceil().clamp(1.0, MOST_SLICES)
}

/// Tooth passes (turns where the pitch is unequal, and in turning) of a swing of the speed, 1
/// without one.
fn swings(process: &Process) -> f64 {
    let Some(variation) = process.variation() else {
        return 1.0;
    };
    let teeth = match process {
        Process::Milling(c) if c.pitch_rad.is_empty() => c.teeth as f64,
        _ => 1.0,
    };
    (teeth / variation.frequency_ratio).max(1.0)
}

/// That its delay equation can be worked out.
fn truth(root: &Section<'_>, section: &'static str, process: &Process) -> Result<(), Refusal> {
    let modes = process.modes();
    let highest = modes.iter().map(|m| m.mode.f_hz).fold(0.0, f64::max);
    let (steps, changes, exact) = match process {
        Process::Milling(c) => {
            let slowest = c.slowest_hz();
            let tooth = STEPS_PER_PERIOD * highest / (slowest * c.teeth as f64);
            let unequal = if c.pitch_rad.is_empty() {
                1.0
            } else {
                c.teeth as f64
            };
            let changes = c.speed.is_some()
                || c.depth.points().len() > 1
                || c.wear.cutting_per_s > 0.0
                || c.workpiece.is_some();
            (tooth * unequal * swings(process), changes, false)
        }
        Process::Turning(c) if c.variation.is_some() => (
            STEPS_PER_PERIOD * highest / c.speeds_hz().0 * swings(process),
            c.width.points().len() > 1,
            false,
        ),
        Process::Turning(c) => (
            6.0 * highest / c.spindle_hz,
            c.width.points().len() > 1,
            true,
        ),
    };
    let most = if process.variation().is_some() {
        MOST_VARIED_STEPS
    } else {
        MOST_STEPS.min(MOST_NUMBERS / (4 * modes.len().pow(2)).max(1))
    };
    if steps > most as f64 && !exact {
        let what = format!(
            "needs {steps:.0} steps a period for {highest} Hz (allowed: up to {most}; a higher speed_rpm or a lower f_hz needs fewer)"
        );
        return Err(root.refuse(section, what));
    }
    let n = 2.0 * modes.len() as f64;
    let look = if exact {
        steps * 500.0 * n
    } else {
        let basis = if process.variation().is_some() {
            // A history of a tooth or turn is in the basis, not of the whole swing.
            8.0 * BASIS / swings(process)
        } else {
            8.0 * BASIS
        };
        BASIS * steps * (n * (n + 6.0) + basis)
    };
    let looks = SEARCH_LOOKS + if changes { TIME_LOOKS } else { 0.0 };
    if look * looks > MOST_TRUTH {
        let what = format!(
            "is too slow for {highest} Hz: {steps:.0} steps a period at {looks:.0} conditions (allowed: up to {:.0} steps; a higher speed_rpm or a lower f_hz needs fewer)",
            steps * MOST_TRUTH / (look * looks)
        );
        return Err(root.refuse(section, what));
    }
    Ok(())
}
