//! How far two tests of the same machine differ where nothing has changed: of the whole plant.
//!
//! From neighbouring tests of a series: their difference has twice the variance of a test, and twice
//! that of an operator or of a tool besides where that is another. Scales are medians, which a change or
//! a bad test does not move. Few pairs are mixed with what is usual (`Usual`), which counts as eight.

use super::series::{Series, SeriesKind, Test};
use serde::Serialize;

/// Deviations of one kind of series, and of one part of it: of ln, of errors in their unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    /// Kind.
    pub kind: SeriesKind,
    /// Of a plane: its mean (0), or its 2θ parts (1); else 0.
    pub part: usize,
    /// From test to test, standard deviation.
    pub test_sd: f64,
    /// From operator to operator.
    pub operator_sd: f64,
    /// From tool to tool.
    pub tool_sd: f64,
    /// Of the season: standard deviation of each of its two parts.
    pub season_sd: f64,
    /// Pairs of tests they come from.
    pub pairs: usize,
}

/// What is usual, where a plant has told little: test, operator, tool, season.
struct Usual(f64, f64, f64, f64);

/// How many pairs the usual counts for.
const USUAL_PAIRS: f64 = 8.0;
/// Two tests further apart than this are no neighbours, days.
const NEIGHBOURS_DAYS: f64 = 60.0;
/// A season is looked for in so many days.
const SEASON_DAYS: f64 = 300.0;

fn usual(kind: SeriesKind, part: usize) -> Usual {
    match (kind, part) {
        (SeriesKind::Plane, 0) => Usual(0.008, 0.01, 0.0, 0.004),
        (SeriesKind::Plane, _) => Usual(0.005, 0.002, 0.0, 0.001),
        (SeriesKind::Frequency, _) => Usual(0.0015, 0.0005, 0.01, 0.002),
        (SeriesKind::Damping, _) => Usual(0.03, 0.01, 0.06, 0.02),
        (SeriesKind::Limit, _) => Usual(0.04, 0.01, 0.01, 0.02),
        (SeriesKind::Hysteresis, _) => Usual(0.04, 0.02, 0.0, 0.02),
        // In their own units from here on.
        (SeriesKind::ScaleMismatch, _) => Usual(1.0, 0.2, 0.0, 1.0),
        (SeriesKind::Squareness, _) => Usual(2.0, 0.5, 0.0, 1.0),
        (SeriesKind::Straightness, _) => Usual(0.2, 0.05, 0.0, 0.1),
        (SeriesKind::Backlash, _) => Usual(0.1, 0.03, 0.0, 0.05),
        (SeriesKind::LateralPlay, _) => Usual(0.1, 0.03, 0.0, 0.03),
        (SeriesKind::ServoMismatch, _) => Usual(0.02, 0.005, 0.0, 0.005),
    }
}

/// Deviations of every kind and part.
#[must_use]
pub fn of_plant(all: &[Series]) -> Vec<Noise> {
    let parts = |kind: SeriesKind| {
        if kind == SeriesKind::Plane {
            0..2
        } else {
            0..1
        }
    };
    SeriesKind::ALL
        .into_iter()
        .flat_map(|kind| parts(kind).map(move |part| (kind, part)))
        .map(|(kind, part)| of_kind(all, kind, part))
        .collect()
}

/// The one of a kind and of a channel (of a plane: 0 its mean, 1 and 2 its 2θ parts).
#[must_use]
pub fn of_channel(all: &[Noise], kind: SeriesKind, channel: usize) -> Noise {
    let part = channel.min(1);
    *all.iter()
        .find(|n| n.kind == kind && n.part == part)
        .expect("every kind is there")
}

