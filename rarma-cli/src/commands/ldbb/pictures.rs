//! Pictures of a test: deflection, stiffness, hysteresis, errors against load.

use super::Answer;
use super::circularity_pictures::circularity;
use super::cycle_pictures::{hysteresis, left_over};
use super::error_pictures::errors;
use crate::commands::els::pictures::above;
use rarma_pictures::palette::step;
use rarma_pictures::{Chart, Mark, Scale, Series, table};
use rarma_pictures::{Polar, PolarSeries};
use rarma_recordings::input::Circles;
use rarma_scenarios::ldbb::stiffness::{AllRound, Cycle, levels};

/// The page of one test.
pub(super) fn page(answer: &Answer, circles: &Circles) -> String {
    let mut body = circularity(&answer.findings.errors, answer.tolerance_um);
    body += &deflection(circles);
    if let Some(s) = &answer.findings.stiffness {
        body += &stiffness(s);
    }
    let standing = &answer.findings.standing;
    if !standing.is_empty() {
        body += &hysteresis("Hysteresis while standing", standing);
    }
    if let Some(moving) = &answer.findings.moving {
        let four: Vec<Cycle> = moving.iter().step_by(90).cloned().collect();
        body += &hysteresis("Hysteresis while moving, four of all directions", &four);
        body += &left_over(moving);
    }
    body += &errors(&answer.findings.errors, circles.conditions.axes());
    body += "<h2>Runs</h2>\n";
    let rows: Vec<Vec<String>> = answer
        .runs
        .iter()
        .map(|r| {
            vec![
                r.run.to_string(),
                r.dir.to_owned(),
                r.way.to_owned(),
                format!("{:.3}", r.p_bar),
                format!("{:.1}", r.force_n),
                r.readings.to_string(),
                format!("{:.2}", r.circular_deviation_um),
            ]
        })
        .collect();
    body + &table(
        &[
            "run",
            "direction",
            "way",
            "bar",
            "N",
            "readings",
            "circular deviation µm",
        ],
        &rows,
    )
}

/// Deflection against the smallest force, by angle: figure 15.
fn deflection(circles: &Circles) -> String {
    let mut levels = levels(circles.runs.iter().filter(|r| r.rising));
    if levels.len() < 2 {
        return String::new();
    }
    levels.sort_by(|a, b| a.force_n.total_cmp(&b.force_n));
    let first = &levels[0];
    let curves: Vec<(String, Vec<(f64, f64)>)> = levels
        .iter()
        .map(|level| {
            let points = (0..360)
                .filter_map(|k| {
                    let d = 1e6 * (level.mean(k)? - first.mean(k)?);
                    Some((k as f64 + 0.5, d))
                })
                .collect();
            (format!("{:.0} N", level.force_n), points)
        })
        .collect();
    let most = curves
        .iter()
        .flat_map(|c| &c.1)
        .fold(0.0, |m: f64, p| m.max(p.1));
    let base = 10.0 * (0.05 * most).ceil();
    let polar = Polar {
        title: "Deflection by direction".to_owned(),
        radius: format!("deflection (µm) + {base:.0}"),
        most: above(most + base),
        series: curves
            .iter()
            .enumerate()
            .map(|(k, (name, points))| PolarSeries {
                name: name.clone(),
                points: points.iter().map(|(a, d)| (*a, d + base)).collect(),
                colour: step(k, curves.len()),
                dashed: false,
            })
            .collect(),
        caption: "Length change against the smallest force (the inner circle); each curve and its force are the mean of the runs of one step, both ways round.".to_owned(),
    }
    .figure();
    let forces = curves.len();
    let chart = Chart {
        title: "Deflection against angle".to_owned(),
        x: Scale::linear("angle (°)", 0.0, 360.0),
        y: Scale::linear("deflection (µm)", 0.0, above(most)),
        height: 260.0,
        series: curves
            .into_iter()
            .enumerate()
            .skip(1)
            .map(|(k, (name, points))| Series {
                name,
                points,
                mark: Mark::Line,
                colour: step(k, forces),
            })
            .collect(),
        caption: "The same, unrolled: equal steps of force should give equal distances.".to_owned(),
    }
    .figure();
    polar + &chart
}

/// Stiffness all round with its extreme vectors: figure 16.
fn stiffness(s: &AllRound) -> String {
    let of = |f: fn(&rarma_scenarios::ldbb::stiffness::Ray) -> f64| -> Vec<(f64, f64)> {
        s.rays.iter().map(|r| (r.angle_deg, f(r))).collect()
    };
    let vector = |name: &str, e: &rarma_scenarios::ldbb::stiffness::Extreme, colour| PolarSeries {
        name: format!(
            "{name}: {:.2} ± {:.3} N/µm at {:.1}°",
            e.n_per_um, e.sd_n_per_um, e.angle_deg
        ),
        points: vec![(e.angle_deg, 0.0), (e.angle_deg, e.n_per_um)],
        colour,
        dashed: false,
    };
    let polar = Polar {
        title: "Static stiffness by direction".to_owned(),
        radius: "stiffness (N/µm)".to_owned(),
        most: above(s.most.n_per_um),
        series: vec![
            PolarSeries {
                name: "each degree by itself".to_owned(),
                points: of(|r| r.raw_n_per_um),
                colour: 3,
                dashed: true,
            },
            PolarSeries {
                name: format!("smoothed, mean {:.2} N/µm", s.mean_n_per_um),
                points: of(|r| r.n_per_um),
                colour: 0,
                dashed: false,
            },
            vector("largest", &s.most, 2),
            vector("smallest", &s.least, 1),
        ],
        caption:
            "Force over the deflection in its own direction, by regression of deflection on force."
                .to_owned(),
    }
    .figure();
    // The same about its mean: 3 N/µm of 12 are hard to see from the centre.
    let low = s.least.n_per_um - 0.05 * s.mean_n_per_um;
    let high = s.most.n_per_um + 0.05 * s.mean_n_per_um;
    let line = |name: &str, points, mark, colour| Series {
        name: name.to_owned(),
        points,
        mark,
        colour,
    };
    let chart = Chart {
        title: "Static stiffness against angle".to_owned(),
        x: Scale::linear("angle (°)", 0.0, 360.0),
        y: Scale::linear("N/µm", low, high),
        height: 260.0,
        series: vec![
            line("each degree", of(|r| r.raw_n_per_um), Mark::Dots, 3),
            line("smoothed", of(|r| r.n_per_um), Mark::Line, 0),
            line(
                "± 2 standard deviations",
                of(|r| r.n_per_um + 2.0 * r.sd_n_per_um),
                Mark::Dashes,
                1,
            ),
            line("", of(|r| r.n_per_um - 2.0 * r.sd_n_per_um), Mark::Dashes, 1),
        ],
        caption: format!(
            "Scatter of a degree's mean about its line {:.3} µm. In {:.0} % of the directions the deflection is curved.",
            s.scatter_um,
            100.0 * s.curved_part
        ),
    }
    .figure();
    polar + &chart
}
