//! The circle under load, on the wire: the job, readings, findings.

use heapless::Vec;
use rarma_rigs::ldbb::{BarSet, LdbbError, ProcedureConfig, Proof, RunFault, Schedule};
use serde::{Deserialize, Serialize};

/// Pressures of a job.
pub const JOB_PRESSURES: usize = 8;
/// Readings in one message.
pub const CIRCLE_POINTS: usize = 20;
/// Readings a second.
pub const CIRCLE_RATE_HZ: u32 = 100;

/// From the host: a whole test. What is not in it is the standard circle's: 150 mm, 390° of
/// which 15° at each end are overshoot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CircleJob {
    /// Pressures, Pa, rising; 0 after the last one.
    pub pressures_pa: [f32; JOB_PRESSURES],
    /// Feed, m/s.
    pub feed_m_s: f32,
    /// Radius, m.
    pub radius_m: f32,
    /// Clockwise as well.
    pub both: bool,
    /// Down again.
    pub down: bool,
}

/// From the host: a static test. The box asks for one direction after the other and goes
/// up and down in each.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StandJob {
    /// Pressures, Pa, rising; 0 after the last one.
    pub pressures_pa: [f32; JOB_PRESSURES],
    /// Directions.
    pub directions: u8,
}

/// Those that are used.
fn used(pressures_pa: &[f32; JOB_PRESSURES]) -> impl Iterator<Item = f32> + '_ {
    pressures_pa.iter().copied().take_while(|p| *p > 0.0)
}

/// The same for an inclined bar.
fn inclined(
    bar: &BarSet,
    pressures_pa: &[f32; JOB_PRESSURES],
) -> Result<[f32; JOB_PRESSURES], LdbbError> {
    let mut out = [0.0; JOB_PRESSURES];
    for (to, from) in out.iter_mut().zip(used(pressures_pa)) {
        *to = bar.pressure_pa(from)?;
    }
    Ok(out)
}

impl StandJob {
    /// What it is for the bar as it stands.
    ///
    /// # Errors
    /// A pressure is out of reach, or does not hold the bar.
    pub fn for_bar(&self, bar: &BarSet) -> Result<Self, LdbbError> {
        let pressures_pa = inclined(bar, &self.pressures_pa)?;
        Ok(Self {
            pressures_pa,
            ..*self
        })
    }

    /// Up and down; none where the pressures do not rise or there is no direction.
    pub fn schedule(&self) -> Option<Schedule> {
        let pressures: Vec<f32, JOB_PRESSURES> = used(&self.pressures_pa).collect();
        Schedule::new(&pressures, false, true).filter(|_| self.directions > 0)
    }
}

impl CircleJob {
    /// What it is for the bar as it stands: pressure, radius and feed of an inclined one.
    ///
    /// # Errors
    /// A pressure is out of reach, or does not hold the bar.
    pub fn for_bar(&self, bar: &BarSet) -> Result<Self, LdbbError> {
        let cos = bar.cos();
        Ok(Self {
            pressures_pa: inclined(bar, &self.pressures_pa)?,
            feed_m_s: self.feed_m_s * cos,
            radius_m: self.radius_m * cos,
            ..*self
        })
    }

    /// The sequence of the job; none where its numbers do not fit together.
    pub fn procedure(&self) -> Option<(ProcedureConfig, Schedule)> {
        let mut standard = ProcedureConfig::default();
        if self.down {
            standard = standard.with_way_down();
        }
        let lead_s = standard.trigger_m / self.feed_m_s + PAUSE_S;
        let pressures: Vec<f32, JOB_PRESSURES> = used(&self.pressures_pa).collect();
        let schedule = Schedule::new(&pressures, self.both, self.down)?;
        let config = ProcedureConfig {
            feed_m_s: self.feed_m_s,
            radius_m: self.radius_m,
            lead_s,
            ..standard
        };
        config.is_sound().then_some((config, schedule))
    }
}

/// The program's pause between radius and arc, s.
pub const PAUSE_S: f32 = 0.5;

/// From the box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum CircleMessage {
    /// The pressure has settled: the machine may start.
    Ready {
        /// Number of the run, from 0.
        run: u16,
        /// Clockwise.
        cw: bool,
        /// On the way up.
        rising: bool,
        /// Set point, Pa.
        pressure_pa: f32,
    },
    /// Readings of the run, overshoots included.
    Points(CirclePoints),
    /// The run is over.
    Done {
        /// Number of the run.
        run: u16,
        /// The arc's time by the triggers, s; the readings' clock begins with the arc.
        arc_s: f32,
        /// Mean pressure, Pa.
        pressure_pa: f32,
        /// Feed by the triggers, m/s.
        feed_m_s: f32,
        /// What proves the direction.
        proof: Proof,
        /// Reversals of the axes that stand out, and the greatest angle one is off its
        /// place, rad.
        reversals: (u8, f32),
    },
    /// The test has ended early; the bar is held at the lowest pressure.
    Failed {
        /// Number of the run.
        run: u16,
        /// Why.
        why: RunFault,
    },
    /// What the box itself makes of the whole test.
    Stiffness {
        /// Mean over the directions, N/m.
        mean_n_per_m: f32,
        /// Largest, N/m, and its direction, rad.
        most: (f32, f32),
        /// Smallest.
        least: (f32, f32),
        /// Standard deviation of the largest, N/m.
        sd_n_per_m: f32,
        /// Scatter of a direction's means about the lines, m.
        scatter_m: f32,
    },
    /// Static test: the machine may go to this direction; then `Command::Go`.
    Go {
        /// Direction, from 0.
        direction: u8,
    },
    /// Static test: a reading.
    Held {
        /// Direction, from 0.
        direction: u8,
        /// Step of the way up and down, from 0.
        step: u16,
        /// On the way up.
        rising: bool,
        /// Mean pressure, Pa.
        pressure_pa: f32,
        /// Force in the plane, N.
        force_n: f32,
        /// Length change in the plane, m.
        dr_m: f32,
    },
    /// Static test: a direction is done; after the last one the bar is held at rest.
    Cycle {
        /// Direction, from 0.
        direction: u8,
        /// Largest unloading less loading deflection, m.
        most_m: f32,
        /// What stays at the smallest force, m.
        left_m: f32,
        /// Stiffness on the way up and its standard deviation, N/m; 0 below three pressures.
        stiffness_n_per_m: (f32, f32),
    },
}

/// Readings at [`CIRCLE_RATE_HZ`]: means of ten milliseconds.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CirclePoints {
    /// Number of the run.
    pub run: u16,
    /// Middle of the first one since the programmed beginning of the arc, ms; negative
    /// before it.
    pub first_ms: i32,
    /// Gauge, m.
    pub gauge_m: Vec<f32, CIRCLE_POINTS>,
    /// Mean pressure over the message, Pa.
    pub pressure_pa: f32,
}
