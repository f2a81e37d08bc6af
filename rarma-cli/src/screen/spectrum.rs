//! The spectrum over time: a row every tenth of a second.
//!
//! Listening side: a window and one transform a row, some 20 µs.

use crate::report::sound::hann;
use rarma_fourier::{Complex, Forward};
use std::collections::VecDeque;
use std::sync::Arc;

/// Time between two rows, s.
pub(super) const ROW_S: f64 = 0.1;
/// Rows that are kept: 25.6 s.
const ROWS: usize = 256;
/// Bins over the band, about.
const BINS: f64 = 256.0;
/// Windows, samples.
const WINDOWS: std::ops::RangeInclusive<f64> = 256.0..=16_384.0;
/// Below this power a level is that of nothing.
const NOTHING: f64 = 1e-20;

/// What one row shows.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Row {
    /// Levels of bins that divide the band evenly, dB.
    Levels(Arc<[f32]>),
    /// Frequencies of modes, Hz, where no samples are at hand.
    Modes(Vec<f64>),
}

/// The rows of the last seconds, the newest first.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Waterfall {
    pub(super) rows: VecDeque<Row>,
    /// Rows there have been.
    pub(super) count: u64,
}

impl Waterfall {
    pub(super) fn push(&mut self, row: Row) {
        self.rows.push_front(row);
        self.rows.truncate(ROWS);
        self.count += 1;
    }
}

/// Samples in, rows of levels out.
pub(super) struct Spectra {
    band_hz: (f64, f64),
    fs: f64,
    window: Vec<f64>,
    gain: f64,
    transform: Forward,
    /// The last samples, as many as the window has.
    last: VecDeque<f64>,
    /// Samples until the next row.
    left: usize,
}

impl Spectra {
    /// Of samples of rate `fs`, Hz, in a band, Hz.
    pub(super) fn new(fs: f64, band_hz: (f64, f64)) -> Self {
        let wanted = BINS * fs / (band_hz.1 - band_hz.0).max(1.0);
        let wanted = wanted.clamp(*WINDOWS.start(), *WINDOWS.end());
        let length = (wanted as usize + 1).next_power_of_two() / 2;
        let (window, gain) = hann(length);
        Self {
            band_hz,
            fs,
            gain,
            transform: rarma_fourier::forward(length),
            last: VecDeque::with_capacity(length),
            window,
            left: (ROW_S * fs) as usize,
        }
    }

    /// Takes samples; each row that they fill goes to `row`, with the root mean square of the
    /// band.
    pub(super) fn take(&mut self, samples: &[f64], mut row: impl FnMut(Row, f32)) {
        for x in samples {
            if self.last.len() == self.window.len() {
                self.last.pop_front();
            }
            self.last.push_back(if x.is_finite() { *x } else { 0.0 });
            self.left -= 1;
            if self.left == 0 {
                self.left = ((ROW_S * self.fs) as usize).max(1);
                let (levels, rms) = self.levels();
                row(Row::Levels(levels), rms);
            }
        }
    }

    fn levels(&self) -> (Arc<[f32]>, f32) {
        let n = self.window.len();
        let mean = self.last.iter().sum::<f64>() / self.last.len().max(1) as f64;
        // A beginning that does not fill the window stands at its end.
        let mut windowed = vec![0.0; n];
        let from = n - self.last.len();
        for (k, x) in self.last.iter().enumerate() {
            windowed[from + k] = self.window[from + k] * (x - mean);
        }
        let mut bins = vec![Complex::new(0.0, 0.0); n / 2 + 1];
        // Lengths are those that were planned.
        let _ = self.transform.process(&mut windowed, &mut bins);
        let place = |hz: f64| ((hz * n as f64 / self.fs).round() as usize).min(n / 2);
        let band = &bins[place(self.band_hz.0)..=place(self.band_hz.1)];
        let powers = band.iter().map(|b| (self.gain * b.norm()).powi(2));
        let power: f64 = powers.clone().sum();
        let db = powers.map(|p| (10.0 * p.max(NOTHING).log10()) as f32);
        // Hann's window spreads a sine's power over 1.5 bins; amplitudes to root mean square.
        (db.collect(), (power / 3.0).sqrt() as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(fs: f64, hz: f64) -> Vec<(Vec<f32>, f32)> {
        let mut spectra = Spectra::new(fs, (300.0, 2500.0));
        let wave = |n: usize| 3.0 + 0.5 * (std::f64::consts::TAU * hz * n as f64 / fs).sin();
        let samples: Vec<f64> = (0..fs as usize).map(wave).collect();
        let mut rows = Vec::new();
        for piece in samples.chunks(77) {
            spectra.take(piece, |row, rms| match row {
                Row::Levels(levels) => rows.push((levels.to_vec(), rms)),
                Row::Modes(_) => unreachable!("levels"),
            });
        }
        rows
    }

    #[test]
    fn a_sine_is_the_highest_level_where_it_lies_and_as_loud_as_it_is() {
        for (fs, hz) in [(48_000.0, 900.0), (8000.0, 1234.0), (44_100.0, 2400.0)] {
            let rows = rows(fs, hz);
            assert!((9..=10).contains(&rows.len()), "{}", rows.len());
            let (levels, rms) = rows.last().expect("one");
            let highest = (0..levels.len()).max_by(|a, b| levels[*a].total_cmp(&levels[*b]));
            let step = 2200.0 / (levels.len() - 1) as f64;
            let at = 300.0 + step * highest.expect("one") as f64;
            assert!((at - hz).abs() <= step, "{at} Hz for {hz} Hz");
            assert!((rms / 0.353_55 - 1.0).abs() < 0.02, "{rms}");
        }
    }

    #[test]
    fn what_is_no_number_and_what_is_silent_leave_finite_levels() {
        let mut spectra = Spectra::new(1000.0, (10.0, 400.0));
        let mut samples = vec![0.0; 2000];
        samples[50] = f64::NAN;
        spectra.take(&samples, |row, rms| {
            let Row::Levels(levels) = row else {
                unreachable!("levels")
            };
            assert!(levels.iter().all(|level| level.is_finite()));
            assert_eq!(rms, 0.0);
        });
    }

    #[test]
    fn rows_are_bounded() {
        let mut waterfall = Waterfall::default();
        for _ in 0..1000 {
            waterfall.push(Row::Modes(vec![900.0]));
        }
        assert_eq!((waterfall.rows.len(), waterfall.count), (ROWS, 1000));
    }
}
