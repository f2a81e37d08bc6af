//! Where modes with damping have been: what a mode can lose its damping from.
//!
//! Rate: decision rate. The memory goes by frequency and not by pole pair, because pole
//! pairs change their modes, often just when a mode loses its damping.

use super::config::AlarmConfig;
use super::sequential::USUAL_RATIO;
use crate::real::Real;

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
#[derive(Debug, Clone, Copy)]
struct Place<T> {
    frequency: T,
    usual_damping: T,
    /// Mean square at the mode, input units.
    usual_power: T,
    seen_s: T,
    /// Mean of the damping, and over how long, s.
    mean_damping: T,
    known_s: T,
    missed_s: T,
    /// It rose by itself, this long ago, s.
    rose_s: Option<T>,
}

impl<T: Real> Place<T> {
    /// Known for long, and for a low damping.
    fn is_low(&self, config: &AlarmConfig<T>) -> bool {
        self.known_s >= T::from_f64(MEAN_S)
            && self.mean_damping < config.threshold * T::from_f64(LOW)
    }
}

/// How loud a mode is that is seen.
#[derive(Debug, Clone, Copy)]
pub struct Sight<T> {
    /// Its part of what nothing explains; 0 for one that is explained.
    pub share: T,
    /// Its part of what is left when the spindle's lines are removed; 0 where another pole
    /// pair at the same place has less damping.
    pub part: T,
    /// Mean square at it, input units.
    pub power: T,
}

/// The modes that have been seen with damping.
#[derive(Debug, Clone)]
pub struct Places<T> {
    places: [Option<Place<T>>; PLACES],
}

impl<T: Real> Default for Places<T> {
    fn default() -> Self {
        Self {
            places: [None; PLACES],
        }
    }
}

