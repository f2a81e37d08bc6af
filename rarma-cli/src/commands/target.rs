//! `rarma target`: the same recording through the firmware image on the emulated
//! Cortex-M4F.
//!
//! The recording is handed over as one channel of 32-bit float, the very numbers
//! that `rarma monitor` takes; the image reads it by semihosting, and its wire
//! frames are decoded here.

use super::show::Audience;
use super::source::About;
use super::{monitor, process, show, source};
use crate::advice::Reach;
use crate::args::MonitorArgs;
use crate::collect::{Collector, News, WholeRun};
use crate::failure::Failure;
use crate::output::{self, WavFile};
use crate::record::Run;
use rarma_box::wire::{Deframer, MonitorJob, Telemetry};
use rarma_recordings::input::Recording;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::{env, fs};
use xtask::board::Machine;
use xtask::{EMULATED_BOARD, Workspace, fw, qemu};

/// Names a ready image, so that none is built.
pub const ELF_VARIABLE: &str = "RARMA_TARGET_ELF";

pub(super) fn main(args: &MonitorArgs) -> Result<u8, Failure> {
    if !args.more.is_empty() {
        return Err(Failure::Usage(
            "several recordings: the chip takes one at a time; use `rarma monitor` for more"
                .to_owned(),
        ));
    }
    if args.second.is_some() {
        return Err(Failure::Usage(
            "--second: a job for the box names one channel; use `rarma monitor` for two".to_owned(),
        ));
    }
    if args.tacho.is_some() {
        return Err(Failure::Usage(
            "--tacho: a job for the box names one channel; use `rarma monitor` with a tacho"
                .to_owned(),
        ));
    }
    if args.speed_from.is_some() {
        return Err(Failure::Usage(
            "--speed-from: a job for the box tells one speed; use `rarma monitor` with several"
                .to_owned(),
        ));
    }
    let structure = process::structure(args.structure.as_deref())?;
    let recording = source::read(&args.input)?;
    let about = About::from(&recording);
    let job = monitor::job(args, &about)?;
    let elf = image()?;
    let bar = show::progress(0, "the emulated chip is listening");
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    let mut audience = Audience::new(args, &about, &job, structure, Reach::default(), bar);
    audience.hear(&recording.samples);
    let run = on_chip(&elf, &job, &recording, |news| audience.take(news.clone()))?;
    Ok(audience.finish(run.summary)?.code)
}

/// Runs one job on the emulated chip. `news` is called with what was said, in the order in which the image said it,
/// once all of it has come.
///
/// # Errors
/// The emulator is missing, or the image failed or was cut short.
pub fn on_chip(
    elf: &Path,
    job: &MonitorJob,
    recording: &Recording,
    news: impl FnMut(&News),
) -> Result<Run, Failure> {
    qemu::ensure_installed().map_err(|why| Failure::System(why.to_string()))?;
    let folder = tempfile::tempdir()
        .map_err(|why| output::failed(env::temp_dir(), "make a folder in it", &why))?;
    let at = |name: &str| folder.path().join(name);
    let mut bytes = [0u8; 256];
    let bytes = postcard::to_slice(job, &mut bytes)
        .map_err(|why| Failure::System(format!("the job cannot be written: {why}")))?;
    output::write(&at("job.bin"), bytes)?;
    write_wav(&at("in.wav"), recording)?;

    let elf = fs::canonicalize(elf)
        .map_err(|why| Failure::System(format!("{}: no image there: {why}", elf.display())))?;
    let mut child = qemu::qemu_command(Machine::An386, &elf, &[])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::inherit())
        .spawn()
        .map_err(|why| Failure::System(format!("cannot start {}: {why}", qemu::PROGRAM)))?;
    let status = qemu::wait(&mut child, &elf).map_err(|why| Failure::System(why.to_string()))?;

    let mut collector = Collector::default();
    let mut said = Vec::new();
    let mut deframer = Deframer::default();
    let mut expected = 0;
    for byte in fs::read(at("out.bin")).unwrap_or_default() {
        match deframer.push::<Telemetry>(byte) {
            None => {}
            Some(Err(why)) => {
                return Err(Failure::System(format!(
                    "a frame of the image is broken: {why:?}"
                )));
            }
            Some(Ok((head, message))) => {
                if head.sequence != expected {
                    return Err(Failure::System(format!(
                        "frames of the image are missing: {expected} expected, {} found",
                        head.sequence
                    )));
                }
                expected += 1;
                said.push(collector.take(&message));
            }
        }
    }
    if let Some(refusal) = collector.refused() {
        return Err(Failure::System(format!(
            "the image refused the job: {refusal:?}"
        )));
    }
    if !status.success() {
        return Err(Failure::System(format!(
            "the image failed ({status}) before its last frame"
        )));
    }
    let summary = collector
        .summary()
        .ok_or_else(|| Failure::System("the image ended without its last frame".to_owned()))?;
    said.iter().for_each(news);
    let mut all = WholeRun::default();
    said.into_iter().for_each(|news| all.keep(news));
    Ok(all.with(summary))
}

/// The image to run: the one that is named, or a fresh one.
///
/// # Errors
/// It cannot be built.
pub fn image() -> Result<PathBuf, Failure> {
    if let Some(path) = env::var_os(ELF_VARIABLE) {
        return Ok(PathBuf::from(path));
    }
    let failed = |why: xtask::Failure| Failure::System(why.to_string());
    let workspace = Workspace::locate().map_err(failed)?;
    fw::build_image(&workspace, EMULATED_BOARD).map_err(failed)
}

fn write_wav(path: &Path, recording: &Recording) -> Result<(), Failure> {
    let spec = hound::WavSpec {
        channels: 1,
        // The image takes the rate from its job; a header holds whole numbers only.
        sample_rate: recording.fs.round().max(1.0) as u32,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let mut wav = WavFile::create(path, spec)?;
    for &x in &recording.samples {
        wav.sample(x as f32)?;
    }
    Ok(wav.finish(None)?.keep()?)
}
