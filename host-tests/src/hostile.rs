//! Signals that are hard on a recursive estimator, without end and at a few
//! nanoseconds a sample, and the good signal by which its health is judged after.

use crate::signal;
use rarma_plants::modal::Mode;
use rarma_plants::modal_noise::ModalNoise;
use rarma_plants::process::{Contact, ForceNoise, Schedule};
use rarma_plants::stability::turning_limit;
use rarma_plants::turning::{Turning, TurningConfig};
use std::f64::consts::TAU;

/// Sampling rate of every signal here, Hz: 48 kHz after the box's decimation by 8.
pub const FS: f64 = 6000.0;
/// The mode of the good signal: natural frequency in Hz, damping ratio.
pub const GOOD_MODE: (f64, f64) = (980.0, 0.02);
/// Its standard deviation, where full scale is 1.
pub const GOOD_RMS: f64 = 0.1;
const SECOND: u64 = FS as u64;

/// Samples for ever, where full scale is 1 unless the signal says otherwise.
pub type Samples = Box<dyn Iterator<Item = f32> + Send>;

/// A hard signal by name.
pub struct Hostile {
    /// What the table calls it.
    pub name: &'static str,
    /// Its size, where full scale is 1.
    pub size: f64,
    /// Starts it anew.
    pub start: fn() -> Samples,
}

/// The nine that a box may hear for days.
pub const EVERYDAY: [Hostile; 9] = [
    Hostile {
        name: "three modes, tooth harmonic",
        size: 1.0,
        start: || {
            sum(
                modes(&[(600.0, 0.03), (980.0, 0.02), (1900.0, 0.025)], 11),
                tone(500.0, 0.2),
            )
        },
    },
    Hostile {
        name: "one mode, ζ = 0.07 %",
        size: 1.0,
        start: || modes(&[(980.0, 0.0007)], 12),
    },
    Hostile {
        name: "turning in chatter",
        size: 1.0,
        start: chatter,
    },
    Hostile {
        name: "silence",
        size: 1.0,
        start: || every(|_| 0.0),
    },
    Hostile {
        name: "constant 0.5",
        size: 1.0,
        start: || every(|_| 0.5),
    },
    Hostile {
        name: "1 s silence, 1 s full-scale tone",
        size: 1.0,
        start: || gated(tone(700.0, 1.0), 2 * SECOND, SECOND),
    },
    Hostile {
        name: "one impulse a second",
        size: 1.0,
        start: || every(|k| f32::from(u8::from(k % SECOND == SECOND / 2))),
    },
    Hostile {
        name: "white noise",
        size: 1.0,
        start: || white(0.3, 13),
    },
    Hostile {
        name: "clipped sine",
        size: 1.0,
        start: || Box::new(tone(437.3, 1.5).map(|y| y.clamp(-1.0, 1.0))),
    },
];

/// Those that only a fault, or a broken file, brings.
pub const RARE: [Hostile; 15] = [
    Hostile {
        name: "steps of 1e6 every second",
        size: 1e6,
        start: || every(|k| if k / SECOND % 2 == 1 { 1e6 } else { 0.0 }),
    },
    Hostile {
        name: "denormal noise (1e-40)",
        size: 1.0,
        start: || white(1e-40, 21),
    },
    Hostile {
        name: "noise of 1e-20",
        size: 1.0,
        start: || white(1e-20, 22),
    },
    Hostile {
        name: "noise of 1e8",
        size: 1e8,
        start: || white(1e8, 23),
    },
    Hostile {
        name: "noise of 1e-20 and 1e8, 1 s each",
        size: 1e8,
        start: || {
            Box::new(white(1.0, 24).enumerate().map(|(k, y)| {
                y * if k as u64 / SECOND % 2 == 1 {
                    1e8
                } else {
                    1e-20
                }
            }))
        },
    },
    Hostile {
        name: "bursts of 100 NaN, 10 a second",
        size: 1.0,
        start: || {
            spoiled(
                25,
                |k, y| if k % (SECOND / 10) < 100 { f32::NAN } else { y },
            )
        },
    },
    Hostile {
        name: "one mode at 0.49 fs",
        size: 1.0,
        start: || modes(&[(0.49 * FS, 0.001)], 26),
    },
    Hostile {
        name: "mode on a constant that jumps by 10",
        size: 10.0,
        start: || spoiled(27, |k, y| if k / SECOND % 2 == 1 { y + 10.0 } else { y }),
    },
    Hostile {
        name: "10 s of zeros, 1 s of mode",
        size: 1.0,
        start: || gated(good(28), 11 * SECOND, SECOND),
    },
    Hostile {
        name: "single samples of 1e4 times",
        size: 1e3,
        start: || spoiled(29, |k, y| if k % (SECOND / 3) == 7 { 1e4 * y } else { y }),
    },
    Hostile {
        name: "two lines 1 Hz apart",
        size: 1.0,
        start: || sum(tone(980.0, 0.4), tone(981.0, 0.4)),
    },
    Hostile {
        name: "pure line at fs/4",
        size: 1.0,
        start: || every(|k| [0.0, 1.0, 0.0, -1.0][k as usize % 4]),
    },
    Hostile {
        name: "alternating at fs/2",
        size: 1.0,
        start: || every(|k| if k % 2 == 0 { 1.0 } else { -1.0 }),
    },
    Hostile {
        name: "three bits of a quiet mode",
        size: 1.0,
        start: || Box::new(good(30).map(|y| (y * 20.0).round() / 20.0)),
    },
    Hostile {
        name: "noise of 1e12",
        size: 1e12,
        start: || white(1e12, 31),
    },
];

