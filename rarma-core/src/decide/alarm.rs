//! The verdict: threshold on ζ with hysteresis, and the alarm it raises.
//!
//! Rate: decision rate. The rule of the first verdict, in words: a mode is
//! *undamped* where ζ lies below the threshold, the more so the more standard
//! deviations it lies below, and *loud* where it holds a good part of the band's power. Undamped, loud, not
//! explained by the rotation, and that for a while: chatter. It is over when the
//! damping is back for certain, or the vibration has gone. In between nothing
//! changes: a limit cycle that the spindle modulates reads several percent at
//! times, and is chatter all the same.

use super::mode::{Label, Mode};
use crate::condition::Fault;
use crate::real::Real;
use serde::{Deserialize, Serialize};

/// What the monitor believes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// Not enough signal yet.
    Starting,
    /// Nothing is being cut.
    Idle,
    /// Cutting; every mode is damped.
    Stable,
    /// A mode is losing its damping.
    Warning,
    /// Chatter.
    Chatter,
    /// The samples cannot be trusted.
    Invalid,
}

/// Why the monitor believes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reason {
    /// Nothing to remark.
    None,
    /// The estimator is in its start-up.
    EstimatorStarting,
    /// The roots are being searched for anew.
    RootsLost,
    /// The level is that of idle.
    LevelAtIdle,
    /// A mode is undamped and loud, for too short a time to be called.
    Undamped,
    /// At its present rate a mode reaches the threshold soon.
    LosingDamping,
    /// A mode is undamped but sits on a multiple of the rotation.
    ForcedOnly,
    /// The samples are bad, see the fault.
    Samples(Fault),
}

/// Settings of the verdict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlarmConfig<T> {
    /// Damping ratio below which a mode counts as undamped, 0.0005..=0.2,
    /// default 0.01.
    pub threshold: T,
    /// The alarm is released by damping only when ζ minus one standard deviation
    /// is above this multiple of the threshold. Default 4.
    pub release_ratio: T,
    /// Least part of the band's power at the mode, 0..=1, default 0.25.
    pub loud_share: T,
    /// Undamped (for certain, by a standard deviation) and loud for this long is
    /// chatter, s; longer where it is less certain. Default 0.06.
    pub confirm_s: T,
    /// Damped or gone for this long ends it, s. Default 0.15.
    pub release_s: T,
    /// Gone: the amplitude is below this part of its mean over the alarm. Default
    /// 0.2 (−14 dB).
    pub gone_ratio: T,
    /// Warn when a mode would reach the threshold within this time at its present
    /// gradient, s. Default 0.3.
    pub warn_ahead_s: T,
}

impl<T: Real> Default for AlarmConfig<T> {
    fn default() -> Self {
        Self {
            threshold: T::from_f64(0.01),
            release_ratio: T::from_f64(4.0),
            loud_share: T::from_f64(0.25),
            confirm_s: T::from_f64(0.06),
            release_s: T::from_f64(0.15),
            gone_ratio: T::from_f64(0.2),
            warn_ahead_s: T::from_f64(0.3),
        }
    }
}

impl<T: Real> AlarmConfig<T> {
    /// ζ + sd below the threshold, and ζ not below −2 thresholds: no vibration grows
    /// that fast for long (ζ = −2 % at 1 kHz is a factor of ten in 18 ms), so a model
    /// that says so has not settled.
    pub fn undamped(&self, damping: (T, T)) -> bool {
        // NaN compares false: never undamped.
        damping.0 + damping.1 < self.threshold && damping.0 > -(self.threshold + self.threshold)
    }

    /// How sure it is that the mode is undamped: (threshold − ζ)/sd, limited to −1..=1;
    /// −1 for a ζ that is not credible.
    pub fn evidence(&self, damping: (T, T)) -> T {
        let (zeta, sd) = damping;
        let credible = zeta > -(self.threshold + self.threshold) && sd.is_finite();
        if !credible {
            return -T::ONE;
        }
        let sd = sd.max(self.threshold * T::from_f64(0.05));
        ((self.threshold - zeta) / sd).clamp(-T::ONE, T::ONE)
    }

