//! Several machines beside each other.

use crate::commands::els::pictures::above;
use rarma_pictures::{Chart, Mark, Scale, Series, table};
use rarma_pictures::{Polar, PolarSeries};
use rarma_scenarios::ldbb::compare::Machine;

/// Machines side by side: figures 18 and 19.
pub(super) fn comparison(machines: &[Machine], spread: f64) -> String {
    let most = machines.iter().fold(0.0, |m: f64, x| m.max(x.most.0));
    let names = |m: &Machine| {
        format!(
            "{}, {:.0} mm/min, {:.0}°",
            m.name, m.feed_mm_min, m.inclination_deg
        )
    };
    let polar = Polar {
        title: "Static stiffness by direction".to_owned(),
        radius: "stiffness (N/µm)".to_owned(),
        most: above(most),
        series: machines
            .iter()
            .enumerate()
            .map(|(k, m)| PolarSeries {
                name: names(m),
                points: m.polar.clone(),
                colour: k,
                dashed: k >= 6,
            })
            .collect(),
        caption: "Smoothed.".to_owned(),
    }
    .figure();
    let of = |f: fn(&Machine) -> f64| -> Vec<(f64, f64)> {
        machines
            .iter()
            .enumerate()
            .map(|(k, m)| (1.0 + k as f64, f(m)))
            .collect()
    };
    let ranks = Chart {
        title: "Stiffness of the tests, stiffest first".to_owned(),
        x: Scale::counted("rank", 0.5, machines.len() as f64 + 0.5),
        y: Scale::linear("N/µm", 0.0, above(most)),
        height: 260.0,
        series: vec![
            Series::new("largest", of(|m| m.most.0), Mark::Dots, 2),
            Series::new("mean", of(|m| m.mean), Mark::Line, 0),
            Series::new("smallest", of(|m| m.least.0), Mark::Dots, 1),
        ],
        caption: format!(
            "The means are {:.0} % of their middle apart.",
            100.0 * spread
        ),
    }
    .figure();
    let inclined = inclinations(machines);
    let rows: Vec<Vec<String>> = machines
        .iter()
        .enumerate()
        .map(|(k, m)| {
            vec![
                (k + 1).to_string(),
                names(m),
                format!("{:.2}", m.mean),
                format!("{:.2} at {:.0}°", m.least.0, m.least.1),
                format!("{:.2} at {:.0}°", m.most.0, m.most.1),
                format!("{:.2}", m.sd),
                format!("{:.1} at {:.0} N", m.at_most.1, m.at_most.0),
                format!("{:.1}", m.at_most.2),
            ]
        })
        .collect();
    polar
        + &ranks
        + &inclined
        + &table(
            &[
                "rank",
                "test",
                "mean N/µm",
                "smallest",
                "largest",
                "standard deviation",
                "scale mismatch µm",
                "squareness µrad",
            ],
            &rows,
        )
}

/// Mean stiffness against inclination, machine by machine, where it was varied.
fn inclinations(machines: &[Machine]) -> String {
    let mut names: Vec<&str> = machines.iter().map(|m| m.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    let mut series = Vec::new();
    for name in names {
        let mut points: Vec<(f64, f64)> = machines
            .iter()
            .filter(|m| m.name == name)
            .map(|m| (m.inclination_deg, m.mean))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| (a.0 - b.0).abs() < 0.1);
        if points.len() > 1 {
            let colour = series.len();
            series.push(Series {
                name: name.to_owned(),
                points,
                mark: Mark::Line,
                colour,
            });
        }
    }
    if series.is_empty() {
        return String::new();
    }
    let points = || series.iter().flat_map(|s: &Series| &s.points);
    let most = points().fold(0.0, |m: f64, p| m.max(p.1));
    let ends = points().fold((0.0, 0.0), |m: (f64, f64), p| (m.0.min(p.0), m.1.max(p.0)));
    Chart {
        title: "Mean stiffness against inclination".to_owned(),
        x: Scale::linear("inclination (°)", ends.0 - 5.0, ends.1 + 5.0),
        y: Scale::linear("N/µm", 0.0, above(most)),
        height: 240.0,
        series,
        caption: "The force's moment about the spindle's root falls as the bar rises.".to_owned(),
    }
    .figure()
}
