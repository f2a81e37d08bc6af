//! `rarma plant`.

use super::store::start_of;
use crate::args::PlantArgs;
use crate::commands::show;
use crate::failure::Failure;
use crate::output::{self, NewFile};
use rarma_fleet::plant::{Fate, Plant, PlantConfig};
use rarma_fleet::record::to_line;
use std::io::{BufWriter, Write};

pub(in crate::commands) fn main(args: &PlantArgs) -> Result<u8, Failure> {
    let days = (f64::from(args.months) * 365.25 / 12.0).round();
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most 3653"
    )]
    let days = days as u32;
    let mut plant = Plant::new(PlantConfig {
        machines: args.machines as usize,
        days,
        start: start_of("--start", &args.start)?,
        seed: args.seed,
        fate: Fate::Usual,
        tests_only: args.tests_only,
    });
    output::folder(&args.out)?;
    let path = args.out.join("records.jsonl");
    let mut file = BufWriter::new(NewFile::create(&path)?);
    let cannot = |why: &std::io::Error| output::failed(&path, "write", why);
    let bar = show::progress(u64::from(days), "days");
    let mut count = 0_u64;
    while let Some(records) = plant.next_day() {
        for record in records {
            let line = to_line(&record).map_err(|why| Failure::System(why.to_string()))?;
            writeln!(file, "{line}").map_err(|why| cannot(&why))?;
            count += 1;
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let file = file.into_inner().map_err(|why| cannot(why.error()))?;
    let truth = serde_json::to_vec_pretty(&plant.truth())
        .map_err(|why| Failure::System(why.to_string()))?;
    let truth = NewFile::whole(&args.out.join("truth.json"), &truth)?;
    output::keep(vec![file.done()?, truth])?;
    say!(
        "{}: {count} records of {} machines over {days} days",
        path.display(),
        args.machines
    );
    Ok(0)
}
