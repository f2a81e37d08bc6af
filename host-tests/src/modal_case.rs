//! Signals of known modes on which estimators are held against the Cramér–Rao bound.

use crate::bound::{Bound, ModeBound};
use rarma_core::estimate::{RarmaConfig, RecursiveArma};
use rarma_core::real::Real;
use rarma_core::spectrum::{FactorTracker, Roots, deviation, modal};
use rarma_fit::{ArmaFit, Pem, PemConfig};
use rarma_plants::modal_noise::{ModalNoise, ModalNoiseConfig, NoiseMode};

/// Rate of the samples, Hz.
pub const FS: f64 = 5000.0;
/// Frequency of the mode under test, Hz.
pub const F: f64 = 980.0;
/// Samples of a series: one second.
pub const SAMPLES: usize = 5000;
/// Relative sampling error of an rms of 40 normal errors: 1/√(2·40).
pub const ERROR_OF_40: f64 = 0.11;
/// The same of 200.
pub const ERROR_OF_200: f64 = 0.05;
/// Parameters of the largest order, (8,8).
pub const MOST_PARAMETERS: usize = 16;
/// A mode found further from the one under test than this, Hz, is another one.
const REACH: f64 = 100.0;
/// Frequency of the mode that makes four close ones, Hz.
const CLOSE_HZ: f64 = 700.0;
/// Modes that join the one under test, in this order.
const OTHERS: [(f64, f64); 3] = [(450.0, 0.03), (1500.0, 0.025), (2000.0, 0.03)];

/// A signal: modes, the one under test first, and measurement noise.
#[derive(Debug, Clone)]
pub struct Case {
    /// Frequency, Hz, and damping ratio of each mode.
    pub modes: Vec<(f64, f64)>,
    /// Variance of the modes over that of white measurement noise, dB; none: no noise.
    pub snr_db: Option<f64>,
}

/// The mode under test as a model has it, with stated standard deviations.
#[derive(Debug, Clone, Copy)]
pub struct Reading {
    /// Natural frequency, Hz.
    pub frequency: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Standard deviation of the frequency, Hz.
    pub frequency_sd: f64,
    /// Standard deviation of the damping ratio.
    pub damping_sd: f64,
}

impl Case {
    /// The mode under test with this damping ratio, among `modes` in all.
    ///
    /// # Panics
    /// More than four modes.
    #[must_use]
    pub fn of(modes: usize, zeta: f64, snr_db: Option<f64>) -> Self {
        let mut all = vec![(F, zeta)];
        all.extend(&OTHERS[..modes - 1]);
        Self { modes: all, snr_db }
    }

    /// Four modes, the nearest two 380 Hz apart.
    #[must_use]
    pub fn four_close() -> Self {
        Self {
            modes: vec![(F, 0.02), (450.0, 0.03), (1600.0, 0.015), (CLOSE_HZ, 0.03)],
            snr_db: None,
        }
    }

    /// Four modes of one damping ratio, the nearest two 250 Hz apart, in noise: what is before the
    /// record is a thousandfold in it there.
    #[must_use]
    pub fn four_close_in_noise(snr_db: f64) -> Self {
        Self {
            modes: vec![(F, 0.02), (450.0, 0.02), (1600.0, 0.02), (CLOSE_HZ, 0.02)],
            snr_db: Some(snr_db),
        }
    }

    /// The generator; every mode has variance 1.
    ///
    /// # Panics
    /// A mode is out of range.
    #[must_use]
    pub fn noise(&self, seed: u64) -> ModalNoise {
        let modes = self.modes.iter().map(|&(f_hz, zeta)| NoiseMode {
            f_hz,
            zeta,
            rms: 1.0,
        });
        ModalNoise::new(ModalNoiseConfig {
            fs_hz: FS,
            modes: modes.collect(),
            drive: Default::default(),
            quantity: Default::default(),
            snr_db: self.snr_db,
            seed: 100 + seed,
        })
        .expect("modes in range")
    }

    /// Damping ratio of the mode under test.
    #[must_use]
    pub fn zeta(&self) -> f64 {
        self.modes[0].1
    }

    /// Orders of A and C that describe the signal exactly.
    #[must_use]
    pub fn order(&self) -> (usize, usize) {
        self.noise(0).arma_order()
    }

    /// Least standard deviations of the mode under test after `samples`.
    #[must_use]
    pub fn bound(&self, samples: f64) -> ModeBound {
        let (f, zeta) = self.modes[0];
        let one = Bound::of_modes(&self.noise(0)).mode(f, zeta, FS);
        ModeBound {
            frequency: one.frequency / samples.sqrt(),
            damping: one.damping / samples.sqrt(),
        }
    }

