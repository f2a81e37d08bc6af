//! The sequence of a test: settle, in over the on-trigger, overshoot, capture, overshoot, out
//! over the off-trigger, next run.
//!
//! Rate: once a millisecond. The machine runs its own program and is not connected; all
//! that is known of it is the gauge. It waits outside the circle, where the bar is longer than
//! the trigger length; moving in along the radius it crosses it. The operator, or a program
//! with a dwell, starts a run when the box says [`Stage::Waiting`].

use super::procedure_config::{OUTSIDE_M, ProcedureConfig};
use super::procedure_event::{Event, Proof, RunDone, RunFault};
use super::recorder::{Beside, Recorder};
use super::schedule::{Run, Schedule};
use super::trace::{AngleMap, Trace};

/// Readings in a row on the other side of the trigger length.
const CROSSED_MS: u32 = 3;
/// Where the test is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Nothing asked for.
    Idle,
    /// A new pressure is coming; dither works the seal loose first.
    Settling,
    /// The machine may start.
    Waiting,
    /// Between on-trigger and arc.
    In,
    /// First overshoot.
    Overshoot,
    /// Capture.
    Capture,
    /// Second overshoot.
    OvershootOut,
    /// The off-trigger is awaited.
    Out,
    /// All runs are done.
    Finished,
    /// The test has ended; the bar is held at the lowest pressure.
    Failed,
}

/// What a millisecond brings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Gauge, m.
    pub gauge_m: f32,
    /// Transducer, Pa.
    pub pressure_pa: f32,
    /// The valve loop is settled.
    pub settled: bool,
}

/// What is asked of the valve loop.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Asked {
    /// Set point, Pa.
    pub pressure_pa: f32,
    /// Dither.
    pub dither: bool,
}

/// Goes through the steps of a test.
#[derive(Debug, Clone)]
pub struct Procedure {
    config: ProcedureConfig,
    schedule: Schedule,
    creep_pa: f32,
    stage: Stage,
    run: u16,
    /// Milliseconds in this stage, and since the on-trigger.
    here_ms: u32,
    run_ms: u32,
    beyond: u32,
    was_outside: bool,
    recorder: Recorder,
}

impl Default for Procedure {
    /// Idle; nothing asked for.
    fn default() -> Self {
        Self {
            config: ProcedureConfig::default(),
            schedule: Schedule::default(),
            creep_pa: 0.0,
            stage: Stage::Idle,
            run: 0,
            here_ms: 0,
            run_ms: 0,
            beyond: 0,
            was_outside: false,
            recorder: Recorder::default(),
        }
    }
}

impl Procedure {
    /// A test that begins at the next step. None where the settings do not fit together.
    pub fn new(config: ProcedureConfig, schedule: Schedule) -> Option<Self> {
        let mut this = Self::default();
        this.begin(config, schedule).then_some(this)
    }

    /// Begins a test where another one was: it is large. False, and nothing has changed, where the
    /// settings do not fit together.
    #[must_use]
    pub fn begin(&mut self, config: ProcedureConfig, schedule: Schedule) -> bool {
        let sound = config.is_sound()
            && schedule
                .run(0)
                .is_some_and(|r| r.pressure_pa >= 0.99 * config.holding_pa);
        if !sound {
            return false;
        }
        // No step of pressure is taken back by more than half.
        self.creep_pa = config
            .creep_pa
            .min(0.5 * schedule.least_step_pa() / f32::from(schedule.senses()));
        self.config = config;
        self.schedule = schedule;
        self.run = 0;
        self.run_ms = 0;
        self.was_outside = false;
        self.recorder.forget();
        self.enter(Stage::Settling);
        true
    }

    /// Where the test is.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Run in progress, or next.
    pub fn run(&self) -> Option<Run> {
        self.schedule.run(self.run)
    }

    /// Time since the on-trigger, s, while the machine runs.
    pub fn run_s(&self) -> Option<f32> {
        self.moving().then_some(1e-3 * self.run_ms as f32)
    }

    /// The settings.
    pub fn config(&self) -> &ProcedureConfig {
        &self.config
    }

