//! Machine errors against load, drawn and as a table.

use crate::commands::els::pictures::above;
use crate::ldbb::evaluate::AtForce;
use crate::report::chart::{Chart, Mark, Scale, Series, table};

/// Errors against load: figure 20, and all of them as a table.
pub(super) fn errors(all: &[AtForce], [a, b]: [&str; 2]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut body = String::new();
    if all.len() > 1 {
        let of = |f: &dyn Fn(&AtForce) -> Option<f64>| -> Vec<(f64, f64)> {
            all.iter()
                .filter_map(|e| Some((e.force_n, f(e)?)))
                .collect()
        };
        let mut series = Vec::new();
        let mut push = |name: String, points: Vec<(f64, f64)>, mark| {
            if !points.is_empty() {
                let colour = series.len();
                series.push(Series {
                    name,
                    points,
                    mark,
                    colour,
                });
            }
        };
        push(
            "scale mismatch (µm)".to_owned(),
            of(&|e| Some(e.scale_mismatch_um.value)),
            Mark::Line,
        );
        push(
            "squareness (µrad)".to_owned(),
            of(&|e| Some(e.squareness_urad.value)),
            Mark::Line,
        );
        for (k, axis) in [a, b].into_iter().enumerate() {
            push(
                format!("straightness of {axis} (µm)"),
                of(&|e| Some(e.straightness_um?[k].value)),
                Mark::Dashes,
            );
        }
        for (k, axis) in [a, b].into_iter().enumerate() {
            push(
                format!("backlash of {axis} (µm)"),
                of(&|e| Some(e.backlash_um?[k].value)),
                Mark::Dashes,
            );
        }
        let points = || series.iter().flat_map(|s: &Series| &s.points);
        let high = points().fold(1.0, |m: f64, p| m.max(p.1));
        let low = points().fold(0.0, |m: f64, p| m.min(p.1));
        let last = all.iter().fold(0.0, |m: f64, e| m.max(e.force_n));
        let room = 0.05 * (high - low);
        body += &Chart {
            title: "Machine errors against load".to_owned(),
            x: Scale::linear("force (N)", 0.0, above(last)),
            y: Scale::linear("µm, µrad", low - room, high + room),
            height: 320.0,
            series,
            caption: "A stiffness that differs between the axes bends the circle like a scale mismatch or a squareness, in proportion to the load.".to_owned(),
        }
        .figure();
    }
    body += "<h2>Machine errors</h2>\n";
    let with = |w: &crate::ldbb::evaluate::With| format!("{:.2} ± {:.2}", w.value, w.sd);
    let pair = |p: &Option<[crate::ldbb::evaluate::With; 2]>| {
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
