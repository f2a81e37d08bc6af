//! A stable cut with its forced lines: modes under white force, tooth harmonics far
//! above them, and the multiples of the spindle that runout gives.
//!
//! The lines are multiples of one angle, the spindle's, so that they move together
//! when the speed does, to the bit. The modes are exactly sampled ([`ModalNoise`]).

use core::f64::consts::{PI, TAU};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_plants::modal_noise::{Drive, ModalNoise, ModalNoiseConfig, NoiseMode, Quantity};

/// Power of all tooth harmonics together over that of the modes, dB.
pub const FORCED_DB: f64 = 20.0;
/// Modes over measurement noise, dB.
const SNR_DB: f64 = 30.0;
/// No line above this part of the rate, nor above [`TOP_HZ`]: an anti-aliasing
/// filter and the ear of a microphone.
const TOP_FRACTION: f64 = 0.45;
/// See [`TOP_FRACTION`].
const TOP_HZ: f64 = 5000.0;
/// Scale of the samples: full scale is 1, and 20 dB above the modes must fit in.
const SCALE: f64 = 0.005;

/// An override turned step by step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverrideSteps {
    /// From, s.
    pub from_s: f64,
    /// One every so many seconds.
    pub every_s: f64,
    /// The spindle takes so long for each, s.
    pub within_s: f64,
    /// So many.
    pub count: u32,
    /// By this part of the starting speed each.
    pub part: f64,
}

impl OverrideSteps {
    /// Part of the starting speed that has been added at `t` s.
    fn added(&self, t: f64) -> f64 {
        let steps = ((t - self.from_s) / self.every_s).max(0.0);
        let whole = steps.floor().min(f64::from(self.count));
        let moving = if whole < f64::from(self.count) {
            ((steps - whole) * self.every_s / self.within_s).min(1.0)
        } else {
            0.0
        };
        self.part * (whole + moving)
    }

    /// The most that is added.
    fn most(&self) -> f64 {
        (self.part * f64::from(self.count)).max(0.0)
    }
}

/// A signal, but for its random part.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcedConfig {
    /// Rate, Hz.
    pub fs_hz: f64,
    /// Frequency (Hz) and damping ratio of each mode; equally loud, variance 1 together.
    pub modes: Vec<(f64, f64)>,
    /// Spindle frequency at the start, Hz.
    pub spindle_hz: f64,
    /// Teeth.
    pub teeth: u32,
    /// Runout lines below the tooth lines there, dB, at every multiple of the spindle
    /// by chance within these; none if there is no runout.
    pub runout_db: Option<(f64, f64)>,
    /// The speed changes from, to (s), by this part of the starting speed a second.
    pub ramp: Option<(f64, f64, f64)>,
    /// An operator turns the override.
    pub steps: Option<OverrideSteps>,
    /// The speed swings by this part of it, so many times a second.
    pub swing: Option<(f64, f64)>,
    /// All lines swell by this part of them, so many times a second.
    pub swell: Option<(f64, f64)>,
    /// A mode (by place) whose damping goes: from when (s), in how long (s), to what
    /// damping ratio, under a force that stays.
    pub fading: Option<(usize, f64, f64, f64)>,
    /// Seed of phases, amplitudes and noise.
    pub seed: u64,
}

/// One mode, or three.
#[must_use]
pub fn some_modes(three: bool, rng: &mut impl Rng) -> Vec<(f64, f64)> {
    if three {
        [450.0, 980.0, 1700.0]
            .map(|f_hz| (f_hz, rng.random_range(0.02..0.05)))
            .to_vec()
    } else {
        vec![(980.0, 0.03)]
    }
}

/// A speed (Hz) and number of teeth: 1500 to 12 000 rpm, two to six.
pub fn some_speed(rng: &mut impl Rng) -> (f64, u32) {
    (rng.random_range(25.0..200.0), rng.random_range(2..=6))
}

impl ForcedConfig {
    /// A stable cut drawn by this seed: one and three modes, 48 and 5 kHz take turns.
    #[must_use]
    pub fn drawn(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(0x0f0c_ed00 + seed);
        let (spindle_hz, teeth) = some_speed(&mut rng);
        Self {
            fs_hz: if seed.is_multiple_of(2) {
                5000.0
            } else {
                48_000.0
            },
            modes: some_modes(seed % 4 >= 2, &mut rng),
            spindle_hz,
            teeth,
            runout_db: Some((10.0, 20.0)),
            ramp: None,
            steps: None,
            swing: None,
            swell: None,
            fading: None,
            seed,
        }
    }

