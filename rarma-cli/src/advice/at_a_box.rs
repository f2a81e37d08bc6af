//! Advice for the alarms of a box, worked out by whoever reads its link: the box tells frequency, speed and teeth.

use super::{AdviceRecord, Advisor, MOST_LEARNT};
use crate::collect::News;
use crate::record::{Alarm, Line};
use crate::translate::{alarm, line};
use rarma_box::settings::{MONITOR_TEETH, SettingValue};
use rarma_box::wire::{Answer, Telemetry};

/// Rate of a microphone until the box tells it, Hz.
pub(crate) const USUAL_HZ: f64 = 48_000.0;

/// Follows what a box says, as far as advice needs it. What chattered at other speeds since it was started is
/// evidence.
#[derive(Debug, Clone, Default)]
pub struct AtBox {
    fs_hz: Option<f64>,
    teeth: u32,
    /// None until the teeth are known.
    advisor: Option<Advisor>,
    /// A line told a speed.
    knows_speed: bool,
    /// It stands, and what to do has not been said.
    waits: Option<Alarm>,
}

impl AtBox {
    /// The setting whose value it must hear, from the box's answer to whoever reads it.
    pub fn setting() -> u16 {
        MONITOR_TEETH.number()
    }

    /// Rate of the box's microphone, Hz: the usual one until it is told.
    pub fn fs_hz(&self) -> f64 {
        self.fs_hz.unwrap_or(USUAL_HZ)
    }

    /// Hears a message; what to do, once for an alarm, as soon as speed and teeth are known.
    pub fn take(&mut self, message: &Telemetry) -> Option<Box<AdviceRecord>> {
        match message {
            Telemetry::Started { fs_hz, .. } => {
                *self = Self {
                    fs_hz: Some(*fs_hz),
                    ..Self::of(self.teeth)
                };
            }
            Telemetry::Reply(reply) => match &reply.answer {
                Answer::Identity(id) => self.fs_hz = Some(f64::from(id.sample_rate_hz)),
                Answer::Setting(said) => self.setting_is(said.setting, said.value),
                Answer::Done | Answer::Refused(_) => {}
            },
            Telemetry::Verdict(verdict) => return self.line(line(verdict, self.fs_hz())),
            Telemetry::Alarm(message) if message.on => {
                self.waits = Some(alarm(message, self.fs_hz()));
                return self.advise();
            }
            Telemetry::Alarm(_) => self.waits = None,
            _ => {}
        }
        None
    }

    fn of(teeth: u32) -> Self {
        Self {
            teeth,
            advisor: (teeth > 0).then(|| Advisor::of_a_box(teeth)),
            ..Self::default()
        }
    }

    fn setting_is(&mut self, number: u16, value: SettingValue) {
        if number == Self::setting()
            && let SettingValue::Whole(teeth) = value
            && teeth != self.teeth
        {
            // What another cutter did tells nothing of this one.
            *self = Self {
                fs_hz: self.fs_hz,
                waits: self.waits.take(),
                ..Self::of(teeth)
            };
        }
    }

    fn line(&mut self, line: Line) -> Option<Box<AdviceRecord>> {
        self.knows_speed = line.spindle.rpm.is_some();
        if let Some(advisor) = &mut self.advisor {
            advisor.take(&mut News::Line(line));
        }
        self.advise()
    }

    fn advise(&mut self) -> Option<Box<AdviceRecord>> {
        if !self.knows_speed {
            return None;
        }
        let advisor = self.advisor.as_mut()?;
        let alarm = self.waits.take()?;
        if advisor.speeds_rpm().count() >= MOST_LEARNT {
            advisor.forget();
        }
        advisor.take(&mut News::On(alarm));
        advisor.last().cloned().map(Box::new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rarma_box::wire::{AlarmMessage, Reply, SettingMessage, SpindleMessage, Verdict};
    use rarma_core::decide::{Reason, State};
    use rarma_core::monitor::SpeedSource;

    fn verdict(at_s: f64, hz: Option<f32>) -> Telemetry {
        Telemetry::Verdict(Verdict {
            sample: (USUAL_HZ * at_s) as u64,
            state: State::Chatter,
            reason: Reason::None,
            level: 0.1,
            modes: Default::default(),
            spindle: SpindleMessage {
                hz,
                source: SpeedSource::Told,
                locked: false,
                notch_hz: 0.0,
                removed_power: 0.0,
            },
            amplitude: None,
        })
    }

    fn alarm(at_s: f64, on: bool, frequency: f32) -> Telemetry {
        Telemetry::Alarm(AlarmMessage {
            sample: (USUAL_HZ * at_s) as u64,
            on,
            frequency,
            damping: -0.001,
        })
    }

    fn teeth(teeth: u32) -> Telemetry {
        let answer = Answer::Setting(SettingMessage {
            setting: AtBox::setting(),
            value: SettingValue::Whole(teeth),
            stored: None,
        });
        Telemetry::Reply(Reply {
            to: 1,
            by: 1,
            answer,
        })
    }

    #[test]
    fn an_alarm_is_advised_on_once_as_soon_as_speed_and_teeth_are_known() {
        let mut ear = AtBox::default();
        assert!(ear.take(&verdict(0.9, Some(150.0))).is_none());
        assert!(ear.take(&alarm(1.0, true, 1128.0)).is_none(), "no teeth");
        assert!(ear.take(&teeth(2)).is_none());
        let said = ear
            .take(&verdict(1.05, Some(150.0)))
            .expect("speed and teeth");
        assert!((said.rpm - 9000.0).abs() < 0.1 && (said.waves - 3.76).abs() < 0.001);
        assert!(
            ear.take(&verdict(1.1, Some(150.0))).is_none(),
            "said already"
        );
        // Another alarm, at another speed: the first is evidence.
        assert!(ear.take(&alarm(2.0, false, 1128.0)).is_none());
        assert!(ear.take(&verdict(2.9, Some(170.0))).is_none());
        let said = ear.take(&alarm(3.0, true, 1131.0)).expect("all is known");
        assert_eq!(said.known.len(), 1);
        assert!((said.known[0].rpm - 9000.0).abs() < 0.1 && !said.known[0].stable);
        // With another cutter it is none.
        ear.take(&alarm(3.5, false, 1131.0));
        ear.take(&teeth(3));
        ear.take(&verdict(3.9, Some(190.0)));
        let said = ear.take(&alarm(4.0, true, 1131.0)).expect("all is known");
        assert!(said.known.is_empty());
    }

    #[test]
    fn an_alarm_that_is_over_is_not_advised_on() {
        let mut ear = AtBox::default();
        ear.take(&teeth(2));
        assert!(ear.take(&alarm(1.0, true, 1128.0)).is_none(), "no speed");
        ear.take(&alarm(1.2, false, 1128.0));
        assert!(ear.take(&verdict(1.3, Some(150.0))).is_none());
    }

    #[test]
    fn a_box_that_alarms_for_ever_does_not_fill_the_memory() {
        let mut ear = AtBox::default();
        ear.take(&teeth(2));
        ear.take(&verdict(0.5, Some(150.0)));
        for k in 0..2 * MOST_LEARNT + 1 {
            let said = ear.take(&alarm(1.0 + 0.001 * k as f64, true, 1128.0));
            assert!(said.is_some(), "{k}");
            ear.take(&alarm(1.0005 + 0.001 * k as f64, false, 1128.0));
        }
        let advisor = ear.advisor.expect("teeth");
        assert!(advisor.speeds_rpm().count() <= MOST_LEARNT);
    }
}
