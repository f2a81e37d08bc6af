//! A box's clock against UTC.
//!
//! A box knows the time since its start, the gateway knows UTC when a frame arrives. Their difference
//! is the box's start plus the time the frame took, and no frame arrives before it was sent: the least
//! difference of a while is nearest to the truth. A line through such least values is the drift.
//!
//! ```text
//! offset = arrival − box    least of each while    offset ≈ a + d·box    UTC = a + (1 + d)·box
//! ```
//! A box that runs fast by `x` millionths has `d = −x·10⁻⁶` to the first order.

use crate::record::{Clock, Utc};
use std::collections::VecDeque;

/// One least value is kept of so long, s.
const WHILE_S: f64 = 600.0;
/// So many are kept: a day.
const WHILES: usize = 144;
/// Fewer say nothing of a drift.
const LEAST_WHILES: usize = 4;
/// A clock that goes back by less is only frames that overtook each other, s.
pub const BACK_S: f64 = 1.0;
/// A difference that jumps up by more was a step of this computer's clock, or a link that stood
/// still, s. Which of them shows when the next while is no lower.
const STEP_S: f64 = 5.0;

/// What was wrong with time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClockFault {
    /// This computer's clock was set back.
    HostBack {
        /// By so much, s.
        seconds: f64,
    },
    /// The box's clock went back within one run: its monitor was started anew.
    BoxBack {
        /// By so much, s.
        seconds: f64,
    },
}

/// One while: where it began (box, s), and the place and value of its least difference.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Least {
    begun_s: f64,
    box_s: f64,
    offset_s: f64,
}

/// Converts times of one box's clock to UTC.
#[derive(Debug, Clone)]
pub struct BoxClock {
    /// Differences are taken from here, so that doubles hold them to a microsecond.
    origin: Option<Utc>,
    whiles: VecDeque<Least>,
    last: Option<(f64, Utc)>,
    fixed: Option<Utc>,
}

impl BoxClock {
    /// A clock that is compared with arrivals.
    #[must_use]
    pub fn live() -> Self {
        Self {
            origin: None,
            whiles: VecDeque::new(),
            last: None,
            fixed: None,
        }
    }

    /// A clock of a recording: the box was started at that time, and its clock is right.
    #[must_use]
    pub fn since(start: Utc) -> Self {
        Self {
            fixed: Some(start),
            ..Self::live()
        }
    }

    /// The box's clock (s) as a frame arrives; says if one of the clocks went back. Then
    /// everything known of their difference is forgotten.
    pub fn hears(&mut self, box_s: f64, arrival: Utc) -> Option<ClockFault> {
        let last = self.last.replace((box_s, arrival));
        let fault = last.and_then(|(before_s, before)| {
            if before_s - box_s > BACK_S {
                let seconds = before_s - box_s;
                Some(ClockFault::BoxBack { seconds })
            } else if self.fixed.is_none() && before.since_s(arrival) > BACK_S {
                let seconds = before.since_s(arrival);
                Some(ClockFault::HostBack { seconds })
            } else {
                None
            }
        });
        if fault.is_some() {
            self.whiles.clear();
        }
        if let Some(start) = &mut self.fixed {
            if let (Some(ClockFault::BoxBack { .. }), Some((before_s, _))) = (fault, last) {
                // A recording goes on where it was.
                *start = start.plus_s(before_s - box_s);
            }
            return fault;
        }
        let origin = *self.origin.get_or_insert(arrival);
        let offset_s = arrival.since_s(origin) - box_s;
        let new = Least {
            begun_s: box_s,
            box_s,
            offset_s,
        };
        match self.whiles.back_mut() {
            Some(least) if box_s - least.begun_s < WHILE_S => {
                if offset_s < least.offset_s {
                    (least.box_s, least.offset_s) = (box_s, offset_s);
                }
            }
            Some(least) if offset_s - least.offset_s > STEP_S => {
                // Later than any drift makes it, and this is the first of a while: a step forward.
                self.whiles.clear();
                self.whiles.push_back(new);
            }
            _ => {
                self.whiles.push_back(new);
                if self.whiles.len() > WHILES {
                    self.whiles.pop_front();
                }
            }
        }
        fault
    }

    /// The box has been started anew: its clock begins again, and that is no fault.
    pub fn restart(&mut self) {
        let before = self.last.take();
        self.whiles.clear();
        if let (Some(start), Some((before_s, _))) = (&mut self.fixed, before) {
            *start = start.plus_s(before_s);
        }
    }

