//! A whole cut as a scenario: machine, microphone, timeline, and the truth about
//! it. The shipped scenarios are here.

use super::converter::{ConverterConfig, Reading};
use super::error::{PlantError, positive};
use super::growth::milling_limit_in_time;
use super::milling::{Engagement, MillSample, Milling, MillingConfig};
use super::modal::Mode;
use super::process::{ForceNoise, Schedule};
use super::sound::{Enclosure, Microphone, MicrophoneConfig, Pickup, Tone};
use super::stability::milling_limit;

/// Everything a simulated recording is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name it is known by.
    pub name: String,
    /// The machine and what it cuts.
    pub milling: MillingConfig,
    /// What listens.
    pub microphone: MicrophoneConfig,
    /// Length of the recording, s, > 0.
    pub duration_s: f64,
}

impl Scenario {
    /// Names of the shipped scenarios.
    pub const SHIPPED: [&'static str; 1] = ["chatter-onset"];

    /// A shipped scenario by name.
    #[must_use]
    pub fn shipped(name: &str, seed: u64) -> Option<Self> {
        (name == Self::SHIPPED[0]).then(|| Self::chatter_onset(seed))
    }

    /// The demonstration: a face mill of six teeth slots steel at 1680 rpm, into
    /// chatter and out again. Three teeth are always in the cut, so the coefficients
    /// hardly vary and the chatter is one clean line, as it is on real face mills.
    ///
    /// 0 to 1 s air; depth to 0.35 mm until 1.2 s; up to 1.25 mm until 6.2 s,
    /// through the limit on the way; held until 8 s; out by 8.1 s; air until 9 s.
    #[must_use]
    pub fn chatter_onset(seed: u64) -> Self {
        let mm = 1e-3;
        let points = [
            (1.0, 0.0),
            (1.2, 0.35 * mm),
            (6.2, 1.25 * mm),
            (8.0, 1.25 * mm),
            (8.1, 0.0),
        ];
        Self {
            name: Self::SHIPPED[0].to_owned(),
            milling: MillingConfig {
                teeth: 6,
                runout_m: vec![0.0, 3e-6, -2e-6, 1e-6, -1e-6, 2e-6],
                spindle_hz: 1680.0 / 60.0,
                feed_per_tooth_m: 150e-6,
                kt_n_per_m2: 1.8e9,
                kn_n_per_m2: 0.7e9,
                kt_edge_n_per_m: 25e3,
                kn_edge_n_per_m: 35e3,
                engagement: Engagement::SLOT,
                modes_x: vec![Mode::from_stiffness(880.0, 0.03, 2.5e7)],
                modes_y: vec![Mode::from_stiffness(1240.0, 0.03, 4.0e7)],
                depth: Schedule::new(&points).unwrap_or_else(|_| Schedule::constant(0.0)),
                noise: ForceNoise {
                    relative: 0.1,
                    background_n: 1.0,
                    ..ForceNoise::default()
                },
                min_step_rate_hz: 192_000.0,
                seed,
                ..MillingConfig::default()
            },
            microphone: MicrophoneConfig {
                sample_rate_hz: 48_000.0,
                pickup: Pickup::Acceleration,
                gain: [2e-3, 1.4e-3],
                distance_m: 0.5,
                enclosure: Some(Enclosure {
                    f_hz: 310.0,
                    zeta: 0.04,
                    gain: 1.0,
                }),
                noise_pa: 0.03,
                tones: vec![
                    Tone {
                        f_hz: 97.0,
                        amplitude_pa: 3e-3,
                    },
                    Tone {
                        f_hz: 679.0,
                        amplitude_pa: 1e-3,
                    },
                ],
                converter: ConverterConfig {
                    full_scale: 20.0,
                    bits: 16,
                    dither: true,
                },
                seed: seed.wrapping_add(1),
            },
            duration_s: 9.0,
        }
    }
}

/// What is true of a scenario, whatever an estimator says.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Spindle frequency, Hz.
    pub spindle_hz: f64,
    /// Number of teeth.
    pub teeth: usize,
    /// Tooth-passing frequency, Hz.
    pub tooth_hz: f64,
    /// Depth at which a small disturbance of the linear simulation neither
    /// grows nor decays, m, to 0.1 %; `None` if none was found within 15 % of
    /// the zero-order limit.
    pub limit_depth_m: Option<f64>,
    /// When the depth first rises through that limit, s.
    pub onset_s: Option<f64>,
    /// When it last falls back through it, s.
    pub end_s: Option<f64>,
    /// When there is any depth at all, from and to, s.
    pub cut_s: Option<(f64, f64)>,
    /// Chatter frequency at the zero-order limit, Hz.
    pub chatter_hz: Option<f64>,
    /// Modes in x.
    pub modes_x: Vec<Mode>,
    /// Modes in y.
    pub modes_y: Vec<Mode>,
}

