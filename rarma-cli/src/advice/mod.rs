//! Which speed to turn instead, for each alarm of a run: as a record for JSON, in words, and
//! what is missing to say it.

mod record;
mod words;

pub use record::{AdviceRecord, HelpRecord, SpeedRecord};
pub use words::{missing_words, sentences};

use crate::args::{AdviseArgs, MonitorArgs, USUAL_REACH};
use crate::collect::News;
use crate::record::{Alarm, SpeedSource, Summary};
use rarma_core::advice::{AdviceConfig, HeardChatter, advise};
use rarma_core::decide::Structure;

/// So many alarms get advice, the first ones: a day of alarms is not worked out for seconds.
const MOST: usize = 1000;
/// A line is good for the speed of an alarm so long, s.
const FRESH_S: f64 = 1.0;
/// Standard deviation of an alarm's frequency, as a part of it: half of the alarms of random
/// cuts lie within 0.2 % of the true root.
pub(crate) const F_SD: f64 = 0.003;
/// That of a speed that was read off sound or tacho, or told by a control.
const READ_SD: f64 = 0.001;
/// That of a speed that was told and not confirmed.
const TOLD_SD: f64 = 0.005;

/// What may be turned, in the user's measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Override, percent of the present speed, from and to.
    pub percent: (f64, f64),
    /// Power at most over the present one.
    pub power: Option<f64>,
    /// The feed is not changed with the speed.
    pub same_feed: bool,
}

impl Default for Reach {
    fn default() -> Self {
        Self {
            percent: USUAL_REACH,
            power: None,
            same_feed: false,
        }
    }
}

impl From<&AdviseArgs> for Reach {
    fn from(args: &AdviseArgs) -> Self {
        Self {
            percent: args.reach.unwrap_or(USUAL_REACH),
            power: args.power,
            same_feed: args.same_feed,
        }
    }
}

/// What is missing to give advice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Missing {
    /// Nobody tells the speed.
    Speed,
    /// Nobody tells the teeth.
    Teeth,
}

/// Gives advice for the alarms of one run.
#[derive(Debug, Clone)]
pub struct Advisor {
    reach: Reach,
    structure: Option<Structure<f64>>,
    teeth: Option<u32>,
    told_rpm: Option<f64>,
    /// A control or a tacho tells the speed as it goes.
    live: bool,
    /// Time, s, speed, 1/min, of the last line that knew one, and whether it was read.
    now: Option<(f64, f64, bool)>,
    /// Speed at each alarm: 1/min, and its standard deviation.
    at: Vec<Option<(f64, f64)>>,
}

impl Advisor {
    /// For a run with these options.
    pub fn new(args: &MonitorArgs, reach: Reach, structure: Option<Structure<f64>>) -> Self {
        Self {
            reach,
            structure,
            teeth: args.teeth,
            told_rpm: args.rpm,
            live: args.speed_from.is_some() || args.tacho.is_some(),
            now: None,
            at: Vec::new(),
        }
    }

    /// A controller tells the speed.
    #[must_use]
    pub fn told_live(self) -> Self {
        Self { live: true, ..self }
    }

    /// What is missing to give any.
    pub fn missing(&self) -> Vec<Missing> {
        let speed = self.told_rpm.is_none() && !self.live;
        let all = [
            (speed, Missing::Speed),
            (self.teeth.is_none(), Missing::Teeth),
        ];
        let missing = all.into_iter().filter(|(is, _)| *is);
        missing.map(|(_, what)| what).collect()
    }

    /// Remembers the speed at which an alarm is called.
    pub fn take(&mut self, news: &News) {
        match news {
            News::Line(line) => {
                if let Some(rpm) = line.spindle.rpm {
                    let read = line.spindle.source != SpeedSource::Told || self.live;
                    self.now = Some((line.t, rpm, read));
                }
            }
            News::On(alarm) if self.at.len() < MOST => {
                let fresh = self.now.filter(|(t, ..)| alarm.on - t < FRESH_S);
                let sd = |read| if read { READ_SD } else { TOLD_SD };
                let told = self.told_rpm.map(|rpm| (rpm, TOLD_SD * rpm));
                self.at
                    .push(fresh.map_or(told, |(_, rpm, read)| Some((rpm, sd(read) * rpm))));
            }
            _ => {}
        }
    }

    /// Adds advice to the alarms of a finished run; nothing where something is missing.
    pub fn add_to(&self, summary: &mut Summary) {
        if !self.missing().is_empty() {
            return;
        }
        for (alarm, speed) in summary.alarms.iter_mut().zip(&self.at) {
            alarm.advice = speed.and_then(|speed| self.of(alarm, speed)).map(Box::new);
        }
    }

    fn of(&self, alarm: &Alarm, (rpm, rpm_sd): (f64, f64)) -> Option<AdviceRecord> {
        let heard = HeardChatter {
            f_hz: alarm.f,
            f_sd_hz: F_SD * alarm.f,
            spindle_hz: rpm / 60.0,
            spindle_sd_hz: rpm_sd / 60.0,
            teeth: self.teeth?,
        };
        let at = |percent: f64| percent / 100.0 * heard.spindle_hz;
        let config = AdviceConfig {
            most_power: self.reach.power,
            keeps_feed: !self.reach.same_feed,
            ..AdviceConfig::reach(at(self.reach.percent.0), at(self.reach.percent.1))
        };
        let advice = advise(&config, &heard, self.structure.as_ref(), &[]).ok()?;
        let top = match self.reach.power {
            Some(power) if !self.reach.same_feed => self.reach.percent.1.min(100.0 * power),
            _ => self.reach.percent.1,
        };
        let reach = (at(self.reach.percent.0), at(top));
        Some(AdviceRecord::new(&advice, rpm, reach))
    }
}