fn of_kind(all: &[Series], kind: SeriesKind, part: usize) -> Noise {
    let channels = if part == 0 { 0..1 } else { 1..3 };
    let Usual(test_sd, operator_sd, tool_sd, season_sd) = usual(kind, part);
    // Squared scales of differences: nothing else, another operator, another tool.
    let (mut same, mut operator, mut tool) = (Vec::new(), Vec::new(), Vec::new());
    for series in all.iter().filter(|s| s.kind == kind) {
        for pair in series.tests.windows(2) {
            if pair[1].time.since_s(pair[0].time) > NEIGHBOURS_DAYS * 86_400.0 {
                continue;
            }
            for channel in channels.clone() {
                let d = (pair[1].y[channel] - pair[0].y[channel]).abs();
                match (
                    pair[0].operator != pair[1].operator,
                    pair[0].tool != pair[1].tool,
                ) {
                    (false, false) => same.push(d),
                    (true, false) => operator.push(d),
                    (_, true) => tool.push(d),
                }
            }
        }
    }
    let pairs = same.len() + operator.len() + tool.len();
    let mixed = |estimate: f64, pairs: usize, usual_sd: f64| {
        let n = pairs as f64;
        (n * estimate.max(0.0) + USUAL_PAIRS * usual_sd * usual_sd) / (n + USUAL_PAIRS)
    };
    let test = mixed(half_variance(&mut same), same.len(), test_sd);
    let by_operator = mixed(
        half_variance(&mut operator) - test,
        operator.len(),
        operator_sd,
    );
    let by_tool = mixed(
        half_variance(&mut tool) - test - by_operator,
        tool.len(),
        tool_sd,
    );
    let mut noise = Noise {
        kind,
        part,
        test_sd: test.sqrt(),
        operator_sd: by_operator.sqrt(),
        tool_sd: by_tool.sqrt(),
        season_sd,
        pairs,
    };
    noise.season_sd = season(all, &noise, channels, season_sd);
    noise
}

/// Half the variance of differences, by their median distance; 0 of none.
fn half_variance(differences: &mut [f64]) -> f64 {
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    (*median / 0.6745).powi(2) / 2.0
}

/// The season's size: the median over series of a year's cosine and sine, less what noise makes of them.
fn season(all: &[Series], noise: &Noise, channels: std::ops::Range<usize>, usual_sd: f64) -> f64 {
    let mut squares = Vec::new();
    for series in all
        .iter()
        .filter(|s| s.kind == noise.kind && s.tests.len() >= 8)
    {
        let days = series.days();
        if days.last().is_none_or(|&last| last < SEASON_DAYS) {
            continue;
        }
        for channel in channels.clone() {
            squares.push(year(&series.tests, &days, channel));
        }
    }
    if squares.is_empty() {
        return usual_sd;
    }
    let count = squares.len();
    let middle = count / 2;
    let (_, median, _) = squares.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0));
    // Of two normal parts with variance v the median of the sum of squares is 2·ln 2·v.
    let v = median.0 / (2.0 * std::f64::consts::LN_2);
    let white = 2.0 * (noise.test_sd.powi(2) + noise.operator_sd.powi(2)) / median.1;
    let tools = noise.tool_sd.powi(2) / 3.0;
    let n = count as f64;
    let least = (0.25 * usual_sd).powi(2);
    ((n * (v - white - tools).max(least) + USUAL_PAIRS * usual_sd.powi(2)) / (n + USUAL_PAIRS))
        .sqrt()
}

/// Sum of squares of the year's two parts, and the number of tests.
fn year(tests: &[Test], days: &[f64], channel: usize) -> (f64, f64) {
    let n = tests.len() as f64;
    let mean = tests.iter().map(|t| t.y[channel]).sum::<f64>() / n;
    let (mut a, mut b) = (0.0, 0.0);
    for (test, day) in tests.iter().zip(days) {
        let (s, c) = (day / 365.25 * std::f64::consts::TAU).sin_cos();
        a += 2.0 / n * (test.y[channel] - mean) * c;
        b += 2.0 / n * (test.y[channel] - mean) * s;
    }
    (a * a + b * b, n)
}
