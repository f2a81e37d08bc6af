//! `rarma ldbb run`: a whole test on a simulated machine.

use super::{answer, save, show};
use crate::args::LdbbRunArgs;
use crate::failure::Failure;
use crate::output;
use rarma_plants::ldbb::drive::{Trouble, circles, standing};
use rarma_recordings::input::{Circles, Static, circle_file};
use rarma_rigs::ldbb::{ForceLaw, Held, Schedule, StandingConfig, ValveConfig};
use rarma_scenarios::ldbb::from_recorded;
use rarma_scenarios::scenario::{LdbbScenario, SHIPPED_LDBB, ldbb_schema, load_ldbb, parse_ldbb};
use std::path::Path;

pub(super) fn main(args: &LdbbRunArgs) -> Result<u8, Failure> {
    if args.schema {
        say!("{:#}", ldbb_schema());
        return Ok(0);
    }
    if args.list {
        for (name, text) in SHIPPED_LDBB {
            say!("{name:16} {}", parse_ldbb(name, text)?.about);
        }
        return Ok(0);
    }
    let file = args.scenario.as_deref().unwrap_or_default();
    let scenario = load_ldbb(file)?;
    let Measured { circles, ended } = measured(&scenario, file)?;
    // What was measured is kept before anything is made of it.
    if let Some(dir) = &args.out {
        record(dir, &circles)?;
    }
    let keeping = |failure: Failure| match &args.out {
        Some(dir) => failure.kept(format!(
            "the readings are kept: rarma ldbb analyse {}",
            dir.display()
        )),
        None => failure.kept("the readings are lost: --out DIR keeps them"),
    };
    if let Some(why) = ended {
        return Err(keeping(why));
    }
    let answer = answer(&circles, &args.known, file).map_err(keeping)?;
    if let Some(dir) = &args.out {
        save(&dir.join("analysis.json"), &answer)?;
    }
    show(&answer, &circles, &args.show)
}

/// One table a run, and one of the static test.
fn record(dir: &Path, circles: &Circles) -> Result<(), Failure> {
    let mut files = Vec::new();
    for run in &circles.runs {
        let name = format!(
            "run-{:02}-{}-{:.0}N.csv",
            run.number,
            run.sense.name(),
            run.force_n
        );
        files.push((name, circle_file(&circles.conditions, Some(run), &[])));
    }
    if !circles.readings.is_empty() {
        let table = circle_file(&circles.conditions, None, &circles.readings);
        files.push(("static.csv".to_owned(), table));
    }
    let bytes = files.into_iter().map(|(name, text)| (name, text.into()));
    Ok(output::write_all(dir, bytes)?)
}

/// What came of a test, and why it ended early where it did.
struct Measured {
    circles: Circles,
    ended: Option<Failure>,
}

/// Runs the sequence on the bench.
///
/// # Errors
/// The scenario does not go. A test that ends early is no error: its runs are there.
fn measured(s: &LdbbScenario, file: &str) -> Result<Measured, Failure> {
    let refused = |why: String| Failure::whole(file, why, "correct the fields it names");
    let pressures: Vec<f32> = s.settings.iter().map(|x| x.pressure_pa as f32).collect();
    let schedule = |both, down| {
        Schedule::new(&pressures, both, down)
            .ok_or_else(|| refused("more than 16 forces".to_owned()))
    };
    let valve = ValveConfig {
        most_pa: s.bench.air.span_pa as f32,
        ..ValveConfig::default()
    };
    let test = circles(
        s.bench,
        s.procedure,
        valve,
        schedule(s.both, s.down)?,
        &Trouble::default(),
    )
    .ok_or_else(|| refused("the circle's settings do not fit together".to_owned()))?;
    let mut ended = test.fault.map(|why| {
        let run = test.fault_run.unwrap_or(0);
        refused(format!("the test ended in run {run}: {why:?}"))
    });
    let law = ForceLaw::standard();
    let incline = s.conditions.inclination_rad;
    let overshoot = f64::from(s.procedure.overshoot_rad);
    let runs = test
        .runs
        .iter()
        .map(|r| from_recorded(r, &law, overshoot, incline))
        .collect();
    let mut readings = Vec::new();
    if ended.is_none() && !s.directions_rad.is_empty() {
        let config = StandingConfig {
            directions: u8::try_from(s.directions_rad.len())
                .map_err(|_| refused("more than 255 directions".to_owned()))?,
            ..StandingConfig::default()
        };
        let held = standing(
            s.bench,
            config,
            valve,
            schedule(false, true)?,
            &s.directions_rad,
        );
        match held {
            Some(held) => {
                let reading = |h: &Held| {
                    Static::new(h, s.directions_rad[usize::from(h.direction)], &law, incline)
                };
                readings = held.iter().map(reading).collect();
            }
            None => ended = Some(refused("the static test ended early".to_owned())),
        }
    }
    Ok(Measured {
        circles: Circles {
            conditions: s.conditions.clone(),
            runs,
            readings,
        },
        ended,
    })
}
