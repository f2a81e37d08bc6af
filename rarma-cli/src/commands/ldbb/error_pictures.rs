//! Machine errors against load, drawn and as a table.

use crate::commands::els::pictures::above;
use rarma_pictures::{Chart, Mark, Scale, Series, table};
use rarma_scenarios::ldbb::errors::AtForce;

/// A named value of the errors at one force.
type Value = (String, Box<dyn Fn(&AtForce) -> Option<f64>>);

/// What is told in µm.
fn lengths(all: &[AtForce], axes: [&str; 2]) -> String {
    let mut values: Vec<Value> = vec![(
        "scale mismatch".to_owned(),
        Box::new(|e| Some(e.scale_mismatch_um.value)),
    )];
    for (k, axis) in axes.into_iter().enumerate() {
        values.push((
            format!("straightness of {axis}"),
            Box::new(move |e| Some(e.straightness_um?[k].value)),
        ));
    }
    for (k, axis) in axes.into_iter().enumerate() {
        values.push((
            format!("backlash of {axis}"),
            Box::new(move |e| Some(e.backlash_um?[k].value)),
        ));
    }
    against_load(all, "Machine errors against load", "error (µm)", values)
}

/// Errors of one unit against load.
fn against_load(all: &[AtForce], title: &str, unit: &str, values: Vec<Value>) -> String {
    let series: Vec<Series> = values
        .iter()
        .enumerate()
        .map(|(colour, (name, of))| Series {
            name: name.clone(),
            points: all
                .iter()
                .filter_map(|e| Some((e.force_n, of(e)?)))
                .collect(),
            mark: Mark::Line,
            colour,
        })
        .filter(|s| !s.points.is_empty())
        .collect();
    let points = || series.iter().flat_map(|s: &Series| &s.points);
    let high = points().fold(1.0, |m: f64, p| m.max(p.1));
    let low = points().fold(0.0, |m: f64, p| m.min(p.1));
    let last = all.iter().fold(0.0, |m: f64, e| m.max(e.force_n));
    let room = 0.05 * (high - low);
    Chart {
        title: title.to_owned(),
        x: Scale::linear("force (N)", 0.0, above(last)),
        y: Scale::linear(unit, low - room, high + room),
        height: 240.0,
        series,
        caption: "A stiffness that differs between the axes bends the circle like a scale mismatch or a squareness, in proportion to the load.".to_owned(),
    }
    .figure()
}

/// Errors against load: figure 20, and all of them as a table.
pub(super) fn errors(all: &[AtForce], [a, b]: [&str; 2]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut body = String::new();
    if all.len() > 1 {
        body += &lengths(all, [a, b]);
        body += &against_load(
            all,
            "Squareness against load",
            "squareness (µrad)",
            vec![(
                "squareness".to_owned(),
                Box::new(|e| Some(e.squareness_urad.value)),
            )],
        );
    }
    body += "<h2>Machine errors</h2>\n";
    let with = |w: &rarma_scenarios::ldbb::errors::With| {
        format!("{:.2} ± {:.2}", w.value, w.sd).replace('-', "−")
    };
    let pair = |p: &Option<[rarma_scenarios::ldbb::errors::With; 2]>| {
        p.as_ref().map_or("not determined".to_owned(), |p| {
            format!("{a} {}; {b} {}", with(&p[0]), with(&p[1]))
        })
    };
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|e| {
            vec![
                format!("{:.0}", e.force_n),
                format!("{:.2} ({:.2})", e.circular_um, e.circular_least_um),
                e.hysteresis_um
                    .map_or("one direction".to_owned(), |h| format!("{h:.2}")),
                with(&e.scale_mismatch_um),
                format!(
                    "{}{}",
                    with(&e.squareness_urad),
                    if e.squareness_includes_servo {
                        " incl. servo mismatch"
                    } else {
                        ""
                    }
                ),
                pair(&e.straightness_um),
                pair(&e.backlash_um),
                pair(&e.lateral_play_um),
                e.servo_mismatch_ms
                    .as_ref()
                    .map_or("not determined".to_owned(), |w| {
                        format!("{:.3} ± {:.3}", w.value, w.sd)
                    }),
            ]
        })
        .collect();
    body + &table(
        &[
            "N",
            "circular deviation µm (least zone)",
            "hysteresis of the directions µm",
            "scale mismatch µm",
            "squareness µrad",
            "straightness µm",
            "backlash µm",
            "lateral play µm",
            "servo mismatch ms",
        ],
        &rows,
    )
}
