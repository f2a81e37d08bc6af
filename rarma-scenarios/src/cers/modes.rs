//! Modes of a record at constant speed, by three ways that share nothing but the record.

use super::record::CersRecord;
use super::response::{Cleaned, Response, Sensor, principal_angle, response, turned};
use super::table_3::{self, Printed};
use super::time::{self, Read};
use rarma_rigs::els::{AgreedMode, Complex, Reading, agreed, fit_modes};
use rayon::prelude::*;
use serde::Serialize;

/// Numbers of modes that are tried: with fewer than there are, neighbours bend each other.
const TRIED: std::ops::RangeInclusive<usize> = 7..=10;
/// Room for them, 4n + 3.
const ROOM: usize = 44;
/// Readings closer than this, relatively, are one mode.
const WIDTH: f64 = 0.01;
/// Damping above which a pole says nothing about a mode of a machine.
const DAMPED: f64 = 0.2;
/// Deviation of a damping ratio, part of it, above which there is no mode.
const LOOSE: f64 = 0.2;
/// Parts of the record for the deviations, each left out once.
const PARTS: usize = 8;
/// A mode of one method is that of another if they are this close, relatively.
const SAME: f64 = 0.025;

/// A mode of a direction with what each method says of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModeRow {
    /// "x" or "y": the principal direction nearest to it.
    pub axis: &'static str,
    /// By rational functions through the response; deviations by leaving out eighths of
    /// the record.
    pub f: f64,
    /// Standard deviation, Hz.
    pub f_sd: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Standard deviation.
    pub zeta_sd: f64,
    /// Fits that agree on it.
    pub fits: u32,
    /// By ARX with instruments, force known; deviations of the fit's covariance.
    pub arx: Option<Read>,
    /// By ARMA(30,29) of the acceleration alone.
    pub arma: Option<Read>,
    /// The thesis' table 3.
    pub table_3: Option<Printed>,
    /// What the simulation knows: frequency Hz, damping ratio.
    pub truth: Option<(f64, f64)>,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Modes {
    /// From x to the first principal direction, degrees; 0 unless both were driven.
    pub principal_deg: f64,
    /// The modes, x first, by rising frequency.
    pub modes: Vec<ModeRow>,
}

/// The receptance along a principal direction, and the angle from x.
#[derive(Debug, Clone)]
pub struct Direct {
    /// 0 for x, 1 for y.
    pub axis: usize,
    /// Frequencies, Hz.
    pub f_hz: Vec<f64>,
    /// Receptance, m/N.
    pub g: Vec<Complex<f64>>,
}

/// Direct receptances along the principal directions, blocks left out as `skip` says.
///
/// # Errors
/// In words.
pub fn direct(
    record: &CersRecord,
    clean: &Cleaned,
    band_hz: (f64, f64),
    skip: &(dyn Fn(usize) -> bool + Sync),
) -> Result<(f64, Vec<Direct>), String> {
    let one = |from, to| response(record, clean, (from, to), Sensor::Displacement, skip);
    let axes = record.setup.drive.axes;
    let cut = |axis, lines: Vec<(f64, Complex<f64>)>| {
        let (f_hz, g) = lines
            .into_iter()
            .filter(|l| (band_hz.0..=band_hz.1).contains(&l.0))
            .unzip();
        Direct { axis, f_hz, g }
    };
    if axes == [true, true] {
        let (xx, yx, xy, yy) = (one(0, 0)?, one(0, 1)?, one(1, 0)?, one(1, 1)?);
        let angle = principal_angle(&xx, &yx, &yy, band_hz);
        let directs = vec![
            cut(0, turned(&xx, &yx, &yy, angle)),
            cut(1, turned(&yy, &xy, &xx, angle)),
        ];
        return Ok((angle, directs));
    }
    let axis = usize::from(axes[1]);
    let own: Response = one(axis, axis)?;
    let lines = own.lines.iter().map(|l| (l.f_hz, l.receptance)).collect();
    Ok((0.0, vec![cut(axis, lines)]))
}

/// Modes on which rational functions of seven to ten modes agree.
pub fn rational(direct: &Direct) -> Vec<AgreedMode<f64>> {
    let mut readings = Vec::new();
    let mut fits = 0;
    for n in TRIED {
        if let Ok(fit) = fit_modes::<f64, ROOM>(&direct.f_hz, &direct.g, n) {
            let sane = fit.modes().iter().filter(|m| m.zeta < DAMPED);
            readings.extend(sane.map(|m| Reading {
                f_hz: m.f_hz,
                zeta: m.zeta,
                fit: fits,
            }));
            fits += 1;
        }
    }
    let mut out = Vec::new();
    agreed(&mut readings, fits, WIDTH, |m| out.push(m));
    out
}

