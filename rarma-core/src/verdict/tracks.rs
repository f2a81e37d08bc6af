//! A line followed from window to window: what made it does not change from one to the next.

use super::belief::sigmoid;
use super::frame::HOP_S;
use super::lines::{CANDIDATES, SpectrumLine};
use crate::real::Real;
use crate::visit::state;

pub(super) const TRACKS: usize = 3 * CANDIDATES;
/// A line is the one of the window before if it is this near, in units of the resolution.
const SAME: f64 = 1.2;
/// A line that is missing in more windows than this is another one when it comes back.
const MISSING: u8 = 3;
/// Where a line was is known for so many windows: a turn of the rotation takes a window of five to be seen. Half and double:
/// decision 67.
const KNOWN: u8 = 8;
/// The log-odds of being forced are averaged over this time, s.
const MEMORY_S: f64 = 1.0;
/// The same for a line that is called: loud chatter drowns the lines that tell of the speed, and
/// the belief drifts. With 2 s the alarms of `labels.json` cover 0.66 to 0.70 of the chatter, with 4
/// and more 0.70 to 0.72, with 1 s 0.64 to 0.68; false alarms are the same.
const CALLED_MEMORY_S: f64 = 4.0;
/// The slope is averaged over this time, s.
const SLOPE_S: f64 = 0.3;
/// Gain of the features that tell a suspect, a window.
const SUSPECT_GAIN: f64 = 0.25;
/// A suspect is one that holds half of the rest, is free, and stands 15 dB over idle; these
/// are the log-odds and decibels at which each is as likely as not.
const SUSPECT: [f64; 3] = [-0.5, 1.0, 1.5];
const FREE_WEIGHT: f64 = 0.8;

/// One line over time.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Track<T> {
    pub(super) f_hz: T,
    pub(super) age_s: T,
    missing: u8,
    seen: bool,
    in_use: bool,
    windows: T,
    /// Change of the frequency, a part of it a second.
    pub(super) slope: T,
    forced: T,
    features: Option<[T; 3]>,
    /// Chance that it is chatter, for the speed's sake: a suspect does not tell it.
    pub(super) suspect: T,
    /// Sum of the evidence.
    pub(super) evidence: T,
    /// Frequency from which its movement counts, Hz.
    pub(super) from_hz: T,
    /// Power when it was last seen.
    pub(super) power: T,
}

state! { Track<T> {
    f_hz, age_s, missing, seen, in_use, windows, slope, forced, features, suspect, evidence, from_hz,
    power
} }

impl<T: Real> Track<T> {
    /// The log-odds that the rotation makes it, averaged.
    pub(super) fn forced(&mut self, odds: T, is_called: bool) -> T {
        self.windows += T::ONE;
        let memory_s = if is_called { CALLED_MEMORY_S } else { MEMORY_S };
        let gain = (T::ONE / self.windows).max(T::from_f64(HOP_S / memory_s));
        self.forced += gain * (odds - self.forced);
        self.forced
    }

    /// Chance that the rotation makes it, by what was known before this window.
    pub(super) fn was_forced(&self) -> T {
        if self.windows > T::ZERO {
            sigmoid(self.forced)
        } else {
            T::ZERO
        }
    }

    /// It is followed still.
    fn is_there(&self) -> bool {
        self.in_use && self.missing <= MISSING
    }

    /// Features of this window: log-odds of its part of the rest, of being free, and level
    /// over idle in units of 10 dB.
    pub(super) fn suspect(&mut self, now: [T; 3]) {
        let gain = T::from_f64(SUSPECT_GAIN);
        let mut features = self.features.unwrap_or(now);
        for (feature, now) in features.iter_mut().zip(now) {
            *feature += gain * (now - *feature);
        }
        self.features = Some(features);
        let over = |i: usize| features[i] - T::from_f64(SUSPECT[i]);
        self.suspect = sigmoid(over(0) + T::from_f64(FREE_WEIGHT) * over(1) + over(2));
    }
}

/// All lines that are followed.
#[derive(Debug, Clone)]
pub(super) struct Tracks<T> {
    tracks: [Track<T>; TRACKS],
    /// The track of each candidate.
    of: [usize; CANDIDATES],
}

state! { Tracks<T> {
    tracks, of;
    where of.iter().all(|track| *track < TRACKS)
} }

