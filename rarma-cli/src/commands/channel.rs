//! Further channels of a recording: a second sensor, a tacho.

use crate::args::MonitorArgs;
use crate::failure::Failure;
use crate::input::{self, ReadOptions, Recording};

/// A channel of the job's file, not yet checked: what is wrong with it is for the
/// caller to judge.
///
/// # Errors
/// The file cannot be read, or has no such channel.
pub(super) fn open(args: &MonitorArgs, channel: usize) -> Result<Recording, Failure> {
    let options = ReadOptions {
        channel,
        fs: args.input.fs,
        stream: args.input.stream,
        check: false,
    };
    Ok(input::read(&args.input.input, &options)?)
}

/// That a file of `channels` channels has the one that `option` asks for.
///
/// # Errors
/// It has not; `remedy` is what else may be done.
pub(super) fn require(
    args: &MonitorArgs,
    option: &str,
    channel: usize,
    channels: usize,
    remedy: &str,
) -> Result<(), Failure> {
    if channel < channels {
        return Ok(());
    }
    let have = match channels {
        1 => "one channel, number 0".to_owned(),
        n => format!("{n} channels, numbered 0 to {}", n - 1),
    };
    Err(Failure::Input(format!(
        "{}: channels: {option} asks for channel {channel}, but the file has {have} ({remedy}, or leave out {option})",
        args.input.input.display()
    )))
}