    /// The UTC of a time of the box's clock (s), and what is known of that clock. Before anything was
    /// heard it is the arrival.
    #[must_use]
    pub fn time(&self, box_s: f64, arrival: Utc) -> (Utc, Clock) {
        let mut clock = Clock {
            box_s,
            drift_ppm: None,
            drift_sd_ppm: None,
            time_sd_s: None,
        };
        if let Some(start) = self.fixed {
            return (start.plus_s(box_s), clock);
        }
        let (Some(origin), Some(newest)) = (self.origin, self.whiles.back()) else {
            return (arrival, clock);
        };
        let Some(line) = self.line() else {
            return (origin.plus_s(box_s + newest.offset_s), clock);
        };
        clock.drift_ppm = Some(-1e6 * line.slope);
        clock.drift_sd_ppm = Some(1e6 * line.slope_sd);
        let away = box_s - line.middle_s;
        clock.time_sd_s =
            Some((line.scatter_s.powi(2) / line.count + (line.slope_sd * away).powi(2)).sqrt());
        (
            origin.plus_s(box_s + line.level_s + line.slope * away),
            clock,
        )
    }

    /// How much faster the box's clock runs than UTC, millionths.
    #[must_use]
    pub fn drift_ppm(&self) -> Option<f64> {
        self.line().map(|line| -1e6 * line.slope)
    }

    /// The line through the least values.
    fn line(&self) -> Option<Line> {
        if self.whiles.len() < LEAST_WHILES {
            return None;
        }
        let count = self.whiles.len() as f64;
        let mean = |f: fn(&Least) -> f64| self.whiles.iter().map(f).sum::<f64>() / count;
        let (middle_s, level_s) = (mean(|l| l.box_s), mean(|l| l.offset_s));
        let (mut xx, mut xy) = (0.0, 0.0);
        for l in &self.whiles {
            xx += (l.box_s - middle_s).powi(2);
            xy += (l.box_s - middle_s) * (l.offset_s - level_s);
        }
        if xx <= 0.0 {
            return None;
        }
        let slope = xy / xx;
        let rest = |l: &Least| (l.offset_s - level_s - slope * (l.box_s - middle_s)).powi(2);
        let scatter_s = (self.whiles.iter().map(rest).sum::<f64>() / (count - 2.0)).sqrt();
        Some(Line {
            count,
            middle_s,
            level_s,
            slope,
            slope_sd: scatter_s / xx.sqrt(),
            scatter_s,
        })
    }
}

struct Line {
    count: f64,
    middle_s: f64,
    level_s: f64,
    slope: f64,
    slope_sd: f64,
    scatter_s: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(us: i64) -> Utc {
        Utc::from_micros(1_800_000_000_000_000 + us).unwrap()
    }

    proptest! {
        /// A clock of known drift, frames delayed at random: the drift is found within its own
        /// deviation, and times are right to a few milliseconds.
        #[test]
        fn the_drift_is_found(drift_ppm in -80.0..80.0_f64, delays in proptest::collection::vec(0.001..0.2_f64, 2000)) {
            let mut clock = BoxClock::live();
            for (k, delay) in delays.iter().enumerate() {
                let true_s = 10.0 * k as f64;
                let box_s = true_s * (1.0 + 1e-6 * drift_ppm);
                prop_assert_eq!(clock.hears(box_s, at((1e6 * (true_s + delay)) as i64)), None);
            }
            let true_s = 20_000.0;
            let (time, told) = clock.time(true_s * (1.0 + 1e-6 * drift_ppm), at(0));
            let off = told.drift_ppm.unwrap() - drift_ppm;
            prop_assert!(off.abs() < 1.0, "{off} ppm");
            prop_assert!(off.abs() < 6.0 * told.drift_sd_ppm.unwrap() + 0.05, "{off} ppm");
            // The least delay of a while is about 4 ms: what is left is that.
            prop_assert!(time.since_s(at(20_000_000_000)).abs() < 0.03);
        }
    }

    #[test]
    fn time_that_runs_backwards_is_named() {
        let mut clock = BoxClock::live();
        assert_eq!(clock.hears(100.0, at(100_000_000)), None);
        // Frames that overtake each other are no fault.
        assert_eq!(clock.hears(99.9, at(100_000_100)), None);
        let fault = clock.hears(101.0, at(40_000_000));
        assert!(
            matches!(fault, Some(ClockFault::HostBack { seconds }) if (seconds - 60.0).abs() < 0.01)
        );
        let fault = clock.hears(2.0, at(41_000_000));
        assert_eq!(fault, Some(ClockFault::BoxBack { seconds: 99.0 }));
        // And from there on it is right again.
        assert_eq!(clock.time(3.0, at(0)).0, at(42_000_000));
    }

    #[test]
    fn a_step_forward_is_followed_within_a_while() {
        let mut clock = BoxClock::live();
        let _ = clock.hears(0.0, at(0));
        for s in 0..700 {
            let _ = clock.hears(f64::from(s), at(i64::from(s) * 1_000_000 + 3_600_000_000));
        }
        assert_eq!(clock.time(700.0, at(0)).0, at(4_300_000_000));
    }

    #[test]
    fn a_recording_has_the_time_that_it_was_given() {
        let clock = BoxClock::since(at(0));
        assert_eq!(clock.time(12.5, at(99)).0, at(12_500_000));
    }
}
