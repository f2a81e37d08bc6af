//! `rarma psd`: power spectral density of a recording.

use super::band::{self, Part};
use super::convert;
use super::estimators::{self, Memory};
use super::fitting::{REMEDY, with_stack};
use super::show;
use super::source::read;
use crate::args::{Detrend, Method, PsdArgs, PsdMethod};
use crate::failure::Failure;
use crate::output;
use rarma_fit::{model_density, welch_density, windowed_density};
use rarma_recordings::export::{Along, Column, Table};
use rarma_recordings::input::Recording;
use serde::Serialize;
use std::path::Path;

/// Frequencies of the grid for models.
const GRID: usize = 2048;
/// Longest stretch of Welch's estimate, samples.
const WELCH_SAMPLES: usize = 4096;

/// Samples that a density is made of at least.
const LEAST_SAMPLES: usize = 8;

/// The JSON of `rarma psd`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Density {
    /// Band that was looked at, `[LO, HI]`, Hz; null for all of the recording.
    pub band: Option<[f64; 2]>,
    /// Rate of the samples it was made of, Hz.
    pub fs: f64,
    /// How many they are.
    pub n: usize,
    /// Frequencies, Hz.
    pub f: Vec<f64>,
    /// One-sided density, input units²/Hz.
    pub psd: Vec<f64>,
}

pub(super) fn main(args: &PsdArgs) -> Result<u8, Failure> {
    let order = order(args)?;
    let recording = read(&args.input)?;
    let part = Part::of(&recording, args.band, Detrend::Mean)?;
    let work = order.map_or(0.0, |(m, o)| estimators::work(m, part.samples.len(), o));
    part.warn_of(work, &args.input.input);
    let bar = show::waiting(format!("density of {} samples", part.samples.len()));
    let density = density_named(&part, args, order, &args.input.input);
    bar.finish_and_clear();
    let density = density?;
    if let Some(path) = &args.out {
        output::keep(vec![output::export(
            path,
            "--out",
            &table(&density, args, &recording),
        )?])?;
        if !args.json {
            say!(
                "{}: {} frequencies, {}",
                path.display(),
                density.f.len(),
                part.words()
            );
            return Ok(0);
        }
    }
    if args.json {
        let text = serde_json::to_string(&density).map_err(std::io::Error::from)?;
        say!("{text}");
    } else {
        say!("# {}", part.words());
        say!("# f_Hz,psd_per_Hz");
        for (f, s) in density.f.iter().zip(&density.psd) {
            say!("{f},{s:e}");
        }
    }
    Ok(0)
}

/// A density for a file.
fn table(density: &Density, args: &PsdArgs, recording: &Recording) -> Table {
    let first = density.f.first().copied().unwrap_or(0.0);
    let last = density.f.last().copied().unwrap_or(first);
    let steps = density.f.len().saturating_sub(1).max(1);
    Table {
        title: format!("power spectral density of {}", args.input.input.display()),
        along: Along::Frequency {
            first,
            step: (last - first) / steps as f64,
        },
        columns: vec![Column {
            name: "psd".to_owned(),
            channel: args.input.channel,
            unit: format!("({})^2/Hz", convert::unit(args.unit.as_deref(), recording)),
            values: density.psd.clone(),
        }],
    }
}

/// What `rarma psd` says of a recording that has been read; `args.input` does not count.
///
/// # Errors
/// As those of the command.
pub fn psd_recording(recording: &Recording, args: &PsdArgs) -> Result<Density, Failure> {
    let order = order(args)?;
    let part = Part::of(recording, args.band, Detrend::Mean)?;
    density_named(&part, args, order, &recording.path)
}

fn density_named(
    part: &Part,
    args: &PsdArgs,
    order: Option<Fit>,
    file: &Path,
) -> Result<Density, Failure> {
    if let Some(f) = args.at {
        check_frequency(f, part)?;
    }
    with_stack(|| density(part, args, order))
        .map_err(|why| Failure::Input(format!("{}: {why}", file.display())))
}

/// Estimator and order of a model.
type Fit = (Method, (usize, usize));

/// What is fitted; nothing for a transform.
fn order(args: &PsdArgs) -> Result<Option<Fit>, Failure> {
    let method = match args.method {
        PsdMethod::Periodogram | PsdMethod::Welch => return Ok(None),
        PsdMethod::Ar => Method::Burg,
        PsdMethod::Arma => Method::Pem,
    };
    let order = args
        .order
        .ok_or_else(|| Failure::Usage("--order P,Q is needed for a model".to_owned()))?;
    if args.method == PsdMethod::Ar && order.1 > 0 {
        return Err(Failure::Usage(format!(
            "--method ar: --order must be {},0",
            order.0
        )));
    }
    Ok(Some((method, order)))
}

