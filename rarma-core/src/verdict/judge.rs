//! The judgement of one window: what each candidate's features say, and which suspect is
//! the strongest.

use super::comb::Powers;
use super::evidence::Sight;
use super::lines::{CANDIDATES, SpectrumLine};
use super::{Judgement, Verdict};
use crate::real::Real;

/// Two lines are sidebands of one vibration if their distances to the next multiple of the spacing differ by less than so
/// many resolutions, or than this part of the breadth of a vibration, whichever is larger.
const SAME: f64 = 1.2;
const SIDEBANDS: f64 = 0.4;
/// Sidebands can be told from each other where they are at least so many resolutions apart.
const TOLD_APART: f64 = 8.0;
/// Multiples can be told from each other where they are at least so many resolutions apart; and so many multiples are
/// summed.
const APART: f64 = 6.0;
const MULTIPLES: u32 = 40;
/// At least this part of the band's power counts as not explained by the rotation.
const LEAST_REST: f64 = 0.03;
/// Parts of the power are kept within these bounds before their log-odds are taken.
const PARTS: (f64, f64) = (0.003, 0.995);
/// A line that holds at least this part of its family's power stands for the whole family; a weaker one in proportion.
const OWN: f64 = 1.0 / 3.0;

/// What is the same for every line of a window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene<T> {
    /// Power of the band, and of the lines that the rotation explains.
    total: T,
    explained: T,
    /// Power that the rotation does not explain.
    rest: T,
    spacing_hz: Option<T>,
    level: T,
    range: T,
}

impl<T: Real> Verdict<T> {
    /// Spacing of sidebands, Hz: a turn's, or a tooth's where those of a turn cannot be told apart.
    fn spacing_hz(&self) -> Option<T> {
        let belief = self.belief()?;
        let apart = self.resolution_hz * T::from_f64(TOLD_APART);
        let turn = belief.turn_hz();
        let tooth = turn * belief.teeth();
        [turn, tooth].into_iter().find(|spacing| *spacing > apart)
    }

    /// Whether two candidates are of one family: near each other, or sidebands of one vibration.
    fn are_family(
        &self,
        line: &SpectrumLine<T>,
        other: &SpectrumLine<T>,
        spacing_hz: Option<T>,
    ) -> bool {
        let same = (self.resolution_hz * T::from_f64(SAME))
            .max(self.breadth * T::from_f64(SIDEBANDS) * line.f_hz);
        let off = |f: T, spacing: T| {
            let q = f / spacing;
            (q - q.round()).abs() * spacing
        };
        let near = (line.f_hz - other.f_hz).abs() < self.breadth * line.f_hz;
        let sideband = spacing_hz.is_some_and(|spacing| {
            (off(line.f_hz, spacing) - off(other.f_hz, spacing)).abs() < same
        });
        near || sideband || line.bin == other.bin
    }

    /// Power of a candidate's family that the rotation does not explain, and the frequency of its strongest line.
    fn family(&self, line: &SpectrumLine<T>, spacing_hz: Option<T>) -> (T, T) {
        let (mut sum, mut strongest) = (T::ZERO, (T::ZERO, line.f_hz));
        for (other, forced) in self.lines.candidates().iter().zip(self.forced) {
            if self.are_family(line, other, spacing_hz) {
                let free = other.power * (T::ONE - forced);
                sum += free;
                if free > strongest.0 {
                    strongest = (free, other.f_hz);
                }
            }
        }
        (sum, strongest.1)
    }

    /// Power at the multiples of the believed speed, where they can be told apart.
    fn at_multiples(&self) -> Option<T> {
        let belief = self.belief()?;
        let apart = self.resolution_hz * T::from_f64(APART);
        let turn = belief.turn_hz();
        let tooth = turn * belief.teeth();
        let spacing = [turn, tooth].into_iter().find(|spacing| *spacing > apart)?;
        let mut sum = T::ZERO;
        for k in 1..=MULTIPLES {
            let bin = (T::from_u32(k) * spacing / self.frame.bin_hz)
                .round()
                .to_f32() as usize;
            sum += self.frame.line_power(bin);
        }
        Some(sum)
    }

    /// Whether the band's power is at least this part of the largest so far.
    pub(crate) fn is_loud(&self, part: T) -> bool {
        self.frame.total > self.loudest * part
    }

