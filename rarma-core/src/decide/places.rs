//! Where modes with damping have been: what a mode can lose its damping from.
//!
//! Rate: decision rate. The memory goes by frequency and not by pole pair, because pole
//! pairs change their modes, often just when a mode loses its damping.

use super::config::AlarmConfig;
use super::sequential::USUAL_RATIO;
use crate::real::Real;
use crate::visit::state;

/// Places that are remembered.
const PLACES: usize = 8;
/// Half-width of a place, as a part of its frequency.
const WIDTH: f64 = 0.03;
/// Memory of a mode's usual damping, s.
const USUAL_TAU_S: f64 = 1.0;
/// Seen damped for this long, s, a mode has damping that it can lose.
const WATCHED_S: f64 = 0.2;
/// Not seen damped for this long, s, it is forgotten.
const FORGET_S: f64 = 5.0;
/// That a line rose by itself is remembered for this long, s.
const ROSE_S: f64 = 1.0;
/// A mode that has lost its damping is louder than it was by this factor, in power.
const GROWN: f64 = 4.0;
/// An undamped mode counts as a change if it was seen damped before for at least this long, s, or
/// if its power is now this many times (3 dB) what it was while it was damped …
const LONG_S: f64 = 0.8;
const LOUDER: f64 = 2.0;
/// … and, if it has always had little damping, only if its power is this many times its mean.
/// Noise alone exceeds that in one of 10⁶ independent moments; because the mean is that of a few
/// moments only, in one of some hundreds.
const BURST: f64 = 14.0;
/// Not seen damped for so long, s, by any pole pair, a mode has lost its damping.
const GONE_S: f64 = 0.05;
/// What is left in the signal has changed: for so long, s, its modes read as they were.
const RELEARN_S: f64 = 0.8;
/// A mode counts as seen where it holds this part of the band's power.
const SEEN_SHARE: f64 = 0.05;
/// Damping above which it has some for certain, in thresholds, and above which a pole
/// pair is no mode, as a ratio.
const DAMPED: (f64, f64) = (1.5, 0.2);

/// Damping, in thresholds, above which a mode has some, to be averaged; the memory of that
/// mean, s, and for how long it is gathered before it counts, s.
const SOME: f64 = 0.2;
const MEAN_TAU_S: f64 = 2.0;
const MEAN_S: f64 = 0.5;
/// Below this mean, in thresholds, a mode is one of low damping: a third of it is less than
/// the threshold.
const LOW: f64 = 3.0;

/// One remembered mode.
#[derive(Debug, Clone, Copy, Default)]
struct Place<T> {
    frequency: T,
    usual_damping: T,
    /// Mean square at the mode, input units.
    usual_power: T,
    seen_s: T,
    /// Means of the damping and of the power, and over how long, s.
    mean_damping: T,
    mean_power: T,
    known_s: T,
    missed_s: T,
    /// Seen damped this long ago, s.
    damped_s: T,
    /// It rose by itself, this long ago, s, and whether clearly so.
    rose: Option<(T, bool)>,
}

state! { Place<T> {
    frequency, usual_damping, usual_power, seen_s, mean_damping, mean_power, known_s,
    missed_s, damped_s, rose
} }

impl<T: Real> Place<T> {
    /// A place of which nothing is known but that something is there, of this power.
    fn unknown(frequency: T, power: T, config: &AlarmConfig<T>) -> Self {
        Self {
            frequency,
            usual_damping: config.threshold * T::from_f64(2.0),
            usual_power: power,
            seen_s: T::ZERO,
            mean_damping: T::ZERO,
            mean_power: power,
            known_s: T::ZERO,
            missed_s: T::ZERO,
            damped_s: T::from_f64(FORGET_S),
            rose: None,
        }
    }

    /// Known for long, and for a low damping.
    fn is_low(&self, config: &AlarmConfig<T>) -> bool {
        self.is_known_below(LOW, config)
    }

    fn is_known_below(&self, thresholds: f64, config: &AlarmConfig<T>) -> bool {
        self.known_s >= T::from_f64(MEAN_S)
            && self.mean_damping < config.threshold * T::from_f64(thresholds)
    }
}

