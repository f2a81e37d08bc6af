//! Promises of the thinned course of a run.

use super::super::tests::line;
use super::*;

#[test]
fn all_time_is_spent_in_some_state() {
    let mut course = Course::default();
    let lines = 400_000;
    for n in 0..lines {
        let state = if n % 40_000 == 7 {
            State::Warning
        } else {
            State::Stable
        };
        course.line(&line(n as f64, state, &[]));
    }
    let spent = course.spent(lines as f64);
    let of = |state| spent.iter().find(|s| s.0 == state).map(|s| s.2);
    assert_eq!(of(State::Warning), Some(10.0));
    assert_eq!(of(State::Stable), Some(lines as f64 - 10.0));
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
        zeta_median: None,
        zeta_deviation: None,
        advice: None,
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
        reading(900.0, Amplitude::SelfExcited),
    );
    say(
        &mut course,
        11.0,
        None,
        reading(905.0, Amplitude::SelfExcited),
    );
    say(&mut course, 11.5, None, reading(904.0, Amplitude::Forced));
    for n in 0..9 {
        say(
            &mut course,
            12.0 + 0.1 * f64::from(n),
            None,
            reading(1_400.0, Amplitude::Forced),
        );
    }
    (alarm.off, alarm.f) = (Some(13.0), 910.0);
    course.take(&News::Off(alarm.clone()));
    say(
        &mut course,
        14.0,
        Some(6_000.0),
        reading(910.0, Amplitude::Forced),
    );
    say(
        &mut course,
        15.0,
        Some(6_000.0),
        reading(910.0, Amplitude::Forced),
    );
    let noted = course.noted(0, &alarm).expect("noted");
    assert_eq!(noted.rpm, Some(5_000.0));
    assert_eq!(noted.said, Some(Amplitude::SelfExcited));
    assert!(course.noted(1, &alarm).is_none());
}
