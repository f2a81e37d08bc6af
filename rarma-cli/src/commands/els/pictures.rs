//! The pictures of the elastic linked system.

use rarma_pictures::palette;
use rarma_pictures::{Chart, Mark, Scale, Series, table};
use rarma_pictures::{Polar, PolarSeries};
use rarma_rigs::els::Complex;
use rarma_scenarios::els::diagram::Diagram;
use rarma_scenarios::els::machine::{DeflectionCase, LoadCase, Picture};

/// A round number at or above a value, for the end of an axis.
pub(in crate::commands) fn above(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(value.log10().floor());
    [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|x| *x >= value * 1.000_001)
        .unwrap_or(10.0 * power)
}

/// Limits all round; and the table of the best and the worst direction.
pub(super) fn limits(diagram: &Diagram) -> String {
    let finite: Vec<f64> = diagram.polar.iter().filter_map(|d| d.width_mm).collect();
    let least = finite.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = finite.iter().copied().fold(0.0, f64::max);
    // A direction next to an unlimited one would shrink all others to a dot.
    let most = above(largest.min(12.0 * least));
    let points = diagram
        .polar
        .iter()
        .map(|d| (d.angle_deg, d.width_mm.unwrap_or(f64::INFINITY)))
        .collect();
    let mut html = Polar {
        title: "Limiting width of cut by direction of the cutting force".to_owned(),
        radius: "limiting width of cut (mm)".to_owned(),
        most,
        series: vec![PolarSeries {
            name: format!("force and chip thickness {:.0}° apart", diagram.chip_angle_deg),
            points,
            colour: 0,
            dashed: false,
        }],
        caption: format!(
            "Width below which no spindle speed chatters, with the force turned about the tool from u (0°) towards v (90°). No curve: beyond the rim, or no limit in that direction. Wider cuts may be stable at some speeds. Ks {} N/mm², teeth in the cut {}, overlap {}.",
            diagram.ks_n_per_mm2, diagram.teeth_in_cut, diagram.overlap
        ),
    }
    .figure();
    let frequencies: Vec<(f64, f64)> = diagram
        .polar
        .iter()
        .filter_map(|d| Some((d.angle_deg, d.chatter_hz?)))
        .collect();
    let top = frequencies.iter().fold(0.0, |m: f64, p| m.max(p.1));
    html.push_str(
        &Chart {
            title: "Chatter frequency at the limit".to_owned(),
            x: Scale::linear("direction of the force (degrees)", 0.0, 360.0),
            y: Scale::linear("frequency (Hz)", 0.0, above(top)),
            height: 180.0,
            series: vec![Series {
                name: "frequency of the most negative real part".to_owned(),
                points: frequencies,
                mark: Mark::Dots,
                colour: 0,
            }],
            caption: "A jump shows where another mode takes over.".to_owned(),
        }
        .figure(),
    );
    let row = |name: &str, d: &rarma_scenarios::els::diagram::Direction| {
        let unit = |x: Option<f64>, digits: usize, unit: &str| {
            x.map_or("none".to_owned(), |x| format!("{x:.digits$} {unit}"))
        };
        vec![
            name.to_owned(),
            format!("{:.0}°", d.angle_deg),
            unit(d.width_mm, 3, "mm"),
            unit(d.chatter_hz, 1, "Hz"),
        ]
    };
    html.push_str("<h2>Best and worst direction</h2>\n");
    html.push_str(&table(
        &["", "direction", "limiting width", "chatter frequency"],
        &[row("best", &diagram.best), row("worst", &diagram.worst)],
    ));
    html
}

/// Static stiffness all round, where it was read.
pub(super) fn stiffness(diagram: &Diagram) -> String {
    let points: Vec<(f64, f64)> = diagram
        .polar
        .iter()
        .map(|d| (d.angle_deg, d.stiffness_n_per_um.unwrap_or(f64::INFINITY)))
        .collect();
    let finite = points.iter().map(|p| p.1).filter(|k| k.is_finite());
    let (least, most) = finite.fold((f64::INFINITY, 0.0), |(a, b): (f64, f64), k| {
        (a.min(k), b.max(k))
    });
    if !least.is_finite() {
        return String::new();
    }
    Polar {
        title: "Static stiffness by direction".to_owned(),
        radius: "stiffness along the force (N/µm)".to_owned(),
        most: above(most.min(12.0 * least)),
        series: vec![PolarSeries {
            name: "from the receptance at zero frequency".to_owned(),
            points,
            colour: 0,
            dashed: false,
        }],
        caption: "Force over the displacement in its own direction.".to_owned(),
    }
    .figure()
}

