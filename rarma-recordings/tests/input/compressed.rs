//! What phones write: read to the last bit where nothing is lost, as far as it goes where it
//! is broken, and refused in one line where it is something else.

use crate::bench::{Bench, at, opts, pcm16, tone, wav};
use crate::bytes::{Movie, flac, flac_frames, mp3};
use proptest::prelude::*;
use rarma_recordings::input::{self, Problem, ReadOptions};
use std::fs;

/// Two channels that differ, 4500 frames.
fn two() -> Vec<Vec<i16>> {
    let left = tone(4500);
    let right = left.iter().map(|x| x / 3 + 7).collect();
    vec![left, right]
}

fn scaled(samples: &[i16]) -> Vec<f64> {
    samples.iter().map(|x| f64::from(*x) / 32_768.0).collect()
}

fn second() -> ReadOptions {
    ReadOptions {
        channel: 1,
        ..opts()
    }
}

#[test]
fn flac_is_the_wav_to_the_last_bit() {
    let both = two();
    let bench = Bench::new();
    let r = bench
        .with("a.flac", &flac(44_100, &both), &second())
        .unwrap();
    assert_eq!((r.fs, r.channels, r.channel), (44_100.0, 2, 1));
    assert_eq!(
        (r.format.as_str(), r.step),
        ("FLAC, 16 bit", Some(2f64.powi(-15)))
    );
    assert!(r.samples == scaled(&both[1]), "{} samples", r.samples.len());
    assert!(r.notices.is_empty(), "{:?}", r.notices);
    let side_by_side: Vec<i16> = both[0]
        .iter()
        .zip(&both[1])
        .flat_map(|(l, r)| [*l, *r])
        .collect();
    let same = wav(1, 2, 44_100, 16, &pcm16(&side_by_side));
    let same = bench.with("a.wav", &same, &second()).unwrap();
    assert!(same.samples == r.samples);
    // The caller may know the rate better, as with a WAV.
    let r = bench
        .with("a.flac", &flac(44_100, &both), &at(48_000.0))
        .unwrap();
    assert_eq!((r.fs, r.notices.len()), (48_000.0, 1));
    let third = ReadOptions {
        channel: 2,
        ..opts()
    };
    let e = bench.refused("a.flac", &flac(44_100, &both), &third);
    assert_eq!(e.problem, Problem::Channel);
}

#[test]
fn mpeg_4_begins_where_its_edit_list_says() {
    let both = two();
    for index_first in [false, true] {
        for begins in [None, Some(0), Some(1024)] {
            let movie = Movie {
                begins,
                index_first,
                ..Movie::flac(48_000, &both)
            };
            let r = Bench::new()
                .with("a.m4a", &movie.bytes(), &second())
                .unwrap();
            let from = begins.unwrap_or(0) as usize;
            assert!(r.samples == scaled(&both[1][from..]), "{begins:?}");
            assert!(r.notices.is_empty(), "{:?}", r.notices);
        }
    }
    // The last packet says how much of it is sound.
    let mut movie = Movie::flac(48_000, &both);
    movie.packets.last_mut().unwrap().1 = 300;
    let r = Bench::new().read("a.mp4", &movie.bytes()).unwrap();
    assert!(
        r.samples == scaled(&both[0][..4300]),
        "{} samples",
        r.samples.len()
    );
}

#[test]
fn mp3_of_silence() {
    let lax = ReadOptions {
        check: false,
        ..opts()
    };
    let r = Bench::new().with("a.mp3", &mp3(200), &lax).unwrap();
    assert_eq!((r.fs, r.channels, r.samples.len()), (44_100.0, 1, 230_400));
    assert_eq!(r.format, "MP3, 128 kbit/s");
    assert!(r.samples.iter().all(|x| *x == 0.0));
    assert!(r.notices[0].contains("damping"), "{:?}", r.notices);
    // A tag before it, and junk.
    let tag = [b"ID3\x03\0\0\0\0\0\x14".as_slice(), &[0; 20], &mp3(200)].concat();
    assert_eq!(
        Bench::new()
            .with("a.mp3", &tag, &lax)
            .unwrap()
            .samples
            .len(),
        230_400
    );
    let e = Bench::new().refused("a.mp3", &mp3(10), &opts());
    assert_eq!(e.problem, Problem::Silence);
}

