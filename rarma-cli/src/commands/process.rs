//! What the process adds to the modes of a structure, line by line and in words.

use crate::failure::Failure;
use crate::record::{Line, ModeRecord};
use crate::translate::decimal;
use rarma_core::decide::Structure;
use rarma_recordings::input;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Reads the structure that is named, if one is.
///
/// # Errors
/// Bad input, in one line.
pub fn structure(path: Option<&Path>) -> Result<Option<Structure<f64>>, Failure> {
    Ok(path.map(input::read_structure).transpose()?)
}

/// Adds the part of the process to every mode of a line.
pub fn annotate(line: &mut Line, structure: &Structure<f64>) {
    for mode in &mut line.modes {
        let process = structure.process_damping((mode.f, mode.f_sd), (mode.zeta, mode.zeta_sd));
        mode.zeta_process = Some(process.map(|p| decimal(p.zeta as f32)));
        mode.zeta_process_sd = Some(process.map(|p| decimal(p.zeta_sd as f32)));
    }
}

/// Readings of a mode that are kept; of more, every second, fourth, … is.
const MOST: usize = 1 << 16;

/// What the process adds to each mode of a structure over a run.
#[derive(Clone)]
pub struct Added {
    structure: Structure<f64>,
    modes: Vec<Readings>,
}

/// What it adds to one mode.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Readings {
    heard: u64,
    sure: u64,
    /// Every `step`th reading.
    kept: Vec<f64>,
    step: u64,
}

impl Added {
    /// Nothing heard yet.
    pub fn new(structure: Structure<f64>) -> Self {
        let none = Readings {
            heard: 0,
            sure: 0,
            kept: Vec::new(),
            step: 1,
        };
        Self {
            modes: vec![none; structure.modes().len()],
            structure,
        }
    }

    /// What was heard of each mode.
    pub(super) fn heard(&self) -> &[Readings] {
        &self.modes
    }

    /// Goes on with what another one has heard; false where that is not of the same structure.
    pub(super) fn go_on(&mut self, heard: Vec<Readings>) -> bool {
        let sound = |one: &Readings| one.kept.len() <= MOST && one.step.is_power_of_two();
        if heard.len() != self.modes.len() || !heard.iter().all(sound) {
            return false;
        }
        self.modes = heard;
        true
    }

    /// Takes a line, and writes into it what the process adds.
    pub fn take(&mut self, line: &mut Line) {
        annotate(line, &self.structure);
        for (i, readings) in self.modes.iter_mut().enumerate() {
            let read = |m: &ModeRecord| {
                let p = self
                    .structure
                    .process_damping((m.f, m.f_sd), (m.zeta, m.zeta_sd))?;
                (p.mode == i).then_some((p.zeta, p.significance))
            };
            if let Some((zeta, significance)) = line.modes.iter().find_map(read) {
                readings.take(zeta, significance.abs() > 2.0);
            }
        }
    }

    /// A line for each mode of the structure that was heard: the median of what the
    /// process adds to its damping, and how often it was for certain (two standard
    /// deviations).
    pub fn words(self) {
        for (at_rest, mut read) in self.structure.modes().iter().zip(self.modes) {
            let rest = format!(
                "Mode at {:.1} Hz ({:.2} % at rest)",
                at_rest.f_hz,
                100.0 * at_rest.zeta
            );
            read.kept.sort_by(f64::total_cmp);
            match read.kept.get(read.kept.len() / 2) {
                Some(median) => say!(
                    "{rest}: the process adds {:+.2} % (median of {} lines, {} of them beyond two standard deviations).",
                    100.0 * median,
                    read.heard,
                    read.sure
                ),
                None => say!("{rest}: not heard."),
            }
        }
    }
}

impl Readings {
    fn take(&mut self, zeta: f64, sure: bool) {
        if self.heard.is_multiple_of(self.step) {
            if self.kept.len() == MOST {
                let mut n = 0;
                self.kept.retain(|_| {
                    n += 1;
                    n % 2 == 1
                });
                self.step *= 2;
            }
            if self.heard.is_multiple_of(self.step) {
                self.kept.push(zeta);
            }
        }
        self.heard += 1;
        self.sure += u64::from(sure);
    }
}
