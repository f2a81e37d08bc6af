//! What a microphone in the enclosure (or an accelerometer on the spindle)
//! makes of the motion of the tool.
//!
//! Responsibility: the path from motion to converted samples. Rate: one call
//! per output sample, which asks the machine for as many steps as it needs; no
//! allocation after building.

use super::converter::{Converter, ConverterConfig, Reading};
use super::error::{PlantError, non_negative, positive, require};
use super::milling::MillSample;
use super::resample::Resampler;
use core::f64::consts::TAU;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Speed of sound in air at 20 °C, m/s.
pub const SPEED_OF_SOUND_M_S: f64 = 343.0;

/// The quantity that radiates or is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Pickup {
    /// Acceleration: far field of a small source, or an accelerometer.
    #[default]
    Acceleration,
    /// Velocity: a source large against the wavelength.
    Velocity,
    /// Displacement: a proximity probe at the tool.
    Displacement,
}

/// A resonance of the enclosure, added to the direct sound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosure {
    /// Frequency, Hz, > 0 and below half the sample rate.
    pub f_hz: f64,
    /// Damping ratio, 1, > 0.
    pub zeta: f64,
    /// Amplitude at resonance relative to the direct sound, 1.
    pub gain: f64,
}

/// A steady tone that has nothing to do with the spindle (fan, pump).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Frequency, Hz, > 0.
    pub f_hz: f64,
    /// Amplitude at the microphone, Pa, ≥ 0.
    pub amplitude_pa: f64,
}

/// Configuration of [`Microphone`].
#[derive(Clone, Debug, PartialEq)]
pub struct MicrophoneConfig {
    /// Sample rate of the converter, Hz, > 0. Default 48 000.
    pub sample_rate_hz: f64,
    /// What it picks up.
    pub pickup: Pickup,
    /// Gain from motion of the place of the sensor in x and y, Pa per m/s² (or per m/s, per m). For a probe or
    /// an accelerometer read "Pa" as its own unit throughout.
    pub gain: [f64; 2],
    /// Distance, m, ≥ 0: a delay of distance/343 s. Default 0.5.
    pub distance_m: f64,
    /// Enclosure resonance, if any.
    pub enclosure: Option<Enclosure>,
    /// White background noise, standard deviation, Pa, ≥ 0.
    pub noise_pa: f64,
    /// Fans and pumps.
    pub tones: Vec<Tone>,
    /// The converter; its full scale is in Pa.
    pub converter: ConverterConfig,
    /// Seed of noise and dither.
    pub seed: u64,
}

impl MicrophoneConfig {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        positive(self.sample_rate_hz, "sample_rate_hz")?;
        require(self.gain.iter().all(|g| g.is_finite()), "gain")?;
        non_negative(self.distance_m, "distance_m")?;
        if let Some(e) = &self.enclosure {
            require(
                e.f_hz > 0.0 && e.f_hz < 0.5 * self.sample_rate_hz,
                "enclosure",
            )?;
            require(
                e.zeta > 0.0 && e.zeta.is_finite() && e.gain.is_finite(),
                "enclosure",
            )?;
        }
        non_negative(self.noise_pa, "noise_pa")?;
        for tone in &self.tones {
            positive(tone.f_hz, "tones")?;
            non_negative(tone.amplitude_pa, "tones")?;
        }
        self.converter.validate()
    }
}

/// Second-order band-pass with gain 1 at its centre.
///
/// 2ζω·s/(s² + 2ζω·s + ω²) through the bilinear transform with the centre
/// frequency kept; transposed direct form II.
#[derive(Clone, Debug)]
struct BandPass {
    b: f64,
    a: [f64; 2],
    z: [f64; 2],
}