impl Truth {
    /// Works out the truth of a milling configuration. Simulates a few seconds
    /// of the linear machine to find the limit.
    ///
    /// # Errors
    /// As [`Milling::new`].
    pub fn of(config: &MillingConfig) -> Result<Self, PlantError> {
        config.validate()?;
        let border = milling_limit(config).ok();
        let limit = border.and_then(|l| {
            milling_limit_in_time(config, 0.85 * l.depth_m, 1.15 * l.depth_m, 0.4, 1e-3).ok()
        });
        Ok(Self {
            spindle_hz: config.spindle_hz,
            teeth: config.teeth,
            tooth_hz: config.tooth_hz(),
            limit_depth_m: limit,
            onset_s: limit.and_then(|b| config.depth.rises_through(b)),
            end_s: limit.and_then(|b| config.depth.falls_through(b)),
            cut_s: config.depth.in_cut_s(),
            chatter_hz: border.map(|l| l.chatter_hz),
            modes_x: config.modes_x.clone(),
            modes_y: config.modes_y.clone(),
        })
    }
}

/// A scenario being played: an iterator over converted samples.
///
/// ```
/// use hal_sim::plant::cut::{Scenario, VirtualCut};
/// let mut cut = VirtualCut::new(Scenario::chatter_onset(1))?;
/// assert_eq!(cut.len(), 9 * 48_000);
/// let first = cut.next().map(|r| r.value);
/// assert!(first.is_some_and(|v| v.abs() < 0.1));
/// # Ok::<(), hal_sim::plant::error::PlantError>(())
/// ```
#[derive(Clone, Debug)]
pub struct VirtualCut {
    mill: Milling,
    microphone: Microphone,
    truth: Truth,
    state: MillSample,
    length: u64,
}

impl VirtualCut {
    /// Builds machine and microphone and works out the truth.
    ///
    /// # Errors
    /// As [`Milling::new`] and [`Microphone::new`].
    pub fn new(scenario: Scenario) -> Result<Self, PlantError> {
        positive(scenario.duration_s, "duration_s")?;
        let truth = Truth::of(&scenario.milling)?;
        let length = (scenario.duration_s * scenario.microphone.sample_rate_hz).round() as u64;
        let mill = Milling::new(scenario.milling)?;
        let rate = mill.fastest_step_rate_hz();
        let microphone = if mill.config().speed.is_some() {
            Microphone::timed(scenario.microphone, rate)?
        } else {
            Microphone::new(scenario.microphone, rate)?
        };
        Ok(Self {
            mill,
            microphone,
            truth,
            state: MillSample::default(),
            length,
        })
    }

    /// The truth about this cut.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// Samples per second, Hz.
    #[must_use]
    pub fn sample_rate_hz(&self) -> f64 {
        self.microphone.config().sample_rate_hz
    }

    /// The machine at its latest step, about half a millisecond ahead of the sound.
    #[must_use]
    pub fn machine(&self) -> &MillSample {
        &self.state
    }

    /// The microphone, for its converter and its count of clipped samples.
    #[must_use]
    pub fn microphone(&self) -> &Microphone {
        &self.microphone
    }
}

impl Iterator for VirtualCut {
    type Item = Reading;

    fn next(&mut self) -> Option<Reading> {
        if self.microphone.samples() >= self.length {
            return None;
        }
        let (mill, state) = (&mut self.mill, &mut self.state);
        Some(self.microphone.next_reading(|| {
            *state = mill.step();
            *state
        }))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = (self.length - self.microphone.samples()) as usize;
        (left, Some(left))
    }
}

impl ExactSizeIterator for VirtualCut {}

#[cfg(test)]
#[path = "cut_tests.rs"]
mod tests;