#[test]
fn a_file_that_was_cut_off_is_read_as_far_as_it_goes() {
    let both = two();
    let whole = flac(48_000, &both);
    let r = Bench::new()
        .read("a.flac", &whole[..whole.len() - 500])
        .unwrap();
    assert!(
        r.samples == scaled(&both[0][..4000]),
        "{} samples",
        r.samples.len()
    );
    assert_eq!(
        r.notices,
        [
            "the header says 4500 frames, the file holds 4000: analysed 4000 frames (0.08 s), the rest is cut off"
        ]
    );
    let movie = Movie {
        index_first: true,
        ..Movie::flac(48_000, &both)
    };
    let bytes = movie.bytes();
    let r = Bench::new()
        .read("a.m4a", &bytes[..bytes.len() - 500])
        .unwrap();
    assert!(
        r.samples == scaled(&both[0][..4000]),
        "{} samples",
        r.samples.len()
    );
    assert!(r.notices[0].contains("cut off"), "{:?}", r.notices);
    // The index stands at the end, where a recorder puts it: nothing is to be had.
    let bytes = Movie::flac(48_000, &both).bytes();
    let e = Bench::new().refused("a.m4a", &bytes[..bytes.len() - 900], &opts());
    assert_eq!(e.problem, Problem::Truncated);
    let e = Bench::new().refused("a.m4a", &bytes[..bytes.len() / 2], &opts());
    assert_eq!(
        (e.problem, e.place.as_str()),
        (
            Problem::Truncated,
            format!("byte {}", bytes.len() / 2).as_str()
        )
    );
    assert!(e.what.contains("index"), "{e}");
}

#[test]
fn what_cannot_be_decoded_is_missing() {
    let both = two();
    let mut movie = Movie::flac(48_000, &both);
    movie.packets[2].0.truncate(500);
    let r = Bench::new().read("a.m4a", &movie.bytes()).unwrap();
    let mut want = scaled(&both[0]);
    want[2000..3000].fill(0.0);
    assert!(r.samples == want, "{} samples", r.samples.len());
    assert_eq!((r.gaps[0].at, r.gaps[0].samples), (2000, 1000));
    assert_eq!(
        r.notices,
        ["from sample 2000 (0.042 s) on 1000 in all cannot be decoded: taken for missing"]
    );
    for packet in &mut movie.packets {
        packet.0.truncate(20);
    }
    let e = Bench::new().refused("a.m4a", &movie.bytes(), &opts());
    assert_eq!(e.problem, Problem::Unsupported);
}

#[test]
fn a_damaged_frame_leaves_the_others_where_they_are() {
    let both = two();
    let mut bytes = flac(48_000, &both);
    let frame = flac_frames(&both)[0].len();
    bytes[42 + 2 * frame + 1500] ^= 0x55;
    let r = Bench::new().read("a.flac", &bytes).unwrap();
    let mut want = scaled(&both[0]);
    want[2000..3000].fill(0.0);
    assert!(r.samples == want, "{} samples", r.samples.len());
    assert_eq!((r.gaps[0].at, r.gaps[0].samples), (2000, 1000));
    assert!(r.notices[0].contains("missing"), "{:?}", r.notices);
}

#[test]
fn names_and_contents_that_differ() {
    let contents = [
        ("flac", flac(8000, &two())),
        ("m4a", Movie::flac(8000, &two()).bytes()),
        ("mp3", mp3(10)),
        ("ogg", b"OggS\0\x02\0\0\0\0\0\0\0\0".to_vec()),
    ];
    for (name, _) in &contents {
        for (other, bytes) in contents.iter().filter(|(other, _)| other != name) {
            let e = Bench::new().refused(&format!("a.{name}"), bytes, &opts());
            assert_eq!(
                (e.problem, e.place.as_str()),
                (Problem::NotThisFormat, "byte 0")
            );
            assert!(e.remedy.contains(other), "{e}");
        }
        let name = format!("a.{name}");
        let e = Bench::new().refused(&name, b"", &opts());
        assert_eq!(e.problem, Problem::Empty);
        let noise: Vec<u8> = (0u32..3000)
            .map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8 & 0x7f)
            .collect();
        let e = Bench::new().refused(&name, &noise, &opts());
        assert_eq!(e.problem, Problem::NotThisFormat);
        let picture = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR";
        let e = Bench::new().refused(&name, picture, &opts());
        assert!(e.what.contains("PNG"), "{e}");
    }
    let e = Bench::new().refused("a.wav", &flac(8000, &two()), &opts());
    assert!(e.what.contains("FLAC"), "{e}");
}

