//! TDMS: every layout that the format has gives the samples that were put in, and what is not read,
//! or is not whole, is said in one line.
//!
//! The files are put together here byte by byte, after the format's description; files of another
//! implementation (npTDMS) are read in `rarma-py/tests/test_tdms.py`.

use crate::bench::{Bench, at, opts};
use proptest::prelude::*;
use rarma_recordings::input::{self, Problem, ReadOptions};

const SAYS: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW: u32 = 1 << 3;
const IN_TURN: u32 = 1 << 5;
const BIG_END: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;
const USUAL: u32 = SAYS | NEW_LIST | RAW;

const I16: u32 = 2;
const F32: u32 = 9;
const F64: u32 = 10;
const TEXT: u32 = 0x20;
const TIME: u32 = 0x44;

/// Bytes of one segment, either end first.
struct Bytes {
    bytes: Vec<u8>,
    big: bool,
}

impl Bytes {
    fn of(big: bool) -> Self {
        let bytes = Vec::new();
        Self { bytes, big }
    }

    fn put<const N: usize>(&mut self, mut little: [u8; N]) -> &mut Self {
        if self.big {
            little.reverse();
        }
        self.bytes.extend(little);
        self
    }

    fn u32(&mut self, n: u32) -> &mut Self {
        self.put(n.to_le_bytes())
    }

    fn u64(&mut self, n: u64) -> &mut Self {
        self.put(n.to_le_bytes())
    }

    fn f64(&mut self, x: f64) -> &mut Self {
        self.put(x.to_le_bytes())
    }

    fn text(&mut self, text: &str) -> &mut Self {
        self.u32(text.len() as u32);
        self.bytes.extend(text.as_bytes());
        self
    }

    /// An object with samples of a kind, and the properties that follow.
    fn object(&mut self, path: &str, kind: u32, count: u64, properties: u32) -> &mut Self {
        self.text(path)
            .u32(20)
            .u32(kind)
            .u32(1)
            .u64(count)
            .u32(properties)
    }

    fn step(&mut self, seconds: f64) -> &mut Self {
        self.text("wf_increment").u32(F64).f64(seconds)
    }

    fn word(&mut self, name: &str, text: &str) -> &mut Self {
        self.text(name).u32(TEXT).text(text)
    }
}

/// A segment of these bits.
fn segment(bits: u32, says: &[u8], raw: &[u8]) -> Vec<u8> {
    let mut head = b"TDSm".to_vec();
    head.extend(bits.to_le_bytes());
    let mut rest = Bytes::of(bits & BIG_END != 0);
    rest.u32(4713)
        .u64((says.len() + raw.len()) as u64)
        .u64(says.len() as u64);
    [&head[..], &rest.bytes, says, raw].concat()
}

