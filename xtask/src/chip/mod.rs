//! `cargo xtask chip`: what the image for the NUCLEO-G474RE takes of its chip, and what it
//! may never do.
//!
//! Sizes and reachable calls are read from the linked image; the stack and the instructions
//! are of a run on the model of the chip, which listens to a fixed sound.

mod accelerator;
mod benchmark;
pub mod figures;
pub mod instruction;
pub mod model;
pub mod profile;
pub mod program;
mod registers;
pub mod schedule;
pub mod stack;
pub mod timing;
#[cfg(test)]
mod timing_tests;
pub mod trace;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::arm_image::{ArmImage, Function};
use crate::count::calls::Unwanted;
use crate::fw::{self, Request};
use crate::toolchain::{ARM, Toolchain};
use crate::{Failure, Result, Workspace, page, process};
use figures::Figures;
use model::{Model, Run};
use program::{COUPLED, Program};
use stack::Stack;
use trace::Trace;

/// The board whose image this is about.
pub const BOARD: &str = "nucleo-g474re";

/// Where the table of figures is.
pub const PAGE: &str = "docs/flash.md";

/// What the model writes of a run's steps.
pub const TRACE: &str = "trace.bin";

/// Functions that are the roots of the duties that may not stop, by a part of their names.
const DUTIES: [&str; 2] = ["Listening4pass", "current_duty"];

/// Functions of the start, by a part of their names: while they run, the stack has all of its memory.
const START: [&str; 3] = ["6target5place", "6Nucleo6set_up", "9SensorBox7prepare"];

/// Handlers of interrupts; all have one priority, so that none breaks into another.
const HANDLERS: [&str; 6] = ["TIM2", "ADC3", "PVD_PVM", "COMP1_2_3", "COMP4_5_6", "COMP7"];

/// Seconds of the run, and from when on instructions are counted: by then the model of the
/// sound has settled.
const SECONDS: f64 = 1.6;
const COUNT_FROM_S: f64 = 1.5;
/// Until then one PWM period in so many is made: it is quicker.
const BRIDGE_EVERY: u32 = 48;

/// Builds the image and returns its path.
///
/// # Errors
/// When it does not build.
pub fn build(workspace: &Workspace, toolchain: &Toolchain) -> Result<PathBuf> {
    let request = Request::build(BOARD)?;
    process::run(&mut fw::command(workspace, toolchain, &request))?;
    Ok(fw::elf_path(workspace, request.board, BOARD))
}

/// Measures the image.
///
/// # Errors
/// When the model cannot be had, the image gets stuck in it, or a duty is not in the image.
pub fn measure(workspace: &Workspace, toolchain: &Toolchain, elf: &Path) -> Result<Figures> {
    let image = ArmImage::read(elf)?;
    let program = Program::read_file(elf)?;
    if let Some(name) = too_early(&image) {
        return Err(Failure::new(format!(
            "the start calls {name}, whose program is copied to where it runs only after it"
        ))
        .advise("take it out of the section `.coupled` of firmware/memory/nucleo-g474re.x"));
    }
    let words = Program::words(elf)?;
    let at_start = Stack::new(&image, words.iter().copied()).program(&HANDLERS)?;
    let afterwards = Stack::new(&image, words).after(&START).program(&HANDLERS)?;
    let folder = workspace.target_dir().join("g474");
    std::fs::create_dir_all(&folder)
        .map_err(|why| Failure::new(format!("cannot make {}", folder.display())).because(why))?;
    let sound = folder.join("sound.u16");
    let codes = figures::sound(SECONDS).into_iter();
    let bytes: Vec<u8> = codes.flat_map(u16::to_le_bytes).collect();
    std::fs::write(&sound, bytes)
        .map_err(|why| Failure::new(format!("cannot write {}", sound.display())).because(why))?;
    let run = Run {
        seconds: SECONDS,
        count_from: Some(COUNT_FROM_S),
        microphone: Some(&sound),
        bridge_every: BRIDGE_EVERY,
    };
    let seen = Model::find_or_make(workspace)?.run(elf, &folder, &run)?;
    let number = |name: &str| {
        seen.get(name)
            .and_then(serde_json::Value::as_u64)
            .ok_or_else(|| Failure::new(format!("the model did not say `{name}`")))
    };
    let trace = Trace::read(&folder.join(TRACE), &program)?;
    let mut unwanted = Vec::new();
    for duty in DUTIES {
        let roots: Vec<_> = image.named(duty).collect();
        if roots.is_empty() {
            return Err(
                Failure::new(format!("{} has no function `{duty}`", elf.display()))
                    .advise("the duty must be a function of its own, not inlined"),
            );
        }
        let found = Unwanted::reachable(&image, roots);
        for line in found.summary() {
            eprintln!("chip: in {duty}: {line}");
        }
        unwanted.push((duty.to_owned(), found));
    }
    Figures::new(
        toolchain.compiler_version()?,
        &image,
        [
            [number("start_stack_bytes")?, at_start],
            [number("stack_bytes")?, afterwards],
        ],
        trace.instructions() as f64 / number("counted_samples")?.max(1) as f64,
        &unwanted,
    )
}

/// A function in the coupled memory that the start can call, before it is there.
fn too_early(image: &ArmImage) -> Option<&str> {
    let mut known = BTreeSet::new();
    let mut roots: Vec<&Function> = START.iter().flat_map(|part| image.named(part)).collect();
    while let Some(function) = roots.pop() {
        if COUPLED.contains(&(function.code.start as u32)) {
            return Some(&function.name);
        }
        if known.insert(function.code.start) {
            roots.extend(
                image
                    .calls(function)
                    .into_iter()
                    .flat_map(|to| image.at(to)),
            );
        }
    }
    None
}

/// The command `chip [--image ELF] [--markdown FILE | --check FILE]`.
///
/// # Errors
/// When the image cannot be built or measured, or a figure differs from the table.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    if let [command, rest @ ..] = arguments
        && command == "benchmarks"
    {
        return benchmark::main(workspace, rest);
    }
    let toolchain = Toolchain::find_or_make(workspace, ARM)?;
    let (elf, arguments) = match arguments {
        [option, elf, rest @ ..] if option == "--image" => (PathBuf::from(elf), rest),
        _ => (build(workspace, &toolchain)?, arguments),
    };
    let figures = measure(workspace, &toolchain, &elf)?;
    println!("{}", figures.markdown());
    match arguments {
        [] => {}
        [option, file] if option == "--markdown" => {
            let text = page::read(Path::new(file))?;
            let text = figures.written_into(&text).map_err(Failure::new)?;
            page::write(Path::new(file), &text)?;
        }
        [option, file] if option == "--check" => check(&figures, Path::new(file))?,
        _ => {
            return Err(Failure::usage(
                "`chip` takes --image ELF, then --markdown FILE or --check FILE",
            ));
        }
    }
    Ok(0)
}

/// Fails unless the figures are those of the table in a file.
///
/// # Errors
/// Names every figure that differs.
pub fn check(figures: &Figures, path: &Path) -> Result<()> {
    let differences = figures
        .differences_from(&page::read(path)?)
        .map_err(|why| {
            Failure::new(format!("cannot read the table in {}", path.display())).because(why)
        })?;
    if differences.is_empty() {
        return Ok(());
    }
    Err(
        Failure::new(format!("figures differ from {}", path.display()))
            .because(format!("\n  {}", differences.join("\n  ")))
            .advise(format!(
                "if the change is meant: cargo xtask chip --markdown {}",
                path.display()
            )),
    )
}
