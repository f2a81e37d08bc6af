//! The work on one window, slice by slice: its spectrum and lines, what they tell of the speed, which
//! of them the rotation makes, how steady they are, and the judgement.

use super::Verdict;
use super::belief::{Belief, Desk, sigmoid};
use super::frame::{HOP_S, decibel};
use super::lines::{CANDIDATES, LINES};
use crate::real::Real;
use crate::visit::{State, StateVisitor};

/// Bins looked at for peaks in a slice.
pub(super) const SCANNED: usize = 16;
/// A line votes for the speed in so far as it stands so many decibels over idle, and the
/// width of the step; half where idle is not known.
const VOTES: (f64, f64) = (6.0, 1.5);
/// A line so many decibels below the strongest tells half as much of the speed, and the width
/// of the step: where there is one strong line, peaks of the noise would tell all of it.
const CLEAR: (f64, f64) = (45.0, 5.0);
/// ln(S + 0.01) of a line whose power does not fluctuate at all.
const QUITE_STEADY: f64 = -4.6;
/// Smoothing of the quietest level, s, and forgetting of the loudest in a window.
const LEVEL_S: f64 = 0.3;
const LOUDEST: f64 = 0.999;
/// The loudest rises by no more than this from one window to the next (2 dB, 40 dB a second): a cut lasts, a door or a clamp that
/// is hit is heard for a few windows. Half and double: decision 67.
const RISE: f64 = 1.58;

/// Which slice of the work is next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    Wait,
    Spectrum,
    Scan(usize),
    Pick,
    Turn,
    Hear(usize),
    Settle,
    Forced(usize),
    Steady(usize),
    Judge,
}

impl Stage {
    /// As two numbers: which, and where in it.
    fn numbers(self) -> (u8, usize) {
        match self {
            Self::Wait => (0, 0),
            Self::Spectrum => (1, 0),
            Self::Scan(bin) => (2, bin),
            Self::Pick => (3, 0),
            Self::Turn => (4, 0),
            Self::Hear(k) => (5, k),
            Self::Settle => (6, 0),
            Self::Forced(k) => (7, k),
            Self::Steady(k) => (8, k),
            Self::Judge => (9, 0),
        }
    }

    /// What it looks at is there; `bins` are those of the band.
    pub(super) fn is_within(self, bins: (usize, usize)) -> bool {
        match self {
            Self::Scan(bin) => bin >= bins.0 && bin <= bins.1,
            Self::Hear(k) => k <= LINES,
            Self::Forced(k) | Self::Steady(k) => k <= CANDIDATES,
            _ => true,
        }
    }
}

impl<T: Real> State<T> for Stage {
    fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) -> bool {
        let mut numbers = self.numbers();
        if !State::<T>::visit_state(&mut numbers, visitor) {
            return false;
        }
        let at = numbers.1;
        let all = [
            Self::Wait,
            Self::Spectrum,
            Self::Scan(at),
            Self::Pick,
            Self::Turn,
            Self::Hear(at),
            Self::Settle,
            Self::Forced(at),
            Self::Steady(at),
            Self::Judge,
        ];
        let there = all.iter().find(|stage| stage.numbers() == numbers);
        *self = there.copied().unwrap_or(Self::Wait);
        there.is_some()
    }
}

impl<T: Real> Verdict<T> {
    /// So many slices of the spectrum; how many are left over for its lines once it is ready.
    #[inline(always)]
    pub(super) fn work_on_spectrum(&mut self, slices: usize) -> Option<usize> {
        let left = self.frame.work(slices)?;
        self.note_level();
        self.lines.begin();
        self.stage = Stage::Scan(self.frame.bins.0);
        Some(left)
    }

    /// One slice behind the spectrum; the next one.
    #[inline(always)]
    pub(super) fn work(&mut self) -> Stage {
        match self.stage {
            Stage::Wait | Stage::Spectrum => self.stage,
            Stage::Scan(bin) => {
                let turn_hz = self.belief().map(Belief::turn_hz);
                self.lines.scan(&self.frame, bin, bin + SCANNED, turn_hz);
                if bin + SCANNED < self.frame.bins.1 {
                    Stage::Scan(bin + SCANNED)
                } else {
                    Stage::Pick
                }
            }
            Stage::Pick => {
                self.lines.pick(&self.frame);
                let candidates = self.lines.candidates();
                self.tracks
                    .follow(candidates, self.resolution_hz, self.weigher.doubt());
                Stage::Turn
            }
            Stage::Turn => {
                self.turn();
                self.weigh_votes();
                Stage::Hear(0)
            }
            Stage::Hear(k) => self.hear(k),
            Stage::Settle => {
                if self.is_told {
                    if self.comb.is_settling() {
                        self.belief.go_along();
                    }
                    self.belief.settle(&mut Desk(self.frame.desk()));
                }
                Stage::Forced(0)
            }
            Stage::Forced(k) => self.blame_rotation(k),
            Stage::Steady(k) => self.watch_steadiness(k),
            Stage::Judge => {
                self.judge();
                Stage::Wait
            }
        }
    }

