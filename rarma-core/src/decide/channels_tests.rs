use super::*;
use crate::decide::{Evidence, Label, Origin};

const PERIOD: f64 = 0.002;

fn mode(damping: f64, damping_sd: f64) -> Mode<f64> {
    Mode {
        frequency: 900.0,
        frequency_sd: 1.0,
        damping,
        damping_sd,
        amplitude: 1.0,
        share: 0.6,
        share_of_all: 0.6,
        gradient: 0.0,
        time_left_s: None,
        label: Label::Structural,
        origin: Origin::Free,
        harmonic: None,
        suspicion: 0.0,
        evidence: Evidence::default(),
        was_damped: false,
        grew: false,
    }
}

/// Both channels for a while: fault, level and reading of each as a function of time.
fn run(
    watch: &mut ChannelWatch<f64>,
    seconds: f64,
    at: impl Fn(f64) -> [(Option<Fault>, f64, Option<Mode<f64>>); 2],
) {
    let config = AlarmConfig::default();
    for k in 0..(seconds / PERIOD).round() as usize {
        let [a, b] = at(k as f64 * PERIOD);
        let (first, second) = ([a.2], [b.2]);
        let hearing = |(fault, level, _): (Option<Fault>, f64, _), modes| Hearing {
            fault,
            judging: true,
            cutting: true,
            level,
            modes,
        };
        watch.update([hearing(a, &first), hearing(b, &second)], &config, PERIOD);
    }
}

fn faults(watch: &ChannelWatch<f64>) -> [Option<ChannelFault>; 2] {
    [0, 1].map(|i| watch.dropped(i).map(|d| d.fault))
}

#[test]
fn bad_samples_drop_at_once_and_come_back_after_a_second() {
    let mut watch = ChannelWatch::default();
    run(&mut watch, 0.1, |_| [(None, 1.0, None); 2]);
    assert_eq!(faults(&watch), [None, None]);
    let stuck = Some(ChannelFault::Samples(Fault::Stuck));
    run(&mut watch, PERIOD, |_| {
        [(None, 1.0, None), (Some(Fault::Stuck), 1.0, None)]
    });
    assert_eq!(faults(&watch), [None, stuck]);
    assert_eq!(watch.dropped(1).map(|d| d.channel), Some(1));
    run(&mut watch, 0.998, |_| [(None, 1.0, None); 2]);
    assert_eq!(faults(&watch), [None, stuck]);
    run(&mut watch, 0.004, |_| [(None, 1.0, None); 2]);
    assert_eq!(faults(&watch), [None, None]);
    run(&mut watch, PERIOD, |_| {
        [(Some(Fault::Clipped), 1.0, None); 2]
    });
    assert!(
        faults(&watch).iter().all(Option::is_some),
        "both may be bad"
    );
}

#[test]
fn a_dead_channel_is_silent_only_once_the_other_moves() {
    let mut watch = ChannelWatch::default();
    run(&mut watch, 2.0, |_| [(None, 1e-6, None), (None, 1.0, None)]);
    assert_eq!(
        faults(&watch),
        [None, None],
        "units may differ by any factor"
    );
    let silent = Some(ChannelFault::Silent);
    run(&mut watch, 1.0, |_| [(None, 1e-6, None), (None, 5.0, None)]);
    assert_eq!(faults(&watch), [silent, None]);
    // The other goes quiet: it is dead all the same.
    run(&mut watch, 3.0, |_| [(None, 1e-6, None), (None, 1.0, None)]);
    assert_eq!(faults(&watch), [silent, None]);
    // It speaks again.
    run(&mut watch, 0.9, |_| [(None, 0.5, None), (None, 1.0, None)]);
    assert_eq!(faults(&watch), [silent, None]);
    run(&mut watch, 0.3, |_| [(None, 0.5, None), (None, 1.0, None)]);
    assert_eq!(faults(&watch), [None, None]);
}

#[test]
fn one_that_moves_along_is_not_silent_however_small() {
    let mut watch = ChannelWatch::default();
    run(&mut watch, 4.0, |t| {
        let level = if t < 2.0 { 1.0 } else { 8.0 };
        [(None, level, None), (None, 1e-6 * level, None)]
    });
    assert_eq!(faults(&watch), [None, None]);
}

#[test]
fn the_less_sure_of_two_that_contradict_is_dropped() {
    let (sure, unsure) = (mode(0.001, 0.0005), mode(0.05, 0.004));
    let mut watch = ChannelWatch::default();
    let contradict = |_| [(None, 1.0, Some(unsure)), (None, 1.0, Some(sure))];
    run(&mut watch, 0.49, contradict);
    assert_eq!(faults(&watch), [None, None]);
    run(&mut watch, 0.02, contradict);
    let dropped = Some(ChannelFault::Contradicts);
    assert_eq!(faults(&watch), [dropped, None]);
    // Nothing in common is no proof of health, agreement is.
    run(&mut watch, 5.0, |_| {
        [(None, 1.0, None), (None, 1.0, Some(sure))]
    });
    assert_eq!(faults(&watch), [dropped, None]);
    run(&mut watch, 1.1, |_| [(None, 1.0, Some(sure)); 2]);
    assert_eq!(faults(&watch), [None, None]);
    // A difference that the uncertainty explains, or that changes no verdict.
    let vague = mode(0.03, 0.02);
    let close = mode(0.015, 0.0005);
    for other in [vague, close] {
        run(&mut watch, 3.0, |_| {
            [(None, 1.0, Some(other)), (None, 1.0, Some(sure))]
        });
        assert_eq!(faults(&watch), [None, None], "{other:?}");
    }
}

#[test]
fn the_last_channel_is_kept() {
    let (sure, unsure) = (mode(0.001, 0.0005), mode(0.05, 0.004));
    let mut watch = ChannelWatch::default();
    run(&mut watch, 1.0, |_| {
        [(None, 1.0, Some(unsure)), (None, 1.0, Some(sure))]
    });
    assert_eq!(faults(&watch), [Some(ChannelFault::Contradicts), None]);
    run(&mut watch, PERIOD, |_| {
        [
            (None, 1.0, Some(unsure)),
            (Some(Fault::NotFinite), 1.0, None),
        ]
    });
    let bad = Some(ChannelFault::Samples(Fault::NotFinite));
    assert_eq!(faults(&watch), [None, bad]);
}
