//! Speed and angle of the spindle from the pulses of a tacho.
//!
//! Rate: [`Tacho::pulse`] at every pulse, [`Tacho::read`] when the speed is wanted
//! (slow path). Words: *turn*, one revolution; *rhythm*, the expected interval.

mod config;
mod held;
mod pulse;
#[cfg(test)]
mod tacho_tests;

pub use config::{TachoConfig, TachoError, TachoFault, TachoReading};
pub use pulse::{LEVEL_MEMORY_S, PulseDetector};

use crate::real::Real;
use crate::visit::state;
use held::{Held, LEAST};

/// Pulses whose faults are counted, and how many of them make a fault.
const FAULTY: u32 = 3;
/// An interval of less than this many expected ones is an extra pulse; one within a
/// quarter of a whole number is that many.
const EXTRA: f64 = 0.75;
const QUARTER: f64 = 0.25;
/// At most so many pulses missing in a row are counted by their time.
const MOST_MISSING: f64 = 4.0;
/// Without a pulse for so many expected intervals, pulses are missing now.
const GONE: f64 = 3.0;
/// Intervals in a row that agree within a tenth with each other, but not with the
/// expected one or a whole number of it or a whole part: the rhythm is another.
const STEADY: u8 = 3;
const TENTH: f64 = 0.1;
/// Pulses against the rhythm in a row after which it is sought anew.
const STRANGERS: u8 = 4;
/// Intervals a new rhythm is made of.
const FIRST: usize = 5;

/// Follows the rhythm of the pulses; a single extra or missing one changes nothing.
///
/// An interval is compared with the expected one: below 0.75 of it the pulse is an
/// extra one and left out, within a quarter of 1, 2, 3, 4 it is so many, else it is a
/// stranger, left out as well; four strangers in a row, or four equal intervals that are
/// neither a multiple nor a whole part of the expected one, and the rhythm is sought
/// anew.
/// Time over count of the last 12 pulses is fitted by a parabola (by a straight line
/// below 6), so that a changing speed is read as it is at the last pulse; the scatter
/// about the fit gives the standard deviation and tells noise. Pulses that are spaced
/// unevenly round the turn count as scatter.
///
/// ```
/// use rarma_core::condition::{Tacho, TachoConfig};
/// let mut tacho = Tacho::<f32>::new(&TachoConfig::new(48_000.0)).unwrap();
/// for n in 0..20u64 {
///     if n != 13 { tacho.pulse(960 * n, 0.0); } // 50 Hz, one pulse lost
/// }
/// let reading = tacho.read(960 * 19 + 240);
/// assert!((reading.spindle_hz.unwrap().0 - 50.0).abs() < 0.01);
/// assert!((reading.turn.unwrap() - 0.25).abs() < 0.001 && reading.fault.is_none());
/// ```
#[derive(Debug, Clone)]
pub struct Tacho<T> {
    fs_hz: T,
    pulses: T,
    silent_samples: u64,
    noisy: T,
    /// Time of the last pulse that counted (of the last one, while none counts).
    last: Option<(u64, T)>,
    /// Samples between pulses.
    rhythm: Option<T>,
    held: Held<T>,
    first: [T; FIRST],
    firsts: usize,
    strangers: u8,
    /// The last pulse of all, the interval before it, and how many agreed with it.
    newest: Option<(u64, T)>,
    between: T,
    steady: u8,
    /// Histories of the last eight pulses, one bit each.
    missing: u8,
    doubled: u8,
    stray: u8,
}

state! { Tacho<T> {
    last, rhythm, held, first, firsts, strangers, newest, between, steady, missing, doubled,
    stray;
    settings fs_hz, pulses, silent_samples, noisy;
    where *firsts <= FIRST && *strangers < STRANGERS
} }

impl<T: Real> Tacho<T> {
    /// A tacho that has heard no pulse.
    ///
    /// # Errors
    /// See [`TachoError`].
    pub fn new(config: &TachoConfig) -> Result<Self, TachoError> {
        let fs = config.fs_hz;
        if !(fs.is_finite() && fs > 0.0) {
            return Err(TachoError::Rate);
        }
        if !(1..=1000).contains(&config.pulses_per_turn) {
            return Err(TachoError::PulsesPerTurn);
        }
        if !(config.least_hz > 0.0 && config.least_hz < fs) {
            return Err(TachoError::LeastSpeed);
        }
        if !(config.noisy_fraction >= 0.001 && config.noisy_fraction <= 0.5) {
            return Err(TachoError::NoisyFraction);
        }
        let pulses = f64::from(config.pulses_per_turn);
        Ok(Self {
            fs_hz: T::from_f64(fs),
            pulses: T::from_f64(pulses),
            silent_samples: (2.0 * fs / (config.least_hz * pulses)) as u64 + 1,
            noisy: T::from_f64(config.noisy_fraction),
            last: None,
            rhythm: None,
            held: Held::new(),
            first: [T::ZERO; FIRST],
            firsts: 0,
            strangers: 0,
            newest: None,
            between: T::ZERO,
            steady: 0,
            missing: 0,
            doubled: 0,
            stray: 0,
        })
    }

    /// Forgets all pulses.
    pub fn reset(&mut self) {
        self.last = None;
        self.newest = None;
        self.lose_rhythm();
        (self.missing, self.doubled, self.stray) = (0, 0, 0);
    }

    fn lose_rhythm(&mut self) {
        self.rhythm = None;
        self.held.clear();
        self.firsts = 0;
        self.strangers = 0;
        self.steady = 0;
    }

