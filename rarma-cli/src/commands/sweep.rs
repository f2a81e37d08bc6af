//! `rarma sweep`: one virtual cut at many depths: true root, what identification
//! reads, and the surface.

use super::band::detrended;
use super::estimators::{self, IdentifiedMode, Memory};
use super::fitting::with_stack;
use super::show;
use crate::args::{Detrend, Method, SweepArgs};
use crate::failure::Failure;
use crate::report::sheet_told;
use core::f64::consts::PI;
use rarma_pictures::{Chart, Mark, Scale, Series, sheet, table};
use rarma_plants::cut::Process;
use rarma_plants::error::PlantError;
use rarma_plants::milling::Milling;
use rarma_plants::process::Schedule;
use rarma_plants::surface::{Roughness, Wall, WallRecorder, turned_profile};
use rarma_plants::truth::roots;
use rarma_plants::turning::Turning;
use rarma_scenarios::ear;
use rarma_scenarios::scenario::{self, Loaded};
use rayon::prelude::*;
use serde::Serialize;

/// Revolutions of milling, and of turning, that the surface is taken from.
const MILLED_TURNS: f64 = 60.0;
const TURNED_TURNS: usize = 80;

/// One depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SweepPoint {
    /// Depth or width, mm.
    pub depth_mm: f64,
    /// Frequency of the dominant root in the band, Hz.
    pub root_f: Option<f64>,
    /// Its damping ratio.
    pub root_zeta: Option<f64>,
    /// Frequency of the least damped mode that is not forced, Hz.
    pub odr_f: Option<f64>,
    /// Its damping ratio: the operational damping that is read.
    pub odr: Option<f64>,
    /// Standard deviation of it, from the fit.
    pub odr_sd: Option<f64>,
    /// Roughness Ra, µm.
    pub ra_um: Option<f64>,
    /// Roughness Rz, µm.
    pub rz_um: Option<f64>,
    /// Surface location error, µm; positive: too much cut away.
    pub location_um: Option<f64>,
}

/// Cutting that is simulated at most, s.
const MOST_SECONDS: f64 = 100_000.0;

/// All depths of one case.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Sweep {
    /// Scenario, and speed if it was set.
    pub case: String,
    /// Spindle speed, 1/min.
    pub speed_rpm: f64,
    /// By depth.
    pub points: Vec<SweepPoint>,
}

pub(super) fn main(args: &SweepArgs) -> Result<u8, Failure> {
    let (p, q) = args.order;
    let cuts = args.scenarios.len() * args.rpm.len().max(1) * args.steps;
    let seconds = cuts as f64 * args.seconds;
    if seconds > MOST_SECONDS {
        return Err(Failure::Usage(format!(
            "--steps: {cuts} cuts of {} s are {seconds:.0} s of cutting (allowed: up to {MOST_SECONDS}; fewer --steps or --rpm, or less --seconds)",
            args.seconds
        )));
    }
    let mut all = Vec::new();
    for name in &args.scenarios {
        let loaded = scenario::load(name, args.seed)?;
        let nominal = 60.0 * loaded.scenario.process.spindle_hz();
        let speeds = if args.rpm.is_empty() {
            vec![nominal]
        } else {
            args.rpm.clone()
        };
        for speed_rpm in speeds {
            let process = loaded.scenario.process.at_spindle_hz(speed_rpm / 60.0);
            let (low, high) = args.depth_mm;
            let depths: Vec<f64> = (0..args.steps)
                .map(|i| low + (high - low) * i as f64 / (args.steps - 1).max(1) as f64)
                .collect();
            let bar = show::progress(depths.len() as u64, &loaded.scenario.name);
            let points = depths
                .par_iter()
                .map(|&depth_mm| {
                    let point = point(&loaded, &process, depth_mm, (p, q), args);
                    bar.inc(1);
                    point
                })
                .collect::<Result<_, _>>()?;
            bar.finish_and_clear();
            all.push(Sweep {
                case: format!("{} at {speed_rpm:.0} 1/min", loaded.scenario.name),
                speed_rpm,
                points,
            });
        }
    }
    if let Some(dir) = &args.report {
        sheet_told(dir, html(&all, args), args.json)?;
    }
    if args.json {
        let text = serde_json::to_string(&all).map_err(std::io::Error::from)?;
        say!("{{\"cases\":{text}}}");
    } else {
        tell(&all);
    }
    Ok(0)
}

