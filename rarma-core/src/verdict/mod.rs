//! Which source made this narrow line: the rotation, the background, a mode that the cut
//! rings, or the cut itself.
//!
//! Rate: [`Verdict::process`] once a decimated sample, a bounded slice of work each time; a
//! [`Judgement`] every 0.05 s. Words: *line*, a narrow peak of the short-time spectrum;
//! *candidate*, one of the strongest lines; *family*, a line with its sidebands a turn or a
//! tooth apart; *evidence*, a log-odds (natural logarithm).
//!
//! ```text
//! window → spectrum → lines → speed as a belief → log-odds that the rotation makes each
//!        → family's part of what the rotation leaves, of all; level over idle; S
//!        → evidence = belief + w·free − Σ penalties, summed over time from a doubt on
//! ```
//!
//! The evidence is a conjunction: each feature can only speak against. Chatter is called when
//! the sum of a line passes a threshold.

mod belief;
mod caller;
mod comb;
mod config;
mod evidence;
mod frame;
mod judge;
mod lines;
mod steadiness;
mod tracks;
mod turning;
#[cfg(test)]
mod verdict_tests;
mod window;

pub use caller::Caller;
pub use config::{Number, VerdictConfig, VerdictError, number};

use crate::real::Real;
use crate::visit::state;
use belief::{Belief, Desk};
use comb::Comb;
use evidence::Weigher;
pub use frame::HOP_S;
use frame::{FRAME, Frame, SEGMENTS};
use lines::{CANDIDATES, LINES, Lines};
use steadiness::Steadiness;
use tracks::Tracks;
use window::{SCANNED, Stage};

/// The work on a window is spread over this part of the time until the next one.
const BUSY: f64 = 0.7;
/// A tone of idle has grown when its power is this many times that at idle (6 dB).
const GROWN: f64 = 4.0;

/// What the verdict is told of the machine and the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Listening {
    /// Rate of the samples, Hz: of the decimated band.
    pub fs_hz: f64,
    /// Turns a second, where they are told.
    pub spindle_hz: Option<f64>,
    /// Teeth on the cutter, where they are told.
    pub teeth: Option<u32>,
    /// Rate of a sampler without an anti-alias filter, Hz, where there is such a one.
    pub folding_hz: Option<f64>,
}

/// What is believed of the strongest suspect after one window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement<T> {
    /// Sum of the evidence that it is self-excited.
    pub evidence: T,
    /// Its frequency, Hz.
    pub f_hz: T,
    /// Chatter is called.
    pub chatter: bool,
    /// Chance that the rotation makes the line; none without a speed.
    pub forced: Option<T>,
    /// Part of the band's power that its family holds.
    pub part: T,
    /// Level of the line over idle, dB, where idle was heard.
    pub over_idle_db: Option<T>,
    /// Turns a second as believed, and their standard deviation.
    pub spindle_hz: Option<(T, T)>,
}

state! { Judgement<T> { evidence, f_hz, chatter, forced, part, over_idle_db, spindle_hz } }

impl<T: Real> Judgement<T> {
    /// Nothing has been judged.
    pub(crate) const NONE: Self = Self {
        evidence: T::ZERO,
        f_hz: T::ZERO,
        chatter: false,
        forced: None,
        part: T::ZERO,
        over_idle_db: None,
        spindle_hz: None,
    };
}

/// Listens to one channel.
#[derive(Debug, Clone)]
pub struct Verdict<T> {
    frame: Frame<T>,
    lines: Lines<T>,
    tracks: Tracks<T>,
    belief: Belief<T>,
    /// A speed has been told.
    is_told: bool,
    steadiness: Steadiness<T>,
    weigher: Weigher<T>,
    stage: Stage,
    /// Samples until the next window, and slices of work a sample.
    until: usize,
    pace: usize,
    weights: [T; LINES],
    /// Chance that the rotation makes each candidate, its log-odds, and ln(S + 0.01).
    forced: [T; CANDIDATES],
    odds: [T; CANDIDATES],
    fluctuation: [T; CANDIDATES],
    breadth: T,
    glide: T,
    resolution_hz: T,
    angle: T,
    /// Power of the band: the loudest of late, the smoothed one, and the least of that.
    loudest: T,
    smooth: T,
    quietest: T,
    comb: Comb<T>,
    caller: Caller<T>,
    last: Judgement<T>,
}

