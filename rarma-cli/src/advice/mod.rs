//! Which speed to turn instead, for each alarm of a run: as a record for JSON, in words, and
//! what is missing to say it.

pub mod machine;
mod words;

pub use crate::record::{AdviceRecord, HelpRecord, MachineRecord, SpeedRecord, VariationRecord};
pub use words::{missing_words, sentences};

use crate::args::{AdviseArgs, MonitorArgs, USUAL_REACH};
use crate::collect::News;
use crate::progress::progress;
use crate::record::{Alarm, SpeedSource, Summary};
use machine::{Answer, Belief};
use rarma_core::advice::{AdviceConfig, HeardChatter, KnownCut, VariationConfig, advise, vary};
use rarma_core::decide::Structure;
use std::sync::Arc;

/// So many alarms get advice, the first ones: a day of alarms is not worked out for seconds.
const MOST: usize = 1000;
/// Of so many a swing of the speed is worked out, where no speed is stable: each takes some
/// hundredths of a second.
const MOST_SWINGS: usize = 20;
/// In so many what is known of other cuts counts: each takes some six hundredths of a second.
const MOST_LEARNT: usize = 100;
/// Of so many a machine that is told is asked: each takes some seconds.
const MOST_BY_MACHINE: usize = 20;
/// A line is good for the speed of an alarm so long, s.
const FRESH_S: f64 = 1.0;
/// Standard deviation of an alarm's frequency, as a part of it: half of the alarms of random
/// cuts lie within 0.2 % of the true root.
pub(crate) const F_SD: f64 = 0.003;
/// That of a speed that was read off sound or tacho, or told by a control.
const READ_SD: f64 = 0.001;
/// That of a speed that was told and not confirmed.
const TOLD_SD: f64 = 0.005;
/// Alarms at speeds that differ by less tell the same.
const SAME_SPEED: f64 = 0.01;

/// What may be turned, in the user's measure, and what is known of other cuts.
#[derive(Debug, Clone)]
pub struct Reach {
    /// Override, percent of the present speed, from and to.
    pub percent: (f64, f64),
    /// Power at most over the present one.
    pub power: Option<f64>,
    /// The feed is not changed with the speed.
    pub same_feed: bool,
    /// What the drive can do, where the speed is to swing.
    pub swing: VariationConfig<f64>,
    /// Other cuts with the same tool.
    pub known: Vec<KnownCut<f64>>,
    /// The machine, where one is told.
    pub machine: Option<Arc<Belief>>,
}

impl Default for Reach {
    fn default() -> Self {
        Self {
            percent: USUAL_REACH,
            power: None,
            same_feed: false,
            swing: VariationConfig::default(),
            known: Vec::new(),
            machine: None,
        }
    }
}

