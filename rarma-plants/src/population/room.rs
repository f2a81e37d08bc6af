//! What else is to be heard in a workshop.

use super::ranges::{self as r, Span, chance, one_of};
use core::f64::consts::TAU;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A tone that wanders: a fan, a pump, another machine's chatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Mean frequency, Hz.
    pub f_hz: f64,
    /// Level, dB over the cut.
    pub level_db: f64,
    /// Random walk of the frequency, part of it in a second.
    pub wander: f64,
    /// From and to, s.
    pub on_s: (f64, f64),
}

/// Something that is hit and rings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knock {
    /// When, s.
    pub at_s: f64,
    /// What rings, Hz.
    pub f_hz: f64,
    /// Its damping ratio, 1.
    pub zeta: f64,
    /// Peak, dB over the cut's root mean square.
    pub peak_db: f64,
}

/// What there is beside the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Room {
    /// White noise, dB over the cut.
    pub noise_db: f64,
    /// Fans and pumps.
    pub tones: Vec<Tone>,
    /// Mains, 50 or 60 Hz, and the level of its strongest multiple, dB.
    pub mains: Option<(f64, f64)>,
    /// Knocks.
    pub knocks: Vec<Knock>,
    /// A jet of compressed air: from, to (s), dB.
    pub jet: Option<(f64, f64, f64)>,
    /// Speech: pitch Hz, dB.
    pub speech: Option<(f64, f64)>,
    /// A machine next to it that chatters.
    pub neighbour: Option<Tone>,
    seed: u64,
}

/// Multiples of the mains that are heard.
const MAINS_MULTIPLES: u32 = 12;
/// Voiced multiples of a voice.
const VOICE_MULTIPLES: u32 = 16;

impl Room {
    /// Draws what there is during `length_s`.
    pub(super) fn draw(rng: &mut ChaCha8Rng, length_s: f64) -> Self {
        let tone = |rng: &mut ChaCha8Rng, f: Span, db: Span, wander: Span, on_s| Tone {
            f_hz: f.draw(rng),
            level_db: db.draw(rng),
            wander: wander.draw(rng),
            on_s,
        };
        let always = (f64::NEG_INFINITY, f64::INFINITY);
        let mut tones = Vec::new();
        if chance(rng, r::TONES.0) {
            for _ in 0..rng.random_range(1..=r::TONES.1) {
                // One in five starts or stops meanwhile.
                let mut on_s = always;
                if chance(rng, 0.2) {
                    let t = length_s * rng.random::<f64>();
                    on_s = one_of(rng, &[(t, f64::INFINITY), (f64::NEG_INFINITY, t)]);
                }
                tones.push(tone(rng, r::TONES.2, r::TONES.3, r::TONES.4, on_s));
            }
        }
        let mut knocks = Vec::new();
        if chance(rng, r::KNOCKS.0) {
            for _ in 0..rng.random_range(1..=r::KNOCKS.1) {
                knocks.push(Knock {
                    at_s: length_s * rng.random::<f64>(),
                    f_hz: r::KNOCKS.2.draw(rng),
                    zeta: r::KNOCKS.3.draw(rng),
                    peak_db: r::KNOCKS.4.draw(rng),
                });
            }
        }
        Self {
            noise_db: r::NOISE_DB.draw(rng),
            tones,
            mains: chance(rng, r::MAINS.0)
                .then(|| (one_of(rng, &[50.0, 60.0]), r::MAINS.1.draw(rng))),
            knocks,
            jet: chance(rng, r::AIR_JET.0).then(|| {
                let from = length_s * rng.random::<f64>();
                (from, from + r::AIR_JET.1.draw(rng), r::AIR_JET.2.draw(rng))
            }),
            speech: chance(rng, r::SPEECH.0)
                .then(|| (r::SPEECH.1.draw(rng), r::SPEECH.2.draw(rng))),
            neighbour: chance(rng, r::NEIGHBOUR.0).then(|| {
                let from = length_s * (1.4 * rng.random::<f64>() - 0.4);
                tone(
                    rng,
                    r::NEIGHBOUR.1,
                    r::NEIGHBOUR.2,
                    r::NEIGHBOUR.3,
                    (from, f64::INFINITY),
                )
            }),
            seed: rng.random(),
        }
    }

    /// What is there in the first sample, for ever; nothing that is hit, blown or spoken.
    pub(super) fn before(&self) -> Self {
        let on = |tone: &Tone| Tone {
            on_s: (f64::NEG_INFINITY, f64::INFINITY),
            ..*tone
        };
        let is_on = |tone: &&Tone| tone.on_s.0 <= 0.0 && tone.on_s.1 > 0.0;
        Self {
            tones: self.tones.iter().filter(is_on).map(on).collect(),
            knocks: Vec::new(),
            jet: None,
            speech: None,
            neighbour: self.neighbour.as_ref().filter(is_on).map(on),
            ..self.clone()
        }
    }

