//! `rarma ldbb compare`: machines, feeds or inclinations side by side.

use super::{compare_pictures, out};
use crate::args::LdbbCompareArgs;
use crate::failure::Failure;
use rarma_recordings::input;
use rarma_scenarios::ldbb::compare::{Machine, rank, spread};
use serde::Serialize;
use std::path::Path;

/// No analysis is larger than this, bytes: it holds some thousand points.
const MOST_BYTES: u64 = 1 << 26;

/// The JSON of `ldbb compare`.
#[derive(Debug, Clone, Serialize)]
struct Answer<'a> {
    /// Stiffest first.
    machines: &'a [Machine],
    /// Largest mean less the smallest over their middle.
    spread: f64,
}

pub(super) fn main(args: &LdbbCompareArgs) -> Result<u8, Failure> {
    let mut machines = args
        .tests
        .iter()
        .map(|path| read(path))
        .collect::<Result<Vec<_>, _>>()?;
    rank(&mut machines);
    let answer = Answer {
        machines: &machines,
        spread: spread(&machines),
    };
    let body = compare_pictures::comparison(&machines, answer.spread);
    if out(
        &args.show,
        "Loaded ball bar, comparison",
        &format!("{} tests", machines.len()),
        &body,
        &answer,
    )? {
        for (k, m) in machines.iter().enumerate() {
            say!(
                "{}. {:10} {:6.2} N/µm ({:.2} at {:.0}° to {:.2} at {:.0}°), {:.0} mm/min, {:.0}°",
                k + 1,
                m.name,
                m.mean,
                m.least.0,
                m.least.1,
                m.most.0,
                m.most.1,
                m.feed_mm_min,
                m.inclination_deg
            );
        }
        say!("spread {:.1} %", 100.0 * answer.spread);
    }
    Ok(0)
}

fn read(path: &Path) -> Result<Machine, Failure> {
    let file = if path.is_dir() {
        path.join("analysis.json")
    } else {
        path.to_path_buf()
    };
    let name = file.display();
    let remedy = "name a folder that `rarma ldbb run --out` wrote, or a file of `analyse --save`";
    let text = input::text(&file, MOST_BYTES).map_err(|mut why| {
        if why.problem == input::Problem::NotFound {
            why.remedy = remedy.to_owned();
        }
        why
    })?;
    let value = serde_json::from_str(&text).map_err(|why| {
        let line = why.line();
        Failure::Input(format!("{name}: line {line}: not JSON ({remedy})"))
    })?;
    Machine::from_json(&value).map_err(|why| {
        Failure::Input(format!(
            "{name}: whole file: {why} (stiffness needs three forces)"
        ))
    })
}
