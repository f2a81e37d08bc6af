//! One coil as the fast side knows it: its current, its regulator, and what is odd about it.
//!
//! What cannot wait is looked at in every period: a sensor at the end of its range, too much
//! current. A sensor that does not move and a coil that takes no current are told from a
//! millisecond's worth.

use super::order::{CoilLimits, CoilOrder};
use crate::board::AdcCode;
use rarma_core::cers::Regulator;
use rarma_core::guard::FaultCode;

/// Periods in a row with a sensor at the end of its range, or without a conversion, that
/// are a fault: one is a disturbance.
pub(super) const LOST_PERIODS: u32 = 3;
/// Periods in a row beyond the limit that are a fault.
const OVER_PERIODS: u32 = 2;
/// Codes nearer to an end of the range than this are no current: 1 %.
const RAIL: u16 = 655;
/// The same code for this long while regulating is no current, ms: converters have noise.
const STUCK_MS: u32 = 10;
/// Voltage without current for this long is an open coil, ms.
const OPEN_MS: u32 = 2;
/// A target below this does not tell an open coil, A.
const OPEN_TARGET_A: f32 = 0.1;
/// Less than this part of the target with more than half of the voltage: an open coil.
const OPEN_PART: f32 = 0.3;

/// An order's limits as every period wants them: worked out once a millisecond.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Scale {
    a_per_code: f32,
    middle_a: f32,
    trip_a: f32,
}

impl Scale {
    pub(super) fn new(limits: &CoilLimits) -> Self {
        Self {
            a_per_code: limits.span_a * (1.0 / 65_535.0),
            middle_a: 0.5 * limits.span_a,
            trip_a: limits.trip_a,
        }
    }

    #[inline(always)]
    fn raw_a(&self, code: u16) -> f32 {
        f32::from(code) * self.a_per_code - self.middle_a
    }
}

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Channel {
    pub(super) regulator: Regulator,
    pub(super) current_a: f32,
    /// Of the period that runs, as a part of the supply.
    pub(super) duty: f32,
    pub(super) sum_duty: f32,
    pub(super) zero_a: f32,
    sum_a: f32,
    sum_a2: f32,
    last: u16,
    /// Bits of the code that have changed since the last exchange.
    changed: u16,
    lost: u32,
    over: u32,
    still_ms: u32,
    open_ms: u32,
    zero_sum: f32,
}

/// Means of a channel over a millisecond.
#[derive(Debug, Clone, Copy)]
pub(super) struct Means {
    pub(super) current_a: f32,
    pub(super) square_a2: f32,
    pub(super) duty: f32,
}

impl Channel {
    /// Fast side: this period's code. True if there is something to [`Self::accuse`].
    #[inline(always)]
    pub(super) fn take(&mut self, code: AdcCode, scale: &Scale) -> bool {
        let code = code.0;
        let at_end = code.wrapping_sub(RAIL) > u16::MAX - 2 * RAIL;
        if !at_end {
            self.current_a = scale.raw_a(code) - self.zero_a;
        }
        self.changed |= code ^ self.last;
        self.last = code;
        let i = self.current_a;
        self.sum_a += i;
        self.sum_a2 += i * i;
        let over = i.abs() > scale.trip_a;
        if at_end || over {
            return self.odd(at_end, over);
        }
        self.lost = 0;
        self.over = 0;
        false
    }

    /// The last current stands in for a lost one, for one or two periods.
    #[cold]
    fn odd(&mut self, at_end: bool, over: bool) -> bool {
        let run = |so: bool, n: u32| if so { n.saturating_add(1) } else { 0 };
        self.lost = run(at_end, self.lost);
        self.over = run(over, self.over);
        self.accuse().is_some()
    }

    /// What is wrong, with which value.
    pub(super) fn accuse(&self) -> Option<(FaultCode, f32)> {
        if self.lost >= LOST_PERIODS {
            Some((FaultCode::CurrentSensorLost, f32::from(self.last)))
        } else if self.over >= OVER_PERIODS {
            Some((FaultCode::OverCurrent, self.current_a))
        } else {
            None
        }
    }

    /// Switches open: the code is the sensor's zero, an end of its range too.
    #[inline]
    pub(super) fn calibrate(&mut self, scale: &Scale) {
        self.zero_sum += scale.raw_a(self.last);
    }

    pub(super) fn begin_calibration(&mut self) {
        self.zero_sum = 0.0;
    }

    pub(super) fn end_calibration(&mut self, periods: u32) {
        self.zero_a = self.zero_sum / periods.max(1) as f32;
    }

    /// Nothing is known of the time before the switches are closed.
    pub(super) fn restart(&mut self) {
        self.regulator.reset();
        (self.lost, self.over, self.still_ms, self.open_ms) = (0, 0, 0, 0);
    }

    /// Once a millisecond: the means since the last call, and what is wrong with them.
    pub(super) fn exchange(
        &mut self,
        counted: u32,
        coil: usize,
        order: &CoilOrder,
    ) -> (Means, Option<(FaultCode, f32)>) {
        let part = 1.0 / counted.max(1) as f32;
        let means = Means {
            current_a: self.sum_a * part,
            square_a2: self.sum_a2 * part,
            duty: self.sum_duty * part,
        };
        let still = counted > 0 && self.changed == 0;
        (self.sum_a, self.sum_a2, self.sum_duty, self.changed) = (0.0, 0.0, 0.0, 0);
        let target = order.target_a.get(coil).copied().unwrap_or(0.0);
        let open =
            target > OPEN_TARGET_A && means.duty > 0.5 && means.current_a < OPEN_PART * target;
        let run = |so: bool, n: u32| if so { n.saturating_add(1) } else { 0 };
        self.still_ms = run(still, self.still_ms);
        self.open_ms = run(open, self.open_ms);
        let wrong = if self.still_ms >= STUCK_MS {
            Some((FaultCode::CurrentSensorStuck, f32::from(self.last)))
        } else if self.open_ms >= OPEN_MS {
            Some((FaultCode::CoilOpen, means.current_a))
        } else {
            None
        };
        (means, wrong)
    }
}
