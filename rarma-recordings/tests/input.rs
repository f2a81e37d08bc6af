//! Promise: every recording is read as it is, or refused in one line that names
//! the file, the place, the reason and what to do.

// Files that are broken on purpose.
#![allow(clippy::disallowed_methods)]

#[path = "input/bench.rs"]
mod bench;
#[cfg(feature = "codecs")]
#[path = "input/bytes.rs"]
mod bytes;
#[cfg(feature = "codecs")]
#[path = "input/compressed.rs"]
mod compressed;
#[path = "input/formats.rs"]
mod formats;
#[path = "input/tdms.rs"]
mod tdms;

use bench::{Bench, at, chunk, fmt, opts, pcm16, riff, tone, wav};
use rarma_recordings::input::{self, Problem, ReadOptions};
use std::fs;

#[test]
fn missing_file() {
    let e = input::read(&Bench::new().0.path().join("no.wav"), &opts()).unwrap_err();
    assert_eq!(e.problem, Problem::NotFound);
    assert!(e.to_string().contains("no.wav: open: no such file ("));
}

#[test]
fn empty_file() {
    for name in ["a.wav", "a.csv", "a.f32"] {
        let e = Bench::new().refused(name, b"", &at(1.0));
        assert_eq!(e.problem, Problem::Empty);
    }
}

#[test]
fn directory() {
    let e = input::read(Bench::new().0.path(), &opts()).unwrap_err();
    assert_eq!(e.problem, Problem::Directory);
}