    /// The last run in bins of angle.
    pub fn trace<const BINS: usize>(&self, done: &RunDone) -> Trace<f32, BINS> {
        self.recorder.trace(&done.map, self.config.overshoot_rad)
    }

    /// Whether a test was begun and not stopped.
    pub fn is_idle(&self) -> bool {
        self.stage == Stage::Idle
    }

    /// The test is over, whatever it did.
    pub fn stop(&mut self) {
        self.enter(Stage::Idle);
    }

    fn moving(&self) -> bool {
        matches!(
            self.stage,
            Stage::In | Stage::Overshoot | Stage::Capture | Stage::OvershootOut | Stage::Out
        )
    }

    fn enter(&mut self, stage: Stage) {
        self.stage = stage;
        self.here_ms = 0;
        self.beyond = 0;
    }

    fn fail(&mut self, why: RunFault) -> Option<Event> {
        self.enter(Stage::Failed);
        Some(Event::Failed(why))
    }

    /// How far the pressure of a run has gone on, Pa. Two runs at one pressure share the way:
    /// the second begins where the first ended.
    fn crept_pa(&self, run: &Run) -> f32 {
        let (senses, turning) = (self.schedule.senses(), self.schedule.turns_at(run));
        if turning {
            return 0.0;
        }
        let whole_ms = 1e3 * (self.config.lead_s + self.config.arc_s());
        let part = if self.moving() {
            (self.run_ms as f32 / whole_ms).min(1.0)
        } else {
            0.0
        };
        let gone = f32::from(run.number % senses) + part;
        let way = if run.rising {
            gone
        } else {
            f32::from(senses) - gone
        };
        way * self.creep_pa
    }

    /// What the valve loop should do now. The bar is held at the lowest pressure when the
    /// test is over: between balls, and with no more force than that.
    pub fn asked(&self) -> Asked {
        let holding = Asked {
            pressure_pa: self.config.holding_pa,
            dither: false,
        };
        match (self.stage, self.run()) {
            (Stage::Idle | Stage::Finished | Stage::Failed, _) | (_, None) => holding,
            (stage, Some(run)) => Asked {
                pressure_pa: run.pressure_pa.max(self.config.holding_pa) + self.crept_pa(&run),
                dither: stage == Stage::Settling
                    && (self.here_ms as f32) < 1e3 * self.config.dither_s,
            },
        }
    }

    /// One millisecond.
    pub fn step(&mut self, seen: &Seen) -> Option<Event> {
        if matches!(self.stage, Stage::Idle | Stage::Finished | Stage::Failed) {
            return None;
        }
        self.here_ms = self.here_ms.saturating_add(1);
        if !(seen.gauge_m.is_finite() && seen.pressure_pa.is_finite()) {
            return self.fail(RunFault::NotFinite);
        }
        if seen.gauge_m.abs() > self.config.gauge_limit_m {
            return self.fail(RunFault::GaugeRange(seen.gauge_m));
        }
        let run = self.run()?;
        match self.stage {
            Stage::Settling => self.settling(seen, run),
            Stage::Waiting => self.waiting(seen),
            _ => self.running(seen, run),
        }
    }

    fn settling(&mut self, seen: &Seen, run: Run) -> Option<Event> {
        let c = self.config;
        let here_s = 1e-3 * self.here_ms as f32;
        if self.was_outside && self.crossed(seen.gauge_m < c.trigger_m) {
            return self.fail(RunFault::StartedEarly);
        }
        self.was_outside |= seen.gauge_m > c.trigger_m + OUTSIDE_M;
        if here_s >= c.dither_s && seen.settled {
            self.enter(Stage::Waiting);
            return Some(Event::Ready(run));
        }
        if here_s > c.settle_most_s {
            return self.fail(RunFault::NotSettled(seen.pressure_pa));
        }
        None
    }

