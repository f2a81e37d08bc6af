//! Tracks of modes over the spindle's speed, by two ways.
//!
//! The response alone, sample by sample: RARMA(6,5) with forgetting on the accelerometer.
//! And with the force known: ARX with instruments, stretch by stretch. Where an order of the
//! spindle or a line of its bearings lies within a mode's half-power band the response is not
//! that of the structure to noise: the reading is labelled a crossing and not believed.

use super::record::CersRecord;
use super::response::Cleaned;
use crate::banded;
use rarma_core::condition::Band;
use rarma_core::estimate::{Arma65, RarmaConfig, Status};
use rarma_core::spectrum::{FactorTracker, Quadratic, Roots, deviation, modal};
use rarma_fit::{ArxOrder, arx_instruments};
use rayon::prelude::*;
use serde::Serialize;

/// Memory of the recursion, and length of a stretch, s.
const MEMORY_S: f64 = 2.0;
/// Time between two readings, s.
const EVERY_S: f64 = 0.25;
/// Poles beyond this damping are no mode.
const DAMPED: f64 = 0.25;
/// Poles of the model of a stretch.
const ARX: usize = 12;
const ARX_ROOM: usize = 26;
/// A pole belongs to a track if it is this close to the last believed one, relatively.
const NEAR: f64 = 0.08;
/// Gain of a believed reading on the place where the next is sought.
const FOLLOW: f64 = 0.2;
/// Standard deviation of the damping, part of it, above which a reading is too loose.
const LOOSE: f64 = 0.25;

/// A reading of a track.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// Time of the middle of the memory, s.
    pub t: f64,
    /// Speed there, 1/min.
    pub rpm: f64,
    /// Frequency, Hz.
    pub f: f64,
    /// Its standard deviation, Hz.
    pub f_sd: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Its standard deviation.
    pub zeta_sd: f64,
    /// What crosses the mode: the order, times a revolution; not to be believed then.
    pub crossing: Option<f64>,
    /// No crossing, and a damping that is known to a quarter.
    pub believed: bool,
    /// What the simulation knows: frequency Hz, damping ratio.
    pub truth: Option<(f64, f64)>,
}

/// Errors of the believed readings against the truth, parts; over their own deviations
/// as well.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Believed readings.
    pub believed: usize,
    /// Median of the magnitude.
    pub f_median: f64,
    /// 95 of 100 are below.
    pub f_95: f64,
    /// The same of the damping.
    pub zeta_median: f64,
    /// The same of the damping.
    pub zeta_95: f64,
    /// Part of the believed readings within two of their own deviations, frequency.
    pub f_within_2: f64,
    /// The same of the damping.
    pub zeta_within_2: f64,
    /// Least damping over the truth among the crossings: how deep the dips are.
    pub deepest_dip: Option<f64>,
}

/// A track.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Track {
    /// "x" or "y".
    pub axis: &'static str,
    /// Band of the model, Hz.
    pub band_hz: (f64, f64),
    /// "rarma" or "arx".
    pub method: &'static str,
    /// Readings over time.
    pub points: Vec<Point>,
    /// Against the truth, if there is one.
    pub against_truth: Option<Errors>,
}

/// A sweep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sweep {
    /// The tracks.
    pub tracks: Vec<Track>,
}

/// One reading of all poles in a band.
struct Snapshot {
    t: f64,
    poles: Vec<[f64; 4]>,
}

/// Tracks of every band of the record's setup; of one over everything if it names none.
///
/// # Errors
/// In words: a band that does not fit the rate.
pub fn sweep(record: &CersRecord, clean: &Cleaned) -> Result<Sweep, String> {
    let axis = usize::from(!record.setup.drive.axes[0]);
    let bands = if record.setup.tracks_hz.is_empty() {
        vec![(400.0, 1100.0)]
    } else {
        record.setup.tracks_hz.clone()
    };
    let jobs: Vec<((f64, f64), bool)> = bands
        .iter()
        .flat_map(|b| [(*b, false), (*b, true)])
        .collect();
    let tracks: Vec<Vec<Track>> = jobs
        .par_iter()
        .map(|&(band, known)| {
            let snapshots = if known {
                stretches(record, clean, axis, band)?
            } else {
                recursion(record, axis, band)?
            };
            let method = if known { "arx" } else { "rarma" };
            Ok(follow(record, axis, band, method, &snapshots))
        })
        .collect::<Result<_, String>>()?;
    Ok(Sweep {
        tracks: tracks.into_iter().flatten().collect(),
    })
}

