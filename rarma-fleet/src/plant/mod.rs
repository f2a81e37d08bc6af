//! A plant to try it on: machines over months, with the truth.
//!
//! At the level of what tests and boxes *say*, not of samples: a test draws its result from the true
//! machine with the deviations that the rigs' own pages measured. That is why fifty years of machines
//! take seconds. What a box hears in a cut is not simulated here; `rarma population` does that.
//!
//! | module | what |
//! |---|---|
//! | [`machine`] | what a machine is: stiffness of its plane, modes, limit width |
//! | [`geometry`] | its loops and errors |
//! | [`life`] | what happens to it: wear, crashes, repairs, seasons |
//! | `tests` | what the ball bar, the exciter and the linked system say of it |
//! | `days` | what its box says of every day: verdicts, alarms, advice, outcomes |
//! | `boxes` | sessions, clocks that drift, boxes that drop out and deliver late |

mod boxes;
mod days;
pub mod geometry;
pub mod life;
pub mod machine;
mod says;
mod tests;

use crate::record::{Record, Utc};
use boxes::SensorBox;
use life::{Event, Life};
use machine::{Drawn, MachineNow};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use says::Says;
use serde::Serialize;

/// What is simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantConfig {
    /// Machines, 1 to 5000.
    pub machines: usize,
    /// Days, 1 to 3660.
    pub days: u32,
    /// First day.
    pub start: Utc,
    /// The same seed gives the same plant.
    pub seed: u64,
    /// What happens.
    pub fate: Fate,
    /// Without verdicts, alarms and advice: tests only, where only trends are asked.
    pub tests_only: bool,
}

/// What happens to the machines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fate {
    /// Wear, crashes and repairs as they come.
    Usual,
    /// Seasons, operators and tools, but no machine changes: every change that is called is false.
    Nothing,
    /// Of one machine in three: one crash on that day in a direction drawn by chance, and nothing else.
    Loss {
        /// Day of it, from 0.
        day: f64,
        /// Part of the stiffness in its direction that is lost, 1.
        part: f64,
    },
    /// Of one machine in three: from that day on one mode loses damping, and nothing else.
    Wear {
        /// Day on which it begins, from 0.
        day: f64,
        /// Days it takes.
        over: f64,
        /// Part of the damping that is lost in the end, 1.
        part: f64,
    },
    /// Of one machine in three: from that day on a joint of one axis wears, and nothing else.
    Joint {
        /// Day on which it begins, from 0.
        day: f64,
        /// Days it takes.
        over: f64,
        /// Part by which loops are wider in the end, 1.
        part: f64,
        /// Backlash that the axis has more in the end, µm.
        backlash_um: f64,
    },
    /// Of one machine in three: knocked out of square on that day, this way or that, and nothing else.
    Knock {
        /// Day of it, from 0.
        day: f64,
        /// By how much, µrad.
        squareness_urad: f64,
    },
}

/// What is true of one machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineTruth {
    /// Its name.
    pub machine: String,
    /// What happened to it.
    pub events: Vec<Event>,
    /// Widest stable cut at the end of each 30 days, mm.
    pub limit_mm: Vec<f64>,
    /// Days for which its box did not deliver, from and to, from 0.
    pub dropped: Vec<(f64, f64)>,
    /// How much faster than UTC its box's clock runs at 25 °C, millionths.
    pub drift_ppm: f64,
}

/// A machine with its life and its box.
struct Cell {
    drawn: Drawn,
    life: Life,
    sensor_box: SensorBox,
    rng: ChaCha8Rng,
}

/// A plant.
pub struct Plant {
    config: PlantConfig,
    cells: Vec<Cell>,
    day: u32,
}

impl Plant {
    /// Draws the machines and their lives.
    #[must_use]
    pub fn new(config: PlantConfig) -> Self {
        let cell = |n: usize| {
            let mut rng = ChaCha8Rng::seed_from_u64(config.seed);
            rng.set_stream(n as u64 + 1);
            let drawn = Drawn::draw(n, &mut rng);
            let life = Life::draw(n, &drawn, &config, &mut rng);
            let sensor_box = SensorBox::draw(config.days, &mut rng);
            Cell {
                drawn,
                life,
                sensor_box,
                rng,
            }
        };
        let cells = (0..config.machines).map(cell).collect();
        Self {
            config,
            cells,
            day: 0,
        }
    }

    /// What is true of the machines.
    #[must_use]
    pub fn truth(&self) -> Vec<MachineTruth> {
        let months = self.config.days / 30;
        (self.cells.iter())
            .map(|cell| MachineTruth {
                machine: cell.drawn.name.to_string(),
                events: cell.life.events.clone(),
                limit_mm: (1..=months)
                    .map(|m| cell.life.at(&cell.drawn, f64::from(m) * 30.0).limit_mm())
                    .collect(),
                dropped: cell.sensor_box.dropped.clone(),
                drift_ppm: cell.sensor_box.drift_ppm,
            })
            .collect()
    }

    /// A machine as it truly is on a day (from 0); `None` of one that is not there.
    #[must_use]
    pub fn machine(&self, name: &str, day: f64) -> Option<MachineNow> {
        let cell = (self.cells.iter()).find(|cell| cell.drawn.name.as_str() == name)?;
        Some(cell.life.at(&cell.drawn, day))
    }

    /// Its widest stable cut, mm.
    #[must_use]
    pub fn limit_mm(&self, machine: &str, day: f64) -> Option<f64> {
        Some(self.machine(machine, day)?.limit_mm())
    }

    /// Everything that arrives on the next day, in the order of arrival: what boxes that had dropped out
    /// deliver late is among it, and one record in a thousand comes twice. `None` after the last day, when
    /// everything has come.
    pub fn next_day(&mut self) -> Option<Vec<Record>> {
        if self.day >= self.config.days {
            let rest: Vec<Record> = self
                .cells
                .iter_mut()
                .flat_map(|cell| cell.sensor_box.rest())
                .collect();
            return (!rest.is_empty()).then_some(rest);
        }
        let day = self.day;
        self.day += 1;
        let mut arrived = Vec::new();
        for cell in &mut self.cells {
            let mut says = Says::new(&self.config, cell.drawn.name.clone(), day);
            tests::of_day(&mut says, &cell.drawn, &cell.life, &mut cell.rng);
            arrived.append(&mut says.by_test);
            if !self.config.tests_only {
                days::of_day(&mut says, &cell.drawn, &cell.life, &mut cell.rng);
                arrived.extend(cell.sensor_box.day(day, says.by_box, &mut cell.rng));
            }
        }
        Some(arrived)
    }
}

#[cfg(test)]
mod plant_tests;
