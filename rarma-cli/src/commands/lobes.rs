//! `rarma lobes`: spindle speed against limit depth, cases overlaid.

use super::show;
use crate::args::LobesArgs;
use crate::failure::Failure;
use crate::report::chart::{Chart, Mark, Scale, Series, sheet, table};
use crate::report::sheet_into;
use crate::scenario::{self, Loaded};
use crate::truth::crossing_word;
use hal_sim::plant::cut::Process;
use hal_sim::plant::delay::DepthSearch;
use hal_sim::plant::error::PlantError;
use hal_sim::plant::truth::{limit_of, zero_order_m};
use rayon::prelude::*;
use serde::Serialize;

/// Depth at which the scan starts, relative to the largest; ratio of the scan.
const LEAST: f64 = 0.01;
const RATIO: f64 = 1.04;

/// One speed of a chart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LobePoint {
    /// Spindle speed, 1/min.
    pub speed_rpm: f64,
    /// Lowest limit by semi-discretisation, mm; null where there is none up to the
    /// largest depth.
    pub depth_mm: Option<f64>,
    /// Chatter frequency there, Hz.
    pub chatter_hz: Option<f64>,
    /// `hopf`, `flip` or `fold`.
    pub crossing: Option<&'static str>,
    /// Zero-order limit, mm, where it is valid.
    pub zero_order_mm: Option<f64>,
}

/// A scenario's chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Lobes {
    /// Its name.
    pub scenario: String,
    /// Largest depth that was looked at, mm.
    pub most_mm: f64,
    /// By speed.
    pub points: Vec<LobePoint>,
}

pub(super) fn main(args: &LobesArgs) -> Result<u8, Failure> {
    let mut all = Vec::new();
    for name in &args.scenarios {
        let loaded = scenario::load(name, None)?;
        let bar = show::progress(args.speeds as u64, &loaded.scenario.name);
        let chart = chart(name, loaded, args, || bar.inc(1));
        bar.finish_and_clear();
        all.push(chart?);
    }
    if let Some(dir) = &args.report {
        let page = sheet_into(dir, html(&all))?;
        if !args.json {
            say!("Report: {}", page.display());
        }
    }
    if args.json {
        let text = serde_json::to_string(&all).map_err(std::io::Error::from)?;
        say!("{{\"scenarios\":{text}}}");
    } else {
        tell(&all);
    }
    Ok(0)
}

/// One scenario over all speeds of `args`, whose `scenarios` do not count; `name` is what
/// messages call it. `done` is called after each speed.
///
/// # Errors
/// The scenario cuts nothing and no depth is given, or the plant refuses it.
pub fn chart(
    name: &str,
    loaded: Loaded,
    args: &LobesArgs,
    done: impl Fn() + Sync,
) -> Result<Lobes, Failure> {
    let process = loaded.scenario.process;
    let nominal = 60.0 * process.spindle_hz();
    let range = args.rpm.unwrap_or((0.5 * nominal, 1.5 * nominal));
    let most_mm = args.max_depth_mm.unwrap_or(2e3 * process.depth().largest());
    if !(most_mm > 0.0) {
        return Err(Failure::Usage(format!(
            "--max-depth-mm: must be given, {name} cuts nothing"
        )));
    }
    let speeds: Vec<f64> = (0..args.speeds)
        .map(|i| range.0 + (range.1 - range.0) * i as f64 / (args.speeds - 1).max(1) as f64)
        .collect();
    let points: Result<Vec<LobePoint>, PlantError> = speeds
        .par_iter()
        .map(|&rpm| {
            let point = point(&process, rpm, most_mm);
            done();
            point
        })
        .collect();
    Ok(Lobes {
        scenario: loaded.scenario.name,
        most_mm,
        points: points.map_err(|why| Failure::whole(name, why, "correct the fields it names"))?,
    })
}

/// The limit at one speed.
///
/// # Errors
/// As the validation of the process; no limit is none.
pub fn point(process: &Process, speed_rpm: f64, most_mm: f64) -> Result<LobePoint, PlantError> {
    let at = process.at_spindle_hz(speed_rpm / 60.0);
    let search = DepthSearch {
        low_m: LEAST * 1e-3 * most_mm,
        high_m: 1e-3 * most_mm,
        ratio: RATIO,
        tolerance: 1e-4,
    };
    let limit = match limit_of(&at, f64::INFINITY, &search) {
        Ok(limit) => Some(limit),
        Err(PlantError::NoLimit) => None,
        Err(why) => return Err(why),
    };
    Ok(LobePoint {
        speed_rpm,
        depth_mm: limit.map(|l| 1e3 * l.depth_m),
        chatter_hz: limit.map(|l| l.root.f_hz),
        crossing: limit.map(|l| crossing_word(l.crossing)),
        zero_order_mm: zero_order_m(&at).map(|d| 1e3 * d),
    })
}

