//! Policy, advice, port and log, put together: one step after the other, without a clock of
//! its own.

use super::Controller;
use super::charts::{Charts, SAME_SPEED, reach_hz};
use super::log::{ActLog, ActRecord, What};
use crate::advice::F_SD;
use crate::failure::Failure;
use rarma_core::act::{ActConfig, Policy, Reading};
use rarma_core::advice::{Advice, AdviceConfig, HeardChatter, KnownCut, advise};
use rarma_core::decide::Structure;

/// Standard deviation of a speed that a controller reports, as a part of it.
const SPEED_SD: f64 = 0.001;

/// Where less than this part of the machines like the one that is told chatter at the speed, a call is taken for a false one: a
/// stable cut is called in one of eight. Of 67 stable cuts (seeds 1 to 299 of the population) 62 are below it, 60 below half of
/// it and 63 below 0.5; of 100 cuts that chatter and have a pocket none is, and three are below 0.5.
const LEAST_EXPECTED: f64 = 0.2;

/// What is known of the cutter and the machine.
#[derive(Debug, Default)]
pub struct Chatter {
    /// Teeth.
    pub teeth: u32,
    /// Modes at rest, where they were told.
    pub structure: Option<Structure<f64>>,
    /// Power at most over the present one.
    pub power: Option<f64>,
    /// The machine, where it is told.
    pub machine: Option<Charts>,
}

/// Speeds for a chatter.
enum Proposed {
    /// Overrides at which the cut may be stable, the best first.
    Believed(Vec<f64>),
    /// By the machine that is told the cut is stable at this speed, or chatters at another frequency: the speeds are shown
    /// alone.
    NotBelieved,
}

/// Turns what is heard into orders.
pub struct Actor {
    controller: Option<Box<dyn Controller>>,
    policy: Policy,
    config: ActConfig,
    about: Chatter,
    log: Option<ActLog>,
    /// The log cannot be written: what is ordered is given back, and nothing is ordered any more.
    failed: Option<Failure>,
    /// Frequency of the chatter that stands, Hz.
    chatter_hz: Option<f64>,
    reading: Option<Reading>,
    /// Speeds of this program at which it chattered.
    known: Vec<KnownCut<f64>>,
    /// It was said that the machine that is told is not worked out for the programmed speed.
    said_without: bool,
}

impl Actor {
    /// Nothing has been heard yet.
    ///
    /// # Errors
    /// A setting is out of range.
    pub fn new(
        controller: Box<dyn Controller>,
        config: ActConfig,
        about: Chatter,
        log: Option<ActLog>,
    ) -> Result<Self, Failure> {
        let fastest = controller.fastest_per_s().unwrap_or(f64::INFINITY);
        let config = ActConfig {
            rate_per_s: config.rate_per_s.min(fastest),
            ..config
        };
        let policy = Policy::new(config).map_err(|why| Failure::Usage(format!("act: {why}")))?;
        Ok(Self {
            controller: Some(controller),
            policy,
            config,
            about,
            log,
            failed: None,
            chatter_hz: None,
            reading: None,
            known: Vec::new(),
            said_without: false,
        })
    }

    /// Sound was heard until now; it chatters at this frequency, Hz, or does not.
    pub fn heard(&mut self, t_s: f64, chatter_hz: Option<f64>) {
        self.chatter_hz = chatter_hz;
        self.policy.heard(t_s, chatter_hz.is_some());
    }

    /// The speed that the listening believes in, turns a second.
    pub fn believe(&mut self, spindle_hz: f64) {
        if let Some(controller) = &mut self.controller {
            controller.believe(spindle_hz);
        }
    }

    /// Overrides that the controller takes, where it has told.
    pub fn range(&self) -> Option<(f64, f64)> {
        self.controller.as_ref()?.range()
    }

    /// The last report of the controller.
    pub fn reading(&self) -> Option<&Reading> {
        self.reading.as_ref()
    }

    /// An order stands, or is being given back.
    pub fn holds(&self) -> bool {
        self.policy.holds()
    }

    /// The listening ends: what is ordered is given back by the next steps.
    pub fn end(&mut self, t_s: f64) {
        self.policy.end(t_s);
    }

    /// Logs what has happened.
    pub fn note(&mut self, t_s: f64, what: What) -> ActRecord {
        let t = (1e3 * t_s).round() / 1e3;
        let record = ActRecord { t, what };
        let written = self.log.as_mut().map(|log| log.add(&record));
        if let Some(Err(why)) = written {
            self.log = None;
            self.failed = Some(why);
            self.policy.end(t_s);
        }
        record
    }