    /// Tooth frequency at the start, Hz.
    #[must_use]
    pub fn tooth_hz(&self) -> f64 {
        self.spindle_hz * f64::from(self.teeth)
    }

    /// Tooth lines in a band, at the starting speed.
    #[must_use]
    pub fn tooth_lines(&self, low_hz: f64, high_hz: f64) -> u32 {
        let below = |f: f64| (f / self.tooth_hz()).floor() as u32;
        below(high_hz) - below(low_hz)
    }

    /// Highest spindle frequency there will be, Hz.
    fn fastest_hz(&self) -> f64 {
        let change = self.ramp.map_or(0.0, |(from, to, rate)| rate * (to - from));
        let swing = self.swing.map_or(0.0, |(part, _)| part);
        let steps = self.steps.map_or(0.0, |steps| steps.most());
        self.spindle_hz * (1.0 + change.max(0.0) + swing + steps)
    }

    /// The modes when mode `fading` has damping `zeta` under a force that stays.
    fn noise_modes(&self, faded: Option<f64>) -> Vec<NoiseMode> {
        let rms = (1.0 / self.modes.len() as f64).sqrt();
        let mode = |(k, &(f_hz, zeta)): (usize, &(f64, f64))| match (self.fading, faded) {
            (Some((fading, ..)), Some(now)) if fading == k => NoiseMode {
                f_hz,
                zeta: now,
                rms: rms * (zeta / now).sqrt(),
            },
            _ => NoiseMode { f_hz, zeta, rms },
        };
        self.modes.iter().enumerate().map(mode).collect()
    }
}

/// The signal: an iterator over samples, without end.
#[derive(Debug, Clone)]
pub struct Forced {
    config: ForcedConfig,
    noise: ModalNoise,
    /// Complex amplitude of every multiple of the spindle from 1 on.
    lines: Vec<(f64, f64)>,
    angle: f64,
    zeta: Option<f64>,
    n: u64,
}

impl Forced {
    /// Draws phases and amplitudes. The k-th tooth harmonic has about k^(−α), α by
    /// chance from 0.5 to 1.5, and ±3 dB by chance.
    ///
    /// # Panics
    /// A mode is out of range.
    #[must_use]
    pub fn new(config: ForcedConfig) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
        let noise = ModalNoise::new(ModalNoiseConfig {
            fs_hz: config.fs_hz,
            modes: config.noise_modes(None),
            drive: Drive::Independent,
            quantity: Quantity::Displacement,
            snr_db: Some(SNR_DB),
            seed: config.seed.wrapping_add(77),
        })
        .expect("modes in range");
        let top = (TOP_FRACTION * config.fs_hz).min(TOP_HZ);
        let count = (top / config.fastest_hz()).floor() as u32;
        let fall: f64 = rng.random_range(0.5..1.5);
        let mut lines = Vec::new();
        let mut power = 0.0;
        for n in 1..=count {
            let order = f64::from(n) / f64::from(config.teeth);
            let tooth = n.is_multiple_of(config.teeth);
            let db: f64 = match (tooth, config.runout_db) {
                (true, _) => rng.random_range(-3.0..3.0),
                (false, Some((least, most))) => -rng.random_range(least..most),
                (false, None) => f64::NEG_INFINITY,
            };
            let size = order.max(1.0).powf(-fall) * 10f64.powf(db / 20.0);
            let (sin, cos) = rng.random_range(-PI..PI).sin_cos();
            if tooth {
                power += 0.5 * size * size;
            }
            lines.push((size * cos, size * sin));
        }
        let scale = (10f64.powf(FORCED_DB / 10.0) / power).sqrt();
        for (re, im) in &mut lines {
            *re *= scale;
            *im *= scale;
        }
        Self {
            noise,
            lines,
            angle: 0.0,
            zeta: None,
            n: 0,
            config,
        }
    }

    /// Amplitude of the multiple `n` of the spindle, in rms of the modes together.
    #[must_use]
    pub fn amplitude(&self, n: usize) -> f64 {
        n.checked_sub(1)
            .and_then(|k| self.lines.get(k))
            .map_or(0.0, |(re, im)| re.hypot(*im))
    }

    /// Σ Re(c_n z^n), z = e^(j·angle), by Horner's rule.
    fn forced(&self) -> f64 {
        let (sin, cos) = self.angle.sin_cos();
        let (mut re, mut im) = (0.0, 0.0);
        for (a, b) in self.lines.iter().rev() {
            let (x, y) = (re + a, im + b);
            re = x * cos - y * sin;
            im = x * sin + y * cos;
        }
        re
    }

    fn spindle_hz(&self, t: f64) -> f64 {
        let change = self
            .config
            .ramp
            .map_or(0.0, |(from, to, rate)| rate * (t.clamp(from, to) - from));
        let steps = self.config.steps.map_or(0.0, |steps| steps.added(t));
        self.config.spindle_hz * (1.0 + change + steps + wave(self.config.swing, t))
    }

    /// Lets the fading mode fade, once a millisecond.
    fn fade(&mut self, t: f64) {
        let Some((mode, from, length, end)) = self.config.fading else {
            return;
        };
        let every = (self.config.fs_hz * 1e-3).ceil() as u64;
        if t < from || !self.n.is_multiple_of(every) {
            return;
        }
        let part = ((t - from) / length).min(1.0);
        let zeta = self.config.modes[mode].1 * (1.0 - part) + end * part;
        if self.zeta != Some(zeta) {
            self.zeta = Some(zeta);
            let modes = self.config.noise_modes(self.zeta);
            self.noise.retune(&modes).expect("modes in range");
        }
    }
}