fn point(
    loaded: &Loaded,
    process: &Process,
    depth_mm: f64,
    order: (usize, usize),
    args: &SweepArgs,
) -> Result<SweepPoint, Failure> {
    let refused =
        |why: PlantError| Failure::whole(&loaded.scenario.name, why, "correct the fields it names");
    let depth_m = 1e-3 * depth_mm;
    let band = loaded.band();
    let found = roots(process, f64::INFINITY, depth_m, 8).map_err(refused)?;
    let root = ear::audible(&found, band, 1.0).first().copied();
    let seed = args.seed.unwrap_or(1);
    let cut = ear::held(loaded, process, depth_m, args.seconds, seed);
    let heard = ear::hear(&cut, band, ear::Forced::Kept)?;
    let odr = read(&heard.band, heard.band_fs, order, process);
    let surface = surface(process, depth_m).map_err(refused)?;
    Ok(SweepPoint {
        depth_mm,
        root_f: root.map(|r| r.f_hz),
        root_zeta: root.map(|r| r.zeta),
        odr_f: odr.map(|m| m.f),
        odr: odr.map(|m| m.zeta),
        odr_sd: odr.map(|m| m.zeta_sd).filter(|s| s.is_finite()),
        ra_um: surface.map(|s| 1e6 * s.ra_m),
        rz_um: surface.map(|s| 1e6 * s.rz_m),
        location_um: surface.map(|s| 1e6 * s.location_m),
    })
}

/// The least damped mode that is not on a multiple of the teeth.
fn read(y: &[f64], fs: f64, order: (usize, usize), process: &Process) -> Option<IdentifiedMode> {
    let (_, y) = detrended(y, Detrend::Mean);
    let model = with_stack(|| estimators::fit(Method::Pem, &y, order, Memory::WHOLE)).ok()?;
    model
        .modes(fs)?
        .into_iter()
        .filter(|m| !ear::is_forced(process, m.f, m.f_sd))
        .min_by(|a, b| a.zeta.total_cmp(&b.zeta))
}

/// The surface of the same cut, once it has settled.
fn surface(process: &Process, depth_m: f64) -> Result<Option<Roughness>, PlantError> {
    let process = process.at_depth(Schedule::constant(depth_m));
    match &process {
        Process::Milling(c) => {
            if c.workpiece.is_some() {
                return Ok(None);
            }
            let mut mill = Milling::new((**c).clone())?;
            let turn = c.feed_per_tooth_m * c.teeth as f64;
            // Down-milling leaves its wall at φ = π; a slot is looked at there, too.
            let wall = if c.engagement.exit_rad > PI - 1e-6 {
                Wall::Down
            } else {
                Wall::Up
            };
            let settle = ear::SETTLE_S * c.spindle_hz * turn;
            let mut recorder = WallRecorder::new(&mill, wall, settle, MILLED_TURNS * turn)?;
            loop {
                let s = mill.step();
                if !recorder.take(&mill, &s) {
                    return Ok(Some(recorder.profile().roughness()));
                }
            }
        }
        Process::Turning(c) => {
            let mut lathe = Turning::new((**c).clone())?;
            let turn = lathe.steps_per_turn();
            let settle = (ear::SETTLE_S * c.spindle_hz).ceil() as usize;
            (0..settle * turn).for_each(|_| {
                lathe.step();
            });
            let samples: Vec<_> = (0..TURNED_TURNS * turn)
                .filter_map(|k| {
                    let s = lathe.step();
                    (k % turn == 0).then_some(s)
                })
                .collect();
            Ok(Some(
                turned_profile(&samples, c.feed_m, c.nose_radius_m).roughness(),
            ))
        }
    }
}

fn cell(x: Option<f64>, scale: f64, digits: usize) -> String {
    x.map_or("-".to_owned(), |x| format!("{:.digits$}", scale * x))
}

fn rows(case: &Sweep) -> Vec<Vec<String>> {
    case.points
        .iter()
        .map(|p| {
            vec![
                format!("{:.4}", p.depth_mm),
                cell(p.root_f, 1.0, 1),
                cell(p.root_zeta, 100.0, 3),
                cell(p.odr_f, 1.0, 1),
                cell(p.odr, 100.0, 3),
                cell(p.odr_sd, 100.0, 3),
                cell(p.ra_um, 1.0, 2),
                cell(p.rz_um, 1.0, 2),
                cell(p.location_um, 1.0, 2),
            ]
        })
        .collect()
}

const HEAD: [&str; 9] = [
    "depth mm",
    "root Hz",
    "root ζ %",
    "read Hz",
    "ODR %",
    "± %",
    "Ra µm",
    "Rz µm",
    "location µm",
];

