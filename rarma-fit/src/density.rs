//! Power spectral density: of a model at any frequency, and of a series on a grid.
//!
//! Slow path. One-sided, in input units squared per Hz: its integral from 0 to fs/2
//! is the variance of the signal.

use rarma_core::real::Real;

/// Density of an ARMA model at `f` Hz, units²/Hz, one-sided:
///
/// ```text
/// S(f) = (2σ²/fs)·|C(e^(jω))|²/|A(e^(jω))|²,   ω = 2πf/fs
/// ```
///
/// `a` and `c` without their leading 1; with an empty `c` it is the spectrum of an
/// autoregressive model. Infinite on an undamped pole.
///
/// ```
/// use rarma_fit::model_density;
/// // White noise of variance 4 at 100 Hz: 4/(100/2) per Hz at every frequency.
/// assert!((model_density::<f64>(&[], &[], 4.0, 13.0, 100.0) - 0.08).abs() < 1e-12);
/// ```
pub fn model_density<T: Real>(a: &[T], c: &[T], sigma2: T, f: T, fs: T) -> T {
    let two = T::from_f64(2.0);
    let (s, co) = (two * T::PI * f / fs).sin_cos();
    let squared = |coefficients: &[T]| {
        // Σ x_i z^-i with z = e^(jω), by Horner from the last coefficient.
        let (mut re, mut im) = (T::ZERO, T::ZERO);
        for &x in coefficients.iter().rev() {
            let (r, i) = (re + x, im);
            re = r * co + i * s;
            im = i * co - r * s;
        }
        re += T::ONE;
        re * re + im * im
    };
    two * sigma2 / fs * squared(c) / squared(a)
}

/// Density of a stretch of signal at `f` Hz by a discrete Fourier transform at that
/// one frequency (Goertzel), with a window: units²/Hz, one-sided.
///
/// ```text
/// S(f) = 2·|Σ w_n x_n e^(−jωn)|²/(fs·Σ w_n²)
/// ```
///
/// `window(n)` gives the weight of sample n. The periodogram is the case of weights
/// 1 over the whole series; Welch's estimate is the mean over overlapping stretches
/// under a Hann window ([`welch_density`]). At 0 Hz and fs/2 the factor 2 is left
/// out.
pub fn windowed_density<T: Real>(x: &[T], window: impl Fn(usize) -> T, f: T, fs: T) -> T {
    let two = T::from_f64(2.0);
    let angle = two * T::PI * f / fs;
    let (s, c) = angle.sin_cos();
    let (mut re, mut im) = (T::ONE, T::ZERO);
    let (mut sum_re, mut sum_im, mut power) = (T::ZERO, T::ZERO, T::ZERO);
    for (n, &value) in x.iter().enumerate() {
        let w = window(n);
        sum_re += w * value * re;
        sum_im += w * value * im;
        power += w * w;
        (re, im) = (re * c + im * s, im * c - re * s);
        // The rotor is put back on the circle before rounding shows.
        if n % 256 == 255 {
            let correction = T::from_f64(1.5) - T::from_f64(0.5) * (re * re + im * im);
            re *= correction;
            im *= correction;
        }
    }
    let edge = f == T::ZERO || two * f == fs;
    let sides = if edge { T::ONE } else { two };
    sides * (sum_re * sum_re + sum_im * sum_im) / (fs * power)
}

/// Welch's estimate at `f` Hz: mean of [`windowed_density`] over stretches of
/// `length` samples, each half a length after the last, under a Hann window. NaN if
/// the series is shorter than one stretch.
pub fn welch_density<T: Real>(x: &[T], length: usize, f: T, fs: T) -> T {
    let turn = T::from_f64(2.0) * T::PI / T::from_u32(length.max(1) as u32);
    let hann = |n: usize| {
        let (_, c) = (turn * T::from_u32(n as u32)).sin_cos();
        T::from_f64(0.5) * (T::ONE - c)
    };
    let (mut sum, mut count) = (T::ZERO, T::ZERO);
    let mut from = 0usize;
    while let Some(stretch) = x.get(from..from.saturating_add(length))
        && length > 1
    {
        sum += windowed_density(stretch, hann, f, fs);
        count += T::ONE;
        from += length / 2;
    }
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut seed = 9u32;
        (0..n)
            .map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(seed >> 8) / 8_388_608.0 - 1.0
            })
            .collect()
    }

    #[test]
    fn model_density_integrates_to_the_variance() {
        // AR(1) with φ = 0.8: variance 1/(1 − 0.64).
        let (a, fs, n) = ([-0.8], 100.0, 20_000);
        let step = fs / 2.0 / f64::from(n);
        let sum: f64 = (0..n)
            .map(|k| model_density(&a, &[], 1.0, (f64::from(k) + 0.5) * step, fs) * step)
            .sum();
        assert!((sum * 0.36 - 1.0).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn periodogram_integrates_to_the_mean_square() {
        let x = noise(400);
        let fs = 50.0;
        let step = fs / 400.0;
        let sum: f64 = (0..=200)
            .map(|k| windowed_density(&x, |_| 1.0, f64::from(k) * step, fs) * step)
            .sum();
        let power = x.iter().map(|v| v * v).sum::<f64>() / 400.0;
        assert!((sum / power - 1.0).abs() < 1e-9, "{sum} {power}");
    }

    #[test]
    fn welch_of_white_noise_is_flat_and_has_its_level() {
        let x = noise(60_000);
        let fs = 1000.0;
        // Uniform noise of −1 to 1 has the variance 1/3.
        let level = 2.0 / 3.0 / fs;
        for f in [50.0, 123.4, 400.0] {
            let s = welch_density(&x, 256, f, fs);
            assert!((0.8..1.2).contains(&(s / level)), "{} at {f}", s / level);
        }
        assert!(welch_density(&x[..10], 256, 50.0, fs).is_nan());
    }

    #[test]
    fn models_peak_where_their_pole_is() {
        let (r, w) = (0.99f64, 0.6f64);
        let a = [-2.0 * r * w.cos(), r * r];
        let at = |w: f64| model_density(&a, &[0.3], 1.0, w / core::f64::consts::TAU, 1.0);
        assert!(at(w) > 50.0 * at(w + 0.2) && at(w) > at(w + 0.01) && at(w) > at(w - 0.01));
    }
}
