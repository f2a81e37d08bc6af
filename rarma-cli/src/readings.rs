//! Readings of one quantity: their median and deviation, in memory that does not grow.

use serde::{Deserialize, Serialize};

/// Readings kept at most; of more, every second, fourth, … is.
const MOST: usize = 1024;
/// Fewer than these have no median worth the name.
const FEWEST: usize = 3;
/// From the median distance to the standard deviation, where readings are normal.
const TO_SD: f64 = 1.4826;

/// Readings as they come.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Readings {
    kept: Vec<f64>,
    seen: u64,
    doubled: u32,
}

/// The middle of some readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Middle {
    /// Half of them lie below.
    pub median: f64,
    /// 1.48 times the median distance from it: the standard deviation of readings that are
    /// normal, and not moved by a few that are not.
    pub deviation: f64,
}

impl Readings {
    /// Takes one; what is not finite is left out.
    pub fn push(&mut self, reading: f64) {
        if !reading.is_finite() {
            return;
        }
        let wanted = |seen: u64, doubled: u32| seen.is_multiple_of(1 << doubled);
        if wanted(self.seen, self.doubled) && self.kept.len() == MOST {
            let mut place = 0;
            self.kept.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            self.doubled += 1;
        }
        if wanted(self.seen, self.doubled) {
            self.kept.push(reading);
        }
        self.seen += 1;
    }

    /// They may have come by [`Self::push`]: not more than are kept, and one in so many that a number
    /// of 64 bits counts them.
    pub(crate) fn is_sound(&self) -> bool {
        self.kept.len() <= MOST && self.doubled < u64::BITS && self.seen < 1 << 62
    }

    /// Median and deviation; none of fewer than three.
    pub fn middle(&self) -> Option<Middle> {
        if self.kept.len() < FEWEST {
            return None;
        }
        let median = median(self.kept.clone());
        let away = self.kept.iter().map(|x| (x - median).abs()).collect();
        Some(Middle {
            median,
            deviation: TO_SD * self::median(away),
        })
    }
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    let half = all.len() / 2;
    if all.len().is_multiple_of(2) {
        0.5 * (all[half - 1] + all[half])
    } else {
        all[half]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_are_told_exactly_and_one_that_is_wild_moves_nothing() {
        let mut readings = Readings::default();
        for x in [0.02, f64::NAN, 0.01] {
            readings.push(x);
        }
        assert_eq!(readings.middle(), None);
        for x in [9.0, 0.03] {
            readings.push(x);
        }
        let middle = readings.middle().expect("four");
        assert!((middle.median - 0.025).abs() < 1e-12, "{middle:?}");
        assert!(
            (middle.deviation - TO_SD * 0.01).abs() < 1e-12,
            "{middle:?}"
        );
    }

    #[test]
    fn many_are_bounded_and_spread_over_all_of_the_time() {
        let mut readings = Readings::default();
        let n = 1_000_003;
        for k in 0..n {
            readings.push(f64::from(k));
            assert!(readings.kept.len() <= MOST);
        }
        assert!(readings.kept.len() > MOST / 4);
        let middle = readings.middle().expect("many");
        let end = f64::from(n);
        assert!((middle.median / end - 0.5).abs() < 0.005, "{middle:?}");
        // Of an even spread the median distance is a quarter.
        assert!(
            (middle.deviation / end - 0.25 * TO_SD).abs() < 0.005,
            "{middle:?}"
        );
    }
}