/// How loud a mode is that is seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight<T> {
    /// Its part of what nothing explains; 0 for one that is explained.
    pub share: T,
    /// Its part of what is left when the spindle's lines are removed; 0 where another pole
    /// pair at the same place has less damping.
    pub part: T,
    /// Mean square at it, input units.
    pub power: T,
    /// Its amplitude stays: whatever it reads, it is a line and no damped mode.
    pub is_steady: bool,
}

/// The modes that have been seen with damping.
#[derive(Debug, Clone)]
pub(crate) struct Places<T> {
    places: [Option<Place<T>>; PLACES],
    /// Nothing is learnt for so long, s.
    deaf_s: T,
}

state! { Places<T> { places, deaf_s } }

impl<T: Real> Default for Places<T> {
    fn default() -> Self {
        Self {
            places: [None; PLACES],
            deaf_s: T::ZERO,
        }
    }
}

impl<T: Real> Places<T> {
    /// What is left in the signal has changed, for lines are removed from now on: what the
    /// modes beside them read says nothing any more, nor does it until the model has followed.
    pub fn begin_anew(&mut self) {
        self.places = [None; PLACES];
        self.deaf_s = T::from_f64(RELEARN_S);
    }

    /// Time passes.
    pub fn age(&mut self, period_s: T) {
        self.deaf_s = (self.deaf_s - period_s).max(T::ZERO);
        for place in &mut self.places {
            if let Some(there) = place {
                there.missed_s += period_s;
                there.damped_s += period_s;
                there.rose = there
                    .rose
                    .map(|(age_s, clearly)| (age_s + period_s, clearly))
                    .filter(|(age_s, _)| *age_s < T::from_f64(ROSE_S));
                if there.missed_s > T::from_f64(FORGET_S) {
                    *place = None;
                }
            }
        }
    }

    /// A mode as it reads now; undamped, quiet and unreal ones teach nothing.
    pub fn see(
        &mut self,
        frequency: T,
        damping: T,
        sight: &Sight<T>,
        config: &AlarmConfig<T>,
        period_s: T,
    ) {
        if self.deaf_s > T::ZERO {
            return;
        }
        let (least, most) = DAMPED;
        let seen = T::from_f64(SEEN_SHARE);
        let real = damping < T::from_f64(most);
        if real && sight.part >= seen && damping > config.threshold * T::from_f64(SOME) {
            self.average(frequency, damping, sight.power, config, period_s);
        }
        let damped = damping > config.threshold * T::from_f64(least);
        if !(real && damped && sight.share >= seen) || sight.is_steady {
            return;
        }
        let power = sight.power;
        let usual = damping.min(config.threshold * T::from_f64(USUAL_RATIO));
        if let Some(there) = self.at_mut(frequency) {
            there.seen_s = (there.seen_s + period_s).min(T::from_f64(USUAL_TAU_S));
            let gain = (period_s / there.seen_s).min(T::ONE);
            there.usual_damping += gain * (usual - there.usual_damping);
            there.usual_power += gain * (power - there.usual_power);
            there.frequency += gain * (frequency - there.frequency);
            there.missed_s = T::ZERO;
            there.damped_s = T::ZERO;
            return;
        }
        self.remember(Place {
            usual_damping: usual,
            seen_s: period_s,
            damped_s: T::ZERO,
            ..Place::unknown(frequency, power, config)
        });
    }

    /// The mean damping of a mode, of all readings that are more than a chatter's.
    fn average(
        &mut self,
        frequency: T,
        damping: T,
        power: T,
        config: &AlarmConfig<T>,
        period_s: T,
    ) {
        if let Some(place) = self.at_mut(frequency) {
            place.known_s = (place.known_s + period_s).min(T::from_f64(MEAN_TAU_S));
            let gain = (period_s / place.known_s).min(T::ONE);
            place.mean_damping += gain * (damping - place.mean_damping);
            place.mean_power += gain * (power - place.mean_power);
            place.missed_s = T::ZERO;
        } else {
            self.remember(Place {
                mean_damping: damping,
                known_s: period_s,
                ..Place::unknown(frequency, power, config)
            });
        }
    }

    /// Damping ratio below which a mode here counts as undamped: the threshold, or a third of
    /// its mean where that is less. A slender tool far below its limit has 1 %, and reads
    /// half of it now and then; that is no news.
    pub fn threshold(&self, frequency: T, config: &AlarmConfig<T>) -> T {
        self.at(frequency)
            .filter(|there| there.is_low(config))
            .map_or(config.threshold, |there| {
                config.threshold.min(there.mean_damping / T::from_f64(LOW))
            })
    }

