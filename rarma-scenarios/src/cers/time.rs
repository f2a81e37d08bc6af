//! Modes from the record itself: with the force known, and from the response alone.

use super::record::CersRecord;
use super::response::Cleaned;
use crate::banded;
use rarma_core::condition::Band;
use rarma_core::spectrum::{FactorTracker, Roots, modal};
use rarma_fit::{ArxOrder, Pem, PemConfig, arx_instruments};
use rarma_rigs::els::{Reading, agreed};
use serde::Serialize;

/// A mode as one method reads it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Read {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Its standard deviation, Hz.
    pub f_sd: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Its standard deviation.
    pub zeta_sd: f64,
}

/// Orders tried with the force known.
const ARX: [usize; 2] = [24, 30];
/// Samples it sees at most: fifteen seconds of computing a direction otherwise.
const ARX_SAMPLES: usize = 12_000;
/// Room for 2p + 1.
const ARX_ROOM: usize = 66;
/// The thesis' order.
const ARMA: (usize, usize) = (30, 29);
const ARMA_ROOM: usize = 60;
/// Samples of the response that the ARMA model sees at most: its search is slow.
const ARMA_SAMPLES: usize = 6000;
/// Damping above which a pole says nothing about a mode of a machine.
const DAMPED: f64 = 0.2;

/// x·cos + y·sin for the first principal direction, −x·sin + y·cos for the second.
fn along(pair: &[Vec<f64>; 2], axis: usize, angle: f64) -> Vec<f64> {
    let (s, c) = angle.sin_cos();
    let (a, b) = [(c, s), (-s, c)][axis];
    pair[0]
        .iter()
        .zip(&pair[1])
        .map(|(x, y)| a * x + b * y)
        .collect()
}

/// Decimated to the band; and the rate that is left, Hz.
fn conditioned(x: &[f64], fs: f64, (low, high): (f64, f64)) -> Result<(Vec<f64>, f64), String> {
    let band = Band {
        low_hz: 0.4 * low,
        high_hz: high,
    };
    let part = banded::through(x, fs, band).map_err(|why| why.to_string())?;
    // The filters' own beginning.
    let skip = ((0.02 * part.fs) as usize).min(part.samples.len());
    Ok((part.samples[skip..].to_vec(), part.fs))
}

/// A·x = B·F along a principal direction, by refined instruments at two orders.
///
/// # Errors
/// In words: the band does not fit the rate.
pub fn arx(
    record: &CersRecord,
    clean: &Cleaned,
    axis: usize,
    angle: f64,
    band_hz: (f64, f64),
) -> Result<Vec<Read>, String> {
    let fs = record.setup.rate_hz;
    let (force, rate) = conditioned(&along(&clean.force_n, axis, angle), fs, band_hz)?;
    let (motion, _) = conditioned(&along(&clean.displacement_m, axis, angle), fs, band_hz)?;
    let n = force.len().min(motion.len()).min(ARX_SAMPLES);
    let (force, motion) = (&force[..n], &motion[..n]);
    let mut readings = Vec::new();
    let mut all = Vec::new();
    let mut fits = 0;
    for p in ARX {
        let order = ArxOrder {
            p,
            b: p + 1,
            delay: 0,
        };
        let Ok(fit) = arx_instruments::<f64, ARX_ROOM>(motion, force, order) else {
            continue;
        };
        let mut roots = FactorTracker::<f64, 32>::new();
        if roots.solve(fit.a(), 500).is_none() {
            continue;
        }
        for q in roots.factors(p) {
            let (Some(m), Roots::Pair { re, im }) = (modal(q, rate), q.roots()) else {
                continue;
            };
            if !sane(m.frequency, m.damping, band_hz) {
                continue;
            }
            readings.push(Reading {
                f_hz: m.frequency,
                zeta: m.damping,
                fit: fits,
            });
            let sd = fit.pole(re, im, rate);
            all.push((m.frequency, sd.map(|d| (d.frequency, d.damping))));
        }
        fits += 1;
    }
    let mut out = Vec::new();
    agreed(&mut readings, fits, 0.01, |m| {
        // The deviation of the reading nearest to the median.
        let sd = all
            .iter()
            .min_by(|a, b| (a.0 - m.f_hz).abs().total_cmp(&(b.0 - m.f_hz).abs()))
            .and_then(|a| a.1)
            .unwrap_or((f64::NAN, f64::NAN));
        out.push(Read {
            f: m.f_hz,
            f_sd: sd.0,
            zeta: m.zeta,
            zeta_sd: sd.1,
        });
    });
    Ok(out)
}

/// ARMA(30,29) of the acceleration alone along a principal direction: what the thesis calls
/// the parametric method.
///
/// # Errors
/// In words: the band does not fit the rate.
pub fn arma(
    record: &CersRecord,
    clean: &Cleaned,
    axis: usize,
    angle: f64,
    band_hz: (f64, f64),
) -> Result<Vec<Read>, String> {
    let fs = record.setup.rate_hz;
    let motion = along(&clean.acceleration_m_per_s2, axis, angle);
    let (y, rate) = conditioned(&motion, fs, band_hz)?;
    let y = &y[..y.len().min(ARMA_SAMPLES)];
    let fit = Pem::new(PemConfig::default()).and_then(|m| m.fit::<ARMA_ROOM>(y, ARMA.0, ARMA.1));
    let Ok(fit) = fit else {
        return Ok(Vec::new());
    };
    let mut roots = FactorTracker::<f64, ARMA_ROOM>::new();
    if roots.solve(fit.a(), 4000).is_none() {
        return Ok(Vec::new());
    }
    let mut out: Vec<Read> = roots
        .factors(ARMA.0)
        .iter()
        .filter_map(|q| {
            let m = modal(q, rate)?;
            let Roots::Pair { re, im } = q.roots() else {
                return None;
            };
            let sd = fit.pole(re, im, rate);
            sane(m.frequency, m.damping, band_hz).then_some(Read {
                f: m.frequency,
                f_sd: sd.map_or(f64::NAN, |d| d.frequency),
                zeta: m.damping,
                zeta_sd: sd.map_or(f64::NAN, |d| d.damping),
            })
        })
        .collect();
    out.sort_by(|a, b| a.f.total_cmp(&b.f));
    Ok(out)
}

fn sane(f: f64, zeta: f64, (low, high): (f64, f64)) -> bool {
    (low..=high).contains(&f) && (0.0..DAMPED).contains(&zeta)
}
