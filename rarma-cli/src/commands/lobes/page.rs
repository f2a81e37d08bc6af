//! The page of stability lobes.

use super::{LobePoint, Lobes};
use crate::commands::els::pictures::above;
use rarma_pictures::{Chart, Mark, Scale, Series, sheet, table};

/// Room above the highest peak, and above the scenario's own cut.
const ROOM: f64 = 1.1;
/// Where the limit is above the largest depth that was looked at: so far beyond the plot that
/// the line to it leaves it steeply.
const BEYOND: f64 = 4.0;

/// The page.
pub(super) fn html(all: &[Lobes]) -> String {
    let mut body = String::new();
    for case in all {
        body += &limits(case);
    }
    if all.len() > 1 {
        body += &overlay(all);
    }
    body += &tones(all);
    body.push_str("<h2>Lowest limit in the picture, and the scenario's own cut</h2>\n");
    let rows: Vec<Vec<String>> = all.iter().map(row).collect();
    body.push_str(&table(
        &["case", "lowest limit", "at", "chatter frequency", "own cut"],
        &rows,
    ));
    let names: Vec<&str> = all.iter().map(|c| c.scenario.as_str()).collect();
    sheet(
        "Stability lobes",
        &names.join(", "),
        &body,
        env!("CARGO_PKG_VERSION"),
    )
}

fn depths(case: &Lobes) -> impl Iterator<Item = f64> {
    case.fine.iter().filter_map(|p| p.depth_mm)
}

/// End of the depth axis: the highest limit there is, or what was looked at.
fn top(case: &Lobes) -> f64 {
    let highest = depths(case).fold(0.0, f64::max);
    let own = if within(case) { case.cut.1 } else { 0.0 };
    let wanted = above(ROOM * highest.max(own));
    if highest > 0.0 {
        wanted.min(case.most_mm)
    } else {
        case.most_mm
    }
}

fn speeds(case: &Lobes) -> (f64, f64) {
    let speed = |p: Option<&LobePoint>| p.map_or(0.0, |p| p.speed_rpm);
    (speed(case.points.first()), speed(case.points.last()))
}

/// Whether the scenario's own cut lies in the picture.
fn within(case: &Lobes) -> bool {
    let (low, high) = speeds(case);
    (low..=high).contains(&case.cut.0) && case.cut.1 > 0.0 && case.cut.1 <= case.most_mm
}

/// The limit at a speed, between its neighbours; `None`: above what was looked at.
fn limit_at(case: &Lobes, rpm: f64) -> Option<f64> {
    let after = case.fine.iter().position(|p| p.speed_rpm >= rpm)?;
    let b = &case.fine[after];
    let a = &case.fine[after.saturating_sub(1)];
    let (low, high) = (a.depth_mm?, b.depth_mm?);
    let span = b.speed_rpm - a.speed_rpm;
    let share = if span > 0.0 {
        (rpm - a.speed_rpm) / span
    } else {
        0.0
    };
    Some(low + share * (high - low))
}

fn verdict(case: &Lobes) -> String {
    let stable = limit_at(case, case.cut.0).is_none_or(|limit| case.cut.1 < limit);
    format!(
        "{:.0} 1/min, {:.3} mm deep: {}",
        case.cut.0,
        case.cut.1,
        if stable { "stable" } else { "chatters" }
    )
}

fn limit_line(case: &Lobes, name: String, colour: usize) -> Series {
    let depth = |p: &LobePoint| p.depth_mm.unwrap_or(BEYOND * case.most_mm);
    Series {
        name,
        points: case.fine.iter().map(|p| (p.speed_rpm, depth(p))).collect(),
        mark: Mark::Line,
        colour,
    }
}

