//! `rarma cers`: run and analyse, and what they share.

mod export;
mod over_speed;
mod pictures;
mod words;

use super::els::{notices, out};
use crate::args::{CersCommand, CersRunArgs, OutArgs, ReadingArgs};
use crate::failure::Failure;
use rarma_scenarios::cers::CersRecord;
use rarma_scenarios::cers::modes::{Modes, modes};
use rarma_scenarios::cers::response::{Response, Sensor, cleaned, response};
use rarma_scenarios::cers::sweep::{Sweep, sweep};
use rarma_scenarios::measure::measured;
use rarma_scenarios::scenario::{SHIPPED_CERS, cers_schema, load_cers, parse_cers, read_cers};
use serde::Serialize;

/// A response in the JSON.
#[derive(Debug, Clone, Serialize)]
struct ResponseLine {
    force: &'static str,
    motion: &'static str,
    sensor: &'static str,
    lines: usize,
    blocks: u32,
    coherence_median: f64,
    random_error_median: f64,
    /// Medians of |H1|, |H2| and |Hv| over |H_IV|, less 1.
    h1_bias: f64,
    h2_bias: f64,
    hv_bias: f64,
}

/// The JSON of `cers run` and `cers analyse`.
#[derive(Debug, Clone, Serialize)]
struct Answer {
    name: String,
    fs: f64,
    seconds: f64,
    rpm: (f64, f64),
    signal: &'static str,
    band_hz: (f64, f64),
    notes: Vec<String>,
    responses: Vec<ResponseLine>,
    #[serde(flatten)]
    modes: Option<Modes>,
    sweep: Option<Sweep>,
}

pub(super) fn main(command: &CersCommand) -> Result<u8, Failure> {
    match command {
        CersCommand::Run(args) => run(args),
        CersCommand::Analyse(args) => {
            let record = read_cers(&args.record)?;
            let file = args.record.display().to_string();
            analysed(&record, Vec::new(), &args.reading, &args.show, &file)
        }
    }
}

fn run(args: &CersRunArgs) -> Result<u8, Failure> {
    if args.schema {
        say!("{:#}", cers_schema());
        return Ok(0);
    }
    if args.list {
        for (name, text) in SHIPPED_CERS {
            say!("{name:16} {}", parse_cers(name, text)?.about);
        }
        return Ok(0);
    }
    let file = args.scenario.as_deref().unwrap_or_default();
    let scenario = load_cers(file)?;
    let measured = measured(&scenario)
        .map_err(|why| Failure::whole(file, why, "correct the fields it names"))?;
    if let Some(dir) = &args.out {
        measured.record.write(dir)?;
    }
    analysed(
        &measured.record,
        measured.notes,
        &args.reading,
        &args.show,
        file,
    )
    .map_err(|why| match &args.out {
        Some(dir) => why.kept(format!(
            "the record is kept: rarma cers analyse {}",
            dir.display()
        )),
        None => why.kept("the record is lost: --out DIR keeps it"),
    })
}

fn analysed(
    record: &CersRecord,
    mut notes: Vec<String>,
    reading: &ReadingArgs,
    show: &OutArgs,
    file: &str,
) -> Result<u8, Failure> {
    let refused =
        |why: String| Failure::whole(file, why, "measure again, with more force or longer");
    let clean = cleaned(record).map_err(refused)?;
    for (axis, doubtful) in clean.doubtful.iter().enumerate() {
        if *doubtful > 0 {
            notes.push(format!(
                "force {}: {doubtful} of {} samples are not to be trusted (iron beyond its knee, or a gap closed)",
                ["x", "y"][axis],
                record.len()
            ));
        }
    }
    let sweeps = record.is_sweep();
    let mut responses = Vec::new();
    if !sweeps {
        for (from, to, sensor) in wanted(record) {
            responses
                .push(response(record, &clean, (from, to), sensor, |_| false).map_err(refused)?);
        }
        let turned = 1e6 * clean.orders_rms_m[0].max(clean.orders_rms_m[1]);
        if turned > 0.0 {
            notes.push(format!(
                "runout, unbalance and bearings at the spindle's orders taken out: {turned:.2} µm rms"
            ));
        }
    }
    export::responses(reading, &record.setup.name, &responses)?;
    let found = if sweeps {
        None
    } else {
        Some(modes(record, &clean, reading.band, !reading.quick).map_err(refused)?)
    };
    let tracks = if sweeps {
        Some(sweep(record, &clean).map_err(refused)?)
    } else {
        None
    };
    let (from, to) = record.speeds_hz();
    let answer = Answer {
        name: record.setup.name.clone(),
        fs: record.setup.rate_hz,
        seconds: record.seconds(),
        rpm: (60.0 * from, 60.0 * to),
        signal: record.setup.drive.signal.name(),
        band_hz: reading.band,
        notes,
        responses: responses.iter().map(line).collect(),
        modes: found,
        sweep: tracks,
    };
    export::structure(reading, &answer)?;
    notices(&answer.notes);
    let body = if show.report.is_some() {
        pictures::page(&answer, record, &clean, &responses, reading.quantity)
    } else {
        String::new()
    };
    let speed = match answer.rpm {
        (from, to) if (to - from).abs() >= 1.0 => format!("{from:.0} to {to:.0} 1/min"),
        (at, _) if at.abs() >= 1.0 => format!("{at:.0} 1/min"),
        _ => "0 1/min".to_owned(),
    };
    let heading = format!("{}: {:.1} s, {speed}", answer.name, answer.seconds);
    if out(show, "Exciter", &heading, &body, &answer)? {
        words::tell(&answer);
    }
    Ok(0)
}

/// Direct and cross, both sensors, of every driven direction.
fn wanted(record: &CersRecord) -> Vec<(usize, usize, Sensor)> {
    let mut out = Vec::new();
    for from in 0..2 {
        if !record.setup.drive.axes[from] {
            continue;
        }
        for to in [from, 1 - from] {
            for sensor in [Sensor::Displacement, Sensor::Accelerometer] {
                out.push((from, to, sensor));
            }
        }
    }
    out
}

fn sensor_name(sensor: Sensor) -> &'static str {
    match sensor {
        Sensor::Displacement => "displacement",
        Sensor::Accelerometer => "accelerometer",
    }
}

fn line(r: &Response) -> ResponseLine {
    let median = |of: &dyn Fn(&rarma_scenarios::cers::response::Line) -> f64| {
        let mut all: Vec<f64> = r.lines.iter().map(of).filter(|x| x.is_finite()).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
    };
    ResponseLine {
        force: ["x", "y"][r.from],
        motion: ["x", "y"][r.to],
        sensor: sensor_name(r.sensor),
        lines: r.lines.len(),
        blocks: r.blocks,
        coherence_median: median(&|l| l.raw.coherence),
        random_error_median: median(&|l| l.raw.iv_random_error),
        h1_bias: median(&|l| l.raw.h1.abs() / l.raw.iv.abs() - 1.0),
        h2_bias: median(&|l| l.raw.h2.abs() / l.raw.iv.abs() - 1.0),
        hv_bias: median(&|l| l.raw.hv.abs() / l.raw.iv.abs() - 1.0),
    }
}