    /// Whether the last intervals, whatever they were taken for, are another rhythm.
    fn another_rhythm(&mut self, at: (u64, T)) -> bool {
        let Some(before) = self.newest.replace(at) else {
            return false;
        };
        let interval = since(before, at.0) + at.1;
        let agrees = (interval - self.between).abs() <= self.between * T::from_f64(TENTH);
        self.steady = if agrees {
            self.steady.saturating_add(1)
        } else {
            0
        };
        self.between = interval;
        let Some(rhythm) = self.rhythm.filter(|_| self.steady >= STEADY) else {
            return false;
        };
        let ratio = interval / rhythm;
        let times = if ratio < T::ONE {
            T::ONE / ratio
        } else {
            ratio
        };
        (times - times.round()).abs() > times * T::from_f64(TENTH)
    }

    /// A pulse at `sample` + `fraction`. One that is not later than the last, or whose
    /// fraction is no number, is ignored.
    pub fn pulse(&mut self, sample: u64, fraction: T) {
        if !fraction.is_finite() {
            return;
        }
        let Some(last) = self.last else {
            self.last = Some((sample, fraction));
            self.newest = self.last;
            return;
        };
        let interval = since(last, sample) + fraction;
        if !(interval > T::ZERO) {
            return;
        }
        if sample.saturating_sub(last.0) > self.silent_samples {
            self.lose_rhythm();
            self.last = Some((sample, fraction));
            return;
        }
        if self.another_rhythm((sample, fraction)) {
            self.lose_rhythm();
        }
        match self.rhythm {
            Some(rhythm) => self.follow(interval, rhythm, (sample, fraction)),
            None => self.begin(interval, (sample, fraction)),
        }
    }

    /// Intervals until three of five agree with their median.
    fn begin(&mut self, interval: T, at: (u64, T)) {
        self.last = Some(at);
        if self.firsts >= FIRST {
            self.first.rotate_left(1);
            self.firsts = FIRST - 1;
        }
        if let Some(place) = self.first.get_mut(self.firsts) {
            *place = interval;
            self.firsts += 1;
        }
        if self.firsts < LEAST {
            return;
        }
        let intervals = self.first.get(..self.firsts).unwrap_or(&[]);
        let agreeing = |x: T| {
            let near = |y: &&T| (**y - x).abs() <= x * T::from_f64(QUARTER);
            intervals.iter().filter(near).count()
        };
        let most = intervals.iter().map(|x| (agreeing(*x), *x));
        let best = most.fold((0, T::ZERO), |a, b| if b.0 > a.0 { b } else { a });
        // The newest must be one of them: the count starts there.
        if best.0 >= LEAST && (interval - best.1).abs() <= best.1 * T::from_f64(QUARTER) {
            self.rhythm = Some(best.1);
            self.held.clear();
            self.strangers = 0;
            self.held.add(interval, T::ONE);
        }
    }

    fn follow(&mut self, interval: T, rhythm: T, at: (u64, T)) {
        let ratio = interval / rhythm;
        let whole = ratio.round();
        let fits = (ratio - whole).abs() <= T::from_f64(QUARTER);
        let extra = ratio < T::from_f64(EXTRA);
        let missing = !extra && ratio > T::from_f64(1.5);
        let stray = !extra && (!fits || whole > T::from_f64(MOST_MISSING));
        let note = |history: u8, bit: bool| (history << 1) | u8::from(bit);
        self.missing = note(self.missing, missing);
        self.doubled = note(self.doubled, extra);
        self.stray = note(self.stray, stray);
        if extra || stray {
            self.strangers += 1;
            if self.strangers >= STRANGERS {
                self.lose_rhythm();
                self.last = Some(at);
            }
            return;
        }
        // One extra pulse in every interval is no stranger's rhythm.
        self.strangers = 0;
        self.last = Some(at);
        self.held.add(interval, whole);
        let step = interval / whole;
        self.rhythm = Some(rhythm + (step - rhythm) * T::from_f64(0.3));
    }

    /// Speed, angle and faults at sample `now`. Slow path.
    pub fn read(&self, now: u64) -> TachoReading<T> {
        let mut reading = TachoReading {
            spindle_hz: None,
            turn: None,
            fault: Some(TachoFault::Silent),
        };
        let Some(last) = self.last else {
            return reading;
        };
        if now.saturating_sub(last.0) > self.silent_samples {
            return reading;
        }
        let often = |history: u8| history.count_ones() >= FAULTY;
        reading.fault = if often(self.missing) {
            Some(TachoFault::Missing)
        } else if often(self.doubled) {
            Some(TachoFault::Doubled)
        } else if often(self.stray) {
            Some(TachoFault::Noisy)
        } else {
            None
        };
        let Some((interval, sd, scatter)) = self.held.fit() else {
            return reading;
        };
        let gone = (since(last, now)) / interval;
        if gone > T::from_f64(GONE) {
            reading.fault = Some(TachoFault::Missing);
        } else if scatter > self.noisy * interval && reading.fault.is_none() {
            reading.fault = Some(TachoFault::Noisy);
        }
        let hz = self.fs_hz / (interval * self.pulses);
        reading.spindle_hz = Some((hz, hz * sd / interval));
        let turns = gone.max(T::ZERO) / self.pulses;
        let part = turns - T::from_u32(turns.to_f32() as u32);
        reading.turn = Some(part.clamp(T::ZERO, T::from_f64(0.999_999)));
        reading
    }
}

/// Samples from a time to a sample.
fn since<T: Real>(from: (u64, T), to: u64) -> T {
    let samples = to.saturating_sub(from.0).min(u64::from(u32::MAX));
    T::from_u32(samples as u32) - from.1
}
