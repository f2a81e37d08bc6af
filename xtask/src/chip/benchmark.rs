//! `cargo xtask chip benchmarks`: the model of the chip's time against what its maker publishes.
//!
//! CoreMark and Dhrystone, fetched by their commits, which git checks, compiled with the arm-none-eabi-gcc
//! at hand, and run as the board's image is: on the model of the chip, what is executed through the
//! model of its time; from the flash, and from the memory coupled to the core.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::TRACE;
use super::model::{Model, Run};
use super::program::Program;
use super::timing::{Form, Setup, run as through};
use super::trace::Trace;
use crate::page::{self, Part};
use crate::{Failure, Result, Workspace, process};

/// Where the table is in a file that holds it.
const PART: Part = Part("benchmarks");
/// The clock of the published figures, MHz.
const MHZ: f64 = 170.0;
/// Dhrystones a second of a machine of one DMIPS.
const DHRYSTONES: f64 = 1757.0;

/// A benchmark.
struct Benchmark {
    name: &'static str,
    /// Where it comes from, the commit, and the variable that names another place.
    from: (&'static str, &'static str, &'static str),
    /// Its files, and ours.
    sources: &'static [&'static str],
    port: &'static str,
    flags: &'static [&'static str],
    /// How often it does its work, and the functions between which it is counted.
    runs: u32,
    marks: [&'static str; 2],
    /// The unit, and how many of it a run of its work in a second is.
    unit: (&'static str, f64),
    /// Published, from the flash and from the coupled memory.
    published: [Option<f64>; 2],
}

const ALL: [Benchmark; 2] = [
    Benchmark {
        name: "CoreMark 1.01",
        from: (
            "https://github.com/eembc/coremark",
            "cfa9ab377835911f23d9b0831c7be302ed1f58de",
            "RARMA_COREMARK",
        ),
        sources: &[
            "core_list_join.c",
            "core_main.c",
            "core_matrix.c",
            "core_state.c",
            "core_util.c",
        ],
        port: "core_portme.c",
        flags: &["-O3", "-funroll-loops", "-ffreestanding"],
        runs: 3,
        marks: ["start_time", "stop_time"],
        unit: ("CoreMark", 1.0),
        published: [Some(550.0), None],
    },
    Benchmark {
        name: "Dhrystone 2.1",
        from: (
            "https://github.com/Keith-S-Thompson/dhrystone",
            "66bb9df1a5dea67f33437b856bf68ae52bd5c90f",
            "RARMA_DHRYSTONE",
        ),
        sources: &["v2.1/dhry_1.c", "v2.1/dhry_2.c"],
        port: "dhrystone_port.c",
        // By its rules: two files, no function is taken into another.
        flags: &["-O3", "-fno-inline", "-fno-builtin-printf", "-DTIME"],
        runs: 100,
        marks: ["time", "time"],
        unit: ("DMIPS", DHRYSTONES),
        published: [Some(213.0), Some(213.0)],
    },
];

/// Flags of both.
const FLAGS: [&str; 6] = [
    "-mcpu=cortex-m4",
    "-mthumb",
    "-mfloat-abi=soft",
    "-w",
    "-nostartfiles",
    "--specs=nosys.specs",
];

/// The first lines of the table.
const HEAD: &str = "| at 170 MHz | most cycles | least | published |\n|---|---:|---:|---:|\n";

/// The compiler.
const GCC: &str = "arm-none-eabi-gcc";

/// The command `chip benchmarks [--markdown FILE | --check FILE]`.
///
/// # Errors
/// When a source or the compiler cannot be had, a benchmark's results are wrong, or a figure differs
/// from the table.
pub fn main(workspace: &Workspace, arguments: &[String]) -> Result<u8> {
    if process::find_program(GCC).is_none() {
        return Err(Failure::new(format!("no {GCC} to compile the benchmarks"))
            .advise("apt install gcc-arm-none-eabi libnewlib-arm-none-eabi"));
    }
    let model = Model::find_or_make(workspace)?;
    let mut rows = Vec::new();
    for benchmark in &ALL {
        let source = source(workspace, benchmark)?;
        for (place, memory) in ["flash", "coupled"].into_iter().enumerate() {
            let elf = compile(workspace, benchmark, &source, memory)?;
            rows.push(measure(benchmark, place, memory, &elf, &model)?);
        }
    }
    let text = table(&rows)?;
    println!("{text}");
    match arguments {
        [] => {}
        [option, file] if option == "--markdown" => {
            let path = Path::new(file);
            let page = PART.written_into(&page::read(path)?, &text);
            page::write(path, &page.map_err(Failure::new)?)?;
        }
        [option, file] if option == "--check" => check(&text, Path::new(file))?,
        _ => {
            return Err(Failure::usage(
                "`chip benchmarks` takes --markdown FILE or --check FILE",
            ));
        }
    }
    Ok(0)
}

/// One benchmark from one memory: at the most cycles, at the least, published.
struct Row {
    name: String,
    figures: [f64; 2],
    published: Option<f64>,
}

impl Row {
    fn markdown(&self) -> String {
        let published = self
            .published
            .map_or("-".to_owned(), |figure| figure.to_string());
        let [most, least] = self.figures;
        format!("| {} | {most:.0} | {least:.0} | {published} |\n", self.name)
    }
}

/// The source at its commit, which git checks.
fn source(workspace: &Workspace, benchmark: &Benchmark) -> Result<PathBuf> {
    let (from, commit, variable) = benchmark.from;
    let folder = workspace.target_dir().join("benchmarks").join(commit);
    let git = |arguments: &[&str]| {
        let mut command = Command::new("git");
        command.arg("-C").arg(&folder).args(arguments);
        command
    };
    if process::output(&mut git(&["diff", "--quiet", commit])).is_ok() {
        return Ok(folder);
    }
    let from = std::env::var(variable).unwrap_or_else(|_| from.to_owned());
    std::fs::create_dir_all(&folder)
        .map_err(|why| Failure::new(format!("cannot make {}", folder.display())).because(why))?;
    for arguments in [
        &["init", "--quiet"][..],
        &["fetch", "--quiet", &from, "HEAD", "--tags"],
        &["checkout", "--quiet", "--force", commit],
    ] {
        process::run(&mut git(arguments)).map_err(|why| {
            Failure::new(format!("cannot fetch {} from {from}", benchmark.name))
                .because(why)
                .advise(format!(
                    "clone it elsewhere and set {variable} to that folder"
                ))
        })?;
    }
    Ok(folder)
}

fn compile(
    workspace: &Workspace,
    benchmark: &Benchmark,
    source: &Path,
    memory: &str,
) -> Result<PathBuf> {
    let ours = workspace.root().join("tools/benchmarks");
    let elf = source.join(format!("{memory}.elf"));
    let mut gcc = Command::new(GCC);
    gcc.args(FLAGS)
        .args(benchmark.flags)
        .arg(format!("-DRUNS={}", benchmark.runs))
        .args([Path::new("-I"), source, Path::new("-I"), &ours])
        .args([Path::new("-L"), &ours])
        .arg(format!("-T{memory}.ld"))
        .arg("-o")
        .arg(&elf)
        .args(["start.c", benchmark.port].map(|file| ours.join(file)))
        .args(benchmark.sources.iter().map(|file| source.join(file)));
    process::run(&mut gcc)?;
    Ok(elf)
}

fn measure(
    benchmark: &Benchmark,
    place: usize,
    memory: &str,
    elf: &Path,
    model: &Model,
) -> Result<Row> {
    let folder = elf.with_extension("run");
    let run = Run {
        seconds: 1.0,
        count_from: Some(0.0),
        bridge_every: 1,
        microphone: None,
    };
    model.run(elf, &folder, &run)?;
    let program = Program::read_file(elf)?;
    let trace = Trace::read(&folder.join(TRACE), &program)?;
    let image = crate::arm_image::ArmImage::read(elf)?;
    let marks = benchmark.marks.map(|name| image.function(name));
    let [Some(first), Some(last)] = marks else {
        return Err(Failure::new(format!(
            "{} has no functions {:?}",
            elf.display(),
            benchmark.marks
        )));
    };
    let counted = trace
        .between(first.code.start as u32, last.code.start as u32)
        .ok_or_else(|| Failure::new(format!("{} was not executed", benchmark.name)))?;
    let figures = [Form::Most, Form::Least].map(|form| {
        let setup = Setup {
            prefetch: true,
            form,
        };
        let cycles = through(&program, &counted, setup).cycles as f64;
        MHZ * 1e6 * f64::from(benchmark.runs) / cycles / benchmark.unit.1
    });
    Ok(Row {
        name: format!("{}, {}, from {memory}", benchmark.name, benchmark.unit.0),
        figures,
        published: benchmark.published[place],
    })
}

fn table(rows: &[Row]) -> Result<String> {
    let mut text = HEAD.to_owned();
    text.extend(rows.iter().map(Row::markdown));
    let version = process::output(Command::new(GCC).arg("-dumpfullversion"))?;
    let flags = |benchmark: &Benchmark| benchmark.flags.join(" ");
    Ok(format!(
        "{text}\nMade with {GCC} {}: {} and {}.\n",
        version.trim(),
        ALL.each_ref()
            .map(|b| format!("`{}` for {}", flags(b), b.name))
            .join(", "),
        "`-mcpu=cortex-m4 -mthumb` for both"
    ))
}

/// Fails where a figure is not the page's; where the compiler is another, that is said instead.
fn check(text: &str, path: &Path) -> Result<()> {
    let page = page::read(path)?;
    let (_, committed, _) = PART.split(&page).map_err(Failure::new)?;
    let made = |text: &str| {
        text.lines()
            .find(|l| l.starts_with("Made with"))
            .map(str::to_owned)
    };
    if made(text) != made(committed) {
        eprintln!(
            "chip: the benchmarks in {} are another compiler's",
            path.display()
        );
        return Ok(());
    }
    if same(text, committed) {
        return Ok(());
    }
    Err(
        Failure::new(format!("benchmarks differ from {}", path.display()))
            .because(format!("\n{committed}"))
            .advise(format!(
                "if it is meant: cargo xtask chip benchmarks --markdown {}",
                path.display()
            )),
    )
}

/// Whether two tables have the same figures, but for a little.
fn same(is: &str, was: &str) -> bool {
    is.lines().count() == was.lines().count()
        && is
            .lines()
            .zip(was.lines())
            .all(|(is, was)| page::is_near(is, was))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_percent_either_way_are_the_same_and_a_row_that_comes_or_goes_is_not() {
        let table = |most: f64, rows: usize| {
            let row = Row {
                name: "CoreMark, from flash".to_owned(),
                figures: [most, 480.0],
                published: None,
            };
            format!("{HEAD}{}", row.markdown().repeat(rows))
        };
        assert!(same(&table(385.0, 2), &table(390.0, 2)));
        assert!(!same(&table(385.0, 2), &table(395.0, 2)));
        assert!(!same(&table(385.0, 2), &table(385.0, 1)));
    }
}