/// One case: stable and unstable depths tinted, the scenario's own cut marked.
fn limits(case: &Lobes) -> String {
    let (low, high) = speeds(case);
    let top = top(case);
    let area: Vec<(f64, f64)> = case
        .fine
        .iter()
        .map(|p| (p.speed_rpm, p.depth_mm.unwrap_or(f64::INFINITY)))
        .collect();
    let mut all = vec![
        Series::new("chatter", area.clone(), Mark::Above, 1),
        Series::new("stable", area, Mark::Below, 0),
        limit_line(case, "limit by semi-discretisation".to_owned(), 0),
    ];
    let zero: Vec<(f64, f64)> = case
        .points
        .iter()
        .map(|p| (p.speed_rpm, p.zero_order_mm.unwrap_or(f64::NAN)))
        .collect();
    if zero.iter().any(|p| p.1.is_finite()) {
        all.push(Series::new("zero-order limit", zero, Mark::Dashes, 3));
    }
    let seen = |p: &LobePoint| (p.speed_rpm, p.depth_mm.unwrap_or(top).min(top));
    let places: Vec<(f64, f64)> = case.fine.iter().map(seen).collect();
    // Of several places that are alike the one in the middle.
    let at = |wanted: f64| {
        let alike: Vec<&(f64, f64)> = places.iter().filter(|p| p.1 == wanted).collect();
        alike.get(alike.len() / 2).map(|p| **p)
    };
    let depths = || places.iter().map(|p| p.1);
    let (lowest, highest) = (depths().fold(top, f64::min), depths().fold(0.0, f64::max));
    let room = 0.06 * (high - low);
    let mut word = |text: &str, at: (f64, f64)| {
        let at = (at.0.clamp(low + room, high - room), at.1);
        all.push(Series::new(text, vec![at], Mark::Word, 0));
    };
    if let Some(p) = at(lowest).filter(|p| p.1 < 0.75 * top) {
        word("chatter", (p.0, 0.5 * (p.1 + top)));
    }
    if let Some(p) = at(highest) {
        word("stable", (p.0, 0.22 * p.1));
    }
    if within(case) {
        let name = format!("the scenario's own cut, {}", verdict(case));
        all.push(Series::new(&name, vec![case.cut], Mark::Place, 0));
    }
    Chart {
        title: format!("Stability lobes: {}", case.scenario),
        x: Scale::linear("spindle speed (1/min)", low, high),
        y: Scale::linear("depth (mm)", 0.0, top),
        height: 340.0,
        series: all,
        caption: format!(
            "Lowest depth at which the cut loses stability; depths up to {:.3} mm were looked at. Unstable islands above a stable gap are not drawn. The zero-order curve keeps only the mean of the cutting force and misses period doubling.",
            case.most_mm
        ),
    }
    .figure()
}

/// All cases over the same axes.
fn overlay(all: &[Lobes]) -> String {
    let ends = all.iter().map(speeds);
    let (low, high) = ends.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), (a, b)| {
        (low.min(a), high.max(b))
    });
    let lines = all.iter().enumerate();
    Chart {
        title: "Limits of all cases".to_owned(),
        x: Scale::linear("spindle speed (1/min)", low, high),
        y: Scale::linear(
            "limit depth (mm)",
            0.0,
            all.iter().map(top).fold(0.0, f64::max),
        ),
        height: 300.0,
        series: lines
            .map(|(k, case)| limit_line(case, case.scenario.clone(), k))
            .collect(),
        caption: "By semi-discretisation; above a curve its case chatters.".to_owned(),
    }
    .figure()
}

/// Chatter frequencies at the limit.
fn tones(all: &[Lobes]) -> String {
    let mut series = Vec::new();
    for (number, case) in all.iter().enumerate() {
        for (kind, (name, flip)) in [("quasi-periodic", false), ("period doubling", true)]
            .into_iter()
            .enumerate()
        {
            let those = case
                .points
                .iter()
                .filter(|p| (p.crossing == Some("flip")) == flip);
            let points: Vec<(f64, f64)> = those
                .filter_map(|p| Some((p.speed_rpm, p.chatter_hz?)))
                .collect();
            if !points.is_empty() {
                series.push(Series {
                    name: format!("{}: {name}", case.scenario),
                    points,
                    mark: Mark::Dots,
                    // A case has the colour of its limit; a second one where it doubles its period.
                    colour: number + all.len() * kind,
                });
            }
        }
    }
    let points = || series.iter().flat_map(|s| &s.points);
    let (low, high) = points().fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), p| {
        (low.min(p.1), high.max(p.1))
    });
    if !low.is_finite() {
        return String::new();
    }
    let room = (0.15 * (high - low)).max(0.02 * high);
    let speeds = all.iter().map(speeds);
    let ends = speeds.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), (a, b)| {
        (low.min(a), high.max(b))
    });
    Chart {
        title: "Chatter frequency at the limit".to_owned(),
        x: Scale::linear("spindle speed (1/min)", ends.0, ends.1),
        y: Scale::linear("frequency (Hz)", (low - room).max(0.0), high + room),
        height: 220.0,
        series,
        caption: "Frequency of the strongest component of the motion that loses its damping. The axis does not begin at 0.".to_owned(),
    }
    .figure()
}

