//! What a change does to the limit depth of the whole machine.
//!
//! A mode that loses damping lowers the limit only where that mode is the one that chatters. Which that is
//! tells the linked system: widths by direction, each with the frequency of its chatter. The widths of the last
//! tests before the change, each direction with what the change does to it, give the limit before and after:
//!
//! ```text
//! limit = min_θ b(θ),   b'(θ) = b(θ)·g(θ)
//! damping of a mode, by r:     g = r(1+ζr)/(1+ζ) where that mode chatters (a_lim ∝ 2kζ(1+ζ)), else 1
//! its frequency, by r:         g = r² there (the mass stays), else 1
//! stiffness along α, by r:     g = 1/(1 + (1/r − 1)·cos²(θ − α)) (compliances add), r where all directions changed alike
//! ```
//!
//! A mode that chattered nowhere before has g = 1 everywhere: how far it is from being the one is in no record. Of a
//! loss that is an optimistic limit.

use super::change::Change;
use super::series::{Series, SeriesKind};
use crate::record::{Quantity, Utc};
use crate::store::MachineReading;
use std::collections::BTreeMap;

/// Tests before a change whose mean counts, most.
const TESTS: usize = 6;
/// Farthest that chatter may be from √(1+2ζ) times the frequency of a mode, as a part of it, to be that mode's:
/// as far as a mode may go from test to test.
const SAME: f64 = 0.08;
/// The plane in which the tool is pushed, where a machine has several.
const TOOL_PLANE: &str = "XY";

/// A direction of a test of the linked system.
#[derive(Default)]
struct Direction {
    /// ln of width × specific cutting force.
    width: Option<f64>,
    chatter_hz: Option<f64>,
}

/// Directions of a test in whole degrees, those that are opposite together.
type Polar = BTreeMap<i64, Vec<Direction>>;

/// The limit of a machine, test by test.
pub(super) struct Depth<'a> {
    tests: Vec<(Utc, Polar)>,
    series: &'a [Series],
}

impl<'a> Depth<'a> {
    /// Of the readings of one machine, and of the series they became.
    pub fn of_machine(readings: &[MachineReading], series: &'a [Series]) -> Self {
        let mut tests: BTreeMap<_, BTreeMap<i64, BTreeMap<i64, Direction>>> = BTreeMap::new();
        for r in readings {
            let (Quantity::LimitWidth | Quantity::ChatterFrequency) = r.quantity else {
                continue;
            };
            #[allow(clippy::cast_possible_truncation, reason = "0 to 359")]
            let whole = r.at.rem_euclid(360.0).round() as i64;
            let test = tests.entry((r.time, &r.id)).or_default();
            let there = (test.entry(whole % 180).or_default())
                .entry(whole)
                .or_default();
            match (r.quantity, r.place.parse::<f64>()) {
                (Quantity::LimitWidth, Ok(ks)) if ks > 0.0 && r.value > 0.0 => {
                    there.width = Some((r.value * ks).ln());
                }
                (Quantity::ChatterFrequency, _) => there.chatter_hz = Some(r.value),
                _ => {}
            }
        }
        let polar = |of: BTreeMap<i64, BTreeMap<i64, Direction>>| {
            (of.into_iter())
                .map(|(axis, both)| (axis, both.into_values().collect()))
                .collect()
        };
        Self {
            tests: (tests.into_iter())
                .map(|((time, _), of)| (time, polar(of)))
                .collect(),
            series,
        }
    }

