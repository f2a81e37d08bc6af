//! What is known of the spindle: its speed, whoever says it, and its lines.
//!
//! Rate: `process` once a decimated sample, the rest at the decision rate. In order of
//! trust: a tacho; the lines in the sound at, or near, the speed that was told; lines in
//! the sound that nobody told of; the told speed itself.

mod belief;
mod hearing;
mod moving;
mod standing;

use super::MonitorConfig;
use super::drift::Drift;
use crate::condition::{
    Band, Lock, SpeedFinder, SpeedFinderConfig, SpindleLines, SpindleLinesConfig, Tacho,
    TachoConfig, TachoFault,
};
use crate::decide::SPEED_ACCURACY;
use crate::real::Real;
use crate::visit::state;
use moving::Moving;
use standing::DoubtfulComb;

/// The model hears up to this part of its rate, and down to this part of the band's lower
/// edge, where the high-pass leaves 1/6 of a line.
const MODEL_REACH: f64 = 0.47;
const BELOW_BAND: f64 = 0.4;
/// Lines that are removed at most.
pub(super) const LINES: usize = 32;
/// A speed that was found is believed for this long without being heard again, s.
const FOUND_HOLD_S: f64 = 3.0;
/// After the level has risen from idle to a cut the speed is in doubt for this long, s,
/// by this part of it: a spindle that is loaded dips by up to 1 % and is back after half
/// a second; the sound tells it 0.2 s later.
const ENTERING: (f64, f64) = (0.8, 0.013);
/// A told speed that the sound has not confirmed is in doubt for this long of cutting,
/// s, by this part of it: a mill told 4500 rpm turned at 4577.
const UNCONFIRMED: (f64, f64) = (0.8, 0.02);
/// Where the search's frame is longer than that, the sound tells the speed after so many frames,
/// and until then the first multiples stay in doubt.
const HEARD_FRAMES: f64 = 2.3;
/// Who says the speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SpeedSource {
    /// Nobody.
    #[default]
    Unknown,
    /// The setting.
    Told,
    /// The lines in the sound.
    Sound,
    /// The tacho.
    Tacho,
}

/// What the monitor knows of the spindle at a decision.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpindleReport<T> {
    /// Rotations per second, Hz; where nobody told the speed, this may be the frequency
    /// of the teeth.
    pub spindle_hz: Option<T>,
    /// Who says so.
    pub source: SpeedSource,
    /// The lines are being removed.
    pub locked: bool,
    /// Power removed, input units squared.
    pub removed_power: T,
    /// Half-width of the notch around each removed line, Hz: nothing can be heard there.
    pub notch_hz: T,
    /// The sound contradicts the told speed: told and found, Hz.
    pub contradiction: Option<(T, T)>,
    /// What is wrong with the tacho.
    pub tacho_fault: Option<TachoFault>,
}

/// The spindle of one monitor. By default nothing is known of one, and no line is looked for.
#[derive(Debug, Clone, Default)]
pub(super) struct Spindle<T> {
    finder: Option<SpeedFinder<T>>,
    lines: Option<SpindleLines<T, LINES>>,
    tacho: Option<Tacho<T>>,
    /// The setting, and what stands for it since a speed near it was heard: an operator
    /// who said 4500 for 4577 is wrong for good, and an override moves the speed.
    setting: Option<T>,
    told: Option<T>,
    was_locked: bool,
    /// The speed found last is a mean over an entry.
    found_at_entry: bool,
    drift: Drift<T>,
    teeth: Option<u32>,
    /// Speed and its deviation as found in the sound, and how long ago, s.
    found: Option<((T, T), T)>,
    /// A comb that may be a chatter's, Hz, and how long ago it was heard, s.
    doubtful: Option<(T, T)>,
    standing: DoubtfulComb<T>,
    moving: Moving<T>,
    contradiction: Option<(T, T)>,
    /// Contradictions in a row.
    denied: u8,
    low_hz: T,
    tacho_reading: Option<(T, T)>,
    tacho_fault: Option<TachoFault>,
    entering_s: T,
    /// For how long of cutting a told speed has not been confirmed, s.
    unconfirmed_s: Option<T>,
}

state! { Spindle<T> {
    setting, told, was_locked, found_at_entry, drift, found, doubtful, standing, moving,
    contradiction, denied, tacho_reading, tacho_fault, entering_s, unconfirmed_s;
    made finder, lines, tacho;
    settings teeth, low_hz
} }

/// Where lines are removed: above the band and below it, too, as far as the model hears. A
/// tooth line there takes a pole pair of the model like any other.
fn up_to_the_model(band: Band, fs: f64) -> Band {
    Band {
        low_hz: BELOW_BAND * band.low_hz,
        high_hz: band.high_hz.max(MODEL_REACH * fs),
    }
}

