//! An alarm that stands, and what the lines say of its mode meanwhile.

use crate::readings::Readings;
use crate::record::{Alarm, Line};
use serde::{Deserialize, Serialize};

/// A mode whose frequency moved by no more than this part since the line before is the same.
const SAME: f64 = 0.06;

/// An alarm that stands, and the damping of its mode in every line since.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct StandingAlarm {
    /// As it was called, without a middle.
    pub(crate) alarm: Alarm,
    /// Where the mode was last, Hz.
    f: f64,
    damping: Readings,
}

impl StandingAlarm {
    /// Nothing has been read yet.
    pub(crate) fn new(alarm: Alarm) -> Self {
        Self {
            f: alarm.f,
            alarm,
            damping: Readings::default(),
        }
    }

    /// See [`Readings::is_sound`].
    pub(crate) fn is_sound(&self) -> bool {
        self.damping.is_sound()
    }

    /// Reads the mode off a line that has it.
    pub(crate) fn read(&mut self, line: &Line) {
        let away = |f: f64| (f - self.f).abs();
        let nearest = line
            .modes
            .iter()
            .min_by(|a, b| away(a.f).total_cmp(&away(b.f)));
        if let Some(mode) = nearest.filter(|m| away(m.f) <= SAME * self.f) {
            self.f = mode.f;
            self.damping.push(mode.zeta);
        }
    }

    /// The alarm, with the middle of what was read.
    pub(crate) fn told(self) -> Alarm {
        let middle = self.damping.middle();
        Alarm {
            zeta_median: middle.map(|m| m.median),
            zeta_deviation: middle.map(|m| m.deviation),
            ..self.alarm
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(modes: &[(f64, f64)]) -> Line {
        let modes: Vec<serde_json::Value> = modes
            .iter()
            .map(|(f, zeta)| {
                serde_json::json!({
                    "f": f, "f_sd": 1.0, "zeta": zeta, "zeta_sd": 0.001, "amplitude": 0.1,
                    "label": "structural", "harmonic": null, "origin": "free", "time_left": null,
                })
            })
            .collect();
        let line = serde_json::json!({
            "t": 0.0, "state": "chatter", "reason": "none", "modes": modes,
            "spindle": {"rpm": null, "source": "unknown", "locked": false, "notch_hz": 0.0},
            "amplitude": null,
        });
        serde_json::from_value(line).expect("a line")
    }

    #[test]
    fn an_alarm_tells_the_damping_of_its_own_mode_as_that_wanders() {
        let alarm = Alarm {
            on: 1.0,
            off: None,
            f: 900.0,
            zeta: -0.5,
            zeta_median: None,
            zeta_deviation: None,
            advice: None,
        };
        let mut standing = StandingAlarm::new(alarm.clone());
        standing.read(&line(&[(300.0, 0.2), (910.0, 0.001)]));
        standing.read(&line(&[(300.0, 0.2)]));
        assert_eq!(
            StandingAlarm {
                damping: standing.damping.clone(),
                alarm,
                f: 900.0
            }
            .told()
            .zeta_median,
            None
        );
        // A tenth of its frequency in small steps, beside another mode.
        for k in 1..=20 {
            let f = 910.0 + 5.0 * f64::from(k);
            standing.read(&line(&[(700.0, 0.3), (f, 0.002)]));
        }
        let told = standing.told();
        assert_eq!((told.zeta_median, told.zeta), (Some(0.002), -0.5));
        assert_eq!(told.zeta_deviation, Some(0.0));
    }
}
