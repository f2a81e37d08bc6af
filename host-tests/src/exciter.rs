//! The exciter's tests: one plant with the errors of a real one, one multisine, one way
//! from a record to a response.

use hal_sim::exciter::{Measurement, Record, measure};
use rarma_plants::cers::ExciterConfig;
use rarma_rigs::cers::{
    AxisForce, Dodge, Eddy, Frf, FrfLine, Geometry, LineSet, Lines, Path, Phases, RealFft,
    RegulatorConfig, Window, lower_crest, multisine, remove_orders,
};
use rarma_rigs::els::Complex;

/// Samples of a block of the record, at 20 kHz: 4.88 Hz.
pub const BLOCK: usize = 4096;
/// Half of them, and a period of the loop's table.
const HALF: usize = BLOCK / 2;
const TABLE: usize = 2 * BLOCK;
/// Rate of the record, Hz.
pub const RATE_HZ: f64 = 20e3;
/// Orders taken out of a turning record.
const ORDERS: [f64; 9] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.43, 3.64, 5.36];

/// Gaps that are not what they are thought to be, current sensors with gain errors.
#[must_use]
pub fn plant() -> ExciterConfig {
    let mut config = ExciterConfig {
        substeps: 8,
        ..ExciterConfig::default()
    };
    for (coil, off) in config.coils.iter_mut().zip([4e-6, -3e-6, 2e-6, -5e-6]) {
        coil.gap_error_m = off;
    }
    config.sensors.current_gain_error = [0.01, -0.008, 0.006, -0.01];
    config
}

/// What the magnets are thought to be before they are calibrated: ideal iron.
#[must_use]
pub fn drawing() -> Geometry<f64> {
    Geometry::textbook()
}

/// The measurement of `blocks` periods at 0.8 A.
///
/// # Panics
/// On a regulator that is not valid: a mistake here.
#[must_use]
pub fn how(blocks: usize) -> Measurement {
    Measurement {
        bias_a: 0.8,
        tuning: RegulatorConfig {
            inductance_h: 4.2e-3,
            resistance_ohm: 4.0,
            rate_hz: 40e3,
            crossover: 1.0 / 18.0,
            most_duty: 0.95,
        }
        .tuning()
        .expect("a valid regulator"),
        every: 2,
        settle_s: 2.0 * BLOCK as f64 / RATE_HZ,
        record_s: (blocks * BLOCK) as f64 / RATE_HZ,
    }
}

/// A direction's lines and one period of its command at unit rms.
pub struct Drive {
    /// Lines, of the record and of the loop alike.
    pub lines: Lines<f64>,
    /// A period at the loop's rate.
    pub period: Vec<f64>,
}

/// 150 to 5000 Hz by Schroeder's phases, dodging a spindle.
///
/// # Panics
/// If no line is left.
#[must_use]
pub fn drive(set: LineSet, spindle_hz: f64) -> Drive {
    drive_to(set, spindle_hz, 5e3)
}

/// The same up to `top_hz`.
///
/// # Panics
/// If no line is left.
#[must_use]
pub fn drive_to(set: LineSet, spindle_hz: f64, top_hz: f64) -> Drive {
    let dodge = (spindle_hz > 0.0).then_some(Dodge {
        spindle_hz,
        clearance_hz: 3.0,
    });
    let spacing = RATE_HZ / BLOCK as f64;
    let lines = Lines::new(spacing, (150.0, top_hz), set, dodge).expect("lines");
    let mut fft = RealFft::<f64, BLOCK>::default();
    let mut period = vec![0.0; TABLE];
    multisine(&lines, Phases::Schroeder, |_| 1.0, &mut fft, &mut period).expect("a period");
    if spindle_hz > 0.0 {
        // Schroeder's phases are for lines that follow each other; gaps raise the peaks.
        let mut work = vec![0.0; TABLE];
        lower_crest(&lines, 150, &mut fft, &mut period, &mut work).expect("a period");
    }
    Drive { lines, period }
}

/// X on odd lines and Y on even ones at once, at an rms current in A.
///
/// # Panics
/// If the plant refuses.
#[must_use]
pub fn record(
    config: &ExciterConfig,
    drives: &[Drive; 2],
    rms_a: f64,
    blocks: usize,
    spindle_hz: f64,
    seed: u64,
) -> Record {
    let command = |n: usize| std::array::from_fn(|a| (rms_a * drives[a].period[n % TABLE]) as f32);
    measure(config, &how(blocks), seed, command, |_| spindle_hz).expect("a record")
}

/// A line of a response.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Hz.
    pub f_hz: f64,
    /// Every estimate, as measured.
    pub raw: FrfLine<f64>,
    /// Receptance by the command as instrument, with sensor and flux taken out, m/N.
    pub receptance: Complex<f64>,
}

/// Response of axis `to` to the force of axis `from`, on the lines of `from`.
///
/// # Panics
/// On blocks that are not whole, which [`how`] does not give.
#[must_use]
pub fn response(
    record: &Record,
    law: &AxisForce<f64>,
    drive: &Drive,
    (from, to): (usize, usize),
    sensor: impl Fn(f64) -> (f64, f64),
    eddy: Option<Eddy<f64>>,
) -> Vec<Line> {
    let (mut force, _) = record.force_n(from, law);
    let mut motion = record.displacement_m[to].clone();
    let turning = record.revolutions.last() > record.revolutions.first();
    if turning {
        for x in [&mut force, &mut motion] {
            remove_orders::<f64, 19>(x, &record.revolutions, &ORDERS).expect("orders");
        }
    }
    let mut fft: [RealFft<f64, HALF>; 3] = std::array::from_fn(|_| RealFft::default());
    let mut frf = Box::new(Frf::<f64, HALF>::new(Window::Rectangular));
    let mut work = vec![0.0; BLOCK];
    let blocks = record.command_a[from].chunks_exact(BLOCK);
    for (r, (u, y)) in blocks.zip(force.chunks_exact(BLOCK).zip(motion.chunks_exact(BLOCK))) {
        frf.add(&mut fft, r, u, y, &mut work)
            .expect("a whole block");
    }
    drive
        .lines
        .iter()
        .filter_map(|k| {
            let f_hz = drive.lines.hz(k);
            let raw = frf.line(k)?;
            let (re, im) = sensor(f_hz);
            let path = Path {
                motion_sensor: Complex::new(re, im),
                force_lag: eddy.map_or(Complex::new(1.0, 0.0), |e| e.flux(f_hz)),
                ..Path::none()
            };
            let receptance = path.correct(raw.iv, f_hz);
            Some(Line {
                f_hz,
                raw,
                receptance,
            })
        })
        .collect()
}

/// The lag of the plant's laminations.
#[must_use]
pub fn lag(config: &ExciterConfig) -> Eddy<f64> {
    let coil = config.coils[0];
    Eddy {
        lamination_m: coil.lamination_m,
        conductivity_s_per_m: coil.conductivity_s_per_m,
        permeability: coil.permeability,
        iron_path_m: coil.iron_path_m,
        gap_m: config.gap_m,
    }
}
