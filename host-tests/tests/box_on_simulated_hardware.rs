//! Promise: the box on simulated hardware says what `listen` says, and tells the
//! host of every fault of its microphone and every frame its link did not take.

use firmware::{Job, Outcome};
use hal_sim::{Microphone, MicrophoneFault, SimBoard};
use host_tests::files::Folder;
use host_tests::signal;
use rarma_box::wire::{Deframer, Finished, MonitorJob, Refusal, Telemetry, Verdict};
use rarma_cli::collect::WholeRun;
use rarma_cli::commands;
use rarma_cli::record::Run;
use rarma_core::condition::Fault;
use rarma_core::decide::{Reason, State};
use rarma_core::monitor::MonitorConfig;

const FS: f64 = 8000.0;

fn job() -> MonitorJob {
    MonitorJob {
        monitor: MonitorConfig {
            full_scale: Some(1.0),
            ..MonitorConfig::new(FS)
        },
        channel: 0,
        every_s: 0.01,
    }
}

/// Four seconds of a damped mode, then one of a tone: an alarm at the end.
fn sound() -> impl Iterator<Item = f32> {
    let mode = signal::modes(&[(900.0, 0.04)], FS, 3)
        .map(|x| 0.1 * x)
        .take(32_000);
    let tone = signal::tone(1234.0, FS).zip(signal::white(8));
    mode.chain(tone.map(|(t, n)| 0.4 * t + 0.01 * n).take(8000))
        .map(|x| x as f32)
}

/// Everything that came over the link, in order and without a gap.
struct Played {
    outcome: Outcome,
    messages: Vec<Telemetry>,
}

impl Played {
    fn verdicts(&self) -> impl Iterator<Item = (f64, &Verdict)> {
        self.messages.iter().filter_map(|message| match message {
            Telemetry::Verdict(v) => Some((v.sample as f64 / FS, v)),
            _ => None,
        })
    }

    fn finished(&self) -> Finished {
        match self.messages.last() {
            Some(Telemetry::Finished(finished)) => *finished,
            other => panic!("the last message is {other:?}"),
        }
    }

    /// States with their reasons between two times, s.
    fn between(&self, from: f64, to: f64) -> Vec<(State, Reason)> {
        let inside = self.verdicts().filter(|(t, _)| (from..to).contains(t));
        inside.map(|(_, v)| (v.state, v.reason)).collect()
    }

    fn run(&self) -> Run {
        let mut collector = WholeRun::default();
        for message in &self.messages {
            collector.take(message);
        }
        collector.run().expect("a finished run")
    }
}

/// Decodes a link's bytes; sequence numbers must follow on from `first`.
fn decoded(bytes: &[u8], first: u32) -> Vec<Telemetry> {
    let mut deframer = Deframer::default();
    let frames = bytes.iter().filter_map(|&b| deframer.push::<Telemetry>(b));
    let messages = frames.enumerate().map(|(k, frame)| {
        let (head, message) = frame.expect("a whole frame");
        assert_eq!(head.sequence, first + k as u32, "a gap in the sequence");
        message
    });
    messages.collect()
}

fn play(microphone: Microphone, job: &MonitorJob) -> Played {
    let mut board = SimBoard::new(microphone);
    let outcome = Job::start(&mut board, job).expect("a job in range").run();
    Played {
        outcome,
        messages: decoded(&board.link.take(), 0),
    }
}

fn with(fault: MicrophoneFault) -> Played {
    play(Microphone::hearing(sound(), FS).with_fault(fault), &job())
}

#[test]
fn healthy_box_says_what_listen_says() {
    let played = play(Microphone::hearing(sound(), FS), &job());
    assert_eq!(played.outcome, Outcome::Ended);
    assert!(matches!(
        played.messages[0],
        Telemetry::Started { p: 8, q: 7, .. }
    ));
    let listened = commands::listen(&job(), sound(), |_| {}).expect("a run");
    assert_eq!(played.run(), listened);
    assert_eq!(listened.summary.alarms.len(), 1);
    assert!((4.0..4.5).contains(&listened.summary.alarms[0].on));
    let finished = played.finished();
    assert_eq!((finished.samples, finished.dropped_frames), (40_000, 0));
    assert_eq!(finished.health, Default::default());
    assert!(
        finished
            .standing
            .is_some_and(|(f, _)| (f - 1234.0).abs() < 1.0)
    );
}

#[test]
fn wav_through_the_microphone_says_what_listen_says() {
    let folder = Folder::default();
    let samples: Vec<f64> = sound().map(f64::from).collect();
    let float: Vec<f32> = sound().collect();
    for path in [
        folder.pcm16("heard.wav", 8000, &samples),
        folder.float("heard-float.wav", 8000, &float),
    ] {
        let microphone = Microphone::playing(&path).expect("a WAV");
        assert_eq!(microphone.fs_hz(), FS);
        let played = play(microphone, &job());
        let recording = rarma_recordings::input::read(&path, &Default::default()).expect("a WAV");
        let listened = commands::listen(&job(), recording.samples_f32(), |_| {}).expect("a run");
        assert_eq!(played.run(), listened, "{}", path.display());
        assert_eq!(listened.summary.alarms.len(), 1);
    }
}

