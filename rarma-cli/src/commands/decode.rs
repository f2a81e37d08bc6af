//! `rarma decode`: frames from anywhere to words, JSON or a WAV.

use crate::args::DecodeArgs;
use crate::failure::Failure;
use crate::frames::{FrameReader, RawSamples, to_json, words};
use crate::port::Port;
use std::path::Path;

pub(super) fn main(args: &DecodeArgs) -> Result<u8, Failure> {
    let mut port = Port::open(&args.input, args.baud)?;
    let mut reader = FrameReader::default();
    let mut raw = RawSamples::default();
    let mut bytes = [0; 4096];
    loop {
        let Some(n) = port.read(&mut bytes)? else {
            continue;
        };
        if n == 0 {
            break;
        }
        reader.take(&bytes[..n], |head, message| {
            raw.take(&message);
            if args.json {
                say!("{}", to_json(head, &message));
            } else if let Some(text) = words(&message) {
                say!("{text}");
            }
        });
    }
    if let Some(losses) = reader.losses() {
        eprintln!("{}: {losses}", args.input);
    }
    if reader.whole == 0 {
        return Err(Failure::Input(format!(
            "{}: end of input: no whole frame in it (is it a record of a box, and the baud rate right?)",
            args.input
        )));
    }
    if let Some(path) = &args.wav {
        write_wav(path, &args.input, &raw)?;
    }
    Ok(0)
}

fn write_wav(path: &Path, input: &str, raw: &RawSamples) -> Result<(), Failure> {
    let (samples, missing) = raw.joined();
    let (false, Some(fs)) = (samples.is_empty(), raw.fs_hz) else {
        return Err(Failure::Input(format!(
            "{input}: end of input: no raw samples with their rate in it (send `stream SECONDS` while recording)"
        )));
    };
    if missing > 0 {
        eprintln!("{input}: {missing} samples are missing; zeros stand in their place");
    }
    let failed = |why: hound::Error| Failure::System(format!("{}: {why}", path.display()));
    let spec = hound::WavSpec {
        channels: 1,
        sample_rate: fs.round() as u32,
        bits_per_sample: 16,
        sample_format: hound::SampleFormat::Int,
    };
    let mut writer = hound::WavWriter::create(path, spec).map_err(failed)?;
    for x in samples {
        writer
            .write_sample((x * 32767.0).round() as i16)
            .map_err(failed)?;
    }
    writer.finalize().map_err(failed)
}
