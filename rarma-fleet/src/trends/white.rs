//! Tests freed of what those before tell of them: whitening, a row a test.
//!
//! A row of the Cholesky factor needs the rows before it only, so that the whitening of the first n tests
//! serves the look at n + 1, too, but for the weight of the last two tests: whether a test is a bad one shows
//! when the next two have come.

use super::noise::Noise;
use super::series::{Series, Test};
use std::f64::consts::TAU;

/// A test agrees with another where they differ by less than so many deviations of such a difference.
const AGREE: f64 = 1.5;
/// Neighbours on each side that a test is compared with.
const NEIGHBOURS: usize = 2;

/// One channel of the first tests of a series.
pub(super) struct White {
    noise: Noise,
    channel: usize,
    factor: Vec<Vec<f64>>,
    /// Whitened: the values, then the level, then a column for each candidate.
    columns: Vec<Vec<f64>>,
}

impl White {
    pub fn new(noise: Noise, channel: usize, columns: usize) -> Self {
        Self {
            noise,
            channel,
            factor: Vec::new(),
            columns: vec![Vec::new(); columns],
        }
    }

    /// A whitened column.
    pub fn column(&self, place: usize) -> &[f64] {
        &self.columns[place]
    }

    /// Goes on to the first `n` tests. `raw` tells a column's value at a test.
    pub fn look(
        &mut self,
        series: &Series,
        days: &[f64],
        n: usize,
        raw: impl Fn(usize, usize) -> f64,
    ) {
        // Those whose neighbours had not all come are done again.
        let sure = self.factor.len().saturating_sub(NEIGHBOURS);
        self.factor.truncate(sure);
        for column in &mut self.columns {
            column.truncate(sure);
        }
        for t in sure..n {
            let row = self.row(&series.tests, days, t, n);
            for (place, column) in self.columns.iter_mut().enumerate() {
                let told: f64 = row.iter().zip(column.iter()).map(|(l, x)| l * x).sum();
                column.push((raw(place, t) - told) / row[t]);
            }
            self.factor.push(row);
        }
    }

    /// Row t of the Cholesky factor of the covariance.
    fn row(&self, tests: &[Test], days: &[f64], t: usize, n: usize) -> Vec<f64> {
        let mut row = Vec::with_capacity(t + 1);
        for j in 0..t {
            let other = &self.factor[j];
            let told: f64 = row
                .iter()
                .zip(other)
                .map(|(a, b): (&f64, &f64)| a * b)
                .sum();
            row.push((self.shared(tests, days, t, j) - told) / other[j]);
        }
        let told: f64 = row.iter().map(|a| a * a).sum();
        let own = self.noise.test_sd.powi(2) * self.weight(tests, t, n);
        let whole = self.shared(tests, days, t, t) + own - told;
        // At least a thousandth of a test's own variance: nothing is told to the last digit.
        row.push(
            whole
                .max(1e-3 * self.noise.test_sd.powi(2))
                .max(1e-14)
                .sqrt(),
        );
        row
    }

    /// What two tests have in common: operator, tool, season.
    fn shared(&self, tests: &[Test], days: &[f64], i: usize, j: usize) -> f64 {
        let season = self.noise.season_sd.powi(2) * ((days[i] - days[j]) / 365.25 * TAU).cos();
        let same = |a: &Option<String>, b: &Option<String>| i == j || (a.is_some() && a == b);
        let operator = if same(&tests[i].operator, &tests[j].operator) {
            self.noise.operator_sd.powi(2)
        } else {
            0.0
        };
        let tool = if same(&tests[i].tool, &tests[j].tool) {
            self.noise.tool_sd.powi(2)
        } else {
            0.0
        };
        season + operator + tool
    }

    /// How much more variance a test has that agrees with none of its neighbours: 1 of one that agrees, the
    /// square of its distance from the nearest one else. The first test after a change looks like a bad one, until
    /// the next agrees with it. Neighbours with another tool are asked only where there is none with the same: they
    /// may differ by so much more that they would agree with anything.
    fn weight(&self, tests: &[Test], t: usize, n: usize) -> f64 {
        let window = t.saturating_sub(NEIGHBOURS)..(t + NEIGHBOURS + 1).min(n);
        let distance = |j: usize| {
            let (a, b) = (&tests[t], &tests[j]);
            let mut v = self.noise.test_sd.powi(2);
            if a.operator != b.operator {
                v += self.noise.operator_sd.powi(2);
            }
            if a.tool != b.tool {
                v += self.noise.tool_sd.powi(2);
            }
            (a.y[self.channel] - b.y[self.channel]).abs() / (2.0 * v).max(1e-14).sqrt()
        };
        let nearest = |same: bool| {
            let those = window
                .clone()
                .filter(|&j| j != t && (!same || tests[j].tool == tests[t].tool));
            those.map(distance).fold(f64::INFINITY, f64::min)
        };
        let nearest = if nearest(true).is_finite() {
            nearest(true)
        } else {
            nearest(false)
        };
        if nearest.is_finite() && nearest > AGREE {
            nearest * nearest
        } else {
            1.0
        }
    }
}