    /// In words, for a table.
    #[must_use]
    pub fn name(&self) -> String {
        let (p, q) = self.order();
        let zeta = 100.0 * self.zeta();
        let several = self.modes.len() > 1;
        // One ratio of all of them, or that of the mode under test.
        let alike = several && self.modes.iter().all(|mode| mode.1 == self.zeta());
        let of = if alike { " of" } else { "," };
        let noise = self
            .snr_db
            .map_or(String::new(), |snr| format!(", SNR {snr} dB"));
        let plural = if several { "s" } else { "" };
        let close = if self.modes.iter().any(|mode| mode.0 == CLOSE_HZ) {
            " close"
        } else {
            ""
        };
        format!(
            "{}{close} mode{plural}{of} ζ {zeta} %{noise} ({p},{q})",
            self.modes.len()
        )
    }

    /// Of what a model holds the mode under test; none if nothing is near it.
    pub fn nearest(&self, found: impl Iterator<Item = Reading>) -> Option<Reading> {
        let off = |x: &Reading| (x.frequency - self.modes[0].0).abs();
        found
            .min_by(|x, y| off(x).total_cmp(&off(y)))
            .filter(|x| off(x) < REACH)
    }

    /// What the recursive estimator reads after `samples` of the series of this seed,
    /// in the precision `T`.
    ///
    /// # Panics
    /// The order is none of the box's.
    #[must_use]
    pub fn recursive<T: Real>(
        &self,
        config: RarmaConfig<T>,
        samples: usize,
        seed: u64,
    ) -> Option<Reading> {
        match self.order() {
            (2, 1) => self.run::<T, 2, 1, 3>(config, samples, seed),
            (2, 2) => self.run::<T, 2, 2, 4>(config, samples, seed),
            (4, 3) => self.run::<T, 4, 3, 7>(config, samples, seed),
            (4, 4) => self.run::<T, 4, 4, 8>(config, samples, seed),
            (6, 5) => self.run::<T, 6, 5, 11>(config, samples, seed),
            (6, 6) => self.run::<T, 6, 6, 12>(config, samples, seed),
            (8, 7) => self.run::<T, 8, 7, 15>(config, samples, seed),
            (8, 8) => self.run::<T, 8, 8, 16>(config, samples, seed),
            order => panic!("no recursive estimator of order {order:?}"),
        }
    }

    /// What the prediction-error method reads in `samples` of the series of this seed.
    ///
    /// # Panics
    /// The series fits no model.
    #[must_use]
    pub fn batch(&self, samples: usize, seed: u64) -> Option<Reading> {
        let (p, q) = self.order();
        let y: Vec<f64> = self.noise(seed).take(samples).collect();
        let pem = Pem::new(PemConfig::default()).expect("settings");
        self.read_fit(&pem.fit(&y, p, q).expect("a model"))
    }

    /// What a batch model reads.
    #[must_use]
    pub fn read_fit(&self, fit: &ArmaFit<f64, MOST_PARAMETERS>) -> Option<Reading> {
        let mut roots = FactorTracker::<f64, MOST_PARAMETERS>::new();
        roots.solve(fit.a(), 2000)?;
        self.nearest(roots.factors(fit.a().len()).iter().filter_map(|factor| {
            let mode = modal(factor, FS)?;
            let Roots::Pair { re, im } = factor.roots() else {
                return None;
            };
            let sd = fit.pole(re, im, FS)?;
            Some(Reading {
                frequency: mode.frequency,
                damping: mode.damping,
                frequency_sd: sd.frequency,
                damping_sd: sd.damping,
            })
        }))
    }

    fn run<T: Real, const P: usize, const Q: usize, const N: usize>(
        &self,
        config: RarmaConfig<T>,
        samples: usize,
        seed: u64,
    ) -> Option<Reading> {
        let mut model = RecursiveArma::<T, P, Q, N>::new(config);
        for y in self.noise(seed).take(samples) {
            model.update(T::from_f64(y));
        }
        let mut roots = FactorTracker::<T, P>::new();
        roots.solve(model.a(), 500)?;
        let (p, scale) = (model.covariance(), model.covariance_factor());
        let fs = T::from_f64(FS);
        self.nearest(roots.factors(P).iter().filter_map(|factor| {
            let mode = modal(factor, fs)?;
            let sd = deviation(model.a(), N, factor, fs, p, scale)?;
            Some(Reading {
                frequency: mode.frequency.to_f64(),
                damping: mode.damping.to_f64(),
                frequency_sd: sd.frequency.to_f64(),
                damping_sd: sd.damping.to_f64(),
            })
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mode_far_away_is_another_one() {
        let reading = |frequency| Reading {
            frequency,
            damping: 0.02,
            frequency_sd: 1.0,
            damping_sd: 0.001,
        };
        let case = Case::of(1, 0.02, None);
        let found = case.nearest([reading(450.0), reading(985.0)].into_iter());
        assert_eq!(found.map(|x| x.frequency), Some(985.0));
        assert!(case.nearest([reading(450.0)].into_iter()).is_none());
    }

    #[test]
    fn measurement_noise_raises_order_and_bound() {
        let (clear, noisy) = (Case::of(3, 0.02, None), Case::of(3, 0.02, Some(10.0)));
        assert_eq!((clear.order(), noisy.order()), ((6, 5), (6, 6)));
        assert!(noisy.bound(5000.0).damping > 1.05 * clear.bound(5000.0).damping);
    }
}