impl BandPass {
    fn new(f_hz: f64, zeta: f64, fs: f64) -> Self {
        let k = (0.5 * TAU * f_hz / fs).tan();
        let d = 1.0 + 2.0 * zeta * k + k * k;
        let a = [2.0 * (k * k - 1.0) / d, (1.0 - 2.0 * zeta * k + k * k) / d];
        Self {
            b: 2.0 * zeta * k / d,
            a,
            z: [0.0; 2],
        }
    }

    fn process(&mut self, x: f64) -> f64 {
        let y = self.b * x + self.z[0];
        self.z[0] = self.z[1] - self.a[0] * y;
        self.z[1] = -self.b * x - self.a[1] * y;
        y
    }
}

/// Motion in, converted sound out.
///
/// p = gx·ax + gy·ay, delayed and band-limited to the converter's rate, plus the
/// enclosure's resonance of it, plus background noise and tones; then the
/// converter. Sample m is the sound at m/fs, so it shows the tool as it was
/// distance/343 s earlier.
#[derive(Clone, Debug)]
pub struct Microphone {
    config: MicrophoneConfig,
    resampler: Resampler,
    enclosure: Option<(BandPass, f64)>,
    converter: Converter,
    rng: ChaCha8Rng,
    index: u64,
    clipped: u64,
    /// The machine's step rate changes: its samples' times are followed.
    timed: bool,
}

impl Microphone {
    /// Builds a microphone for a machine simulated at `step_rate_hz`.
    ///
    /// # Errors
    /// As [`MicrophoneConfig::validate`]; `OutOfRange` if the machine steps
    /// more slowly than the converter.
    pub fn new(config: MicrophoneConfig, step_rate_hz: f64) -> Result<Self, PlantError> {
        config.validate()?;
        let fs = config.sample_rate_hz;
        Ok(Self {
            resampler: Resampler::new(step_rate_hz, fs, config.distance_m / SPEED_OF_SOUND_M_S)?,
            enclosure: config
                .enclosure
                .map(|e| (BandPass::new(e.f_hz, e.zeta, fs), e.gain)),
            converter: Converter::new(config.converter, config.seed ^ 0x0d17_4e25)?,
            rng: ChaCha8Rng::seed_from_u64(config.seed),
            index: 0,
            clipped: 0,
            timed: false,
            config,
        })
    }

    /// For a machine whose step rate changes and is never above `step_rate_hz`: the
    /// times of its samples are followed.
    ///
    /// # Errors
    /// As [`Microphone::new`].
    pub fn timed(config: MicrophoneConfig, step_rate_hz: f64) -> Result<Self, PlantError> {
        Ok(Self {
            timed: true,
            ..Self::new(config, step_rate_hz)?
        })
    }

    /// Next sample; `machine` is stepped as often as needed.
    pub fn next_reading(&mut self, mut machine: impl FnMut() -> MillSample) -> Reading {
        let (gain, pickup) = (self.config.gain, self.config.pickup);
        let t = self.index as f64 / self.config.sample_rate_hz;
        let mut heard = || {
            let s = machine();
            let m = match pickup {
                Pickup::Acceleration => s.sensor[2],
                Pickup::Velocity => s.sensor[1],
                Pickup::Displacement => s.sensor[0],
            };
            (gain[0] * m[0] + gain[1] * m[1], s.t)
        };
        let direct = if self.timed {
            let late = self.config.distance_m / SPEED_OF_SOUND_M_S;
            self.resampler.next_at(t - late, heard)
        } else {
            self.resampler.next_sample(|| heard().0)
        };
        let mut p = direct;
        if let Some((filter, gain)) = &mut self.enclosure {
            p += *gain * filter.process(direct);
        }
        for tone in &self.config.tones {
            p += tone.amplitude_pa * (TAU * tone.f_hz * t).sin();
        }
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        p += self.config.noise_pa * noise;
        self.index += 1;
        let reading = self.converter.convert(p);
        self.clipped += u64::from(reading.clipped);
        reading
    }

