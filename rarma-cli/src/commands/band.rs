//! What of a recording is fitted: the monitor's band through the monitor's own
//! conditioning, or all of it; and in what words a band is refused.

use super::estimators::{self, IdentifiedMode, Model};
use super::source::read;
use crate::args::{BandArgs, Detrend, InputArgs};
use crate::failure::Failure;
use rarma_core::condition::{Band, BandError, BandFilter};
use rarma_recordings::input::{Recording, check_size};
use rarma_scenarios::banded;
use std::path::Path;

/// The series that is fitted, or transformed.
#[derive(Debug, Clone)]
pub struct Part {
    /// Samples without mean or trend, in the band.
    pub samples: Vec<f64>,
    /// Their rate, Hz.
    pub fs: f64,
    /// Mean of the recording, where it was removed.
    pub mean: f64,
    /// The band; none for all of it.
    pub band: Option<Band>,
    /// Largest magnitude of the recording, mean and all.
    largest: f64,
    /// Rate of the recording, Hz.
    recorded_fs: f64,
}

impl Part {
    /// A series as it is, without mean or trend.
    pub fn whole(series: &[f64], fs: f64, how: Detrend) -> Self {
        let (mean, samples) = detrended(series, how);
        Self {
            samples,
            fs,
            mean,
            band: None,
            largest: series.iter().fold(0.0f64, |m, x| m.max(x.abs())),
            recorded_fs: fs,
        }
    }

    /// Reads a recording and takes the band that is asked for.
    ///
    /// # Errors
    /// Bad input, or a band that does not fit it, in one line.
    pub fn read(input: &InputArgs, band: BandArgs, how: Detrend) -> Result<Self, Failure> {
        Self::of(&read(input)?, band, how)
    }

    /// Takes the band that is asked for of a recording that has been read.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn of(recording: &Recording, band: BandArgs, how: Detrend) -> Result<Self, Failure> {
        check_size(recording)?;
        let whole = Self::whole(&recording.samples, recording.fs, how);
        let Some(band) = band.of(recording.fs) else {
            return Ok(whole);
        };
        let reduced = banded::through(&whole.samples, recording.fs, band)
            .map_err(|why| refused(why, band, &recording.path, recording.fs))?;
        let settle = reduced.settle.min(reduced.samples.len());
        Ok(Self {
            samples: reduced.samples[settle..].to_vec(),
            fs: reduced.fs,
            band: Some(band),
            ..whole
        })
    }

    /// Mean square of the samples.
    ///
    /// # Errors
    /// Nothing but rounding is left, in words.
    pub fn variance(&self) -> Result<f64, String> {
        let n = self.samples.len() as f64;
        let variance = self.samples.iter().map(|x| x * x).sum::<f64>() / n;
        if variance > (self.largest * 1e-12).powi(2) {
            return Ok(variance);
        }
        Err(match self.band {
            None => "whole file: nothing is left once the trend is removed: the series is constant (check the sensor)".to_owned(),
            Some(band) => format!(
                "whole file: nothing is left in the band {}:{} Hz (choose another --band, or --band full)",
                band.low_hz, band.high_hz
            ),
        })
    }

    /// The frequencies that count, Hz.
    pub fn edges(&self) -> (f64, f64) {
        self.band
            .map_or((0.0, self.fs / 2.0), |b| (b.low_hz, b.high_hz))
    }

    /// Modes of a model of it that lie where it was looked; none if the roots of A are
    /// not found. Outside the band poles are those of the conditioning, too.
    pub(super) fn modes(&self, model: &Model) -> Option<Vec<IdentifiedMode>> {
        let mut modes = model.modes(self.fs)?;
        if let Some(band) = self.band {
            modes.retain(|m| (band.low_hz..=band.high_hz).contains(&m.f));
        }
        Some(modes)
    }

    /// What the conditioning has multiplied a density by, at frequencies of the band.
    pub fn power_gain(&self) -> impl Fn(f64) -> f64 {
        let filter = self
            .band
            .and_then(|band| BandFilter::<f64>::new(band, self.recorded_fs).ok());
        let fs = self.recorded_fs;
        move |f| filter.as_ref().map_or(1.0, |h| h.power_gain(f, fs))
    }

    /// Says on standard error if what follows takes minutes, and what would not.
    pub(super) fn warn_of(&self, work: f64, file: &Path) {
        if work > estimators::MINUTES {
            eprintln!(
                "{}: {} samples at such an order take minutes (choose a narrower --band, a lower order or a shorter stretch)",
                file.display(),
                self.samples.len()
            );
        }
    }

    /// `low:high` in Hz for people, and the rate.
    pub fn words(&self) -> String {
        match self.band {
            None => format!("all of it, at {} Hz", self.fs),
            Some(b) => format!("band {}:{} Hz, at {} Hz", b.low_hz, b.high_hz, self.fs),
        }
    }
}

/// A band for JSON.
pub fn in_json(band: Option<Band>) -> Option<[f64; 2]> {
    band.map(|b| [b.low_hz, b.high_hz])
}

/// A band that does not fit, in one line.
pub fn refused(error: BandError, band: Band, file: &Path, fs: f64) -> Failure {
    let Band { low_hz, high_hz } = band;
    let file = file.display();
    match error {
        BandError::Edges => Failure::Usage(format!(
            "--band: both edges must be above 0, the upper one at least 1.2 times the lower (is {low_hz}:{high_hz})"
        )),
        BandError::RateTooLow { highest_hz } => Failure::Input(format!(
            "{file}: header: {fs} Hz is too low a rate for a band up to {high_hz} Hz (choose --band with an upper edge of at most {highest_hz:.0} Hz, or record faster)"
        )),
        BandError::TooWide { lowest_hz } => Failure::Usage(format!(
            "--band: the lower edge must be at least {lowest_hz} Hz for an upper edge of {high_hz} Hz"
        )),
        BandError::Rate => Failure::Input(format!(
            "{file}: header: the sampling rate is {fs} Hz (say the true one with --fs)"
        )),
    }
}

/// The mean, and the series without its trend.
pub(super) fn detrended(series: &[f64], how: Detrend) -> (f64, Vec<f64>) {
    let n = series.len() as f64;
    let mean = series.iter().sum::<f64>() / n;
    match how {
        Detrend::None => (0.0, series.to_vec()),
        Detrend::Mean => (mean, series.iter().map(|x| x - mean).collect()),
        Detrend::Linear => {
            let centre = (n - 1.0) / 2.0;
            let (mut sxy, mut sxx) = (0.0, 0.0);
            for (i, x) in series.iter().enumerate() {
                let t = i as f64 - centre;
                sxy += t * (x - mean);
                sxx += t * t;
            }
            let slope = sxy / sxx;
            let line = |i: usize| mean + slope * (i as f64 - centre);
            let rest = series.iter().enumerate().map(|(i, x)| x - line(i));
            (mean, rest.collect())
        }
    }
}
