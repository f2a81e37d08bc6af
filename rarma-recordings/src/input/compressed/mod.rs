//! Recordings as phones and cameras make them: AAC in MPEG-4, MP3, FLAC, Ogg Vorbis.
//!
//! `symphonia` takes the files apart and decodes; what is told about them, in which words,
//! and what is done where they end early or hold what cannot be decoded, is decided here.
//! A file is opened (this file), its samples are taken packet by packet ([`blocks`]),
//! so that a day takes as much memory as a second but for the index of an MPEG-4 file
//! (some bytes for every 20 ms).

mod blocks;
mod guard;
mod movie;
mod source;
mod words;

use super::blocks::Begin;
use super::content::Content;
use super::{InputError, Problem, rate_of};
use blocks::{Decoded, Sound};
use guard::caught;
use movie::Movie;
use source::Source;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use symphonia::core::codecs::audio::well_known::CODEC_ID_AAC;
use symphonia::core::codecs::audio::{AudioCodecParameters, AudioDecoderOptions};
use symphonia::core::errors::Error;
use symphonia::core::formats::probe::{Hint, Probe};
use symphonia::core::formats::{FormatReader, Track, TrackType};
use symphonia::core::io::MediaSourceStream;
use symphonia::default::formats::{FlacReader, IsoMp4Reader, MpaReader, OggReader};
use symphonia::default::meta::Id3v2Reader;

/// Highest rate that is believed, Hz: fifty times that of studios.
const MOST_HZ: u32 = 10_000_000;

/// Reads up to the samples of a compressed file, which is `named` one of that kind; `length`
/// is that of the file, none for a pipe with such a name.
pub(super) fn begin(
    mut file: File,
    length: Option<u64>,
    named: Content,
    fs: Option<f64>,
) -> Result<Begin, InputError> {
    let mut movie = None;
    match (length, named) {
        (Some(length), _) => {
            agrees(&mut file, named)?;
            if named == Content::Mp4 {
                movie = Some(movie::read(&mut file, length)?);
            }
        }
        (None, Content::Mp4) => {
            return Err(InputError::new(
                Problem::Unsupported,
                "open",
                "an MPEG-4 file has to be read twice, and a pipe cannot be",
                "save it in a file, or send WAV",
            ));
        }
        (None, _) => {}
    }
    let end = movie.as_ref().map_or(length, |movie| Some(movie.end));
    let reader = opened(Source::new(file, end), named)?;
    let track = sound(&*reader, movie.as_ref())?;
    let params = track
        .codec_params
        .as_ref()
        .and_then(|params| params.audio())
        .cloned()
        .ok_or_else(|| words::unsupported(movie.as_ref(), None))?;
    let options = AudioDecoderOptions::default()
        // An MP3 without the encoder's own tag says nothing of its delay: its length is a guess.
        .gapless(named != Content::Mp3 || track.delay.is_some());
    let codecs = symphonia::default::get_codecs();
    let decoder = caught(|| codecs.make_audio_decoder(&params, &options))
        .and_then(Result::ok)
        .ok_or_else(|| words::unsupported(movie.as_ref(), Some(&params)))?;
    // The decoder knows better than the container where both tell it.
    let known = decoder.codec_params();
    let rate = known.sample_rate.or(params.sample_rate).unwrap_or(0);
    if rate > MOST_HZ {
        return Err(words::header(format!("it says {rate} samples a second")));
    }
    let channels = known.channels.as_ref().or(params.channels.as_ref());
    let by_index = movie.as_ref().and_then(Movie::sound);
    let by_index = by_index.map_or(0, |track| usize::from(track.channels));
    let channels = channels.map_or(by_index, |all| all.count());
    if channels == 0 {
        return Err(InputError::new(
            Problem::Channel,
            "header",
            "it says 0 channels",
            "record again, or convert it to WAV",
        ));
    }
    let mut notices = Vec::new();
    let fs = rate_of("header", rate, fs, &mut notices)?;
    let sound = Sound {
        rate,
        timescale: track.time_base.map_or(rate, |base| base.denom.get()),
        promised: frames(&track, &options),
        // FLAC and MPEG-4 count exactly; others by packets, of which one may be the tag.
        give: match named {
            Content::Flac | Content::Mp4 => 0,
            _ => 2048,
        },
        skip: movie.as_ref().map_or(0, |movie| priming(movie, rate)),
        cut: movie.as_ref().is_some_and(|movie| movie.cut),
        placed: matches!(named, Content::Flac | Content::Ogg),
        aac: params.codec == CODEC_ID_AAC,
    };
    let bits = params
        .bits_per_sample
        .filter(|bits| (1..=32).contains(bits));
    let lossless = words::lossless(params.codec);
    let mean = mean_rate(&track, length, movie.as_ref(), rate);
    notices.extend(words::notices(&params, rate, movie.as_ref()));
    Ok(Begin {
        format: words::format(named, &params, bits, mean, movie.as_ref()),
        fs: Some(fs),
        // What a codec hands on is scaled to ±1 like the integers it was made of.
        step: Some(2_f64.powi(1 - bits.filter(|_| lossless).unwrap_or(16) as i32)),
        channels,
        blocks: Box::new(Decoded::new(reader, decoder, track.id, sound, fs, notices)),
    })
}

