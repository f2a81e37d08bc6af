//! What is read is what was written, in every format, and no bytes panic.

use crate::bench::{Bench, at, chunk, fmt, opts, pcm16, riff, tone, wav};
use proptest::prelude::*;
use rarma_recordings::input::{self, Problem, ReadOptions, Recording};

#[test]
fn a_header_of_a_csv_tells_units() {
    let b = Bench::new();
    let unit = |bytes: &[u8], channel: usize| {
        let options = ReadOptions { channel, ..opts() };
        b.with("a.csv", bytes, &options).unwrap().unit
    };
    let two = "time (ms),a (m/s²),b\n0,1,4\n2,2,5\n".as_bytes();
    assert_eq!(unit(two, 0).as_deref(), Some("m/s²"));
    assert_eq!(unit(two, 1), None);
    let one = b"# fs = 100\nleft force (N)\n1\n2\n";
    assert_eq!(unit(one, 0).as_deref(), Some("N"));
    for none in ["x()", "x (N) left", "x"] {
        let text = format!("# fs = 100\n{none}\n1\n2\n");
        assert_eq!(unit(text.as_bytes(), 0), None, "{none}");
    }
    assert_eq!(unit(b"# fs = 100\n1\n2\n", 0), None);
}

#[test]
fn csv_forms() {
    let b = Bench::new();
    let one = ReadOptions {
        channel: 1,
        ..opts()
    };
    let r = b
        .read("a.csv", b"# fs = 5000\nx\n1\n-2\n# note\n3e-1\n\n")
        .unwrap();
    assert_eq!((r.fs, r.samples), (5000.0, vec![1.0, -2.0, 0.3]));
    let r = b
        .with("a.csv", b"# fs: 5000 Hz\n1\n2\n", &at(100.0))
        .unwrap();
    assert_eq!((r.fs, r.notices.len()), (100.0, 1));
    let r = b
        .with(
            "a.csv",
            b"\xef\xbb\xbft,x,y\r\n0.0,1,4\r\n0.1,2,5\r\n",
            &one,
        )
        .unwrap();
    assert_eq!((r.fs, r.channels, r.samples), (10.0, 2, vec![4.0, 5.0]));
    let r = b.read("a.csv", b"0,000;1,5\n0,001;2,5\n").unwrap();
    assert_eq!((r.fs, r.samples), (1000.0, vec![1.5, 2.5]));
    let r = b.read("a.csv", b"time (ms),x\n0,1\n2,2\n").unwrap();
    assert_eq!((r.fs, r.seconds, r.full_scale), (500.0, 0.004, None));
    let e = b.refused("a.csv", b"1\n2\n", &opts());
    assert_eq!(e.problem, Problem::Rate);
    let e = b.refused("a.csv", b"# fs = 0\n1\n2\n", &opts());
    assert_eq!((e.problem, e.place.as_str()), (Problem::Rate, "line 1"));
}

#[test]
fn wav_oddities() {
    let b = Bench::new();
    let x = tone(101);
    let data = pcm16(&x);
    let head = || chunk(b"fmt ", &fmt(1, 1, 12, 16));
    let same = |r: &Recording| {
        assert_eq!(r.samples.len(), x.len());
        assert_eq!(r.samples[7], f64::from(x[7]) / 32768.0);
        assert_eq!((r.fs, r.full_scale), (12.0, Some(1.0)));
    };

    // Chunks before, between and after; odd ones with and without padding.
    let odd = chunk(b"LIST", b"abc");
    let unpadded = odd[..odd.len() - 1].to_vec();
    for extra in [odd, unpadded] {
        let tail = chunk(b"id3 ", b"xy");
        let r = b.read(
            "a.wav",
            &riff(&[extra.clone(), head(), extra, chunk(b"data", &data), tail]),
        );
        let r = r.unwrap();
        same(&r);
        assert!(r.notices.is_empty());
    }

    // Sizes as streaming writers leave them.
    for size in [0, u32::MAX] {
        let mut file = riff(&[head(), chunk(b"data", &data)]);
        file[4..8].copy_from_slice(&size.to_le_bytes());
        file[40..44].copy_from_slice(&size.to_le_bytes());
        let r = b.read("a.wav", &file).unwrap();
        same(&r);
        assert!(r.notices[0].contains("streamed"));
    }
    let mut file = riff(&[head(), chunk(b"data", &data)]);
    file[40..44].copy_from_slice(&0x7FFF_F000_u32.to_le_bytes());
    same(&b.read("a.wav", &file).unwrap());

    // RF64 keeps its true size elsewhere.
    let mut ds = vec![0; 28];
    ds[8..16].copy_from_slice(&(data.len() as u64).to_le_bytes());
    let mut file = riff(&[
        chunk(b"ds64", &ds),
        head(),
        chunk(b"data", &data),
        vec![9; 64],
    ]);
    file[..8].copy_from_slice(b"RF64\xff\xff\xff\xff");
    let data_size = 12 + 36 + 24 + 4;
    file[data_size..data_size + 4].copy_from_slice(&[0xff; 4]);
    let r = b.read("a.wav", &file).unwrap();
    same(&r);
    assert!(r.notices.is_empty());

    // Extensible: 20 of 24 bits.
    let mut ext = fmt(0xFFFE, 1, 12, 24);
    ext.extend([22, 0, 20, 0, 0, 0, 0, 0]);
    ext.extend(b"\x01\0\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71");
    let data: Vec<u8> = x
        .iter()
        .flat_map(|v| (i32::from(*v) << 8).to_le_bytes()[..3].to_vec())
        .collect();
    let r = b
        .read(
            "a.wav",
            &riff(&[chunk(b"fmt ", &ext), chunk(b"data", &data)]),
        )
        .unwrap();
    same(&r);
    assert_eq!(r.step, Some(2_f64.powi(-19)));
}