impl<T: Real> Spindle<T> {
    /// Forgets everything, and takes decimated samples of rate `fs`. A rate that is too low
    /// for lines has none.
    #[inline(never)]
    pub(super) fn restart(&mut self, config: &MonitorConfig, fs: f64) {
        let band = config.band();
        let said = config.spindle_hz;
        // All of them by name, so that none is forgotten.
        let Self {
            finder,
            lines,
            tacho,
            setting,
            told,
            was_locked,
            found_at_entry,
            drift,
            teeth,
            found,
            doubtful,
            standing,
            moving,
            contradiction,
            denied,
            low_hz,
            tacho_reading,
            tacho_fault,
            entering_s,
            unconfirmed_s,
        } = self;
        // The teeth belong to the told speed; a comb found blindly may be theirs.
        *teeth = config.teeth.filter(|_| said.is_some());
        // A told speed too low to be resolved is taken as it is: blindly, a comb of
        // something else would stand for it.
        let sought = SpeedFinderConfig {
            fs_hz: fs,
            band,
            told_hz: said,
            teeth: *teeth,
        };
        // Large: put there blank, and begun in its place.
        if finder.is_none() {
            *finder = Some(SpeedFinder::BLANK);
        }
        if finder.as_mut().is_none_or(|f| f.restart(&sought).is_err()) {
            *finder = None;
        }
        *lines = SpindleLines::new(&SpindleLinesConfig {
            teeth: *teeth,
            ..SpindleLinesConfig::new(fs, up_to_the_model(band, fs))
        })
        .ok();
        *tacho = config.tacho_pulses.and_then(|pulses| {
            Tacho::new(&TachoConfig {
                pulses_per_turn: pulses,
                ..TachoConfig::new(config.fs_hz)
            })
            .ok()
        });
        *setting = said.map(T::from_f64);
        *told = *setting;
        (*was_locked, *found_at_entry) = (false, false);
        *drift = Drift::default();
        (*found, *doubtful) = (None, None);
        *standing = DoubtfulComb::default();
        *moving = Moving::default();
        (*contradiction, *denied) = (None, 0);
        *low_hz = T::from_f64(band.low_hz);
        (*tacho_reading, *tacho_fault) = (None, None);
        *entering_s = T::ZERO;
        *unconfirmed_s = said.map(|_| T::ZERO);
    }

    /// A tacho pulse, `fraction` of a sample before input sample `sample`.
    pub(super) fn pulse(&mut self, sample: u64, fraction: T) {
        if let Some(tacho) = &mut self.tacho {
            tacho.pulse(sample, -fraction);
        }
    }

    /// Takes a decimated sample; gives what the rotation does not force.
    #[inline(always)]
    pub(super) fn process(&mut self, y: T) -> T {
        if let Some(finding) = self.finder.as_mut().and_then(|finder| finder.push(y)) {
            self.take(finding);
        }
        match &mut self.lines {
            Some(lines) => lines.process(y),
            None => y,
        }
    }

    /// A lock that is lost was lost because the speed has changed, and one that is caught
    /// while a cut begins is late.
    fn watch_lock(&mut self) {
        let locked = self.locked().is_some();
        if self.was_locked && !locked && self.told.is_some() {
            self.unconfirmed_s = Some(T::ZERO);
        }
        if locked && !self.was_locked && self.is_entering() {
            // Lines that are caught in the dip are drawn up to the speed slowly.
            self.entering_s = T::from_f64(ENTERING.0);
        }
        self.was_locked = locked;
    }

    /// A decision: time passes; `begins` says that a cut has just begun.
    pub(super) fn decide(&mut self, now: u64, cutting: bool, begins: bool, period_s: T) {
        if begins {
            // What denied the told speed was heard before the cut: a pump, the mains.
            (self.contradiction, self.denied) = (None, 0);
        }
        self.entering_s = if begins {
            T::from_f64(ENTERING.0)
        } else {
            (self.entering_s - period_s).max(T::ZERO)
        };
        if cutting {
            self.unconfirmed_s = self.unconfirmed_s.map(|t| t + period_s);
        }
        self.found = self
            .found
            .map(|(speed, age_s)| (speed, age_s + period_s))
            .filter(|(_, age_s)| *age_s < T::from_f64(FOUND_HOLD_S));
        self.doubtful = self
            .doubtful
            .map(|(speed, age_s)| (speed, age_s + period_s))
            .filter(|(_, age_s)| *age_s < T::from_f64(FOUND_HOLD_S));
        self.watch_lock();
        self.remove_standing(period_s);
        self.read_tacho(now);
        let speed = self.speed().map(|(speed, ..)| speed);
        self.drift.note(speed, period_s);
    }

