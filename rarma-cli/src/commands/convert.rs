//! `rarma convert`: a recording to a format of other programs.

use crate::args::{ChannelSet, ConvertArgs};
use crate::failure::Failure;
use crate::output;
use rarma_recordings::export::{Along, Column, Table};
use rarma_recordings::input::{self, ReadOptions, Recording};

/// What stands in the file for the unit of a recording's samples: as asked for, else as it says
/// itself, else parts of full scale.
pub(super) fn unit(asked: Option<&str>, recording: &Recording) -> String {
    asked
        .or(recording.unit.as_deref())
        .unwrap_or("1")
        .to_owned()
}

pub(super) fn main(args: &ConvertArgs) -> Result<u8, Failure> {
    let options = ReadOptions {
        fs: args.input.fs,
        stream: args.input.stream,
        // What is sick is written as it is: whoever reads it is to see it.
        check: false,
        ..ReadOptions::default()
    };
    let path = &args.input.input;
    let one = [args.input.channel];
    let wanted = match &args.channels {
        Some(ChannelSet::These(these)) => Some(&these[..]),
        Some(ChannelSet::All) => None,
        None => (args.input.channel > 0).then_some(&one[..]),
    };
    let recordings = input::read_channels(path, &options, args.input.raw(), wanted)?;
    let Some(first) = recordings.first() else {
        return Err(Failure::whole(
            path.display(),
            "it has no channel",
            "record again",
        ));
    };
    for notice in &first.notices {
        eprintln!("{}: {notice}", path.display());
    }
    let table = Table {
        title: format!("{}: {}", path.display(), first.format),
        along: Along::Time { fs: first.fs },
        columns: recordings
            .iter()
            .map(|r| Column {
                name: format!("channel {}", r.channel),
                channel: r.channel,
                unit: unit(args.unit.as_deref(), r),
                values: r.samples.clone(),
            })
            .collect(),
    };
    output::keep(vec![output::export(&args.out, "--out", &table)?])?;
    say!(
        "{}: {} samples of {} channel{} at {} Hz",
        args.out.display(),
        first.samples.len(),
        recordings.len(),
        if recordings.len() == 1 { "" } else { "s" },
        first.fs
    );
    Ok(0)
}