/// That the first bytes are those of the kind it is named.
fn agrees(file: &mut File, named: Content) -> Result<(), InputError> {
    let head = head(file).map_err(|why| InputError::from_io(&why))?;
    let found = Content::of(&head);
    // Of MP3 alone the beginning may be cut off: a frame is looked for.
    if found == Some(named) || found.is_none() && named == Content::Mp3 {
        return Ok(());
    }
    let (what, remedy) = match found {
        Some(found) => (found.name(), found.remedy()),
        None if head.len() < 12 => {
            return Err(InputError::new(
                Problem::Truncated,
                format!("byte {}", head.len()),
                "the file ends inside its first header",
                "copy it again; nothing can be saved from it",
            ));
        }
        None => (
            "something that is not known",
            "check that it is the right file, or convert it to WAV".to_owned(),
        ),
    };
    Err(InputError::new(
        Problem::NotThisFormat,
        "byte 0",
        format!("not {} but {what}", words::kind(named)),
        remedy,
    ))
}

/// The first bytes behind the tag (ID3) that some programs put before any sound; the file is
/// rewound.
fn head(file: &mut File) -> io::Result<Vec<u8>> {
    let mut look = |at: u64| -> io::Result<Vec<u8>> {
        let mut head = Vec::new();
        file.seek(SeekFrom::Start(at))?;
        file.take(64).read_to_end(&mut head)?;
        file.rewind()?;
        Ok(head)
    };
    let first = look(0)?;
    match first[..] {
        [b'I', b'D', b'3', _, _, _, a, b, c, d, ..] => {
            let size = [a, b, c, d]
                .iter()
                .fold(0, |sum, x| sum << 7 | u64::from(x & 0x7f));
            look(10 + size)
        }
        _ => Ok(first),
    }
}

/// The file taken apart.
fn opened(source: Source, named: Content) -> Result<Box<dyn FormatReader>, InputError> {
    let mut probe = Probe::default();
    match named {
        Content::Mp4 => probe.register_format::<IsoMp4Reader<'_>>(),
        Content::Flac => probe.register_format::<FlacReader<'_>>(),
        Content::Ogg => probe.register_format::<OggReader<'_>>(),
        _ => probe.register_format::<MpaReader<'_>>(),
    }
    if matches!(named, Content::Flac | Content::Mp3) {
        probe.register_metadata::<Id3v2Reader<'_>>();
    }
    let stream = MediaSourceStream::new(Box::new(source), Default::default());
    let (hint, format, meta) = (Hint::new(), Default::default(), Default::default());
    let found = caught(|| probe.probe(&hint, stream, format, meta));
    found
        .unwrap_or(Err(Error::DecodeError("")))
        .map_err(|why| words::not_opened(named, &why))
}

/// The track to listen to.
fn sound(reader: &dyn FormatReader, movie: Option<&Movie>) -> Result<Track, InputError> {
    if movie.is_some_and(|movie| movie.sound().is_none()) {
        return Err(InputError::new(
            Problem::NoSamples,
            "tracks",
            if movie.is_some_and(Movie::video) {
                "a video without sound"
            } else {
                "there is no sound in it"
            },
            "check the camera's microphone, and record again",
        ));
    }
    let track = match movie.and_then(Movie::sound) {
        Some(sound) => reader.tracks().iter().find(|track| track.id == sound.id),
        None => reader
            .default_track(TrackType::Audio)
            .or_else(|| reader.tracks().first()),
    };
    track
        .cloned()
        .ok_or_else(|| words::unsupported(movie, None))
}

/// Frames that the file says it holds, without those that an encoder put around them.
fn frames(track: &Track, options: &AudioDecoderOptions) -> Option<u64> {
    track.num_frames.filter(|n| *n > 0 && options.gapless)
}

/// Frames before the sound begins: an AAC encoder's run-up, by the edit list.
fn priming(movie: &Movie, rate: u32) -> u64 {
    let Some(track) = movie.sound().filter(|track| track.timescale > 0) else {
        return 0;
    };
    let begin = track.edits.first().copied().unwrap_or(0);
    let frames = u128::from(begin) * u128::from(rate) / u128::from(track.timescale);
    u64::try_from(frames).unwrap_or(u64::MAX)
}

/// Mean bit rate, kbit/s, of a file that holds sound and nothing else.
fn mean_rate(track: &Track, length: Option<u64>, movie: Option<&Movie>, rate: u32) -> Option<f64> {
    let alone = movie.is_none_or(|movie| movie.tracks.len() == 1 && !movie.cut);
    let frames = track.num_frames.filter(|n| *n > 0 && alone)?;
    Some(length? as f64 * 8e-3 * f64::from(rate) / frames as f64)
}

/// The parameters of a track, as [`words`] asks for them.
type Params = AudioCodecParameters;