    /// ζ − sd above the release threshold: damped for certain. An alarm that has not
    /// been `established` is released at 1.5 thresholds already.
    pub fn damped(&self, damping: (T, T), established: bool) -> bool {
        let ratio = if established {
            self.release_ratio
        } else {
            T::from_f64(1.5)
        };
        damping.0 - damping.1 > self.threshold * ratio
    }

    /// ζ − sd below twice the threshold: the mode may be a line without damping of
    /// its own. A tone reads ζ ≈ 0.0003, and 0.006 in noise of its own power.
    pub fn may_be_line(&self, damping: (T, T)) -> bool {
        damping.0 - damping.1 < self.threshold * T::from_f64(2.0)
    }

    /// The mode holds enough of the band's power.
    pub fn loud(&self, share: T) -> bool {
        share >= self.loud_share
    }
}

/// The standing alarm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing<T> {
    /// Place of the mode among the tracked ones.
    pub slot: usize,
    /// Power-weighted mean frequency since the call, Hz.
    pub frequency: T,
    /// Lowest damping ratio since the call.
    pub lowest_damping: T,
    mean_amplitude: T,
    weight: T,
    over_s: T,
    explained_s: T,
    undamped_s: T,
}

/// Undamped for this long in all, an alarm is established, s: it then holds through
/// damping that is smeared by modulation.
pub const ESTABLISHED_S: f64 = 0.5;

impl<T: Real> Standing<T> {
    /// The mode has been undamped for [`ESTABLISHED_S`] in all.
    pub fn is_established(&self) -> bool {
        self.undamped_s >= T::from_f64(ESTABLISHED_S)
    }
}

/// What happened to the alarm in one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlarmEvent<T> {
    /// Nothing.
    None,
    /// Called: mode frequency (Hz) and damping ratio.
    On {
        /// Frequency of the mode, Hz.
        frequency: T,
        /// Its damping ratio.
        damping: T,
    },
    /// Released: mean frequency (Hz) and lowest damping ratio while it stood.
    Off {
        /// Power-weighted mean frequency, Hz.
        frequency: T,
        /// Lowest damping ratio.
        lowest_damping: T,
    },
}

/// Raises and releases the alarm.
#[derive(Debug, Clone)]
pub struct Alarm<T> {
    config: AlarmConfig<T>,
    standing: Option<Standing<T>>,
    /// The alarm before, and for how long it is still remembered, s.
    before: Option<(Standing<T>, T)>,
}

/// Memory of the mean amplitude while an alarm stands, s.
const AMPLITUDE_TAU_S: f64 = 1.0;
/// On a multiple of the speed for this long, the alarm was a forced line, s; half
/// of it for an alarm that is not established.
const EXPLAINED_S: f64 = 1.0;
/// The alarm's mode may jump this far (relative) to another place and is still it.
const SAME_MODE: f64 = 0.03;

/// After a release, the same mode is called again only if it is louder than what
/// rings on, for this long, s.
const AFTERGLOW_S: f64 = 1.0;

/// The mode is where the alarm is.
fn is_near<T: Real>(alarm: &Standing<T>, mode: &Mode<T>) -> bool {
    (mode.frequency - alarm.frequency).abs() < alarm.frequency * T::from_f64(SAME_MODE)
}

impl<T: Real> Alarm<T> {
    /// No alarm.
    pub fn new(config: AlarmConfig<T>) -> Self {
        Self {
            config,
            standing: None,
            before: None,
        }
    }

    /// The alarm that stands, if one does.
    pub fn standing(&self) -> Option<&Standing<T>> {
        self.standing.as_ref()
    }

    /// One decision over the modes (with the time each has been suspect, s).
    /// `may_call` is false while nothing is cut or the samples are bad.
    pub fn update(
        &mut self,
        modes: &[Option<(Mode<T>, T)>],
        may_call: bool,
        period_s: T,
    ) -> AlarmEvent<T> {
        self.before = self
            .before
            .map(|(alarm, left_s)| (alarm, left_s - period_s))
            .filter(|(_, left_s)| *left_s > T::ZERO);
        match self.standing {
            Some(standing) => self.follow(standing, modes, period_s),
            None if may_call => self.call(modes),
            None => AlarmEvent::None,
        }
    }