/// Colour of a receptance, the same in every picture whichever others are there, and whether
/// it is dashed: a cross receptance is, and a fit over what was measured.
fn dress(name: &str, place: usize) -> (usize, Mark) {
    match name {
        "uu" | "xx" => (0, Mark::Line),
        "vv" | "yy" => (1, Mark::Line),
        "uv" | "xy" => (2, Mark::Dashes),
        "vu" | "yx" => (3, Mark::Dashes),
        _ if place == 0 => (0, Mark::Line),
        _ => (place, Mark::Dashes),
    }
}

/// Magnitude and real part of receptances in µm/N over frequency.
pub(super) fn receptances(f: &[f64], functions: &[(String, Vec<Complex<f64>>)]) -> String {
    let range = (
        f.first().copied().unwrap_or(0.0),
        f.last().copied().unwrap_or(1.0),
    );
    // No more points than pixels.
    let thin = f.len().div_ceil(1500).max(1);
    let series = |value: fn(&Complex<f64>) -> f64| -> Vec<Series> {
        functions
            .iter()
            .enumerate()
            .map(|(k, (name, g))| Series {
                name: name.clone(),
                points: f
                    .iter()
                    .zip(g)
                    .step_by(thin)
                    .map(|(f, g)| (*f, 1e6 * value(g)))
                    .collect(),
                mark: dress(name, k).1,
                colour: dress(name, k).0,
            })
            .collect()
    };
    let chart = |title: &str, y: Scale, series, caption: &str| {
        Chart {
            title: title.to_owned(),
            x: Scale::linear("frequency (Hz)", range.0, range.1),
            y,
            height: 240.0,
            series,
            caption: caption.to_owned(),
        }
        .figure()
    };
    let size = series(|g| g.abs());
    let ends = |s: &[Series], start: f64, f: fn(f64, f64) -> f64| {
        s.iter()
            .flat_map(|s| &s.points)
            .fold(start, |m, p| f(m, p.1))
    };
    let most = ends(&size, 0.0, f64::max).max(1e-9);
    let least = ends(&size, f64::INFINITY, f64::min).min(0.1 * most);
    let real = series(|g| g.re);
    let low = ends(&real, 0.0, f64::min);
    let high = ends(&real, 0.0, f64::max);
    let room = 0.05 * (high - low).max(1e-12);
    let decade = |x: f64, up: bool| {
        let e = x.log10();
        10_f64.powf(if up { e.ceil() } else { e.floor() })
    };
    chart(
        "Receptance, magnitude",
        Scale::log(
            "µm/N",
            decade(least.max(1e-4 * most), false),
            decade(most, true),
        ),
        size,
        "Displacement over force, response first, excitation second.",
    ) + &chart(
        "Receptance, real part",
        Scale::linear("µm/N", low - room, high + room),
        real,
        "Its most negative value sets the limiting width of cut.",
    )
}

