//! Promises of the thinned course of a run.

use super::*;
use crate::record::{Origin, SpindleRecord};

fn line(t: f64, state: State, modes: &[(f64, f64, Label)]) -> Line {
    let mode = |(f, zeta, label): &(f64, f64, Label)| ModeRecord {
        f: *f,
        f_sd: 1.0,
        zeta: *zeta,
        zeta_sd: 0.1 * zeta,
        amplitude: 0.1,
        label: *label,
        harmonic: None,
        origin: Origin::Free,
        time_left: None,
        zeta_process: None,
        zeta_process_sd: None,
    };
    Line {
        t,
        state,
        reason: Reason::None,
        modes: modes.iter().map(mode).collect(),
        spindle: SpindleRecord {
            rpm: None,
            source: SpeedSource::Unknown,
            locked: false,
            notch_hz: 0.0,
        },
        amplitude: None,
        agreement: None,
    }
}

#[test]
fn few_lines_are_kept_one_by_one() {
    let mut course = Course::default();
    for n in 0..MOMENTS {
        let f = 500.0 + n as f64;
        course.line(&line(
            n as f64,
            State::Stable,
            &[(f, 0.02, Label::Structural)],
        ));
    }
    assert_eq!(course.moments().count(), MOMENTS);
    for (n, moment) in course.moments().enumerate() {
        assert_eq!((moment.t, moment.modes().len()), (n as f64, 1));
        assert_eq!(moment.modes()[0].f, 500.0 + n as f64);
    }
}

#[test]
fn many_lines_keep_every_state_and_the_ends_of_every_stretch() {
    let mut course = Course::default();
    let lines = 50 * MOMENTS;
    // Once in 40 000 lines: another state, a mode of little damping, and one far off.
    let odd = |n: usize| n % 40_000 == 7;
    for n in 0..lines {
        let usual = (600.0 + (n % 400) as f64, 0.03, Label::Structural);
        let mut modes = vec![
            usual,
            (1_500.0, 0.02 + 1e-5 * (n % 977) as f64, Label::Forced),
        ];
        let state = if odd(n) {
            modes.push((2_200.0, 0.0005, Label::SelfExcited));
            modes.push((1_501.0, 0.0001, Label::Forced));
            State::Warning
        } else {
            State::Stable
        };
        course.line(&line(n as f64, state, &modes));
    }
    let moments: Vec<&Moment> = course.moments().collect();
    assert!((MOMENTS / 2..=MOMENTS + 1).contains(&moments.len()));
    assert!(moments.iter().all(|m| m.more.len() <= LABELS * MORE));
    let warned = moments.iter().filter(|m| m.has(State::Warning)).count();
    assert_eq!(warned, (0..lines).filter(|n| odd(*n)).count());
    for moment in moments.iter().filter(|m| m.has(State::Warning)) {
        let has = |f: f64, zeta: f64| {
            let same = |m: &Seen| m.f == f && (m.zeta - zeta).abs() < 1e-9;
            moment.all_modes().any(|m| same(&m) && odd(m.t as usize))
        };
        assert!(has(2_200.0, 0.0005) && has(1_501.0, 0.0001), "{}", moment.t);
    }
    // In order of time, and none of the usual ones lost altogether.
    assert!(moments.windows(2).all(|w| w[0].t < w[1].t));
    assert!(
        moments
            .iter()
            .all(|m| m.has(State::Stable) && !m.modes().is_empty())
    );
    let spent = course.spent(lines as f64);
    let total: f64 = spent.iter().map(|s| s.2).sum();
    assert!((total - lines as f64).abs() < 1.0, "{total}");
}

#[test]
fn an_alarm_takes_the_nearest_speed_and_what_was_said_most() {
    let mut course = Course::default();
    let reading = |f: f64, verdict| {
        Some(AmplitudeRecord {
            f,
            s: 0.1,
            verdict,
            z: -5.0,
        })
    };
    let mut alarm = Alarm {
        on: 10.0,
        off: None,
        f: 900.0,
        zeta: 0.0,
    };
    let say = |course: &mut Course, t: f64, rpm, amplitude| {
        let mut line = line(t, State::Chatter, &[]);
        line.spindle.rpm = rpm;
        line.amplitude = amplitude;
        course.take(&News::Line(line));
    };
    say(&mut course, 8.0, Some(4_000.0), None);
    course.take(&News::On(alarm.clone()));
    say(
        &mut course,
        10.5,
        Some(5_000.0),
        reading(900.0, AmplitudeVerdict::SelfExcited),
    );
    say(
        &mut course,
        11.0,
        None,
        reading(905.0, AmplitudeVerdict::SelfExcited),
    );
    say(
        &mut course,
        11.5,
        None,
        reading(904.0, AmplitudeVerdict::Forced),
    );
    for n in 0..9 {
        say(
            &mut course,
            12.0 + 0.1 * f64::from(n),
            None,
            reading(1_400.0, AmplitudeVerdict::Forced),
        );
    }
    (alarm.off, alarm.f) = (Some(13.0), 910.0);
    course.take(&News::Off(alarm.clone()));
    say(
        &mut course,
        14.0,
        Some(6_000.0),
        reading(910.0, AmplitudeVerdict::Forced),
    );
    say(
        &mut course,
        15.0,
        Some(6_000.0),
        reading(910.0, AmplitudeVerdict::Forced),
    );
    let noted = course.noted(0, &alarm).expect("noted");
    assert_eq!(noted.rpm, Some(5_000.0));
    assert_eq!(noted.said, Some(AmplitudeVerdict::SelfExcited));
    assert!(course.noted(1, &alarm).is_none());
}