impl<T: Real> Places<T> {
    /// Time passes.
    pub fn age(&mut self, period_s: T) {
        for place in &mut self.places {
            if let Some(there) = place {
                there.missed_s += period_s;
                there.rose_s = there
                    .rose_s
                    .map(|age_s| age_s + period_s)
                    .filter(|age_s| *age_s < T::from_f64(ROSE_S));
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
        let (least, most) = DAMPED;
        let seen = T::from_f64(SEEN_SHARE);
        let real = damping < T::from_f64(most);
        if real && sight.part >= seen && damping > config.threshold * T::from_f64(SOME) {
            self.average(frequency, damping, sight.power, config, period_s);
        }
        let damped = damping > config.threshold * T::from_f64(least);
        if !(real && damped && sight.share >= seen) {
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
            return;
        }
        self.remember(Place {
            frequency,
            usual_damping: usual,
            usual_power: power,
            seen_s: period_s,
            mean_damping: T::ZERO,
            known_s: T::ZERO,
            missed_s: T::ZERO,
            rose_s: None,
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
            place.missed_s = T::ZERO;
        } else {
            self.remember(Place {
                frequency,
                usual_damping: config.threshold * T::from_f64(2.0),
                usual_power: power,
                seen_s: T::ZERO,
                mean_damping: damping,
                known_s: period_s,
                missed_s: T::ZERO,
                rose_s: None,
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

    /// A line at this frequency has risen by itself just now.
    pub fn rose(&mut self, frequency: T, config: &AlarmConfig<T>) {
        if let Some(there) = self.at_mut(frequency) {
            there.rose_s = Some(T::ZERO);
            there.missed_s = T::ZERO;
            return;
        }
        self.remember(Place {
            frequency,
            usual_damping: config.threshold * T::from_f64(2.0),
            usual_power: T::ZERO,
            seen_s: T::ZERO,
            mean_damping: T::ZERO,
            known_s: T::ZERO,
            missed_s: T::ZERO,
            rose_s: Some(T::ZERO),
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

    /// A line rose here by itself within the last second.
    pub fn has_risen(&self, frequency: T) -> bool {
        self.at(frequency)
            .is_some_and(|there| there.rose_s.is_some())
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
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;

    fn watch(places: &mut Places<f64>, f: f64, zeta: f64, share: f64, seconds: f64) {
        let config = AlarmConfig::default();
        for _ in 0..(seconds / PERIOD_S) as usize {
            places.age(PERIOD_S);
            let sight = Sight {
                share,
                part: share,
                power: 1.0,
            };
            places.see(f, zeta, &sight, &config, PERIOD_S);
        }
    }

    #[test]
    fn a_mode_is_known_by_the_damping_it_had() {
        let config = AlarmConfig::default();
        let mut places = Places::default();
        watch(&mut places, 980.0, 0.04, 0.5, 0.1);
        assert!(!places.has_grown(980.0, 9.0), "too short");
        watch(&mut places, 980.0, 0.04, 0.5, 1.0);
        assert!(places.has_grown(1000.0, 4.1) && !places.has_grown(1000.0, 3.9));
        assert!(!places.has_grown(1030.0, 9.0), "another place");
        assert!((places.usual_damping(975.0, &config) - 0.04).abs() < 1e-9);
        assert_eq!(places.usual_damping(700.0, &config), 0.02);
        // Undamped it is remembered as it was, for a while.
        watch(&mut places, 980.0, 0.001, 0.9, 4.0);
        assert!(places.has_grown(980.0, 9.0));
        watch(&mut places, 980.0, 0.001, 0.9, 2.0);
        assert!(!places.has_grown(980.0, 9.0));
    }

    #[test]
    fn a_mode_of_low_damping_is_undamped_at_a_third_of_it() {
        let config = AlarmConfig::default();
        let mut places = Places::default();
        assert_eq!(places.threshold(980.0, &config), 0.01);
        watch(&mut places, 980.0, 0.009, 0.5, 0.4);
        assert_eq!(places.threshold(980.0, &config), 0.01, "too short");
        watch(&mut places, 980.0, 0.009, 0.5, 1.0);
        assert!((places.threshold(990.0, &config) - 0.003).abs() < 1e-9);
        assert!((places.usual_damping(990.0, &config) - 0.009).abs() < 1e-9);
        // What reads like a chatter does not make it lower, however long it lasts.
        watch(&mut places, 980.0, 0.0005, 0.9, 4.0);
        assert!((places.threshold(980.0, &config) - 0.003).abs() < 1e-9);
        // A mode with damping keeps the setting.
        watch(&mut places, 500.0, 0.04, 0.5, 1.0);
        assert_eq!(places.threshold(500.0, &config), 0.01);
    }

    #[test]
    fn lines_ghosts_and_whispers_are_no_modes() {
        let mut places = Places::default();
        watch(&mut places, 500.0, 0.001, 0.9, 2.0);
        watch(&mut places, 700.0, 0.5, 0.9, 2.0);
        watch(&mut places, 900.0, 0.03, 0.01, 2.0);
        watch(&mut places, f64::NAN, f64::NAN, f64::NAN, 2.0);
        for f in [500.0, 700.0, 900.0, f64::NAN] {
            assert!(!places.has_grown(f, 1e9));
        }
        // More modes than places: the one unseen for longest goes.
        for k in 0..12 {
            watch(&mut places, 300.0 * 1.1f64.powi(k), 0.03, 0.5, 0.3);
        }
        assert!(!places.has_grown(300.0, 9.0));
        assert!(places.has_grown(300.0 * 1.1f64.powi(11), 9.0));
    }

    #[test]
    fn a_line_that_rose_is_remembered_for_a_second() {
        let mut places = Places::<f64>::default();
        places.rose(900.0, &AlarmConfig::default());
        assert!(places.has_risen(905.0) && !places.has_risen(950.0));
        assert!(!places.has_grown(900.0, 1e9), "it was never damped");
        for _ in 0..520 {
            places.age(PERIOD_S);
        }
        assert!(!places.has_risen(905.0));
    }
}
