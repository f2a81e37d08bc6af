//! The sequential test: has it changed, since when, how, and in which direction?

use super::noise::{Noise, of_channel};
use super::series::{Series, SeriesKind};
use super::white::White;
use crate::record::Utc;
use serde::Serialize;

/// How it changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// At once.
    Step,
    /// A little every day.
    Drift,
}

/// A change beyond its uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// Of what.
    pub what: SeriesKind,
    /// Plane, or axis and speed; of an error its plane and name.
    pub place: String,
    /// Frequency of the mode, Hz; direction of the limit, degrees; force of an error, N; 0 of a plane.
    pub at: f64,
    /// At once, or every day.
    pub shape: Shape,
    /// Time of the test with which it was found.
    pub found: Utc,
    /// Tests after its beginning until it was found.
    pub tests: usize,
    /// Since when: the middle between the last test before and the first one after.
    pub since: Utc,
    /// Earliest and latest beginning that is nearly as likely (95 %).
    pub since_from: Utc,
    /// See there.
    pub since_to: Utc,
    /// Its size by the last test, percent of what it was: stiffness (of a plane, in the direction), frequency,
    /// damping, width, or loops; `null` of an error.
    pub percent: Option<f64>,
    /// Standard deviation of that, percent.
    pub percent_sd: Option<f64>,
    /// Size of the change of an error by the last test, in its unit; `null` of what is told in percent.
    pub amount: Option<f64>,
    /// Standard deviation of that.
    pub amount_sd: Option<f64>,
    /// Unit of both.
    pub unit: Option<&'static str>,
    /// Direction of a plane in which it changed most, 0 to 180 degrees; `null` where all directions changed alike.
    pub direction_deg: Option<f64>,
    /// Standard deviation of that, degrees.
    pub direction_sd_deg: Option<f64>,
    /// What it does to the limit depth of the whole machine, the least over all directions, percent: 0 of a mode that
    /// is not the one that chatters. By the tests of the linked system before it; `null` where these do not say at which
    /// frequency it chatters (stiffness: where there are none), and of loops and errors, which say nothing of it.
    pub limit_percent: Option<f64>,
    /// Gain of the change in squared residual, and what it had to reach.
    pub statistic: f64,
    /// See there.
    pub threshold: f64,
}

/// Tests before and after a change that it needs: one bad test is none.
const LEAST_BEFORE: usize = 2;
const LEAST_AFTER: usize = 2;
/// A drift needs one more.
const LEAST_DRIFT: usize = 3;
/// Directions that are tried, degrees apart.
const DIRECTIONS_DEG: f64 = 2.5;
/// Tests that are looked back at, most.
const MOST_TESTS: usize = 120;
/// Beginnings whose gain is less by so much are nearly as likely. The 95 % of χ² with 1 degree of freedom, 3.84, held
/// the true day in 86 to 88 of 100: a beginning is no regular parameter. This, its 99 %, held it in 98 of 100.
const NEARLY: f64 = 6.63;
/// Changes of a series, most.
const MOST_CHANGES: usize = 12;

/// Chance that χ² is above x, with 1 or 3 degrees of freedom.
#[must_use]
pub fn above(x: f64, degrees: usize) -> f64 {
    let tail = libm::erfc((x / 2.0).sqrt());
    if degrees == 1 {
        tail
    } else {
        tail + (2.0 * x / std::f64::consts::PI).sqrt() * (-x / 2.0).exp()
    }
}

/// The gain that a change must reach: so that the chances of all comparisons of a year, looks × beginnings ×
/// shapes, add up to `per_year`.
#[must_use]
pub fn threshold(per_year: f64, looks_per_year: f64, tests: usize, degrees: usize) -> f64 {
    let comparisons = looks_per_year * 2.0 * tests.max(1) as f64;
    let chance = per_year / comparisons;
    let (mut low, mut high) = (0.0, 200.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if above(middle, degrees) > chance {
            low = middle
        } else {
            high = middle
        }
    }
    high
}

/// Where and how a change begins: before test `first`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Candidate {
    first: usize,
    shape: Shape,
}

impl Candidate {
    /// The change's course at a test: 0 before, then 1, or years.
    fn at(self, days: &[f64], test: usize) -> f64 {
        let begin = 0.5 * (days[self.first - 1] + days[self.first]);
        match self.shape {
            Shape::Step => f64::from(days[test] > begin),
            Shape::Drift => (days[test] - begin).max(0.0) / 365.25,
        }
    }

    /// Its place among the candidates: first 1 as a step, first 1 as a drift, first 2 …
    fn of_place(place: usize) -> Self {
        let shape = if place.is_multiple_of(2) {
            Shape::Step
        } else {
            Shape::Drift
        };
        Self {
            first: place / 2 + 1,
            shape,
        }
    }

