//! A mode that loses its damping and gets it back: what the lag of a verdict is
//! measured on.
//!
//! The modes are exactly sampled ([`ModalNoise`]), so that the damping at each
//! instant is known and nothing else changes. White measurement noise is set once,
//! at [`SNR_DB`] below the vibration at full damping, and stays.

use rarma_plants::modal_noise::{Drive, ModalNoise, ModalNoiseConfig, NoiseMode, Quantity};

/// Rate, Hz.
pub const FS_HZ: f64 = 5000.0;
/// Frequency of the mode that changes, Hz.
pub const MODE_HZ: f64 = 980.0;
/// Frequency and damping ratio of the one beside it.
pub const BESIDE: (f64, f64) = (450.0, 0.04);
/// Vibration at full damping over measurement noise, dB.
pub const SNR_DB: f64 = 30.0;
/// Damping ratio before and after.
pub const DAMPED: f64 = 0.05;
/// Damping ratio in between.
pub const UNDAMPED: f64 = 0.001;
/// When the damping goes, and when it comes back, s.
pub const DOWN_S: f64 = 3.0;
/// See [`DOWN_S`].
pub const UP_S: f64 = 5.0;
/// End of the signal, s.
pub const END_S: f64 = 6.5;
/// Length of the ramp, s.
pub const RAMP_S: f64 = 0.5;
/// Scale of the samples: full scale is 1.
const SCALE: f64 = 0.05;
/// The damping of a ramp changes once in so many samples: 1 ms, 0.01 % of damping.
const RAMP_EVERY: u64 = 5;

/// What stays as it was when the damping changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Constant {
    /// The force. The mean square of a mode driven by white force is S/(4ζω³m²): it
    /// grows as the damping goes. This is what a machine does, and the reference.
    Force,
    /// The loudness: the force falls with the damping. Nothing but the damping tells.
    Loudness,
}

/// How the damping goes. It always comes back by a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// At once.
    Step,
    /// Linearly in [`RAMP_S`].
    Ramp,
    /// Not at all: it stays at this damping ratio in parts per thousand.
    Steady(u32),
}

impl Course {
    /// Damping ratio at time `t`, s.
    #[must_use]
    pub fn zeta(self, t: f64) -> f64 {
        match self {
            Self::Steady(thousandths) => 1e-3 * f64::from(thousandths),
            _ if !(DOWN_S..UP_S).contains(&t) => DAMPED,
            Self::Ramp if t < DOWN_S + RAMP_S => {
                DAMPED + (UNDAMPED - DAMPED) * (t - DOWN_S) / RAMP_S
            }
            _ => UNDAMPED,
        }
    }

    /// When the damping falls through `zeta`, s: the lag is counted from here.
    #[must_use]
    pub fn falls_through(self, zeta: f64) -> f64 {
        match self {
            Self::Ramp => DOWN_S + RAMP_S * (DAMPED - zeta) / (DAMPED - UNDAMPED),
            _ => DOWN_S,
        }
    }
}

/// One signal: an iterator over samples, without end.
#[derive(Debug, Clone)]
pub struct Stepping {
    noise: ModalNoise,
    course: Course,
    constant: Constant,
    modes: usize,
    zeta: f64,
    n: u64,
}

impl Stepping {
    /// The signal with this course, of one or two modes.
    ///
    /// # Panics
    /// `modes` is neither 1 nor 2.
    #[must_use]
    pub fn new(course: Course, constant: Constant, modes: usize, seed: u64) -> Self {
        assert!((1..=2).contains(&modes), "one or two modes");
        let noise = ModalNoise::new(ModalNoiseConfig {
            fs_hz: FS_HZ,
            modes: settings(DAMPED, constant, modes),
            drive: Drive::Independent,
            quantity: Quantity::Displacement,
            snr_db: Some(SNR_DB),
            seed,
        })
        .expect("modes in range");
        Self {
            noise,
            course,
            constant,
            modes,
            zeta: DAMPED,
            n: 0,
        }
    }
}

/// The modes at damping `zeta` of the first.
fn settings(zeta: f64, constant: Constant, modes: usize) -> Vec<NoiseMode> {
    let rms = match constant {
        Constant::Force => (DAMPED / zeta).sqrt(),
        Constant::Loudness => 1.0,
    };
    let all = [
        NoiseMode {
            f_hz: MODE_HZ,
            zeta,
            rms,
        },
        NoiseMode {
            f_hz: BESIDE.0,
            zeta: BESIDE.1,
            rms: 0.5,
        },
    ];
    all[..modes].to_vec()
}

impl Iterator for Stepping {
    type Item = f64;

    fn next(&mut self) -> Option<f64> {
        if self.n.is_multiple_of(RAMP_EVERY) {
            let zeta = self.course.zeta(self.n as f64 / FS_HZ);
            if zeta != self.zeta {
                self.zeta = zeta;
                let modes = settings(zeta, self.constant, self.modes);
                self.noise.retune(&modes).expect("modes in range");
            }
        }
        self.n += 1;
        Some(SCALE * self.noise.next_sample())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::rms;

    /// Loudness over one second from `from`, s.
    fn loudness(constant: Constant, from: f64) -> f64 {
        let samples = |seed| {
            Stepping::new(Course::Step, constant, 1, seed)
                .skip((from * FS_HZ) as usize)
                .take(FS_HZ as usize)
        };
        rms(&(0..40).flat_map(samples).collect::<Vec<_>>()) / SCALE
    }

    #[test]
    fn a_constant_force_is_heard_louder_as_the_damping_goes() {
        // √(5 %/0.1 %) = 7.07; 0.6 s after the step 98 % of the way in power is gone
        // (e^(−2·0.001·6158·t), mean over the next second).
        let (before, after) = (
            loudness(Constant::Force, 1.5),
            loudness(Constant::Force, 3.6),
        );
        assert!((before - 1.0).abs() < 0.02, "{before}");
        assert!((after / 7.07 - 1.0).abs() < 0.08, "{after}");
        let kept = loudness(Constant::Loudness, 3.6);
        assert!((kept - 1.0).abs() < 0.08, "{kept}");
    }

    #[test]
    fn a_ramp_passes_the_threshold_when_it_says() {
        let t = Course::Ramp.falls_through(0.01);
        assert!((Course::Ramp.zeta(t) - 0.01).abs() < 1e-12);
        assert!((t - DOWN_S - 0.408).abs() < 1e-3);
        assert_eq!(Course::Step.falls_through(0.01), DOWN_S);
        assert_eq!(Course::Steady(20).zeta(4.0), 0.02);
    }
}