fn through(x: &[f64], fs: f64, (low, high): (f64, f64)) -> Result<(Vec<f64>, f64, f64), String> {
    let band = Band {
        low_hz: low,
        high_hz: high,
    };
    let part = banded::through(x, fs, band).map_err(|why| format!("track: {why}"))?;
    Ok((part.samples, part.fs, part.delay_s))
}

/// RARMA(6,5) on the acceleration.
fn recursion(record: &CersRecord, axis: usize, band: (f64, f64)) -> Result<Vec<Snapshot>, String> {
    let (y, rate, delay) = through(
        &record.acceleration_m_per_s2[axis],
        record.setup.rate_hz,
        band,
    )?;
    let gain = 1.0 / (MEMORY_S * rate);
    let mut model = Arma65::<f64>::new(RarmaConfig {
        forgetting: 1.0 - gain,
        variance_gain: gain,
        ..RarmaConfig::default()
    });
    let every = ((EVERY_S * rate) as usize).max(1);
    let first = (MEMORY_S * rate) as usize;
    let mut out = Vec::new();
    for (n, y) in y.iter().enumerate() {
        let step = model.update(*y);
        if n < first
            || n % every != 0
            || !matches!(step.status, Status::Running | Status::Limiting(_))
        {
            continue;
        }
        let mut roots = FactorTracker::<f64, 6>::new();
        if roots.solve(model.a(), 400).is_none() {
            continue;
        }
        let (covariance, scale) = (model.covariance(), model.covariance_factor());
        let pole = |q: &Quadratic<f64>| {
            let m = modal(q, rate)?;
            let sd = deviation(model.a(), 11, q, rate, covariance, scale)?;
            Some([m.frequency, sd.frequency, m.damping, sd.damping])
        };
        // Forgetting weighs the past as e^{−age/memory}: its middle is a memory ago.
        out.push(Snapshot {
            t: n as f64 / rate - delay - MEMORY_S,
            poles: roots.factors(6).iter().filter_map(pole).collect(),
        });
    }
    Ok(out)
}

/// ARX with instruments, stretch by stretch, the force known.
fn stretches(
    record: &CersRecord,
    clean: &Cleaned,
    axis: usize,
    band: (f64, f64),
) -> Result<Vec<Snapshot>, String> {
    let fs = record.setup.rate_hz;
    let (y, rate, delay) = through(&record.acceleration_m_per_s2[axis], fs, band)?;
    let (u, ..) = through(&clean.force_n[axis], fs, band)?;
    let (length, every) = (
        (2.0 * MEMORY_S * rate) as usize,
        (2.0 * EVERY_S * rate) as usize,
    );
    let starts: Vec<usize> = (0..y.len().saturating_sub(length)).step_by(every).collect();
    Ok(starts
        .par_iter()
        .filter_map(|&from| {
            let order = ArxOrder {
                p: ARX,
                b: ARX + 1,
                delay: 0,
            };
            let (y, u) = (&y[from..from + length], &u[from..from + length]);
            // Rounds that do not settle, as where a line crosses the mode, end at a model that rounding decides.
            let fit = arx_instruments::<f64, ARX_ROOM>(y, u, order).ok()?;
            let fit = fit.converged().then_some(fit)?;
            let mut roots = FactorTracker::<f64, ARX>::new();
            roots.solve(fit.a(), 400)?;
            let pole = |q: &Quadratic<f64>| {
                let m = modal(q, rate)?;
                let Roots::Pair { re, im } = q.roots() else {
                    return None;
                };
                let sd = fit.pole(re, im, rate)?;
                Some([m.frequency, sd.frequency, m.damping, sd.damping])
            };
            Some(Snapshot {
                t: from as f64 / rate - delay + MEMORY_S,
                poles: roots.factors(ARX).iter().filter_map(pole).collect(),
            })
        })
        .collect())
}

