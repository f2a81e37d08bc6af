//! Whiteness of the innovations as they come.
//!
//! Rate: once a sample, O(lags). A model that fits leaves innovations without memory;
//! what is left in them is a mode too few, a wrong start, or a machine that changes
//! faster than the model.

use crate::real::Real;

/// Lags compared.
pub const RUNNING_LAGS: usize = 16;
/// Gain of the mean square against which an innovation is scaled before it is used.
const SCALE_GAIN: f64 = 1.0 / 64.0;
/// Innovations count with at most this many standard deviations, so that a spike is
/// not taken for memory.
const MOST_DEVIATIONS: f64 = 5.0;

/// Correlations of the innovations over an exponential memory, and their portmanteau:
///
/// ```text
/// u = e/s,  s² the running mean square,   r_k ← r_k + g(u(t)·u(t−k) − r_k)
/// Q = N_eff·Σ_k (r_k/r_0)²,  N_eff = (2 − g)/g     (Box and Pierce)
/// ```
///
/// For white innovations Q is χ² with [`RUNNING_LAGS`] degrees of freedom, fewer by up
/// to p + q where the model was fitted to them, so that [`Self::excess`] is then near 0
/// or below.
///
/// ```
/// use rarma_core::estimate::RunningWhiteness;
/// let mut white = RunningWhiteness::<f32>::new(500);
/// let mut seed = 1u32;
/// for _ in 0..5000 {
///     seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///     white.update((seed >> 8) as f32 / 8_388_608.0 - 1.0);
/// }
/// assert!(white.excess() < 4.0);
/// ```
#[derive(Debug, Clone)]
pub struct RunningWhiteness<T> {
    gain: T,
    square: T,
    past: [T; RUNNING_LAGS],
    variance: T,
    correlations: [T; RUNNING_LAGS],
    samples: u32,
    memory: u32,
}

impl<T: Real> RunningWhiteness<T> {
    /// With a memory of `memory` samples, at least 64: g = 1/memory.
    pub fn new(memory: u32) -> Self {
        let memory = memory.max(64);
        Self {
            gain: T::ONE / T::from_u32(memory),
            square: T::ZERO,
            past: [T::ZERO; RUNNING_LAGS],
            variance: T::ZERO,
            correlations: [T::ZERO; RUNNING_LAGS],
            samples: 0,
            memory,
        }
    }

    /// Takes an innovation; one that is not finite is left out.
    #[inline]
    pub fn update(&mut self, innovation: T) {
        if !(innovation.abs() < T::from_f64(1e15)) {
            return;
        }
        self.samples = self.samples.saturating_add(1);
        let first = T::ONE / T::from_u32(self.samples);
        let scale_gain = first.max(T::from_f64(SCALE_GAIN));
        self.square += scale_gain * (innovation * innovation - self.square);
        if !(self.square > T::from_f64(1e-30)) {
            return;
        }
        let most = T::from_f64(MOST_DEVIATIONS);
        let u = (innovation / self.square.sqrt()).clamp(-most, most);
        let gain = first.max(self.gain);
        self.variance += gain * (u * u - self.variance);
        for (r, past) in self.correlations.iter_mut().zip(&self.past) {
            *r += gain * (u * *past - *r);
        }
        self.past.copy_within(0..RUNNING_LAGS - 1, 1);
        self.past[0] = u;
    }

    /// A memory full of innovations has been seen.
    pub fn ready(&self) -> bool {
        self.samples >= self.memory
    }

    /// Correlation at lag k = 1…[`RUNNING_LAGS`], −1 to 1; 0 for another lag.
    pub fn correlation(&self, lag: usize) -> T {
        match lag.checked_sub(1).and_then(|k| self.correlations.get(k)) {
            Some(r) if self.variance > T::ZERO => *r / self.variance,
            _ => T::ZERO,
        }
    }

    /// Q of the formula above. Decision rate.
    pub fn portmanteau(&self) -> T {
        if !(self.variance > T::ZERO) {
            return T::ZERO;
        }
        let two = T::from_f64(2.0);
        let memory = ((two - self.gain) / self.gain).min(T::from_u32(self.samples));
        let sum = self
            .correlations
            .iter()
            .fold(T::ZERO, |sum, r| sum + *r * *r);
        memory * sum / (self.variance * self.variance)
    }

    /// (Q − lags)/√(2·lags): how many standard deviations Q is above what white
    /// innovations give. Above 4 the innovations are not white.
    pub fn excess(&self) -> T {
        let lags = T::from_u32(RUNNING_LAGS as u32);
        (self.portmanteau() - lags) / (T::from_f64(2.0) * lags).sqrt()
    }

    /// Forgets everything but the memory's length.
    pub fn reset(&mut self) {
        *self = Self::new(self.memory);
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn noise(seed: &mut u32) -> f64 {
        // Sum of four uniform numbers: near enough to normal.
        (0..4)
            .map(|_| {
                *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(*seed >> 8) / 8_388_608.0 - 1.0
            })
            .sum()
    }

    fn excesses(colour: f64) -> Vec<f64> {
        (1..=200)
            .map(|run| {
                let (mut seed, mut e1) = (run * 7919, 0.0);
                let mut white = RunningWhiteness::<f64>::new(500);
                for _ in 0..5000 {
                    let e = noise(&mut seed);
                    white.update(e + colour * e1);
                    e1 = e;
                }
                white.excess()
            })
            .collect()
    }

    #[test]
    fn white_innovations_have_the_stated_mean_and_spread() {
        let q = excesses(0.0);
        let mean = q.iter().sum::<f64>() / 200.0;
        let spread = (q.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 199.0).sqrt();
        let wrong = q.iter().filter(|x| **x > 4.0).count();
        std::println!("white: mean {mean:.2}, spread {spread:.2}, above 4: {wrong} of 200");
        assert!((-0.3..0.3).contains(&mean), "{mean}");
        assert!((0.8..1.3).contains(&spread), "{spread}");
        assert!(wrong <= 3, "{wrong} of 200 white series called coloured");
    }

    #[test]
    fn a_correlation_is_seen_as_often_as_theory_says() {
        // ρ₁ = 0.2/1.04 and 999 effective samples put Q 37 above its mean, with a
        // deviation of 13: a sixth stays below 4·√32. With ρ₁ = 0.28 none does.
        let missed = |colour| excesses(colour).iter().filter(|x| **x <= 4.0).count();
        let (weak, strong) = (missed(0.2), missed(0.3));
        std::println!("missed of 200: {weak} at ρ = 0.19, {strong} at ρ = 0.28");
        assert!((15..60).contains(&weak) && strong <= 4, "{weak} {strong}");
    }

    #[test]
    fn nothing_but_numbers_comes_out() {
        let mut white = RunningWhiteness::<f32>::new(100);
        for x in [0.0, f32::NAN, f32::INFINITY, 1e30, 1e-30, -5.0, 1e14, 0.0] {
            white.update(x);
            assert!(white.excess().is_finite() && white.correlation(1).is_finite());
        }
        assert!(!white.ready() && white.correlation(0) == 0.0 && white.correlation(99) == 0.0);
    }
}