/// The mode by which an estimator is judged, driven by white noise and exactly
/// sampled: ARMA(2,1).
#[must_use]
pub fn good_noise(seed: u64) -> ModalNoise {
    modal(&[GOOD_MODE], seed)
}

fn good(seed: u64) -> Samples {
    modes(&[GOOD_MODE], seed)
}

fn modal(modes: &[(f64, f64)], seed: u64) -> ModalNoise {
    signal::modes_of(GOOD_RMS, modes, FS, seed)
}

fn modes(list: &[(f64, f64)], seed: u64) -> Samples {
    Box::new(modal(list, seed).map(|y| y as f32))
}

fn every(at: fn(u64) -> f32) -> Samples {
    Box::new((0..).map(at))
}

fn white(scale: f64, seed: u64) -> Samples {
    Box::new(signal::white(seed).map(move |y| (scale * y) as f32))
}

fn tone(f_hz: f64, amplitude: f64) -> impl Iterator<Item = f32> + Send + 'static {
    // The phase of this sample, kept small: k/fs loses digits over days.
    let mut turns = 0.0;
    std::iter::repeat_with(move || {
        turns = (turns + f_hz / FS) % 1.0;
        (amplitude * (TAU * turns).sin()) as f32
    })
}

fn sum(
    x: impl Iterator<Item = f32> + Send + 'static,
    y: impl Iterator<Item = f32> + Send + 'static,
) -> Samples {
    Box::new(x.zip(y).map(|(x, y)| x + y))
}

/// `samples` in the last `on` of every `period` samples, zeros before.
fn gated(samples: impl Iterator<Item = f32> + Send + 'static, period: u64, on: u64) -> Samples {
    Box::new(samples.zip(0..).map(
        move |(y, k): (f32, u64)| {
            if k % period < period - on { 0.0 } else { y }
        },
    ))
}

/// The good mode with something done to it.
fn spoiled(seed: u64, what: fn(u64, f32) -> f32) -> Samples {
    Box::new(good(seed).zip(0..).map(move |(y, k)| what(k, y)))
}

/// Velocity of the tool of a lathe at one and a half times its limit width, in the
/// limit cycle that the loss of contact makes: scaled to half of full scale.
fn chatter() -> Samples {
    const MODE: Mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);
    const KS: f64 = 2e9;
    const STEPS: usize = 8;
    let mut lathe = Turning::new(TurningConfig {
        spindle_hz: 150.0,
        variation: None,
        feed_m: 1e-4,
        nose_radius_m: 0.8e-3,
        ks_n_per_m2: KS,
        edge_n_per_m: 0.0,
        modes: vec![MODE],
        width: Schedule::constant(1.5 * turning_limit(&MODE, KS).depth_m),
        process_damping: None,
        noise: ForceNoise::default(),
        contact: Contact::Real,
        min_step_rate_hz: STEPS as f64 * FS,
        seed: 0,
    })
    .expect("settings in range");
    assert!((lathe.dt() * STEPS as f64 * FS - 1.0).abs() < 1e-9);
    let mut next = move || {
        // The mean over the steps of a sample stands for the anti-alias filter.
        (0..STEPS).map(|_| lathe.step().velocity_m_s).sum::<f64>() / STEPS as f64
    };
    for _ in 0..SECOND {
        next();
    }
    let peak = (0..SECOND).map(|_| next().abs()).fold(0.0, f64::max);
    Box::new(std::iter::repeat_with(move || (0.5 * next() / peak) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chatter_is_one_steady_line_near_the_mode_and_its_harmonics() {
        let y: Vec<f64> = chatter().take(6 * FS as usize).map(f64::from).collect();
        let line = |f: f64| {
            let (mut re, mut im) = (0.0, 0.0);
            for (k, y) in y.iter().enumerate() {
                let (s, c) = (TAU * f * k as f64 / FS).sin_cos();
                re += y * c;
                im += y * s;
            }
            2.0 * re.hypot(im) / y.len() as f64
        };
        // 1/6 Hz of resolution over the band in which a 980 Hz mode chatters.
        let (f, size) = (0..1200)
            .map(|i| 950.0 + f64::from(i) / 6.0)
            .map(|f| (f, line(f)))
            .fold((0.0, 0.0), |best, x| if x.1 > best.1 { x } else { best });
        assert!((985.0..1120.0).contains(&f) && size > 0.3, "{f} Hz, {size}");
        assert!(line(2.0 * f) > 1e-4, "no harmonic");
        let rms = |y: &[f64]| (y.iter().map(|y| y * y).sum::<f64>() / y.len() as f64).sqrt();
        let (early, late) = y.split_at(y.len() / 2);
        assert!((rms(late) / rms(early) - 1.0).abs() < 0.02, "not steady");
    }

    #[test]
    fn every_signal_starts_anew_the_same() {
        for hostile in EVERYDAY.iter().chain(&RARE) {
            let some = || (hostile.start)().take(2000).map(f32::to_bits);
            assert!(some().eq(some()), "{}", hostile.name);
        }
    }
}
