//! Fourier transforms of real series, for pictures, spectra and plants on a computer.
//!
//! Each crate that makes a planner compiles the whole of `rustfft` anew, because the planner is generic: 380 000 of the
//! 900 000 lines of intermediate code that such a crate had. Here it is compiled once.
//!
//! `X[k] = Σ x[n]·exp(−2πi·k·n/N)` for `k = 0 … N/2`; neither way is scaled, so that there and back gives `N·x`.

pub use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::sync::Arc;

/// A planned way to the lines.
pub type Forward = Arc<dyn RealToComplex<f64>>;

/// `length` real numbers to `length/2 + 1` complex lines.
pub fn forward(length: usize) -> Forward {
    RealFftPlanner::new().plan_fft_forward(length)
}

/// `length/2 + 1` complex lines back to `length` real numbers. The first line must be real, and the last one where `length`
/// is even.
pub fn inverse(length: usize) -> Arc<dyn ComplexToReal<f64>> {
    RealFftPlanner::new().plan_fft_inverse(length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Beside the sum as it is written, for an even and an odd length, and back.
    #[test]
    fn lines_are_the_written_sum() {
        for n in [12, 15] {
            let x: Vec<f64> = (0..n).map(|i| ((7 * i * i + 3) % 11) as f64).collect();
            let to = forward(n);
            let (mut input, mut lines) = (x.clone(), to.make_output_vec());
            to.process(&mut input, &mut lines).unwrap();
            assert_eq!(lines.len(), n / 2 + 1);
            for (k, line) in lines.iter().enumerate() {
                let turn = |i: usize| TAU * (k * i) as f64 / n as f64;
                let re: f64 = x.iter().enumerate().map(|(i, x)| x * turn(i).cos()).sum();
                let im: f64 = x.iter().enumerate().map(|(i, x)| -x * turn(i).sin()).sum();
                assert!((line.re - re).abs() < 1e-10, "{n} {k} {line} {re}");
                assert!((line.im - im).abs() < 1e-10, "{n} {k} {line} {im}");
            }
            let back = inverse(n);
            let mut again = back.make_output_vec();
            back.process(&mut lines, &mut again).unwrap();
            for (a, x) in again.iter().zip(&x) {
                assert!((a - n as f64 * x).abs() < 1e-9);
            }
        }
    }
}