/// part·sin(2π·hz·t).
fn wave(of: Option<(f64, f64)>, t: f64) -> f64 {
    of.map_or(0.0, |(part, hz)| part * (TAU * hz * t).sin())
}

impl Iterator for Forced {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        let t = self.n as f64 / self.config.fs_hz;
        self.fade(t);
        let y = self.noise.next_sample() + self.forced() * (1.0 + wave(self.config.swell, t));
        self.angle = (self.angle + TAU * self.spindle_hz(t) / self.config.fs_hz) % TAU;
        self.n += 1;
        Some(SCALE * y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::rms;

    #[test]
    fn the_lines_are_as_loud_as_they_say() {
        for seed in 0..4 {
            let config = ForcedConfig {
                runout_db: None,
                ..ForcedConfig::drawn(seed)
            };
            let n = (4.0 * config.fs_hz) as usize;
            let samples: Vec<f64> = Forced::new(config).take(n).collect();
            let power = (rms(&samples) / SCALE).powi(2);
            // 100 of the lines, 1 of the modes, 0.001 of the sensor.
            assert!((power / 101.0 - 1.0).abs() < 0.03, "seed {seed}: {power}");
        }
    }

    #[test]
    fn a_ramp_ends_where_it_should_and_runout_lies_below() {
        let config = ForcedConfig {
            ramp: Some((1.0, 3.0, 0.1)),
            ..ForcedConfig::drawn(3)
        };
        let (start, teeth) = (config.spindle_hz, config.teeth as usize);
        let signal = Forced::new(config);
        assert!((signal.spindle_hz(9.0) / start - 1.2).abs() < 1e-12);
        assert!((signal.spindle_hz(0.5) / start - 1.0).abs() < 1e-12);
        let (tooth, runout) = (signal.amplitude(teeth), signal.amplitude(teeth - 1));
        let db = 20.0 * (runout / tooth).log10();
        assert!((-23.0..-7.0).contains(&db), "{db}");
    }

    #[test]
    fn an_override_is_turned_step_by_step() {
        let steps = OverrideSteps {
            from_s: 2.0,
            every_s: 1.0,
            within_s: 0.2,
            count: 3,
            part: -0.01,
        };
        let config = ForcedConfig {
            steps: Some(steps),
            ..ForcedConfig::drawn(3)
        };
        let start = config.spindle_hz;
        let signal = Forced::new(config);
        for (t, added) in [
            (1.9, 0.0),
            (2.1, -0.005),
            (2.9, -0.01),
            (3.1, -0.015),
            (9.0, -0.03),
        ] {
            let there = signal.spindle_hz(t) / start - 1.0;
            assert!((there - added).abs() < 1e-9, "{t} s: {there}");
        }
    }

    #[test]
    fn the_fading_mode_ends_at_its_damping() {
        let config = ForcedConfig {
            fading: Some((0, 1.0, 0.5, 0.0005)),
            ..ForcedConfig::drawn(0)
        };
        let mut signal = Forced::new(config);
        signal.nth((1.6 * 5000.0) as usize);
        let zeta = signal.noise.true_poles()[0].zeta;
        assert!((zeta - 0.0005).abs() < 1e-12, "{zeta}");
    }
}
