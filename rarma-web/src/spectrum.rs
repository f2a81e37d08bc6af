//! The sound over time and frequency, column by column, for the picture that moves.

use rarma_fourier::{Complex, Forward};
use std::fmt;

/// Length of a window, s: frequencies 23 Hz apart.
const WINDOW_S: f64 = 0.043;
/// The scale ends this far above the upper edge of the band.
const ABOVE: f64 = 1.15;
/// Amplitude of the darkest and of the brightest value, dB over full scale.
const RANGE_DB: (f64, f64) = (-110.0, -10.0);
/// Columns that wait to be fetched, at most; older ones go.
const MOST: usize = 4096;

/// Makes columns of values from 0 to 255, the lowest frequency first.
#[derive(Clone)]
pub struct Spectrum {
    fs: f64,
    transform: Forward,
    hann: Vec<f64>,
    gain: f64,
    rows: usize,
    window: Vec<f64>,
    input: Vec<f64>,
    output: Vec<Complex<f64>>,
    columns: Vec<u8>,
}

impl fmt::Debug for Spectrum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Spectrum")
            .field("fs", &self.fs)
            .field("rows", &self.rows)
            .finish_non_exhaustive()
    }
}

impl Spectrum {
    /// Of samples of rate `fs`, Hz, up to a little above `high_hz`.
    pub fn new(fs: f64, high_hz: f64) -> Self {
        let n = ((WINDOW_S * fs) as usize).next_power_of_two().max(32);
        let transform = rarma_fourier::forward(n);
        let hann: Vec<f64> = (0..n)
            .map(|i| 0.5 - 0.5 * (std::f64::consts::TAU * (i as f64 + 0.5) / n as f64).cos())
            .collect();
        let rows = ((ABOVE * high_hz / fs * n as f64).ceil() as usize).clamp(1, n / 2);
        Self {
            fs,
            gain: 2.0 / hann.iter().sum::<f64>(),
            rows,
            window: Vec::with_capacity(n),
            input: transform.make_input_vec(),
            output: transform.make_output_vec(),
            columns: Vec::new(),
            hann,
            transform,
        }
    }

    /// Values of a column.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Frequency of the upper end, Hz.
    pub fn top_hz(&self) -> f64 {
        self.rows as f64 * self.fs / self.hann.len() as f64
    }

    /// Seconds from column to column.
    pub fn step_s(&self) -> f64 {
        0.5 * self.hann.len() as f64 / self.fs
    }

    /// Takes the next sample.
    pub fn push(&mut self, x: f32) {
        self.window
            .push(if x.is_finite() { f64::from(x) } else { 0.0 });
        if self.window.len() < self.hann.len() {
            return;
        }
        for (to, (x, w)) in self
            .input
            .iter_mut()
            .zip(self.window.iter().zip(&self.hann))
        {
            *to = x * w;
        }
        // Lengths are those of the plan.
        if self
            .transform
            .process(&mut self.input, &mut self.output)
            .is_ok()
        {
            let (low, high) = RANGE_DB;
            let value = |z: &Complex<f64>| {
                let db = 20.0 * (self.gain * z.norm()).max(1e-9).log10();
                (255.0 * (db - low) / (high - low)).clamp(0.0, 255.0) as u8
            };
            if self.columns.len() >= MOST * self.rows {
                self.columns.drain(..self.rows * (MOST / 2));
            }
            self.columns
                .extend(self.output.iter().take(self.rows).map(value));
        }
        self.window.drain(..self.hann.len() / 2);
    }

    /// The columns since the last time, one after the other.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_stands_in_its_row_at_its_level() {
        let mut spectrum = Spectrum::new(48_000.0, 2500.0);
        // -20 dB over full scale.
        let tone = |n: u32| 0.1 * (std::f64::consts::TAU * 937.5 * f64::from(n) / 48e3).sin();
        (0..48_000).for_each(|n| spectrum.push(tone(n) as f32));
        let columns = spectrum.take();
        let rows = spectrum.rows();
        assert_eq!(columns.len() % rows, 0);
        let expected = 1.0 / spectrum.step_s();
        assert!((columns.len() as f64 / rows as f64 - expected).abs() < 2.0);
        let column = &columns[rows * 10..rows * 11];
        let loudest = (0..rows).max_by_key(|k| column[*k]).expect("rows");
        assert!((loudest as f64 / rows as f64 * spectrum.top_hz() - 937.5).abs() < 24.0);
        assert!(
            (i32::from(column[loudest]) - 229).abs() <= 3,
            "{}",
            column[loudest]
        );
        assert!(spectrum.take().is_empty());
    }

    #[test]
    fn what_nobody_fetches_does_not_grow_and_odd_samples_do_no_harm() {
        let mut spectrum = Spectrum::new(8000.0, 1000.0);
        (0..8000 * 700).for_each(|n| spectrum.push(if n % 1000 == 0 { f32::NAN } else { 0.0 }));
        assert!(spectrum.take().len() <= MOST * spectrum.rows());
    }
}