    fn waiting(&mut self, seen: &Seen) -> Option<Event> {
        let c = self.config;
        self.was_outside |= seen.gauge_m > c.trigger_m + OUTSIDE_M;
        if self.was_outside && self.crossed(seen.gauge_m < c.trigger_m) {
            self.recorder.begin(c.arc_s());
            self.run_ms = CROSSED_MS - 1;
            self.was_outside = false;
            self.enter(Stage::In);
        } else if self.here_ms as f32 > 1e3 * c.wait_s {
            return self.fail(RunFault::NoOnTrigger);
        }
        None
    }

    fn crossed(&mut self, beyond: bool) -> bool {
        self.beyond = if beyond { self.beyond + 1 } else { 0 };
        self.beyond >= CROSSED_MS
    }

    fn running(&mut self, seen: &Seen, run: Run) -> Option<Event> {
        let c = self.config;
        self.run_ms += 1;
        let run_s = 1e-3 * self.run_ms as f32;
        if seen.pressure_pa < 0.9 * c.holding_pa {
            return self.fail(RunFault::NotHeld(seen.pressure_pa));
        }
        let set_pa = run.pressure_pa.max(c.holding_pa) + self.crept_pa(&run);
        if (seen.pressure_pa - set_pa).abs() > c.drift_pa {
            return self.fail(RunFault::PressureMoved(seen.pressure_pa));
        }
        let (arc_s, t_s) = (c.arc_s(), run_s - c.lead_s);
        self.recorder.add(t_s, seen.gauge_m, seen.pressure_pa);
        if t_s > 0.0 && self.crossed(seen.gauge_m > c.trigger_m) {
            return self.out(run_s - 1e-3 * (CROSSED_MS - 1) as f32, run);
        }
        let over_s = arc_s * c.overshoot_rad / c.sweep_rad;
        let stage = if t_s < 0.0 {
            Stage::In
        } else if t_s < over_s {
            Stage::Overshoot
        } else if t_s < arc_s - over_s {
            Stage::Capture
        } else if t_s < arc_s {
            Stage::OvershootOut
        } else {
            Stage::Out
        };
        if stage != self.stage {
            let beyond = self.beyond;
            self.enter(stage);
            self.beyond = beyond;
        }
        if t_s > 1.1 * arc_s + c.lead_s {
            return self.fail(RunFault::NoOffTrigger);
        }
        None
    }

    /// The off-trigger.
    fn out(&mut self, off_s: f32, run: Run) -> Option<Event> {
        let c = self.config;
        let real_s = off_s - 2.0 * c.lead_s;
        let part = real_s / c.arc_s();
        if !(part > 0.9) {
            return self.fail(RunFault::EndedEarly(part.max(0.0)));
        }
        if !((1.0 / part - 1.0).abs() <= c.feed_part) {
            return self.fail(RunFault::Feed(1.0 / part));
        }
        let map = AngleMap {
            start_rad: match run.sense {
                super::Sense::Ccw => c.start_rad,
                super::Sense::Cw => c.start_rad + c.sweep_rad,
            },
            sweep_rad: c.sweep_rad,
            sense: run.sense,
            from_s: 0.0,
            to_s: real_s,
        };
        let reversals = self.recorder.reversals(&map);
        if reversals.turned {
            return self.fail(RunFault::WrongDirection);
        }
        let proof = match self.recorder.beside(&map, c.overshoot_rad) {
            Beside::Turned if !reversals.proven => return self.fail(RunFault::WrongDirection),
            Beside::Turned | Beside::LastTurned => {
                return self.fail(RunFault::WrongDirectionBefore);
            }
            _ if reversals.proven => Proof::Reversals,
            Beside::Alike => Proof::LikeBefore,
            Beside::Open => Proof::None,
        };
        if reversals.proven && reversals.off_rad > c.feed_within_rad {
            return self.fail(RunFault::FeedWithin(reversals.off_rad));
        }
        self.run += 1;
        self.was_outside = true;
        self.enter(if self.run < self.schedule.runs() {
            Stage::Settling
        } else {
            Stage::Finished
        });
        Some(Event::Done(RunDone {
            run,
            map,
            off_s,
            pressure_pa: self.recorder.pressure_pa(),
            feed_m_s: map.feed_m_s(c.radius_m),
            proof,
            reversals,
        }))
    }
}