    /// Notices that the speed has changed. True while the new speed is searched for.
    fn follow_speed(&mut self, explained: T) -> bool {
        let lines = self.lines.candidates().iter();
        let lines = lines.fold(T::ZERO, |sum, line| sum + line.power);
        let powers = Powers {
            explained,
            at_multiples: self.at_multiples(),
            total: self.frame.total,
            lines,
        };
        if !self.is_told {
            return false;
        }
        let was_settling = self.comb.is_settling();
        if self.comb.leaves(&powers) {
            self.belief.moved();
        }
        let is_settling = self.comb.is_settling();
        if is_settling != was_settling {
            // What each line was taken for rests on the old speed.
            self.tracks.forget_origin();
        }
        is_settling
    }

    /// What is the same for every line of a window.
    pub(super) fn look_around(&self) -> Scene<T> {
        let of = T::from_f64;
        let total = self.frame.total;
        let mut explained = T::ZERO;
        for (line, forced) in self.lines.candidates().iter().zip(self.forced) {
            explained += line.power * forced;
        }
        let lg = |x: T| (x + of(1e-30)).ln() * of(core::f64::consts::LOG10_E);
        Scene {
            total,
            explained,
            rest: (total - explained).max(of(LEAST_REST) * total),
            spacing_hz: self.spacing_hz(),
            level: lg(total / self.loudest).clamp(of(-2.0), T::ZERO),
            range: lg(self.loudest / (self.quietest + of(1e-30))),
        }
    }

    /// The features of candidate `k`; with the power of its family and the frequency of the strongest line in it.
    pub(super) fn see(
        &self,
        k: usize,
        line: &SpectrumLine<T>,
        scene: &Scene<T>,
    ) -> (Sight<T>, (T, T)) {
        let of = T::from_f64;
        let k = k.min(CANDIDATES - 1);
        let log_odds = |part: T| (part / (T::ONE - part)).ln();
        let (family, f_hz) = self.family(line, scene.spacing_hz);
        let own = line.power * (T::ONE - self.forced[k]) / (family + of(1e-30));
        let counts = (own * of(1.0 / OWN)).min(T::ONE);
        let part = |of_what: T| {
            let part = (family.min(of_what) / of_what).clamp(of(PARTS.0), of(PARTS.1));
            log_odds((part * counts).max(of(PARTS.0)))
        };
        let sight = Sight {
            free: self.is_told.then_some(-self.odds[k]),
            part_of_rest: part(scene.rest),
            part_of_all: part(scene.total),
            over_idle_db: self.frame.over_idle_db(line.bin, line.power),
            fluctuation: self.fluctuation[k],
            level: scene.level,
            range: scene.range,
        };
        (sight, (family, f_hz))
    }

    pub(super) fn judge(&mut self) {
        let of = T::from_f64;
        let scene = self.look_around();
        let is_settling = self.follow_speed(scene.explained);
        let mut best: Option<Judgement<T>> = None;
        let mut next = 0;
        while let Some(line) = self.lines.candidates().get(next).copied() {
            let k = next.min(CANDIDATES - 1);
            next += 1;
            let (sight, (family, f_hz)) = self.see(k, &line, &scene);
            let mut evidence = self.weigher.weigh(&sight);
            let track = self.tracks.of(k);
            if is_settling || track.slope.abs() > self.glide {
                evidence = evidence.min(T::ZERO);
            }
            let over = sight
                .over_idle_db
                .unwrap_or(of(10.0))
                .clamp(T::ZERO, of(30.0))
                / of(10.0);
            let free_odds = sight.free.unwrap_or(T::ZERO).clamp(of(-5.0), of(5.0));
            track.evidence = self.weigher.add(track.evidence, evidence);
            track.suspect([sight.part_of_rest, free_odds, over]);
            if best.is_none_or(|best| track.evidence > best.evidence) {
                best = Some(Judgement {
                    evidence: track.evidence,
                    f_hz,
                    chatter: false,
                    forced: sight.free.map(|_| self.forced[k]),
                    part: family / scene.total,
                    over_idle_db: sight.over_idle_db,
                    spindle_hz: None,
                });
            }
        }
        let mut now = best.unwrap_or(Judgement {
            evidence: self.weigher.doubt(),
            ..Judgement::NONE
        });
        now.spindle_hz = self
            .belief()
            .map(|belief| (belief.turn_hz(), belief.turn_hz() * belief.sd()));
        now.chatter = self.caller.hear(now.evidence);
        self.last = now;
    }
}
