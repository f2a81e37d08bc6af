//! What is said of compressed files.

use super::super::content::Content;
use super::super::{InputError, Problem};
use super::Params;
use super::movie::Movie;
use std::io::ErrorKind;
use symphonia::core::codecs::audio::AudioCodecId;
use symphonia::core::codecs::audio::well_known::{
    CODEC_ID_AAC, CODEC_ID_AC3, CODEC_ID_ALAC, CODEC_ID_EAC3, CODEC_ID_FLAC, CODEC_ID_MP1,
    CODEC_ID_MP2, CODEC_ID_MP3, CODEC_ID_OPUS, CODEC_ID_SPEEX, CODEC_ID_VORBIS,
};
use symphonia::core::errors::Error;

/// Bit rates of MP3, kbit/s: a mean that is near one is that one and the file's tags.
const USUAL_KBIT_S: [f64; 18] = [
    8.0, 16.0, 24.0, 32.0, 40.0, 48.0, 56.0, 64.0, 80.0, 96.0, 112.0, 128.0, 144.0, 160.0, 192.0,
    224.0, 256.0, 320.0,
];

/// The rate of telephones, Hz.
const TELEPHONE_HZ: u32 = 8000;

/// A kind of file with its article.
pub(super) fn kind(named: Content) -> String {
    let article = if named == Content::Mp4 || named == Content::Mp3 || named == Content::Ogg {
        "an"
    } else {
        "a"
    };
    format!("{article} {} file", named.name())
}

/// Whether a codec gives back what it was given.
pub(super) fn lossless(codec: AudioCodecId) -> bool {
    codec == CODEC_ID_FLAC
}

/// What a codec is called.
fn name(codec: AudioCodecId) -> Option<&'static str> {
    Some(match codec {
        CODEC_ID_AAC => "AAC",
        CODEC_ID_MP3 => "MP3",
        CODEC_ID_FLAC => "FLAC",
        CODEC_ID_VORBIS => "Vorbis",
        CODEC_ID_ALAC => "ALAC",
        CODEC_ID_OPUS => "Opus",
        CODEC_ID_SPEEX => "Speex",
        CODEC_ID_AC3 => "Dolby Digital",
        CODEC_ID_EAC3 => "Dolby Digital Plus",
        CODEC_ID_MP1 => "MPEG layer I",
        CODEC_ID_MP2 => "MPEG layer II",
        _ => return None,
    })
}

/// What a sample entry of an MPEG-4 file stands for.
fn entry(code: [u8; 4]) -> String {
    match &code {
        b"alac" => "ALAC".to_owned(),
        b"Opus" => "Opus".to_owned(),
        b"samr" | b"sawb" => "AMR".to_owned(),
        b"ac-3" => "Dolby Digital".to_owned(),
        b"ec-3" => "Dolby Digital Plus".to_owned(),
        b"lpcm" | b"sowt" | b"twos" | b"in24" | b"fl32" => "bare samples (PCM)".to_owned(),
        code => format!("`{}`", code.escape_ascii()),
    }
}

/// The format for people: `MP3, 128 kbit/s`.
pub(super) fn format(
    named: Content,
    params: &Params,
    bits: Option<u32>,
    mean: Option<f64>,
    movie: Option<&Movie>,
) -> String {
    let codec = name(params.codec).unwrap_or("unknown");
    let mut out = match named {
        Content::Ogg => format!("Ogg {codec}"),
        _ if movie.is_some_and(Movie::video) => format!("sound of a video, {codec}"),
        _ => codec.to_owned(),
    };
    if lossless(params.codec) {
        if let Some(bits) = bits {
            out += &format!(", {bits} bit");
        }
    } else if let Some(mean) = mean.filter(|mean| (1.0..10_000.0).contains(mean)) {
        let near = |usual: &&f64| (mean / **usual - 1.0).abs() < 0.03;
        let usual = USUAL_KBIT_S.iter().find(near).copied();
        out += &format!(", {:.0} kbit/s", usual.unwrap_or(mean));
    }
    out
}

/// What is to be known of every such file.
pub(super) fn notices(params: &Params, rate: u32, movie: Option<&Movie>) -> Vec<String> {
    let mut out = Vec::new();
    if !lossless(params.codec) {
        out.push(format!(
            "{} leaves out what is not heard: frequencies and times of alarms hold at 128 kbit/s, \
             damping ratios less so, and the quiet gets quieter; for damping record WAV or FLAC",
            name(params.codec).unwrap_or("this codec")
        ));
    }
    if (1..=TELEPHONE_HZ).contains(&rate) {
        out.push(format!(
            "{rate} Hz, as of a telephone, which lets 300 to 3400 Hz through and may change the \
             loudness by itself: nothing outside is heard"
        ));
    }
    if movie
        .and_then(Movie::sound)
        .is_some_and(|track| track.edits.len() > 1)
    {
        out.push("an edit list rearranges the sound: read as it was recorded".to_owned());
    }
    out
}

/// A header that cannot be.
pub(super) fn header(what: impl Into<String>) -> InputError {
    InputError::new(
        Problem::Header,
        "header",
        what,
        "the header is damaged: record or convert again",
    )
}

/// Why the file cannot be taken apart.
pub(super) fn not_opened(named: Content, why: &Error) -> InputError {
    match why {
        Error::IoError(why) if why.kind() == ErrorKind::UnexpectedEof => InputError::new(
            Problem::Truncated,
            "header",
            "the file ends inside its header",
            "copy it again; nothing can be saved from it",
        ),
        Error::IoError(why) => InputError::from_io(why),
        _ if named == Content::Mp3 => InputError::new(
            Problem::NotThisFormat,
            "byte 0",
            "not an MP3 file: no frame of sound in it",
            "check that it is the right file, or convert it to WAV",
        ),
        _ => header("it contradicts itself"),
    }
}

/// Sound that cannot be decoded here.
pub(super) fn unsupported(movie: Option<&Movie>, params: Option<&Params>) -> InputError {
    let known = params.map(|params| params.codec);
    let what = match (known, movie.and_then(Movie::sound)) {
        (Some(CODEC_ID_AAC), _) => {
            "HE-AAC, or AAC with more than two channels: only AAC-LC is read here".to_owned()
        }
        (Some(codec), _) if name(codec).is_some() => {
            format!(
                "{}, which is not read here",
                name(codec).unwrap_or_default()
            )
        }
        (_, Some(track)) => format!("{}, which is not read here", entry(track.codec)),
        _ => "a codec that is not read here".to_owned(),
    };
    InputError::new(
        Problem::Unsupported,
        "sound track",
        what,
        "convert it to WAV or FLAC, or let the recorder write AAC-LC, MP3, FLAC or WAV",
    )
}