fn row(case: &Lobes) -> Vec<String> {
    let depth = |p: &LobePoint| p.depth_mm.unwrap_or(f64::INFINITY);
    let lowest = case
        .points
        .iter()
        .filter(|p| p.depth_mm.is_some())
        .min_by(|a, b| depth(a).total_cmp(&depth(b)));
    let of = |text: Option<String>| text.unwrap_or_else(|| "–".to_owned());
    vec![
        case.scenario.clone(),
        lowest.map_or(format!("above {:.3} mm", case.most_mm), |p| {
            format!("{:.4} mm", depth(p))
        }),
        of(lowest.map(|p| format!("{:.0} 1/min", p.speed_rpm))),
        of(lowest.and_then(|p| Some(format!("{:.1} Hz", p.chatter_hz?)))),
        if within(case) {
            verdict(case)
        } else {
            "outside the picture".to_owned()
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A limit of 1 mm at 1000 1/min that rises to none at 3000.
    fn case(cut: (f64, f64)) -> Lobes {
        let point = |speed_rpm: f64, depth_mm: Option<f64>| LobePoint {
            speed_rpm,
            depth_mm,
            chatter_hz: depth_mm.map(|_| 900.0),
            crossing: depth_mm.map(|_| "hopf"),
            zero_order_mm: None,
        };
        let points = vec![
            point(1000.0, Some(1.0)),
            point(2000.0, Some(2.0)),
            point(3000.0, None),
        ];
        Lobes {
            scenario: "a<b".to_owned(),
            most_mm: 20.0,
            fine: points.clone(),
            points,
            cut,
        }
    }

    #[test]
    fn the_own_cut_is_judged_against_the_limit_at_its_speed() {
        for (cut, want) in [
            ((1500.0, 1.4), "stable"),
            ((1500.0, 1.6), "chatters"),
            ((2900.0, 19.0), "stable"),
        ] {
            let html = html(&[case(cut)]);
            assert!(html.contains(&format!("mm deep: {want}")), "{cut:?}");
            assert!(html.contains("class=\"place\""), "{cut:?}");
        }
        let outside = html(&[case((9000.0, 1.0))]);
        assert!(outside.contains("outside the picture"));
        assert!(!outside.contains("class=\"place\""));
    }

    #[test]
    fn a_case_without_a_limit_says_so() {
        let mut none = case((1500.0, 1.0));
        for p in none.points.iter_mut().chain(&mut none.fine) {
            (p.depth_mm, p.chatter_hz, p.crossing) = (None, None, None);
        }
        let page = html(&[none]);
        assert!(
            page.contains("<td>above 20.000 mm</td><td>–</td>"),
            "{page}"
        );
        assert!(!page.contains("NaN"));
    }

    #[test]
    fn the_depth_axis_follows_the_limits_and_both_sides_are_tinted() {
        assert_eq!(top(&case((1500.0, 1.0))), 2.5);
        assert_eq!(top(&case((1500.0, 4.0))), 5.0);
        let page = html(&[case((1500.0, 1.0)), case((1500.0, 1.0))]);
        // Two for each case; as many more in the legends.
        assert_eq!(page.matches("class=\"area ").count(), 8);
        assert!(page.contains("a&lt;b") && !page.contains("a<b"));
        assert!(page.contains("Limits of all cases"));
    }
}
