//! `rarma lobes`: spindle speed against limit depth, cases overlaid.

mod page;

use super::show;
use crate::args::LobesArgs;
use crate::failure::Failure;
use crate::report::sheet_told;
use rarma_plants::cut::Process;
use rarma_plants::delay::DepthSearch;
use rarma_plants::error::PlantError;
use rarma_plants::truth::{limit_of, zero_order_m};
use rarma_scenarios::scenario::{self, Loaded};
use rarma_scenarios::truth::crossing_word;
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
    /// For the picture: the same, and more where one lobe meets the next.
    #[serde(skip)]
    fine: Vec<LobePoint>,
    /// For the picture: the scenario's own speed, 1/min, and largest depth, mm.
    #[serde(skip)]
    cut: (f64, f64),
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
        sheet_told(dir, page::html(&all), args.json)?;
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
    let refused = |why| Failure::whole(name, why, "correct the fields it names");
    let points = points.map_err(refused)?;
    let fine = if args.report.is_some() {
        refined(&process, &points, most_mm).map_err(refused)?
    } else {
        Vec::new()
    };
    Ok(Lobes {
        scenario: loaded.scenario.name,
        most_mm,
        points,
        fine,
        cut: (nominal, 1e3 * process.depth().largest()),
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

/// Halvings of a step in which a lobe meets the next.
const HALVINGS: usize = 6;
/// A step of the chatter frequency by so much is one lobe meeting the next.
const STEP: f64 = 0.02;

/// How far two neighbours are from being on one lobe: the step of the frequency, part of it.
fn jump(a: &LobePoint, b: &LobePoint) -> f64 {
    match (a.chatter_hz, b.chatter_hz) {
        (Some(f), Some(g)) if a.crossing == b.crossing => (f - g).abs() / f,
        (None, None) => 0.0,
        _ => f64::INFINITY,
    }
}

/// The points, and more of them where the frequency jumps between two neighbours: there lies
/// a peak, which even steps of speed would cut off.
fn refined(
    process: &Process,
    points: &[LobePoint],
    most_mm: f64,
) -> Result<Vec<LobePoint>, PlantError> {
    let between: Result<Vec<Vec<LobePoint>>, PlantError> = points
        .par_windows(2)
        .map(|pair| {
            let (mut a, mut b) = (pair[0], pair[1]);
            let mut found = Vec::new();
            let halvings = if jump(&a, &b) > STEP { HALVINGS } else { 0 };
            for _ in 0..halvings {
                let middle = point(process, 0.5 * (a.speed_rpm + b.speed_rpm), most_mm)?;
                if jump(&a, &middle) > jump(&middle, &b) {
                    b = middle;
                } else {
                    a = middle;
                }
                found.push(middle);
            }
            Ok(found)
        })
        .collect();
    let mut all: Vec<LobePoint> = between?.into_iter().flatten().collect();
    all.extend_from_slice(points);
    all.sort_by(|a, b| a.speed_rpm.total_cmp(&b.speed_rpm));
    Ok(all)
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

    #[test]
    fn a_peak_between_two_speeds_is_found() {
        let loaded = scenario::load("two-tooth-benchmark", None).expect("shipped");
        let process = loaded.scenario.process;
        let at = |rpm| point(&process, rpm, 3.0).expect("valid");
        // The peak between the first and the second lobe lies near 13 900 1/min.
        let points = [at(13_000.0), at(15_000.0)];
        let fine = refined(&process, &points, 3.0).expect("valid");
        assert_eq!(fine.len(), 2 + HALVINGS);
        assert!(fine.is_sorted_by(|a, b| a.speed_rpm < b.speed_rpm));
        let highest = |all: &[LobePoint]| all.iter().filter_map(|p| p.depth_mm).fold(0.0, f64::max);
        assert!(highest(&fine) > 1.1 * highest(&points), "{fine:?}");
        // On one lobe nothing is added.
        let same = [at(16_000.0), at(16_100.0)];
        assert_eq!(refined(&process, &same, 3.0).expect("valid"), same);
    }
}
