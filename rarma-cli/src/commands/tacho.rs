//! `rarma monitor --tacho`: the channel of a recording that holds a tacho's pulses.

use super::channel;
use crate::args::MonitorArgs;
use crate::failure::Failure;
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
    if channel == args.input.channel || Some(channel) == args.second {
        return Err(Failure::Usage(format!(
            "--tacho: must be another channel than those that are listened to (channel {channel} is)"
        )));
    }
    let channels = channel::open(args, args.input.channel)?.channels;
    let remedy = "record the tacho into the same file";
    channel::require(args, "--tacho", channel, channels, remedy)?;
    // Unchecked: pulses are no vibration, flat and clipped is what they should be.
    let tacho = channel::open(args, channel)?;
    let finite = || tacho.samples.iter().copied().filter(|x| x.is_finite());
    let span = finite().fold(f64::MIN, f64::max) - finite().fold(f64::MAX, f64::min);
    let least = (LEAST_HEIGHT * span).max(f64::MIN_POSITIVE);
    let mut detector = PulseDetector::<f64>::new(tacho.fs, least);
    let pulses = tacho.samples.iter().map(|&x| detector.process(x));
    Ok(pulses
        .map(|pulse| pulse.map(|before| before as f32))
        .collect())
}
