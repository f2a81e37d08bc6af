//! Whether the rotation has been turned: all its lines move by the same part, and nobody has told.
//!
//! By how much, its strongest line would say, if one knew which of those that are heard now it has become; and that one may as
//! well be chatter near a multiple, which wanders by itself. Its other lines say: where they were there is nothing any more, and
//! where they would have gone there is a line. Where they bear it out the belief holds both to be possible, and the votes of
//! the next windows choose.

use super::Verdict;
use super::belief::{LINE_SD, SPAN};
use super::lines::CANDIDATES;
use super::tracks::TRACKS;
use crate::real::Real;

/// It is asked once a line would have moved by so many deviations of its frequency: sooner it is noise that answers. Half and
/// double of these numbers: decision 67.
const MOVED: f64 = 2.5;
/// The others went with the strongest line where they say so by 33 to 1.
const TURNED: f64 = 3.5;
/// What one line can say at the most, natural logarithm: it takes two that are surely forced.
const MOST: f64 = 3.0;

/// Where a line of the rotation was.
#[derive(Debug, Clone, Copy, Default)]
struct Place<T> {
    hz: T,
    /// Chance that the rotation made it.
    forced: T,
    /// Square of the deviations from there to the nearest line that is heard now.
    stayed: T,
}

impl<T: Real> Verdict<T> {
    /// Takes a movement of the rotation's lines for a turn that may have been, where they bear it out.
    pub(super) fn turn(&mut self) {
        // What grows or fades is no rotation that is turned.
        let is_steady = self.is_told && !self.comb.is_settling();
        if !(is_steady && self.comb.is_as_loud(self.frame.total)) {
            self.tracks.anchor();
            return;
        }
        if let Some(ratio) = self.turned_by() {
            self.belief.may_have_turned(ratio.ln());
            self.tracks.turn(ratio);
        }
    }

    /// The ratio of the speeds, now over before, that the other lines bear out best; none where they bear out none.
    fn turned_by(&self) -> Option<T> {
        let sd_hz = T::from_f64(LINE_SD) * self.resolution_hz;
        let mut places = [Place::default(); TRACKS];
        let (mut strongest, mut highest) = ((T::ZERO, 0), T::ZERO);
        for (k, (place, track)) in places.iter_mut().zip(self.tracks.known()).enumerate() {
            (place.hz, place.forced) = (track.from_hz, track.was_forced());
            highest = highest.max(place.hz * place.forced);
            let power = track.power * place.forced;
            if power > strongest.0 {
                strongest = (power, k);
            }
        }
        // It has no word about itself.
        let first = places.get_mut(strongest.1)?;
        let from_hz = first.hz;
        first.forced = T::ZERO;
        let mut most = T::ZERO;
        for place in places.iter_mut().filter(|place| place.forced > T::ZERO) {
            place.stayed = self.nearest(place.hz, sd_hz);
            most += Self::says(place, T::ZERO);
        }
        let mut best = (T::from_f64(TURNED), None);
        if most < best.0 {
            return None;
        }
        for line in self.lines.candidates().iter().take(CANDIDATES) {
            let ratio = line.f_hz / from_hz;
            let moved = highest * (ratio - T::ONE).abs();
            if moved < T::from_f64(MOVED) * sd_hz || ratio.ln().abs() > T::from_f64(SPAN) {
                continue;
            }
            let mut word = T::ZERO;
            for place in places.iter().filter(|place| place.forced > T::ZERO) {
                word += Self::says(place, self.nearest(place.hz * ratio, sd_hz));
            }
            if word > best.0 {
                best = (word, Some(ratio));
            }
        }
        best.1
    }

    /// Log-odds that a line has gone from one frequency to another, each measured with that deviation; `went` is the square of
    /// the deviations from the other to the nearest line.
    fn says(place: &Place<T>, went: T) -> T {
        T::from_f64(0.25) * place.forced * (place.stayed - went)
    }

