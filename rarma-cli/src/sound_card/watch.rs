//! What a card does that it should not: it gives nothing, or at another rate than it says.

use std::time::{Duration, Instant};

/// After this long without samples it is said.
const STALLED: Duration = Duration::from_secs(2);
/// By this share the clocks of a card and a computer do not differ.
const RATE_IS_OFF: f64 = 0.03;

/// Looks at the clock while samples are waited for.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    fs: f64,
    /// When something came last.
    came: Instant,
    stalled: bool,
    /// The rate it has told of, Hz.
    told_hz: f64,
}

impl Watch {
    pub(super) fn new(fs: f64, now: Instant) -> Self {
        Self {
            fs,
            came: now,
            stalled: false,
            told_hz: fs,
        }
    }

    /// Something has come.
    pub(super) fn something(&mut self, now: Instant) -> Option<String> {
        let pause = now.duration_since(self.came).as_secs_f64();
        self.came = now;
        std::mem::take(&mut self.stalled).then(|| format!("samples come again, after {pause:.1} s"))
    }

    /// Nothing has come.
    pub(super) fn nothing(&mut self, now: Instant) -> Option<String> {
        if self.stalled || now.duration_since(self.came) < STALLED {
            return None;
        }
        self.stalled = true;
        Some(format!(
            "no samples for {} s; still waiting (is the input in use, or was it switched off? Ctrl-C ends)",
            STALLED.as_secs()
        ))
    }

    /// How long nothing has come.
    pub(super) fn pause(&self, now: Instant) -> Duration {
        now.duration_since(self.came)
    }

    /// The rate has been measured.
    pub(super) fn rate(&mut self, measured_hz: Option<f64>) -> Option<String> {
        let hz = measured_hz?;
        let off = |from: f64| (hz / from - 1.0).abs() > RATE_IS_OFF;
        if !off(self.told_hz) {
            return None;
        }
        self.told_hz = hz;
        Some(if off(self.fs) {
            format!(
                "{hz:.0} samples a second come, not {:.0}: frequencies are told {:.3} times too high (the rate was changed elsewhere: end, and start again)",
                self.fs,
                self.fs / hz
            )
        } else {
            format!("{hz:.0} samples a second come again")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_card_that_gives_nothing_is_told_once_and_so_is_its_return() {
        let begin = Instant::now();
        let at = |ms| begin + Duration::from_millis(ms);
        let mut watch = Watch::new(48_000.0, begin);
        assert_eq!(watch.nothing(at(1900)), None);
        assert!(watch.nothing(at(2100)).is_some_and(|t| t.contains("2 s")));
        assert_eq!(watch.nothing(at(5000)), None);
        let again = watch.something(at(7300));
        assert!(again.is_some_and(|t| t.contains("after 7.3 s")));
        assert_eq!(watch.something(at(7400)), None);
        assert_eq!(watch.nothing(at(9300)), None);
        assert!(watch.nothing(at(9500)).is_some());
    }

    #[test]
    fn a_changed_rate_is_told_once_and_so_is_its_return() {
        let mut watch = Watch::new(48_000.0, Instant::now());
        assert_eq!(watch.rate(None), None);
        assert_eq!(watch.rate(Some(48_100.0)), None);
        let said = watch.rate(Some(44_100.0)).expect("told");
        assert!(said.contains("44100") && said.contains("1.088"), "{said}");
        assert_eq!(watch.rate(Some(44_110.0)), None);
        assert!(
            watch
                .rate(Some(48_010.0))
                .is_some_and(|t| t.contains("again"))
        );
    }
}
