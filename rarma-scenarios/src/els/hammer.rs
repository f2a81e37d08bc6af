//! A hammer record: force and response to receptance and modes.

use crate::banded::{Banded, through};
use rarma_core::condition::Band;
use rarma_core::spectrum::{FactorTracker, modal};
use rarma_fit::{ArxOrder, arx};
use rarma_rigs::els::{AgreedMode, Complex, Reading, agreed, fit_modes};

/// What the sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// m/s².
    Acceleration,
    /// m/s.
    Velocity,
    /// m.
    Displacement,
}

/// One blow: force and response, same rate, same length.
#[derive(Debug, Clone, Copy)]
pub struct Blow<'a> {
    /// Force, N.
    pub force: &'a [f64],
    /// Response, in the sensor's SI unit.
    pub response: &'a [f64],
    /// Rate, Hz.
    pub fs: f64,
    /// What the response is.
    pub sensor: Sensor,
}

/// Numbers of modes that are tried on the receptance.
const RATIONAL: std::ops::RangeInclusive<usize> = 3..=8;
/// Orders that are tried on the record, by twos; twice as many poles as the receptance needs: noise
/// and the modes outside the band take their own.
const ARX: (usize, usize) = (16, 32);
/// Room for them: 4n + 3, and 2p + 1.
const ROOM_RATIONAL: usize = 36;
const ROOM_ARX: usize = 66;
/// Readings closer than this, relatively, are one mode.
const WIDTH: f64 = 0.01;
/// Damping above which a pole says nothing about a mode of a machine.
const DAMPED: f64 = 0.2;
/// Share of the response's energy at which the record is taken to have died away; what
/// follows is noise.
const RUNG_OUT: f64 = 0.999;
/// Share of the force's peak at which the blow begins.
const TOUCH: f64 = 0.01;

impl Blow<'_> {
    /// Receptance of the whole record between two frequencies, 1/T apart: the ratio of
    /// the transforms, over (jω)² for an accelerometer. No window: the record holds the
    /// blow and its decay whole.
    ///
    /// # Errors
    /// No line in the band, or no force at one.
    pub fn receptance(
        &self,
        (low, high): (f64, f64),
    ) -> Result<(Vec<f64>, Vec<Complex<f64>>), String> {
        let (force, response) = (transform(self.force)?, transform(self.response)?);
        let step = self.fs / self.force.len() as f64;
        let (mut f, mut g) = (Vec::new(), Vec::new());
        for (k, (x, y)) in force.iter().zip(&response).enumerate().skip(1) {
            let at = k as f64 * step;
            if !(low..=high).contains(&at) {
                continue;
            }
            let ratio = *y * x.inverse();
            if !ratio.is_finite() {
                return Err(format!("the force has no component at {at} Hz"));
            }
            let w = core::f64::consts::TAU * at;
            f.push(at);
            g.push(match self.sensor {
                Sensor::Displacement => ratio,
                Sensor::Velocity => Complex::new(ratio.im / w, -ratio.re / w),
                Sensor::Acceleration => ratio.scale(-1.0 / (w * w)),
            });
        }
        if f.len() < 50 {
            return Err(format!(
                "{} lines between {low} and {high} Hz, at least 50 are needed (record longer, or choose a wider --band)",
                f.len()
            ));
        }
        Ok((f, g))
    }

    /// Modes from the record itself: least squares of A·y = B·F in the time domain,
    /// decimated to the band, from the touch until the response has died away, at
    /// every even order from 16 to 32; those on which half of the orders agree.
    ///
    /// # Errors
    /// The band does not fit the rate; no order could be fitted.
    pub fn modes_in_time(&self, (low, high): (f64, f64)) -> Result<Vec<AgreedMode<f64>>, String> {
        let band = Band {
            low_hz: (0.2 * low).max(high / 200.0),
            high_hz: high,
        };
        let part = |x: &[f64]| through(x, self.fs, band).map_err(|why| why.to_string());
        let Banded {
            samples: force, fs, ..
        } = part(self.force)?;
        let response = part(self.response)?.samples;
        let span = heard(&force, &response);
        let (force, response) = (&force[span.clone()], &response[span]);
        let mut readings = Vec::new();
        let mut fits = 0;
        for p in (ARX.0..=ARX.1).step_by(2) {
            let order = ArxOrder {
                p,
                b: p + 1,
                delay: 0,
            };
            let Ok(fit) = arx::<f64, ROOM_ARX>(response, force, order) else {
                continue;
            };
            let mut roots = FactorTracker::<f64, 32>::new();
            if roots.solve(fit.a(), 500).is_none() {
                continue;
            }
            for mode in roots.factors(p).iter().filter_map(|q| modal(q, fs)) {
                if (low..=high).contains(&mode.frequency) && (0.0..DAMPED).contains(&mode.damping) {
                    readings.push(Reading {
                        f_hz: mode.frequency,
                        zeta: mode.damping,
                        fit: fits,
                    });
                }
            }
            fits += 1;
        }
        if fits == 0 {
            return Err("no model of the record could be fitted".to_owned());
        }
        Ok(collect(&mut readings, fits))
    }
}

/// Modes of a receptance by rational functions of 3 to 8 modes through all its lines;
/// those on which half of them agree.
///
/// # Errors
/// None could be fitted.
pub fn modes_in_frequency(f: &[f64], g: &[Complex<f64>]) -> Result<Vec<AgreedMode<f64>>, String> {
    let mut readings = Vec::new();
    let (mut fits, mut why) = (0, String::new());
    for n in RATIONAL {
        match fit_modes::<f64, ROOM_RATIONAL>(f, g, n) {
            Ok(fit) => {
                let sane = fit.modes().iter().filter(|m| m.zeta < DAMPED);
                readings.extend(sane.map(|m| Reading {
                    f_hz: m.f_hz,
                    zeta: m.zeta,
                    fit: fits,
                }));
                fits += 1;
            }
            Err(no) => why = no.to_string(),
        }
    }
    if fits == 0 {
        return Err(why);
    }
    Ok(collect(&mut readings, fits))
}

fn collect(readings: &mut [Reading<f64>], fits: u32) -> Vec<AgreedMode<f64>> {
    let mut out = Vec::new();
    agreed(readings, fits, WIDTH, |m| out.push(m));
    out
}

/// From the touch until nearly all energy of the response is in.
fn heard(force: &[f64], response: &[f64]) -> std::ops::Range<usize> {
    let peak = force.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let touch = force
        .iter()
        .position(|x| x.abs() > TOUCH * peak)
        .unwrap_or(0);
    // A past of silence before it, which the model takes as it is.
    let from = touch.saturating_sub(ARX.1 + 2);
    let all: f64 = response[from..].iter().map(|y| y * y).sum();
    let mut sum = 0.0;
    let length = response[from..]
        .iter()
        .position(|y| {
            sum += y * y;
            sum >= RUNG_OUT * all
        })
        .unwrap_or(0);
    from..(from + length.max(8 * ARX.1)).min(response.len())
}

fn transform(x: &[f64]) -> Result<Vec<Complex<f64>>, String> {
    let plan = rarma_fourier::forward(x.len());
    let (mut input, mut output) = (x.to_vec(), plan.make_output_vec());
    plan.process(&mut input, &mut output)
        .map_err(|why| why.to_string())?;
    Ok(output.iter().map(|z| Complex::new(z.re, z.im)).collect())
}
