//! What speaks for and against a line being self-excited, and its sum over time.

use super::config::VerdictConfig;
use crate::real::Real;

/// Evidence of one window is held within this.
const MOST: f64 = 6.0;
/// The sum never exceeds this, so that what ends ends soon.
const CERTAIN: f64 = 3.0;
/// Sharpness of each feature's penalty, and its factor.
const LEVEL_SHARPNESS: f64 = 3.0;
const SHARPNESS: f64 = 2.0;
/// Once the level has changed by this, lg, idle is known.
const CONTRAST: f64 = 0.8;

/// What is seen of one line in one window.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sight<T> {
    /// Log-odds that the rotation does not make it; none without a speed.
    pub(super) free: Option<T>,
    /// Log-odds of its family's part of what the rotation leaves, and of all.
    pub(super) part_of_rest: T,
    pub(super) part_of_all: T,
    /// Level over idle, dB, where it was heard.
    pub(super) over_idle_db: Option<T>,
    /// ln(S + 0.01).
    pub(super) fluctuation: T,
    /// lg of the band's power over the loudest heard, and of the loudest over the quietest.
    pub(super) level: T,
    pub(super) range: T,
}

/// The numbers of the evidence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weigher<T> {
    belief: T,
    free_weight: T,
    free_most: T,
    part_of_rest: T,
    part_of_all: T,
    over_idle: T,
    unheard_idle_db: T,
    fluctuation: T,
    level: T,
    gain: T,
    doubt: T,
}

/// ln(1 + e^x): nothing while x is well below 0, x well above.
fn penalty<T: Real>(x: T) -> T {
    if x > T::from_f64(30.0) {
        x
    } else {
        x.exp().ln_1p()
    }
}

impl<T: Real> Weigher<T> {
    /// One that is not made yet.
    pub(super) const BLANK: Self = Self {
        belief: T::ZERO,
        free_weight: T::ZERO,
        free_most: T::ZERO,
        part_of_rest: T::ZERO,
        part_of_all: T::ZERO,
        over_idle: T::ZERO,
        unheard_idle_db: T::ZERO,
        fluctuation: T::ZERO,
        level: T::ZERO,
        gain: T::ZERO,
        doubt: T::ZERO,
    };

    pub(super) fn new(config: &VerdictConfig, period_s: f64) -> Self {
        let of = T::from_f64;
        Self {
            belief: of(config.belief),
            free_weight: of(config.free_weight),
            free_most: of(config.free_most),
            part_of_rest: of(config.part_of_rest),
            part_of_all: of(config.part_of_all),
            over_idle: of(config.over_idle_db / 10.0),
            unheard_idle_db: of(config.unheard_idle_db),
            fluctuation: of(config.fluctuation),
            level: of(config.level),
            gain: of(period_s / config.memory_s),
            doubt: of(config.doubt),
        }
    }

    /// Evidence of one window: what is believed, less a penalty for each feature that
    /// speaks against.
    pub(super) fn weigh(&self, sight: &Sight<T>) -> T {
        let of = T::from_f64;
        let sharp = of(SHARPNESS);
        let over = match sight.over_idle_db {
            Some(db) if sight.range > of(CONTRAST) => db,
            Some(db) => db.max(self.unheard_idle_db),
            None => self.unheard_idle_db,
        };
        let over = over.clamp(T::ZERO, of(30.0)) / of(10.0);
        // Nobody knows of a rotation: as if it made none of this.
        let free = sight.free.unwrap_or(self.free_most);
        let free = self.free_weight * free.clamp(of(-5.0), self.free_most);
        let sum = self.belief + free
            - penalty(self.part_of_rest - sight.part_of_rest)
            - sharp * penalty(self.part_of_all - sight.part_of_all)
            - penalty(sharp * (self.over_idle - over))
            - penalty(sharp * (sight.fluctuation - self.fluctuation))
            - penalty(of(LEVEL_SHARPNESS) * (self.level - sight.level));
        sum.clamp(of(-MOST), of(MOST))
    }

    /// What a line that nothing is known of begins with.
    pub(super) fn doubt(&self) -> T {
        self.doubt
    }

    /// The sum after one more window.
    pub(super) fn add(&self, sum: T, evidence: T) -> T {
        (sum + self.gain * evidence).clamp(self.doubt, T::from_f64(CERTAIN))
    }
}
