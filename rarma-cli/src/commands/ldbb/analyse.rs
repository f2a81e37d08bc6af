//! `rarma ldbb analyse`: readings to findings.

use super::{answer, save, show};
use crate::args::LdbbAnalyseArgs;
use crate::failure::Failure;
use rarma_recordings::input::read_circles;
use std::path::PathBuf;

pub(super) fn main(args: &LdbbAnalyseArgs) -> Result<u8, Failure> {
    let mut files = Vec::new();
    for path in &args.files {
        if path.is_dir() {
            let mut tables: Vec<PathBuf> = std::fs::read_dir(path)?
                .filter_map(|entry| Some(entry.ok()?.path()))
                .filter(|p| p.extension().is_some_and(|e| e == "csv"))
                .collect();
            tables.sort();
            if tables.is_empty() {
                return Err(Failure::Input(format!(
                    "{}: open: there is no .csv in it (name a folder that `rarma ldbb run --out` wrote)",
                    path.display()
                )));
            }
            files.append(&mut tables);
        } else {
            files.push(path.clone());
        }
    }
    let circles = read_circles(&files)?;
    let name = match files.as_slice() {
        [one] => one.display().to_string(),
        [first, .., last] => format!("{} to {}", first.display(), last.display()),
        [] => String::new(),
    };
    let answer = answer(&circles, &args.known, &name)?;
    if let Some(path) = &args.save {
        save(path, &answer)?;
    }
    show(&answer, &circles, &args.show)
}
