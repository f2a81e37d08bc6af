//! Are the samples fit to be analysed?
//!
//! Three things make every later number meaningless, and none of them shows in
//! a damping ratio: samples that are no numbers, a channel that heard nothing,
//! and a converter that ran into its end. Clipping is the treacherous one: it
//! turns a growing vibration into a steady one with harmonics, which reads as
//! forced vibration.

use super::{InputError, Problem, Recording};
use std::collections::BTreeMap;

/// Share of samples at the end of the range from which a recording is refused.
/// A stray peak or two does not move a fitted pole; one sample in a thousand
/// is a flat top in every burst.
const CLIPPED_SHARE: f64 = 1e-3;

/// Equal samples in a row that make a flat top.
const FLAT_RUN: u64 = 3;

/// Refuses samples that are NaN or infinite, all equal, or clipped; see [`FileHealth`].
///
/// # Errors
/// As [`FileHealth::verdict`].
pub fn check(recording: &Recording) -> Result<(), InputError> {
    let mut health = FileHealth::new(recording.step);
    recording.samples.iter().for_each(|x| health.push(*x));
    health
        .verdict(recording.fs, recording.channel)
        .map_err(|why| why.in_file(&recording.path))
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
        let place = format!("sample {at} ({} s)", time(at as u64, recording.fs));
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

/// Judges a channel as it comes.
///
/// Integer PCM counts as clipped where it sits at either end of its range. A
/// float or CSV recording has no known end: there, runs of at least three
/// samples exactly at the maximum or minimum count, and only if the signal
/// enters and leaves them in a leap (more than four times the smallest change
/// in the recording), because a coarsely quantised but healthy peak is flat too.
#[derive(Debug, Clone)]
pub struct FileHealth {
    samples: u64,
    first: f64,
    constant: bool,
    /// First sample that is not finite, and how many there are.
    not_finite: Option<(u64, f64, u64)>,
    clipping: Clipping,
}

#[derive(Debug, Clone)]
enum Clipping {
    /// At or beyond this: the first one, its size, and how many there are.
    End { limit: f64, found: Option<Clipped> },
    /// Somewhere below the largest number.
    Tops(FlatTops),
}

/// Place and size of the first clipped sample, and how many there are.
type Clipped = (u64, f64, u64);

impl FileHealth {
    /// Nothing heard yet; `step` is the smallest the format can hold, full scale being 1,
    /// or none.
    pub fn new(step: Option<f64>) -> Self {
        Self {
            samples: 0,
            first: 0.0,
            constant: true,
            not_finite: None,
            clipping: match step {
                Some(step) => Clipping::End {
                    limit: 1.0 - step,
                    found: None,
                },
                None => Clipping::Tops(FlatTops::default()),
            },
        }
    }

    /// Takes the next sample.
    pub fn push(&mut self, x: f64) {
        if self.samples == 0 {
            self.first = x;
        }
        self.constant &= x == self.first;
        if !x.is_finite() {
            self.not_finite.get_or_insert((self.samples, x, 0)).2 += 1;
        }
        match &mut self.clipping {
            Clipping::End { limit, found } => {
                if x.abs() >= *limit {
                    found.get_or_insert((self.samples, x.abs(), 0)).2 += 1;
                }
            }
            Clipping::Tops(tops) => tops.push(x),
        }
        self.samples += 1;
    }

    /// Samples taken.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Whether the channel may be analysed.
    ///
    /// # Errors
    /// [`Problem::NonFinite`], [`Problem::Silence`] or [`Problem::Clipped`], with
    /// the first place and how much of the recording is affected; no file is named.
    pub fn verdict(&self, fs: f64, channel: usize) -> Result<(), InputError> {
        let place = |i: u64| format!("sample {i} ({} s)", time(i, fs));
        let fail = |problem, place, what: String, remedy: &str| {
            Err(InputError::new(problem, place, what, remedy))
        };
        if let Some((first, x, count)) = self.not_finite {
            let name = if x.is_nan() { "NaN" } else { "infinite" };
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
        if self.samples == 0 {
            return fail(
                Problem::NoSamples,
                "samples".into(),
                "there are none".into(),
                "record again",
            );
        }
        if self.samples == 1 {
            return fail(
                Problem::NoSamples,
                place(0),
                "is the only one".into(),
                "record longer",
            );
        }
        if self.constant {
            let what = if self.first == 0.0 {
                format!("silence: all {} samples are zero", self.samples)
            } else {
                format!(
                    "silence: all {} samples are the constant {}",
                    self.samples, self.first
                )
            };
            return fail(
                Problem::Silence,
                format!("channel {channel}"),
                what,
                "check the sensor, its cable and --channel",
            );
        }
        let clipped = match &self.clipping {
            Clipping::End { found, .. } => *found,
            Clipping::Tops(tops) => tops.clone().found(),
        };
        if let Some((first, size, count)) = clipped {
            let share = count as f64 / self.samples as f64;
            if share > CLIPPED_SHARE {
                return fail(
                    Problem::Clipped,
                    place(first),
                    format!(
                        "clipped: {:.2} % of the samples are at full scale ({size:.4}), from here on",
                        100.0 * share
                    ),
                    "lower the gain and record again",
                );
            }
        }
        Ok(())
    }
}

/// Kinds of flat tops that are kept apart: beyond that the closest are counted as one.
const MOST_LEAPS: usize = 512;

/// Runs of equal samples at the largest and at the smallest value.
#[derive(Debug, Clone)]
struct FlatTops {
    samples: u64,
    /// The run that goes on: value, length, and the leap by which it was entered.
    run: (f64, u64, f64),
    /// Smallest change from sample to sample.
    smallest: f64,
    high: Extreme,
    low: Extreme,
}

/// Runs at one extreme, by the smaller of the leaps in and out: only the end tells which
/// leaps are large.
#[derive(Debug, Clone)]
struct Extreme {
    value: f64,
    /// Bits of the leap (they sort as positive numbers do) to first place and count.
    runs: BTreeMap<u64, (u64, u64)>,
}

impl Extreme {
    fn new(value: f64) -> Self {
        Self {
            value,
            runs: BTreeMap::new(),
        }
    }

    fn add(&mut self, leap: f64, start: u64, length: u64, smallest: f64) {
        let sum = |runs: &mut BTreeMap<u64, (u64, u64)>, key, (first, count): (u64, u64)| {
            let run = runs.entry(key).or_insert((first, 0));
            *run = (run.0.min(first), run.1 + count);
        };
        sum(&mut self.runs, leap.to_bits(), (start, length));
        if self.runs.len() > MOST_LEAPS {
            // The smallest change only ever shrinks: what is large now stays so.
            let large = self.runs.split_off(&(4.0 * smallest).next_up().to_bits());
            for run in large.into_values() {
                sum(&mut self.runs, f64::INFINITY.to_bits(), run);
            }
        }
        if self.runs.len() > MOST_LEAPS
            && let Some((key, _)) = self.runs.first_key_value()
        {
            let key = *key;
            let next = self.runs.range(key + 1..).next().map(|(k, _)| *k);
            if let Some(run) = next.and_then(|k| self.runs.remove(&k)) {
                sum(&mut self.runs, key, run);
            }
        }
    }
}

impl Default for FlatTops {
    fn default() -> Self {
        Self {
            samples: 0,
            run: (0.0, 0, f64::INFINITY),
            smallest: f64::MAX,
            high: Extreme::new(f64::MIN),
            low: Extreme::new(f64::MAX),
        }
    }
}

impl FlatTops {
    fn push(&mut self, x: f64) {
        let (value, length, _) = self.run;
        if self.samples > 0 && x == value {
            self.run.1 = length + 1;
        } else {
            let leap = (x - value).abs();
            let entered = if self.samples > 0 {
                leap
            } else {
                f64::INFINITY
            };
            if self.samples > 0 {
                if leap > 0.0 {
                    self.smallest = self.smallest.min(leap);
                }
                self.close(leap);
            }
            self.run = (x, 1, entered);
        }
        self.samples += 1;
    }

    /// Ends the run that goes on; `leap` leads out of it.
    fn close(&mut self, leap: f64) {
        let (value, length, entered) = self.run;
        if value > self.high.value {
            self.high = Extreme::new(value);
        }
        if value < self.low.value {
            self.low = Extreme::new(value);
        }
        // A level of exactly zero is a pause or a rectified signal.
        if length < FLAT_RUN || value == 0.0 {
            return;
        }
        for end in [&mut self.high, &mut self.low] {
            if value == end.value {
                end.add(
                    entered.min(leap),
                    self.samples - length,
                    length,
                    self.smallest,
                );
            }
        }
    }

    fn found(mut self) -> Option<Clipped> {
        self.close(f64::INFINITY);
        let mut found: Option<Clipped> = None;
        for end in [&self.high, &self.low] {
            for (leap, (first, count)) in &end.runs {
                if f64::from_bits(*leap) > 4.0 * self.smallest {
                    let all = found.get_or_insert((u64::MAX, 0.0, 0));
                    if *first < all.0 {
                        (all.0, all.1) = (*first, end.value.abs());
                    }
                    all.2 += count;
                }
            }
        }
        found
    }
}

/// Time of sample `i` in seconds, to the microsecond, without idle zeros.
fn time(i: u64, fs: f64) -> String {
    let text = format!("{:.6}", i as f64 / fs);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    text.to_owned()
}
