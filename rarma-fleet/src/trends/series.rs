//! Readings to series: one number a test, or the three of a plane.

use crate::record::{Quantity, Utc};
use crate::store::MachineReading;
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use std::collections::BTreeMap;

/// What a series is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SeriesKind {
    /// Compliance of a plane: ln of its mean, and its cosine and sine of 2θ over the mean.
    Plane,
    /// ln of a mode's frequency.
    Frequency,
    /// ln of a mode's damping.
    Damping,
    /// ln of the widest stable cut in the worst direction.
    Limit,
    /// ln of the width of a plane's loops, mean over all directions.
    Hysteresis,
    /// How much longer one axis measures than the other, µm.
    ScaleMismatch,
    /// Departure from a right angle, µrad.
    Squareness,
    /// Of an axis, µm.
    Straightness,
    /// Of an axis, µm.
    Backlash,
    /// Of an axis, µm.
    LateralPlay,
    /// How much more one axis lags than the other, ms.
    ServoMismatch,
}

impl SeriesKind {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Plane,
        Self::Frequency,
        Self::Damping,
        Self::Limit,
        Self::Hysteresis,
        Self::ScaleMismatch,
        Self::Squareness,
        Self::Straightness,
        Self::Backlash,
        Self::LateralPlay,
        Self::ServoMismatch,
    ];

    /// Unit of a machine error, which may be 0 or of either sign; `None` of what is tested as ln.
    #[must_use]
    pub fn unit(self) -> Option<&'static str> {
        match self {
            Self::Plane | Self::Frequency | Self::Damping | Self::Limit | Self::Hysteresis => None,
            Self::Squareness => Some("µrad"),
            Self::ScaleMismatch | Self::Straightness | Self::Backlash | Self::LateralPlay => {
                Some("µm")
            }
            Self::ServoMismatch => Some("ms"),
        }
    }
}

/// One test.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// When.
    pub time: Utc,
    /// Values; of a plane three, else the first.
    pub y: [f64; 3],
    /// Operator.
    pub operator: Option<String>,
    /// Tool.
    pub tool: Option<String>,
}

/// Tests of one thing of one machine, by time.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Machine.
    pub machine: String,
    /// What.
    pub kind: SeriesKind,
    /// Plane, or axis and speed; of an error its plane and name.
    pub place: String,
    /// Frequency of the mode (Hz, its median), direction of the limit (degrees), force of an error (N); 0 of a plane.
    pub at: f64,
    /// The tests.
    pub tests: Vec<Test>,
}

impl Series {
    /// Values a test.
    #[must_use]
    pub fn width(&self) -> usize {
        if self.kind == SeriesKind::Plane { 3 } else { 1 }
    }

    /// Days from the first test.
    #[must_use]
    pub fn days(&self) -> Vec<f64> {
        let first = self.tests[0].time;
        self.tests
            .iter()
            .map(|t| t.time.since_s(first) / 86_400.0)
            .collect()
    }
}

/// Farthest that a mode may be from where it was, as a part of its frequency, to be the same.
const SAME_MODE: f64 = 0.08;

/// Readings test by test.
pub(super) fn by_test(readings: &[MachineReading]) -> Vec<Vec<&MachineReading>> {
    let mut tests: BTreeMap<_, Vec<&MachineReading>> = BTreeMap::new();
    for reading in readings {
        tests
            .entry((reading.time, &reading.id))
            .or_default()
            .push(reading);
    }
    tests.into_values().collect()
}

pub(super) fn test(of: &MachineReading, y: [f64; 3]) -> Test {
    Test {
        time: of.time,
        y,
        operator: of.operator.clone(),
        tool: of.tool.clone(),
    }
}

pub(super) fn series(
    readings: &[MachineReading],
    kind: SeriesKind,
    at: f64,
    tests: Vec<Test>,
) -> Series {
    let first = &readings[0];
    Series {
        machine: first.machine.clone(),
        kind,
        place: first.place.clone(),
        at,
        tests,
    }
}

/// m, m·a and m·b of m·(1 + a·cos 2θ + b·sin 2θ) by least squares: of a tensor in a plane it is all there is. Fewer than
/// five directions, or all of them on one side, do not determine it.
pub(super) fn tensor(rays: &[&MachineReading]) -> Option<Vector3<f64>> {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for ray in rays {
        let (s, c) = (2.0 * ray.at.to_radians()).sin_cos();
        let row = Vector3::new(1.0, c, s);
        normal += row * row.transpose();
        right += row * ray.value;
    }
    let scaled = normal / rays.len() as f64;
    if rays.len() < 5 || scaled.determinant() < 0.02 {
        return None;
    }
    Some(normal.cholesky()?.solve(&right))
}

