//! Promises of the page of a long run, and of a stretch of one.

use super::*;

#[test]
fn a_long_run_is_a_density_and_a_window_of_it_is_not() {
    let (run, samples) = (chatter(4000), tone(10_000));
    let whole = page(&job(&played(&run, &samples)));
    sound(&whole);
    assert!(
        whole.contains("class=\"struct cells l"),
        "cells of both pictures"
    );
    assert!(whole.contains("class=\"forced cells l"));
    // What is self-excited is marked one by one: in both legends, and in the picture of frequency;
    // its damping is negative, an arrow.
    assert_eq!(whole.matches("<path class=\"self\" d=\"M").count(), 3);
    assert!(whole.contains("<path class=\"self arrow\" d=\"M"));
    assert!(
        !whole.contains("confidence\" d=\"M"),
        "no band behind a density"
    );
    assert!(whole.contains("<code>--window 0:2</code>"));

    let window = (0.9, 1.1);
    let mut course = Course::default().within(window);
    tell(&run, |news| course.take(&news));
    let mut heard = Sound::new(5000.0, (200.0, 2000.0)).within(window);
    samples.iter().for_each(|x| heard.push(*x));
    assert_eq!((heard.heard(), heard.samples()), (10_000, 1_000));
    let played = Played {
        sound: heard,
        course,
        summary: run.summary.clone(),
        provenance: Provenance::default(),
    };
    let mut job = job(&played);
    job.window_s = Some(window);
    let close = page(&job);
    sound(&close);
    assert!(!close.contains(" cells "), "400 lines are drawn one by one");
    assert!(close.contains("The pictures show 0.9\u{a0}s to 1.1\u{a0}s of 2\u{a0}s"));
    // The alarm begins in the middle of the plot; the words are of all of the run.
    assert!(close.contains("class=\"span\" x=\"504\""));
    assert!(close.contains("Chatter at 898\u{a0}Hz from 1\u{a0}s to the end</h1>"));
    assert!(close.contains("10\u{202f}000 at 5000\u{a0}Hz, 2\u{a0}s"));
}

#[test]
fn an_alarm_too_narrow_to_be_seen_into_has_no_edges() {
    let mut run = chatter(4000);
    run.summary.alarms = vec![alarm(0.5, Some(0.51), 898.0), alarm(1.0, Some(1.5), 898.0)];
    let page = page(&job(&played(&run, &tone(10_000))));
    // One alarm of two in each of the five pictures over time.
    assert_eq!(page.matches("class=\"edge\"").count(), 5);
    assert_eq!(page.matches("class=\"bar\"").count(), 10);
    assert!(page.contains("--window 0:2</code> draws how the first alarm began"));
}

#[test]
fn many_marks_are_a_density_and_a_few_are_seen_in_any_run() {
    // Chatter of a damping that wanders all over the axis: more marks than can be told apart.
    let mut run = chatter(40_000);
    for (n, line) in run.lines.iter_mut().enumerate() {
        let wide = (n as f64 * 0.37).sin().abs();
        line.modes[1].zeta = 1e-4 * 10_f64.powf(3.9 * wide);
        line.modes[1].label = Label::SelfExcited;
    }
    let page = page(&job(&played(&run, &tone(10_000))));
    sound(&page);
    assert!(page.contains("class=\"self cells l"));
    // Their one frequency is a row of marks still.
    assert_eq!(page.matches("marked one by one").count(), 1);
    // The same, self-excited in a single line.
    for (n, line) in run.lines.iter_mut().enumerate() {
        if n != 20_000 {
            line.modes[1].label = Label::Structural;
        }
    }
    let page = self::page(&job(&played(&run, &tone(10_000))));
    assert!(!page.contains("class=\"self cells l"));
    // A mark in both pictures, beside those of the two legends.
    assert_eq!(page.matches("<path class=\"self\" d=\"M").count(), 4);
}

#[test]
fn a_density_counts_every_mode_of_every_line() {
    // 40 000 lines, each with one mode whose damping wanders over a decade.
    let mut course = Course::default();
    let lines = 40_000;
    for n in 0..lines {
        let zeta = 0.01 * 10_f64.powf((f64::from(n) * 0.37).sin().abs());
        let modes = [(600.0, zeta, Label::Structural)];
        course.take(&News::Line(line(
            0.01 * f64::from(n),
            State::Stable,
            &modes,
        )));
    }
    let counted: u64 = course
        .moments()
        .flat_map(|moment| {
            moment
                .all_modes()
                .map(|m| u64::from(m.n))
                .collect::<Vec<_>>()
        })
        .sum();
    assert_eq!(counted, u64::from(lines as u32));
    let told: u64 = course.moments().map(|m| u64::from(m.lines)).sum();
    assert_eq!(told, u64::from(lines as u32));
}
