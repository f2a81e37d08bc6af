//! A machine that is told: its modes with stiffness and direction, the cutter, arc, coefficients and
//! depth, as a scenario has them; and machines like it, for nothing that is told is known exactly.

mod belief;
mod curve;
mod likelihood;
#[cfg(test)]
mod tests;
mod vibration;

pub use belief::{Answer, Belief, Chart};

use crate::args::MachineArgs;
use crate::failure::Failure;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rarma_core::decide::{StructuralMode, Structure};
use rarma_plants::cut::Process;
use rarma_plants::delay::Root;
use rarma_plants::error::PlantError;
use rarma_plants::modal::{Mode, ShapedMode};
use rarma_plants::truth::roots_in;
use rarma_scenarios::scenario;

/// How well what is told is known: relative standard deviations of one drawn machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Natural frequencies. A hammer's record of a second tells them to a tenth of a percent; the rest is
    /// the tool that was taken out and put in again, a warm spindle, and one that turns.
    pub frequency: f64,
    /// Damping ratios: it is read from the width of a peak, and a joint is damped as hard as it is clamped.
    pub damping: f64,
    /// Stiffnesses: the calibrations of hammer and accelerometer, and where the hammer hits.
    pub stiffness: f64,
    /// Directions, rad: a hammer that hits a few degrees askew.
    pub direction: f64,
    /// The cutting coefficient: of measured ones 95 % lie within 20 % of the fit, in aluminium and in
    /// steels (ASME MSEC2009, 43628, 137). It stands for the depth, too, which counts as a factor of it.
    pub cutting: f64,
    /// Radial over tangential coefficient.
    pub radial: f64,
}

impl Spread {
    /// As usual.
    pub const USUAL: Self = Self {
        frequency: 0.003,
        damping: 0.1,
        stiffness: 0.05,
        direction: 0.05,
        cutting: 0.1,
        radial: 0.1,
    };

    /// All of it so many times.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            frequency: factor * self.frequency,
            damping: factor * self.damping,
            stiffness: factor * self.stiffness,
            direction: factor * self.direction,
            cutting: factor * self.cutting,
            radial: factor * self.radial,
        }
    }
}

/// Steps a period of the fastest mode. In 20 the growth of 20 random cuts, with damping of some tens 1/s, is that in
/// 60 within 0.7 1/s, of one within 2 % (150 for 153 1/s), and a root takes a third of the time.
const STEPS: f64 = 24.0;

/// The same is said of the same sound.
const SEED: u64 = 1;

/// A cut at its full depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    process: Process,
    depth_m: f64,
}

impl Machine {
    /// From a scenario's file, or a shipped one, for a cutter of so many teeth.
    ///
    /// # Errors
    /// Bad input; it cuts nothing; its teeth are others, or there are none to turn with.
    pub fn load(name: &str, teeth: Option<u32>) -> Result<Self, Failure> {
        let machine = Self::of(scenario::load(name, None)?.scenario.process);
        if !(machine.depth_m > 0.0) {
            return Err(Failure::Usage(format!(
                "--machine {name}: it cuts nothing, and its depth is part of what chatters: give it one"
            )));
        }
        let there = machine.process.teeth();
        match teeth {
            Some(teeth) if teeth as usize != there => Err(Failure::Usage(format!(
                "--machine {name}: {} with {there} {}, and --teeth is {teeth}: it is the file of another cut, or the number is wrong",
                match machine.process {
                    Process::Milling(_) => "it is milled",
                    Process::Turning(_) => "it is turned",
                },
                if there == 1 { "edge" } else { "teeth" },
            ))),
            _ => Ok(machine),
        }
    }

    /// A cut at its largest depth.
    #[must_use]
    pub fn of(process: Process) -> Self {
        Self {
            depth_m: process.depth().largest(),
            process,
        }
    }

    /// Its modes at rest, the first eight of them.
    #[must_use]
    pub fn structure(&self, spread: &Spread) -> Option<Structure<f64>> {
        let modes = self.process.modes();
        let modes: Vec<StructuralMode<f64>> = modes
            .iter()
            .take(rarma_core::decide::MAX_STRUCTURAL_MODES)
            .map(|m| StructuralMode {
                f_hz: m.mode.f_hz,
                f_sd: spread.frequency * m.mode.f_hz,
                zeta: m.mode.zeta,
                zeta_sd: spread.damping * m.mode.zeta,
            })
            .collect();
        Structure::new(&modes).ok()
    }

    /// One like it.
    #[must_use]
    pub fn like(&self, spread: &Spread, rng: &mut ChaCha8Rng) -> Self {
        let mut off = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
        let mut out = self.clone();
        match &mut out.process {
            Process::Milling(c) => {
                let modes = c.shaped_modes().into_iter();
                c.modes_other = modes.map(|m| shaped(&m, spread, &mut off)).collect();
                (c.modes_x, c.modes_y) = (Vec::new(), Vec::new());
                c.kt_n_per_m2 *= off(spread.cutting).exp();
                let radial = off(spread.radial).exp() * c.kt_n_per_m2;
                let told = match &self.process {
                    Process::Milling(told) => told.kn_n_per_m2 / told.kt_n_per_m2,
                    Process::Turning(_) => 0.0,
                };
                c.kn_n_per_m2 = told * radial;
            }
            Process::Turning(c) => {
                for mode in &mut c.modes {
                    *mode = off_told(mode, spread, &mut off);
                }
                c.ks_n_per_m2 *= off(spread.cutting).exp();
            }
        }
        out
    }

    /// Its dominant roots at a speed, turns a second, and so many times its depth; none where they
    /// cannot be told.
    fn roots(&self, spindle_hz: f64, depth: f64, wanted: usize) -> Result<Vec<Root>, PlantError> {
        let there = self.process.at_spindle_hz(spindle_hz);
        // An infinite time is fresh edges and the whole arc.
        roots_in(&there, f64::INFINITY, depth * self.depth_m, wanted, STEPS)
    }
}

/// What is believed of the machine that options name, if they name one.
///
/// # Errors
/// As [`Machine::load`].
pub fn told(args: &MachineArgs, teeth: Option<u32>) -> Result<Option<Belief>, Failure> {
    let Some(name) = &args.machine else {
        return Ok(None);
    };
    let spread = Spread::USUAL.times(args.machine_sd.unwrap_or(1.0));
    Ok(Some(Belief::new(Machine::load(name, teeth)?, spread, SEED)))
}

fn off_told(mode: &Mode, spread: &Spread, off: &mut impl FnMut(f64) -> f64) -> Mode {
    Mode {
        f_hz: mode.f_hz * off(spread.frequency).exp(),
        zeta: mode.zeta * off(spread.damping).exp(),
        stiffness_n_per_m: mode.stiffness_n_per_m * off(spread.stiffness).exp(),
    }
}

fn shaped(mode: &ShapedMode, spread: &Spread, off: &mut impl FnMut(f64) -> f64) -> ShapedMode {
    let own = off_told(&mode.mode, spread, off);
    let (sin, cos) = off(spread.direction).sin_cos();
    ShapedMode {
        mode: own,
        x: cos * mode.x - sin * mode.y,
        y: sin * mode.x + cos * mode.y,
        ..*mode
    }
}
