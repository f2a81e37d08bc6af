//! Pictures of a record over the speed: the waterfall and the tracks.

use crate::commands::els::pictures::above;
use rarma_fit::welch_density;
use rarma_pictures::Map;
use rarma_pictures::{Chart, Mark, Scale, Series};
use rarma_scenarios::cers::CersRecord;
use rarma_scenarios::cers::response::Cleaned;
use rarma_scenarios::cers::sweep::{Point, Track};

/// Columns and rows of the waterfall, and its top, Hz.
const COLUMNS: usize = 240;
const ROWS: usize = 150;
const TOP_HZ: f64 = 1500.0;

/// All of them.
pub(super) fn pictures(record: &CersRecord, clean: &Cleaned, tracks: &[Track]) -> String {
    let mut body = waterfall(record, clean);
    for one in tracks {
        body += &track(one);
    }
    body
}

/// Spectrum over speed: figure 25.
fn waterfall(record: &CersRecord, clean: &Cleaned) -> String {
    let axis = usize::from(!record.setup.drive.axes[0]);
    let y = &clean.acceleration_m_per_s2[axis];
    let fs = record.setup.rate_hz;
    let (from, to) = record.speeds_hz();
    let piece = y.len() / COLUMNS;
    let mut level = vec![f64::NAN; COLUMNS * ROWS];
    for column in 0..COLUMNS {
        let x = &y[column * piece..(column + 1) * piece];
        for row in 0..ROWS {
            let f = TOP_HZ * (row as f64 + 0.5) / ROWS as f64;
            let p = welch_density(x, (fs / 20.0) as usize, f, fs);
            level[(ROWS - 1 - row) * COLUMNS + column] = 10.0 * p.max(1e-20).log10();
        }
    }
    let rpm = |hz: f64| 60.0 * hz;
    let lines = record
        .setup
        .orders
        .iter()
        .map(|o| {
            let end = to.min(TOP_HZ / o);
            [(rpm(from), o * from), (rpm(end), o * end)]
        })
        .collect();
    Map {
        title: "Spectral density of the acceleration over speed".to_owned(),
        x: ("speed (1/min)".to_owned(), rpm(from), rpm(to)),
        y: ("frequency (Hz)".to_owned(), 0.0, TOP_HZ),
        height: 380.0,
        columns: COLUMNS,
        level,
        lines,
        caption: format!(
            "Acceleration in {} over pieces of {:.2} s, (m/s²)²/Hz; fine lines: orders of the spindle and its bearings.",
            ["x", "y"][axis],
            piece as f64 / fs
        ),
    }
    .figure()
}

/// Frequency and damping of a track over speed: figure 26.
fn track(t: &Track) -> String {
    let most = t.points.iter().fold(1.0, |m: f64, p| m.max(p.rpm));
    let of = |keep: &dyn Fn(&Point) -> bool, y: &dyn Fn(&Point) -> f64| {
        t.points
            .iter()
            .filter(|p| keep(p))
            .map(|p| (p.rpm, y(p)))
            .collect::<Vec<_>>()
    };
    let chart =
        |what: &str, unit: &str, value: &dyn Fn(&Point) -> (f64, f64), truth: usize, scale: f64| {
            let band: Vec<f64> = t.points.iter().map(|p| value(p).0).collect();
            let top = if truth == 1 {
                above(band.iter().fold(0.0, |m: f64, x| m.max(*x)).min(25.0))
            } else {
                t.band_hz.1
            };
            let low = if truth == 1 { 0.0 } else { t.band_hz.0 };
            let dots = |name: &str, keep: &dyn Fn(&Point) -> bool, colour| Series {
                name: name.to_owned(),
                points: of(keep, &|p| value(p).0),
                mark: Mark::Dots,
                colour,
            };
            let edge = |sign: f64, name: &str| Series {
                name: name.to_owned(),
                points: t
                    .points
                    .iter()
                    .map(|p| {
                        let (x, sd) = value(p);
                        (
                            p.rpm,
                            if p.believed {
                                x + 2.0 * sign * sd
                            } else {
                                f64::NAN
                            },
                        )
                    })
                    .collect(),
                mark: Mark::Dashes,
                colour: 0,
            };
            Chart {
                title: format!(
                    "{what} over speed: {}, {:.0} to {:.0} Hz, {}",
                    t.axis,
                    t.band_hz.0,
                    t.band_hz.1,
                    if t.method == "arx" {
                        "ARX, force known"
                    } else {
                        "RARMA(6,5), response alone"
                    }
                ),
                x: Scale::linear("speed (1/min)", 0.0, most),
                y: Scale::linear(unit, low, top),
                height: 220.0,
                series: vec![
                    dots("believed", &|p| p.believed, 0),
                    dots(
                        "crossing: an order within the half-power band, not believed",
                        &|p| p.crossing.is_some(),
                        1,
                    ),
                    dots("too loose", &|p| p.crossing.is_none() && !p.believed, 5),
                    Series {
                        name: "truth".to_owned(),
                        points: t
                            .points
                            .iter()
                            .filter_map(|p| p.truth.map(|x| (p.rpm, scale * [x.0, x.1][truth])))
                            .collect(),
                        mark: Mark::Line,
                        colour: 2,
                    },
                    edge(1.0, "two standard deviations"),
                    edge(-1.0, ""),
                ],
                caption: t.against_truth.as_ref().map_or(String::new(), |e| {
                    let (median, most) = if truth == 1 {
                        (e.zeta_median, e.zeta_95)
                    } else {
                        (e.f_median, e.f_95)
                    };
                    format!(
                        "{} believed readings, off by {:.2} % (median), {:.2} % (95 of 100).",
                        e.believed,
                        100.0 * median,
                        100.0 * most
                    )
                }),
            }
            .figure()
        };
    chart("Frequency", "Hz", &|p| (p.f, p.f_sd), 0, 1.0)
        + &chart(
            "Damping ratio",
            "percent",
            &|p| (100.0 * p.zeta, 100.0 * p.zeta_sd),
            1,
            100.0,
        )
}
