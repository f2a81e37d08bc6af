//! Band-limited Gaussian noise, clipped at three standard deviations.

use crate::cers::error::{CersError, within};
use rarma_core::condition::{Biquad, BiquadState, Pass, ZERO_FRACTION};
use rarma_core::real::Real;

/// Sections of each edge of the band: fourth order.
const SECTIONS: usize = 2;
/// Clipped here, standard deviations.
const CLIP: f64 = 3.0;

/// What the noise is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandNoiseConfig<T> {
    /// Sampling rate, Hz, 100 to 1e6.
    pub rate_hz: T,
    /// Lower edge (−3 dB), Hz; 0 for none.
    pub low_hz: T,
    /// Upper edge (−3 dB), Hz, up to 0.45 of the rate.
    pub high_hz: T,
    /// Start of the sequence; the same gives the same.
    pub seed: u32,
}

/// Gaussian noise of unit rms before clipping: four uniform numbers a sample (xorshift)
/// through a Butterworth band of fourth order, clipped at ±3. Clipping takes 0.5 % of the
/// power and puts it, 40 dB down, outside the band too.
#[derive(Debug, Clone, Copy)]
pub struct BandNoise<T> {
    state: u32,
    low: Option<[Biquad<T>; SECTIONS]>,
    high: [Biquad<T>; SECTIONS],
    memory: [BiquadState<T>; 2 * SECTIONS],
    gain: T,
}

impl<T: Real> BandNoise<T> {
    /// Builds the band, and its gain from the power that the band lets through.
    ///
    /// Slow path: some 100 000 instructions, so that a box may do it between two
    /// milliseconds.
    ///
    /// # Errors
    /// `OutOfRange` with the first field.
    pub fn new(config: &BandNoiseConfig<T>) -> Result<Self, CersError> {
        let value = T::from_f64;
        let rate = config.rate_hz;
        within(rate, value(100.0), value(1e6), "rate_hz")?;
        within(
            config.high_hz,
            rate * value(1e-3),
            rate * value(0.45),
            "high_hz",
        )?;
        within(
            config.low_hz,
            T::ZERO,
            config.high_hz * value(0.8),
            "low_hz",
        )?;
        let fs = rate.to_f64();
        let side = |pass, f: T| {
            core::array::from_fn(|k| Biquad::butterworth(pass, f.to_f64(), fs, k, SECTIONS))
        };
        let mut out = Self {
            state: 1,
            low: (config.low_hz > T::ZERO).then(|| side(Pass::High, config.low_hz)),
            high: side(Pass::Low, config.high_hz),
            memory: [BiquadState::default(); 2 * SECTIONS],
            gain: T::ONE,
        };
        out.restart(config.seed);
        out.gain = T::ONE / band_power(config).sqrt();
        Ok(out)
    }

    /// The same band with the sequence of another seed.
    #[must_use]
    pub fn with_seed(mut self, seed: u32) -> Self {
        self.restart(seed);
        self
    }

    fn restart(&mut self, seed: u32) {
        // Zero would stay zero; a few rounds mix seeds that are near each other.
        self.state = (seed ^ 0x9e37_79b9) | 1;
        for _ in 0..16 {
            let _ = self.random();
        }
        self.memory = [BiquadState::default(); 2 * SECTIONS];
    }

    #[inline(always)]
    fn random(&mut self) -> u32 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 17;
        self.state ^= self.state << 5;
        self.state
    }

    #[inline(always)]
    fn filter(&mut self, x: T) -> T {
        let mut y = x;
        for k in 0..SECTIONS {
            y = self.high[k].process(&mut self.memory[k], y);
            if let Some(low) = &self.low {
                y = low[k].process(&mut self.memory[SECTIONS + k], y);
            }
        }
        y
    }

    /// A sample, within ±3.
    #[inline]
    pub fn next_sample(&mut self) -> T {
        // Four uniform numbers of ±1/2: variance 4/12.
        let mut sum = -T::from_f64(2.0);
        for _ in 0..4 {
            let x = self.random() >> 8;
            sum += T::from_u32(x) * T::from_f64(1.0 / 16_777_216.0);
        }
        let white = sum * T::from_f64(1.732_050_807_568_877_2);
        let clip = T::from_f64(CLIP);
        (self.filter(white) * self.gain).max(-clip).min(clip)
    }
}

