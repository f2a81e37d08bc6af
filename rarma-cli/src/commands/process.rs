//! What the process adds to the modes of a structure, line by line and in words.

use crate::collect::decimal;
use crate::failure::Failure;
use crate::input;
use crate::record::{ModeRecord, Run};
use rarma_core::decide::Structure;
use std::path::Path;

/// Reads the structure that is named, if one is.
///
/// # Errors
/// Bad input, in one line.
pub fn structure(path: Option<&Path>) -> Result<Option<Structure<f64>>, Failure> {
    Ok(path.map(input::read_structure).transpose()?)
}

/// Adds the part of the process to every mode of a run.
pub fn annotate(run: &mut Run, structure: &Structure<f64>) {
    for mode in run.lines.iter_mut().flat_map(|line| &mut line.modes) {
        let process = structure.process_damping((mode.f, mode.f_sd), (mode.zeta, mode.zeta_sd));
        mode.zeta_process = Some(process.map(|p| decimal(p.zeta as f32)));
        mode.zeta_process_sd = Some(process.map(|p| decimal(p.zeta_sd as f32)));
    }
}

/// A line for each mode of the structure that was heard: the median of what the process
/// adds to its damping, and how often it was for certain (two standard deviations).
pub fn words(run: &Run, structure: &Structure<f64>) {
    for (i, at_rest) in structure.modes().iter().enumerate() {
        let read = |m: &ModeRecord| {
            let p = structure.process_damping((m.f, m.f_sd), (m.zeta, m.zeta_sd))?;
            (p.mode == i).then_some((p.zeta, p.significance))
        };
        let mut read: Vec<(f64, f64)> = run
            .lines
            .iter()
            .filter_map(|line| line.modes.iter().find_map(read))
            .collect();
        read.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some((median, _)) = read.get(read.len() / 2) else {
            say!(
                "Mode at {:.1} Hz ({:.2} % at rest): not heard.",
                at_rest.f_hz,
                100.0 * at_rest.zeta
            );
            continue;
        };
        let sure = read.iter().filter(|(_, s)| s.abs() > 2.0).count();
        say!(
            "Mode at {:.1} Hz ({:.2} % at rest): the process adds {:+.2} % (median of {} lines, {} of them beyond two standard deviations).",
            at_rest.f_hz,
            100.0 * at_rest.zeta,
            100.0 * median,
            read.len(),
            sure
        );
    }
}
