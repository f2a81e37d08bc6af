//! Whether the rotation has been turned: all its lines move by the same part, and nobody has told.
//!
//! By how much, its strongest line says; that line may as well be chatter near a multiple, which wanders by itself. Its
//! other lines say whether they went with it. Where they do the belief holds both to be possible, and the votes of the
//! next windows choose.

use super::Verdict;
use super::belief::LINE_SD;
use super::lines::CANDIDATES;
use crate::real::Real;

/// It is asked once a line would have moved by so many deviations of its frequency: sooner it is noise that answers. Half and
/// double of these numbers: decision 67.
const MOVED: f64 = 2.5;
/// The others went with the strongest line where they say so by 20 to 1.
const TURNED: f64 = 3.0;
/// What one line can say at the most, natural logarithm: it takes two that are surely forced.
const MOST: f64 = 3.0;

impl<T: Real> Verdict<T> {
    /// Takes the movement of the strongest line of the rotation for a turn that may have been, where the others moved as it did.
    pub(super) fn turn(&mut self) {
        // What grows or fades is no rotation that is turned.
        let is_steady = self.is_told && !self.comb.is_settling();
        if !(is_steady && self.comb.is_as_loud(self.frame.total)) {
            self.tracks.anchor();
            return;
        }
        let (mut first, mut most, mut r) = (0, T::ZERO, T::ZERO);
        let lines = self.lines.candidates();
        for (k, line) in lines.iter().enumerate().take(CANDIDATES) {
            let track = self.tracks.of(k);
            let forced = line.power * track.was_forced();
            if forced > most {
                (first, most, r) = (k, forced, track.moved());
            }
        }
        let sd_hz = T::from_f64(LINE_SD) * self.resolution_hz;
        let limit = T::from_f64(MOST);
        let (mut word, mut moved) = (T::ZERO, T::ZERO);
        for (k, line) in lines.iter().enumerate().take(CANDIDATES) {
            let track = self.tracks.of(k);
            let forced = track.was_forced();
            moved = moved.max(forced * (r * line.f_hz / sd_hz).abs());
            // Log-odds of two measured frequencies, each with that deviation.
            let stayed = track.moved() * line.f_hz / sd_hz;
            let went = (track.moved() - r) * line.f_hz / sd_hz;
            let says = T::from_f64(0.25) * (stayed * stayed - went * went);
            if k != first {
                word += forced * says.clamp(-limit, limit);
            }
        }
        if moved > T::from_f64(MOVED) && word > T::from_f64(TURNED) {
            self.belief.may_have_turned(r);
            self.tracks.anchor();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::{Listening, VerdictConfig};
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
