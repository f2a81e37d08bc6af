//! The limit width of next month.
//!
//! ln of the width is a level with a slope that both wander (local linear trend, Kalman); how fast they
//! wander is chosen for the whole plant, by likelihood over a grid.

use super::noise::{Noise, of_channel};
use super::series::{Series, SeriesKind};
use crate::record::Utc;
use nalgebra::{Matrix2, Vector2};
use serde::Serialize;

/// Ahead, days.
pub const AHEAD_DAYS: f64 = 30.0;

/// The widest stable cut in a month, in the worst direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Forecast {
    /// For when.
    pub time: Utc,
    /// Now, mm.
    pub now_mm: f64,
    /// Then, mm.
    pub then_mm: f64,
    /// 95 % of it, from and to, mm.
    pub from_mm: f64,
    /// See there.
    pub to_mm: f64,
    /// Worst direction, degrees, 0 to 180.
    pub direction_deg: f64,
    /// Tests that it comes from.
    pub tests: usize,
}

/// How fast the limit of a machine wanders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Memory {
    /// Of the level, in a month, standard deviation of ln.
    level_sd: f64,
    /// Of the slope, in a month, ln a month.
    slope_sd: f64,
}

/// Days of a month, as used here.
const MONTH: f64 = 30.0;

/// What the plant's machines do: the likeliest of a grid.
#[must_use]
pub fn memory(all: &[Series], noise: &[Noise]) -> Memory {
    let mut best = (
        f64::NEG_INFINITY,
        Memory {
            level_sd: 0.02,
            slope_sd: 0.005,
        },
    );
    for level_sd in [0.002, 0.01, 0.02, 0.04, 0.08] {
        for slope_sd in [0.0, 0.003, 0.01, 0.03] {
            let memory = Memory { level_sd, slope_sd };
            let limits = all.iter().filter(|s| s.kind == SeriesKind::Limit);
            let likelihood: f64 = limits
                .map(|s| Filter::run(s, noise, &memory).likelihood)
                .sum();
            if likelihood > best.0 {
                best = (likelihood, memory);
            }
        }
    }
    best.1
}

/// Level and slope after the last test.
struct Filter {
    x: Vector2<f64>,
    p: Matrix2<f64>,
    likelihood: f64,
}

impl Filter {
    fn run(series: &Series, noise: &[Noise], memory: &Memory) -> Self {
        let days = series.days();
        let r = of_channel(noise, SeriesKind::Limit, 0).test_sd.powi(2);
        let mut filter = Self {
            x: Vector2::new(series.tests[0].y[0], 0.0),
            p: Matrix2::new(r, 0.0, 0.0, 0.02_f64.powi(2)),
            likelihood: 0.0,
        };
        for (n, test) in series.tests.iter().enumerate().skip(1) {
            filter.ahead((days[n] - days[n - 1]) / MONTH, memory);
            let s = filter.p[(0, 0)] + r;
            let mut e = test.y[0] - filter.x[0];
            filter.likelihood -= 0.5 * (s.ln() + (e * e / s).min(16.0));
            // A bad test moves it by three deviations at most.
            e = e.clamp(-3.0 * s.sqrt(), 3.0 * s.sqrt());
            let gain = filter.p.column(0) / s;
            filter.x += gain * e;
            let row = filter.p.row(0).into_owned();
            filter.p -= gain * row;
        }
        filter
    }

    /// So many months on.
    fn ahead(&mut self, months: f64, memory: &Memory) {
        let f = Matrix2::new(1.0, months, 0.0, 1.0);
        let (l, s) = (memory.level_sd.powi(2), memory.slope_sd.powi(2));
        let q = Matrix2::new(
            l * months + s * months.powi(3) / 3.0,
            s * months.powi(2) / 2.0,
            s * months.powi(2) / 2.0,
            s * months,
        );
        self.x = f * self.x;
        self.p = f * self.p * f.transpose() + q;
    }
}

/// The forecast of a series of limits; `None` with fewer than three tests.
#[must_use]
pub fn forecast(series: &Series, noise: &[Noise], memory: &Memory) -> Option<Forecast> {
    let last = series.tests.last()?;
    if series.tests.len() < 3 {
        return None;
    }
    let mut filter = Filter::run(series, noise, memory);
    let now_mm = filter.x[0].exp();
    filter.ahead(AHEAD_DAYS / MONTH, memory);
    let (then, sd) = (filter.x[0], filter.p[(0, 0)].sqrt());
    Some(Forecast {
        time: last.time.plus_s(AHEAD_DAYS * 86_400.0),
        now_mm,
        then_mm: then.exp(),
        from_mm: (then - 1.96 * sd).exp(),
        to_mm: (then + 1.96 * sd).exp(),
        direction_deg: series.at,
        tests: series.tests.len(),
    })
}
