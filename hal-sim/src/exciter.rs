//! The exciter at work on its plant: magnets calibrated, bias held, a signal commanded,
//! everything recorded.
//!
//! The regulator is the one of the firmware; what is simulated is the plant. Off the signal
//! path: whole records in memory.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rarma_plants::PlantError;
use rarma_plants::cers::{COILS, CoilConfig, ExciterConfig, ExciterPlant};
use rarma_rigs::cers::{
    AxisForce, Calibration, CalibrationConfig, CersError, ForcePair, Geometry, Regulator, Tuning,
    calibrate,
};

/// How a measurement is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Bias of every coil, A.
    pub bias_a: f32,
    /// Coefficients of the regulators.
    pub tuning: Tuning,
    /// Periods of the loop for each sample of the record, 1 upward. What the signal or the
    /// PWM have above half of the rate that is left folds back.
    pub every: usize,
    /// Time before the record begins: bias and transients settle, s.
    pub settle_s: f64,
    /// Time of the record, s.
    pub record_s: f64,
}

/// What was measured; index 0 is x, 1 is y, all at the same instants.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Samples a second.
    pub fs_hz: f64,
    /// Commanded change of the current, A.
    pub command_a: [Vec<f64>; 2],
    /// Currents of +x, −x, +y, −y, zero errors removed, A.
    pub current_a: [Vec<f64>; COILS],
    /// Displacement, m.
    pub displacement_m: [Vec<f64>; 2],
    /// Acceleration at the front bearing, m/s².
    pub acceleration_m_per_s2: [Vec<f64>; 2],
    /// Force on the rotor as it was, N: only a simulation knows it.
    pub true_force_n: [Vec<f64>; 2],
    /// Revolutions of the spindle since the start.
    pub revolutions: Vec<f64>,
    /// Periods in which the supply held a current back.
    pub limited: usize,
}

impl Record {
    /// Magnetic force of an axis from currents and displacement by the calibrated law, N,
    /// and the samples that are not to be trusted.
    #[must_use]
    pub fn force_n(&self, axis: usize, law: &AxisForce<f64>) -> (Vec<f64>, usize) {
        let mut doubtful = 0;
        let force = self.current_a[2 * axis]
            .iter()
            .zip(&self.current_a[2 * axis + 1])
            .zip(&self.displacement_m[axis])
            .map(|((p, m), x)| {
                let f = law.force(*p, *m, *x);
                doubtful += usize::from(!f.trusted);
                f.newton
            })
            .collect();
        (force, doubtful)
    }
}

/// Periods over which the zeros of the current sensors are taken, switches open.
const ZERO_PERIODS: usize = 4096;

/// Runs a measurement. `command` gives the change of the current in x and y, A, for each
/// period; `spindle_hz` the speed at a time since the start of settling, s.
///
/// Coils +: bias + command; coils −: bias − command.
///
/// # Errors
/// `OutOfRange`, a field of the plant or `every`.
pub fn measure(
    config: &ExciterConfig,
    how: &Measurement,
    seed: u64,
    mut command: impl FnMut(usize) -> [f32; 2],
    mut spindle_hz: impl FnMut(f64) -> f64,
) -> Result<Record, PlantError> {
    if how.every == 0 {
        return Err(PlantError::OutOfRange { name: "every" });
    }
    let mut plant = ExciterPlant::new(config.clone(), seed)?;
    let mut zero = [0.0; COILS];
    for _ in 0..ZERO_PERIODS {
        plant.period(None);
        for (zero, i) in zero.iter_mut().zip(plant.read().current_a) {
            *zero += i / ZERO_PERIODS as f64;
        }
    }
    let settle = (how.settle_s * config.loop_hz).round() as usize;
    let periods = settle + (how.record_s * config.loop_hz).round() as usize;
    let per_volt = 1.0 / config.supply_v as f32;
    let mut regulators = [Regulator::default(); COILS];
    let mut out = Record {
        fs_hz: config.loop_hz / how.every as f64,
        ..Record::default()
    };
    for n in 0..periods {
        plant.turn(spindle_hz(n as f64 / config.loop_hz));
        let seen = plant.read();
        let wanted = command(n);
        let mut current = seen.current_a;
        let duty = std::array::from_fn(|k| {
            current[k] -= zero[k];
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let target = (how.bias_a + sign * wanted[k / 2]).max(0.0);
            let drive = regulators[k].update(&how.tuning, target, current[k] as f32, per_volt);
            out.limited += usize::from(drive.limiting && n >= settle);
            f64::from(drive.duty)
        });
        if n >= settle && (n - settle).is_multiple_of(how.every) {
            let truth = plant.truth();
            for axis in 0..2 {
                out.command_a[axis].push(f64::from(wanted[axis]));
                out.displacement_m[axis].push(seen.displacement_m[axis]);
                out.acceleration_m_per_s2[axis].push(seen.acceleration_m_per_s2[axis]);
                out.true_force_n[axis].push(truth.force_n[axis]);
            }
            for (list, i) in out.current_a.iter_mut().zip(current) {
                list.push(i);
            }
            out.revolutions.push(plant.revolutions());
        }
        plant.period(Some(duty));
    }
    Ok(out)
}

/// A magnet on the bench: a load cell (0.05 N, and 0.5 % from setting gap and current)
/// against its own current sensor and the gap as it is thought to be, 0.4 to 3 A at five
/// gaps from 100 to 200 µm.
#[must_use]
pub fn bench_pairs(coil: &CoilConfig, current_gain_error: f64, seed: u64) -> Vec<ForcePair<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut out = Vec::new();
    for gap_m in [100e-6, 125e-6, 150e-6, 175e-6, 200e-6] {
        for step in 1..=8 {
            let current = 0.375 * f64::from(step);
            let force = coil.force_at_rest_n(current, gap_m);
            out.push(ForcePair {
                current_a: current * (1.0 + current_gain_error),
                gap_m,
                force_n: force * (1.0 + 0.005 * noise()) + 0.05 * noise(),
            });
        }
    }
    out
}

/// Laws of x and y with what each magnet's calibration left over.
pub type CalibratedAxes = ([AxisForce<f64>; 2], [Calibration<f64>; COILS]);

/// Calibrates all four magnets of a plant on the bench.
///
/// # Errors
/// Those of [`calibrate`].
pub fn calibrated(
    config: &ExciterConfig,
    guess: &Geometry<f64>,
    seed: u64,
) -> Result<CalibratedAxes, CersError> {
    let one = |k: usize| {
        let error = config.sensors.current_gain_error[k];
        let pairs = bench_pairs(&config.coils[k], error, seed + k as u64);
        calibrate(&pairs, guess.magnet(), &CalibrationConfig::default())
    };
    let all = [one(0)?, one(1)?, one(2)?, one(3)?];
    let axis = |a: usize| AxisForce {
        plus: all[2 * a].magnet,
        minus: all[2 * a + 1].magnet,
        gap_m: config.gap_m,
        gap_per_displacement: guess.pole_angle_rad.cos(),
    };
    Ok(([axis(0), axis(1)], all))
}