/// Natural frequencies against the load of the link.
pub(super) fn frequencies(cases: &[LoadCase]) -> String {
    let last = cases.last().map_or(1.0, |c| c.load_n);
    let top = cases
        .iter()
        .flat_map(|c| &c.modes)
        .fold(0.0, |m: f64, x| m.max(x.f));
    // The k-th mode of its kind: torsion does not change its name where bending passes it.
    let of = |c: &LoadCase, shape: &str| -> Vec<f64> {
        let those = c.modes.iter().filter(|m| m.shape == shape);
        those.map(|m| m.f).collect()
    };
    let mut series = Vec::new();
    for (shape, mark) in [("bending", Mark::Line), ("torsion", Mark::Dashes)] {
        let count = cases.iter().map(|c| of(c, shape).len()).min().unwrap_or(0);
        for k in 0..count {
            series.push(Series {
                name: format!("{shape} {}", k + 1),
                points: cases.iter().map(|c| (c.load_n, of(c, shape)[k])).collect(),
                mark,
                colour: if mark == Mark::Line {
                    palette::step(k, count)
                } else {
                    1 + k
                },
            });
        }
    }
    Chart {
        title: "Natural frequencies against the load of the link".to_owned(),
        x: Scale::linear("load (N)", 0.0, last.max(1.0)),
        y: Scale::linear("frequency (Hz)", 0.0, above(top)),
        height: 340.0,
        series,
        caption: "The link's stiffness grows with its load. Bending modes rise, torsion (dashed) stays: the link does not resist turning about the axis.".to_owned(),
    }
    .figure()
}

/// Shapes with the tip free or grounded.
pub(super) fn shapes(title: &str, pictures: &[Picture]) -> String {
    let nodes = || {
        pictures
            .iter()
            .flat_map(|p| p.holder.iter().chain(&p.spindle))
    };
    let low = nodes().fold(0.0, |m: f64, n| m.min(n[0]));
    let high = nodes().fold(0.1, |m: f64, n| m.max(n[0]));
    let mut series = Vec::new();
    for (k, p) in pictures.iter().enumerate() {
        // The plane in which it moves most, with the sign of the largest excursion.
        let torsion = p.shape == "torsion";
        let largest = p
            .holder
            .iter()
            .chain(&p.spindle)
            .fold((0.0, 0.0), |m: (f64, f64), n| {
                if n[1].hypot(n[2]) > m.0.hypot(m.1) {
                    (n[1], n[2])
                } else {
                    m
                }
            });
        let size = largest.0.hypot(largest.1).max(1e-12);
        let along = |n: &[f64; 4]| {
            if torsion {
                n[3]
            } else {
                (n[1] * largest.0 + n[2] * largest.1) / size
            }
        };
        for (part, nodes) in [("", &p.holder), (", spindle", &p.spindle)] {
            if nodes.is_empty() {
                continue;
            }
            series.push(Series {
                name: format!("{:.0} Hz, {}{part}", p.f, p.shape),
                points: nodes.iter().map(|n| (1e3 * n[0], along(n))).collect(),
                mark: if part.is_empty() {
                    Mark::Line
                } else {
                    Mark::Dashes
                },
                colour: k,
            });
        }
    }
    Chart {
        title: title.to_owned(),
        x: Scale::linear("distance from the tool joint (mm)", 1e3 * low, 1e3 * high),
        y: Scale::linear("shape, largest 1", -1.1, 1.1),
        height: 260.0,
        series,
        caption: "Deflection in the plane of the largest motion; for torsion the twist. Solid: tool and holder. Dashed: spindle.".to_owned(),
    }
    .figure()
}

/// Deflection all round at tool joint, middle of the holder and bearing.
pub(super) fn deflections(cases: &[DeflectionCase]) -> String {
    let mut series = Vec::new();
    for (k, c) in cases.iter().enumerate() {
        for (place, values, colour) in [
            ("tool joint", &c.tool_joint_um, 0),
            ("middle of the holder", &c.middle_um, 2),
            ("front bearing", &c.bearing_um, 1),
        ] {
            if !values.is_empty() {
                series.push(PolarSeries {
                    name: format!("{place}, {} kN", c.load_n / 1e3),
                    points: c
                        .angle_deg
                        .iter()
                        .copied()
                        .zip(values.iter().copied())
                        .collect(),
                    colour,
                    dashed: k + 1 < cases.len(),
                });
            }
        }
    }
    let most = series
        .iter()
        .flat_map(|s| &s.points)
        .fold(0.0, |m: f64, p| m.max(p.1));
    Polar {
        title: "Deflection by direction of the load".to_owned(),
        radius: "total displacement (µm)".to_owned(),
        most: above(most),
        series,
        caption: "Length of the displacement under a load at the tool joint, turned about the axis from x (0°) towards y (90°). Solid: the largest load; dashed: smaller ones, the smaller the further inside.".to_owned(),
    }
    .figure()
}