impl From<&AdviseArgs> for Reach {
    fn from(args: &AdviseArgs) -> Self {
        let usual = VariationConfig::default();
        let amplitude = args.swing.map(|percent| percent / 100.0);
        Self {
            percent: args.reach.unwrap_or(USUAL_REACH),
            power: args.power,
            same_feed: args.same_feed,
            swing: VariationConfig {
                most_amplitude: amplitude.unwrap_or(usual.most_amplitude),
                most_acceleration: args.swing_acceleration.unwrap_or(usual.most_acceleration),
                most_hz: args.swing_hz.unwrap_or(usual.most_hz),
            },
            known: Vec::new(),
            machine: None,
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

/// See [`Advisor::memory`].
pub(crate) type Memory = (Option<(f64, f64, bool)>, Vec<Option<(f64, f64)>>);

/// What is asked beside an alarm.
struct Asked<'a> {
    known: &'a [KnownCut<f64>],
    /// A machine that is told, and whether it is asked.
    machine: Option<Option<&'a Belief>>,
    /// A swing of the speed, too, where no speed is stable.
    swing: bool,
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

    /// For a box, which tells its speed itself, as far as it knows it.
    pub fn of_a_box(teeth: u32) -> Self {
        Self {
            reach: Reach::default(),
            structure: None,
            teeth: Some(teeth),
            told_rpm: None,
            live: true,
            now: None,
            at: Vec::new(),
        }
    }

    /// A controller tells the speed.
    #[must_use]
    pub fn told_live(self) -> Self {
        Self { live: true, ..self }
    }

    /// Speed at each alarm, 1/min; none where nobody told it.
    pub fn speeds_rpm(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.at.iter().map(|at| at.map(|(rpm, _)| rpm))
    }

    /// The speed now, 1/min, where anybody tells it.
    pub fn speed_rpm(&self) -> Option<f64> {
        self.now.map(|(_, rpm, _)| rpm).or(self.told_rpm)
    }

    /// What it remembers of the run: the last line that knew a speed, and the speed at each alarm.
    pub(crate) fn memory(&self) -> Memory {
        (self.now, self.at.clone())
    }

    /// Goes on with the memory of another one; false where that is more than is kept.
    pub(crate) fn go_on(&mut self, (now, at): Memory) -> bool {
        let fits = at.len() <= MOST;
        if fits {
            (self.now, self.at) = (now, at);
        }
        fits
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
        let mut swings = MOST_SWINGS;
        let heard: Vec<f64> = summary.alarms.iter().map(|alarm| alarm.f).collect();
        for (n, (alarm, speed)) in summary.alarms.iter_mut().zip(&self.at).enumerate() {
            let before = heard.iter().copied().zip(self.at.iter().copied()).take(n);
            let known = if n < MOST_LEARNT {
                self.known(*speed, before)
            } else {
                Vec::new()
            };
            let machine =
                (self.reach.machine.as_deref()).map(|m| (n < MOST_BY_MACHINE).then_some(m));
            let asked = Asked {
                known: &known,
                machine,
                swing: swings > 0,
            };
            let advice = speed.and_then(|speed| self.of(alarm.f, speed, &asked));
            if advice.as_ref().is_some_and(|a| a.variation.is_some()) {
                swings -= 1;
            }
            alarm.advice = advice.map(Box::new);
        }
    }

    /// What to do about the alarm that was taken last, a sentence each; none where it is one of
    /// too many. Of other cuts those that were told count, of this one what was heard before does not.
    pub fn now(&self, alarm: &Alarm) -> Vec<String> {
        if let Some(missing) = missing_words(&self.missing()) {
            return vec![missing];
        }
        let speed = self.at.last().copied().flatten();
        let swing = self.at.len() <= MOST_SWINGS;
        let known = self.known(speed, []);
        let asked = Asked {
            known: &known,
            machine: None,
            swing,
        };
        let advice = speed.and_then(|speed| self.of(alarm.f, speed, &asked));
        advice.map(|advice| sentences(&advice)).unwrap_or_default()
    }

    /// What is known beside an alarm at a speed: cuts that were told, and the alarms before it, with frequency and
    /// speed. Alarms at one speed are of one cut, of which the last is asked about.
    fn known(
        &self,
        speed: Option<(f64, f64)>,
        before: impl IntoIterator<Item = (f64, Option<(f64, f64)>)>,
    ) -> Vec<KnownCut<f64>> {
        let elsewhere = before.into_iter().filter_map(|(f, there)| {
            let ((at, _), (rpm, _)) = (there?, speed?);
            let is_other = (at / rpm - 1.0).abs() > SAME_SPEED;
            is_other.then(|| KnownCut::chattered(at / 60.0, Some((f, F_SD * f))))
        });
        self.reach.known.iter().copied().chain(elsewhere).collect()
    }

    fn of(&self, f_hz: f64, (rpm, rpm_sd): (f64, f64), asked: &Asked<'_>) -> Option<AdviceRecord> {
        let heard = HeardChatter {
            f_hz,
            f_sd_hz: F_SD * f_hz,
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
        let by_machine = |belief: &Belief| -> Option<Answer> {
            let bar = progress(Belief::CHARTED as u64, "machines like the one told");
            let answer = belief.advise(&config, &heard, asked.known, || bar.inc(1));
            bar.finish_and_clear();
            answer.ok()?
        };
        let told = asked.machine.flatten().and_then(by_machine);
        let machine = asked.machine.map(|asked| match (asked, &told) {
            (None, _) => MachineRecord::NotAsked,
            (_, Some(Answer { explains: true, .. })) => MachineRecord::Explains,
            (_, Some(_)) => MachineRecord::Expects,
            (_, None) => MachineRecord::Contradicts,
        });
        let of_machine = || self.reach.machine.as_ref()?.structure();
        let structure = told.as_ref().and_then(|_| of_machine()).or(self.structure);
        let advice = match told {
            Some(told) => told.advice,
            None => advise(&config, &heard, structure.as_ref(), asked.known).ok()?,
        };
        let top = match self.reach.power {
            Some(power) if !self.reach.same_feed => self.reach.percent.1.min(100.0 * power),
            _ => self.reach.percent.1,
        };
        let reach = (at(self.reach.percent.0), at(top));
        let variation = (asked.swing && advice.first().is_none())
            .then(|| vary(&self.reach.swing, &heard, structure.as_ref()).ok())
            .flatten();
        Some(AdviceRecord {
            machine,
            ..AdviceRecord::new(&advice, variation.as_ref(), rpm, reach)
        })
    }
}