#[test]
fn sound_that_is_not_there_or_not_read() {
    let both = two();
    let movie = |change: &dyn Fn(&mut Movie)| {
        let mut movie = Movie::flac(48_000, &both);
        change(&mut movie);
        movie.bytes()
    };
    for (name, word) in [(b"alac", "ALAC"), (b"samr", "AMR"), (b"zzzz", "zzzz")] {
        let bytes = movie(&|m| {
            m.codec = *name;
            m.inside = Vec::new();
        });
        let e = Bench::new().refused("a.m4a", &bytes, &opts());
        assert!(
            e.problem == Problem::Unsupported && e.what.contains(word),
            "{e}"
        );
    }
    let e = Bench::new().refused("a.mp4", &movie(&|m| m.handler = *b"vide"), &opts());
    assert_eq!(e.problem, Problem::NoSamples);
    assert!(e.what.contains("a video without sound"), "{e}");
    // HE-AAC, by its description.
    let asc = [0x2b, 0x8a, 0x08, 0x00];
    let mut esds = vec![0, 0, 0, 0, 3, 27, 0, 1, 0, 4, 19, 0x40, 0x15];
    esds.extend([0; 11]);
    esds.extend([5, 4]);
    esds.extend(asc);
    esds.extend([6, 1, 2]);
    let bytes = movie(&|m| {
        m.codec = *b"mp4a";
        m.inside = crate::bytes::boxed(b"esds", &esds);
    });
    let e = Bench::new().refused("a.m4a", &bytes, &opts());
    assert!(
        e.problem == Problem::Unsupported && e.what.contains("HE-AAC"),
        "{e}"
    );
}

#[test]
fn headers_that_cannot_be() {
    let both = two();
    // FLAC's own header, and MPEG-4's for it: a rate of zero, samples by the billion.
    let mut bytes = flac(48_000, &both);
    bytes[18..20].fill(0);
    bytes[20] &= 0x0f;
    let e = Bench::new().refused("a.flac", &bytes, &opts());
    assert!(matches!(e.problem, Problem::Rate | Problem::Header), "{e}");
    let mut bytes = flac(48_000, &both);
    bytes[22..26].fill(0xff);
    let r = Bench::new().read("a.flac", &bytes).unwrap();
    assert_eq!(r.samples.len(), 4500);
    assert!(r.notices[0].contains("cut off"), "{:?}", r.notices);
    let mut movie = Movie::flac(48_000, &both);
    movie.packets[1].1 = u32::MAX;
    let r = Bench::new().read("a.m4a", &movie.bytes()).unwrap();
    assert_eq!(r.samples.len(), 4500);
}

#[test]
fn a_telephone_is_named() {
    let r = Bench::new().read("call.flac", &flac(8000, &two())).unwrap();
    assert!(
        r.notices.iter().any(|n| n.contains("3400 Hz")),
        "{:?}",
        r.notices
    );
}

#[cfg(unix)]
#[test]
fn a_pipe_with_such_a_name() {
    let bench = Bench::new();
    let both = two();
    for (name, bytes) in [
        ("a.flac", flac(48_000, &both)),
        ("a.m4a", Movie::flac(48_000, &both).bytes()),
    ] {
        let path = bench.0.path().join(name);
        let made = std::process::Command::new("mkfifo")
            .arg(&path)
            .status()
            .unwrap();
        assert!(made.success());
        let end = path.clone();
        let writer = std::thread::spawn(move || fs::write(end, bytes));
        match (name, input::read(&path, &opts())) {
            ("a.flac", Ok(r)) => assert!(r.samples == scaled(&both[0])),
            ("a.m4a", Err(e)) => assert_eq!(e.problem, Problem::Unsupported),
            (_, other) => panic!("{other:?}"),
        }
        // Whoever is not read to the end is told so.
        let _ = writer.join();
    }
}

/// Files to be damaged.
fn good(kind: usize) -> (&'static str, Vec<u8>) {
    let both = two();
    match kind {
        0 => ("a.flac", flac(48_000, &both)),
        1 => ("a.m4a", Movie::flac(48_000, &both).bytes()),
        2 => (
            "a.m4a",
            Movie {
                begins: Some(100),
                index_first: true,
                ..Movie::flac(48_000, &both)
            }
            .bytes(),
        ),
        _ => ("a.mp3", mp3(12)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_files_are_read_or_refused(
        kind in 0usize..4,
        hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), any::<bool>()), 1..6),
        keep in 0.3f64..1.0,
    ) {
        let (name, mut bytes) = good(kind);
        let length = bytes.len();
        for (place, value, at_the_head) in hits {
            // Where the headers are, most of the time.
            let index_at = if kind == 1 { length - 800 } else { 0 };
            let place = if at_the_head { index_at + place.index(700) } else { place.index(length) };
            bytes[place] = value;
        }
        bytes.truncate((length as f64 * keep.max(0.6)) as usize);
        if keep > 0.6 {
            bytes.resize(length, 0);
        }
        let lax = ReadOptions { check: false, ..opts() };
        match Bench::new().with(name, &bytes, &lax) {
            Ok(r) => {
                prop_assert!(!r.samples.is_empty() && r.samples.len() < 1 << 20);
                prop_assert!(r.fs > 0.0 && r.channels > 0);
            }
            Err(e) => prop_assert!(!e.to_string().contains('\n')),
        }
    }
}

#[test]
fn frames_of_the_builder_are_whole() {
    assert_eq!(flac_frames(&two()).len(), 5);
}