    /// What a change does to the limit, percent; `None` where it says nothing of it, or the tests before it do not
    /// say which mode chatters.
    pub fn percent(&self, change: &Change) -> Option<f64> {
        let ratio = 1.0 + change.percent? / 100.0;
        let effect: Effect = match change.what {
            SeriesKind::Limit => return change.percent,
            SeriesKind::Plane if self.is_of_tool(&change.place) => {
                let angle = change.direction_deg;
                Box::new(move |axis, _| Some(along(ratio, axis, angle)))
            }
            SeriesKind::Damping | SeriesKind::Frequency => {
                let factor = if change.what == SeriesKind::Frequency {
                    ratio * ratio
                } else {
                    let zeta = self.zeta(&change.place, change.at, change.since)?;
                    ratio * (1.0 + zeta * ratio) / (1.0 + zeta)
                };
                let mode = (change.place.as_str(), change.at);
                Box::new(move |_, chatter_hz| {
                    let of_this = self.mode(chatter_hz?, speed(mode.0), change.since) == Some(mode);
                    Some(if of_this { factor } else { 1.0 })
                })
            }
            _ => return None,
        };
        let (mut before, mut after) = (f64::INFINITY, f64::INFINITY);
        for (axis, (width, chatter_hz)) in self.last_before(change.since) {
            let factor = effect(axis, chatter_hz)?;
            before = before.min(width);
            after = after.min(width + factor.ln());
        }
        before
            .is_finite()
            .then(|| 100.0 * ((after - before).exp() - 1.0))
    }

    /// ln of the width in each direction, mean of the last tests before a time, and the frequency of the chatter
    /// there, their median.
    fn last_before(&self, since: Utc) -> BTreeMap<i64, (f64, Option<f64>)> {
        let known = self.tests.partition_point(|(time, _)| *time < since);
        let mut all: Polar = BTreeMap::new();
        for (_, polar) in &self.tests[known.saturating_sub(TESTS)..known] {
            for (&axis, found) in polar {
                all.entry(axis)
                    .or_default()
                    .extend(found.iter().map(|d| Direction { ..*d }));
            }
        }
        let known = |(axis, found): (i64, Vec<Direction>)| {
            let widths: Vec<f64> = found.iter().filter_map(|d| d.width).collect();
            let chatter = found.iter().filter_map(|d| d.chatter_hz).collect();
            let mean = widths.iter().sum::<f64>() / widths.len() as f64;
            (!widths.is_empty()).then_some((axis, (mean, median(chatter))))
        };
        all.into_iter().filter_map(known).collect()
    }

    /// A plane in which the tool is pushed: the only one of the machine, or the one of that name.
    fn is_of_tool(&self, plane: &str) -> bool {
        let planes = self.series.iter().filter(|s| s.kind == SeriesKind::Plane);
        plane == TOOL_PLANE || planes.count() == 1
    }

    /// The mode that chatters at that frequency, by place and frequency, of those at one speed.
    fn mode(&self, chatter_hz: f64, speed: &str, since: Utc) -> Option<(&str, f64)> {
        let modes = (self.series.iter())
            .filter(|s| s.kind == SeriesKind::Frequency && self::speed(&s.place) == speed);
        let off = |s: &Series| {
            let zeta = self.zeta(&s.place, s.at, since).unwrap_or(0.0);
            let chatter = s.at * (1.0 + 2.0 * zeta.max(0.0)).sqrt();
            (chatter_hz / chatter).ln().abs()
        };
        let (off, nearest) = modes
            .map(|s| (off(s), s))
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        (off < SAME).then_some((&nearest.place, nearest.at))
    }

    /// Damping ratio of a mode: median of its tests before a time.
    fn zeta(&self, place: &str, at: f64, since: Utc) -> Option<f64> {
        let is = |s: &&Series| {
            s.kind == SeriesKind::Damping && s.place == place && (s.at - at).abs() < 1e-9 * at
        };
        let series = self.series.iter().find(is)?;
        let before = series.tests.iter().take_while(|t| t.time < since);
        median(before.map(|t| t.y[0].exp()).collect())
    }
}

/// What a change does to the width in a direction (degrees) where it chatters at a frequency; `None`: not known.
type Effect<'a> = Box<dyn Fn(i64, Option<f64>) -> Option<f64> + 'a>;

/// Stiffness in a direction over what it was, where compliance came in another, degrees.
fn along(ratio: f64, axis: i64, angle_deg: Option<f64>) -> f64 {
    let Some(angle) = angle_deg else {
        return ratio;
    };
    #[allow(clippy::cast_precision_loss, reason = "0 to 179")]
    let part = (axis as f64 - angle).to_radians().cos().powi(2);
    1.0 / (1.0 + (1.0 / ratio - 1.0) * part)
}

/// Of `X 9000` the speed.
fn speed(place: &str) -> &str {
    place.rsplit(' ').next().unwrap_or(place)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
