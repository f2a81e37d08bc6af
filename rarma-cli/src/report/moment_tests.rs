//! Promises of the thinned lines of a run.

use super::super::tests::line;
use super::*;

#[test]
fn few_lines_are_kept_one_by_one() {
    let mut moments = Moments::default();
    for n in 0..MOMENTS {
        let f = 500.0 + n as f64;
        moments.push(Moment::of(&line(
            n as f64,
            State::Stable,
            &[(f, 0.02, Label::Structural)],
        )));
    }
    assert_eq!(moments.iter().count(), MOMENTS);
    for (n, moment) in moments.iter().enumerate() {
        assert_eq!((moment.t, moment.modes().len()), (n as f64, 1));
        assert_eq!(moment.modes()[0].f, 500.0 + n as f64);
    }
}

#[test]
fn many_lines_keep_every_state_and_the_ends_of_every_stretch() {
    let mut moments = Moments::default();
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
        moments.push(Moment::of(&line(n as f64, state, &modes)));
    }
    let moments: Vec<&Moment> = moments.iter().collect();
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
}