    fn place(self) -> usize {
        (self.first - 1) * 2 + usize::from(self.shape == Shape::Drift)
    }
}

/// Score and information of a candidate in each channel.
#[derive(Debug, Clone, Copy, Default)]
struct Evidence {
    score: [f64; 3],
    information: [f64; 3],
}

/// The best of a candidate: gain, direction (none: all alike), size and its variance.
#[derive(Debug, Clone, Copy)]
struct Best {
    gain: f64,
    direction: Option<f64>,
    size: f64,
    variance: f64,
}

/// Parts of a pattern in the three channels: more compliance d in direction θ adds d/2 to the mean and
/// d/2·(cos 2θ, sin 2θ) to the rest; alike in all directions: d to the mean.
fn pattern(direction: Option<f64>) -> [f64; 3] {
    match direction {
        None => [1.0, 0.0, 0.0],
        Some(angle) => [0.5, 0.5 * (2.0 * angle).cos(), 0.5 * (2.0 * angle).sin()],
    }
}

impl Evidence {
    fn along(&self, direction: Option<f64>) -> Best {
        let w = pattern(direction);
        let score: f64 = (0..3).map(|c| w[c] * self.score[c]).sum();
        let information: f64 = (0..3).map(|c| w[c] * w[c] * self.information[c]).sum();
        if information > 0.0 {
            Best {
                gain: score * score / information,
                direction,
                size: score / information,
                variance: 1.0 / information,
            }
        } else {
            Best {
                gain: 0.0,
                direction,
                size: 0.0,
                variance: f64::INFINITY,
            }
        }
    }

    fn best(&self, width: usize) -> Best {
        let mut best = self.along(None);
        if width == 3 {
            let mut angle: f64 = 0.0;
            while angle < 180.0 {
                let there = self.along(Some(angle.to_radians()));
                if there.gain > best.gain {
                    best = there;
                }
                angle += DIRECTIONS_DEG;
            }
        }
        best
    }
}

/// A series in the form in which it is tested.
struct Tested<'a> {
    series: &'a Series,
    days: Vec<f64>,
    channels: Vec<White>,
}

/// Columns before those of the candidates: the values, and the level.
const VALUES: usize = 0;
const LEVEL: usize = 1;
const CANDIDATES: usize = 2;

impl<'a> Tested<'a> {
    fn new(series: &'a Series, noise: &[Noise]) -> Self {
        let columns = CANDIDATES + 2 * (series.tests.len() - 1);
        let channels = (0..series.width())
            .map(|c| White::new(of_channel(noise, series.kind, c), c, columns))
            .collect();
        Self {
            series,
            days: series.days(),
            channels,
        }
    }

    /// Takes the first `n` tests.
    fn look(&mut self, n: usize) {
        for (c, channel) in self.channels.iter_mut().enumerate() {
            channel.look(self.series, &self.days, n, |column, test| match column {
                VALUES => self.series.tests[test].y[c],
                LEVEL => 1.0,
                place => Candidate::of_place(place - CANDIDATES).at(&self.days, test),
            });
        }
    }

    /// Orthonormal columns of the level and of changes that are known.
    fn known(&self, channel: usize, changes: &[Candidate]) -> Vec<Vec<f64>> {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let places = std::iter::once(LEVEL).chain(changes.iter().map(|c| CANDIDATES + c.place()));
        for place in places {
            let mut v = self.channels[channel].column(place).to_vec();
            let length = dot(&v, &v).sqrt();
            without(&mut v, &basis);
            let left = dot(&v, &v).sqrt();
            if left > 1e-8 * length {
                v.iter_mut().for_each(|x| *x /= left);
                basis.push(v);
            }
        }
        basis
    }