#[test]
fn files_of_another_writer() {
    let b = Bench::new();
    let path = b.0.path().join("hound.wav");
    let spec = hound::WavSpec {
        channels: 2,
        sample_rate: 48_000,
        bits_per_sample: 24,
        sample_format: hound::SampleFormat::Int,
    };
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for i in 0..100 {
        writer.write_sample(i * 1000).unwrap();
        writer.write_sample(i * -2000).unwrap();
    }
    writer.finalize().unwrap();
    let right = ReadOptions {
        channel: 1,
        ..opts()
    };
    let r = input::read(&path, &right).unwrap();
    assert_eq!((r.fs, r.channels, r.samples.len()), (48_000.0, 2, 100));
    assert_eq!(r.samples[3], -6000.0 / 8_388_608.0);
    assert_eq!(r.samples_f32()[3], -6000.0 / 8_388_608.0);
}

/// Every format says back what was written, sample for sample.
fn round_trips(x: &[i32], rate: u32) {
    let b = Bench::new();
    let lax = ReadOptions {
        fs: Some(rate.into()),
        check: false,
        ..opts()
    };
    let check = |name: &str, bytes: &[u8], want: Vec<f64>| {
        let r = b.with(name, bytes, &lax).unwrap();
        assert_eq!(r.samples, want, "{name}");
        assert_eq!(r.fs, f64::from(rate));
        assert!(r.notices.is_empty(), "{:?}", r.notices);
    };
    let scaled = |bits: u32| -> Vec<f64> {
        let shift = 32 - bits;
        x.iter()
            .map(|v| f64::from(v >> shift) / 2_f64.powi(bits as i32 - 1))
            .collect()
    };
    for bits in [16_u16, 24, 32] {
        let n = usize::from(bits / 8);
        let data: Vec<u8> = x
            .iter()
            .flat_map(|v| v.to_le_bytes()[4 - n..].to_vec())
            .collect();
        check("a.wav", &wav(1, 1, rate, bits, &data), scaled(bits.into()));
    }
    let data: Vec<u8> = x.iter().map(|v| ((v >> 24) + 128) as u8).collect();
    check("a.wav", &wav(1, 1, rate, 8, &data), scaled(8));

    let single: Vec<f32> = x.iter().map(|&v| v as f32 * 1e-3).collect();
    let want: Vec<f64> = single.iter().map(|&v| v.into()).collect();
    let data: Vec<u8> = single.iter().flat_map(|v| v.to_le_bytes()).collect();
    check("a.wav", &wav(3, 1, rate, 32, &data), want.clone());
    check("a.f32", &data, want);

    let double: Vec<f64> = x.iter().map(|&v| f64::from(v) / 3.0).collect();
    let data: Vec<u8> = double.iter().flat_map(|v| v.to_le_bytes()).collect();
    check("a.wav", &wav(3, 1, rate, 64, &data), double.clone());
    check("a.f64", &data, double.clone());
    let text: String = double.iter().map(|v| format!("{v}\n")).collect();
    check("a.csv", text.as_bytes(), double.clone());
    if double.len() > 1 {
        let fs = f64::from(rate);
        let line = |(i, v): (usize, &f64)| format!("{},{v}\n", i as f64 / fs);
        let text: String = double.iter().enumerate().map(line).collect();
        check("a.csv", text.as_bytes(), double);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_bytes_are_read_or_refused(
        bytes in proptest::collection::vec(any::<u8>(), 0..400),
        cut in 0_usize..60,
        fs in proptest::option::of(1.0..1e5),
        channel in 0_usize..3,
    ) {
        let b = Bench::new();
        let opts = ReadOptions { fs, channel, ..ReadOptions::default() };
        for name in ["a.wav", "a.csv", "a.f32", "a.f64"] {
            let _ = b.with(name, &bytes, &opts);
        }
        // The same behind a header that begins well.
        let mut file = wav(1, 1, 5000, 16, &[]);
        file.truncate(cut.max(12));
        file.extend(&bytes);
        let _ = b.with("a.wav", &file, &opts);
        let mut file = wav(1, 2, 5000, 24, &bytes);
        if let (Some(slot), Some(byte)) = (file.get_mut(cut), bytes.first()) {
            *slot = *byte;
        }
        let _ = b.with("a.wav", &file, &opts);
    }

    #[test]
    fn any_text_is_read_or_refused(text in "[0-9.,;eE+# \t\nfsxna=-]{0,200}") {
        let _ = Bench::new().with("a.csv", text.as_bytes(), &opts());
    }

    #[test]
    fn what_is_written_is_read(
        x in proptest::collection::vec(any::<i32>(), 1..60),
        rate in 1_u32..200_000,
    ) {
        round_trips(&x, rate);
    }
}
