//! `rarma psd`: power spectral density of a recording.

use super::estimators::{self, Memory};
use super::identify::{self, with_stack};
use super::monitor::read;
use crate::args::{Detrend, Method, PsdArgs, PsdMethod};
use crate::failure::Failure;
use rarma_core::spectrum::{model_density, welch_density, windowed_density};
use realfft::RealFftPlanner;
use serde::Serialize;

/// Frequencies of the grid for models.
const GRID: usize = 2048;
/// Longest stretch of Welch's estimate, samples.
const WELCH_SAMPLES: usize = 4096;

/// The JSON of `rarma psd`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Density {
    /// Frequencies, Hz.
    pub f: Vec<f64>,
    /// One-sided density, input units²/Hz.
    pub psd: Vec<f64>,
}

pub(super) fn main(args: &PsdArgs) -> Result<u8, Failure> {
    let recording = read(&args.input)?;
    let file = recording.path.display().to_string();
    let (_, y) = identify::detrended(&recording.samples, Detrend::Mean);
    let density = density(&y, recording.fs, args).map_err(|why| match why {
        Trouble::Usage(why) => Failure::Usage(why),
        Trouble::Series(why) => {
            Failure::whole(&file, why, "record longer, or choose a lower order")
        }
    })?;
    if args.json {
        let text = serde_json::to_string(&density).map_err(std::io::Error::from)?;
        say!("{text}");
    } else {
        say!("# f_Hz,psd_per_Hz");
        for (f, s) in density.f.iter().zip(&density.psd) {
            say!("{f},{s:e}");
        }
    }
    Ok(0)
}

/// Why there is no density.
#[derive(Debug)]
pub enum Trouble {
    /// The command line.
    Usage(String),
    /// The series.
    Series(String),
}

/// Density of a series without its mean.
///
/// # Errors
/// The order is missing, or the fit is refused.
pub fn density(y: &[f64], fs: f64, args: &PsdArgs) -> Result<Density, Trouble> {
    let (f, psd): (Vec<f64>, Vec<f64>) = match (args.at, args.method) {
        (Some(f), _) if f > fs / 2.0 => {
            return Err(Trouble::Usage(format!(
                "--at: {f} Hz lies above half the rate, {} Hz",
                fs / 2.0
            )));
        }
        (Some(f), PsdMethod::Periodogram) => (vec![f], vec![windowed_density(y, |_| 1.0, f, fs)]),
        (Some(f), PsdMethod::Welch) => (vec![f], vec![welch_density(y, stretch(y.len()), f, fs)]),
        (None, PsdMethod::Periodogram) => transformed(y, y.len(), |_| 1.0, fs),
        (None, PsdMethod::Welch) => welch(y, fs),
        (at, PsdMethod::Ar | PsdMethod::Arma) => {
            let order = args
                .order
                .ok_or_else(|| Trouble::Usage("--order P,Q is needed for a model".to_owned()))?;
            let method = if args.method == PsdMethod::Ar {
                Method::Burg
            } else {
                Method::Pem
            };
            if args.method == PsdMethod::Ar && order.1 > 0 {
                return Err(Trouble::Usage(format!(
                    "--method ar: --order must be {},0",
                    order.0
                )));
            }
            let memory = Memory {
                forgetting: 1.0,
                random_walk: 0.0,
            };
            let model = with_stack(|| estimators::fit(method, y, order, memory))
                .map_err(Trouble::Series)?;
            let sigma2 = model.sigma2.unwrap_or(f64::NAN);
            let frequencies: Vec<f64> = match at {
                Some(f) => vec![f],
                None => (0..=GRID)
                    .map(|k| k as f64 * fs / 2.0 / GRID as f64)
                    .collect(),
            };
            let psd = frequencies
                .iter()
                .map(|&f| model_density(&model.a, &model.c, sigma2, f, fs))
                .collect();
            (frequencies, psd)
        }
    };
    Ok(Density { f, psd })
}

/// Length of Welch's stretches: at least eight half-overlapping ones.
fn stretch(n: usize) -> usize {
    (n / 4).next_power_of_two().clamp(8, WELCH_SAMPLES).min(n)
}

fn welch(y: &[f64], fs: f64) -> (Vec<f64>, Vec<f64>) {
    let length = stretch(y.len());
    let hann = |n: usize| 0.5 * (1.0 - (std::f64::consts::TAU * n as f64 / length as f64).cos());
    let (mut f, mut sum, mut count) = (Vec::new(), Vec::new(), 0.0);
    let mut from = 0;
    while let Some(part) = y.get(from..from + length) {
        let (frequencies, psd) = transformed(part, length, hann, fs);
        if sum.is_empty() {
            (f, sum) = (frequencies, psd);
        } else {
            sum.iter_mut().zip(&psd).for_each(|(s, x)| *s += x);
        }
        count += 1.0;
        from += (length / 2).max(1);
    }
    (f, sum.iter().map(|s| s / count).collect())
}

/// All frequencies of one stretch by a fast transform; the scale is that of
/// [`windowed_density`].
fn transformed(
    x: &[f64],
    n: usize,
    window: impl Fn(usize) -> f64,
    fs: f64,
) -> (Vec<f64>, Vec<f64>) {
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut input: Vec<f64> = x.iter().enumerate().map(|(k, x)| x * window(k)).collect();
    let power: f64 = (0..n).map(|k| window(k).powi(2)).sum();
    let mut lines = transform.make_output_vec();
    if transform.process(&mut input, &mut lines).is_err() {
        return (Vec::new(), Vec::new());
    }
    lines
        .iter()
        .enumerate()
        .map(|(k, z)| {
            let sides = if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
            (
                k as f64 * fs / n as f64,
                sides * z.norm_sqr() / (fs * power),
            )
        })
        .unzip()
}