    /// Every change that may have been in the first `n` tests besides those that are known, beginning after
    /// test `after`, each at its best.
    fn candidates(&self, n: usize, known: &[Candidate], after: usize) -> Vec<(Candidate, Best)> {
        let width = self.series.width();
        let basis: Vec<_> = (0..width).map(|c| self.known(c, known)).collect();
        let residual: Vec<Vec<f64>> = (0..width)
            .map(|c| {
                let mut y = self.channels[c].column(VALUES).to_vec();
                without(&mut y, &basis[c]);
                y
            })
            .collect();
        let mut all = Vec::new();
        for candidate in (0..2 * (n - 1)).map(Candidate::of_place) {
            let least = if candidate.shape == Shape::Drift {
                LEAST_DRIFT
            } else {
                LEAST_AFTER
            };
            if candidate.first < after + LEAST_BEFORE || candidate.first + least > n {
                continue;
            }
            let mut evidence = Evidence::default();
            for c in 0..width {
                let x = self.channels[c].column(CANDIDATES + candidate.place());
                let whole = dot(x, x);
                let lost: f64 = basis[c].iter().map(|b| dot(b, x).powi(2)).sum();
                // What the level and the known changes leave of it; next to nothing tells nothing.
                let information = whole - lost;
                if information > 1e-6 * whole {
                    evidence.score[c] = dot(x, &residual[c]);
                    evidence.information[c] = information;
                }
            }
            all.push((candidate, evidence.best(width)));
        }
        all
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes the parts along orthonormal columns out of a vector.
fn without(v: &mut [f64], basis: &[Vec<f64>]) {
    for b in basis {
        let part = dot(b, v);
        v.iter_mut().zip(b).for_each(|(x, b)| *x -= part * b);
    }
}

/// The changes of a series, in the order in which they were found; what they do to the limit depth is not told yet.
#[must_use]
pub fn changes(series: &Series, noise: &[Noise], per_year: f64) -> Vec<Change> {
    let start = series.tests.len().saturating_sub(MOST_TESTS);
    let recent = Series {
        tests: series.tests[start..].to_vec(),
        ..series.clone()
    };
    let mut tested = Tested::new(&recent, noise);
    let count = recent.tests.len();
    let years = (tested.days[count - 1] / 365.25).max(0.25);
    let looks = count as f64 / years;
    let degrees = if series.width() == 3 { 3 } else { 1 };
    let mut known: Vec<Candidate> = Vec::new();
    let mut found: Vec<Change> = Vec::new();
    let mut after = 0;
    for n in LEAST_BEFORE + LEAST_AFTER..=count {
        let limit = threshold(per_year, looks, n, degrees);
        tested.look(n);
        let all = tested.candidates(n, &known, after);
        let Some(top) = all.iter().max_by(|a, b| a.1.gain.total_cmp(&b.1.gain)) else {
            continue;
        };
        if top.1.gain < limit || found.len() >= MOST_CHANGES {
            continue;
        }
        found.push(told(&tested, n, &all, *top, limit));
        known.push(top.0);
        after = n - 1;
    }
    found
}

/// A change in words of the outside.
fn told(
    tested: &Tested<'_>,
    n: usize,
    all: &[(Candidate, Best)],
    top: (Candidate, Best),
    limit: f64,
) -> Change {
    let (candidate, best) = top;
    let tests = &tested.series.tests;
    let between = |first: usize| {
        let (a, b) = (tests[first - 1].time, tests[first].time);
        a.plus_s(0.5 * b.since_s(a))
    };
    let likely = all.iter().filter(|(_, b)| b.gain > best.gain - NEARLY);
    let firsts: Vec<usize> = likely.map(|(c, _)| c.first).collect();
    let earliest = firsts.iter().min().copied().unwrap_or(candidate.first);
    let latest = firsts.iter().max().copied().unwrap_or(candidate.first);
    // A drift by its size at the last test.
    let begin = 0.5 * (tested.days[candidate.first - 1] + tested.days[candidate.first]);
    let grown = match candidate.shape {
        Shape::Step => 1.0,
        Shape::Drift => (tested.days[n - 1] - begin) / 365.25,
    };
    let size = best.size * grown;
    let sd = best.variance.sqrt() * grown;
    let kind = tested.series.kind;
    // Compliance up is stiffness down.
    let ratio = if kind == SeriesKind::Plane {
        (-size).exp()
    } else {
        size.exp()
    };
    let percent = |ratio: f64| 100.0 * (ratio - 1.0);
    let unit = kind.unit();
    Change {
        what: kind,
        place: tested.series.place.clone(),
        at: tested.series.at,
        shape: candidate.shape,
        found: tests[n - 1].time,
        tests: n - candidate.first,
        since: between(candidate.first),
        since_from: tests[earliest - 1].time,
        since_to: tests[latest].time,
        percent: unit.is_none().then(|| percent(ratio)),
        percent_sd: unit.is_none().then_some(100.0 * ratio * sd),
        amount: unit.map(|_| size),
        amount_sd: unit.map(|_| sd),
        unit,
        direction_deg: best.direction.map(f64::to_degrees),
        direction_sd_deg: best.direction.map(|_| direction_sd(best)),
        limit_percent: None,
        statistic: best.gain,
        threshold: limit,
    }
}

/// Deviation of a direction, degrees: a turn by φ moves the 2θ parts by size·φ, whose deviation is about that of
/// the size.
fn direction_sd(best: Best) -> f64 {
    let relative = best.variance.sqrt() / best.size.abs().max(1e-12);
    relative.to_degrees().min(45.0)
}
