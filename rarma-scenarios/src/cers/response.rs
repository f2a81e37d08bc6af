//! Responses of a record: motion over force by the command as instrument, corrected for
//! sensor and flux.

use super::drive::{BLOCK, Signal};
use super::record::CersRecord;
use core::f64::consts::{PI, SQRT_2};
use rarma_rigs::cers::{Frf, FrfLine, Path, RealFft, Window, remove_orders};
use rarma_rigs::els::Complex;

const HALF: usize = BLOCK / 2;
/// Room for the orders: 2·24 + 1.
const ORDERS: usize = 49;
/// Lines of a random signal are read from here on, Hz.
const LOWEST_HZ: f64 = 100.0;

/// The sensor of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// At the rotor, m.
    Displacement,
    /// At the front bearing, m/s²; read as displacement, over −ω².
    Accelerometer,
}

/// A line of a response.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// Hz.
    pub f_hz: f64,
    /// Every estimate, as measured.
    pub raw: FrfLine<f64>,
    /// Receptance by the command as instrument, sensor and flux taken out, m/N.
    pub receptance: Complex<f64>,
}

/// A response of a direction to the force of a direction.
#[derive(Debug, Clone)]
pub struct Response {
    /// Direction of the force: 0 for x, 1 for y.
    pub from: usize,
    /// Direction of the motion.
    pub to: usize,
    /// What measured the motion.
    pub sensor: Sensor,
    /// Blocks averaged.
    pub blocks: u32,
    /// The lines, by rising frequency.
    pub lines: Vec<Line>,
}

/// Forces and motions of a record with what turns taken out.
#[derive(Debug, Clone)]
pub struct Cleaned {
    /// Magnetic force of x and y, N.
    pub force_n: [Vec<f64>; 2],
    /// Displacement, m.
    pub displacement_m: [Vec<f64>; 2],
    /// Acceleration, m/s².
    pub acceleration_m_per_s2: [Vec<f64>; 2],
    /// Samples with a force that is not to be trusted, x and y.
    pub doubtful: [usize; 2],
    /// What the orders had of each displacement, m rms.
    pub orders_rms_m: [f64; 2],
}

/// Rebuilds the forces and takes the spindle's orders out of a record at constant speed.
///
/// # Errors
/// In words: orders that cannot be told apart in this record.
pub fn cleaned(record: &CersRecord) -> Result<Cleaned, String> {
    let ((fx, dx), (fy, dy)) = rayon::join(|| force(record, 0), || force(record, 1));
    let mut out = Cleaned {
        force_n: [fx, fy],
        displacement_m: record.displacement_m.clone(),
        acceleration_m_per_s2: record.acceleration_m_per_s2.clone(),
        doubtful: [dx, dy],
        orders_rms_m: [0.0; 2],
    };
    let turns = record.speeds_hz().1 > 0.1;
    if turns && !record.is_sweep() && !record.setup.orders.is_empty() {
        let orders = &record.setup.orders;
        let revolutions = &record.revolutions;
        let remove = |x: &mut Vec<f64>| {
            remove_orders::<f64, ORDERS>(x, revolutions, orders)
                .map_err(|why| format!("orders of the spindle: {why}"))
        };
        for axis in 0..2 {
            remove(&mut out.force_n[axis])?;
            out.orders_rms_m[axis] = remove(&mut out.displacement_m[axis])?;
            remove(&mut out.acceleration_m_per_s2[axis])?;
        }
    }
    Ok(out)
}

/// Force of a direction with the gap as it is and not as its sensor follows it.
///
/// At a resonance k_x·x is k_x/(2ζk) of the force, 9 % for ζ = 2.8 % at 40 N/µm, and the
/// sensor turns it: 16° at 2 kHz for a corner of 10 kHz. Left in, damping was read 1.7 % too low
/// there.
fn force(record: &CersRecord, axis: usize) -> (Vec<f64>, usize) {
    let setup = &record.setup;
    let lag = |f: f64| butterworth(f, setup.corner_hz[0], setup.sensor_rate_hz).inverse();
    match filtered(&record.displacement_m[axis], setup.rate_hz, lag) {
        Some(moved) => record.force_n(axis, &moved),
        None => record.force_n(axis, &record.displacement_m[axis]),
    }
}

/// A series through a response, by its transform as a whole.
fn filtered(x: &[f64], fs: f64, by: impl Fn(f64) -> Complex<f64>) -> Option<Vec<f64>> {
    let n = x.len();
    let (there, back) = (rarma_fourier::forward(n), rarma_fourier::inverse(n));
    let (mut input, mut lines) = (x.to_vec(), there.make_output_vec());
    there.process(&mut input, &mut lines).ok()?;
    for (k, z) in lines.iter_mut().enumerate() {
        let h = by(k as f64 * fs / n as f64);
        let (re, im) = (z.re * h.re - z.im * h.im, z.re * h.im + z.im * h.re);
        (z.re, z.im) = (re / n as f64, im / n as f64);
    }
    lines[0].im = 0.0;
    if n.is_multiple_of(2) {
        lines[n / 2].im = 0.0;
    }
    back.process(&mut lines, &mut input).ok()?;
    Some(input)
}