/// A rational function through a response.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its modes.
    pub modes: usize,
    /// Part of the response that it leaves.
    pub left: f64,
    /// Its values at the response's frequencies, m/N.
    pub g: Vec<Complex<f64>>,
}

/// The one of the most modes that goes, of those that [`rational`] tries.
pub fn curve_of(direct: &Direct) -> Option<Curve> {
    TRIED.rev().find_map(|modes| {
        let fit = fit_modes::<f64, ROOM>(&direct.f_hz, &direct.g, modes).ok()?;
        Some(Curve {
            modes,
            left: fit.residual(),
            g: direct.f_hz.iter().map(|f| fit.at(*f)).collect(),
        })
    })
}

/// Modes of a record at constant speed.
///
/// # Errors
/// In words.
pub fn modes(
    record: &CersRecord,
    clean: &Cleaned,
    band_hz: (f64, f64),
    in_time: bool,
) -> Result<Modes, String> {
    let blocks = record.len() / super::BLOCK;
    let parts = PARTS.min(blocks);
    let (angle, all) = direct(record, clean, band_hz, &|_| false)?;
    let found: Vec<(usize, Vec<AgreedMode<f64>>)> =
        all.par_iter().map(|d| (d.axis, rational(d))).collect();
    // One eighth left out at a time.
    let without: Vec<Vec<Vec<AgreedMode<f64>>>> = (0..parts)
        .into_par_iter()
        .map(|part| {
            let (_, all) = direct(record, clean, band_hz, &|k| k * parts / blocks == part)?;
            Ok(all.iter().map(rational).collect())
        })
        .collect::<Result<_, String>>()?;
    let speed = record.speeds_hz().0;
    let mut rows = Vec::new();
    for (k, (axis, list)) in found.iter().enumerate() {
        let (arx, arma) = if in_time {
            let pair = rayon::join(
                || time::arx(record, clean, *axis, angle, band_hz),
                || time::arma(record, clean, *axis, angle, band_hz),
            );
            (pair.0?, pair.1?)
        } else {
            (Vec::new(), Vec::new())
        };
        let truth = record.setup.truth.as_ref().map(|t| t.at(*axis, speed));
        for m in list {
            let leave_out = |of: fn(&AgreedMode<f64>) -> f64| {
                let values: Vec<f64> = without
                    .iter()
                    .filter_map(|w| nearest(&w[k], m.f_hz, |x| x.f_hz).map(|x| of(&x)))
                    .collect();
                jackknife(&values, parts)
            };
            let (f_sd, zeta_sd) = (leave_out(|x| x.f_hz), leave_out(|x| x.zeta));
            // What two eighths of the record do not show when left out is noise, and what
            // moves by a fifth with them.
            if !(f_sd.is_finite() && zeta_sd < LOOSE * m.zeta) {
                continue;
            }
            rows.push(ModeRow {
                axis: ["x", "y"][*axis],
                f: m.f_hz,
                f_sd,
                zeta: m.zeta,
                zeta_sd,
                fits: m.fits,
                arx: nearest(&arx, m.f_hz, |x| x.f),
                arma: nearest(&arma, m.f_hz, |x| x.f),
                table_3: table_3::nearest(*axis, m.f_hz),
                truth: truth.as_ref().and_then(|t| nearest(t, m.f_hz, |x| x.0)),
            });
        }
    }
    Ok(Modes {
        principal_deg: angle.to_degrees(),
        modes: rows,
    })
}

/// The member nearest to a frequency, if it is near enough.
pub fn nearest<V: Copy>(list: &[V], f_hz: f64, of: impl Fn(&V) -> f64) -> Option<V> {
    list.iter()
        .min_by(|a, b| (of(a) - f_hz).abs().total_cmp(&(of(b) - f_hz).abs()))
        .filter(|x| (of(x) / f_hz - 1.0).abs() < SAME)
        .copied()
}

/// √((n − 1)/n·Σ(x − mean)²); NaN if more than one part lost the mode.
fn jackknife(values: &[f64], parts: usize) -> f64 {
    if parts < 2 || values.len() + 1 < parts {
        return f64::NAN;
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    ((n - 1.0) / n * squares).sqrt()
}