fn tell(all: &[Sweep]) {
    for case in all {
        say!("{}", case.case);
        say!(
            "  {}",
            HEAD.iter()
                .map(|h| format!("{h:>11}"))
                .collect::<Vec<_>>()
                .join(" ")
        );
        for row in rows(case) {
            say!(
                "  {}",
                row.iter()
                    .map(|c| format!("{c:>11}"))
                    .collect::<Vec<_>>()
                    .join(" ")
            );
        }
    }
}

fn html(all: &[Sweep], args: &SweepArgs) -> String {
    let percent = |x: Option<f64>| 100.0 * x.unwrap_or(f64::NAN);
    let over = |pick: fn(&SweepPoint) -> Option<f64>| {
        all.iter()
            .flat_map(|c| c.points.iter().filter_map(pick))
            .filter(|x| x.is_finite())
            .fold(0.0, f64::max)
    };
    let depth = || Scale::linear("depth (mm)", args.depth_mm.0.min(0.0), args.depth_mm.1);
    let most = 100.0 * over(|p| p.root_zeta).max(over(|p| p.odr)).min(0.06);
    // Readings beyond the axis are drawn on its edge.
    let edge = 1.05 * most;
    let damping = Scale::linear("damping ratio (%)", -0.25 * most, edge);
    let roughest = over(|p| p.ra_um).max(1e-3);
    let finest = all
        .iter()
        .flat_map(|c| c.points.iter().filter_map(|p| p.ra_um))
        .filter(|x| *x > 0.0)
        .fold(roughest, f64::min);
    let decade = |x: f64, up: bool| {
        let e = x.log10();
        10_f64.powf(if up { e.ceil() } else { e.floor() })
    };
    let ra = Scale::log(
        "Ra (µm)",
        decade(finest, false),
        decade(roughest * 1.01, true),
    );
    let (mut zeta, mut rough, mut both) = (Vec::new(), Vec::new(), Vec::new());
    for (k, case) in all.iter().enumerate() {
        let series = |what: &str, mark, pick: &dyn Fn(&SweepPoint) -> (f64, f64)| Series {
            name: format!("{}: {what}", case.case),
            points: case.points.iter().map(pick).collect(),
            mark,
            colour: k,
        };
        zeta.push(series("dominant root", Mark::Line, &|p| {
            (p.depth_mm, percent(p.root_zeta))
        }));
        zeta.push(series("read (ODR)", Mark::Dots, &|p| {
            (p.depth_mm, percent(p.odr).min(edge))
        }));
        rough.push(series("Ra", Mark::Dots, &|p| {
            (p.depth_mm, p.ra_um.unwrap_or(f64::NAN))
        }));
        both.push(series("ODR and Ra", Mark::Dots, &|p| {
            (percent(p.odr).clamp(0.0, edge), p.ra_um.unwrap_or(f64::NAN))
        }));
    }
    let (p, q) = args.order;
    let charts = [
        Chart {
            title: "Operational damping: the delay equation, and what is read".to_owned(),
            x: depth(),
            y: damping.clone(),
            height: 300.0,
            series: zeta,
            caption: format!("Line: damping of the dominant root of the delay equation in the band; below 0 the cut is unstable. Dots: least damped mode that is not forced, batch ARMA({p},{q}) over {} s of sound; those on the upper edge lie above it. In chatter the amplitude is limited by the loss of contact and the reading stays at zero. Where a revolution holds many vibrations, neighbouring roots overlap: the reading is their common envelope, far above the dominant root, and falls only near the limit. There it tells the loss of stability, not the margin.", args.seconds),
        },
        Chart {
            title: "Roughness".to_owned(),
            x: depth(),
            y: ra.clone(),
            height: 240.0,
            series: rough,
            caption: "Ra of the profile the tool leaves, mean line removed, no cut-off filter.".to_owned(),
        },
        Chart {
            title: "Roughness against operational damping".to_owned(),
            x: Scale::linear("ODR (%)", 0.0, edge),
            y: ra,
            height: 260.0,
            series: both,
            caption: "Each dot one depth; ODR above the axis is drawn on its right edge, below 0 on its left. The relation is that of this cut: feed, nose radius and stiffness move it.".to_owned(),
        },
    ];
    let mut body: String = charts.iter().map(Chart::figure).collect();
    for case in all {
        body.push_str(&format!("<h2>{}</h2>\n", case.case));
        body.push_str(&table(&HEAD, &rows(case)));
    }
    let title = all
        .iter()
        .map(|c| c.case.as_str())
        .collect::<Vec<_>>()
        .join("; ");
    sheet("Depth sweep", &title, &body, env!("CARGO_PKG_VERSION"))
}
