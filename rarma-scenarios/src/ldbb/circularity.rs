//! What a ball-bar report says of a circle: the deviations that ISO 230-4 names, and which
//! machine errors they come from, the largest first.
//!
//! The deviations are defined from general knowledge of the standard, not from its text. A
//! cause counts by the range of what it alone adds to the length of the bar, all round and in
//! both directions: the circular deviation of a machine that had no other error.

use super::errors::{AtForce, Cause, Circularity, OneWay};
use super::options::Options;
use rarma_rigs::ldbb::{Circle, Deviation, MAX_TERMS, Sense, Terms};

/// Degrees between two angles at which a cause is evaluated.
const STEP_DEG: f64 = 0.5;

impl From<&Deviation<f64>> for OneWay {
    fn from(d: &Deviation<f64>) -> Self {
        Self {
            g_um: 1e6 * d.least_zone_m,
            f_max_um: 1e6 * d.radial_m.0,
            f_min_um: 1e6 * d.radial_m.1,
        }
    }
}

impl Circularity {
    /// Of the paths that there are, and of both together.
    pub(super) fn of(
        ccw: Option<&Deviation<f64>>,
        cw: Option<&Deviation<f64>>,
        both: Option<&Deviation<f64>>,
    ) -> Self {
        Self {
            ccw: ccw.map(OneWay::from),
            cw: cw.map(OneWay::from),
            g_b_um: both.map(|d| 1e6 * d.least_zone_m),
            d_um: both.map(|d| 1e6 * d.radius_m),
        }
    }

    /// What a tolerance is compared with, µm, and its symbol: G(b), or G of the one direction.
    pub fn judged(&self) -> Option<(&'static str, f64)> {
        let one = |name, way: Option<OneWay>| way.map(|way| (name, way.g_um));
        self.g_b_um
            .map(|g| ("G(b)", g))
            .or(one("G(CCW)", self.ccw))
            .or(one("G(CW)", self.cw))
    }
}

/// The causes at one force, the largest first; `axes` are the names of the plane's.
pub fn causes(e: &AtForce, options: &Options, [a, b]: [&str; 2]) -> Vec<Cause> {
    let m = |um: f64| 1e-6 * um;
    let mut terms: Vec<(String, usize, f64)> = vec![
        (
            "scale mismatch".into(),
            3,
            m(e.scale_mismatch_um.value) / 4.0,
        ),
        (
            if e.squareness_includes_servo {
                "squareness, with the servo mismatch".into()
            } else {
                "squareness".into()
            },
            4,
            -m(e.squareness_urad.value) * options.radius_m / 2.0,
        ),
    ];
    let mut pair = |what: &str, columns: [usize; 2], values: [f64; 2]| {
        for (axis, (column, value)) in [a, b].into_iter().zip(columns.into_iter().zip(values)) {
            terms.push((format!("{what} of {axis}"), column, value));
        }
    };
    if let Some([x, y]) = e.straightness_um {
        pair(
            "straightness",
            [6, 5],
            [m(x.value) / 4.0, -m(y.value) / 4.0],
        );
    }
    if let Some([x, y]) = e.backlash_um {
        pair("backlash", [7, 8], [m(x.value), m(y.value)]);
    }
    if let Some([x, y]) = e.lateral_play_um {
        pair("lateral play", [9, 10], [m(x.value), m(y.value)]);
    }
    if let Some(servo) = e.servo_mismatch_ms {
        let value = 1e-3 * servo.value * options.feed_m_s / 2.0;
        terms.push(("servo mismatch".into(), 11, value));
    }
    let both = e.hysteresis_um.is_some();
    let mut causes: Vec<Cause> = terms
        .into_iter()
        .map(|(name, column, value)| Cause {
            name,
            um: 1e6 * value.abs() * range(column, both, options),
            share: 0.0,
        })
        .collect();
    if let Some([x, y]) = e.cyclic_um {
        for (axis, cyclic) in [(a, x), (b, y)] {
            causes.push(Cause {
                name: format!("cyclic error of {axis}"),
                um: 2.0 * cyclic.value.abs(),
                share: 0.0,
            });
        }
    }
    let spikes = e.spikes_um.iter().flat_map(|(_, heights)| heights);
    let highest = spikes.fold(0.0, |most: f64, h| most.max(h.abs()));
    if highest > 0.0 {
        causes.push(Cause {
            name: "reversal spikes".into(),
            um: highest,
            share: 0.0,
        });
    }
    let sum: f64 = causes.iter().map(|c| c.um).sum();
    for cause in &mut causes {
        cause.share = if sum > 0.0 { cause.um / sum } else { 0.0 };
    }
    causes.sort_by(|x, y| y.um.total_cmp(&x.um));
    causes
}

