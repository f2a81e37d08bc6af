//! The static test: the machine stands in one direction after another, the load goes up and
//! down in each.
//!
//! Rate: once a millisecond. As in the circular test the machine is not connected: the
//! host says when it stands in the next direction ([`Standing::go`]).

use super::procedure::{Asked, Seen};
use super::procedure_event::RunFault;
use super::schedule::{Run, Schedule};

/// Settings, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingConfig {
    /// Directions that are measured.
    pub directions: u8,
    /// Dither after a new pressure, s; by default none: it would shake the friction loose
    /// whose hysteresis is sought.
    pub dither_s: f32,
    /// Mean over this long, s.
    pub hold_s: f32,
    /// Longest time for a pressure to settle, s.
    pub settle_most_s: f32,
    /// Pressure between directions, Pa.
    pub holding_pa: f32,
    /// Gauge beyond ± this ends the test, m.
    pub gauge_limit_m: f32,
}

impl Default for StandingConfig {
    fn default() -> Self {
        Self {
            directions: 4,
            dither_s: 0.0,
            hold_s: 1.0,
            settle_most_s: 20.0,
            holding_pa: 4e4,
            gauge_limit_m: 0.9e-3,
        }
    }
}

/// One reading of the static test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Direction, from 0.
    pub direction: u8,
    /// Step of the schedule.
    pub run: Run,
    /// Mean of the gauge, m.
    pub gauge_m: f32,
    /// Mean pressure, Pa.
    pub pressure_pa: f32,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StandingEvent {
    /// The machine may go to this direction; then [`Standing::go`].
    Go(u8),
    /// A reading.
    Held(Held),
    /// The test has ended.
    Failed(RunFault),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum At {
    Asking,
    Moving,
    Settling,
    Holding,
    Over,
}

/// Goes through the directions and loads of the static test.
#[derive(Debug, Clone)]
pub struct Standing {
    config: StandingConfig,
    schedule: Schedule,
    at: At,
    direction: u8,
    step: u16,
    here_ms: u32,
    mean: (f32, f32),
}

impl Standing {
    /// A test that asks for its first direction at once. None without directions or times.
    pub fn new(config: StandingConfig, schedule: Schedule) -> Option<Self> {
        let sound = config.directions > 0
            && config.hold_s >= 1e-3
            && config.settle_most_s > config.dither_s
            && config.dither_s >= 0.0
            && config.holding_pa > 0.0
            && config.gauge_limit_m > 0.0;
        sound.then_some(Self {
            config,
            schedule,
            at: At::Asking,
            direction: 0,
            step: 0,
            here_ms: 0,
            mean: (0.0, 0.0),
        })
    }

    /// The machine stands in the direction that was asked for.
    pub fn go(&mut self) {
        if self.at == At::Moving {
            self.enter(At::Settling);
        }
    }

    fn enter(&mut self, at: At) {
        self.at = at;
        self.here_ms = 0;
        self.mean = (0.0, 0.0);
    }

    fn fail(&mut self, why: RunFault) -> Option<StandingEvent> {
        self.enter(At::Over);
        Some(StandingEvent::Failed(why))
    }

    /// What the valve loop should do now.
    pub fn asked(&self) -> Asked {
        let run = match self.at {
            At::Settling | At::Holding => self.schedule.run(self.step),
            At::Asking | At::Moving | At::Over => None,
        };
        Asked {
            pressure_pa: run.map_or(self.config.holding_pa, |r| r.pressure_pa),
            dither: self.at == At::Settling && (self.here_ms as f32) < 1e3 * self.config.dither_s,
        }
    }

    /// One millisecond.
    pub fn step(&mut self, seen: &Seen) -> Option<StandingEvent> {
        if self.at == At::Over {
            return None;
        }
        self.here_ms = self.here_ms.saturating_add(1);
        if !(seen.gauge_m.is_finite() && seen.pressure_pa.is_finite()) {
            return self.fail(RunFault::NotFinite);
        }
        if seen.gauge_m.abs() > self.config.gauge_limit_m {
            return self.fail(RunFault::GaugeRange(seen.gauge_m));
        }
        let here_s = 1e-3 * self.here_ms as f32;
        match self.at {
            At::Asking => {
                self.enter(At::Moving);
                Some(StandingEvent::Go(self.direction))
            }
            At::Settling if here_s >= self.config.dither_s && seen.settled => {
                self.enter(At::Holding);
                None
            }
            At::Settling if here_s > self.config.settle_most_s => {
                self.fail(RunFault::NotSettled(seen.pressure_pa))
            }
            At::Holding => self.holding(seen, here_s),
            At::Moving | At::Settling | At::Over => None,
        }
    }

    fn holding(&mut self, seen: &Seen, here_s: f32) -> Option<StandingEvent> {
        let n = self.here_ms as f32;
        self.mean.0 += (seen.gauge_m - self.mean.0) / n;
        self.mean.1 += (seen.pressure_pa - self.mean.1) / n;
        if here_s < self.config.hold_s {
            return None;
        }
        let run = self.schedule.run(self.step)?;
        let held = Held {
            direction: self.direction,
            run,
            gauge_m: self.mean.0,
            pressure_pa: self.mean.1,
        };
        self.step += 1;
        if self.step < self.schedule.runs() {
            self.enter(At::Settling);
        } else {
            self.step = 0;
            self.direction += 1;
            self.enter(if self.direction < self.config.directions {
                At::Asking
            } else {
                At::Over
            });
        }
        Some(StandingEvent::Held(held))
    }

    /// Whether everything is over.
    pub fn is_over(&self) -> bool {
        self.at == At::Over
    }
}
