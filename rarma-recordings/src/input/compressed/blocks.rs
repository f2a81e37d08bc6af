//! Samples out of packets.
//!
//! What an encoder put around the sound is left out, so that samples stand where they
//! stood before it. A packet that cannot be decoded becomes missing samples, which the
//! monitor is told; a file that ends early is read as far as it goes. Both are said.

use super::super::blocks::{Blocks, End};
use super::super::{InputError, Problem, no_channel};
use super::guard::caught;
use std::io::ErrorKind;
use symphonia::core::codecs::audio::AudioDecoder;
use symphonia::core::errors::Error;
use symphonia::core::formats::FormatReader;
use symphonia::core::packet::Packet;

/// No packet of these codecs holds more frames: FLAC's largest block.
const MOST_FRAMES: u64 = 65_536;

/// More of the sound than this is not made up, s: what follows is not read.
const LONGEST_GAP_S: u64 = 60;

/// What is known of the sound before it is decoded.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sound {
    /// Sampling rate by the header, Hz.
    pub rate: u32,
    /// Units in which packets tell their time, a second.
    pub timescale: u32,
    /// Frames that the file says it holds.
    pub promised: Option<u64>,
    /// By so many frames that may be wrong.
    pub give: u64,
    /// Frames to be left out before the sound begins.
    pub skip: u64,
    /// The file is shorter than it says.
    pub cut: bool,
    /// Packets tell where they lie, and readers pass over those that are damaged.
    pub placed: bool,
    /// It is AAC, of which a part of the band may be made up by a player.
    pub aac: bool,
}

/// How the samples ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    /// As they should.
    Whole,
    /// The file ends inside a packet.
    Cut,
    /// The file goes on with what cannot be read.
    Broken,
    /// Another recording is joined to this one.
    Another,
}

/// A file that is being decoded.
pub(super) struct Decoded {
    reader: Box<dyn FormatReader>,
    decoder: Box<dyn AudioDecoder>,
    track: u32,
    sound: Sound,
    fs: f64,
    notices: Vec<String>,
    channels: Vec<usize>,
    /// Frames still to be left out.
    skip: u64,
    /// Frames handed on, missing ones among them.
    given: u64,
    /// Of those of the last block.
    missing: u64,
    /// Where packets count from: the place of the first.
    base: Option<i64>,
    /// Where the first packet that could not be decoded lay, and how many frames in all.
    lost: Option<(u64, u64)>,
    ending: Option<Ending>,
    /// A packet held twice the frames of the core: the upper half of the band was left out.
    halved: bool,
    planes: Vec<Vec<f64>>,
}

impl Decoded {
    pub(super) fn new(
        reader: Box<dyn FormatReader>,
        decoder: Box<dyn AudioDecoder>,
        track: u32,
        sound: Sound,
        fs: f64,
        notices: Vec<String>,
    ) -> Self {
        Self {
            reader,
            decoder,
            track,
            skip: sound.skip,
            sound,
            fs,
            notices,
            channels: vec![0],
            given: 0,
            missing: 0,
            base: None,
            lost: None,
            ending: None,
            halved: false,
            planes: Vec::new(),
        }
    }

    /// The next packet of the sound; none at the end, of whatever kind.
    fn packet(&mut self) -> Result<Option<Packet>, InputError> {
        while self.ending.is_none() {
            let next = caught(|| self.reader.next_packet());
            self.ending = Some(match next {
                Some(Ok(Some(packet))) if packet.track_id == self.track => return Ok(Some(packet)),
                Some(Ok(Some(_))) => continue,
                Some(Ok(None)) => Ending::Whole,
                Some(Err(Error::IoError(why))) if why.kind() == ErrorKind::UnexpectedEof => {
                    Ending::Cut
                }
                Some(Err(Error::IoError(why))) => return Err(InputError::from_io(&why)),
                Some(Err(Error::ResetRequired)) => Ending::Another,
                Some(Err(_)) | None => Ending::Broken,
            });
        }
        Ok(None)
    }

    /// Decodes a packet into the planes; the frames there are, none if it cannot be decoded.
    fn decode(&mut self, packet: &Packet) -> Result<Option<usize>, InputError> {
        let planes = &mut self.planes;
        let decoder = &mut self.decoder;
        let done = caught(|| {
            let buffer = decoder.decode(packet)?;
            buffer.copy_to_vecs_planar(planes);
            Ok::<_, Error>((buffer.frames(), buffer.spec().rate()))
        });
        let Some(Ok((frames, rate))) = done else {
            return Ok(None);
        };
        if frames > 0 && rate != self.sound.rate {
            return Err(InputError::new(
                Problem::Rate,
                self.place(),
                format!(
                    "the sampling rate changes from {} to {rate} Hz",
                    self.sound.rate
                ),
                "cut it there into two files",
            ));
        }
        let wanted = self.channels.iter().max().copied().unwrap_or(0);
        let there = self.planes.iter().all(|plane| plane.len() >= frames);
        Ok((there && self.planes.len() > wanted).then_some(frames))
    }