/// Mean of |H|² from 0 to half the rate.
///
/// |H|² = (1 + (t_z/t)²)⁴/((1 + (t/t_h)⁸)·(1 + (t_l/t)⁸)), t = tan(πf/fs), t_z the zeros of
/// the high-pass ([`ZERO_FRACTION`]), by the midpoint rule to four times the upper edge:
/// beyond it are 9·10⁻⁶ of the power.
fn band_power<T: Real>(config: &BandNoiseConfig<T>) -> T {
    const POINTS: u32 = 512;
    let value = T::from_f64;
    let tan = |part: T| {
        let (s, c) = (T::PI * part).sin_cos();
        s / c
    };
    let fourth = |x: T| x * x * x * x;
    let eighth = |x: T| fourth(x * x);
    let high = config.high_hz / config.rate_hz;
    let low = config.low_hz / config.rate_hz;
    let top = (high * value(4.0)).min(value(0.5));
    let (t_high, t_low) = (tan(high), tan(low));
    let mut sum = T::ZERO;
    for k in 0..POINTS {
        let t = tan(top * (T::from_u32(k) + value(0.5)) / T::from_u32(POINTS));
        let zero = t_low * value(ZERO_FRACTION) / t;
        sum += fourth(T::ONE + zero * zero)
            / ((T::ONE + eighth(t / t_high)) * (T::ONE + eighth(t_low / t)));
    }
    sum / T::from_u32(POINTS) * top * value(2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cers::spectra::tests::powers;

    fn config(low_hz: f32, seed: u32) -> BandNoiseConfig<f32> {
        BandNoiseConfig {
            rate_hz: 40e3,
            low_hz,
            high_hz: 5e3,
            seed,
        }
    }

    #[test]
    fn it_is_gaussian_of_unit_rms_and_clipped() {
        for (low, high) in [(0.0, 5e3), (200.0, 5e3), (400.0, 600.0), (1000.0, 18e3)] {
            let mut noise = BandNoise::new(&BandNoiseConfig {
                high_hz: high,
                ..config(low, 7)
            })
            .unwrap();
            let x: Vec<f64> = (0..1_000_000)
                .map(|_| f64::from(noise.next_sample()))
                .collect();
            let n = x.len() as f64;
            let square = x.iter().map(|x| x * x).sum::<f64>() / n;
            let fourth = x.iter().map(|x| x.powi(4)).sum::<f64>() / n;
            let most = x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            println!(
                "rms {:.4}, kurtosis {:.3}",
                square.sqrt(),
                fourth / square / square
            );
            assert!((0.98..1.01).contains(&square.sqrt()), "{square}");
            // 3 for Gauss; 2.85 for Gauss clipped at 3 σ; 2.7 for four uniforms.
            assert!((2.75..2.95).contains(&(fourth / square / square)));
            assert_eq!(most, 3.0);
        }
    }

    #[test]
    fn its_band_is_flat_and_empty_outside() {
        let mut noise = BandNoise::new(&config(200.0, 3)).unwrap();
        let mut mean = vec![0.0; 1024];
        for _ in 0..200 {
            let x: Vec<f64> = (0..2048).map(|_| f64::from(noise.next_sample())).collect();
            for (m, p) in mean.iter_mut().zip(powers::<1024>(&x)) {
                *m += p;
            }
        }
        let band = |low: f64, high: f64| {
            let k = |f: f64| (f / 40e3 * 2048.0) as usize;
            mean[k(low)..k(high)].iter().sum::<f64>() / (k(high) - k(low)) as f64
        };
        let flat = band(1e3, 3e3);
        for (low, high) in [(600.0, 1000.0), (3e3, 4e3)] {
            let db = 10.0 * (band(low, high) / flat).log10();
            assert!(db.abs() < 0.5, "{low}: {db}");
        }
        let above = 10.0 * (band(12e3, 19e3) / flat).log10();
        println!("above the band {above:.1} dB");
        assert!((-60.0..-28.0).contains(&above), "{above}");
    }

    #[test]
    fn seeds_differ_and_repeat() {
        let run = |seed| {
            let mut n = BandNoise::new(&config(0.0, seed)).unwrap();
            (0..20_000).map(|_| n.next_sample()).collect::<Vec<f32>>()
        };
        assert_eq!(run(5), run(5));
        let (a, b) = (run(5), run(6));
        let dot: f32 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
        // Independent: about √(N·rate/(2·band)) = 280.
        assert!(dot.abs() < 1200.0, "{dot}");
    }

    #[test]
    fn refusals() {
        let of = |c| BandNoise::<f32>::new(&c).map(|_| ()).unwrap_err();
        let bad = BandNoiseConfig {
            high_hz: 19e3,
            ..config(0.0, 1)
        };
        assert_eq!(of(bad), CersError::OutOfRange { name: "high_hz" });
        assert_eq!(
            of(config(4900.0, 1)),
            CersError::OutOfRange { name: "low_hz" }
        );
    }
}