    /// A line at this frequency has risen by itself just now; `clearly`, if more than by
    /// chance.
    pub fn rose(&mut self, frequency: T, clearly: bool, config: &AlarmConfig<T>) {
        if let Some(there) = self.at_mut(frequency) {
            let was = there.rose.is_some_and(|(_, clearly)| clearly);
            there.rose = Some((T::ZERO, clearly || was));
            there.missed_s = T::ZERO;
            return;
        }
        self.remember(Place {
            rose: Some((T::ZERO, clearly)),
            ..Place::unknown(frequency, T::ZERO, config)
        });
    }

    /// In the place of the one that was not seen for longest.
    fn remember(&mut self, new: Place<T>) {
        let mut stalest: Option<&mut Option<Place<T>>> = None;
        for place in &mut self.places {
            let age = |p: &Option<Place<T>>| p.map_or(T::from_f64(1e9), |p| p.missed_s);
            if stalest.as_ref().is_none_or(|s| age(place) > age(s)) {
                stalest = Some(place);
            }
        }
        if let Some(place) = stalest {
            *place = Some(new);
        }
    }

    /// The damping ratio that a mode here usually has; two thresholds where none is
    /// known.
    pub fn usual_damping(&self, frequency: T, config: &AlarmConfig<T>) -> T {
        let unknown = config.threshold * T::from_f64(2.0);
        let Some(there) = self.at(frequency) else {
            return unknown;
        };
        if there.is_low(config) {
            there.mean_damping
        } else if there.seen_s >= T::from_f64(WATCHED_S) {
            there.usual_damping
        } else {
            unknown
        }
    }

    /// A mode was seen here with damping that it can have lost, and its power has grown
    /// by 6 dB since.
    pub fn has_grown(&self, frequency: T, power: T) -> bool {
        self.at(frequency).is_some_and(|there| {
            there.seen_s >= T::from_f64(WATCHED_S) && power > there.usual_power * T::from_f64(GROWN)
        })
    }

    /// That a mode is undamped here is news: it was seen with damping for long, or is louder
    /// than it was with it; or a line rose by itself, clearly; or idle was heard without it.
    /// A mode that has always had little damping is loud now and then.
    pub fn is_news(
        &self,
        frequency: T,
        power: T,
        idle_known: bool,
        config: &AlarmConfig<T>,
    ) -> bool {
        let Some(there) = self.at(frequency) else {
            return idle_known;
        };
        if there.is_known_below(DAMPED.0, config) {
            return power > there.mean_power * T::from_f64(BURST);
        }
        let louder = power > there.usual_power * T::from_f64(LOUDER);
        let watched = there.seen_s >= T::from_f64(WATCHED_S);
        let long = there.seen_s >= T::from_f64(LONG_S);
        let rose = there.rose.is_some_and(|(_, clearly)| clearly);
        idle_known || long || (watched && louder) || rose
    }

    /// A mode was seen here with damping for long and is no louder than it was with it: it has
    /// lost that damping itself. A line that had come up beside it would add its power, four
    /// times the mode's for the two to read undamped. Not while another pole pair there is the
    /// damped mode.
    pub fn keeps_its_power(&self, frequency: T, power: T) -> bool {
        self.at(frequency).is_some_and(|there| {
            there.seen_s >= T::from_f64(LONG_S)
                && there.damped_s >= T::from_f64(GONE_S)
                && power < there.usual_power * T::from_f64(LOUDER)
        })
    }

    /// A line rose here by itself within the last second.
    pub fn has_risen(&self, frequency: T) -> bool {
        self.at(frequency).is_some_and(|there| there.rose.is_some())
    }

    fn at(&self, frequency: T) -> Option<&Place<T>> {
        self.places
            .iter()
            .flatten()
            .find(|there| is_near(there, frequency))
    }

    fn at_mut(&mut self, frequency: T) -> Option<&mut Place<T>> {
        self.places
            .iter_mut()
            .flatten()
            .find(|there| is_near(there, frequency))
    }
}

fn is_near<T: Real>(there: &Place<T>, frequency: T) -> bool {
    (frequency - there.frequency).abs() < there.frequency * T::from_f64(WIDTH)
}

#[cfg(test)]
#[path = "places_tests.rs"]
mod tests;
