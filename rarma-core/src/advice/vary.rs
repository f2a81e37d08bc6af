//! A speed that swings, where no speed is stable: how far, how fast, and whether it helps.

use super::config::AdviceError;
use super::envelope::{Cutting, Swing, growth};
use super::heard::HeardChatter;
use super::swung::{Case, cases};
use crate::decide::Structure;
use crate::real::Real;

/// Usual [`VariationConfig::most_amplitude`].
const MOST_AMPLITUDE: f64 = 0.2;
/// Usual [`VariationConfig::most_acceleration`].
const MOST_ACCELERATION: f64 = 300.0;
/// Usual [`VariationConfig::most_hz`].
const MOST_HZ: f64 = 4.0;
/// Amplitudes that are tried, parts of the largest.
const AMPLITUDES: [f64; 2] = [1.0, 0.5];
/// Frequencies that are tried, parts of the quickest that is allowed.
const FREQUENCIES: [f64; 2] = [1.0, 0.25];
/// Swings a tooth at most: what is quicker averages itself out between two teeth. At 0.23 a
/// lathe of 92 waves loses a tenth of what a slow swing gives, at 0.47 all of it.
const QUICKEST: f64 = 0.25;
/// Chance from which on a swing is said to help: more likely than not.
const HELPS: f64 = 0.5;
/// Part of the swings that every case has stable which are so, with a structure and without, of
/// one edge; and of several, where other modes meet their lobes as the speed swings. Set on the cuts
/// that the belief names.
const SEEN_ONE: [f64; 2] = [0.95, 0.85];
/// See [`SEEN_ONE`].
const SEEN_SEVERAL: [f64; 2] = [0.55, 0.5];

/// What a spindle's drive can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VariationConfig<T> {
    /// Largest ratio of the amplitude of the speed to its mean (RVA), 0.01 to 0.5, usually 0.2:
    /// what trials in the literature swing at most; the feed of a tooth and the power swing
    /// with it.
    pub most_amplitude: T,
    /// Largest angular acceleration of the spindle, rad/s², > 0, usually 300: a lathe that runs
    /// up to 4000 1/min in a second and a half, a mill to 10 000 in three and a half. A spindle's
    /// own is 2π/60 times its largest speed, 1/min, over its time to run up, s.
    pub most_acceleration: T,
    /// Quickest swing, Hz, > 0, usually 4: a drive follows its speed command some ten times
    /// faster than that.
    pub most_hz: T,
}

impl<T: Real> Default for VariationConfig<T> {
    fn default() -> Self {
        Self {
            most_amplitude: T::from_f64(MOST_AMPLITUDE),
            most_acceleration: T::from_f64(MOST_ACCELERATION),
            most_hz: T::from_f64(MOST_HZ),
        }
    }
}

impl<T: Real> VariationConfig<T> {
    /// # Errors
    /// [`AdviceError::Variation`] where a field is out of range.
    pub fn validate(&self) -> Result<(), AdviceError> {
        let positive = |x: T| x > T::ZERO && x.is_finite();
        let amplitude = self.most_amplitude >= T::from_f64(0.0099)
            && self.most_amplitude <= T::from_f64(0.5001);
        if amplitude && positive(self.most_acceleration) && positive(self.most_hz) {
            Ok(())
        } else {
            Err(AdviceError::Variation)
        }
    }
}

/// A swing of the speed, n(t) = n₀·(1 + RVA·sin(2π·RVF·n₀·t)), and what is expected of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variation<T> {
    /// RVA, the amplitude of the speed over its mean.
    pub amplitude: T,
    /// Swings a second, Hz.
    pub swing_hz: T,
    /// RVF, swings a turn.
    pub frequency_ratio: T,
    /// Largest angular acceleration, rad/s².
    pub acceleration: T,
    /// How far the phase of the chatter's wave between two teeth swings to either side, rad:
    /// 2π·w·RVA·sinc(π·RVF/N).
    pub phase_swing: T,
    /// Chance that the cut is stable with it, 0 to 1.
    pub chance: T,
    /// Growth of the chatter with it over that without, mean of the belief: below 0 it dies.
    pub growth_ratio: T,
}

impl<T: Real> Variation<T> {
    /// Whether it is likely to make the cut stable.
    pub fn helps(&self) -> bool {
        self.chance >= T::from_f64(HELPS)
    }
}

