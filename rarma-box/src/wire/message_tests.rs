//! Promises: the largest messages fit a frame and come back as they were.

use super::*;
use crate::wire::{Deframer, MAX_FRAME, encode};
use rarma_core::condition::Fault;

/// Every number as long as postcard writes it.
fn largest_verdict() -> Verdict {
    let mode = ModeMessage {
        frequency: 1234.5,
        frequency_sd: 0.1,
        damping: -0.0123,
        damping_sd: 0.001,
        amplitude: 1e-3,
        gradient: -0.5,
        label: Label::Forced,
        harmonic: Some(u32::MAX),
        origin: Origin::Unknown,
        time_left_s: Some(0.25),
    };
    Verdict {
        sample: u64::MAX,
        state: State::Invalid,
        reason: Reason::Samples(Fault::Clipped),
        level: 0.1,
        modes: Vec::from_array([mode; MAX_MODES]),
        spindle: SpindleMessage {
            hz: Some(76.3),
            source: SpeedSource::Tacho,
            locked: true,
            notch_hz: 1.5,
            removed_power: 0.02,
        },
        amplitude: Some(AmplitudeMessage {
            frequency: 1234.5,
            scintillation: 0.03,
            verdict: Amplitude::NotStationary,
            z: -7.5,
        }),
    }
}

#[test]
fn the_largest_messages_fit_and_come_back() {
    let messages = [
        Telemetry::Verdict(largest_verdict()),
        Telemetry::Amplitude(HistogramMessage {
            sample: u64::MAX,
            frequency: 1234.5,
            counts: [u16::MAX; BINS],
            beyond: u16::MAX,
            bin_width: 1e-7,
        }),
        Telemetry::Notice(NoticeMessage {
            sample: u64::MAX,
            notice: Notice::Contradiction {
                told_hz: 75.0,
                found_hz: 76.3,
            },
        }),
        Telemetry::Notice(NoticeMessage {
            sample: 3,
            notice: Notice::Tacho(TachoFault::Noisy),
        }),
        Telemetry::Finished(Finished {
            samples: u64::MAX,
            state_samples: [u64::MAX; 6],
            health: HealthCounts {
                not_finite: u32::MAX,
                clipped: u32::MAX,
                stuck: u32::MAX,
                missing: u32::MAX,
            },
            locked_samples: u64::MAX,
            removed_fraction: 0.9,
            standing: Some((1234.5, -0.01)),
            longest_block_us: u32::MAX,
            late_blocks: u32::MAX,
            dropped_frames: u32::MAX,
        }),
    ];
    let mut lengths = [0; 5];
    for (message, length) in messages.iter().zip(&mut lengths) {
        let mut buffer = [0; MAX_FRAME];
        let frame = encode(message, u32::MAX, u32::MAX, &mut buffer).expect("fits a frame");
        *length = frame.len();
        let mut deframer = Deframer::default();
        let mut back = None;
        for &byte in frame {
            back = deframer.push::<Telemetry>(byte).or(back);
        }
        let (head, back) = back.expect("a frame").expect("a message");
        assert_eq!((head.session, head.sequence), (u32::MAX, u32::MAX));
        assert_eq!(&back, message);
    }
    // A verdict is the longest; room is left for another mode's worth of fields.
    assert!((180..MAX_FRAME - 40).contains(&lengths[0]), "{lengths:?}");
    assert!(lengths.iter().all(|n| *n <= lengths[0]), "{lengths:?}");
}

#[test]
fn a_report_is_sent_as_it_is() {
    use rarma_core::decide::{AlarmEvent, AmplitudeReading};
    let mut report = Report::<f64> {
        sample: 7,
        state: State::Warning,
        reason: Reason::OriginUnknown,
        event: AlarmEvent::None,
        level: 0.5,
        modes: [None; MAX_MODES],
        spindle: SpindleReport {
            spindle_hz: Some(27.5),
            source: SpeedSource::Sound,
            locked: true,
            removed_power: 0.125,
            notch_hz: 0.75,
            ..SpindleReport::default()
        },
        amplitude: Some(AmplitudeReport {
            frequency: 980.0,
            reading: AmplitudeReading {
                scintillation: 0.25,
                z: -3.0,
                verdict: Amplitude::SelfExcited,
                ..AmplitudeReading::default()
            },
        }),
        standing: None,
    };
    let sent = Verdict::from_report(&report);
    assert_eq!(sent.reason, Reason::OriginUnknown);
    assert_eq!(sent.spindle.hz, Some(27.5));
    assert_eq!(sent.spindle.source, SpeedSource::Sound);
    assert_eq!(
        (sent.spindle.removed_power, sent.spindle.notch_hz),
        (0.125, 0.75)
    );
    let amplitude = sent.amplitude.expect("a followed mode");
    assert_eq!(
        (amplitude.frequency, amplitude.scintillation, amplitude.z),
        (980.0, 0.25, -3.0)
    );
    assert_eq!(amplitude.verdict, Amplitude::SelfExcited);
    report.amplitude = None;
    assert_eq!(Verdict::from_report(&report).amplitude, None);
}
