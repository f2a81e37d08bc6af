//! What the program was asked to reach, and where it does not.
//!
//! A bar has a name, a measured figure and the range that was asked for. Bars that this version
//! misses stand on the list in `missed.rs` with the range that is got instead and the reason;
//! docs/bench.md shows that list as a table. A bar that is not on the list must be met; one
//! that is must lie within what is got: if it gets worse the test fails, and if it is met the
//! test fails until it is taken off the list. `RARMA_HOLD_BARS=1` holds them all,
//! `RARMA_HOLD_BARS=0` none: to see a whole table while the logic changes.

mod missed;

use core::ops::RangeInclusive;
use std::env;
use std::fmt::Write as _;
use std::sync::{Mutex, PoisonError};

pub use missed::MISSED;

/// A bar that this version misses.
#[derive(Debug, Clone, PartialEq)]
pub struct Missed {
    /// The bar's name: `form: what, of which`.
    pub bar: &'static str,
    /// What was asked.
    pub asked: RangeInclusive<f64>,
    /// What is got: the measured figure with room for another machine's rounding.
    pub got: RangeInclusive<f64>,
    /// The test that measures it: file and function.
    pub test: &'static str,
    /// Why it is missed.
    pub why: &'static str,
}

/// What became of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The figure lies within the bar.
    Met,
    /// It does not, as is known.
    Missed,
}

/// Names of the bars judged in this process.
static JUDGED: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Judges one figure by one bar and prints the line that says so. A figure that is not a
/// number meets no bar.
///
/// # Panics
/// The bar is missed and not on the list, or on the list and met or no more as it says there.
pub fn holds(bar: &str, figure: f64, asked: RangeInclusive<f64>) -> Outcome {
    JUDGED
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(bar.to_owned());
    let known = MISSED.iter().find(|missed| missed.bar == bar);
    let (outcome, objection) = match env::var("RARMA_HOLD_BARS").as_deref() {
        Ok("0") => (judge(figure, &asked, None).0, None),
        Ok("1") => judge(figure, &asked, None),
        _ => judge(figure, &asked, known),
    };
    let word = if outcome == Outcome::Met {
        "met"
    } else {
        "MISSED"
    };
    let (low, high) = (asked.start(), asked.end());
    println!("bar | {bar} | {figure:.4} | {low} to {high} | {word}");
    assert!(
        objection.is_none(),
        "{bar}: {}",
        objection.unwrap_or_default()
    );
    outcome
}

/// The outcome, and what is wrong about it.
fn judge(
    figure: f64,
    asked: &RangeInclusive<f64>,
    known: Option<&Missed>,
) -> (Outcome, Option<String>) {
    let met = asked.contains(&figure);
    let objection = match known {
        None => (!met).then(|| format!("{figure}, asked {}", said(asked))),
        Some(missed) if missed.asked != *asked => Some(format!(
            "asked {}, by the list of missed bars {}",
            said(asked),
            said(&missed.asked)
        )),
        Some(_) if met => Some(format!(
            "{figure} meets it: take it off the list of missed bars"
        )),
        Some(missed) => (!missed.got.contains(&figure)).then(|| {
            let got = said(&missed.got);
            format!(
                "{figure}, by the list of missed bars {got} (asked {})",
                said(asked)
            )
        }),
    };
    (if met { Outcome::Met } else { Outcome::Missed }, objection)
}

/// Fails unless each listed bar of this form was judged: to be called at the end of the test
/// that judges them.
///
/// # Panics
/// A bar is on the list and nothing was measured for it.
pub fn all_judged(form: &str) {
    let judged = JUDGED.lock().unwrap_or_else(PoisonError::into_inner);
    let stale = MISSED
        .iter()
        .filter(|missed| form_of(missed.bar) == form)
        .filter(|missed| !judged.iter().any(|bar| bar == missed.bar))
        .map(|missed| missed.bar);
    let stale: Vec<&str> = stale.collect();
    assert!(
        stale.is_empty(),
        "on the list of missed bars, not measured: {stale:?}"
    );
}

fn form_of(bar: &str) -> &str {
    bar.split_once(':').map_or(bar, |(form, _)| form)
}

/// A range as a reader wants it.
fn said(range: &RangeInclusive<f64>) -> String {
    let (low, high) = (range.start(), range.end());
    if low == high {
        format!("{low}")
    } else {
        format!("{low} to {high}")
    }
}

/// The list as a table.
#[must_use]
pub fn markdown() -> String {
    let mut text = "| bar | asked | got | test | why |\n|---|---|---|---|---|\n".to_owned();
    for missed in MISSED {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | `{}` | {} |",
            missed.bar,
            said(&missed.asked),
            said(&missed.got),
            missed.test,
            missed.why
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: Missed = Missed {
        bar: "a: b",
        asked: 0.0..=1.0,
        got: 1.9..=2.1,
        test: "file::function",
        why: "a reason",
    };

    fn objection(figure: f64, known: Option<&Missed>) -> Option<String> {
        judge(figure, &(0.0..=1.0), known).1
    }

    #[test]
    fn a_bar_off_the_list_must_be_met() {
        assert_eq!(judge(1.0, &(0.0..=1.0), None), (Outcome::Met, None));
        assert!(objection(2.0, None).is_some_and(|why| why.contains("2, asked 0 to 1")));
        assert!(objection(f64::NAN, None).is_some());
    }

    #[test]
    fn a_known_miss_stays_as_it_is_known() {
        assert_eq!(
            judge(2.0, &(0.0..=1.0), Some(&KNOWN)),
            (Outcome::Missed, None)
        );
        for worse in [1.5, 2.2, f64::NAN] {
            assert!(objection(worse, Some(&KNOWN)).is_some_and(|why| why.contains("1.9 to 2.1")));
        }
    }

    #[test]
    fn a_bar_that_is_met_leaves_the_list() {
        let why = objection(0.5, Some(&KNOWN)).expect("an objection");
        assert!(why.contains("take it off the list"), "{why}");
    }

    #[test]
    fn what_is_asked_is_what_the_list_says() {
        let why = judge(2.0, &(0.0..=1.5), Some(&KNOWN))
            .1
            .expect("an objection");
        assert!(
            why.contains("asked 0 to 1.5, by the list of missed bars 0 to 1"),
            "{why}"
        );
    }

    #[test]
    fn the_list_is_of_misses_each_once() {
        for (k, missed) in MISSED.iter().enumerate() {
            let bar = missed.bar;
            assert!(
                MISSED[..k].iter().all(|other| other.bar != bar),
                "{bar}: twice"
            );
            assert!(bar.contains(": ") && missed.test.contains("::"), "{bar}");
            assert!(!missed.why.is_empty() && !missed.why.contains('|'), "{bar}");
            // No figure that is got may be one that was asked.
            let (asked, got) = (&missed.asked, &missed.got);
            assert!(got.start() <= got.end(), "{bar}");
            assert!(
                got.end() < asked.start() || got.start() > asked.end(),
                "{bar}"
            );
        }
    }

    #[test]
    #[should_panic(expected = "not measured: [\"near: ")]
    fn a_listed_bar_that_nothing_measures_is_told() {
        all_judged("near");
    }
}