state! { Verdict<T> {
    frame, lines, tracks, belief, is_told, steadiness, stage, until, weights, forced, odds,
    fluctuation, loudest, smooth, quietest, comb, caller, last;
    settings weigher, pace, breadth, glide, resolution_hz, angle;
    where *until <= FRAME && stage.is_within(frame.bins)
} }

impl<T: Real> Verdict<T> {
    /// A verdict at the beginning of listening.
    ///
    /// # Errors
    /// The first setting that is out of range.
    pub fn new(config: &VerdictConfig, listening: &Listening) -> Result<Self, VerdictError> {
        let mut verdict = Self::BLANK;
        verdict.restart(config, listening)?;
        Ok(verdict)
    }

    /// Zeros, until [`Self::restart`]: it takes no sample.
    pub(crate) const BLANK: Self = Self {
        frame: Frame::BLANK,
        lines: Lines::BLANK,
        tracks: Tracks::BLANK,
        belief: Belief::BLANK,
        is_told: false,
        steadiness: Steadiness::BLANK,
        weigher: Weigher::BLANK,
        stage: Stage::Wait,
        until: 0,
        pace: 0,
        weights: [T::ZERO; LINES],
        forced: [T::ZERO; CANDIDATES],
        odds: [T::ZERO; CANDIDATES],
        fluctuation: [T::ZERO; CANDIDATES],
        breadth: T::ZERO,
        glide: T::ZERO,
        resolution_hz: T::ZERO,
        angle: T::ZERO,
        loudest: T::ZERO,
        smooth: T::ZERO,
        quietest: T::ZERO,
        comb: Comb::BLANK,
        caller: Caller::BLANK,
        last: Judgement::NONE,
    };

    /// Forgets everything and begins with these settings, in place: it is 30 KB.
    ///
    /// # Errors
    /// The first setting that is out of range; nothing has changed then.
    #[inline(never)]
    pub fn restart(
        &mut self,
        config: &VerdictConfig,
        listening: &Listening,
    ) -> Result<(), VerdictError> {
        config.check()?;
        let within = |x: f64, least: f64, most: f64| x >= least && x <= most;
        let fs_hz = listening.fs_hz;
        let folding_ok = listening.folding_hz.is_none_or(|hz| within(hz, 100.0, 1e6));
        if !(within(fs_hz, 100.0, 20_000.0) && folding_ok) {
            return Err(VerdictError::Rate);
        }
        if listening
            .spindle_hz
            .is_some_and(|hz| !within(hz, 0.1, 5000.0))
        {
            return Err(VerdictError::Speed);
        }
        if listening
            .teeth
            .is_some_and(|teeth| !(1..=1000).contains(&teeth))
        {
            return Err(VerdictError::Teeth);
        }
        // All of them by name, so that none is forgotten.
        let Self {
            frame,
            lines,
            tracks,
            belief,
            is_told,
            steadiness,
            weigher,
            stage,
            until,
            pace,
            weights,
            forced,
            odds,
            fluctuation,
            breadth,
            glide,
            resolution_hz,
            angle,
            loudest,
            smooth,
            quietest,
            comb,
            caller,
            last,
        } = self;
        frame.restart(fs_hz);
        *resolution_hz = frame.resolution_hz();
        let slices = Frame::<T>::slices()
            + (frame.bins.1 - frame.bins.0) / SCANNED
            + LINES
            + CANDIDATES * (SEGMENTS + 2)
            + 5;
        *until = frame.window;
        *pace = (slices as f64 / (BUSY * frame.hop as f64)) as usize + 1;
        *is_told = listening.spindle_hz.is_some();
        let told_hz = listening.spindle_hz.unwrap_or(1.0);
        belief.restart(
            config,
            told_hz,
            listening,
            *resolution_hz,
            &mut Desk(frame.desk()),
        );
        *lines = Lines::BLANK;
        *tracks = Tracks::BLANK;
        *steadiness = Steadiness::BLANK;
        *weigher = Weigher::new(config, HOP_S);
        *stage = Stage::Wait;
        weights.fill(T::ZERO);
        for each in [forced, odds, fluctuation] {
            each.fill(T::ZERO);
        }
        *breadth = T::from_f64(config.breadth);
        *glide = T::from_f64(config.glide);
        *angle = T::from_f64(core::f64::consts::TAU / fs_hz);
        for x in [loudest, smooth, quietest] {
            *x = T::ZERO;
        }
        *comb = Comb::BLANK;
        *caller = Caller::new(config);
        *last = Judgement::NONE;
        Ok(())
    }