    /// Frames that a packet says it holds.
    fn told(&self, packet: &Packet) -> u64 {
        let units = u128::from(packet.dur.get());
        let frames = units * u128::from(self.sound.rate) / u128::from(self.sound.timescale.max(1));
        u64::try_from(frames).unwrap_or(u64::MAX).min(MOST_FRAMES)
    }

    /// Frames that should have come before this packet and did not.
    fn gap(&mut self, packet: &Packet) -> u64 {
        if !self.sound.placed {
            return 0;
        }
        let begin = packet
            .pts
            .get()
            .saturating_add_unsigned(packet.trim_start.get());
        let base = *self.base.get_or_insert(begin);
        let place = u64::try_from(begin.saturating_sub(base)).unwrap_or(0);
        place.saturating_sub(self.given)
    }

    /// Zeros for missing samples.
    fn fill(&mut self, rows: &mut [Vec<f64>], frames: u64) {
        if frames == 0 {
            return;
        }
        self.lost.get_or_insert((self.given, 0)).1 += frames;
        self.missing += frames;
        self.given += frames;
        for row in rows {
            row.resize(row.len() + frames as usize, 0.0);
        }
    }

    /// What is read where the sound is now.
    fn place(&self) -> String {
        format!(
            "sample {} ({:.3} s)",
            self.given,
            self.given as f64 / self.fs
        )
    }
}

impl Blocks for Decoded {
    fn want(&mut self, channels: &[usize]) {
        self.channels = channels.to_vec();
    }

    fn next(&mut self, rows: &mut [Vec<f64>]) -> Result<bool, InputError> {
        self.missing = 0;
        while let Some(packet) = self.packet()? {
            let told = self.told(&packet);
            let decoded = self.decode(&packet)?;
            let mut frames = match decoded {
                // The last packet of an MPEG-4 file says how much of it is sound.
                Some(frames) if self.sound.timescale == self.sound.rate && told > 0 => {
                    self.halved |= self.sound.aac && told == 2 * frames as u64;
                    told.min(frames as u64)
                }
                Some(frames) => frames as u64,
                None => told,
            };
            let from = self.skip.min(frames);
            self.skip -= from;
            frames -= from;
            if frames == 0 {
                continue;
            }
            let gap = self.gap(&packet);
            if gap > LONGEST_GAP_S * u64::from(self.sound.rate) {
                self.ending = Some(Ending::Broken);
                return Ok(false);
            }
            self.fill(rows, gap);
            if decoded.is_some() {
                let range = from as usize..(from + frames) as usize;
                for (row, channel) in rows.iter_mut().zip(&self.channels) {
                    row.extend_from_slice(&self.planes[*channel][range.clone()]);
                }
                self.given += frames;
            } else {
                self.fill(rows, frames);
            }
            return Ok(true);
        }
        Ok(false)
    }

    fn missing(&self) -> u64 {
        self.missing
    }

    fn end(&mut self) -> Result<End, InputError> {
        let lost = self.lost.map_or(0, |(_, frames)| frames);
        if self.given == lost {
            let (problem, what) = match self.given {
                0 => (Problem::NoSamples, "it holds no samples"),
                _ => (Problem::Unsupported, "nothing of its sound can be decoded"),
            };
            let remedy = "convert it to WAV or FLAC with another program, or record again";
            return Err(InputError::new(problem, "samples", what, remedy));
        }
        let seconds = self.given as f64 / self.fs;
        let read = format!("analysed {} frames ({seconds:.2} s)", self.given);
        let mut notices = std::mem::take(&mut self.notices);
        let promised = self
            .sound
            .promised
            .map(|n| n.saturating_sub(self.sound.skip));
        let short = promised.filter(|n| *n > self.given + self.sound.give);
        notices.extend(match (self.ending, short) {
            (Some(Ending::Another), _) => Some(format!(
                "another recording is joined to this one and is not read: {read}"
            )),
            (Some(Ending::Broken), _) => {
                Some(format!("the file cannot be read from there on: {read}"))
            }
            (_, Some(promised)) => Some(format!(
                "the header says {promised} frames, the file holds {}: {read}, the rest is cut off",
                self.given
            )),
            (Some(Ending::Cut), None) => Some(format!("the file ends too early: {read}")),
            (_, None) if self.sound.cut => Some(format!("the file ends too early: {read}")),
            _ => None,
        });
        if let Some((first, frames)) = self.lost {
            notices.push(format!(
                "from sample {first} ({:.3} s) on {frames} in all cannot be decoded: taken for missing",
                first as f64 / self.fs
            ));
        }
        if self.halved {
            notices.push(format!(
                "HE-AAC: what an encoder leaves out above {:.0} Hz and a player makes up is not read",
                self.fs / 2.0
            ));
        }
        Ok(End {
            fs: self.fs,
            notices,
        })
    }

    fn no_channel(&self, asked: usize, channels: usize) -> InputError {
        no_channel("header", asked, channels)
    }
}