    /// Square of the deviations to the nearest line, as far as it counts.
    fn nearest(&self, hz: T, sd_hz: T) -> T {
        let most = T::from_f64(4.0 * MOST);
        let lines = self.lines.candidates().iter();
        let off_hz = lines.fold(most * sd_hz, |least, line| {
            least.min((line.f_hz - hz).abs())
        });
        let off = off_hz / sd_hz;
        (off * off).min(most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::{HOP_S, Listening, VerdictConfig};
    use core::f64::consts::TAU;

    const FS: f64 = 6000.0;

    /// The speed that is believed, turns a second, every 0.05 s of the last four: five multiples of three teeth at 60 turns a
    /// second, the third four times as strong as the first. `turned` and `wanders` are by which part the rotation and the
    /// third multiple have moved at a time.
    fn believed(turned: impl Fn(f64) -> f64, wanders: impl Fn(f64) -> f64) -> Vec<f64> {
        let listening = Listening {
            fs_hz: FS,
            spindle_hz: Some(60.0),
            teeth: Some(3),
            folding_hz: None,
        };
        let mut verdict =
            Verdict::<f32>::new(&VerdictConfig::default(), &listening).expect("in range");
        let (mut state, mut phase, mut third) = (5_u32, 0.0, 0.0);
        let mut speeds = Vec::new();
        for n in 0..36_000 {
            let t = f64::from(n) / FS;
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state >> 8) / 8_388_608.0 - 1.0;
            phase += TAU * 180.0 * (1.0 + turned(t)) / FS;
            third += TAU * 540.0 * (1.0 + turned(t) + wanders(t)) / FS;
            let teeth: f64 = [1.0, 2.0, 4.0, 5.0]
                .map(|k| (k * phase).sin() / k)
                .iter()
                .sum();
            let cut = if t < 1.0 {
                0.0
            } else {
                teeth + 4.0 * third.sin() + 0.05 * noise
            };
            let judgement = verdict.process((cut + 0.01 * noise) as f32);
            if let Some((hz, _)) = judgement.and_then(|now| now.spindle_hz).filter(|_| t > 2.0) {
                speeds.push(f64::from(hz));
            }
        }
        speeds
    }

    #[test]
    fn a_speed_that_is_turned_in_steps_is_followed_within_a_window() {
        for part in [0.01, -0.01] {
            // A step begins every 0.8 s and takes 0.2 s.
            let turned = |t: f64| {
                let steps = (t - 3.0).max(0.0) / 0.8;
                part * (steps.floor() + (4.0 * steps.fract()).min(1.0))
            };
            let speeds = believed(turned, |_| 0.0);
            for (n, hz) in speeds.iter().enumerate() {
                let t = 2.0 + 0.05 * n as f64;
                let off = |t: f64| (hz / (60.0 * (1.0 + turned(t))) - 1.0).abs();
                // A window of 0.25 s, and what has been heard of it.
                let nearest = (0..8).map(|k| off(t - 0.05 * f64::from(k)));
                let nearest = nearest.fold(f64::INFINITY, f64::min);
                assert!(nearest < 0.004, "{part}: {hz} at {t}");
            }
        }
    }

    #[test]
    fn a_speed_that_is_turned_far_is_found_again_by_all_lines() {
        // The overtones pass more than a line's breadth between two windows: none of them is followed.
        for part in [0.012, -0.012, 0.05, -0.05, 0.13, -0.13] {
            let turned = |t: f64| part * ((t - 3.0) / 0.2).clamp(0.0, 1.0);
            let speeds = believed(turned, |_| 0.0);
            // From 0.8 s after it has come to rest.
            for (n, hz) in speeds.iter().enumerate().skip((2.0 / HOP_S) as usize) {
                let off = hz / (60.0 * (1.0 + part)) - 1.0;
                assert!(
                    off.abs() < 0.003,
                    "{part}: {hz} at {}",
                    2.0 + 0.05 * n as f64
                );
            }
        }
    }

    #[test]
    fn a_line_that_wanders_on_a_multiple_does_not_take_the_speed_along() {
        for part in [0.004, 0.01] {
            let speeds = believed(|_| 0.0, |t| part * (TAU * 0.7 * (t - 2.0).max(0.0)).sin());
            assert!(speeds.len() > 70);
            for hz in speeds {
                assert!((hz / 60.0 - 1.0).abs() < 0.003, "{part}: {hz}");
            }
        }
    }
}