    /// Reads, decides, orders: to be called some fifty times a second. What has happened goes
    /// to `said`.
    ///
    /// # Errors
    /// The log cannot be written, and what was ordered has been given back.
    pub fn step(&mut self, t_s: f64, mut said: impl FnMut(ActRecord)) -> Result<(), Failure> {
        if !self.holds()
            && let Some(why) = self.failed.take()
        {
            return Err(why);
        }
        let read = self.controller.as_mut().map(|c| c.read());
        match read {
            Some(Ok(Some(reading))) => self.take(t_s, reading),
            Some(Err(why)) => said(self.gone(t_s, &why)),
            Some(Ok(None)) | None => {}
        }
        if self.failed.is_none() && self.policy.asks(t_s) {
            let proposed = self.proposals(t_s, &mut said);
            // What could not be logged just now is not ordered.
            match (proposed, &self.failed) {
                (_, Some(_)) => {}
                (Proposed::Believed(overrides), None) => self.policy.advised(t_s, &overrides),
                (Proposed::NotBelieved, None) => self.policy.disbelieved(t_s),
            }
        }
        let step = self.policy.step(t_s);
        if let Some(what) = step.said {
            said(self.note(t_s, what.into()));
        }
        if let (Some(order), Some(controller)) = (step.order, &mut self.controller)
            && let Err(why) = controller.order(order)
        {
            said(self.gone(t_s, &why));
        }
        Ok(())
    }

    fn take(&mut self, t_s: f64, reading: Reading) {
        let before = self.reading.replace(reading);
        let same = before.is_some_and(|b| {
            (b.program_hz - reading.program_hz).abs() <= SAME_SPEED * b.program_hz
        });
        if !reading.running || !same {
            self.known.clear();
        }
        if let Some(charts) = &mut self.about.machine {
            charts.begin(reading.program_hz, &self.config);
        }
        self.policy.reading(t_s, &reading);
    }

    fn gone(&mut self, t_s: f64, why: &Failure) -> ActRecord {
        self.controller = None;
        self.policy.lost();
        let error = why.to_string();
        self.note(t_s, What::Gone { error })
    }

    /// By the machine that is told, or else by the one mode that is heard; and whether the chatter is believed.
    fn advice(
        &mut self,
        t_s: f64,
        program_hz: f64,
        config: &AdviceConfig<f64>,
        heard: &HeardChatter<f64>,
        said: &mut impl FnMut(ActRecord),
    ) -> (Option<Advice<f64>>, bool) {
        let chart = self.about.machine.as_mut().map(|m| m.of(program_hz));
        let believed = match &chart {
            None => true,
            Some(None) => {
                if !std::mem::replace(&mut self.said_without, true) {
                    said(self.note(t_s, What::WithoutMachine));
                }
                true
            }
            Some(Some(chart)) => {
                self.said_without = false;
                match chart.advise(config, heard, &self.known) {
                    Ok(Some(answer)) => {
                        // One call that was believed in this program speaks for the next.
                        let is_first = self.known.is_empty();
                        let believed = !is_first || answer.expected >= LEAST_EXPECTED;
                        return (Some(answer.advice), believed);
                    }
                    Ok(None) => false,
                    Err(_) => true,
                }
            }
        };
        let structure = self.about.structure.as_ref();
        // What is out of range, such as a frequency that is none, has no advice.
        let advice = advise(config, heard, structure, &self.known);
        (advice.ok(), believed)
    }

    /// What is proposed, and shown.
    fn proposals(&mut self, t_s: f64, said: &mut impl FnMut(ActRecord)) -> Proposed {
        let (Some(reading), Some(f_hz)) = (self.reading, self.chatter_hz) else {
            return Proposed::Believed(Vec::new());
        };
        let Some(spindle_hz) = reading.spindle_hz() else {
            return Proposed::Believed(Vec::new());
        };
        let heard = HeardChatter {
            f_hz,
            f_sd_hz: F_SD * f_hz,
            spindle_hz,
            spindle_sd_hz: SPEED_SD * spindle_hz,
            teeth: self.about.teeth,
        };
        let (least_hz, most_hz) = reach_hz(&self.config, reading.program_hz);
        let config = AdviceConfig {
            most_power: self.about.power,
            keeps_feed: self.config.keeps_feed,
            ..AdviceConfig::reach(least_hz, most_hz)
        };
        let (advice, believed) = self.advice(t_s, reading.program_hz, &config, &heard, said);
        let hz: Vec<f64> = advice
            .iter()
            .flat_map(|a| a.proposals.iter().flatten())
            .map(|p| p.spindle_hz)
            .collect();
        // Shown once, though it is asked again while it stands.
        if !believed && self.policy.disbelieves() {
            return Proposed::NotBelieved;
        }
        if believed {
            let known = KnownCut::chattered(spindle_hz, Some((f_hz, heard.f_sd_hz)));
            self.known.push(known);
        }
        let rpm = |hz: f64| (600.0 * hz).round() / 10.0;
        let proposed = What::Proposed {
            f: (10.0 * f_hz).round() / 10.0,
            rpm: rpm(spindle_hz),
            speeds: hz.iter().map(|hz| rpm(*hz)).collect(),
        };
        said(self.note(t_s, proposed));
        let overrides: Vec<f64> = hz.iter().map(|hz| hz / reading.program_hz).collect();
        let shown = self.controller.as_mut().map(|c| c.propose(&overrides));
        if let Some(Err(why)) = shown {
            said(self.gone(t_s, &why));
        }
        if believed {
            Proposed::Believed(overrides)
        } else {
            Proposed::NotBelieved
        }
    }
}
