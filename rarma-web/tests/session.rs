//! Promise: what the page is told of a sound is what the command says of it, however it comes in
//! blocks; what is missing is counted and said; what cannot be is refused with what to do.

use rarma_box::wire::MonitorJob;
use rarma_cli::commands::{listen, simulate};
use rarma_cli::record::{State, Summary};
use rarma_core::monitor::MonitorConfig;
use rarma_scenarios::scenario;
use rarma_web::{Opened, Session, Settings};

const RPM: f64 = 1680.0;
const TEETH: u32 = 6;

fn demonstration() -> (Vec<f32>, f64) {
    let loaded = scenario::load("chatter-onset", None).expect("it is shipped");
    let played = simulate(&loaded).expect("it can be cut");
    (
        played.samples.iter().map(|x| *x as f32).collect(),
        played.fs,
    )
}

fn settings(fs: f64) -> Settings {
    Settings {
        name: "microphone".to_owned(),
        fs,
        full_scale: Some(1.0),
        rpm: Some(RPM),
        teeth: Some(TEETH),
        band: None,
        order: None,
    }
}

fn by_the_command(samples: &[f32], fs: f64) -> Summary {
    let job = MonitorJob {
        monitor: MonitorConfig {
            full_scale: Some(1.0),
            spindle_hz: Some(RPM / 60.0),
            teeth: Some(TEETH),
            ..MonitorConfig::new(fs)
        },
        channel: 0,
        every_s: 0.01,
    };
    let run = listen(&job, samples.iter().copied(), |_| {});
    run.expect("settings are sound").summary
}

#[test]
fn live_sound_in_blocks_is_called_as_the_command_calls_it() {
    let (samples, fs) = demonstration();
    let expected = by_the_command(&samples, fs);
    let mut page = Session::new(settings(fs), true, true, None).expect("settings");
    let mut thread = Session::new(settings(fs), true, false, None).expect("settings");
    let mut urgent = 0;
    for block in samples.chunks(128) {
        urgent += u32::from(thread.push(block));
    }
    for block in samples.chunks(2048) {
        page.push(block);
    }
    for session in [&page, &thread] {
        let summary = session.summary().expect("a record");
        for (alarm, other) in summary.alarms.iter().zip(&expected.alarms) {
            assert_eq!(
                (alarm.on, alarm.off, alarm.f),
                (other.on, other.off, other.f)
            );
        }
        assert_eq!(summary.alarms.len(), expected.alarms.len());
    }
    assert!((4..60).contains(&urgent), "told at once {urgent} times");
    let heard = page.heard();
    assert_eq!((heard.alarms_so_far, heard.missing.gaps), (1, 0));
    assert!(heard.points.len() > 150 && heard.level.is_some_and(|level| !level.silent));
    assert!(page.heard().points.is_empty(), "handed on once");
    assert!(
        page.advice()
            .expect("advice")
            .concat()
            .contains("1/min instead of")
    );
    let report = page.report(1.8e9).expect("a page");
    assert!(report.contains("Chatter at") && report.contains("2027-01-15"));
    assert!(thread.report(0.0).is_err(), "without pictures");
}

#[test]
fn what_is_missing_is_told_and_is_no_verdict() {
    let (samples, fs) = demonstration();
    let mut session = Session::new(settings(fs), true, true, None).expect("settings");
    session.missing(1000);
    session.push(&[0.0; 4000]);
    assert!(
        !session.heard().begun && session.heard().t == 0.0,
        "not yet"
    );
    session.push(&samples[..(2.0 * fs) as usize]);
    session.push(&[0.0; 480]);
    session.push(&samples[(2.0 * fs) as usize..(2.02 * fs) as usize]);
    assert_eq!(session.heard().state, Some(State::Invalid));
    session.push(&samples[(2.02 * fs) as usize..(3.0 * fs) as usize]);
    session.missing(24_000);
    session.push(&samples[(3.5 * fs) as usize..(4.0 * fs) as usize]);
    let heard = session.heard();
    // One of the zeros may be a sample.
    assert_eq!(heard.missing.gaps, 2, "{:?}", heard.missing);
    assert!(
        (24_480..24_490).contains(&heard.missing.samples),
        "{:?}",
        heard.missing
    );
    assert_eq!(heard.alarms_so_far, 0, "{:?}", heard.alarms);
    let report = session.report(0.0).expect("a page");
    assert!(
        report.contains("0.510 s in 2 gaps"),
        "the note of what is missing"
    );
}

#[test]
fn the_speed_may_change_and_must_be_one() {
    let (samples, fs) = demonstration();
    let unknown = Settings {
        rpm: None,
        ..settings(fs)
    };
    let mut session = Session::new(unknown, true, true, None).expect("settings");
    let why = session.tell_speed(0.0).expect_err("no speed").to_string();
    assert!(why.contains("write 0.06 to 300000"), "{why}");
    session.tell_speed(RPM).expect("a speed");
    session.push(&samples[..(1.0 * fs) as usize]);
    let rpm = session.heard().spindle.and_then(|spindle| spindle.rpm);
    assert!(
        rpm.is_some_and(|rpm| (rpm / RPM - 1.0).abs() < 0.03),
        "{rpm:?}"
    );
    for (odd, says) in [
        (
            Settings {
                rpm: Some(-1.0),
                ..settings(fs)
            },
            "rpm",
        ),
        (
            Settings {
                band: Some((2000.0, 300.0)),
                ..settings(fs)
            },
            "band",
        ),
        (
            Settings {
                order: Some((3, 3)),
                ..settings(fs)
            },
            "order",
        ),
        (
            Settings {
                teeth: Some(0),
                ..settings(fs)
            },
            "teeth",
        ),
    ] {
        let why = Session::new(odd, true, true, None)
            .err()
            .expect(says)
            .to_string();
        assert!(why.contains(says), "{why}");
    }
}

#[test]
fn a_file_in_memory_is_judged_as_the_command_judges_it() {
    let (samples, fs) = demonstration();
    let wav = |samples: &[f32]| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let spec = hound::WavSpec {
            channels: 1,
            sample_rate: fs as u32,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut writer = hound::WavWriter::new(&mut bytes, spec).expect("memory");
        for x in samples {
            writer.write_sample((x * 32_768.0) as i16).expect("memory");
        }
        writer.finalize().expect("memory");
        bytes.into_inner()
    };
    let mut opened = Opened::new("cut.wav", wav(&samples)).expect("fit");
    assert_eq!(opened.about().samples, samples.len() as u64);
    let mut read = Vec::new();
    while let Some(block) = opened.next_samples().expect("whole") {
        read.extend(block);
    }
    assert_eq!(read, samples);
    let half = wav(&samples);
    let half = Opened::new("half.wav", half[..half.len() / 2].to_vec()).expect("half of it is fit");
    assert_eq!(half.about().notices.len(), 1, "{:?}", half.about().notices);
    for (name, bytes, says) in [
        ("muted.wav", wav(&[0.0; 9000]), "silence"),
        (
            "movie.wav",
            b"\0\0\0\x1cftypM4A and more".to_vec(),
            "MPEG-4",
        ),
        ("short.wav", wav(&samples)[..30].to_vec(), "copy it again"),
        ("empty.wav", Vec::new(), "empty"),
    ] {
        let why = Opened::new(name, bytes).expect_err(name).to_string();
        assert!(why.starts_with(name) && why.contains(says), "{why}");
    }
}