/// Poles to tracks: each begins with the first snapshot that shows it, and takes the pole
/// nearest to where it was last believed.
fn follow(
    record: &CersRecord,
    axis: usize,
    band: (f64, f64),
    method: &'static str,
    snapshots: &[Snapshot],
) -> Vec<Track> {
    let inside = |p: &&[f64; 4]| {
        (1.02 * band.0..=0.98 * band.1).contains(&p[0])
            && (0.005..DAMPED).contains(&p[2])
            && p[3] < 0.3 * p[2]
    };
    let Some(first) = snapshots
        .iter()
        .find(|s| s.poles.iter().any(|p| inside(&p)))
    else {
        return Vec::new();
    };
    let speed = |t: f64| -> f64 {
        let fs = record.setup.rate_hz;
        let half = (0.05 * fs) as usize;
        let last = record.len().saturating_sub(1);
        let at = ((t.max(0.0) * fs) as usize).min(last);
        let (a, b) = (at.saturating_sub(half), (at + half).min(last));
        (record.revolutions[b] - record.revolutions[a]) * fs / (b - a).max(1) as f64
    };
    let mut out = Vec::new();
    for seed in first.poles.iter().filter(inside) {
        let (mut place, mut damping) = (seed[0], seed[2]);
        let mut points = Vec::new();
        for s in snapshots {
            let near = s
                .poles
                .iter()
                .filter(|p| p[2] > -0.05 && p[2] < DAMPED)
                .min_by(|a, b| (a[0] - place).abs().total_cmp(&(b[0] - place).abs()))
                .filter(|p| (p[0] / place - 1.0).abs() < NEAR);
            let Some(&[f, f_sd, zeta, zeta_sd]) = near else {
                continue;
            };
            let (now, before, after) = (speed(s.t), speed(s.t - MEMORY_S), speed(s.t + MEMORY_S));
            // An order within the mode's band, or one that the pole itself has gone to.
            let width = damping.max(0.02);
            let crossing = crossed(record, place, width, before, after)
                .or_else(|| crossed(record, f, zeta.clamp(0.02, width), before, after));
            let believed = crossing.is_none() && zeta_sd < LOOSE * zeta;
            if believed {
                place += FOLLOW * (f - place);
                damping += FOLLOW * (zeta - damping);
            }
            points.push(Point {
                t: s.t,
                rpm: 60.0 * now,
                f,
                f_sd,
                zeta,
                zeta_sd,
                crossing,
                believed,
                truth: None,
            });
        }
        let mut track = Track {
            axis: ["x", "y"][axis],
            band_hz: band,
            method,
            points,
            against_truth: None,
        };
        // Two seeds of one mode end on one track.
        let same = |other: &Track| {
            let at = |t: &Track| t.points.last().map_or(0.0, |p| p.f);
            (at(other) / at(&track) - 1.0).abs() < 1e-3
        };
        if !out.iter().any(same) {
            compare(record, axis, seed[0], &mut track);
            out.push(track);
        }
    }
    out
}

/// The first order that lies within a mode's half-power band at some time of the memory.
fn crossed(record: &CersRecord, f: f64, zeta: f64, before_hz: f64, after_hz: f64) -> Option<f64> {
    let (low, high) = (f * (1.0 - zeta), f * (1.0 + zeta));
    record
        .setup
        .orders
        .iter()
        .copied()
        .find(|o| o * before_hz.min(after_hz) <= high && o * before_hz.max(after_hz) >= low)
}

fn compare(record: &CersRecord, axis: usize, at_start: f64, track: &mut Track) {
    let Some(truth) = &record.setup.truth else {
        return;
    };
    let rest = truth.at(axis, 0.0);
    let Some(k) = (0..rest.len()).min_by(|a, b| {
        (rest[*a].0 - at_start)
            .abs()
            .total_cmp(&(rest[*b].0 - at_start).abs())
    }) else {
        return;
    };
    let (mut f, mut zeta) = (Vec::new(), Vec::new());
    let (mut f_in, mut zeta_in) = (0u32, 0u32);
    let mut dip: Option<f64> = None;
    for p in &mut track.points {
        let (tf, tz) = truth.at(axis, p.rpm / 60.0)[k];
        p.truth = Some((tf, tz));
        if p.crossing.is_some() {
            dip = Some(dip.map_or(p.zeta / tz, |d| d.min(p.zeta / tz)));
        }
        if !p.believed {
            continue;
        }
        f.push((p.f / tf - 1.0).abs());
        zeta.push((p.zeta / tz - 1.0).abs());
        f_in += u32::from((p.f - tf).abs() < 2.0 * p.f_sd);
        zeta_in += u32::from((p.zeta - tz).abs() < 2.0 * p.zeta_sd);
    }
    if f.is_empty() {
        return;
    }
    f.sort_by(f64::total_cmp);
    zeta.sort_by(f64::total_cmp);
    let at =
        |list: &[f64], part: f64| list[((part * list.len() as f64) as usize).min(list.len() - 1)];
    let n = f.len() as f64;
    track.against_truth = Some(Errors {
        believed: f.len(),
        f_median: at(&f, 0.5),
        f_95: at(&f, 0.95),
        zeta_median: at(&zeta, 0.5),
        zeta_95: at(&zeta, 0.95),
        f_within_2: f64::from(f_in) / n,
        zeta_within_2: f64::from(zeta_in) / n,
        deepest_dip: dip,
    });
}