    fn note_level(&mut self) {
        let level = self.frame.total;
        if self.smooth == T::ZERO {
            self.smooth = level;
            self.loudest = level;
        }
        let reached = level.min(self.loudest * T::from_f64(RISE));
        self.loudest = (self.loudest * T::from_f64(LOUDEST)).max(reached);
        self.smooth += T::from_f64(HOP_S / LEVEL_S) * (level - self.smooth);
        self.quietest = if self.frame.learns_idle() {
            self.quietest.min(self.smooth)
        } else {
            self.smooth
        };
    }

    /// How much each line's word for the speed weighs: a line of the background has none, and
    /// a suspect, its sidebands and its double have none.
    fn weigh_votes(&mut self) {
        if !self.is_told {
            return;
        }
        let belief = &mut self.belief;
        let (turn, teeth) = (belief.turn_hz(), belief.teeth());
        let two = T::from_f64(2.0);
        let candidates = self.lines.candidates().len();
        let mut sum = T::ZERO;
        let strongest = self
            .lines
            .all()
            .iter()
            .fold(T::ZERO, |most, line| most.max(line.power));
        for (k, (line, weight)) in self.lines.all().iter().zip(&mut self.weights).enumerate() {
            let mut suspect = T::ZERO;
            for track in self.tracks.suspects() {
                let sideband = ((line.f_hz - track.f_hz) / turn).round();
                let beside = (line.f_hz - track.f_hz - sideband * turn).abs() < self.resolution_hz;
                let double = (line.f_hz - two * track.f_hz).abs() < two * self.resolution_hz;
                if (beside && sideband.abs() <= two * teeth) || double {
                    suspect = suspect.max(track.suspect);
                }
            }
            if self.comb.is_settling() {
                // Every line of the new comb is a suspect at first.
                suspect = T::ZERO;
            }
            let over = self.frame.over_idle_db(line.bin, line.power);
            let heard = over.map_or(T::from_f64(0.5), |db| {
                sigmoid((db - T::from_f64(VOTES.0)) / T::from_f64(VOTES.1))
            });
            let counts = line.visible || k >= candidates;
            *weight = if counts {
                let below = decibel(line.power / (strongest + T::from_f64(1e-30)));
                let clear = sigmoid((below + T::from_f64(CLEAR.0)) / T::from_f64(CLEAR.1));
                heard * clear * (T::ONE - suspect) * belief.weight(line.f_hz)
            } else {
                T::ZERO
            };
            sum += *weight;
        }
        // A window in which next to nothing tells of the speed changes nothing.
        if sum < T::from_f64(0.05) {
            self.weights = [T::ZERO; LINES];
        } else {
            belief.forget(sum);
        }
    }

    fn hear(&mut self, k: usize) -> Stage {
        let Some(line) = self.lines.all().get(k).filter(|_| self.is_told) else {
            return Stage::Settle;
        };
        let weight = self.weights[k.min(LINES - 1)];
        if weight > T::from_f64(1e-3) {
            let mut sum = T::ZERO;
            for (weight, _) in self.weights.iter().zip(self.lines.all()) {
                sum += *weight;
            }
            self.belief
                .hear(line.f_hz, weight, sum, &mut Desk(self.frame.desk()));
        }
        Stage::Hear(k + 1)
    }

    fn blame_rotation(&mut self, k: usize) -> Stage {
        let Some(line) = self.lines.candidates().get(k) else {
            return self.begin_steadiness(0);
        };
        let (forced, odds) = if self.is_told {
            let track = self.tracks.of(k);
            let weight = self.weights[k.min(LINES - 1)];
            let is_called = self.caller.would_call(track.evidence);
            let desk = &mut Desk(self.frame.desk());
            let odds = self.belief.forced(line.f_hz, weight, track.age_s, desk);
            let odds = track.forced(odds, is_called);
            (sigmoid(odds), odds)
        } else {
            (T::ZERO, T::ZERO)
        };
        let k = k.min(CANDIDATES - 1);
        self.forced[k] = forced;
        self.odds[k] = odds;
        Stage::Forced(k + 1)
    }

    /// The next candidate whose steadiness matters: one that has no evidence, and would gain
    /// none if it were quite steady, stays where it is.
    fn begin_steadiness(&mut self, first: usize) -> Stage {
        let scene = self.look_around();
        let mut k = first;
        while let Some(line) = self.lines.candidates().get(k).copied() {
            let (mut sight, _) = self.see(k, &line, &scene);
            sight.fluctuation = T::from_f64(QUITE_STEADY);
            let most = self.weigher.weigh(&sight);
            if most > T::ZERO || self.tracks.of(k).evidence > self.weigher.doubt() {
                self.steadiness.begin(self.angle * line.f_hz, &self.frame);
                return Stage::Steady(k);
            }
            self.fluctuation[k.min(CANDIDATES - 1)] = T::ZERO;
            k += 1;
        }
        Stage::Judge
    }

    fn watch_steadiness(&mut self, k: usize) -> Stage {
        if !self.steadiness.work(&self.frame) {
            return Stage::Steady(k);
        }
        self.fluctuation[k.min(CANDIDATES - 1)] =
            (self.steadiness.value() + T::from_f64(0.01)).ln();
        self.begin_steadiness(k + 1)
    }
}
