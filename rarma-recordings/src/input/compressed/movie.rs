//! The frame of an MPEG-4 file: which tracks there are, and where the sound begins.
//!
//! The decoder's own reader passes over edit lists, which tell how many samples an AAC
//! encoder put before the sound, and says in one word whatever it does not like. Here the
//! few boxes that matter are walked, box by box, without reading the sound: as much
//! memory for a day as for a second.

use super::super::{InputError, Problem};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

/// More boxes than this are looked at in no sound file.
const MOST_BOXES: u32 = 100_000;

/// What is known of the file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Movie {
    pub tracks: Vec<Track>,
    /// Where the last box ends, by what it says itself.
    pub end: u64,
    /// That is behind the end of the file.
    pub cut: bool,
}

/// One track.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Track {
    pub id: u32,
    /// `soun`, `vide`, …
    pub handler: [u8; 4],
    /// `mp4a`, `alac`, `avc1`, …
    pub codec: [u8; 4],
    /// Of the sound.
    pub channels: u16,
    /// Units of time a second.
    pub timescale: u32,
    /// Parts of the track that are meant to be heard: where each begins, in units of
    /// `timescale`.
    pub edits: Vec<u64>,
}

impl Movie {
    /// The first track with sound.
    pub(super) fn sound(&self) -> Option<&Track> {
        self.tracks.iter().find(|track| &track.handler == b"soun")
    }

    /// Whether there are pictures that move.
    pub(super) fn video(&self) -> bool {
        self.tracks.iter().any(|track| &track.handler == b"vide")
    }
}

/// Walks the file of this length, and rewinds it.
///
/// # Errors
/// It cannot be read, or ends before its index.
pub(super) fn read(file: &mut File, length: u64) -> Result<Movie, InputError> {
    let mut walk = Walk {
        file,
        boxes: 0,
        movie: Movie::default(),
        found: false,
    };
    walk.within(0, length, &[])
        .and_then(|()| walk.file.rewind())
        .map_err(|why| match why.kind() {
            ErrorKind::UnexpectedEof | ErrorKind::InvalidData => InputError::new(
                Problem::Header,
                "index",
                "its boxes contradict each other",
                "the file is damaged: copy it again",
            ),
            _ => InputError::from_io(&why),
        })?;
    let Walk { movie, found, .. } = walk;
    if !found {
        let what = if movie.cut {
            "the file ends before its index (moov), without which nobody knows where the sound lies: \
             it was copied in part, or the recorder stopped before it could write it"
        } else {
            "there is no index (moov), without which nobody knows where the sound lies"
        };
        return Err(InputError::new(
            Problem::Truncated,
            format!("byte {length}"),
            what,
            "copy it again, or record again",
        ));
    }
    Ok(movie)
}

struct Walk<'a> {
    file: &'a mut File,
    boxes: u32,
    movie: Movie,
    /// There is a `moov` box.
    found: bool,
}

/// Boxes whose insides are walked, by the names of those around them.
const OPENED: [&[&[u8; 4]]; 6] = [
    &[b"moov"],
    &[b"moov", b"trak"],
    &[b"moov", b"trak", b"edts"],
    &[b"moov", b"trak", b"mdia"],
    &[b"moov", b"trak", b"mdia", b"minf"],
    &[b"moov", b"trak", b"mdia", b"minf", b"stbl"],
];