fn doubles(samples: &[f64]) -> Vec<u8> {
    samples.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn wave(n: usize, channel: usize) -> f64 {
    (n as f64 * (0.3 + channel as f64)).sin() + n as f64 * 1e-3
}

fn waves(from: usize, to: usize, channel: usize) -> Vec<f64> {
    (from..to).map(|n| wave(n, channel)).collect()
}

/// Two channels of doubles at 51.2 kHz, one after the other, `chunks` of 100 samples of each.
fn two(chunks: usize) -> Vec<u8> {
    let mut says = Bytes::of(false);
    says.u32(2);
    says.object("/'Vib'/'x'", F64, 100, 2)
        .step(1.0 / 51_200.0)
        .word("unit_string", "m/s²");
    says.object("/'Vib'/'y'", F64, 100, 1).step(1.0 / 51_200.0);
    let chunk = |k: usize| {
        let channel = |c| doubles(&waves(100 * k, 100 * (k + 1), c));
        [channel(0), channel(1)].concat()
    };
    let raw: Vec<u8> = (0..chunks).flat_map(chunk).collect();
    segment(USUAL, &says.bytes, &raw)
}

fn channel(k: usize) -> ReadOptions {
    ReadOptions {
        channel: k,
        ..opts()
    }
}

#[test]
fn channels_one_after_the_other_in_chunks_that_repeat() {
    let b = Bench::new();
    // More than is handed on at once.
    let file = two(200);
    let r = b.read("a.tdms", &file).unwrap();
    assert_eq!((r.fs, r.channels, r.full_scale), (51_200.0, 2, None));
    assert_eq!(r.format, "TDMS, 0 'Vib/x' in m/s², 1 'Vib/y'");
    assert_eq!(r.samples, waves(0, 20_000, 0));
    assert_eq!(r.unit.as_deref(), Some("m/s²"));
    assert!(r.notices.is_empty(), "{:?}", r.notices);
    let r = b.with("a.tdms", &file, &channel(1)).unwrap();
    assert_eq!((r.samples, r.unit), (waves(0, 20_000, 1), None));
    let path = b.file("b.tdms", &file);
    let both = input::read_channels(&path, &opts(), None, None).unwrap();
    assert_eq!(both[1].samples, waves(0, 20_000, 1));
    let e = b.refused("a.tdms", &file, &channel(2));
    assert_eq!(e.problem, Problem::Channel);
    assert_eq!(
        e.what,
        "channel 2 asked for, but there are 2: 0 'Vib/x' in m/s², 1 'Vib/y'"
    );
}

#[test]
fn lists_go_on_from_segment_to_segment() {
    let b = Bench::new();
    // Raw data only; then as before, of one channel another number of samples; then none of the other.
    let more = segment(
        RAW,
        &[],
        &doubles(&[waves(100, 200, 0), waves(100, 200, 1)].concat()),
    );
    let mut says = Bytes::of(false);
    says.u32(1).object("/'Vib'/'x'", F64, 3, 0);
    let other = segment(
        SAYS | RAW,
        &says.bytes,
        &doubles(&[waves(200, 203, 0), waves(200, 300, 1)].concat()),
    );
    let mut says = Bytes::of(false);
    says.u32(2).text("/'Vib'/'y'").u32(u32::MAX).u32(0);
    says.text("/'Vib'/'x'").u32(0).u32(0);
    let last = segment(SAYS | RAW, &says.bytes, &doubles(&waves(203, 206, 0)));
    let mut says = Bytes::of(false);
    says.u32(1).text("/'Vib'/'y'").u32(0).u32(0);
    let anew = segment(USUAL, &says.bytes, &doubles(&waves(300, 400, 1)));
    let file = [two(1), more, other, last, anew].concat();
    let r = b.read("a.tdms", &file).unwrap();
    assert_eq!(r.samples, waves(0, 206, 0));
    let r = b.with("a.tdms", &file, &channel(1)).unwrap();
    assert_eq!(r.samples, waves(0, 400, 1));
    let path = b.file("b.tdms", &file);
    let e = input::read_channels(&path, &opts(), None, None).unwrap_err();
    assert_eq!(e.what, "'Vib/x' has 206 samples and 'Vib/y' 400");
}

#[test]
fn channels_in_turn_of_several_kinds_either_end_first() {
    let b = Bench::new();
    for big in [false, true] {
        let mut says = Bytes::of(big);
        says.u32(3);
        says.object("/'g'/'i'", I16, 3000, 1).step(0.001);
        says.object("/'g'/'t'", TIME, 3000, 0);
        says.object("/'g'/'f'", F32, 3000, 1).step(0.001);
        let mut raw = Bytes::of(big);
        for n in 0..3000i32 {
            raw.put(((7 * n % 4001 - 2000) as i16).to_le_bytes());
            raw.u64(5).u64(n as u64);
            raw.put((wave(n as usize, 0) as f32).to_le_bytes());
        }
        let bits = USUAL | IN_TURN | if big { BIG_END } else { 0 };
        let file = segment(bits, &says.bytes, &raw.bytes);
        let r = b.read("a.tdms", &file).unwrap();
        let whole = |n: i32| f64::from(7 * n % 4001 - 2000);
        assert_eq!((r.fs, r.channels), (1000.0, 2));
        assert_eq!(r.samples, (0..3000).map(whole).collect::<Vec<_>>());
        assert_eq!(
            r.notices,
            ["1 of 3 channels left out: empty, or no numbers over time"]
        );
        let r = b.with("a.tdms", &file, &channel(1)).unwrap();
        let single = |x: f64| f64::from(x as f32);
        assert_eq!(
            r.samples,
            waves(0, 3000, 0)
                .into_iter()
                .map(single)
                .collect::<Vec<_>>()
        );
    }
}

#[test]
fn scales_beside_whole_numbers_are_applied() {
    let b = Bench::new();
    let file = |kind: &str| {
        let mut says = Bytes::of(false);
        says.u32(1).object("/'g'/'c'", I16, 500, 6).step(1e-3);
        says.text("NI_Number_Of_Scales").u32(7).u32(1);
        says.word("NI_Scaling_Status", "unscaled");
        says.word("NI_Scale[0]_Scale_Type", kind);
        says.text("NI_Scale[0]_Linear_Slope").u32(F64).f64(0.25);
        says.text("NI_Scale[0]_Linear_Y_Intercept")
            .u32(F64)
            .f64(-3.0);
        let raw: Vec<u8> = (0..500i16)
            .flat_map(|n| (n * 31 % 977).to_le_bytes())
            .collect();
        segment(USUAL, &says.bytes, &raw)
    };
    let r = b.read("a.tdms", &file("Linear")).unwrap();
    let scaled = |n: i16| 0.25 * f64::from(n * 31 % 977) - 3.0;
    assert_eq!(r.samples, (0..500).map(scaled).collect::<Vec<_>>());
    let e = b.refused("a.tdms", &file("RTD"), &opts());
    assert_eq!(
        (e.problem, e.place.as_str()),
        (Problem::Unsupported, "channel 'g/c'")
    );
    assert_eq!(e.what, "a scale of the kind 'RTD' is not known here");
}

#[test]
fn a_rate_that_is_missing_or_differs() {
    let b = Bench::new();
    let file = |steps: [f64; 2]| {
        let mut says = Bytes::of(false);
        says.u32(2);
        for (path, step) in ["/'A'/'x'", "/'B'/'x'"].iter().zip(steps) {
            match step > 0.0 {
                true => says.object(path, F64, 100, 1).step(step),
                false => says.object(path, F64, 100, 0),
            };
        }
        segment(
            USUAL,
            &says.bytes,
            &doubles(&[waves(0, 100, 0), waves(0, 100, 1)].concat()),
        )
    };
    let e = b.refused("a.tdms", &file([0.0, 0.0]), &opts());
    assert_eq!(
        (e.problem, e.place.as_str()),
        (Problem::Rate, "channel 'A/x'")
    );
    assert_eq!(
        (e.what.as_str(), e.remedy.as_str()),
        (
            "no sampling rate: the property wf_increment is missing or tells none",
            "give --fs in hertz"
        )
    );
    let r = b.with("a.tdms", &file([0.0, 0.0]), &at(2500.0)).unwrap();
    assert_eq!((r.fs, r.samples), (2500.0, waves(0, 100, 0)));
    // Of several groups each channel has its own; they are numbered through.
    let mixed = file([1.0 / 48_000.0, 0.1]);
    let r = b.read("a.tdms", &mixed).unwrap();
    assert_eq!((r.fs, r.seconds), (48_000.0, 100.0 / 48_000.0));
    assert_eq!(
        r.notices,
        ["2 groups: channels are numbered through all of them, 0 'A/x', 1 'B/x'"]
    );
    let r = b.with("a.tdms", &mixed, &channel(1)).unwrap();
    assert_eq!((r.fs, r.samples), (10.0, waves(0, 100, 1)));
    let path = b.file("b.tdms", &mixed);
    let e = input::read_channels(&path, &opts(), None, None).unwrap_err();
    assert_eq!(e.what, "'A/x' has 48000 Hz and 'B/x' 10 Hz");
    let r = b.with("a.tdms", &file([0.0, 0.1]), &channel(1)).unwrap();
    assert_eq!(r.fs, 10.0);
    let e = b.refused("a.tdms", &file([0.0, 0.1]), &opts());
    assert_eq!(e.problem, Problem::Rate);
    let r = b.with("a.tdms", &mixed, &at(47_000.0)).unwrap();
    assert_eq!(
        r.notices[1],
        "header says 48000 Hz: --fs 47000 Hz used instead"
    );
}

#[test]
fn samples_of_a_card_and_of_unknown_kinds() {
    let b = Bench::new();
    let mut says = Bytes::of(false);
    says.u32(1)
        .text("/'g'/'ai0'")
        .u32(0x1269)
        .u32(u32::MAX)
        .u32(1)
        .u64(10);
    let by_index = segment(USUAL | DAQMX, &says.bytes, &[0; 40]);
    let mut says = Bytes::of(false);
    says.u32(1).object("/'g'/'ai0'", I16, 10, 0);
    let by_bit = segment(USUAL | DAQMX, &says.bytes, &[0; 40]);
    for file in [by_index, by_bit] {
        let e = b.refused("a.tdms", &file, &opts());
        assert_eq!(e.problem, Problem::Unsupported);
        assert_eq!(e.what, "raw data of a DAQmx card, which are not read");
    }
    let mut says = Bytes::of(false);
    says.u32(1).object("/'g'/'e'", 0x0b, 10, 0);
    let e = b.refused("a.tdms", &segment(USUAL, &says.bytes, &[0; 160]), &opts());
    assert_eq!(e.what, "samples of the type 0xb are not read");
    let mut says = Bytes::of(false);
    says.u32(1)
        .text("/'g'/'words'")
        .u32(28)
        .u32(TEXT)
        .u32(1)
        .u64(2)
        .u64(10)
        .u32(0);
    let e = b.refused("a.tdms", &segment(USUAL, &says.bytes, &[b'x'; 10]), &opts());
    assert_eq!(
        e.what,
        "no channel of numbers over time; 1 of other kinds, or empty"
    );
    let e = b.refused("a.tdms", b"TDSh\x0e\0\0\0", &opts());
    assert_eq!(e.remedy, "name the file that ends in .tdms");
    let e = b.refused("a.tdms", b"RIFF\0\0\0\0WAVEfmt ", &opts());
    assert_eq!(
        (e.problem, e.what.as_str()),
        (Problem::NotThisFormat, "not a TDMS file but WAV")
    );
    let e = b.refused("a.tdms", b"", &opts());
    assert_eq!(e.problem, Problem::Empty);
}

#[test]
fn a_file_that_is_cut_short_is_read_as_far_as_it_goes() {
    let b = Bench::new();
    let file = [two(2), two(3)].concat();
    let first = two(2).len();
    let said = first - 28 - 2 * 2 * 800;
    let (mut refused, mut lengths) = (0, Vec::new());
    for n in (1..file.len()).step_by(7).chain([first, first + 28]) {
        match b.with(
            "a.tdms",
            &file[..n],
            &ReadOptions {
                check: false,
                ..opts()
            },
        ) {
            Ok(r) => {
                let count = r.samples.len();
                assert_eq!(
                    r.samples,
                    [waves(0, 200, 0), waves(0, 300, 0)].concat()[..count]
                );
                assert_eq!(r.notices.is_empty(), n == first, "{n}: {:?}", r.notices);
                lengths.push(count);
            }
            Err(e) => {
                let short = matches!(e.problem, Problem::Truncated | Problem::NoSamples);
                assert!(short && n < 28 + said + 8, "{n}: {e}");
                refused += 1;
            }
        }
    }
    assert!(
        refused > 10 && lengths.is_sorted() || lengths.len() > 100,
        "{lengths:?}"
    );
    assert_eq!(lengths.iter().max(), Some(&500));
    // A chunk that is cut has more of its first channel: both are read as far as the shorter.
    let path = b.file("b.tdms", &file[..28 + said + 1600 + 800 + 80]);
    let both = input::read_channels(&path, &opts(), None, None).unwrap();
    assert_eq!((both[0].samples.len(), both[1].samples.len()), (110, 110));
    assert_eq!(both[0].notices.len(), 2, "{:?}", both[0].notices);
    // One that was never closed.
    let mut open = two(2);
    open[12..20].copy_from_slice(&u64::MAX.to_le_bytes());
    let r = b.read("a.tdms", &open).unwrap();
    assert_eq!(r.samples, waves(0, 200, 0));
    assert_eq!(
        r.notices,
        ["segment 1 was never closed by who wrote it: read as far as it goes"]
    );
}

proptest! {
    /// Whatever the bytes: samples, or one line.
    #[test]
    fn no_bytes_break_it(places in prop::collection::vec((0usize..3400, any::<u8>()), 1..12), n in 0usize..3400) {
        let mut file = [two(1), two(1)].concat();
        let last = file.len() - 1;
        for (place, byte) in places {
            file[place.min(last)] = byte;
        }
        file.truncate(n.max(28));
        let b = Bench::new();
        match b.read("a.tdms", &file) {
            Ok(r) => prop_assert!(!r.samples.is_empty()),
            Err(e) => prop_assert!(!e.to_string().contains('\n')),
        }
    }
}
