//! The checks, in order. The image is built before the host tests, which run it.

use super::bench::Bench;
use super::cargo_deny::CargoDeny;
use super::summary::Outcome;
use super::{
    browser, commands, dependencies, fuzz, on_embassy, packed, plant, plant_gateway, python,
};
use crate::arm_image::ArmImage;
use crate::chip::figures::Figures;
use crate::chip::model::Model;
use crate::fuzz::{long_form, targets};
use crate::long::{self, Forms, LongForm};
use crate::needs::controller;
use crate::toolchain::{ARM_V8, Toolchain};
use crate::{
    EMULATED_BOARD, EMULATED_M33, Failure, Result, TARGET, book, chip, count, fw, page, pico,
    process, screens, sound, tmux,
};

/// A check: reads and adds to the bench.
pub type Check = fn(&mut Bench<'_>) -> Result<Outcome>;

/// Every check with its name.
pub const ALL: &[(&str, Check)] = &[
    ("format", format),
    ("clippy", clippy),
    ("docs", docs),
    ("licences and sources", licences),
    ("target toolchain", toolchain),
    ("rooms without std", rooms_without_std),
    ("packed crates", packed::check),
    ("firmware image", firmware_image),
    ("board image", board_image),
    ("Pico image", pico_image),
    ("example on embassy", on_embassy::check),
    ("host tests", host_tests),
    ("sound card", sound_card),
    ("plant records", plant::records),
    ("plant gateway", plant_gateway::check),
    ("loop with LinuxCNC", linuxcnc_loop),
    ("doc tests", doc_tests),
    ("book", the_book),
    ("commands of the docs", commands::check),
    ("python", python),
    ("browser page", browser::check),
    ("fuzzing", fuzzing),
    ("long forms", long_forms),
    ("on-target tests", on_target_tests),
    ("board figures", board_figures),
    ("counting plugin", counting_plugin),
    ("instruction counts", instruction_counts),
];

/// All tests but those that want databases and a broker, which `plant records` and `plant gateway` run.
const ELSEWHERE: &str = "not (kind(test) & (package(rarma-fleet) | (package(rarma-cli) & (binary(=fleet) | binary(=gateway)))))";
/// The page with the table of counts.
const COUNT_TABLE: &str = "README.md";

/// Ends a check that needs the target where there is none.
macro_rules! toolchain_or_skip {
    ($bench:expr) => {
        &match $bench.toolchain() {
            Ok(toolchain) => toolchain,
            Err(why) => return Ok(Outcome::Skipped(why)),
        }
    };
}

fn format(bench: &mut Bench<'_>) -> Result<Outcome> {
    for manifest in dependencies::MANIFESTS {
        bench.pass_if(&mut bench.cargo(&[
            "fmt",
            "--all",
            "--check",
            "--manifest-path",
            manifest,
        ]))?;
    }
    Ok(Outcome::passed())
}

/// In release form like all that follows: what runs while something is built (macros, sources in C) is built once.
fn clippy(bench: &mut Bench<'_>) -> Result<Outcome> {
    let mut clippy = bench.cargo(&["clippy", "--release", "--all-targets"]);
    clippy
        .args(process::HOST)
        .args(["--", "--deny", "warnings"]);
    bench.pass_if(&mut clippy)
}

fn docs(bench: &mut Bench<'_>) -> Result<Outcome> {
    let mut cargo = bench.cargo(&["doc", "--release", "--no-deps", "--quiet"]);
    cargo.args(process::HOST);
    bench.pass_if(cargo.env("RUSTDOCFLAGS", "-D warnings"))
}

fn licences(bench: &mut Bench<'_>) -> Result<Outcome> {
    let count = dependencies::check(bench.workspace)?;
    println!("{count} packages have allowed licences and come from the registry");
    match CargoDeny::find_or_make(bench.workspace) {
        Ok(deny) => bench.pass_if(&mut deny.check(bench.workspace)),
        Err(failure) => Ok(Outcome::Partly(format!("own check only: {failure}"))),
    }
}

/// Without a toolchain, or without an emulator, every check on the target is skipped. The first check that needs more than
/// the host's compiler, as do those after it.
fn toolchain(bench: &mut Bench<'_>) -> Result<Outcome> {
    bench.wait_for_what_is_fetched();
    let outcome = match bench.look_for_toolchain() {
        Ok(toolchain) => Outcome::Passed(toolchain.description().to_owned()),
        Err(failure) => Outcome::Skipped(failure.to_string()),
    };
    Ok(outcome)
}

fn rooms_without_std(bench: &mut Bench<'_>) -> Result<Outcome> {
    let mut cargo = toolchain_or_skip!(bench).cargo(bench.workspace);
    cargo
        .args(["build", "--target", TARGET, "--profile", "fw"])
        .env("CARGO_TARGET_DIR", bench.workspace.firmware_target_dir());
    for name in packed::CRATES {
        cargo.args(["--package", name]);
    }
    // What images of this workspace do not ask for, but others may.
    bench.pass_if(cargo.args(["--features", "rarma-box/defmt"]))
}

fn firmware_image(bench: &mut Bench<'_>) -> Result<Outcome> {
    let toolchain = toolchain_or_skip!(bench);
    let request = fw::Request::build(EMULATED_BOARD)?;
    let mut build = fw::command(bench.workspace, toolchain, &request);
    bench.pass_if(&mut build)?;
    let mut whole_box = fw::command(bench.workspace, toolchain, &fw::Request::build_box()?);
    let outcome = bench.pass_if(&mut whole_box)?;
    bench.image = Some(fw::elf_path(bench.workspace, request.board, EMULATED_BOARD));
    Ok(outcome)
}

/// The image for the Raspberry Pi Pico 2, and whether its ROM would start it.
fn pico_image(bench: &mut Bench<'_>) -> Result<Outcome> {
    let toolchain = match Toolchain::find_or_make(bench.workspace, ARM_V8) {
        Ok(toolchain) => toolchain,
        Err(failure) => return Ok(Outcome::Skipped(failure.to_string())),
    };
    let request = fw::Request::build(pico::BOARD)?;
    bench.pass_if(&mut fw::command(bench.workspace, &toolchain, &request))?;
    let elf = fw::elf_path(bench.workspace, request.board, pico::BOARD);
    pico::finish(&elf)?;
    let image = ArmImage::read(&elf)?;
    Ok(Outcome::Passed(format!(
        "{} bytes of flash, {} of static memory",
        image.flash_bytes(),
        image.static_bytes()
    )))
}

/// The image for the real board; without a model of its chip it is built all the same.
fn board_image(bench: &mut Bench<'_>) -> Result<Outcome> {
    let toolchain = toolchain_or_skip!(bench);
    let image = chip::build(bench.workspace, toolchain)?;
    match Model::find_or_make(bench.workspace) {
        Ok(model) => {
            bench.board = Some((image, model));
            Ok(Outcome::passed())
        }
        Err(failure) => Ok(Outcome::Skipped(format!("built, but {failure}"))),
    }
}

/// Figures belong to a compiler, like the counts.
fn board_figures(bench: &mut Bench<'_>) -> Result<Outcome> {
    let toolchain = toolchain_or_skip!(bench);
    let Some((image, _)) = &bench.board else {
        return Ok(Outcome::Skipped(
            "no image, or no model of the chip".to_owned(),
        ));
    };
    let figures = chip::measure(bench.workspace, toolchain, image)?;
    println!("{}", figures.markdown());
    let path = bench.workspace.root().join(chip::PAGE);
    let committed = Figures::compiler_in(&page::read(&path)?).map_err(|why| {
        Failure::new(format!("no figures to compare with in {}", chip::PAGE)).because(why)
    })?;
    if committed != figures.compiler() {
        return Ok(Outcome::Skipped(format!(
            "{} has the figures of {committed}, this is {}: `cargo xtask chip --markdown {}`",
            chip::PAGE,
            figures.compiler(),
            chip::PAGE
        )));
    }
    chip::check(&figures, &path).map(|()| Outcome::passed())
}

fn host_tests(bench: &mut Bench<'_>) -> Result<Outcome> {
    let encoder = sound::ensure_encoder();
    let terminal = tmux::ensure();
    let mut tests = if process::find_program("cargo-nextest").is_some() {
        bench.cargo(&[
            "nextest",
            "run",
            "--cargo-profile",
            "release",
            "--no-fail-fast",
            "--filterset",
            ELSEWHERE,
        ])
    } else {
        bench.cargo(&[
            "test",
            "--lib",
            "--bins",
            "--tests",
            "--release",
            "--no-fail-fast",
        ])
    };
    tests.args(process::HOST);
    bench.require(&mut tests);
    for (there, required) in [
        (&encoder, "RARMA_REQUIRE_FFMPEG"),
        (&terminal, "RARMA_REQUIRE_TMUX"),
    ] {
        match there {
            Ok(()) => drop(tests.env(required, "1")),
            Err(failure) => eprintln!("{failure}"),
        }
    }
    let outcome = bench.pass_if(&mut tests)?;
    let without: Vec<&str> = [
        (bench.image.is_none(), "the emulated chip"),
        (bench.board.is_none(), "the model of the board's chip"),
        (encoder.is_err(), "an encoder of sound"),
        (terminal.is_err(), "a terminal to look at"),
    ]
    .into_iter()
    .filter_map(|(lacks, what)| lacks.then_some(what))
    .collect();
    if without.is_empty() {
        return Ok(outcome);
    }
    Ok(Outcome::Partly(format!(
        "without {}",
        without.join(" and ")
    )))
}

/// `rarma` with the feature that needs a library of the system, on cards that are files, and what is
/// seen of it on a screen.
fn sound_card(bench: &mut Bench<'_>) -> Result<Outcome> {
    if let Err(failure) = sound::ensure_card_library() {
        return Ok(Outcome::Skipped(failure.to_string()));
    }
    // Without the plant's commands, which the other checks have; of the workspace, for what that shares is built already.
    let with = ["--workspace", "--features", "rarma-cli/sound-card"];
    let mut tests = bench.cargo(&["test", "--release", "--test", "sound_card"]);
    tests.args(with);
    bench.pass_if(tests.env("RARMA_REQUIRE_SOUND_CARD", "1"))?;
    let program = bench.workspace.target_dir().join("release/rarma");
    screens::usual(bench.workspace, program)?;
    let mut clippy = bench.cargo(&["clippy", "--release"]);
    clippy.args(with).args(["--", "--deny", "warnings"]);
    bench.pass_if(&mut clippy)
}

/// Every day: each long form has a short one, and passed when it ran last or is named as one
/// that has not been run yet. With `--long` all of them run.
fn long_forms(bench: &mut Bench<'_>) -> Result<Outcome> {
    let forms = Forms::find(bench.workspace, &[])?;
    if bench.long() {
        let markdown = bench.request.markdown.as_deref();
        let failed = long::run_all(bench.workspace, &forms, markdown, &|tests| {
            bench.require(tests);
        })?;
        return Ok(if failed.is_empty() {
            Outcome::passed()
        } else {
            Outcome::Failed(format!("{} failed", failed.join(", ")))
        });
    }
    let targets = targets(bench.workspace)?;
    let of_fuzzing = targets.iter().map(|target| long_form(target));
    let all: Vec<String> = forms
        .long
        .iter()
        .map(LongForm::name)
        .chain(of_fuzzing)
        .collect();
    let waiting = long::check(bench.workspace, &all)?;
    let mut told = format!(
        "{} of {} passed when they ran last, all have short ones; `--long` runs them",
        all.len() - waiting.len(),
        all.len()
    );
    if !waiting.is_empty() {
        told = format!("{told}; NOT RUN YET: {}", waiting.join(", "));
    }
    Ok(Outcome::Passed(told))
}

/// LinuxCNC is installed where that can be done; else it is said that it is missing.
fn linuxcnc_loop(bench: &mut Bench<'_>) -> Result<Outcome> {
    if let Err(why) = controller::linuxcnc() {
        return Ok(Outcome::Skipped(why.to_string()));
    }
    let mut tests = bench.cargo(&[
        "test",
        "--release",
        "--test",
        "act_linuxcnc",
        "--test",
        "act_linuxcnc_faults",
    ]);
    tests.args(process::HOST).env("RARMA_REQUIRE_LINUXCNC", "1");
    bench.pass_if(&mut tests)
}

/// In release like the host tests, whose dependencies are built by now.
/// Programs that show how a crate is used, and what each must say at its end.
const EXAMPLES: [(&str, &str, &str); 3] = [
    ("rarma-core", "damping", "     2.0           0.18      899."),
    ("rarma-core", "monitor", "chatter at 898."),
    (
        "rarma-fit",
        "batch_and_recursive",
        "no estimator scatters by less",
    ),
];

fn doc_tests(bench: &mut Bench<'_>) -> Result<Outcome> {
    bench.pass_if(
        bench
            .cargo(&["test", "--doc", "--release"])
            .args(process::HOST),
    )?;
    for (package, name, end) in EXAMPLES {
        let mut example = bench.cargo(&["run", "--quiet", "--release", "--package", package]);
        example.args(["--example", name]);
        println!("{}", process::spelled(&example));
        let said = process::output(&mut example)?;
        if !said.lines().last().is_some_and(|line| line.contains(end)) {
            return Err(
                Failure::new(format!("the example `{name}` does not end as it should")).because(
                    format!("its last line is to hold `{end}`; it said:\n{said}"),
                ),
            );
        }
    }
    Ok(Outcome::passed())
}

fn python(bench: &mut Bench<'_>) -> Result<Outcome> {
    python::check(bench.workspace)
}

fn fuzzing(bench: &mut Bench<'_>) -> Result<Outcome> {
    let markdown = bench.request.markdown.as_deref();
    fuzz::check(bench.workspace, bench.long(), markdown)
}

fn on_target_tests(bench: &mut Bench<'_>) -> Result<Outcome> {
    let toolchain = toolchain_or_skip!(bench);
    let mut tests = fw::command(
        bench.workspace,
        toolchain,
        &fw::Request::test(EMULATED_BOARD)?,
    );
    bench.pass_if(&mut tests)?;
    let toolchain = match Toolchain::find_or_make(bench.workspace, ARM_V8) {
        Ok(toolchain) => toolchain,
        Err(failure) => return Ok(Outcome::Partly(format!("not on the Cortex-M33: {failure}"))),
    };
    let mut tests = fw::command(
        bench.workspace,
        &toolchain,
        &fw::Request::test(EMULATED_M33)?,
    );
    bench.pass_if(&mut tests)
}

fn counting_plugin(bench: &mut Bench<'_>) -> Result<Outcome> {
    for check in [&["clippy", "--quiet"][..], &["test"]] {
        tool(bench, "tools/m4-cycles/Cargo.toml", check)?;
    }
    Ok(Outcome::passed())
}

/// Lints or tests a helper that is a workspace of its own.
fn tool(bench: &Bench<'_>, manifest: &str, check: &[&str]) -> Result<Outcome> {
    let mut cargo = bench.cargo(check);
    cargo
        .args(["--manifest-path", manifest])
        .env("CARGO_TARGET_DIR", bench.workspace.tools_target_dir());
    if check[0] == "clippy" {
        cargo.args(["--", "--deny", "warnings"]);
    }
    bench.pass_if(&mut cargo)
}

/// The pages of docs as a book with every picture of every command: all are drawn, and every link of
/// the pages and of the book goes somewhere.
fn the_book(bench: &mut Bench<'_>) -> Result<Outcome> {
    let checks: [&[&str]; 2] = [
        &["clippy", "--quiet", "--all-targets", "--release"],
        &["test", "--quiet", "--release"],
    ];
    for check in checks {
        tool(bench, book::MANIFEST, check)?;
    }
    let book = book::make(bench.workspace, true)?;
    Ok(Outcome::Passed(book.description))
}

/// Counts belong to a compiler: another one's are shown, not compared.
fn instruction_counts(bench: &mut Bench<'_>) -> Result<Outcome> {
    let toolchain = toolchain_or_skip!(bench);
    let table = count::measure_all(bench.workspace, toolchain)?;
    println!("{}", table.markdown());
    let path = bench.workspace.root().join(COUNT_TABLE);
    let committed = count::table::Table::found_in(&page::read(&path)?).map_err(|why| {
        Failure::new(format!("no counts to compare with in {COUNT_TABLE}")).because(why)
    })?;
    if committed.compiler != table.compiler {
        return Ok(Outcome::Skipped(format!(
            "{COUNT_TABLE} has the counts of {}, this is {}: `cargo xtask count --markdown {COUNT_TABLE}`",
            committed.compiler, table.compiler
        )));
    }
    count::check(&table, &path).map(|()| Outcome::passed())
}
