//! One tracked mode: what is gathered of it at every sample, and read at a decision.

use super::spindle::Spindle;
use crate::decide::{
    AlarmConfig, Evidence, ModeTrack, Origin, Places, Reading, Rotation, Runaway, SequentialTest,
    Steadiness,
};
use crate::real::Real;
use crate::spectrum::{LOCKIN_TAU_S, LockIn, Modal, ModalDeviation};
use crate::verdict::Verdict;
use crate::visit::state;

/// Factor on the threshold of ζ for a mode that may have had little damping from the beginning.
const NO_NEWS: f64 = 0.25;
/// Time constant of the average of a line's frequency, s; and the relative change of frequency
/// above which it is taken for another line.
const LINE_TAU_S: f64 = 0.06;
const SAME_LINE: f64 = 0.01;

/// A mode's place: its lock-in, its test and its memory.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot<T> {
    at: LockIn<T>,
    test: SequentialTest<T>,
    steadiness: Steadiness<T>,
    runaway: Runaway<T>,
    /// Frequency of the line that is loudest at the mode, Hz, and for how long it has been
    /// averaged, s.
    line: (T, T),
    steered: T,
    pub(super) track: ModeTrack<T>,
}

state! { Slot<T> { at, test, steadiness, runaway, line, steered, track } }

impl<T: Real> Default for Slot<T> {
    fn default() -> Self {
        Self {
            at: LockIn::default(),
            test: SequentialTest::default(),
            steadiness: Steadiness::default(),
            runaway: Runaway::default(),
            line: (T::ZERO, T::ZERO),
            steered: T::ZERO,
            track: ModeTrack::default(),
        }
    }
}

/// Gains of the smoothing at one rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gains<T> {
    lockin: T,
    variance: T,
}

impl<T: Real> Gains<T> {
    pub(super) fn new(fs: f64) -> Self {
        Self {
            lockin: T::from_f64((1.0 / (LOCKIN_TAU_S * fs)).min(1.0)),
            variance: SequentialTest::variance_gain(fs),
        }
    }
}

/// What a mode is compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surroundings<'a, T> {
    pub(super) fs: T,
    pub(super) band: (T, T),
    pub(super) rotation: Rotation<T>,
    pub(super) spindle: &'a Spindle<T>,
    pub(super) sources: &'a Verdict<T>,
    pub(super) places: &'a Places<T>,
    pub(super) config: &'a AlarmConfig<T>,
    /// The machine has been heard idling, so that tones of idle can be recognised.
    pub(super) idle_known: bool,
    /// The band has become louder during the cut. At the beginning of a cut this is false, for forced lines grow
    /// then, too.
    pub(super) louder: bool,
    /// The speed of the spindle is told or heard. Then lines of the spectrum are compared with its
    /// multiples, and a line may call an alarm.
    pub(super) knows_speed: bool,
    /// Time since the last decision, s.
    pub(super) period_s: T,
}

impl<T: Real> Slot<T> {
    /// One decimated sample, and the mode's own part of it.
    #[inline(always)]
    pub(super) fn listen(&mut self, y: T, own: T, gains: &Gains<T>) {
        self.at.process(y, gains.lockin);
        self.test.process(own, gains.variance);
    }

    /// Its alarm has ended: forgets the evidence, so that the next call needs new evidence.
    pub(super) fn clear(&mut self) {
        self.track.clear();
        self.test.forget();
    }

    /// Whether its amplitude stays constant, as that of a limit cycle does.
    pub(super) fn is_steady(&self) -> bool {
        self.steadiness.is_steady()
    }

    /// Whether its amplitude grows as its (negative) damping says.
    pub(super) fn runs_away(&self) -> bool {
        self.runaway.is_certain()
    }

    /// There is no mode here any more: forgets all.
    pub(super) fn reset(&mut self) {
        self.track.reset();
        self.test.reset();
        self.steadiness.reset();
        self.runaway = Runaway::default();
    }

