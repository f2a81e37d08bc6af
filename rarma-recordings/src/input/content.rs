//! What a file is by its first bytes, for words: people rename what they should convert.

/// Kinds of files that are met under the name of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    Flac,
    Ogg,
    Mp3,
    Layer2,
    Mp4,
    Wav,
    BigEndianWav,
    Avi,
    Aiff,
    Caf,
    Adts,
    Amr,
    Asf,
    Matroska,
    Png,
    Jpeg,
    Zip,
    Pdf,
}

impl Content {
    /// By the bytes at the beginning, at least twelve of them; none: it is not known.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        let form = bytes.get(8..12);
        Some(match bytes {
            [b'f', b'L', b'a', b'C', ..] => Self::Flac,
            [b'O', b'g', b'g', b'S', ..] => Self::Ogg,
            [b'I', b'D', b'3', ..] => Self::Mp3,
            // A whole frame header, layer III: two bytes alone are met by chance.
            [0xff, b, c, ..] if b & 0xe6 == 0xe2 && c & 0xf0 != 0xf0 && c & 0x0c != 0x0c => {
                Self::Mp3
            }
            [0xff, b, c, ..] if b & 0xe6 == 0xe4 && c & 0xf0 != 0xf0 && c & 0x0c != 0x0c => {
                Self::Layer2
            }
            [0xff, 0xf0 | 0xf1 | 0xf8 | 0xf9, ..] => Self::Adts,
            [_, _, _, _, b'f', b't', b'y', b'p', ..] => Self::Mp4,
            [b'R', b'I', b'F', b'F', ..] if form == Some(b"WAVE") => Self::Wav,
            [b'R', b'I', b'F', b'F', ..] if form == Some(b"AVI ") => Self::Avi,
            [b'R', b'F', b'6', b'4', ..] => Self::Wav,
            [b'R', b'I', b'F', b'X', ..] => Self::BigEndianWav,
            [b'F', b'O', b'R', b'M', ..] => Self::Aiff,
            [b'c', b'a', b'f', b'f', ..] => Self::Caf,
            [b'#', b'!', b'A', b'M', b'R', ..] => Self::Amr,
            [0x30, 0x26, 0xb2, 0x75, ..] => Self::Asf,
            [0x1a, 0x45, 0xdf, 0xa3, ..] => Self::Matroska,
            [0x89, b'P', b'N', b'G', ..] => Self::Png,
            [0xff, 0xd8, 0xff, ..] => Self::Jpeg,
            [b'P', b'K', 3, 4, ..] => Self::Zip,
            [b'%', b'P', b'D', b'F', ..] => Self::Pdf,
            _ => return None,
        })
    }

    /// In words, as in "not a WAV file but FLAC".
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Flac => "FLAC",
            Self::Ogg => "Ogg",
            Self::Mp3 => "MP3",
            Self::Layer2 => "MPEG layer II",
            Self::Mp4 => "MPEG-4",
            Self::Wav => "WAV",
            Self::BigEndianWav => "a big-endian WAV file (RIFX)",
            Self::Avi => "an AVI video",
            Self::Aiff => "AIFF",
            Self::Caf => "CAF",
            Self::Adts => "bare AAC",
            Self::Amr => "AMR",
            Self::Asf => "WMA or WMV",
            Self::Matroska => "Matroska or WebM",
            Self::Png => "a PNG picture",
            Self::Jpeg => "a JPEG picture",
            Self::Zip => "a ZIP archive",
            Self::Pdf => "PDF",
        }
    }

    /// The name's ending under which such a file is read here; none if it is not.
    pub(super) fn ending(self) -> Option<&'static str> {
        match self {
            Self::Flac => Some(".flac"),
            Self::Ogg => Some(".ogg"),
            Self::Mp3 => Some(".mp3"),
            Self::Mp4 => Some(".m4a"),
            Self::Wav => Some(".wav"),
            _ => None,
        }
    }

    /// What to do with such a file under another kind's name.
    pub(super) fn remedy(self) -> String {
        match self.ending() {
            Some(ending) => format!("read it from a file whose name ends in {ending}"),
            None => "convert it to WAV or FLAC".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_by_their_first_bytes() {
        for (bytes, content) in [
            (&b"fLaC\0\0\0\x22"[..], Content::Flac),
            (b"\xff\xfb\x90\x64", Content::Mp3),
            (b"\xff\xf3\x44\xc4", Content::Mp3),
            (b"\xff\xfd\x84\x04", Content::Layer2),
            (b"\xff\xf1\x50\x80", Content::Adts),
            (b"\0\0\0\x1cftypM4A ", Content::Mp4),
            (b"RIFF\0\0\0\0WAVE", Content::Wav),
            (b"\xff\xd8\xff\xe0", Content::Jpeg),
        ] {
            assert_eq!(Content::of(bytes), Some(content), "{bytes:?}");
        }
        for bytes in [
            &b""[..],
            b"\xff",
            b"\xff\xff\xff\xff",
            b"RIFF",
            b"hello, world",
        ] {
            assert_eq!(Content::of(bytes), None, "{bytes:?}");
        }
    }
}