/// Range of a column all round, in the directions that were run.
fn range(column: usize, both: bool, options: &Options) -> f64 {
    let circle = Circle {
        radius_m: options.radius_m,
        feed_m_s: options.feed_m_s,
        pitch_m: 0.0,
    };
    let terms = Terms::of(true, 360.0, false);
    let senses = if both {
        &[Sense::Ccw, Sense::Cw][..]
    } else {
        &[Sense::Ccw]
    };
    let angles = 0..(360.0 / STEP_DEG) as usize;
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for sense in senses {
        for k in angles.clone() {
            // Between the reversals: at one an axis stands, and its column is 0.
            let theta = ((k as f64 + 0.5) * STEP_DEG).to_radians();
            let row: [f64; MAX_TERMS] = terms.row(theta, *sense, &circle);
            (low, high) = (low.min(row[column]), high.max(row[column]));
        }
    }
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ldbb::evaluate::evaluate;
    use rarma_recordings::input::RunData;

    /// A test at one force, both ways, of a machine with these errors.
    fn tested(error: impl Fn(f64, f64) -> f64) -> AtForce {
        let run = |number, sense: Sense| RunData {
            number,
            sense,
            pressure_pa: 4e4,
            forces_n: Vec::new(),
            set_pa: Some(4e4),
            force_n: 36.0,
            rising: true,
            points: (0..720)
                .map(|k| {
                    let theta = (0.5 * f64::from(k) + 0.25).to_radians();
                    (theta, error(theta, sense.sign()))
                })
                .collect(),
        };
        let runs = [run(0, Sense::Ccw), run(1, Sense::Cw)];
        let findings = evaluate(&runs, &[], &Options::default()).expect("findings");
        findings.errors.into_iter().next().expect("one force")
    }

    #[test]
    fn each_cause_alone_makes_the_deviation_that_is_measured() {
        // Scale mismatch of 8 µm: ± 2 µm; backlash of 3 µm: ± 1.5 µm.
        type Error = fn(f64, f64) -> f64;
        let cases: [(&str, f64, Error); 2] = [
            ("scale mismatch", 4.0, |t, _| 2e-6 * (2.0 * t).cos()),
            ("backlash of X", 3.0, |t, d| {
                1.5e-6 * d * t.sin().signum() * t.cos()
            }),
        ];
        for (name, um, error) in cases {
            let e = tested(error);
            let causes = causes(&e, &Options::default(), ["X", "Y"]);
            assert_eq!(causes[0].name, name);
            assert!((causes[0].um - um).abs() < 0.03 * um, "{causes:?}");
            assert!(causes[0].share > 0.9, "{causes:?}");
            assert!((causes.iter().map(|c| c.share).sum::<f64>() - 1.0).abs() < 1e-9);
            let (symbol, g) = e.circularity.judged().expect("both ways");
            assert_eq!(symbol, "G(b)");
            assert!((g - um).abs() < 0.03 * um, "{g}");
        }
    }

    #[test]
    fn deviations_of_each_direction_and_of_both() {
        // The clockwise path lies 3 µm outside.
        let e = tested(|t, d| 2e-6 * (2.0 * t).cos() + if d < 0.0 { 3e-6 } else { 0.0 });
        let c = e.circularity;
        let (ccw, cw) = (c.ccw.expect("run"), c.cw.expect("run"));
        for way in [ccw, cw] {
            assert!((way.g_um - 4.0).abs() < 0.05, "{way:?}");
        }
        assert!((cw.f_max_um - 5.0).abs() < 0.05 && (cw.f_min_um - 1.0).abs() < 0.05);
        assert!((c.g_b_um.expect("both") - 7.0).abs() < 0.05, "{c:?}");
        assert!((c.d_um.expect("both") - 1.5).abs() < 0.05, "{c:?}");
    }
}