    /// Multiple and power, input units squared, of every line that is removed.
    pub(super) fn removed(&self) -> impl Iterator<Item = (u32, T)> + '_ {
        let lines = self.lines.iter().flat_map(|lines| lines.lines());
        lines.map(|(multiple, amplitude)| (multiple, amplitude * amplitude * T::from_f64(0.5)))
    }

    /// The speed moves, or is in doubt, so that its lines come and go.
    pub(super) fn is_changing(&self) -> bool {
        self.is_entering() || self.rotation().doubt > T::from_f64(SPEED_ACCURACY)
    }

    /// A cut has just begun.
    pub(super) fn is_entering(&self) -> bool {
        self.entering_s > T::ZERO
    }

    /// A control tells another speed, Hz: it is the told one from now on. What differs by less
    /// than [`SPEED_ACCURACY`] from the last is no news, for the sound tells it better.
    pub(super) fn tell(&mut self, spindle_hz: T) {
        let accuracy = T::from_f64(SPEED_ACCURACY);
        let is_known = |told: T| (told - spindle_hz).abs() < told * accuracy;
        if self.setting.is_some_and(is_known) {
            return;
        }
        (self.setting, self.told) = (Some(spindle_hz), Some(spindle_hz));
        self.unconfirmed_s = Some(T::ZERO);
        (self.found, self.doubtful) = (None, None);
        (self.contradiction, self.denied) = (None, 0);
        if let Some(finder) = &mut self.finder {
            // Out of its range it keeps what it was told.
            let _ = finder.tell(Some(spindle_hz));
        }
        if self.tacho_reading.is_none() {
            self.lead(spindle_hz, spindle_hz * accuracy);
        }
    }

    /// A tacho leads the lines.
    fn read_tacho(&mut self, now: u64) {
        let Some(tacho) = &self.tacho else { return };
        let reading = tacho.read(now);
        self.tacho_fault = reading.fault;
        self.tacho_reading = reading.spindle_hz;
        if let Some((speed, sd)) = reading.spindle_hz {
            self.lead(speed, sd);
        }
    }

    /// The lines go to a speed that is known from elsewhere.
    fn lead(&mut self, speed: T, sd: T) {
        let Some(lines) = &mut self.lines else { return };
        let followed = lines
            .spindle_hz()
            .filter(|(there, _)| (*there - speed).abs() < speed * T::from_f64(UNCONFIRMED.1));
        match followed {
            Some(_) => lines.measure_speed(speed, sd),
            None => lines.start(speed, sd),
        }
    }

    /// Speed by the tacho, Hz.
    pub(super) fn by_tacho(&self) -> Option<T> {
        self.tacho_reading.map(|(hz, _)| hz)
    }

    /// Speed of the lines that are removed, Hz, where nobody tells one.
    pub(super) fn by_sound_alone(&self) -> Option<T> {
        self.locked().map(|(hz, _)| hz).filter(|_| !self.is_told())
    }

    /// The speed that a setting tells, Hz, and the sound has not denied.
    pub(super) fn by_setting(&self) -> Option<T> {
        self.setting.filter(|_| !self.is_denied())
    }

    /// Somebody tells the speed: a setting that the sound has not denied, or the tacho.
    pub(super) fn is_told(&self) -> bool {
        self.by_setting().is_some() || self.tacho_reading.is_some()
    }

    /// The lines are removed, those of a comb in doubt, too.
    pub(super) fn is_locked(&self) -> bool {
        let lines = self.lines.as_ref();
        lines.is_some_and(|lines| lines.lock() == Lock::Locked)
    }

    /// The lines are there and are removed.
    fn locked(&self) -> Option<(T, T)> {
        let lines = self.lines.as_ref().filter(|lines| !lines.are_slow())?;
        (lines.lock() == Lock::Locked)
            .then(|| lines.spindle_hz())
            .flatten()
    }

    /// For the report.
    pub(super) fn report(&self) -> SpindleReport<T> {
        let speed = self.speed();
        let locked = self.is_locked();
        let lines = self.lines.as_ref().filter(|_| locked);
        SpindleReport {
            spindle_hz: speed.map(|(hz, _, _)| hz),
            source: speed.map_or(SpeedSource::Unknown, |(_, _, source)| source),
            locked,
            removed_power: lines.map_or(T::ZERO, |lines| lines.power()),
            notch_hz: lines.map_or(T::ZERO, |lines| lines.notch_hz()),
            contradiction: self.contradiction,
            tacho_fault: self.tacho_fault,
        }
    }
}