fn check_frequency(f: f64, part: &Part) -> Result<(), Failure> {
    let (low, high) = part.edges();
    if (low..=high).contains(&f) {
        return Ok(());
    }
    Err(Failure::Usage(match part.band {
        None => format!("--at: {f} Hz lies above half the rate, {high} Hz"),
        Some(_) => format!(
            "--at: {f} Hz lies outside the band {low}:{high} Hz (choose another --band, or --band full)"
        ),
    }))
}

/// Density of a recording in its band, as it was before the conditioning.
fn density(part: &Part, args: &PsdArgs, order: Option<Fit>) -> Result<Density, String> {
    let (y, fs, n) = (&part.samples[..], part.fs, part.samples.len());
    if n < LEAST_SAMPLES {
        return Err(format!(
            "end of data: {n} samples are too few for a density, which needs at least {LEAST_SAMPLES} (record longer)"
        ));
    }
    part.variance()?;
    let (mut f, mut psd): (Vec<f64>, Vec<f64>) = match (order, args.at) {
        (Some((method, order)), at) => {
            let memory = Memory {
                forgetting: 1.0,
                random_walk: 0.0,
            };
            let model = estimators::fit(method, y, order, memory)
                .map_err(|why| format!("whole file: {why} {}", REMEDY))?;
            let sigma2 = model.sigma2.unwrap_or(f64::NAN);
            let (low, high) = part.edges();
            let grid = |k: usize| low + (high - low) * k as f64 / GRID as f64;
            let f = at.map_or_else(|| (0..=GRID).map(grid).collect(), |f| vec![f]);
            let at = |f: &f64| model_density(&model.a, &model.c, sigma2, *f, fs);
            let psd = f.iter().map(at).collect();
            (f, psd)
        }
        (None, Some(f)) if args.method == PsdMethod::Periodogram => {
            (vec![f], vec![windowed_density(y, |_| 1.0, f, fs)])
        }
        (None, Some(f)) => (vec![f], vec![welch_density(y, stretch(n), f, fs)]),
        (None, None) if args.method == PsdMethod::Periodogram => transformed(y, n, |_| 1.0, fs),
        (None, None) => welch(y, fs),
    };
    (f, psd) = of_the_recording(part, f.into_iter().zip(psd))
        .into_iter()
        .unzip();
    if f.is_empty() {
        return Err(format!(
            "end of data: {n} samples at {fs} Hz resolve no frequency of the band (record longer, or choose a wider --band)"
        ));
    }
    if let Some((f, s)) = f
        .iter()
        .zip(&psd)
        .find(|(f, s)| !(f.is_finite() && s.is_finite()))
    {
        return Err(format!(
            "whole file: the density at {f} Hz is {s} (check --fs, or choose another --method)"
        ));
    }
    Ok(Density {
        band: band::in_json(part.band),
        fs,
        n,
        f,
        psd,
    })
}

/// A density of the part as that of the recording, in the band.
fn of_the_recording(part: &Part, density: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    if part.band.is_none() {
        return density.collect();
    }
    // Only there the conditioning can be undone.
    let (low, high) = part.edges();
    let gain = part.power_gain();
    density
        .filter(|(f, _)| (low..=high).contains(f))
        .map(|(f, s)| (f, s / gain(f)))
        .collect()
}

/// Welch's estimate of a recording in its band: frequency, Hz, and density.
pub(super) fn estimate(part: &Part) -> Vec<(f64, f64)> {
    let (f, psd) = welch(&part.samples, part.fs);
    of_the_recording(part, f.into_iter().zip(psd))
}

/// Density of a model of a part, (a, c) and innovation variance, on the grid of models.
pub(super) fn of_model(part: &Part, (a, c): (&[f64], &[f64]), sigma2: f64) -> Vec<(f64, f64)> {
    let (low, high) = part.edges();
    let f = (0..=GRID).map(|k| low + (high - low) * k as f64 / GRID as f64);
    of_the_recording(
        part,
        f.map(|f| (f, model_density(a, c, sigma2, f, part.fs))),
    )
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
    let transform = rarma_fourier::forward(n);
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
