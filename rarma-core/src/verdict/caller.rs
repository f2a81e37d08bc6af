//! When evidence becomes an alarm, and when the alarm ends.

use super::config::VerdictConfig;
use crate::real::Real;
use crate::visit::state;

/// An alarm ends at this above the doubt at the least, where every line without evidence is.
const ABOVE_DOUBT: f64 = 0.2;
/// An alarm outlives so many windows without evidence: 0.2 s.
const OUTLIVES: u8 = 4;

/// Calls chatter where the evidence passes a threshold, and holds the alarm until it has
/// fallen below another one for 0.2 s.
#[derive(Debug, Clone)]
pub struct Caller<T> {
    call: T,
    release: T,
    silent: u8,
    stands: bool,
}

state! { Caller<T> {
    silent, stands;
    settings call, release
} }

impl<T: Real> Caller<T> {
    /// One that is not made yet.
    pub(super) const BLANK: Self = Self {
        call: T::ZERO,
        release: T::ZERO,
        silent: 0,
        stands: false,
    };

    /// By the settings `call`, `hysteresis` and `doubt`.
    pub fn new(config: &VerdictConfig) -> Self {
        let release = (config.call - config.hysteresis).max(config.doubt + ABOVE_DOUBT);
        Self {
            call: T::from_f64(config.call),
            release: T::from_f64(release),
            silent: 0,
            stands: false,
        }
    }

    /// So much evidence is enough.
    pub(super) fn would_call(&self, evidence: T) -> bool {
        evidence > self.call
    }

    /// Ends an alarm.
    pub(super) fn silence(&mut self) {
        self.stands = false;
    }

    /// The largest sum of evidence after a window; whether chatter is called.
    pub fn hear(&mut self, evidence: T) -> bool {
        self.silent = if evidence > self.release {
            0
        } else {
            self.silent.saturating_add(1)
        };
        self.stands = if self.stands {
            self.silent <= OUTLIVES
        } else {
            self.would_call(evidence)
        };
        self.stands
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alarm_outlives_a_gap_and_ends_after_it() {
        let config = VerdictConfig {
            call: 0.0,
            hysteresis: 1.0,
            doubt: -2.0,
            ..VerdictConfig::default()
        };
        let mut caller = Caller::<f64>::new(&config);
        let mut heard =
            |evidence: &[f64]| -> Vec<bool> { evidence.iter().map(|e| caller.hear(*e)).collect() };
        assert_eq!(heard(&[-0.5, 0.1, -0.9]), [false, true, true]);
        assert_eq!(heard(&[-1.5, -1.5, -0.5]), [true, true, true]);
        assert_eq!(heard(&[-1.5; 6]), [true, true, true, true, false, false]);
    }

    #[test]
    fn an_alarm_ends_even_where_the_call_is_near_the_doubt() {
        let config = VerdictConfig {
            call: -1.9,
            hysteresis: 5.0,
            doubt: -2.0,
            ..VerdictConfig::default()
        };
        let mut caller = Caller::<f32>::new(&config);
        assert!(caller.hear(0.0));
        assert!((0..6).map(|_| caller.hear(-2.0)).any(|stands| !stands));
    }
}
