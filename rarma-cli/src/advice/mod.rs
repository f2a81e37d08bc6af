//! Which speed to turn instead, for each alarm of a run: as a record for JSON, in words, and
//! what is missing to say it.

mod at_a_box;
pub mod machine;
mod words;

pub use crate::record::{
    AdviceRecord, HelpRecord, KnownRecord, LobesRecord, MachineRecord, SpeedRecord, VariationRecord,
};
pub use at_a_box::AtBox;
pub(crate) use at_a_box::USUAL_HZ;
pub use words::{missing_words, sentences};

use crate::args::{AdviseArgs, MonitorArgs, USUAL_REACH};
use crate::collect::News;
use crate::progress::progress;
use crate::record::{SpeedSource, Summary, known};
use machine::{Answer, Belief};
use rarma_core::advice::{
    AdviceConfig, HeardChatter, KnownCut, MOST_KNOWN, VariationConfig, advise, vary,
};
use rarma_core::decide::Structure;
use serde::{Deserialize, Serialize};
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Missing {
    /// Nobody tells the speed.
    Speed,
    /// Nobody tells the teeth.
    Teeth,
}

/// An alarm that was called.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Called {
    f_hz: f64,
    /// Speed, 1/min, and its standard deviation.
    speed: Option<(f64, f64)>,
}

/// What an [`Advisor`] remembers of its run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Memory {
    /// Time, s, speed, 1/min, of the last line that knew one, and whether it was read.
    now: Option<(f64, f64, bool)>,
    called: Vec<Called>,
    /// Alarms for which a swing of the speed was worked out.
    swings: usize,
    /// What was said to do about the last alarm.
    said: Option<Box<AdviceRecord>>,
    /// The next line is to carry it.
    is_new: bool,
}

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
    memory: Memory,
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
            memory: Memory::default(),
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
            memory: Memory::default(),
        }
    }

    /// A controller tells the speed.
    #[must_use]
    pub fn told_live(self) -> Self {
        Self { live: true, ..self }
    }

    /// Speed at each alarm, 1/min; none where nobody told it.
    pub fn speeds_rpm(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        let called = self.memory.called.iter();
        called.map(|alarm| alarm.speed.map(|(rpm, _)| rpm))
    }

    /// The speed now, 1/min, where anybody tells it.
    pub fn speed_rpm(&self) -> Option<f64> {
        self.memory.now.map(|(_, rpm, _)| rpm).or(self.told_rpm)
    }

    /// What it remembers of the run.
    pub(crate) fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Goes on with the memory of another one; false where that is more than is kept.
    pub(crate) fn go_on(&mut self, memory: Memory) -> bool {
        let fits = memory.called.len() <= MOST;
        if fits {
            self.memory = memory;
        }
        fits
    }

    /// Forgets the alarms, as if it began now.
    pub(crate) fn forget(&mut self) {
        self.memory = Memory {
            now: self.memory.now,
            ..Memory::default()
        };
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

    /// Hears what a monitor says. An alarm is advised on at once, and the next line carries it; but a machine
    /// that is told takes seconds, and is asked at the end ([`Self::add_to`]).
    pub fn take(&mut self, news: &mut News) {
        match news {
            News::Line(line) => {
                if let Some(rpm) = line.spindle.rpm {
                    let read = line.spindle.source != SpeedSource::Told || self.live;
                    self.memory.now = Some((line.t, rpm, read));
                }
                if std::mem::take(&mut self.memory.is_new) {
                    line.advice.clone_from(&self.memory.said);
                }
            }
            News::On(alarm) if self.memory.called.len() < MOST => {
                let fresh = self.memory.now.filter(|(t, ..)| alarm.on - t < FRESH_S);
                let sd = |read| if read { READ_SD } else { TOLD_SD };
                let told = self.told_rpm.map(|rpm| (rpm, TOLD_SD * rpm));
                let speed = fresh.map_or(told, |(_, rpm, read)| Some((rpm, sd(read) * rpm)));
                let called = Called {
                    f_hz: alarm.f,
                    speed,
                };
                self.memory.said = match self.reach.machine {
                    None => self.of(called, self.memory.called.len()),
                    Some(_) => None,
                };
                self.memory.is_new = true;
                self.memory.called.push(called);
            }
            // One of too many.
            News::On(_) => self.memory.said = None,
            _ => {}
        }
    }

    /// Adds advice to the alarms of a finished run; nothing where something is missing. Their frequencies are means by
    /// then, and better than those at the call.
    pub fn add_to(&mut self, summary: &mut Summary) {
        for (called, alarm) in self.memory.called.iter_mut().zip(&summary.alarms) {
            called.f_hz = alarm.f;
        }
        self.memory.swings = 0;
        for (n, alarm) in summary.alarms.iter_mut().enumerate() {
            let Some(called) = self.memory.called.get(n).copied() else {
                return;
            };
            alarm.advice = self.of(called, n);
        }
    }

    /// What to do about the alarm that was called last, a sentence each; none where it is one of
    /// too many.
    pub fn words(&self) -> Vec<String> {
        if let Some(missing) = missing_words(&self.missing()) {
            return vec![missing];
        }
        self.last().map(sentences).unwrap_or_default()
    }

    /// What to do about the alarm that was called last, where it can be said.
    pub(crate) fn last(&self) -> Option<&AdviceRecord> {
        self.memory.said.as_deref()
    }

    /// What to do about the `n`th alarm, of which the ones before it are evidence.
    fn of(&mut self, called: Called, n: usize) -> Option<Box<AdviceRecord>> {
        if !self.missing().is_empty() {
            return None;
        }
        let known = if n < MOST_LEARNT {
            self.known(called.speed, n)
        } else {
            Vec::new()
        };
        let machine = (self.reach.machine.as_deref()).map(|m| (n < MOST_BY_MACHINE).then_some(m));
        let asked = Asked {
            known: &known,
            machine,
            swing: self.memory.swings < MOST_SWINGS,
        };
        let advice = self.asked(called.f_hz, called.speed?, &asked)?;
        self.memory.swings += usize::from(advice.variation.is_some());
        Some(Box::new(advice))
    }

    /// What is known beside the `n`th alarm: cuts that were told, and the alarms before it, with frequency and
    /// speed. Alarms at one speed are of one cut, of which the last is asked about.
    fn known(&self, speed: Option<(f64, f64)>, n: usize) -> Vec<KnownCut<f64>> {
        let elsewhere = self.memory.called.iter().take(n).filter_map(|before| {
            let ((at, _), (rpm, _)) = (before.speed?, speed?);
            let is_other = (at / rpm - 1.0).abs() > SAME_SPEED;
            let chatter = (before.f_hz, F_SD * before.f_hz);
            is_other.then(|| KnownCut::chattered(at / 60.0, Some(chatter)))
        });
        self.reach.known.iter().copied().chain(elsewhere).collect()
    }

    fn asked(
        &self,
        f_hz: f64,
        (rpm, rpm_sd): (f64, f64),
        asked: &Asked<'_>,
    ) -> Option<AdviceRecord> {
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
        let by_machine = matches!(
            machine,
            Some(MachineRecord::Explains | MachineRecord::Expects)
        );
        let mut record = AdviceRecord::new(&advice, variation.as_ref(), rpm, reach);
        if by_machine {
            record.lobes = None;
        }
        let counted = asked.known.len().saturating_sub(MOST_KNOWN);
        record.known = asked.known.iter().skip(counted).map(known).collect();
        record.machine = machine;
        Some(record)
    }
}
