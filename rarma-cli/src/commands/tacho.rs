//! `rarma monitor --tacho`: the channel of a recording that holds a tacho's pulses.

use crate::args::MonitorArgs;
use crate::failure::Failure;
use crate::input::{self, ReadOptions};
use rarma_core::condition::PulseDetector;

/// A pulse is at least this part of the channel's span high: what lies below is noise
/// between pulses that are fewer than the detector's memory expects.
const LEAST_HEIGHT: f64 = 0.3;

/// For every sample, where a pulse has begun since the one before: how long ago,
/// samples.
///
/// # Errors
/// The channel is not there, or is one that is listened to.
pub fn read(args: &MonitorArgs, channel: usize) -> Result<Vec<Option<f32>>, Failure> {
    let path = &args.input.input;
    if channel == args.input.channel || Some(channel) == args.second {
        return Err(Failure::Usage(format!(
            "--tacho: must be another channel than those that are listened to (channel {channel} is)"
        )));
    }
    let open = |channel| {
        let options = ReadOptions {
            channel,
            fs: args.input.fs,
            // Pulses are no vibration: flat and clipped is what they should be.
            check: false,
        };
        input::read(path, &options)
    };
    let channels = open(args.input.channel)?.channels;
    if channel >= channels {
        let have = match channels {
            1 => "one channel, number 0".to_owned(),
            n => format!("{n} channels, numbered 0 to {}", n - 1),
        };
        return Err(Failure::Input(format!(
            "{}: channels: --tacho asks for channel {channel}, but the file has {have} (record the tacho into the same file, or leave out --tacho)",
            path.display()
        )));
    }
    let tacho = open(channel)?;
    let finite = || tacho.samples.iter().copied().filter(|x| x.is_finite());
    let span = finite().fold(f64::MIN, f64::max) - finite().fold(f64::MAX, f64::min);
    let least = (LEAST_HEIGHT * span).max(f64::MIN_POSITIVE);
    let mut detector = PulseDetector::<f64>::new(tacho.fs, least);
    let pulses = tacho.samples.iter().map(|&x| detector.process(x));
    Ok(pulses
        .map(|pulse| pulse.map(|before| before as f32))
        .collect())
}
