//! Cuts as recordings with a list of what is true of each.
//!
//! `labels.json` is a list, one object a recording. `ints` and `f` are for readers that
//! know one stretch of chatter a recording; everything else stands beside them.

use super::{Judged, told};
use rarma_plants::population::state::Cutting;
use rarma_recordings::output::{self, WavFile, WriteError};
use serde_json::{Value, json};
use std::path::Path;

/// Bits of a sample in the file. Converters of fewer bits are aligned to the left.
const FILE_BITS: u16 = 16;

/// Name of the recording of a seed.
fn name(seed: u64) -> String {
    format!("cut-{seed:06}")
}

/// Writes the recording of one cut into a folder that is there.
///
/// # Errors
/// It cannot be written.
pub fn write_recording(folder: &Path, one: &Judged) -> Result<(), WriteError> {
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: one.heard.fs_hz.round() as u32,
        bits_per_sample: FILE_BITS,
        sample_format: hound::SampleFormat::Int,
    };
    let path = folder.join(name(one.cut.seed)).with_extension("wav");
    let mut file = WavFile::create(&path, spec)?;
    let top = f32::from(i16::MAX) + 1.0;
    for x in &one.heard.samples {
        file.sample((x * top) as i16)?;
    }
    file.finish(None)?.keep()
}

/// Writes the list.
///
/// # Errors
/// It cannot be written.
pub fn write_list(folder: &Path, labels: &[Value]) -> Result<(), WriteError> {
    // Values only: there is nothing that could not be written.
    let text = serde_json::to_string_pretty(labels).unwrap_or_default();
    output::write(&folder.join("labels.json"), text)
}

fn thousandths(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

fn pairs(of: &[(f64, f64)]) -> Vec<[f64; 2]> {
    of.iter()
        .map(|p| [thousandths(p.0), thousandths(p.1)])
        .collect()
}

/// Stretches without others, s.
fn without(stretches: Vec<(f64, f64)>, others: &[(f64, f64)]) -> Vec<(f64, f64)> {
    others.iter().fold(stretches, |left, (from, to)| {
        left.iter()
            .flat_map(|s| [(s.0, s.1.min(*from)), (s.0.max(*to), s.1)])
            .filter(|s| s.1 > s.0)
            .collect()
    })
}

/// What is true of one cut.
pub fn label(one: &Judged) -> Value {
    let (cut, heard) = (&one.cut, &one.heard);
    let name = name(cut.seed);
    let chatter = pairs(&heard.chatter_s);
    let either = without(cut.either_s(), &heard.chatter_s);
    let class = if cut.undecidable() {
        "ambiguous"
    } else if !chatter.is_empty() {
        "chatter"
    } else if either.is_empty() {
        "none"
    } else {
        "ambiguous"
    };
    // What is not the first chatter, and may be called or not.
    let mut apart = heard.chatter_s.get(1..).unwrap_or_default().to_vec();
    apart.extend(&either);
    let stretches: Vec<Value> = cut
        .stretches()
        .iter()
        .map(|s| json!([thousandths(s.from_s), state(s.cutting)]))
        .collect();
    let (f, zeta) = cut.operational();
    let rpm = |course: Vec<(f64, f64)>| -> Vec<[f64; 2]> {
        course
            .iter()
            .map(|p| [thousandths(p.0), thousandths(60.0 * p.1)])
            .collect()
    };
    json!({
        "name": name, "file": format!("{name}.wav"), "class": class,
        "ints": chatter.first().map(|c| vec![c]).unwrap_or_default(),
        "f": heard.chatter_hz.map(|f| [thousandths(f.0), thousandths(f.1)]),
        "rpm": 60.0 * cut.spindle_hz(), "teeth": cut.teeth(),
        "sec": heard.samples.len() as f64 / heard.fs_hz, "fs": heard.fs_hz.round() as u32,
        "excl": pairs(&apart), "aliased": cut.sensor.folds > 1, "note": cut.kinds().join(", "),
        "seed": cut.seed, "chatter": chatter, "either": pairs(&either), "stretches": stretches,
        "operational": { "f": thousandths(f), "zeta": (zeta * 1e6).round() / 1e6 },
        "limit_part": thousandths(cut.limit_part()), "kinds": cut.kinds(),
        "undecidable": cut.undecidable(),
        "quiet_s": thousandths(cut.quiet_s(heard, 0.0, cut.length_s())),
        "speed": rpm(cut.speeds()), "live": rpm(told::live(cut)),
    })
}

fn state(cutting: Cutting) -> &'static str {
    match cutting {
        Cutting::Air => "air",
        Cutting::Stable => "stable",
        Cutting::Margin => "margin",
        Cutting::Unstable => "unstable",
    }
}
