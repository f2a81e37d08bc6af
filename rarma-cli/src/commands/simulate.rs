//! `rarma simulate`: a scenario to a recording and what is true of it.

use super::show;
use crate::args::SimulateArgs;
use crate::failure::Failure;
use crate::output::{self, NewFile, WavFile, Whole};
use rarma_plants::cut::VirtualCut;
use rarma_recordings::export::{Along, Column, Format, Table};
use rarma_scenarios::scenario::{self, Loaded};
use rarma_scenarios::truth::TruthRecord;
use std::path::Path;
use std::time::Instant;

/// Samples between two updates of the progress bar.
const BAR_STEP: usize = 24_000;

pub(super) fn main(args: &SimulateArgs) -> Result<u8, Failure> {
    if args.list {
        for (name, _) in scenario::SHIPPED {
            let loaded = scenario::load(name, None)?;
            say!("{name:22} {}", loaded.about);
        }
        return Ok(0);
    }
    if args.schema {
        say!("{:#}", scenario::schema());
        return Ok(0);
    }
    let Some(name) = &args.scenario else {
        return Err(Failure::Usage(
            "SCENARIO is missing: a TOML file or a shipped name (--list shows them)".to_owned(),
        ));
    };
    let loaded = scenario::load(name, args.seed)?;
    let truth = TruthRecord::of(&loaded)?;
    let json = serde_json::to_string_pretty(&truth).map_err(std::io::Error::from)?;
    let mut files = Vec::new();
    if let Some(path) = &args.truth {
        files.push(NewFile::whole(path, json.as_bytes())?);
    }
    if let Some(out) = &args.out {
        let start = Instant::now();
        let (file, clipped) = write(&loaded, out)?;
        files.push(file);
        let took = start.elapsed().as_secs_f64();
        if !args.json {
            say!(
                "{}: {:.2} s at {} Hz in {took:.2} s ({:.0} simulated seconds per second)",
                out.display(),
                loaded.scenario.duration_s,
                loaded.scenario.microphone.sample_rate_hz,
                loaded.scenario.duration_s / took
            );
        }
        if clipped > 0 {
            eprintln!("{name}: {clipped} samples clipped (raise microphone.full_scale_pa)");
        }
    }
    output::keep(files)?;
    if args.json {
        say!("{json}");
    } else {
        describe(&loaded, &truth);
    }
    Ok(0)
}

/// Plays the cut into a WAV file, or one of the formats of other programs, which is still to be kept; the number of clipped samples.
///
/// # Errors
/// The file cannot be written.
fn write(loaded: &Loaded, out: &Path) -> Result<(Whole, u64), Failure> {
    if Format::of(out).is_some() {
        let heard = simulate(loaded)?;
        let table = Table {
            title: format!("virtual cut {}", loaded.scenario.name),
            along: Along::Time { fs: heard.fs },
            columns: vec![Column {
                name: "microphone".to_owned(),
                channel: 0,
                unit: "1".to_owned(),
                values: heard.samples,
            }],
        };
        return Ok((output::export(out, "--out", &table)?, heard.clipped));
    }
    let mut sound = Sound::new(loaded)?;
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: sound.cut.sample_rate_hz().round() as u32,
        bits_per_sample: sound.bits,
        sample_format: hound::SampleFormat::Int,
    };
    let mut file = WavFile::create(out, spec)?;
    let bar = show::progress(sound.cut.len() as u64, "cutting");
    let mut count = 0;
    for sample in sound.by_ref() {
        file.sample(sample)?;
        count += 1;
        if count % BAR_STEP == 0 {
            bar.set_position(count as u64);
        }
    }
    bar.finish_and_clear();
    Ok((file.finish(None)?, sound.cut.microphone().clipped()))
}

/// A cut sample by sample, as a WAV file holds it.
struct Sound {
    cut: VirtualCut,
    /// Bits of a sample in the file.
    bits: u16,
    /// Codes of fewer bits are aligned to the left: full scale stays full scale.
    shift: u32,
}

impl Sound {
    fn new(loaded: &Loaded) -> Result<Self, Failure> {
        let refused =
            |why| Failure::whole(&loaded.scenario.name, why, "correct the fields it names");
        let code_bits = loaded.scenario.microphone.converter.bits;
        let bits = if code_bits <= 16 { 16 } else { 24 };
        Ok(Self {
            cut: VirtualCut::new(&loaded.scenario).map_err(refused)?,
            bits,
            shift: u32::from(bits) - code_bits,
        })
    }
}

impl Iterator for Sound {
    type Item = i32;

    fn next(&mut self) -> Option<i32> {
        Some(self.cut.next()?.code << self.shift)
    }
}

/// What a recording of a scenario holds once it is read again.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// Samples as parts of full scale.
    pub samples: Vec<f64>,
    /// Their rate, Hz.
    pub fs: f64,
    /// Samples at the end of the range.
    pub clipped: u64,
}

/// Plays a scenario into memory: what [`rarma_recordings::input::read`] gives of the file that
/// `rarma simulate --out` writes.
///
/// # Errors
/// The plant refuses the scenario.
pub fn simulate(loaded: &Loaded) -> Result<Simulated, Failure> {
    let mut sound = Sound::new(loaded)?;
    let scale = 0.5 / f64::from(1u32 << (sound.bits - 2));
    let samples = sound.by_ref().map(|x| f64::from(x) * scale).collect();
    Ok(Simulated {
        samples,
        fs: sound.cut.sample_rate_hz().round(),
        clipped: sound.cut.microphone().clipped(),
    })
}

/// The truth for people.
pub(super) fn describe(loaded: &Loaded, truth: &TruthRecord) {
    say!("{}: {}", loaded.scenario.name, loaded.about);
    say!(
        "  spindle {:.0} 1/min, {} {} (tooth passing {:.1} Hz), {:.2} s",
        truth.speed_rpm,
        truth.teeth,
        if truth.teeth == 1 { "tooth" } else { "teeth" },
        truth.tooth_hz,
        truth.duration_s
    );
    match &truth.limit {
        Some(limit) => say!(
            "  stability limit {:.4} mm ({}, {:.1} Hz); zero-order {}",
            limit.depth_mm,
            limit.crossing,
            limit.chatter_hz,
            truth
                .zero_order_mm
                .map_or("not valid here".to_owned(), |d| format!("{d:.4} mm"))
        ),
        None => say!(
            "  stability limit: {}",
            truth.no_limit.as_deref().unwrap_or("not asked for")
        ),
    }
    match (truth.onset_s, truth.end_s) {
        (Some(on), Some(off)) => say!("  unstable from {on:.3} s to {off:.3} s"),
        (Some(on), None) => say!("  unstable from {on:.3} s to the end"),
        _ => say!("  stable throughout"),
    }
    for o in &truth.operational {
        let roots: Vec<String> = o
            .roots
            .iter()
            .map(|r| format!("{:.1} Hz {:+.3} %", r.f, 100.0 * r.zeta))
            .collect();
        say!(
            "  {:7.3} s  {:6.3} mm  {:6.0} 1/min  {}",
            o.t_s,
            o.depth_mm,
            o.speed_rpm,
            roots.join(", ")
        );
    }
}
