//! Modes with their shapes, and how alike two shapes are.

use alloc::vec::Vec;

/// What one channel shows of a mode, over the channel that shows the most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapePart {
    /// Real part, 1 (channels of one unit; else in units of this channel over that one's).
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Standard deviation of the magnitude; 0 of the channel that the others are referred to.
    pub magnitude_sd: f64,
    /// Standard deviation of the phase, rad.
    pub phase_sd: f64,
}

impl ShapePart {
    /// Magnitude, 1.
    pub fn magnitude(&self) -> f64 {
        libm::hypot(self.re, self.im)
    }

    /// Phase, rad, −π to π.
    pub fn phase(&self) -> f64 {
        libm::atan2(self.im, self.re)
    }
}

/// A mode as all channels together tell it.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMode {
    /// Undamped natural frequency, Hz.
    pub frequency: f64,
    /// Standard deviation of it, Hz.
    pub frequency_sd: f64,
    /// Damping ratio, 1.
    pub damping: f64,
    /// Standard deviation of it.
    pub damping_sd: f64,
    /// One for each channel; the largest is 1.
    pub shape: Vec<ShapePart>,
}

/// Modal assurance criterion of two shapes, 0 (nothing in common) to 1 (the same but for a
/// factor):
///
/// ```text
/// MAC = |Σ conj(a)·b|² / (Σ|a|²·Σ|b|²)
/// ```
///
/// NaN if the shapes are not of as many channels, or one is 0. Source: Allemang and Brown, 1982.
///
/// ```
/// use rarma_fit::mac;
/// let a = [(1.0, 0.0), (0.5, 0.0)];
/// let turned = [(0.0, 2.0), (0.0, 1.0)];
/// assert!((mac(&a, &turned) - 1.0).abs() < 1e-12);
/// assert!(mac(&a, &[(0.5, 0.0), (-1.0, 0.0)]) < 1e-12);
/// ```
pub fn mac(a: &[(f64, f64)], b: &[(f64, f64)]) -> f64 {
    if a.len() != b.len() {
        return f64::NAN;
    }
    let power = |x: &[(f64, f64)]| x.iter().map(|(re, im)| re * re + im * im).sum::<f64>();
    let (mut re, mut im) = (0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        re += x.0 * y.0 + x.1 * y.1;
        im += x.0 * y.1 - x.1 * y.0;
    }
    (re * re + im * im) / (power(a) * power(b))
}

impl ChannelMode {
    /// The shape as pairs (real, imaginary), as [`mac`] takes them.
    pub fn pairs(&self) -> Vec<(f64, f64)> {
        self.shape.iter().map(|p| (p.re, p.im)).collect()
    }
}