impl<T: Real> Tracks<T> {
    /// None.
    pub(super) const BLANK: Self = Self {
        tracks: [Track {
            f_hz: T::ZERO,
            age_s: T::ZERO,
            missing: 0,
            seen: false,
            in_use: false,
            windows: T::ZERO,
            slope: T::ZERO,
            forced: T::ZERO,
            features: None,
            suspect: T::ZERO,
            evidence: T::ZERO,
            from_hz: T::ZERO,
            power: T::ZERO,
        }; TRACKS],
        of: [0; CANDIDATES],
    };

    /// Finds the track of each candidate, or begins one; forgets those that have gone.
    pub(super) fn follow(&mut self, candidates: &[SpectrumLine<T>], resolution_hz: T, doubt: T) {
        for track in &mut self.tracks {
            track.seen = false;
        }
        let reach = resolution_hz * T::from_f64(SAME);
        for (line, of) in candidates.iter().zip(&mut self.of) {
            let mut best: Option<(usize, T)> = None;
            for (k, track) in self.tracks.iter().enumerate() {
                let apart = (track.f_hz - line.f_hz).abs();
                let may_be = track.is_there() && !track.seen && apart < reach;
                if may_be && best.is_none_or(|(_, nearest)| apart < nearest) {
                    best = Some((k, apart));
                }
            }
            let k = match best {
                Some((k, _)) => k,
                None => {
                    let k = Self::place(&self.tracks);
                    if let Some(track) = self.tracks.get_mut(k) {
                        *track = Track {
                            in_use: true,
                            evidence: doubt,
                            from_hz: line.f_hz,
                            ..Track::default()
                        };
                    }
                    k
                }
            };
            let Some(track) = self.tracks.get_mut(k) else {
                continue;
            };
            track.seen = true;
            track.missing = 0;
            if track.f_hz > T::ZERO {
                let now = (line.f_hz / track.f_hz - T::ONE) / T::from_f64(HOP_S);
                track.slope += T::from_f64(HOP_S / SLOPE_S) * (now - track.slope);
            }
            track.f_hz = line.f_hz;
            track.power = line.power;
            track.age_s += T::from_f64(HOP_S);
            *of = k;
        }
        for track in self.tracks.iter_mut().filter(|track| !track.seen) {
            track.missing = track.missing.saturating_add(1);
            if track.missing > KNOWN {
                track.in_use = false;
            }
        }
    }

    /// Room for a line: of none, or of the one that is missing for longest. There are three times as many as can be seen at
    /// once.
    fn place(tracks: &[Track<T>]) -> usize {
        let unused = tracks.iter().position(|track| !track.in_use);
        let unseen = tracks.iter().enumerate().filter(|(_, track)| !track.seen);
        let longest = unseen.max_by_key(|(_, track)| track.missing);
        unused.or(longest.map(|(k, _)| k)).unwrap_or(0)
    }

    /// Movement counts from here on; what is not there any more is forgotten.
    pub(super) fn anchor(&mut self) {
        for track in &mut self.tracks {
            track.from_hz = track.f_hz;
            track.in_use = track.is_there();
        }
    }

    /// The rotation has been turned by this ratio, and what of it was not seen, too.
    pub(super) fn turn(&mut self, ratio: T) {
        for track in &mut self.tracks {
            track.from_hz = if track.seen {
                track.f_hz
            } else {
                track.from_hz * ratio
            };
        }
    }

    /// All that are there, or were a moment ago.
    pub(super) fn known(&self) -> impl Iterator<Item = &Track<T>> {
        self.tracks.iter().filter(|track| track.in_use)
    }

    /// The track of a candidate.
    pub(super) fn of(&mut self, candidate: usize) -> &mut Track<T> {
        let k = self.of[candidate.min(CANDIDATES - 1)];
        &mut self.tracks[k.min(TRACKS - 1)]
    }

    /// What made the lines is asked anew; their evidence stays.
    pub(super) fn forget_origin(&mut self) {
        for track in &mut self.tracks {
            track.windows = T::ZERO;
            track.suspect = T::ZERO;
            track.features = None;
        }
    }

    /// Those that are suspected of being chatter.
    pub(super) fn suspects(&self) -> impl Iterator<Item = &Track<T>> {
        let half = T::from_f64(0.5);
        self.tracks
            .iter()
            .filter(move |track| track.is_there() && track.suspect > half)
    }
}
