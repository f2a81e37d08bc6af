//! Settings of the verdict, and what they make of one reading.

use crate::real::Real;

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
    /// Least part of all of the band's power, the spindle's lines included, at the
    /// mode, 0..=1, default 0.005: what is 23 dB below the cut marks no surface.
    pub loud_of_all: T,
    /// Undamped (for certain, by a standard deviation) and loud for this long is
    /// chatter, s; longer where it is less certain. Default 0.06.
    pub confirm_s: T,
    /// Damped or gone for this long ends it, s. Default 0.15.
    pub release_s: T,
    /// Gone: the amplitude is below this part of its mean over the alarm. Default
    /// 0.2 (−14 dB).
    pub gone_ratio: T,
    /// Warn when a mode would lose all its damping within this time at its present
    /// gradient, s. Default 0.3.
    pub warn_ahead_s: T,
}

impl<T: Real> Default for AlarmConfig<T> {
    fn default() -> Self {
        Self {
            threshold: T::from_f64(0.01),
            release_ratio: T::from_f64(4.0),
            loud_share: T::from_f64(0.25),
            loud_of_all: T::from_f64(0.005),
            confirm_s: T::from_f64(0.06),
            release_s: T::from_f64(0.15),
            gone_ratio: T::from_f64(0.2),
            warn_ahead_s: T::from_f64(0.3),
        }
    }
}

impl<T: Real> AlarmConfig<T> {
    /// ζ is not below −2 thresholds: no vibration grows that fast for long.
    pub fn credible(&self, damping: T) -> bool {
        damping > -(self.threshold + self.threshold)
    }

    /// ζ + sd below the threshold, and ζ not below −2 thresholds: no vibration grows
    /// that fast for long (ζ = −2 % at 1 kHz is a factor of ten in 18 ms), so a model
    /// that says so has not settled.
    pub fn undamped(&self, damping: (T, T)) -> bool {
        // NaN compares false: never undamped.
        damping.0 + damping.1 < self.threshold && self.credible(damping.0)
    }

    /// How sure it is that the mode is undamped: (threshold − ζ)/sd, limited to −1..=1;
    /// −1 for a ζ that is not credible.
    pub fn evidence(&self, damping: (T, T)) -> T {
        let (zeta, sd) = damping;
        if !(self.credible(zeta) && sd.is_finite()) {
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

    /// The mode holds enough of the band's power: of what nothing else explains, and of
    /// all.
    pub fn loud(&self, share: T, share_of_all: T) -> bool {
        share >= self.loud_share && share_of_all >= self.loud_of_all
    }
}