/// The response of direction `to` to the force of direction `from`, leaving out every block
/// for which `skip` says so.
///
/// # Errors
/// In words.
pub fn response(
    record: &CersRecord,
    clean: &Cleaned,
    (from, to): (usize, usize),
    sensor: Sensor,
    skip: impl Fn(usize) -> bool,
) -> Result<Response, String> {
    let setup = &record.setup;
    let window = match setup.drive.signal {
        Signal::Multisine => Window::Rectangular,
        _ => Window::Hann,
    };
    let mut fft: [RealFft<f64, HALF>; 3] = std::array::from_fn(|_| RealFft::default());
    let mut frf = Box::new(Frf::<f64, HALF>::new(window));
    let mut work = vec![0.0; BLOCK];
    let motion = match sensor {
        Sensor::Displacement => &clean.displacement_m[to],
        Sensor::Accelerometer => &clean.acceleration_m_per_s2[to],
    };
    let blocks = record.command_a[from]
        .chunks_exact(BLOCK)
        .zip(clean.force_n[from].chunks_exact(BLOCK))
        .zip(motion.chunks_exact(BLOCK));
    for (k, ((r, u), y)) in blocks.enumerate() {
        if !skip(k) {
            frf.add(&mut fft, r, u, y, &mut work)
                .map_err(|why| format!("block {k}: {why}"))?;
        }
    }
    let step = setup.rate_hz / BLOCK as f64;
    let excited = setup.drive.lines(from);
    let corner = setup.corner_hz[usize::from(sensor == Sensor::Accelerometer)];
    let lines = (1..HALF)
        .filter_map(|k| {
            let f_hz = step * k as f64;
            let wanted = match &excited {
                Some(lines) => lines.has(k),
                None => {
                    (setup.drive.band_hz.0.max(LOWEST_HZ)..=setup.drive.band_hz.1).contains(&f_hz)
                }
            };
            let raw = frf.line(k).filter(|_| wanted)?;
            let path = Path {
                motion_sensor: butterworth(f_hz, corner, setup.sensor_rate_hz),
                force_lag: setup
                    .lag
                    .map_or(Complex::new(1.0, 0.0), |lag| lag.flux(f_hz)),
                ..Path::none()
            };
            let h = path.correct(raw.iv, f_hz);
            let w = 2.0 * PI * f_hz;
            Some(Line {
                f_hz,
                raw,
                receptance: match sensor {
                    Sensor::Displacement => h,
                    Sensor::Accelerometer => h.scale(-1.0 / (w * w)),
                },
            })
        })
        .collect();
    Ok(Response {
        from,
        to,
        sensor,
        blocks: frf.blocks(),
        lines,
    })
}

/// 1/(1 + √2·p + p²), p = j·f/f_c; of a digital filter with both tangents in place of the
/// frequencies.
fn butterworth(f_hz: f64, corner_hz: f64, rate_hz: f64) -> Complex<f64> {
    let p = if rate_hz > 0.0 {
        (PI * f_hz / rate_hz).tan() / (PI * corner_hz / rate_hz).tan()
    } else {
        f_hz / corner_hz
    };
    Complex::new(1.0 - p * p, SQRT_2 * p).inverse()
}

/// Value of a receptance at a frequency between its lines, by a straight line.
fn between(lines: &[Line], f_hz: f64) -> Option<Complex<f64>> {
    let k = lines.partition_point(|l| l.f_hz < f_hz);
    let (b, a) = (lines.get(k)?, lines.get(k.checked_sub(1)?)?);
    let part = (f_hz - a.f_hz) / (b.f_hz - a.f_hz);
    Some(a.receptance.scale(1.0 - part) + b.receptance.scale(part))
}

/// The direct receptance of a direction turned by `angle` towards its principal one:
///
/// ```text
/// G′ = c²·G_own + 2·s·c·G_cross + s²·G_other,   c = cos angle, s = ± sin angle
/// ```
///
/// on the lines of its own force: the cross receptance is the other direction's motion under
/// this force (reciprocity), the other's direct one, on other lines, stands between its
/// neighbours with the small weight s².
pub fn turned(
    own: &Response,
    cross: &Response,
    other: &Response,
    angle: f64,
) -> Vec<(f64, Complex<f64>)> {
    let (s, c) = angle.sin_cos();
    let s = if own.from == 0 { s } else { -s };
    own.lines
        .iter()
        .zip(&cross.lines)
        .filter_map(|(a, x)| {
            let o = between(&other.lines, a.f_hz)?;
            let g = a.receptance.scale(c * c) + x.receptance.scale(2.0 * s * c) + o.scale(s * s);
            Some((a.f_hz, g))
        })
        .collect()
}

/// The angle from x to the first principal direction, rad: the one that leaves least of the
/// cross receptance, Σ|(c² − s²)·G_yx + s·c·(G_yy − G_xx)|², within a band.
pub fn principal_angle(xx: &Response, yx: &Response, yy: &Response, band_hz: (f64, f64)) -> f64 {
    // With t = tan 2θ: cross + t/2·(yy − xx) least: a plain least squares in t.
    let (mut above, mut below) = (0.0, 0.0);
    for (a, x) in xx.lines.iter().zip(&yx.lines) {
        if !(band_hz.0..=band_hz.1).contains(&a.f_hz) {
            continue;
        }
        if let Some(o) = between(&yy.lines, a.f_hz) {
            let d = (o - a.receptance).scale(0.5);
            above += d.re * x.receptance.re + d.im * x.receptance.im;
            below += d.norm_sqr();
        }
    }
    if below > 0.0 {
        0.5 * (-above / below).atan()
    } else {
        0.0
    }
}
