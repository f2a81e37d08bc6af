//! Recordings: everything that `monitor` and its like read.

use super::link::{Piece, SESSION, framed, head_words, pieces};
use crate::{Target, check, scratch};
use rarma_recordings::input::{self, ReadOptions, Recording};
use std::path::Path;

pub(super) const WAV: Target = Target {
    name: "wav",
    reads: "recordings, WAV",
    run: |bytes| {
        for options in variants() {
            read("case.wav", bytes, &options);
        }
    },
    words: || {
        let names = [
            "RIFF", "RF64", "WAVE", "fmt ", "data", "ds64", "LIST", "fact",
        ];
        let numbers = [[1, 0], [3, 0], [32, 0], [64, 0], [24, 0]];
        let numbers = numbers.map(|n: [u8; 2]| n.map(char::from).iter().collect::<String>());
        names
            .map(str::to_owned)
            .into_iter()
            .chain(numbers)
            .collect()
    },
};

pub(super) const TABLE: Target = Target {
    name: "table",
    reads: "recordings, CSV",
    run: |bytes| {
        for options in variants() {
            read("case.csv", bytes, &options);
        }
    },
    words: || {
        [
            "# fs = ", "Hz", "time", "t_ms", "(us)", "µs", "nan", "inf", "1e308", "-0", "\u{feff}",
        ]
        .map(str::to_owned)
        .to_vec()
    },
};

pub(super) const TDMS: Target = Target {
    name: "tdms",
    reads: "recordings, TDMS",
    run: |bytes| {
        for options in variants() {
            read("case.tdms", bytes, &options);
        }
    },
    words: || {
        let names = [
            "TDSm",
            "TDSh",
            "/'g'/'x'",
            "wf_increment",
            "wf_xunit_string",
            "unit_string",
            "NI_Number_Of_Scales",
            "NI_Scale[0]_Scale_Type",
            "NI_Scale[0]_Linear_Slope",
            "Linear",
            "Polynomial",
        ];
        let bits = [0x0e, 0x2e, 0x4e, 0x6e, 0x8e, 0x08, 0x0a, 0x20, 0xff];
        let bits = bits.map(|b: u8| [b, 0, 0, 0].map(char::from).iter().collect());
        names.map(str::to_owned).into_iter().chain(bits).collect()
    },
};

pub(super) const RAW: Target = Target {
    name: "raw",
    reads: "recordings, raw floats",
    run: |bytes| {
        for name in ["case.f32", "case.f64"] {
            for options in variants() {
                let Some(recording) = read(name, bytes, &options) else {
                    continue;
                };
                // Written out as doubles, it is the same recording.
                let out: Vec<u8> = recording
                    .samples
                    .iter()
                    .flat_map(|x| x.to_le_bytes())
                    .collect();
                let again = read("again.f64", &out, &options).expect("what was read is sound");
                // By their bits: NaN is not equal to itself.
                let bits =
                    |r: &Recording| -> Vec<u64> { r.samples.iter().map(|x| x.to_bits()).collect() };
                assert_eq!(bits(&again), bits(&recording));
                assert_eq!(again.fs, recording.fs);
            }
        }
    },
    words: || ["\0\0\0A", "\0\0\0\0\0\0\0@"].map(str::to_owned).to_vec(),
};

pub(super) const FRAMES: Target = Target {
    name: "record",
    reads: "records of a box, .frames",
    run: |bytes| {
        // As they are, and as what a box would have sent.
        let sent: Vec<u8> = pieces(bytes)
            .into_iter()
            .enumerate()
            .flat_map(|(k, piece)| match piece {
                Piece::Bytes(bytes) => bytes.to_vec(),
                Piece::Body(body) => framed(body, SESSION, k as u32).unwrap_or_default(),
                Piece::Pause(_) => Vec::new(),
            })
            .collect();
        for options in variants() {
            read("case.frames", bytes, &options);
            read("case.frames", &sent, &options);
        }
    },
    words: head_words,
};

/// As a file says it, with a rate from outside, and the second channel.
fn variants() -> [ReadOptions; 3] {
    let plain = ReadOptions::default();
    [
        plain.clone(),
        ReadOptions {
            fs: Some(8000.0),
            check: false,
            ..plain.clone()
        },
        ReadOptions {
            channel: 1,
            fs: Some(48_000.0),
            ..plain
        },
    ]
}

fn read(name: &str, bytes: &[u8], options: &ReadOptions) -> Option<Recording> {
    let path = scratch::file(name, bytes);
    match input::read(&path, options) {
        Ok(recording) => {
            sound(&path, &recording, options);
            Some(recording)
        }
        Err(why) => {
            check::refusal(&path, &why);
            None
        }
    }
}

/// What is promised of every recording that is not refused.
fn sound(path: &Path, r: &Recording, options: &ReadOptions) {
    assert_eq!(r.path, path);
    assert!(!r.samples.is_empty() && r.channel < r.channels);
    assert!(r.fs.is_finite() && r.fs > 0.0, "rate {}", r.fs);
    assert!(r.seconds > 0.0 && r.seconds.is_finite(), "{} s", r.seconds);
    assert!(!options.check || r.samples.iter().all(|x| x.is_finite()));
    for notice in &r.notices {
        check::one_line(notice);
    }
}