    /// The mode as it is now, and the power at it. Steers the lock-in and the test.
    pub(super) fn read(
        &mut self,
        modal: &Modal<T>,
        sd: &ModalDeviation<T>,
        around: &Surroundings<'_, T>,
    ) -> (Reading<T>, T) {
        let frequency = modal.frequency;
        if self.track.follow(frequency) {
            self.test.reset();
            self.steadiness.reset();
            self.runaway = Runaway::default();
        }
        self.follow_line(frequency, around.period_s);
        let angle = T::from_f64(2.0) * T::PI * frequency / around.fs;
        self.at.steer(angle);
        let here = self.at.power();
        self.steadiness.note(here, around.period_s);
        let damping = (modal.damping, sd.damping);
        let knows_speed = around.knows_speed;
        self.runaway
            .note(frequency, damping, here, knows_speed, around.period_s);
        let steady = self.steadiness.is_steady();
        // A constant amplitude is that of a limit cycle and not of a mode with little damping that the cut rings.
        let (usual, threshold) = if steady {
            let setting = around.config.threshold;
            (setting * T::from_f64(2.0), setting)
        } else {
            (
                around.places.usual_damping(frequency, around.config),
                around.places.threshold(frequency, around.config),
            )
        };
        let places = around.places;
        let is_news = steady || places.is_news(frequency, here, around.idle_known, around.config);
        let most = around.config.threshold * T::from_f64(if is_news { 1.0 } else { NO_NEWS });
        self.test.steer(angle, most, usual);
        // A mode that was on a multiple of the speed still counts as on it within 1.5 times the
        // usual number of standard deviations: else it would leave the multiple by chance many
        // times a second.
        let spread = if self.track.was_on_rotation() {
            sd.frequency * T::from_f64(1.5)
        } else {
            sd.frequency
        };
        // One pole for a line and a mode beside it lies between the two: the line's own frequency is asked, too.
        let undamped = modal.damping < around.config.threshold && !around.spindle.is_locked();
        let line = self.line_hz().filter(|_| undamped);
        let sure = around.rotation.without_doubt();
        let of_line = line.and_then(|line| sure.harmonic(line, T::ZERO));
        let harmonic = around.rotation.harmonic(frequency, spread).or(of_line);
        let origin = self.origin(frequency, sd.frequency, harmonic, around);
        if origin.explains() {
            // Evidence on a forced line is thrown away, lest it count when the speed jumps and leaves the line behind.
            self.test.discount();
        }
        let reading = Reading {
            frequency: (frequency, sd.frequency),
            damping: (modal.damping, sd.damping),
            amplitude: self.at.amplitude(),
            share: T::ZERO,
            share_of_all: T::ZERO,
            origin,
            harmonic,
            in_band: frequency >= around.band.0 && frequency <= around.band.1,
            grew: (around.louder && around.places.has_grown(frequency, here))
                || around
                    .places
                    .keeps_its_power(frequency, here.max(self.steadiness.mean()))
                || around.places.has_risen(frequency),
            threshold: threshold.min(most),
            evidence: self.evidence(),
        };
        (reading, here)
    }

    /// Follows the frequency of the line that the lock-in hears, from how its phase turns.
    fn follow_line(&mut self, frequency: T, period_s: T) {
        let slip = self.at.slipped();
        let (line, heard_s) = self.line;
        let jumped = (frequency - self.steered).abs() > frequency * T::from_f64(SAME_LINE);
        let there = self.steered - slip / (T::from_f64(2.0) * T::PI * period_s);
        self.line = if jumped || !there.is_finite() {
            (frequency, T::ZERO)
        } else {
            let heard_s = (heard_s + period_s).min(T::from_f64(LINE_TAU_S));
            (line + (there - line) * (period_s / heard_s), heard_s)
        };
        self.steered = frequency;
    }

    /// Frequency of the line, Hz, once it is known.
    fn line_hz(&self) -> Option<T> {
        let (line, heard_s) = self.line;
        (heard_s >= T::from_f64(LINE_TAU_S)).then_some(line)
    }

    fn evidence(&self) -> Evidence<T> {
        self.test.evidence()
    }

    fn origin(
        &self,
        frequency: T,
        sd: T,
        harmonic: Option<u32>,
        around: &Surroundings<'_, T>,
    ) -> Origin {
        if let Some(n) = harmonic {
            return if around.rotation.may_flip(n) {
                Origin::Unknown
            } else {
                Origin::Rotation
            };
        }
        if around.idle_known && around.sources.is_background(frequency) {
            return Origin::Background;
        }
        let spindle = around.spindle;
        if around.rotation.spindle_hz.is_none()
            || spindle.is_doubtful(frequency, sd)
            || spindle.is_unproven(frequency, around.idle_known)
        {
            return Origin::Unknown;
        }
        Origin::Free
    }
}