    /// Fans, pumps and the neighbour's chatter.
    pub(super) fn lines(&self) -> impl Iterator<Item = &Tone> {
        self.tones.iter().chain(&self.neighbour)
    }

    /// Adds everything to a sound of rate `fs_hz` whose cut has the root mean square
    /// `reference`. What lies above half the rate is left out.
    pub(super) fn add_to(&self, sound: &mut [f64], fs_hz: f64, reference: f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let level = |db: f64| reference * 10f64.powf(db / 20.0);
        let white = level(self.noise_db);
        for x in sound.iter_mut() {
            *x += white * normal(&mut rng);
        }
        for tone in self.lines() {
            add_tone(
                sound,
                fs_hz,
                tone,
                level(tone.level_db) * core::f64::consts::SQRT_2,
                &mut rng,
            );
        }
        if let Some((hz, db)) = self.mains {
            for k in 1..=MAINS_MULTIPLES {
                let f_hz = hz * f64::from(k);
                // Even multiples lead (magnetostriction), falling by 6 dB an octave.
                let part = if k % 2 == 0 { 2.0 } else { 0.7 } / f64::from(k);
                let tone = Tone {
                    f_hz,
                    level_db: db,
                    wander: 1e-5,
                    on_s: (f64::NEG_INFINITY, f64::INFINITY),
                };
                add_tone(
                    sound,
                    fs_hz,
                    &tone,
                    part * level(db) * core::f64::consts::SQRT_2,
                    &mut rng,
                );
            }
        }
        for knock in &self.knocks {
            let from = (knock.at_s * fs_hz) as usize;
            let w = TAU * knock.f_hz / fs_hz;
            if w >= 0.9 * core::f64::consts::PI {
                continue;
            }
            for (n, x) in sound.iter_mut().skip(from).enumerate() {
                let fall = (-knock.zeta * w * n as f64).exp();
                if fall < 1e-5 {
                    break;
                }
                *x += level(knock.peak_db) * fall * (w * n as f64).sin();
            }
        }
        if let Some((from, to, db)) = self.jet {
            let gain = level(db);
            for (n, x) in sound.iter_mut().enumerate() {
                if (from..to).contains(&(n as f64 / fs_hz)) {
                    *x += gain * normal(&mut rng);
                }
            }
        }
        if let Some((pitch, db)) = self.speech {
            add_speech(sound, fs_hz, pitch, level(db), &mut rng);
        }
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A tone whose frequency walks: f ← f·(1 + wander·√dt·e), drawn every millisecond.
fn add_tone(sound: &mut [f64], fs_hz: f64, tone: &Tone, amplitude: f64, rng: &mut ChaCha8Rng) {
    let every = ((1e-3 * fs_hz) as usize).max(1);
    let step = tone.wander * (every as f64 / fs_hz).sqrt();
    let mut phase = TAU * rng.random::<f64>();
    let mut off = 0.0;
    for (n, x) in sound.iter_mut().enumerate() {
        if n % every == 0 {
            off += step * normal(rng);
        }
        let f = tone.f_hz * (1.0 + off);
        phase = (phase + TAU * f / fs_hz) % TAU;
        let t = n as f64 / fs_hz;
        if f < 0.45 * fs_hz && t >= tone.on_s.0 && t < tone.on_s.1 {
            *x += amplitude * phase.sin();
        }
    }
}

/// Syllables of 80 to 300 ms: a pitch that glides, its multiples with a formant.
fn add_speech(sound: &mut [f64], fs_hz: f64, pitch_hz: f64, rms: f64, rng: &mut ChaCha8Rng) {
    let mut n = 0;
    while n < sound.len() {
        let length = (Span::even(0.08, 0.3).draw(rng) * fs_hz) as usize;
        let pause = (Span::even(0.02, 0.4).draw(rng) * fs_hz) as usize;
        let (from, to) = (
            pitch_hz * Span::even(0.85, 1.15).draw(rng),
            pitch_hz * Span::even(0.85, 1.15).draw(rng),
        );
        let formant = Span::even(300.0, 1200.0).draw(rng);
        let mut phase = 0.0;
        for k in 0..length.min(sound.len() - n) {
            let u = k as f64 / length as f64;
            let f = from + (to - from) * u;
            phase += TAU * f / fs_hz;
            let shape = (core::f64::consts::PI * u).sin();
            let mut y = 0.0;
            for m in 1..=VOICE_MULTIPLES {
                let g = f * f64::from(m);
                if g < 0.45 * fs_hz {
                    let gain = 1.0 / (1.0 + ((g - formant) / 200.0).powi(2));
                    y += gain * (phase * f64::from(m)).sin();
                }
            }
            sound[n + k] += rms * shape * y;
        }
        n += length + pause;
    }
}
