//! Pictures of a test: deflection, stiffness, hysteresis, errors against load; several
//! machines beside each other.

use super::Answer;
use crate::commands::els::pictures::above;
use crate::input::Circles;
use crate::ldbb::compare::Machine;
use crate::ldbb::evaluate::AtForce;
use crate::ldbb::stiffness::{AllRound, Cycle, trace};
use crate::report::chart::{Chart, Mark, Scale, Series, table};
use crate::report::polar::{Polar, PolarSeries};

/// The page of one test.
pub(super) fn page(answer: &Answer, circles: &Circles) -> String {
    let mut body = deflection(circles);
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
    let mut rising: Vec<_> = circles.runs.iter().filter(|r| r.rising).collect();
    if rising.len() < 2 {
        return String::new();
    }
    rising.sort_by(|a, b| a.force_n.total_cmp(&b.force_n));
    // One direction is enough to see.
    let sense = rising[0].sense;
    rising.retain(|r| r.sense == sense);
    let first = trace(rising[0]);
    let curves: Vec<(String, Vec<(f64, f64)>)> = rising
        .iter()
        .map(|r| {
            let t = trace(r);
            let points = (0..360)
                .filter_map(|k| {
                    let d = 1e6 * (t.mean(k)? - first.mean(k)?);
                    Some((k as f64 + 0.5, d))
                })
                .collect();
            (format!("{:.0} N", r.force_n), points)
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
                colour: k,
                dashed: k % 2 == 1,
            })
            .collect(),
        caption: format!(
            "Length change against the run with the smallest force ({}, the inner circle).",
            sense.name()
        ),
    }
    .figure();
    let chart = Chart {
        title: "Deflection against angle".to_owned(),
        x: Scale::linear("angle (°)", 0.0, 360.0),
        y: Scale::linear("µm", 0.0, above(most)),
        height: 260.0,
        series: curves
            .into_iter()
            .enumerate()
            .skip(1)
            .map(|(k, (name, points))| Series {
                name,
                points,
                mark: if k % 2 == 1 { Mark::Dashes } else { Mark::Line },
                colour: k,
            })
            .collect(),
        caption: "The same, unrolled: equal steps of force should give equal distances.".to_owned(),
    }
    .figure();
    polar + &chart
}

/// Stiffness all round with its extreme vectors: figure 16.
fn stiffness(s: &AllRound) -> String {
    let of = |f: fn(&crate::ldbb::stiffness::Ray) -> f64| -> Vec<(f64, f64)> {
        s.rays.iter().map(|r| (r.angle_deg, f(r))).collect()
    };
    let vector = |name: &str, e: &crate::ldbb::stiffness::Extreme, colour| PolarSeries {
        name: format!(
            "{name}: {:.2} ± {:.2} N/µm at {:.1}°",
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

/// Load cycles: figure 17.
fn hysteresis(title: &str, cycles: &[Cycle]) -> String {
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
}

fn left_over(cycles: &[Cycle]) -> String {
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

/// Errors against load: figure 20, and all of them as a table.
fn errors(all: &[AtForce], [a, b]: [&str; 2]) -> String {
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
    let series = |name: &str, points, mark, colour| Series {
        name: name.to_owned(),
        points,
        mark,
        colour,
    };
    let ranks = Chart {
        title: "Stiffness of the tests, stiffest first".to_owned(),
        x: Scale::linear("rank", 0.5, machines.len() as f64 + 0.5),
        y: Scale::linear("N/µm", 0.0, above(most)),
        height: 260.0,
        series: vec![
            series("largest", of(|m| m.most.0), Mark::Dots, 2),
            series("mean", of(|m| m.mean), Mark::Line, 0),
            series("smallest", of(|m| m.least.0), Mark::Dots, 1),
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