#[test]
fn not_a_wav() {
    let e = Bench::new().refused("a.wav", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", &opts());
    assert_eq!(e.problem, Problem::NotThisFormat);
    assert!(e.what.contains("PNG"));
    let e = Bench::new().refused("a.wav", b"RIFF\x10\0\0\0AVI LIST", &opts());
    assert_eq!(e.problem, Problem::NotThisFormat);
    let e = Bench::new().refused("a.csv", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", &opts());
    assert_eq!(e.problem, Problem::NotThisFormat);
}

#[test]
fn unknown_extension() {
    for name in ["a.opus", "a"] {
        let e = Bench::new().refused(name, b"x", &opts());
        assert_eq!(e.problem, Problem::Extension);
    }
}

#[test]
fn truncated_header_at_every_byte() {
    let whole = wav(1, 1, 5000, 16, &pcm16(&tone(50)));
    for n in 1..44 {
        let e = Bench::new().refused("a.wav", &whole[..n], &opts());
        assert_eq!(e.problem, Problem::Truncated, "{n}: {e}");
    }
}

#[test]
fn truncated_data() {
    let whole = wav(1, 1, 5000, 16, &pcm16(&tone(5000)));
    let r = Bench::new().read("a.wav", &whole[..44 + 2001]).unwrap();
    assert_eq!(r.samples.len(), 1000);
    assert_eq!(
        r.notices,
        ["data chunk says 5000 frames, file holds 1000: \
          analysed 1000 (0.20 s), the rest is cut off"]
    );
    let e = Bench::new().refused("a.wav", &whole[..45], &opts());
    assert_eq!(e.problem, Problem::Truncated);
    let e = Bench::new().refused("a.wav", &wav(1, 1, 5000, 16, b""), &opts());
    assert_eq!(e.problem, Problem::NoSamples);
}

#[test]
fn no_channels_and_no_rate() {
    let data = pcm16(&tone(100));
    let e = Bench::new().refused("a.wav", &wav(1, 0, 5000, 16, &data), &opts());
    assert_eq!(e.problem, Problem::Channel);
    let silent = wav(1, 1, 0, 16, &data);
    let e = Bench::new().refused("a.wav", &silent, &opts());
    assert_eq!(e.problem, Problem::Rate);
    // The caller may know better.
    let r = Bench::new().with("a.wav", &silent, &at(12.5)).unwrap();
    assert_eq!((r.fs, r.notices.len()), (12.5, 1));
    for fs in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let e = Bench::new().refused("a.f32", &[0; 8], &at(fs));
        assert_eq!(e.problem, Problem::Rate);
    }
}

#[test]
fn unsupported_encodings() {
    for (tag, bits) in [
        (2, 4),
        (6, 8),
        (7, 8),
        (0x55, 16),
        (1, 64),
        (3, 16),
        (3, 80),
        (1, 0),
    ] {
        let e = Bench::new().refused("a.wav", &wav(tag, 1, 8000, bits, &[1; 64]), &opts());
        assert_eq!(e.problem, Problem::Unsupported, "tag {tag}, {bits} bits");
    }
    let mut odd = fmt(1, 2, 8000, 16);
    odd[12] = 3;
    let file = riff(&[chunk(b"fmt ", &odd), chunk(b"data", &[1; 64])]);
    let e = Bench::new().refused("a.wav", &file, &opts());
    assert_eq!(e.problem, Problem::Header);
    let file = riff(&[chunk(b"data", &[1; 64])]);
    let e = Bench::new().refused("a.wav", &file, &opts());
    assert_eq!(e.problem, Problem::Header);
}

#[test]
fn channel_that_is_not_there() {
    let two = ReadOptions {
        channel: 2,
        fs: Some(9.0),
        ..opts()
    };
    let stereo = wav(1, 2, 5000, 16, &pcm16(&tone(100)));
    let e = Bench::new().refused("a.wav", &stereo, &two);
    assert_eq!(e.problem, Problem::Channel);
    assert!(e.what.contains("numbered 0 to 1"), "{e}");
    for (name, bytes) in [
        ("a.csv", &b"0,1\n1,2\n"[..]),
        ("a.csv", b"1\n2\n"),
        ("a.f32", &[0; 8]),
    ] {
        let e = Bench::new().refused(name, bytes, &two);
        assert_eq!(e.problem, Problem::Channel);
    }
}

#[test]
fn samples_that_are_no_numbers() {
    let mut x: Vec<f32> = (0..1000).map(|i| (i as f32 * 0.3).sin()).collect();
    x[250] = f32::NAN;
    x[251] = f32::INFINITY;
    let bytes: Vec<u8> = x.iter().flat_map(|v| v.to_le_bytes()).collect();
    let e = Bench::new().refused("a.wav", &wav(3, 1, 1000, 32, &bytes), &opts());
    assert_eq!(e.problem, Problem::NonFinite);
    assert_eq!(e.place, "sample 250 (0.25 s)");
    assert!(e.what.contains("NaN") && e.what.contains("2"), "{e}");
    let e = Bench::new().refused("a.csv", b"1\ninf\n3\n", &at(1.0));
    assert_eq!(e.problem, Problem::NonFinite);
    assert!(e.what.contains("infinite"));
    let lax = ReadOptions {
        check: false,
        ..opts()
    };
    let r = Bench::new()
        .with("a.wav", &wav(3, 1, 1000, 32, &bytes), &lax)
        .unwrap();
    assert_eq!(input::check(&r).unwrap_err().problem, Problem::NonFinite);
}

#[test]
fn silence() {
    let e = Bench::new().refused("a.wav", &wav(1, 1, 5000, 16, &[0; 200]), &opts());
    assert_eq!(e.problem, Problem::Silence);
    assert!(e.what.contains("zero"));
    let e = Bench::new().refused("a.csv", b"2.5\n2.5\n2.5\n", &at(1.0));
    assert_eq!(e.problem, Problem::Silence);
    assert!(e.what.contains("constant 2.5"));
}

#[test]
fn clipping() {
    let sine =
        |gain: f64| -> Vec<f64> { (0..5000).map(|i| gain * (i as f64 * 0.31).sin()).collect() };
    let as_pcm = |x: &[f64]| -> Vec<u8> {
        let v: Vec<i16> = x.iter().map(|v| (v * 32768.0) as i16).collect();
        wav(1, 1, 5000, 16, &pcm16(&v))
    };
    let as_float = |x: &[f64]| -> Vec<u8> {
        let v: Vec<u8> = x.iter().flat_map(|v| v.to_le_bytes()).collect();
        wav(3, 1, 5000, 64, &v)
    };
    let e = Bench::new().refused("a.wav", &as_pcm(&sine(1.3)), &opts());
    assert_eq!(e.problem, Problem::Clipped);
    assert!(e.place.starts_with("sample 3 ("), "{e}");
    assert!(
        e.what.contains(" % of the samples") && e.remedy.contains("gain"),
        "{e}"
    );
    Bench::new().read("a.wav", &as_pcm(&sine(0.9))).unwrap();

    // A float recording clipped somewhere below its largest number.
    let flat: Vec<f64> = sine(1.3).iter().map(|v| v.clamp(-0.8, 0.8)).collect();
    let e = Bench::new().refused("a.wav", &as_float(&flat), &opts());
    assert_eq!(e.problem, Problem::Clipped);
    Bench::new().read("a.wav", &as_float(&sine(1.3))).unwrap();

    // Healthy but coarse: peaks are flat for many samples, entered in one step.
    let coarse: Vec<f64> = (0..5000)
        .map(|i| (8.0 * (i as f64 * 0.01).sin()).round() / 8.0)
        .collect();
    Bench::new().read("a.wav", &as_float(&coarse)).unwrap();
    // A square wave has no slope to lose.
    let square: Vec<f64> = (0..5000).map(|i| f64::from(i / 50 % 2)).collect();
    Bench::new().read("a.wav", &as_float(&square)).unwrap();
}

#[test]
fn csv_holes_name_their_line() {
    for (text, line) in [
        ("t,x\n0,1\n1,\n2,3\n", "line 3"),
        ("0,1\n1\n2,3\n", "line 2"),
        ("0,1\n1,2\n\n2,3\n", "line 3"),
        ("# c\n0,1\n,2\n2,3\n", "line 3"),
        (",\n0,1\n", "line 1"),
    ] {
        let e = Bench::new().refused("a.csv", text.as_bytes(), &opts());
        assert_eq!(
            (e.problem, e.place.as_str()),
            (Problem::Hole, line),
            "{text:?}"
        );
    }
    for (text, line) in [("0,1\n1,x2\n", "line 2"), ("t,x\n0,1\n1,2,3\n", "line 3")] {
        let e = Bench::new().refused("a.csv", text.as_bytes(), &opts());
        assert_eq!((e.problem, e.place.as_str()), (Problem::NotANumber, line));
    }
    for text in ["t,x\n", "# only words\n", "\n\n"] {
        let e = Bench::new().refused("a.csv", text.as_bytes(), &opts());
        assert_eq!(e.problem, Problem::NoSamples);
    }
}

#[test]
fn csv_time_must_advance_in_equal_steps() {
    for (text, line) in [
        ("0,1\n1,2\n1,3\n2,4\n", "line 3"),
        ("0,1\n1,2\n0.5,3\n", "line 3"),
        ("0,1\n1.00,2\n2.00,3\n5.00,4\n6.00,5\n", "line 4"),
        ("0,1\n1.000,2\n2.000,3\n3.050,4\n4.050,5\n", "line 4"),
        ("0,1\ninf,2\n", "line 2"),
    ] {
        let e = Bench::new().refused("a.csv", text.as_bytes(), &opts());
        assert_eq!(
            (e.problem, e.place.as_str()),
            (Problem::Time, line),
            "{text:?}"
        );
    }
    let e = Bench::new().refused("a.csv", b"0,1\n1,2\n", &at(2.0));
    assert_eq!(e.problem, Problem::Rate);
    let e = Bench::new().refused("a.csv", b"0,1\n", &opts());
    assert_eq!(e.problem, Problem::Rate);
}

#[test]
fn raw_needs_a_rate_and_whole_numbers() {
    let e = Bench::new().refused("a.f32", &[0; 8], &opts());
    assert_eq!(e.problem, Problem::Rate);
    let e = Bench::new().refused("a.f64", &[0; 12], &at(1.0));
    assert_eq!(
        (e.problem, e.place.as_str()),
        (Problem::Truncated, "byte 8")
    );
}

#[cfg(unix)]
#[test]
fn permission_denied() {
    use std::os::unix::fs::PermissionsExt;
    let b = Bench::new();
    let path = b.file("a.wav", &wav(1, 1, 5000, 16, &pcm16(&tone(9))));
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::File::open(&path).is_ok() {
        eprintln!("SKIPPED permission_denied: this user may read everything");
        return;
    }
    let e = input::read(&path, &opts()).unwrap_err();
    assert_eq!(e.problem, Problem::Permission);
}