    /// Loudest mode that has been suspect for long enough.
    fn call(&mut self, modes: &[Option<(Mode<T>, T)>]) -> AlarmEvent<T> {
        let mut loudest: Option<(usize, &Mode<T>)> = None;
        for (slot, mode) in modes.iter().enumerate() {
            if let Some((mode, suspicion)) = mode
                && *suspicion >= self.config.confirm_s
                && !self.is_afterglow(mode)
                && loudest.is_none_or(|(_, m)| mode.amplitude > m.amplitude)
            {
                loudest = Some((slot, mode));
            }
        }
        let Some((slot, mode)) = loudest else {
            return AlarmEvent::None;
        };
        self.standing = Some(Standing {
            slot,
            frequency: mode.frequency,
            lowest_damping: mode.damping,
            mean_amplitude: mode.amplitude,
            weight: mode.amplitude * mode.amplitude,
            over_s: T::ZERO,
            explained_s: T::ZERO,
            undamped_s: self.config.confirm_s,
        });
        AlarmEvent::On {
            frequency: mode.frequency,
            damping: mode.damping,
        }
    }

    /// What is left of a vibration that has just been released: the same mode, and
    /// no louder than when it was called gone.
    fn is_afterglow(&self, mode: &Mode<T>) -> bool {
        self.before.is_some_and(|(alarm, _)| {
            is_near(&alarm, mode)
                && mode.amplitude < alarm.mean_amplitude * self.config.gone_ratio * T::from_f64(2.0)
        })
    }

    fn follow(
        &mut self,
        mut s: Standing<T>,
        modes: &[Option<(Mode<T>, T)>],
        period_s: T,
    ) -> AlarmEvent<T> {
        s.slot = self.locate(&s, modes);
        let mode = modes.get(s.slot).copied().flatten().map(|(mode, _)| mode);
        let over = match mode {
            None => true,
            Some(mode) => {
                let damping = (mode.damping, mode.damping_sd);
                if self.config.undamped(damping) {
                    s.undamped_s += period_s;
                }
                let damped = self.config.damped(damping, s.is_established());
                let gone = mode.amplitude < s.mean_amplitude * self.config.gone_ratio;
                if !damped && !gone {
                    let gain = (period_s / T::from_f64(AMPLITUDE_TAU_S)).min(T::ONE);
                    s.mean_amplitude += gain * (mode.amplitude - s.mean_amplitude);
                    let w = mode.amplitude * mode.amplitude;
                    s.weight += w;
                    if s.weight > T::ZERO {
                        s.frequency += (mode.frequency - s.frequency) * (w / s.weight);
                    }
                    if self.config.undamped(damping) {
                        s.lowest_damping = s.lowest_damping.min(mode.damping);
                    }
                }
                damped || gone
            }
        };
        // A chatter frequency may drift through a multiple of the speed; one that
        // stays on it was a forced line all along.
        s.explained_s = match mode {
            Some(mode) if mode.harmonic.is_some() => s.explained_s + period_s,
            _ => T::ZERO,
        };
        let patience = if s.is_established() {
            T::from_f64(EXPLAINED_S)
        } else {
            T::from_f64(0.5 * EXPLAINED_S)
        };
        let explained = s.explained_s > patience;
        s.over_s = if over { s.over_s + period_s } else { T::ZERO };
        if s.over_s < self.config.release_s && !explained {
            self.standing = Some(s);
            return AlarmEvent::None;
        }
        self.standing = None;
        self.before = Some((s, T::from_f64(AFTERGLOW_S)));
        AlarmEvent::Off {
            frequency: s.frequency,
            lowest_damping: s.lowest_damping,
        }
    }

    /// Ends a standing alarm: nothing can be heard any more.
    pub fn release(&mut self) -> AlarmEvent<T> {
        match self.standing.take() {
            Some(s) => AlarmEvent::Off {
                frequency: s.frequency,
                lowest_damping: s.lowest_damping,
            },
            None => AlarmEvent::None,
        }
    }