impl Walk<'_> {
    /// The boxes from `at` to `end`, which lie inside those of `path`.
    fn within(&mut self, mut at: u64, end: u64, path: &[[u8; 4]]) -> io::Result<()> {
        while at.saturating_add(8) <= end {
            self.boxes += 1;
            if self.boxes > MOST_BOXES {
                return Err(ErrorKind::InvalidData.into());
            }
            self.file.seek(SeekFrom::Start(at))?;
            let short = u32::from_be_bytes(self.take()?);
            let name: [u8; 4] = self.take()?;
            let (head, size) = match short {
                0 => (8, end - at),
                1 => (16, u64::from_be_bytes(self.take()?)),
                size => (8, u64::from(size)),
            };
            if size < head {
                return Err(ErrorKind::InvalidData.into());
            }
            let whole = at.saturating_add(size);
            if whole > end {
                if !path.is_empty() {
                    return Err(ErrorKind::InvalidData.into());
                }
                self.movie.cut = true;
                if &name == b"moov" {
                    return Ok(());
                }
            }
            let inside: Vec<[u8; 4]> = path.iter().copied().chain([name]).collect();
            if inside.len() == 1 && &name == b"moov" {
                self.found = true;
            }
            if inside.len() == 2 && &name == b"trak" {
                self.movie.tracks.push(Track::default());
            }
            if OPENED
                .iter()
                .any(|open| open.iter().copied().eq(inside.iter()))
            {
                self.within(at + head, whole.min(end), &inside)?;
                self.movie.end = self.movie.end.max(whole);
            } else if let Some(outer) = path.last() {
                self.leaf(*outer, name, whole)?;
            } else {
                self.movie.end = whole;
            }
            at = whole;
        }
        if path.is_empty() && at < end {
            self.movie.cut = true;
        }
        Ok(())
    }

    /// A box whose numbers are wanted; the file stands behind its head.
    fn leaf(&mut self, outer: [u8; 4], name: [u8; 4], end: u64) -> io::Result<()> {
        match (&outer, &name) {
            (b"trak", b"tkhd") => {
                let wide = self.version()?;
                self.skip(if wide { 16 } else { 8 })?;
                let id = u32::from_be_bytes(self.take()?);
                self.of_track(|track| track.id = id);
            }
            (b"mdia", b"mdhd") => {
                let wide = self.version()?;
                self.skip(if wide { 16 } else { 8 })?;
                let timescale = u32::from_be_bytes(self.take()?);
                self.of_track(|track| track.timescale = timescale);
            }
            // QuickTime has another of that name, for where the samples lie.
            (b"mdia", b"hdlr") => {
                self.skip(8)?;
                let handler = self.take()?;
                self.of_track(|track| track.handler = handler);
            }
            (b"stbl", b"stsd") => {
                self.skip(12)?;
                let codec = self.take()?;
                self.skip(16)?;
                let channels = u16::from_be_bytes(self.take()?);
                self.of_track(|track| {
                    track.codec = codec;
                    track.channels = channels;
                });
            }
            (b"edts", b"elst") => self.edits(end)?,
            _ => {}
        }
        Ok(())
    }

    fn edits(&mut self, end: u64) -> io::Result<()> {
        let wide = self.version()?;
        let told = u32::from_be_bytes(self.take()?);
        let each = if wide { 20 } else { 12 };
        let there = end.saturating_sub(self.file.stream_position()?) / each;
        // Two tell that there are several; more are not wanted.
        for _ in 0..u64::from(told).min(there).min(8) {
            let begin = if wide {
                self.skip(8)?;
                i64::from_be_bytes(self.take()?)
            } else {
                self.skip(4)?;
                i64::from(i32::from_be_bytes(self.take()?))
            };
            self.skip(4)?;
            // Negative: a pause before the sound, which belongs to the pictures.
            if let Ok(begin) = u64::try_from(begin) {
                self.of_track(|track| track.edits.push(begin));
            }
        }
        Ok(())
    }

    fn of_track(&mut self, set: impl FnOnce(&mut Track)) {
        if let Some(track) = self.movie.tracks.last_mut() {
            set(track);
        }
    }

    /// Version and flags; whether its times are of 64 bits.
    fn version(&mut self) -> io::Result<bool> {
        let [version, ..]: [u8; 4] = self.take()?;
        Ok(version == 1)
    }

    fn skip(&mut self, bytes: i64) -> io::Result<()> {
        self.file.seek(SeekFrom::Current(bytes)).map(|_| ())
    }

    fn take<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}