/// The swing of the speed, within what the drive can do, that makes the cut likeliest stable
/// at its present mean speed.
///
/// Each case of the belief (dampings and depths that fit what was heard) is played with each of
/// four swings: all or half of the largest amplitude, and all or a quarter of the quickest frequency
/// that the acceleration leaves it. The chance is the part of the belief whose chatter dies; of two alike
/// that goes first in which it dies quicker.
///
/// # Errors
/// What is out of range in `config` or `heard`.
///
/// ```
/// use rarma_core::advice::{HeardChatter, VariationConfig, vary};
/// // A lathe at 1500 1/min: 40.7 waves in a turn.
/// let heard = HeardChatter { f_hz: 1017.0, f_sd_hz: 1.0, spindle_hz: 25.0, spindle_sd_hz: 0.03, teeth: 1 };
/// let swing = vary(&VariationConfig::default(), &heard, None).unwrap();
/// assert!(swing.helps() && swing.phase_swing > 10.0);
/// // Hardly two between the teeth of a quick mill: a swing does not help.
/// let quick = HeardChatter { spindle_hz: 300.0, teeth: 2, ..heard };
/// assert!(!vary(&VariationConfig::default(), &quick, None).unwrap().helps());
/// ```
pub fn vary<T: Real>(
    config: &VariationConfig<T>,
    heard: &HeardChatter<T>,
    structure: Option<&Structure<T>>,
) -> Result<Variation<T>, AdviceError> {
    config.validate()?;
    heard.validate()?;
    let (cases, of_structure) = cases(heard, structure);
    let [told, untold] = if heard.teeth > 1 {
        SEEN_SEVERAL
    } else {
        SEEN_ONE
    };
    let seen = T::from_f64(if of_structure { told } else { untold });
    let mut best: Option<(Variation<T>, T)> = None;
    for amplitude in AMPLITUDES.map(|part| config.most_amplitude * T::from_f64(part)) {
        for part in FREQUENCIES.map(T::from_f64) {
            let most = quickest(config, heard.spindle_hz, heard.teeth, amplitude);
            let mut one = swing(heard, amplitude, most * part);
            let (chance, ratio) = judged(heard, &cases, &one);
            one.chance = chance * seen;
            one.growth_ratio = ratio;
            let score = chance - ratio * T::from_f64(0.01);
            if best.as_ref().is_none_or(|(_, most)| score > *most) {
                best = Some((one, score));
            }
        }
    }
    best.map(|(one, _)| one).ok_or(AdviceError::Variation)
}

/// The quickest swing of an amplitude, Hz: 2π·n₀·RVA·2π·f ≤ the acceleration.
fn quickest<T: Real>(config: &VariationConfig<T>, spindle_hz: T, teeth: u32, amplitude: T) -> T {
    let two_pi = T::PI * T::from_f64(2.0);
    let bound = config.most_acceleration / (two_pi * two_pi * spindle_hz * amplitude);
    let teeth = T::from_u32(teeth) * spindle_hz * T::from_f64(QUICKEST);
    bound.min(config.most_hz).min(teeth)
}

fn swing<T: Real>(heard: &HeardChatter<T>, amplitude: T, swing_hz: T) -> Variation<T> {
    let two_pi = T::PI * T::from_f64(2.0);
    let frequency_ratio = swing_hz / heard.spindle_hz;
    let x = T::PI * frequency_ratio / T::from_u32(heard.teeth);
    let (sin, _) = x.sin_cos();
    Variation {
        amplitude,
        swing_hz,
        frequency_ratio,
        acceleration: two_pi * heard.spindle_hz * amplitude * two_pi * swing_hz,
        phase_swing: two_pi * heard.waves() * amplitude * (sin / x).abs(),
        chance: T::ZERO,
        growth_ratio: T::ONE,
    }
}

/// Part of the cases that are stable with a swing, and their growth over that without.
fn judged<T: Real>(
    heard: &HeardChatter<T>,
    cases: &[Option<Case<T>>],
    swing: &Variation<T>,
) -> (T, T) {
    let teeth = T::from_u32(heard.teeth);
    let (mut stable, mut with, mut without) = (T::ZERO, T::ZERO, T::ZERO);
    let mut count = T::ZERO;
    for case in cases.iter().flatten() {
        count += T::ONE;
        let cut = Cutting {
            natural_hz: case.natural_hz,
            zeta: case.zeta,
            load: case.load,
            side: case.side,
            tooth_hz: heard.spindle_hz * teeth,
        };
        let swing = Swing {
            amplitude: swing.amplitude,
            per_tooth: swing.frequency_ratio / teeth,
        };
        let grows = growth(&cut, &swing);
        if grows < T::ZERO {
            stable += T::ONE;
        }
        with += grows / case.zeta;
        without += case.growth / case.zeta;
    }
    let count = count.max(T::ONE);
    (stable / count, with / without.max(T::from_f64(0.1) * count))
}
