//! `rarma ldbb`: one file per command, and what they share.

mod analyse;
mod circularity_pictures;
mod compare;
mod compare_pictures;
mod cycle_pictures;
mod error_pictures;
mod pictures;
mod run;

use super::els::{notices, out};
use crate::args::{KnownArgs, LdbbCommand, OutArgs};
use crate::failure::Failure;
use crate::output;
use rarma_recordings::input::Circles;
use rarma_scenarios::ldbb::{Findings, Options, evaluate, without_its_other};
use serde::Serialize;
use std::path::Path;

pub(super) fn main(command: &LdbbCommand) -> Result<u8, Failure> {
    match command {
        LdbbCommand::Run(args) => run::main(args),
        LdbbCommand::Analyse(args) => analyse::main(args),
        LdbbCommand::Compare(args) => compare::main(args),
    }
}

/// One run in the JSON.
#[derive(Debug, Clone, Serialize)]
struct RunLine {
    run: u32,
    dir: &'static str,
    way: &'static str,
    p_bar: f64,
    force_n: f64,
    readings: usize,
    circular_deviation_um: f64,
}

/// The JSON of `ldbb run` and `ldbb analyse`.
#[derive(Debug, Clone, Serialize)]
struct Answer {
    machine: String,
    plane: String,
    radius_mm: f64,
    feed_mm_min: f64,
    inclination_deg: f64,
    notes: Vec<String>,
    /// Circular deviation that is allowed, µm, and whether it is kept at the smallest force.
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance_um: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    within_tolerance: Option<bool>,
    runs: Vec<RunLine>,
    findings: Findings,
}

/// Evaluates readings; `file` is what a refusal names.
fn answer(circles: &Circles, known: &KnownArgs, file: &str) -> Result<Answer, Failure> {
    let c = &circles.conditions;
    let refused =
        |why: String| Failure::whole(file, why, "measure what is missing, or leave it out");
    complete(circles).map_err(refused)?;
    let options = Options {
        bar_m_per_n: 1e-6 * known.bar_compliance,
        order: usize::from(known.smooth),
        scale_sd: 0.01 * known.force_sd,
        pitch_m: 1e-3 * known.pitch,
        radius_m: c.radius_m,
        feed_m_s: c.feed_m_s,
        axes: c.axes(),
    };
    let findings = evaluate(&circles.runs, &circles.readings, &options)
        .map_err(|why| refused(why.to_string()))?;
    let mut notes = Vec::new();
    if findings.errors.iter().any(|e| e.squareness_includes_servo) {
        notes.push(
            "one direction: squareness includes the servo mismatch, lateral play is unknown"
                .to_owned(),
        );
    }
    if findings.stiffness.is_none() && !circles.runs.is_empty() {
        notes.push("fewer than three forces: no stiffness all round".to_owned());
    }
    if let Some(s) = findings.stiffness.as_ref().filter(|s| s.smoothing > 2.0) {
        notes.push(format!(
            "the smoothed stiffness leaves {:.1} times the noise: look at the raw one too",
            s.smoothing
        ));
    }
    notes.push("compliance of the balls' contacts is outside the gauge: not seen".to_owned());
    let runs = circles
        .runs
        .iter()
        .map(|r| RunLine {
            run: r.number,
            dir: r.sense.name(),
            way: if r.rising { "up" } else { "down" },
            p_bar: 1e-5 * r.pressure_pa,
            force_n: r.force_n,
            readings: r.points.len(),
            circular_deviation_um: rarma_rigs::ldbb::circular_deviation(
                &rarma_scenarios::ldbb::stiffness::trace(r),
            )
            .map_or(f64::NAN, |d| 1e6 * d.least_squares_m),
        })
        .collect();
    let judged = findings.errors.first().and_then(|e| e.circularity.judged());
    Ok(Answer {
        tolerance_um: known.tolerance,
        within_tolerance: known
            .tolerance
            .and_then(|tolerance| Some(judged?.1 <= tolerance)),
        machine: c.machine.clone(),
        plane: c.plane.clone(),
        radius_mm: 1e3 * c.radius_m,
        feed_mm_min: 6e4 * c.feed_m_s,
        inclination_deg: c.inclination_rad.to_degrees(),
        notes,
        runs,
        findings,
    })
}

/// Either every step was run both ways, or none was.
fn complete(circles: &Circles) -> Result<(), String> {
    match without_its_other(&circles.runs) {
        None => Ok(()),
        Some(r) => Err(format!(
            "a missing direction: run {} at {:.0} N is {} and has no {} beside it (measure it, or leave the run out)",
            r.number,
            r.force_n,
            r.sense.name(),
            r.sense.reversed().name()
        )),
    }
}

fn show(answer: &Answer, circles: &Circles, args: &OutArgs) -> Result<u8, Failure> {
    notices(&answer.notes);
    let body = if args.report.is_some() {
        pictures::page(answer, circles)
    } else {
        String::new()
    };
    let heading = format!(
        "{}, plane {}, {:.0} mm/min, {:.0}°",
        answer.machine, answer.plane, answer.feed_mm_min, answer.inclination_deg
    );
    if out(args, "Loaded ball bar", &heading, &body, answer)? {
        words(answer, circles);
    }
    Ok(0)
}

fn words(answer: &Answer, circles: &Circles) {
    if let Some(s) = &answer.findings.stiffness {
        say!("stiffness {:.2} N/µm on average", s.mean_n_per_um);
        for (name, e) in [("largest ", &s.most), ("smallest", &s.least)] {
            say!(
                "  {name} {:.2} ± {:.3} N/µm at {:.1}°",
                e.n_per_um,
                e.sd_n_per_um,
                e.angle_deg
            );
        }
    }
    for c in &answer.findings.standing {
        if let (Some(k), Some(sd)) = (c.n_per_um, c.sd_n_per_um) {
            say!(
                "standing at {:3.0}°: {k:.2} ± {sd:.3} N/µm, hysteresis {:.1} µm",
                c.angle_deg,
                c.left_um
            );
        }
    }
    let [a, b] = circles.conditions.axes();
    let first = answer.findings.errors.first();
    if let Some(text) = first.and_then(|e| circularity_pictures::verdict(e, answer.tolerance_um)) {
        say!("{text}");
    }
    for e in &answer.findings.errors {
        say!(
            "{:4.0} N: circular deviation {:.1} µm, scale mismatch {:.2} ± {:.2} µm, squareness {:.1} ± {:.1} µrad{}",
            e.force_n,
            e.circular_um,
            e.scale_mismatch_um.value,
            e.scale_mismatch_um.sd,
            e.squareness_urad.value,
            e.squareness_urad.sd,
            e.backlash_um.map_or(String::new(), |x| format!(
                ", backlash {a} {:.2}, {b} {:.2} µm",
                x[0].value, x[1].value
            ))
        );
    }
}

/// Writes the findings as `rarma ldbb compare` reads them.
fn save(path: &Path, answer: &Answer) -> Result<(), Failure> {
    let text = serde_json::to_string(answer).map_err(std::io::Error::from)?;
    Ok(output::write(path, text)?)
}