fn tell(all: &[Lobes]) {
    for case in all {
        say!("{}", case.scenario);
        say!("  1/min     limit mm   chatter Hz         zero-order mm");
        for p in &case.points {
            match (p.depth_mm, p.chatter_hz) {
                (Some(d), Some(f)) => say!(
                    "{:8.0}  {d:9.4}  {f:9.1}  {:5} {}",
                    p.speed_rpm,
                    p.crossing.unwrap_or(""),
                    p.zero_order_mm
                        .map_or("        -".to_owned(), |z| format!("{z:9.4}"))
                ),
                _ => say!("{:8.0}   above {:.3}", p.speed_rpm, case.most_mm),
            }
        }
    }
}

fn html(all: &[Lobes]) -> String {
    let ends = |f: fn(f64, f64) -> f64, start: f64| {
        all.iter()
            .flat_map(|c| &c.points)
            .fold(start, |m, p| f(m, p.speed_rpm))
    };
    let speeds = (ends(f64::min, f64::INFINITY), ends(f64::max, 0.0));
    let most = all.iter().map(|c| c.most_mm).fold(0.0, f64::max);
    let highest = all
        .iter()
        .flat_map(|c| c.points.iter().filter_map(|p| p.chatter_hz))
        .fold(1.0, f64::max);
    let axis = || Scale::linear("spindle speed (1/min)", speeds.0, speeds.1);
    let mut limits = Vec::new();
    let mut tones = Vec::new();
    for (k, case) in all.iter().enumerate() {
        let series = |name: String, mark, pick: fn(&LobePoint) -> Option<f64>| Series {
            name,
            points: case
                .points
                .iter()
                .map(|p| (p.speed_rpm, pick(p).unwrap_or(f64::NAN)))
                .collect(),
            mark,
            colour: k,
        };
        limits.push(series(
            format!("{}: semi-discretisation", case.scenario),
            Mark::Line,
            |p| p.depth_mm,
        ));
        if case.points.iter().any(|p| p.zero_order_mm.is_some()) {
            limits.push(series(
                format!("{}: zero-order", case.scenario),
                Mark::Dashes,
                |p| p.zero_order_mm,
            ));
        }
        tones.push(series(
            format!("{}: quasi-periodic", case.scenario),
            Mark::Dots,
            |p| p.chatter_hz.filter(|_| p.crossing != Some("flip")),
        ));
        if case.points.iter().any(|p| p.crossing == Some("flip")) {
            tones.push(Series {
                colour: k + 3,
                ..series(
                    format!("{}: period doubling", case.scenario),
                    Mark::Dots,
                    |p| p.chatter_hz.filter(|_| p.crossing == Some("flip")),
                )
            });
        }
    }
    let charts = [
        Chart {
            title: "Stability lobes".to_owned(),
            x: axis(),
            y: Scale::linear("limit depth (mm)", 0.0, most),
            height: 340.0,
            series: limits,
            caption: "Lowest depth at which the cut loses stability; above a curve it chatters. No curve: stable up to the top of the picture. Unstable islands above a stable gap are not drawn. The zero-order curve keeps only the mean of the cutting force and misses period doubling.".to_owned(),
        },
        Chart {
            title: "Chatter frequency at the limit".to_owned(),
            x: axis(),
            y: Scale::linear("frequency (Hz)", 0.0, 1.05 * highest),
            height: 220.0,
            series: tones,
            caption: "Frequency of the strongest component of the motion that loses its damping.".to_owned(),
        },
    ];
    let rows: Vec<Vec<String>> = all
        .iter()
        .filter_map(|case| {
            let lowest = case
                .points
                .iter()
                .filter(|p| p.depth_mm.is_some())
                .min_by(|a, b| {
                    a.depth_mm
                        .partial_cmp(&b.depth_mm)
                        .unwrap_or(std::cmp::Ordering::Equal)
                })?;
            Some(vec![
                case.scenario.clone(),
                format!("{:.4} mm", lowest.depth_mm.unwrap_or(f64::NAN)),
                format!("{:.0} 1/min", lowest.speed_rpm),
                format!("{:.1} Hz", lowest.chatter_hz.unwrap_or(f64::NAN)),
            ])
        })
        .collect();
    let mut body: String = charts.iter().map(Chart::figure).collect();
    body.push_str("<h2>Lowest limit in the picture</h2>\n");
    body.push_str(&table(&["case", "depth", "at", "chatter frequency"], &rows));
    sheet(
        "Stability lobes",
        &all.iter()
            .map(|c| c.scenario.as_str())
            .collect::<Vec<_>>()
            .join(", "),
        &body,
        env!("CARGO_PKG_VERSION"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_does_not_depend_on_how_deep_one_looks() {
        let loaded = scenario::load("two-tooth-benchmark", None).expect("shipped");
        let process = loaded.scenario.process;
        // 0.0714 mm, far below a hundredth of the largest depths.
        for most_mm in [0.1, 10.0, 100.0] {
            let point = point(&process, 10_000.0, most_mm).expect("valid");
            let depth = point.depth_mm.expect("a limit");
            assert!((0.0710..0.0718).contains(&depth), "{most_mm}: {point:?}");
        }
        let none = point(&process, 10_000.0, 0.05).expect("valid");
        assert_eq!(none.depth_mm, None);
        // What is no speed has no chart, instead of one without a limit.
        assert!(point(&process, 0.0, 1.0).is_err());
    }
}
