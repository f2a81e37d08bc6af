//! What listens: sensor, sampler, gain, bits.

use super::ranges::{self as r, chance, one_of};
use crate::converter::ConverterConfig;
use crate::sound::{Enclosure, MicrophoneConfig, Pickup};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Rate at which a sampler without a filter still follows the sound, Hz.
const OPEN_HZ: f64 = 48_000.0;

/// A sensor and its sampler.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Sampling rate, Hz.
    pub fs_hz: f64,
    /// 1: with an anti-alias filter. Else one of so many samples is kept, unfiltered.
    pub folds: usize,
    /// Bits of the converter.
    pub bits: u32,
    /// Full scale over the loudest sample, where it does not clip.
    pub headroom: f64,
    /// Part of the samples that clip.
    pub clips: Option<f64>,
    pickup: Pickup,
    gain: [f64; 2],
    distance_m: f64,
    enclosure: Option<Enclosure>,
}

impl Sensor {
    pub(super) fn draw(rng: &mut ChaCha8Rng) -> Self {
        let fs_hz = one_of(rng, &r::RATES_HZ);
        let folds = if chance(rng, r::UNFILTERED) {
            (OPEN_HZ / fs_hz).round().max(1.0) as usize
        } else {
            1
        };
        // An accelerometer hangs on the machine: no way through the air, no enclosure.
        let microphone = chance(rng, 0.7);
        let (often, f, zeta, gain) = r::ENCLOSURE;
        let enclosure = (microphone && chance(rng, often)).then(|| Enclosure {
            f_hz: f.draw(rng).min(0.4 * fs_hz),
            zeta: zeta.draw(rng),
            gain: gain.draw(rng),
        });
        Self {
            fs_hz,
            folds,
            bits: one_of(rng, &r::BITS),
            headroom: r::HEADROOM.draw(rng),
            clips: chance(rng, r::CLIPPED.0).then(|| r::CLIPPED.1.draw(rng)),
            pickup: if microphone {
                one_of(rng, &[Pickup::Acceleration, Pickup::Velocity])
            } else {
                Pickup::Acceleration
            },
            gain: [1.0, rng.random()],
            distance_m: if microphone {
                r::DISTANCE_M.draw(rng)
            } else {
                0.0
            },
            enclosure,
        }
    }

    /// It hangs on the machine; else it is a microphone.
    #[must_use]
    pub fn accelerometer(&self) -> bool {
        self.distance_m == 0.0
    }

    /// Rate before samples are left out, Hz.
    #[must_use]
    pub fn inner_hz(&self) -> f64 {
        self.fs_hz * self.folds as f64
    }

    /// Full scale for these samples.
    pub(super) fn full_scale(&self, samples: &[f64]) -> f64 {
        let mut sizes: Vec<f64> = samples.iter().map(|x| x.abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        let beyond = self
            .clips
            .map_or(0, |part| (part * sizes.len() as f64) as usize);
        let largest = sizes.iter().rev().nth(beyond).copied().unwrap_or(0.0);
        let headroom = if self.clips.is_some() {
            1.0
        } else {
            self.headroom
        };
        (largest * headroom).max(f64::MIN_POSITIVE)
    }

    pub(super) fn microphone(&self, converter: ConverterConfig) -> MicrophoneConfig {
        MicrophoneConfig {
            sample_rate_hz: self.inner_hz(),
            pickup: self.pickup,
            gain: self.gain,
            distance_m: self.distance_m,
            enclosure: self.enclosure,
            noise_pa: 0.0,
            tones: Vec::new(),
            converter,
            seed: 0,
        }
    }
}