    /// The speed as a control tells it, Hz: for the first time, or anew. What was held of the lines
    /// before the first time is forgotten: without a speed each of them was free.
    pub fn tell_speed(&mut self, spindle_hz: T) {
        if spindle_hz.is_finite() && spindle_hz > T::from_f64(0.1) {
            if !self.is_told {
                self.tracks = Tracks::BLANK;
                self.caller.silence();
                // The window at hand is half judged.
                self.stage = Stage::Wait;
                self.last = Judgement::NONE;
            }
            self.belief.tell(spindle_hz);
            self.is_told = true;
        }
    }

    /// The speed, Hz, is among those that are believed in.
    pub(crate) fn reaches(&self, spindle_hz: T) -> bool {
        self.is_told && self.belief.reaches(spindle_hz)
    }

    /// The speed that is believed in explains most of the sound.
    pub(crate) fn explains_most(&self) -> bool {
        self.is_told && self.comb.explains_most()
    }

    /// The belief, where somebody has told a speed.
    fn belief(&self) -> Option<&Belief<T>> {
        self.is_told.then_some(&self.belief)
    }

    /// What is there at this frequency, Hz, was there at idle and has not grown since.
    pub(crate) fn is_background(&self, f_hz: T) -> bool {
        let over = self.frame.smooth_over_idle(f_hz);
        over.is_some_and(|over| over < T::from_f64(GROWN))
    }

    /// Chance that the rotation makes the line at this frequency, Hz; none where no strong line
    /// is, or while the speed is looked for.
    pub fn forced_at(&self, f_hz: T) -> Option<T> {
        if !self.is_told || self.comb.is_settling() {
            return None;
        }
        let candidates = self.lines.candidates().iter().zip(self.forced);
        let mut nearest = (self.resolution_hz, None);
        for (line, forced) in candidates {
            let apart = (line.f_hz - f_hz).abs();
            if apart < nearest.0 {
                nearest = (apart, Some(forced));
            }
        }
        nearest.1
    }

    /// The last judgement.
    pub fn judgement(&self) -> &Judgement<T> {
        &self.last
    }

    /// Takes one sample of the band; gives a judgement every 0.05 s.
    #[inline]
    pub fn process(&mut self, x: T) -> Option<&Judgement<T>> {
        self.frame.push(x);
        self.until = self.until.saturating_sub(1);
        if self.until == 0 && self.pace > 0 {
            self.until = self.frame.hop;
            self.frame.begin();
            self.stage = Stage::Spectrum;
        }
        match self.stage {
            Stage::Wait => None,
            Stage::Spectrum => {
                let left = self.work_on_spectrum(self.pace)?;
                self.work_on_lines(left)
            }
            _ => self.work_on_lines(self.pace),
        }
    }

    /// So many slices behind the spectrum. A function of its own, so that the other samples do not
    /// prepare its loop.
    #[inline(never)]
    fn work_on_lines(&mut self, slices: usize) -> Option<&Judgement<T>> {
        for _ in 0..slices {
            self.stage = self.work();
            if self.stage == Stage::Wait {
                return Some(&self.last);
            }
        }
        None
    }
}
