//! Pictures of load cycles.

use crate::commands::els::pictures::above;
use rarma_pictures::{Chart, Mark, Scale, Series};
use rarma_pictures::{Polar, PolarSeries};
use rarma_scenarios::ldbb::stiffness::Cycle;

/// Load cycles: figure 17.
pub(super) fn hysteresis(title: &str, cycles: &[Cycle]) -> String {
    let points = || cycles.iter().flat_map(|c| c.up.iter().chain(&c.down));
    let most_n = points().fold(0.0, |m: f64, p| m.max(p.0));
    let most = points().fold(0.0, |m: f64, p| m.max(p.1));
    let least = points().fold(0.0, |m: f64, p| m.min(p.1));
    let mut series = Vec::new();
    for (k, c) in cycles.iter().enumerate() {
        series.push(Series {
            name: format!(
                "{:.0}°: {:.1} µm left, {:.1} µm at most",
                c.angle_deg, c.left_um, c.most_um
            ),
            points: c.up.clone(),
            mark: Mark::Line,
            colour: k,
        });
        let top = c.up.last().copied();
        series.push(Series {
            name: format!("{:.0}°, down", c.angle_deg),
            points: top.into_iter().chain(c.down.iter().copied()).collect(),
            mark: Mark::Dashes,
            colour: k,
        });
    }
    Chart {
        title: title.to_owned(),
        x: Scale::linear("force (N)", 0.0, above(most_n)),
        y: Scale::linear("deflection (µm)", least.min(0.0) - 1.0, above(most)),
        height: 340.0,
        series,
        caption: "Deflection against the first reading. Solid: up. Dashed: down.".to_owned(),
    }
    .figure()
        + &loops(cycles, most_n)
}

/// The way down less the way up, at the same force: what the curves above hide.
fn loops(cycles: &[Cycle], most_n: f64) -> String {
    let series: Vec<Series> = cycles
        .iter()
        .enumerate()
        .map(|(k, c)| Series {
            name: format!("{:.0}°", c.angle_deg),
            points: c.down.iter().filter_map(|p| open_by(c, *p)).collect(),
            mark: Mark::Line,
            colour: k,
        })
        .collect();
    let points = || series.iter().flat_map(|s| &s.points);
    let high = points().fold(1.0, |m: f64, p| m.max(p.1));
    let low = points().fold(0.0, |m: f64, p| m.min(p.1));
    Chart {
        title: "The way down less the way up".to_owned(),
        x: Scale::linear("force (N)", 0.0, above(most_n)),
        y: Scale::linear("µm", low - 0.05 * high, 1.1 * high),
        height: 220.0,
        series,
        caption: "How far the loop is open at each force.".to_owned(),
    }
    .figure()
}

/// Down less up, the small difference of the two forces taken off along the way up.
fn open_by(c: &Cycle, (force, down): (f64, f64)) -> Option<(f64, f64)> {
    let near =
        c.up.iter()
            .min_by(|a, b| (a.0 - force).abs().total_cmp(&(b.0 - force).abs()))?;
    let (first, last) = (c.up.first()?, c.up.last()?);
    let slope = (last.1 - first.1) / (last.0 - first.0);
    Some((force, down - near.1 - slope * (force - near.0)))
}

/// What stays after a cycle, all round.
pub(super) fn left_over(cycles: &[Cycle]) -> String {
    let points: Vec<(f64, f64)> = cycles
        .iter()
        .map(|c| (c.angle_deg, c.left_um.max(0.0)))
        .collect();
    let most = points.iter().fold(0.0, |m: f64, p| m.max(p.1));
    Polar {
        title: "What a load cycle leaves".to_owned(),
        radius: "hysteresis at the smallest force (µm)".to_owned(),
        most: above(most),
        series: vec![PolarSeries {
            name: "while moving".to_owned(),
            points,
            colour: 0,
            dashed: false,
        }],
        caption: "Length at the smallest force after the cycle less that before it.".to_owned(),
    }
    .figure()
}