    /// Samples given so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.index
    }

    /// Samples that clipped so far.
    #[must_use]
    pub fn clipped(&self) -> u64 {
        self.clipped
    }

    /// The converter.
    #[must_use]
    pub fn converter(&self) -> &Converter {
        &self.converter
    }

    /// The configuration it was built from.
    #[must_use]
    pub fn config(&self) -> &MicrophoneConfig {
        &self.config
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quiet() -> MicrophoneConfig {
        MicrophoneConfig {
            sample_rate_hz: 48_000.0,
            pickup: Pickup::Acceleration,
            gain: [0.5, 0.25],
            distance_m: 0.343,
            enclosure: None,
            noise_pa: 0.0,
            tones: Vec::new(),
            converter: ConverterConfig {
                full_scale: 10.0,
                bits: 32,
                dither: false,
            },
            seed: 1,
        }
    }

    /// Amplitude and phase of a 1 kHz motion of 2 m/s² in x as it is heard.
    fn heard(config: MicrophoneConfig) -> (f64, f64) {
        let mut microphone = Microphone::new(config, 192_000.0).expect("valid");
        let mut step = 0.0;
        let (mut re, mut im) = (0.0, 0.0);
        for m in 0..9600 {
            let p = 10.0
                * f64::from(
                    microphone
                        .next_reading(|| {
                            step += 1.0;
                            let a = 2.0 * (TAU * 1000.0 * step / 192_000.0).sin();
                            MillSample {
                                sensor: [[0.0; 2], [0.0; 2], [a, 0.0]],
                                ..MillSample::default()
                            }
                        })
                        .value,
                );
            if m >= 4800 {
                let (s, c) = (TAU * 1000.0 * f64::from(m) / 48_000.0).sin_cos();
                re += p * s / 2400.0;
                im += p * c / 2400.0;
            }
        }
        (re.hypot(im), im.atan2(re))
    }

    #[test]
    fn gain_and_delay() {
        // 1 ms at 1 kHz is a whole turn; 0.25 ms more is a quarter turn.
        let (amplitude, phase) = heard(quiet());
        assert!(
            (amplitude - 1.0).abs() < 1e-3 && phase.abs() < 1e-3,
            "{amplitude} {phase}"
        );
        let (_, phase) = heard(MicrophoneConfig {
            distance_m: 0.343 * 1.25,
            ..quiet()
        });
        assert!((phase + 0.25 * TAU).abs() < 1e-3, "{phase}");
    }

    #[test]
    fn enclosure_raises_its_own_frequency() {
        let at = |f_hz| {
            let e = Enclosure {
                f_hz,
                zeta: 0.05,
                gain: 3.0,
            };
            heard(MicrophoneConfig {
                enclosure: Some(e),
                ..quiet()
            })
            .0
        };
        assert!((at(1000.0) - 4.0).abs() < 0.01);
        assert!((at(6000.0) - 1.0).abs() < 0.02);
    }

    #[test]
    fn noise_tones_and_clipping() {
        let mut config = quiet();
        config.noise_pa = 0.2;
        config.tones = vec![Tone {
            f_hz: 100.0,
            amplitude_pa: 0.4,
        }];
        let mut microphone = Microphone::new(config, 192_000.0).expect("valid");
        let n = 48_000;
        let power = (0..n)
            .map(|_| (10.0 * f64::from(microphone.next_reading(MillSample::default).value)).powi(2))
            .sum::<f64>()
            / f64::from(n);
        assert!((power / (0.04 + 0.08) - 1.0).abs() < 0.03, "{power}");
        assert_eq!((microphone.clipped(), microphone.samples()), (0, 48_000));
        let mut small = quiet();
        small.converter.full_scale = 0.1;
        let mut microphone = Microphone::new(small, 192_000.0).expect("valid");
        for _ in 0..480 {
            microphone.next_reading(|| MillSample {
                sensor: [[0.0; 2], [0.0; 2], [1.0, 0.0]],
                ..MillSample::default()
            });
        }
        assert!(microphone.clipped() > 0);
    }
}