/// The compliance of a plane. A test that does not determine its tensor is left out.
pub(super) fn plane(readings: &[MachineReading]) -> Option<Series> {
    let tests: Vec<Test> = (by_test(readings).iter())
        .filter_map(|rays| {
            let x = tensor(rays)?;
            (x[0] > 0.0).then(|| test(rays[0], [x[0].ln(), x[1] / x[0], x[2] / x[0]]))
        })
        .collect();
    (!tests.is_empty()).then(|| series(readings, SeriesKind::Plane, 0.0, tests))
}

/// The limit in the direction that is the worst in the mean over all tests, with the one opposite: the least of
/// twelve noisy ones would be too low by their noise.
pub(super) fn limit(readings: &[MachineReading]) -> Option<Series> {
    let tests = by_test(readings);
    let mut sums: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
    let axis = |r: &MachineReading| {
        #[allow(clippy::cast_possible_truncation, reason = "0 to 179")]
        let whole = r.at.rem_euclid(180.0).round() as i64;
        whole % 180
    };
    for reading in readings.iter().filter(|r| r.value > 0.0) {
        let sum = sums.entry(axis(reading)).or_insert((0.0, 0.0));
        *sum = (sum.0 + 1.0, sum.1 + reading.value.ln());
    }
    let mean = |(n, sum): &(f64, f64)| sum / n;
    let (worst, _) = sums.iter().min_by(|a, b| mean(a.1).total_cmp(&mean(b.1)))?;
    let value = |rays: &Vec<&MachineReading>| {
        let there: Vec<f64> = rays
            .iter()
            .filter(|r| axis(r) == *worst && r.value > 0.0)
            .map(|r| r.value.ln())
            .collect();
        let mean = there.iter().sum::<f64>() / there.len() as f64;
        (!there.is_empty()).then(|| test(rays[0], [mean, 0.0, 0.0]))
    };
    let tests: Vec<Test> = tests.iter().filter_map(value).collect();
    #[allow(clippy::cast_precision_loss, reason = "0 to 179")]
    let at = *worst as f64;
    (!tests.is_empty()).then(|| series(readings, SeriesKind::Limit, at, tests))
}

/// A mode that is followed.
struct Track {
    f_hz: f64,
    tests: Vec<(Test, Option<f64>)>,
}

/// Modes told apart from test to test: each goes to the nearest that is followed, within 8 % of where that was
/// last; a mode that nobody expects begins a new one.
pub(super) fn modes(readings: &[MachineReading]) -> Vec<Series> {
    let mut places: BTreeMap<&str, Vec<MachineReading>> = BTreeMap::new();
    for reading in readings {
        if matches!(reading.quantity, Quantity::Frequency | Quantity::Damping) {
            places
                .entry(&reading.place)
                .or_default()
                .push(reading.clone());
        }
    }
    places
        .into_values()
        .flat_map(|of_place| followed(&of_place))
        .collect()
}

fn followed(readings: &[MachineReading]) -> Vec<Series> {
    let mut tracks: Vec<Track> = Vec::new();
    for of_test in by_test(readings) {
        let found = of_test.iter().filter(|r| r.quantity == Quantity::Frequency);
        // Pairs by how near they are; each mode and each track once.
        let found: Vec<&&MachineReading> = found.collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (m, mode) in found.iter().enumerate() {
            for (t, track) in tracks.iter().enumerate() {
                let off = (mode.value / track.f_hz).ln().abs();
                if off < SAME_MODE {
                    pairs.push((off, m, t));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut goes: Vec<Option<usize>> = vec![None; found.len()];
        let mut taken = vec![false; tracks.len()];
        for (_, m, t) in pairs {
            if goes[m].is_none() && !taken[t] {
                (goes[m], taken[t]) = (Some(t), true);
            }
        }
        for (mode, to) in found.iter().zip(goes) {
            let damping = (of_test.iter())
                .find(|r| {
                    r.quantity == Quantity::Damping && (r.at - mode.at).abs() < 1e-9 * mode.at
                })
                .map(|r| r.value)
                .filter(|z| *z > 0.0);
            let one = (test(mode, [mode.value.ln(), 0.0, 0.0]), damping);
            match to {
                Some(t) => {
                    tracks[t].f_hz = mode.value;
                    tracks[t].tests.push(one);
                }
                None => tracks.push(Track {
                    f_hz: mode.value,
                    tests: vec![one],
                }),
            }
        }
    }
    let mut all = Vec::new();
    for track in tracks {
        let mut sorted: Vec<f64> = track.tests.iter().map(|(t, _)| t.y[0]).collect();
        sorted.sort_by(f64::total_cmp);
        let at = sorted[sorted.len() / 2].exp();
        let damping: Vec<Test> = (track.tests.iter())
            .filter_map(|(t, zeta)| {
                zeta.map(|z| Test {
                    y: [z.ln(), 0.0, 0.0],
                    ..t.clone()
                })
            })
            .collect();
        all.push(series(readings, SeriesKind::Damping, at, damping));
        let frequency = track.tests.into_iter().map(|(t, _)| t).collect();
        all.push(series(readings, SeriesKind::Frequency, at, frequency));
    }
    all
}
