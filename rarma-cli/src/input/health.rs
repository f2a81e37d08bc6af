//! Are the samples fit to be analysed?
//!
//! Three things make every later number meaningless, and none of them shows in
//! a damping ratio: samples that are no numbers, a channel that heard nothing,
//! and a converter that ran into its end. Clipping is the treacherous one: it
//! turns a growing vibration into a steady one with harmonics, which reads as
//! forced vibration.

use super::{InputError, Problem, Recording};

/// Share of samples at the end of the range from which a recording is refused.
/// A stray peak or two does not move a fitted pole; one sample in a thousand
/// is a flat top in every burst.
const CLIPPED_SHARE: f64 = 1e-3;

/// Equal samples in a row that make a flat top.
const FLAT_RUN: usize = 3;

/// Refuses samples that are NaN or infinite, all equal, or clipped.
///
/// Integer PCM counts as clipped where it sits at either end of its range. A
/// float or CSV recording has no known end: there, runs of at least three
/// samples exactly at the maximum or minimum count, and only if the signal
/// enters and leaves them in a leap (more than four times the smallest change
/// in the recording), because a coarsely quantised but healthy peak is flat too.
///
/// # Errors
/// [`Problem::NonFinite`], [`Problem::Silence`] or [`Problem::Clipped`], with
/// the first place and how much of the recording is affected.
pub fn check(recording: &Recording) -> Result<(), InputError> {
    let x = &recording.samples;
    let place = |i: usize| format!("sample {i} ({} s)", time(i, recording.fs));
    let fail = |problem, place, what: String, remedy: &str| {
        Err(InputError::new(problem, place, what, remedy).in_file(&recording.path))
    };

    if let Some(first) = x.iter().position(|v| !v.is_finite()) {
        let count = x.iter().filter(|v| !v.is_finite()).count();
        let name = if x[first].is_nan() { "NaN" } else { "infinite" };
        let rest = match count {
            1 => "the only one that is not finite".to_owned(),
            n => format!("the first of {n} that are not finite"),
        };
        return fail(
            Problem::NonFinite,
            place(first),
            format!("is {name}, {rest}"),
            "repair or cut out these samples",
        );
    }

    let Some(&first) = x.first() else {
        return fail(
            Problem::NoSamples,
            "samples".into(),
            "there are none".into(),
            "record again",
        );
    };
    if x.len() == 1 {
        return fail(
            Problem::NoSamples,
            place(0),
            "is the only one".into(),
            "record longer",
        );
    }
    if x.iter().all(|&v| v == first) {
        let what = if first == 0.0 {
            format!("silence: all {} samples are zero", x.len())
        } else {
            format!("silence: all {} samples are the constant {first}", x.len())
        };
        return fail(
            Problem::Silence,
            format!("channel {}", recording.channel),
            what,
            "check the sensor, its cable and --channel",
        );
    }

    let clipped = match recording.step {
        Some(step) => at_the_end(x, 1.0 - step),
        None => flat_tops(x),
    };
    if let Some((first, count)) = clipped {
        let share = count as f64 / x.len() as f64;
        if share > CLIPPED_SHARE {
            return fail(
                Problem::Clipped,
                place(first),
                format!(
                    "clipped: {:.2} % of the samples are at full scale ({:.4}), from here on",
                    100.0 * share,
                    x[first].abs()
                ),
                "lower the gain and record again",
            );
        }
    }
    Ok(())
}

/// Largest magnitude of a sample that is fitted: more than a converter of 64 bits
/// counts to. Its square, summed, stays far inside double precision, and a recording
/// that holds more holds a mark for "no value" and no measurement.
const LARGEST: f64 = 1e19;
/// A recording that does not reach this is lost when it is squared.
const SMALLEST: f64 = 1e-100;

/// Refuses samples whose powers would overflow or vanish: for what works on whole
/// recordings in double precision. (The monitor has a limit of its own.)
///
/// # Errors
/// [`Problem::Range`], with the place of the largest sample.
pub fn check_size(recording: &Recording) -> Result<(), InputError> {
    let x = &recording.samples;
    let Some((at, value)) = x
        .iter()
        .enumerate()
        .max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))
    else {
        return Ok(());
    };
    let fail = |what: String, remedy: &str| {
        let place = format!("sample {at} ({} s)", time(at, recording.fs));
        Err(InputError::new(Problem::Range, place, what, remedy).in_file(&recording.path))
    };
    if value.abs() > LARGEST {
        return fail(
            format!("is {value:e}: no sensor gives more than {LARGEST:e}, and its powers overflow"),
            "cut out marks for missing values, or record in a larger unit",
        );
    }
    if value.abs() < SMALLEST {
        return fail(
            format!("is {value:e}, the largest of all: powers of less than {SMALLEST:e} vanish"),
            "record in a smaller unit",
        );
    }
    Ok(())
}

/// First index and number of samples at or beyond `limit` in magnitude.
fn at_the_end(x: &[f64], limit: f64) -> Option<(usize, usize)> {
    let first = x.iter().position(|v| v.abs() >= limit)?;
    Some((first, x.iter().filter(|v| v.abs() >= limit).count()))
}

/// First index and number of samples in flat tops, see [`check`].
fn flat_tops(x: &[f64]) -> Option<(usize, usize)> {
    let high = x.iter().copied().fold(f64::MIN, f64::max);
    let low = x.iter().copied().fold(f64::MAX, f64::min);
    let smallest = x
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|d| *d > 0.0)
        .fold(f64::MAX, f64::min);
    let mut found = None;
    let mut start = 0;
    for run in x.chunk_by(|a, b| a == b) {
        let end = start + run.len();
        // A level of exactly zero is a pause or a rectified signal.
        if run.len() >= FLAT_RUN && run[0] != 0.0 && (run[0] == high || run[0] == low) {
            let leap = |j: usize| x.get(j).is_none_or(|v| (v - run[0]).abs() > 4.0 * smallest);
            let before = start.checked_sub(1).is_none_or(leap);
            if before && leap(end) {
                let (_, count) = found.get_or_insert((start, 0));
                *count += run.len();
            }
        }
        start = end;
    }
    found
}

/// Time of sample `i` in seconds, to the microsecond, without idle zeros.
fn time(i: usize, fs: f64) -> String {
    let text = format!("{:.6}", i as f64 / fs);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_owned()
}
