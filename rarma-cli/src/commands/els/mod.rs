//! `rarma els`: one file per command, and what they share.

mod fit;
mod hammer;
mod limit;
mod model;
pub(super) mod pictures;

use crate::args::{ElsCommand, OutArgs};
use crate::failure::Failure;
use crate::report::sheet_told;
use rarma_pictures::sheet;
use rarma_scenarios::els::diagram::{Diagram, Direction};
use serde::Serialize;
use std::path::Path;

pub(super) fn main(command: &ElsCommand) -> Result<u8, Failure> {
    match command {
        ElsCommand::Model(args) => model::main(args),
        ElsCommand::Limit(args) => limit::main(args),
        ElsCommand::Hammer(args) => hammer::main(args),
        ElsCommand::Fit(args) => fit::main(args),
    }
}

/// Writes the page and the JSON that were asked for; true if the words are wanted too.
pub(super) fn out(
    args: &OutArgs,
    title: &str,
    name: &str,
    body: &str,
    value: &impl Serialize,
) -> Result<bool, Failure> {
    if let Some(dir) = &args.report {
        sheet_told(
            dir,
            sheet(title, name, body, env!("CARGO_PKG_VERSION")),
            args.json,
        )?;
    }
    if args.json {
        let text = serde_json::to_string(value).map_err(std::io::Error::from)?;
        say!("{text}");
    }
    Ok(!args.json)
}

/// A file's name without its folders, for headings.
fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |n| n.to_string_lossy().into_owned(),
    )
}

/// What odd input is told about, on standard error.
pub(super) fn notices(all: &[String]) {
    for notice in all {
        eprintln!("rarma: note: {notice}");
    }
}

fn width(d: &Direction) -> String {
    match (d.width_mm, d.chatter_hz) {
        (Some(w), Some(f)) => format!("{w:.3} mm at {:.0}°, chatter at {f:.1} Hz", d.angle_deg),
        _ => format!("none at {:.0}°", d.angle_deg),
    }
}

/// The diagram in words.
fn tell(diagram: &Diagram) {
    if let Some(r) = diagram.reciprocity {
        let mean = if diagram.symmetrised {
            ", replaced by their mean"
        } else {
            ""
        };
        say!("cross receptances apart by {:.1} %{mean}", 100.0 * r);
    }
    say!("smallest limit {}", width(&diagram.worst));
    say!("largest limit  {}", width(&diagram.best));
    if let Some(k) = diagram.polar[0].stiffness_n_per_um {
        let across = diagram.polar[diagram.polar.len() / 4];
        say!(
            "static stiffness {k:.2} ± {:.2} N/µm in u",
            diagram.polar[0].stiffness_sd_n_per_um.unwrap_or(0.0)
        );
        if let (Some(k), Some(sd)) = (across.stiffness_n_per_um, across.stiffness_sd_n_per_um) {
            say!("static stiffness {k:.2} ± {sd:.2} N/µm in v");
        }
    }
}