    /// The alarm's mode keeps its place; if that place has gone elsewhere, the
    /// loudest mode close to the alarm's frequency takes over.
    fn locate(&self, s: &Standing<T>, modes: &[Option<(Mode<T>, T)>]) -> usize {
        let near = |mode: &Mode<T>| is_near(s, mode);
        let mut best = s.slot;
        let mut loudness = match modes.get(s.slot) {
            Some(Some((mode, _))) if near(mode) => mode.amplitude,
            _ => T::ZERO,
        };
        for (slot, mode) in modes.iter().enumerate() {
            if let Some((mode, _)) = mode
                && near(mode)
                && mode.amplitude > loudness * T::from_f64(1.5)
            {
                best = slot;
                loudness = mode.amplitude;
            }
        }
        best
    }

    /// Puts the verdict into a word: the state and why.
    pub fn judge(&self, modes: &[Option<(Mode<T>, T)>], cutting: bool) -> (State, Reason) {
        if self.standing.is_some() {
            return (State::Chatter, Reason::None);
        }
        if !cutting {
            return (State::Idle, Reason::LevelAtIdle);
        }
        let mut forced = false;
        let mut losing = false;
        for (mode, suspicion) in modes.iter().flatten() {
            if *suspicion > T::ZERO {
                return (State::Warning, Reason::Undamped);
            }
            let c = &self.config;
            let undamped = c.undamped((mode.damping, mode.damping_sd));
            forced |= mode.label == Label::Forced && undamped;
            let ahead = mode.damping + mode.gradient * c.warn_ahead_s;
            losing |= mode.label != Label::Forced
                && c.loud(mode.share)
                && mode.damping < c.threshold * c.release_ratio
                && ahead < c.threshold;
        }
        if losing {
            (State::Warning, Reason::LosingDamping)
        } else if forced {
            (State::Stable, Reason::ForcedOnly)
        } else {
            (State::Stable, Reason::None)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::{ModeTrack, Reading};

    const PERIOD_S: f64 = 0.002;

    /// One track, one alarm, fed with readings of a mode at 900 Hz.
    struct Bench {
        track: ModeTrack<f64>,
        alarm: Alarm<f64>,
        now_s: f64,
    }

    impl Bench {
        fn new() -> Self {
            Self {
                track: ModeTrack::default(),
                alarm: Alarm::new(AlarmConfig::default()),
                now_s: 0.0,
            }
        }

        fn reading(damping: f64, share: f64, amplitude: f64) -> Reading<f64> {
            Reading {
                frequency: (900.0, 0.5),
                damping: (damping, 0.001),
                amplitude,
                share,
                harmonic: None,
                overtone: false,
                in_band: true,
            }
        }

        /// Feeds a reading for some seconds; the time of the first event, and it.
        fn feed(
            &mut self,
            reading: &Reading<f64>,
            seconds: f64,
            may_call: bool,
        ) -> Option<(f64, AlarmEvent<f64>)> {
            let mut first = None;
            for _ in 0..(seconds / PERIOD_S) as usize {
                self.now_s += PERIOD_S;
                let mode = self
                    .track
                    .update(reading, &AlarmConfig::default(), PERIOD_S);
                let modes = [Some((mode, self.track.suspicion_s()))];
                let event = self.alarm.update(&modes, may_call, PERIOD_S);
                if event != AlarmEvent::None && first.is_none() {
                    first = Some((self.now_s, event));
                }
            }
            first
        }
    }

    #[test]
    fn calls_after_the_confirmation_and_holds_through_smeared_damping() {
        let mut bench = Bench::new();
        assert_eq!(bench.feed(&Bench::reading(0.03, 0.5, 1.0), 1.0, true), None);
        let (t, event) = bench
            .feed(&Bench::reading(0.004, 0.8, 2.0), 0.6, true)
            .expect("called");
        assert!((1.055..1.07).contains(&t), "called at {t}");
        assert!(matches!(event, AlarmEvent::On { .. }));
        // 3.5 % is above the threshold, but not damped for certain.
        assert_eq!(
            bench.feed(&Bench::reading(0.035, 0.4, 1.0), 5.0, true),
            None
        );
        let (_, event) = bench
            .feed(&Bench::reading(0.08, 0.4, 1.0), 1.0, true)
            .expect("released");
        let AlarmEvent::Off {
            frequency,
            lowest_damping,
        } = event
        else {
            panic!("not a release: {event:?}");
        };
        assert_eq!((frequency, lowest_damping), (900.0, 0.004));
    }

    #[test]
    fn releases_when_the_vibration_has_gone_whatever_the_damping_reads() {
        let mut bench = Bench::new();
        bench.feed(&Bench::reading(0.004, 0.8, 2.0), 0.5, true);
        assert!(bench.alarm.standing().is_some());
        let (t, event) = bench
            .feed(&Bench::reading(0.004, 0.8, 0.2), 0.5, true)
            .expect("released");
        assert!(
            (0.64..0.67).contains(&t) && matches!(event, AlarmEvent::Off { .. }),
            "{t}"
        );
        // What rings on is not called again; the same mode at full size is.
        assert!(bench.alarm.standing().is_none());
        assert_eq!(
            bench.feed(&Bench::reading(0.004, 0.8, 0.2), 0.3, true),
            None
        );
        assert!(
            bench
                .feed(&Bench::reading(0.004, 0.8, 2.0), 0.2, true)
                .is_some()
        );
    }

    #[test]
    fn forced_soft_damped_out_of_band_and_idle_modes_are_not_called() {
        let undamped = Bench::reading(0.001, 0.9, 1.0);
        for reading in [
            Reading {
                harmonic: Some(6),
                share: 0.0,
                ..undamped
            },
            Reading {
                overtone: true,
                ..undamped
            },
            Reading {
                share: 0.1,
                ..undamped
            },
            Reading {
                in_band: false,
                ..undamped
            },
            Reading {
                damping: (0.0101, 0.005),
                ..undamped
            },
            Reading {
                damping: (f64::NAN, f64::NAN),
                ..undamped
            },
        ] {
            assert_eq!(Bench::new().feed(&reading, 2.0, true), None, "{reading:?}");
        }
        assert_eq!(Bench::new().feed(&undamped, 2.0, false), None);
    }

    #[test]
    fn an_alarm_that_settles_on_a_multiple_of_the_speed_is_withdrawn() {
        let mut bench = Bench::new();
        let undamped = Bench::reading(0.001, 0.9, 1.0);
        bench.feed(&undamped, 0.6, true);
        let passing = Reading {
            harmonic: Some(33),
            ..undamped
        };
        assert_eq!(
            bench.feed(&passing, 0.8, true),
            None,
            "drifting through is no reason"
        );
        assert_eq!(bench.feed(&undamped, 0.1, true), None);
        let (t, _) = bench.feed(&passing, 2.0, true).expect("withdrawn");
        assert!((2.49..2.52).contains(&t), "{t}");
    }

    #[test]
    fn an_alarm_with_little_to_stand_on_goes_easily() {
        let mut bench = Bench::new();
        bench.feed(&Bench::reading(0.004, 0.8, 2.0), 0.1, true);
        assert!(bench.alarm.standing().is_some());
        let (t, _) = bench
            .feed(&Bench::reading(0.02, 0.8, 2.0), 1.0, true)
            .expect("released");
        assert!((0.24..0.27).contains(&t), "{t}");
        // A model that claims impossible growth is no reason for one.
        assert_eq!(
            Bench::new().feed(&Bench::reading(-0.05, 0.8, 2.0), 1.0, true),
            None
        );
    }

    #[test]
    fn a_falling_damping_warns_before_the_threshold() {
        let mut bench = Bench::new();
        let mut warned_at = None;
        for k in 0..500 {
            let zeta = 0.05 - 0.1 * f64::from(k) * PERIOD_S;
            let reading = Bench::reading(zeta, 0.5, 1.0);
            let mode = bench
                .track
                .update(&reading, &AlarmConfig::default(), PERIOD_S);
            let modes = [Some((mode, bench.track.suspicion_s()))];
            if warned_at.is_none() && bench.alarm.judge(&modes, true).1 == Reason::LosingDamping {
                warned_at = Some(zeta);
            }
        }
        let zeta = warned_at.expect("a warning");
        assert!((0.02..0.04).contains(&zeta), "warned at {zeta}");
    }
}
