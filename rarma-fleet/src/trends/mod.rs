//! Has a machine changed, beyond what its tests leave uncertain?
//!
//! | module | what |
//! |---|---|
//! | [`series`] | readings to series: the tensor of a plane, modes told apart, the worst limit |
//! | `geometry` | the same of loops and errors |
//! | [`noise`] | how far two tests of the same machine differ: from test to test, by operator, by tool, over the year |
//! | [`change`] | the sequential test: since when, a step or a drift, in which direction |
//! | `depth` | what a change does to the limit depth of the machine |
//! | [`forecast`] | the limit width of next month |
//!
//! **Model.** ln of a reading (of an error, which may be 0, the reading) is a level, changes, and deviations: of the test σₑ, of the operator σ_o and
//! of the tool σ_t (the same each time that name comes again), and of the season (a cosine of the year of any
//! phase). The deviations' sizes are those of the whole plant ([`noise`]), robustly; so a new operator or a new
//! holder explains a shift of the size that operators and holders make, and no more.
//!
//! **Test.** Generalised likelihood ratio: after every test, over all times since when and both shapes, the
//! gain in squared residual of the model with that change over the one without. Under no change each gain is
//! χ² (1 degree of freedom; 3 for a plane, whose change may point anywhere). The threshold makes the sum of
//! their chances over a year no more than the false changes that are allowed: a bound, so that
//! the real rate is lower ([`change::threshold`]).

pub mod change;
mod depth;
pub mod forecast;
mod geometry;
pub mod noise;
pub mod series;
mod white;

use crate::record::Quantity;
use crate::store::MachineReading;
use change::Change;
use forecast::Forecast;
use rayon::prelude::*;
use serde::Serialize;
use series::Series;

/// What is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrendsConfig {
    /// False changes a machine and year, at most; above 0, at most 1. Usual: 0.2.
    pub false_per_year: f64,
}

impl Default for TrendsConfig {
    fn default() -> Self {
        Self {
            false_per_year: 0.2,
        }
    }
}

/// What is known of one machine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MachineTrend {
    /// Its name.
    pub machine: String,
    /// Tests that were read.
    pub tests: usize,
    /// Series that were tested.
    pub series: usize,
    /// What has changed, by time.
    pub changes: Vec<Change>,
    /// The widest stable cut in a month; `null` with fewer than three tests of it.
    pub limit: Option<Forecast>,
}

/// What is known of a plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trends {
    /// False changes a machine and year that were allowed.
    pub false_per_year: f64,
    /// Deviations, of the whole plant.
    pub noise: Vec<noise::Noise>,
    /// The machines.
    pub machines: Vec<MachineTrend>,
}

/// Series of the readings of one machine.
fn gathered(readings: &[MachineReading]) -> Vec<Series> {
    let mut all = Vec::new();
    for of_place in readings.chunk_by(|a, b| a.place == b.place) {
        for of_quantity in of_place.chunk_by(|a, b| a.quantity == b.quantity) {
            match of_quantity[0].quantity {
                Quantity::Compliance => all.extend(series::plane(of_quantity)),
                Quantity::Hysteresis => all.extend(geometry::loops(of_quantity)),
                Quantity::LimitWidth => all.extend(series::limit(of_quantity)),
                _ => {}
            }
        }
    }
    all.extend(series::modes(readings));
    all.extend(geometry::errors(readings));
    // A change needs a before and an after.
    all.retain(|s| s.tests.len() >= 4);
    all.sort_by(|a, b| {
        (a.kind, &a.place)
            .cmp(&(b.kind, &b.place))
            .then(a.at.total_cmp(&b.at))
    });
    all
}

/// Trends of readings, sorted as [`crate::store::Store::readings`] gives them.
#[must_use]
pub fn trends(readings: &[MachineReading], config: &TrendsConfig) -> (Trends, Vec<Series>) {
    let all: Vec<Series> = readings
        .chunk_by(|a, b| a.machine == b.machine)
        .collect::<Vec<_>>()
        .par_iter()
        .flat_map(|of_machine| gathered(of_machine))
        .collect();
    let noise = noise::of_plant(&all);
    let memory = forecast::memory(&all, &noise);
    let machines: Vec<MachineTrend> = all
        .chunk_by(|a, b| a.machine == b.machine)
        .collect::<Vec<_>>()
        .par_iter()
        .map(|of_machine| {
            let part = config.false_per_year / of_machine.len() as f64;
            let mut changes: Vec<Change> = of_machine
                .iter()
                .flat_map(|s| change::changes(s, &noise, part))
                .collect();
            let readings = of_name(readings, &of_machine[0].machine);
            let depth = depth::Depth::of_machine(readings, of_machine);
            for change in &mut changes {
                change.limit_percent = depth.percent(change);
            }
            changes.sort_by(|a, b| (a.found, &a.what, &a.place).cmp(&(b.found, &b.what, &b.place)));
            MachineTrend {
                machine: of_machine[0].machine.clone(),
                tests: of_machine.iter().map(|s| s.tests.len()).max().unwrap_or(0),
                series: of_machine.len(),
                changes,
                limit: of_machine
                    .iter()
                    .find(|s| s.kind == series::SeriesKind::Limit)
                    .and_then(|s| forecast::forecast(s, &noise, &memory)),
            }
        })
        .collect();
    (
        Trends {
            false_per_year: config.false_per_year,
            noise,
            machines,
        },
        all,
    )
}

/// Readings of one machine, of those that are sorted by machine.
fn of_name<'a>(readings: &'a [MachineReading], machine: &str) -> &'a [MachineReading] {
    let from = readings.partition_point(|r| r.machine.as_str() < machine);
    let to = readings.partition_point(|r| r.machine.as_str() <= machine);
    &readings[from..to]
}

#[cfg(test)]
mod trends_tests;
