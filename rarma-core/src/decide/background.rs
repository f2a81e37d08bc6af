//! Tones of the machine itself: what is there at idle and does not grow with the cut.
//!
//! Rate: decision rate. Fans, pumps and drives whine: lines of ζ = 0.02 % that are no
//! multiple of the speed. One that is heard at idle is learnt with its amplitude; during
//! a cut a line at its place is excused as long as it is no louder than
//! [`GROWN`] times that. It is forgotten when idle passes without it.

use crate::real::Real;

/// Tones that are remembered.
const TONES: usize = 8;
/// A tone is known after this long at idle, s.
const KNOWN_S: f64 = 0.3;
/// Idle without it for this long, s, forgets a tone.
const FORGET_S: f64 = 3.0;
/// Memory of a tone's frequency and amplitude, s of idle.
const TONE_TAU_S: f64 = 1.0;
/// A line at the place of a tone that is louder by this factor (6 dB) is not the tone.
pub const GROWN: f64 = 2.0;
/// Half-width of a tone's place, as a part of its frequency; at least
/// [`LEAST_WIDTH_HZ`]. Mains-bound tones wander by 0.1 % with load.
const WIDTH: f64 = 0.003;
/// Half-width of a tone's place at the least, Hz.
const LEAST_WIDTH_HZ: f64 = 2.0;

/// One remembered tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone<T> {
    /// Frequency, Hz.
    pub frequency: T,
    /// Peak amplitude at idle, input units.
    pub amplitude: T,
    heard_s: T,
    missed_s: T,
    heard_now: bool,
}

/// The tones that idle has taught.
#[derive(Debug, Clone)]
pub struct Background<T> {
    tones: [Option<Tone<T>>; TONES],
}

impl<T: Real> Default for Background<T> {
    fn default() -> Self {
        Self {
            tones: [None; TONES],
        }
    }
}

impl<T: Real> Background<T> {
    /// One decision at idle: the lines that are heard now, (f, sd of f, amplitude).
    pub fn learn(&mut self, lines: impl Iterator<Item = (T, T, T)>, period_s: T) {
        for tone in self.tones.iter_mut().flatten() {
            tone.heard_now = false;
        }
        for line in lines {
            self.hear(line, period_s);
        }
        for place in &mut self.tones {
            let Some(tone) = place else { continue };
            if tone.heard_now {
                tone.missed_s = T::ZERO;
            } else {
                tone.missed_s += period_s;
                // Not yet known, it goes as fast as it came.
                let patience = if tone.heard_s >= T::from_f64(KNOWN_S) {
                    T::from_f64(FORGET_S)
                } else {
                    tone.heard_s
                };
                if tone.missed_s > patience {
                    *place = None;
                }
            }
        }
    }

    fn hear(&mut self, (frequency, sd, amplitude): (T, T, T), period_s: T) {
        if !(frequency.is_finite() && amplitude.is_finite()) {
            return;
        }
        if let Some(tone) = self.at(frequency, sd) {
            let spent = (tone.heard_s + period_s).min(T::from_f64(TONE_TAU_S));
            let gain = period_s / spent;
            tone.frequency += gain * (frequency - tone.frequency);
            tone.amplitude += gain * (amplitude - tone.amplitude);
            tone.heard_s = spent;
            tone.heard_now = true;
            return;
        }
        if let Some(place) = self.tones.iter_mut().find(|place| place.is_none()) {
            *place = Some(Tone {
                frequency,
                amplitude,
                heard_s: period_s,
                missed_s: T::ZERO,
                heard_now: true,
            });
        }
    }

    /// A line of the cut is one of the tones, and no louder.
    pub fn explains(&self, frequency: T, sd: T, amplitude: T) -> bool {
        self.tones.iter().flatten().any(|tone| {
            tone.heard_s >= T::from_f64(KNOWN_S)
                && is_at(tone, frequency, sd)
                && amplitude < tone.amplitude * T::from_f64(GROWN)
        })
    }

    /// The tones that are known, for display.
    pub fn known(&self) -> impl Iterator<Item = &Tone<T>> {
        self.tones
            .iter()
            .flatten()
            .filter(|tone| tone.heard_s >= T::from_f64(KNOWN_S))
    }

    fn at(&mut self, frequency: T, sd: T) -> Option<&mut Tone<T>> {
        self.tones
            .iter_mut()
            .flatten()
            .find(|tone| is_at(tone, frequency, sd))
    }
}

fn is_at<T: Real>(tone: &Tone<T>, frequency: T, sd: T) -> bool {
    let width = (tone.frequency * T::from_f64(WIDTH)).max(T::from_f64(LEAST_WIDTH_HZ));
    // A wild deviation is no reason to find a tone everywhere.
    let spread = (sd * T::from_f64(2.0)).min(width);
    (frequency - tone.frequency).abs() < width.max(spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;

    fn idle(background: &mut Background<f64>, line: Option<(f64, f64, f64)>, seconds: f64) {
        for _ in 0..(seconds / PERIOD_S) as usize {
            background.learn(line.into_iter(), PERIOD_S);
        }
    }

    #[test]
    fn what_is_there_at_idle_is_excused_until_it_grows_or_goes() {
        let mut background = Background::default();
        idle(&mut background, Some((1398.0, 0.2, 0.5)), 0.2);
        assert!(!background.explains(1398.0, 0.2, 0.5), "too short to know");
        idle(&mut background, Some((1398.0, 0.2, 0.5)), 2.0);
        assert!(background.explains(1399.4, 0.2, 0.6));
        assert!(!background.explains(1398.0, 0.2, 1.5), "it has grown");
        assert!(!background.explains(1405.0, 0.2, 0.5), "another place");
        assert!(!background.explains(1405.0, 500.0, 0.5), "whatever the sd");
        assert_eq!(background.known().count(), 1);
        idle(&mut background, None, 2.5);
        assert!(background.explains(1398.0, 0.2, 0.5), "a pause");
        idle(&mut background, None, 1.0);
        assert!(!background.explains(1398.0, 0.2, 0.5), "gone");
    }

    #[test]
    fn noise_that_wanders_leaves_no_tones_and_no_room_is_no_harm() {
        let mut background = Background::default();
        for n in 0..5000 {
            let wild = 300.0 + f64::from(n * 7919 % 2000);
            background.learn([(wild, 0.2, 0.1)].into_iter(), PERIOD_S);
        }
        assert_eq!(background.known().count(), 0);
        for n in 0..20 {
            let f = 300.0 + 50.0 * f64::from(n);
            idle(&mut background, Some((f, 0.2, 0.1)), 0.5);
        }
        let known = background.known().count();
        assert!((5..=8).contains(&known), "{known}");
        background.learn([(f64::NAN, 0.2, f64::NAN)].into_iter(), PERIOD_S);
        assert!(!background.explains(f64::NAN, 0.2, 0.1));
    }
}