#[test]
fn nan_from_the_converter_is_named_while_it_lasts() {
    let played = with(MicrophoneFault::NotFinite {
        from_s: 1.0,
        to_s: 1.2,
    });
    assert_eq!(played.outcome, Outcome::Ended);
    let bad = (State::Invalid, Reason::Samples(Fault::NotFinite));
    assert!(played.between(1.01, 1.29).iter().all(|s| *s == bad));
    assert!(
        played
            .between(0.5, 1.0)
            .iter()
            .all(|s| s.0 != State::Invalid && s.0 != State::Starting)
    );
    assert!(
        played
            .between(1.6, 3.9)
            .iter()
            .all(|s| s.0 != State::Invalid)
    );
    assert_eq!(played.finished().health.not_finite, 1600);
    assert_eq!(played.run().summary.alarms.len(), 1);
}

#[test]
fn stuck_value_is_named_while_it_lasts() {
    let played = with(MicrophoneFault::Stuck {
        from_s: 1.0,
        to_s: 1.5,
    });
    let bad = (State::Invalid, Reason::Samples(Fault::Stuck));
    assert!(played.between(1.07, 1.49).iter().all(|s| *s == bad));
    assert!(
        played
            .between(1.6, 3.9)
            .iter()
            .all(|s| s.0 != State::Invalid)
    );
    assert!((3500..=4001).contains(&played.finished().health.stuck));
    assert_eq!(played.run().summary.alarms.len(), 1);
}

#[test]
fn overdriven_microphone_is_named_and_calls_nothing_on_its_own() {
    let played = with(MicrophoneFault::Overdriven {
        from_s: 1.0,
        to_s: 2.0,
        gain: 30.0,
    });
    let bad = (State::Invalid, Reason::Samples(Fault::Clipped));
    assert!(played.between(1.05, 2.0).iter().all(|s| *s == bad));
    assert!(played.finished().health.clipped > 2000);
    let alarms = played.run().summary.alarms;
    assert!(alarms.iter().all(|a| a.on > 4.0), "{alarms:?}");
}

#[test]
fn lost_samples_are_counted_and_named() {
    let played = with(MicrophoneFault::Missing {
        at_s: 1.0,
        samples: 777,
    });
    assert_eq!(played.outcome, Outcome::Ended);
    let bad = (State::Invalid, Reason::Samples(Fault::Missing));
    assert!(
        played.between(1.14, 1.18).iter().all(|s| *s == bad),
        "{:?}",
        played.between(1.0, 1.3)
    );
    let finished = played.finished();
    assert_eq!((finished.health.missing, finished.samples), (777, 40_000));
    // Time goes on with the world: the alarm is not early by the hole.
    let on = played.run().summary.alarms[0].on;
    assert!((4.0..4.5).contains(&on), "{on}");
    let sum: u64 = finished.state_samples.iter().sum();
    assert!(40_000 - sum <= 16, "{sum} samples in states");
}

#[test]
fn source_that_breaks_off_ends_the_run_with_its_reason() {
    let played = with(MicrophoneFault::Lost { at_s: 1.0 });
    assert_eq!(played.outcome, Outcome::Refused(Refusal::SourceLost));
    assert_eq!(
        played.messages.last(),
        Some(&Telemetry::Refused(Refusal::SourceLost))
    );
    let heard = played.verdicts().last().map_or(0.0, |(t, _)| t);
    assert!((0.95..=1.0).contains(&heard), "heard until {heard} s");
}

#[test]
fn job_out_of_range_is_refused_on_the_link() {
    let mut bad = job();
    bad.monitor.threshold = 7.0;
    let mut board = SimBoard::new(Microphone::hearing(sound(), FS));
    assert_eq!(Job::start(&mut board, &bad).err(), Some(Refusal::Settings));
    let messages = decoded(&board.link.take(), 0);
    assert_eq!(messages, [Telemetry::Refused(Refusal::Settings)]);
}

#[test]
fn broken_link_drops_frames_counts_them_and_the_gap_shows() {
    let mut board = SimBoard::new(Microphone::hearing(sound(), FS));
    let mut running = Job::start(&mut board, &job()).expect("a job in range");
    let mut before = Vec::new();
    let mut dropped_from = 0;
    let mut blocks = 0;
    while running.step().is_none() {
        blocks += 1;
        if blocks == 30 {
            before = decoded(&running.board().link.take(), 0);
            dropped_from = before.len() as u32;
            running.board().link.broken = true;
        }
        if blocks == 90 {
            assert!(
                running.board().link.take().is_empty(),
                "a broken link took bytes"
            );
            running.board().link.broken = false;
        }
    }
    // 60 blocks of 256 samples are 1.92 s, from 0.96 s on: 192 lines and the histograms of
    // the first and the second second.
    let after = board.link.take();
    let mut deframer = Deframer::default();
    let first = after.iter().find_map(|&b| deframer.push::<Telemetry>(b));
    let (head, _) = first.expect("a frame").expect("a whole frame");
    let dropped = head.sequence - dropped_from;
    assert!((193..=195).contains(&dropped), "{dropped} frames dropped");
    let messages = decoded(&after, head.sequence);
    let Some(Telemetry::Finished(finished)) = messages.last() else {
        panic!("the last message is {:?}", messages.last());
    };
    assert_eq!(finished.dropped_frames, dropped);
    // What was heard meanwhile was heard all the same.
    assert_eq!(finished.samples, 40_000);
    assert!(before.len() > 50 && messages.len() > 100);
}
