//! Recordings in TDMS files of National Instruments: LabVIEW, DIAdem, FlexLogger. Each channel of
//! numbers over time is a channel, numbered through all groups in the order of the file.
//!
//! After NI's description of the format ("TDMS File Format Internal Structure"): channels one after
//! the other or in turn, either end first, chunks that repeat, lists of objects that go on. Linear and
//! polynomial scales are applied. Samples in the layout of a DAQmx card are refused.

mod bytes;
mod index;
mod kind;
mod layout;
mod object;
mod scale;

use super::blocks::{Begin, Blocks, End};
use super::time::is_rate;
use super::{InputError, Problem};
use crate::one_line::OneLine;
use kind::Kind;
use object::{Object, Piece};
use scale::Scales;
use std::collections::HashMap;
use std::io::{Read, Seek, SeekFrom};

/// Samples handed on at once.
const BLOCK: u64 = 1 << 13;
/// Bytes that are read at once, at most, where channels come in turn.
const SPAN: u64 = 1 << 22;
/// A step is the inverse of a rate: within so much of a whole one it is that.
const WHOLE: f64 = 1e-9;
/// Channels that are named in words, at most.
const NAMED: usize = 8;

/// What can be read at any place.
pub(super) trait Source: Read + Seek {}

impl<S: Read + Seek> Source for S {}

/// A channel of numbers over time.
struct Channel {
    name: String,
    unit: Option<String>,
    kind: Kind,
    pieces: Vec<Piece>,
    count: u64,
    /// Hz, where it is said.
    rate: Option<f64>,
    scales: Result<Scales, String>,
}

/// Reads what is said of the channels; `length` is that of the file, none for a pipe.
pub(super) fn begin(
    mut source: Box<dyn Source>,
    length: Option<u64>,
    fs: Option<f64>,
) -> Result<Begin, InputError> {
    let length = length.ok_or_else(|| {
        InputError::new(
            Problem::Unsupported,
            "open",
            "a TDMS file is read at many places, which a pipe does not allow",
            "name the file",
        )
    })?;
    let index = index::read(&mut *source, length)?;
    let mut notices = index.notices;
    let (channels, left_out) = channels(&index.objects);
    if channels.is_empty() {
        return Err(InputError::new(
            Problem::NoSamples,
            "whole file",
            format!("no channel of numbers over time; {left_out} of other kinds, or empty"),
            "check that it is the right file, or export it as waveforms",
        ));
    }
    if left_out > 0 {
        let all = left_out + channels.len();
        notices.push(format!(
            "{left_out} of {all} channels left out: empty, or no numbers over time"
        ));
    }
    let mut groups: Vec<&str> = channels.iter().map(Channel::group).collect();
    groups.dedup();
    if groups.len() > 1 {
        notices.push(format!(
            "{} groups: channels are numbered through all of them, {}",
            groups.len(),
            named(&channels)
        ));
    }
    let rate = channels[0].rate;
    let alike = channels.iter().all(|channel| channel.rate == rate);
    if fs.is_none() && channels.iter().all(|channel| channel.rate.is_none()) {
        return Err(no_rate(&channels[0]));
    }
    Ok(Begin {
        format: format!("TDMS, {}", named(&channels)),
        // Where they differ, the channels that are wanted tell.
        fs: fs.or(rate.filter(|_| alike)),
        step: None,
        channels: channels.len(),
        blocks: Box::new(Held {
            source,
            channels,
            wanted: Vec::new(),
            fs,
            is_cut: index.is_cut,
            end: None,
            notices,
        }),
    })
}

/// The channels that are taken, and how many are not.
fn channels(objects: &[Object]) -> (Vec<Channel>, usize) {
    let (mut taken, mut left_out) = (Vec::new(), 0);
    let file = objects.iter().find(|object| object.names.is_empty());
    let groups = objects.iter().filter(|object| object.names.len() == 1);
    let groups: HashMap<&str, &Object> = groups
        .map(|group| (group.names[0].as_str(), group))
        .collect();
    for object in objects.iter().filter(|object| object.is_channel()) {
        let over_time = object
            .text("wf_xunit_string")
            .is_none_or(|unit| matches!(unit, "s" | "S" | "sec" | "Sec" | "seconds" | "Seconds"));
        let Some(kind) = object
            .kind
            .filter(|kind| kind.is_number() && object.count > 0 && over_time)
        else {
            left_out += 1;
            continue;
        };
        let group = groups.get(object.names[0].as_str()).copied();
        let step = object.number("wf_increment");
        taken.push(Channel {
            name: object.name(),
            unit: object
                .text("unit_string")
                .map(|unit| OneLine(unit).to_string()),
            kind,
            pieces: object.pieces.clone(),
            count: object.count,
            rate: step.map(rate_of_step).filter(|rate| is_rate(*rate)),
            scales: Scales::of([Some(object), group, file]),
        });
    }
    (taken, left_out)
}

fn rate_of_step(step: f64) -> f64 {
    let rate = 1.0 / step;
    if (rate / rate.round() - 1.0).abs() < WHOLE {
        rate.round()
    } else {
        rate
    }
}

/// The first channels by number, name and unit.
fn named(channels: &[Channel]) -> String {
    let one = |(k, channel): (usize, &Channel)| match &channel.unit {
        Some(unit) => format!("{k} '{}' in {unit}", channel.name),
        None => format!("{k} '{}'", channel.name),
    };
    let mut words: Vec<String> = channels.iter().enumerate().take(NAMED).map(one).collect();
    if channels.len() > NAMED {
        words.push("…".to_owned());
    }
    words.join(", ")
}

fn no_rate(channel: &Channel) -> InputError {
    InputError::new(
        Problem::Rate,
        format!("channel '{}'", channel.name),
        "no sampling rate: the property wf_increment is missing or tells none",
        "give --fs in hertz",
    )
}

impl Channel {
    fn group(&self) -> &str {
        self.name.split('/').next().unwrap_or(&self.name)
    }

    /// Appends the samples from number `from` on, at least one and at most `most`, to `row`.
    fn samples(
        &self,
        source: &mut dyn Source,
        cursor: &mut Cursor,
        most: u64,
        row: &mut Vec<f64>,
    ) -> Result<(), InputError> {
        let scales = self.scales.as_ref().map_err(|what| {
            InputError::new(
                Problem::Unsupported,
                format!("channel '{}'", self.name),
                format!("{what} is not known here"),
                "save it again with scaled samples",
            )
        })?;
        let size = self.kind.size().unwrap_or(1);
        let mut bytes = Vec::new();
        let mut left = most;
        while left > 0
            && let Some(piece) = self.pieces.get(cursor.piece)
        {
            if cursor.within >= piece.count {
                (cursor.piece, cursor.within) = (cursor.piece + 1, 0);
                continue;
            }
            let (chunk, within) = (cursor.within / piece.each, cursor.within % piece.each);
            let here = (piece.each - within)
                .min(piece.count - cursor.within)
                .min(left)
                .min(SPAN / piece.stride.max(1) + 1);
            let at = piece.at + chunk * piece.chunk + within * piece.stride;
            bytes.resize(((here - 1) * piece.stride + size) as usize, 0);
            let done = source.seek(SeekFrom::Start(at));
            let done = done.and_then(|_| source.read_exact(&mut bytes));
            done.map_err(|why| InputError::from_io(&why))?;
            let each = bytes.chunks(piece.stride as usize);
            row.extend(each.map(|value| scales.apply(self.kind.value(value, piece.big))));
            cursor.within += here;
            left -= here;
        }
        Ok(())
    }
}

/// The next sample of a channel.
#[derive(Debug, Clone, Copy, Default)]
struct Cursor {
    piece: usize,
    within: u64,
}

struct Held {
    source: Box<dyn Source>,
    channels: Vec<Channel>,
    wanted: Vec<(usize, Cursor)>,
    fs: Option<f64>,
    is_cut: bool,
    /// Samples that are left of each wanted channel, once they have been looked at.
    end: Option<u64>,
    notices: Vec<String>,
}

impl Held {
    fn first(&self) -> &Channel {
        let wanted = self.wanted.first().and_then(|(k, _)| self.channels.get(*k));
        wanted.unwrap_or(&self.channels[0])
    }

    /// The rate of the wanted channels, Hz.
    fn rate(&mut self) -> Result<f64, InputError> {
        let first = self.first();
        let told = first.rate;
        let other = self
            .wanted
            .iter()
            .map(|(k, _)| &self.channels[*k])
            .find(|channel| channel.rate != told);
        match (self.fs, told, other) {
            (Some(fs), _, _) => Ok(fs),
            (None, _, Some(other)) => {
                let hz = |channel: &Channel| match channel.rate {
                    Some(rate) => format!("{rate} Hz"),
                    None => "an unknown rate".to_owned(),
                };
                Err(InputError::new(
                    Problem::Rate,
                    "channels",
                    format!(
                        "'{}' has {} and '{}' {}",
                        first.name,
                        hz(first),
                        other.name,
                        hz(other)
                    ),
                    "choose channels of one rate",
                ))
            }
            (None, Some(told), None) => Ok(told),
            (None, None, None) => Err(no_rate(first)),
        }
    }

    /// Samples of each wanted channel.
    fn length(&mut self) -> Result<u64, InputError> {
        self.rate()?;
        let (first, fs) = (self.first().count, self.fs);
        if let Some((fs, told)) = fs.zip(self.first().rate).filter(|(fs, told)| fs != told) {
            let what = format!("header says {told} Hz: --fs {fs} Hz used instead");
            self.notices.push(what);
        }
        let counts = self.wanted.iter().map(|(k, _)| self.channels[*k].count);
        let least = counts.min().unwrap_or(first);
        let other = self
            .wanted
            .iter()
            .find(|(k, _)| self.channels[*k].count != first);
        if let Some((k, _)) = other {
            let (one, other) = (self.first(), &self.channels[*k]);
            let what = format!(
                "'{}' has {} samples and '{}' {}",
                one.name, one.count, other.name, other.count
            );
            if !self.is_cut {
                return Err(InputError::new(
                    Problem::Unsupported,
                    "channels",
                    what,
                    "choose channels of one length, such as those of one group",
                ));
            }
            self.notices
                .push(format!("{what}: {least} of each were read"));
        }
        Ok(least)
    }
}

impl Blocks for Held {
    fn want(&mut self, channels: &[usize]) {
        self.wanted = channels.iter().map(|k| (*k, Cursor::default())).collect();
    }

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        let left = match self.end {
            Some(left) => left,
            None => self.length()?,
        };
        let here = left.min(BLOCK);
        self.end = Some(left - here);
        for (row, (k, cursor)) in rows.iter_mut().zip(&mut self.wanted) {
            self.channels[*k].samples(&mut *self.source, cursor, here, row)?;
        }
        Ok(here > 0)
    }

    fn end(&mut self) -> Result<End, InputError> {
        Ok(End {
            fs: self.rate()?,
            notices: self.notices.clone(),
        })
    }

    fn unit(&self, channel: usize) -> Option<String> {
        self.channels.get(channel)?.unit.clone()
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        let what = format!(
            "channel {asked} asked for, but there are {channels}: {}",
            named(&self.channels)
        );
        InputError::new(
            Problem::Channel,
            "whole file",
            what,
            "choose another --channel",
        )
    }
}
