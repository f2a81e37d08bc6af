//! One coil as the fast side knows it: its current, its regulator, and what is odd about it.
//!
//! What cannot wait is looked at in every period: a sensor at the end of its range, too much
//! current. A sensor that does not move and a coil that takes no current are told from a
//! millisecond's worth.

use crate::board::{AdcCode, CoilLimits};
use rarma_box::guard::FaultCode;
use rarma_rigs::cers::Regulator;

/// Periods in a row with a sensor at the end of its range, or without a conversion, that
/// are a fault: one is a disturbance.
pub(super) const LOST_PERIODS: u32 = 3;
/// Periods in a row beyond the limit that are a fault.
const OVER_PERIODS: u32 = 2;
/// Codes nearer to an end of the range than this are no current: 1 %.
const RAIL: u16 = 655;
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

/// What a channel counts between two orders.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub(super) current_a: f32,
    pub(super) square_a2: f32,
    pub(super) duty: f32,
    /// The last code, and the bits that have changed.
    pub(super) last: u16,
    pub(super) changed: u16,
}

#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Channel {
    pub(super) regulator: Regulator,
    pub(super) current_a: f32,
    /// Of the period that runs, as a part of the supply.
    pub(super) duty: f32,
    pub(super) zero_a: f32,
    pub(super) sums: Sums,
    lost: u32,
    over: u32,
    zero_sum: f32,
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
        let sums = &mut self.sums;
        sums.changed |= code ^ sums.last;
        sums.last = code;
        let i = self.current_a;
        sums.current_a += i;
        sums.square_a2 += i * i;
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
            Some((FaultCode::CurrentSensorLost, f32::from(self.sums.last)))
        } else if self.over >= OVER_PERIODS {
            Some((FaultCode::OverCurrent, self.current_a))
        } else {
            None
        }
    }

    /// Switches open: the code is the sensor's zero, an end of its range too.
    #[inline]
    pub(super) fn calibrate(&mut self, scale: &Scale) {
        self.zero_sum += scale.raw_a(self.sums.last);
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
        (self.lost, self.over) = (0, 0);
    }

    /// What has been counted since the last call.
    pub(super) fn counted(&mut self) -> Sums {
        let last = self.sums.last;
        let new = Sums {
            last,
            ..Sums::default()
        };
        core::mem::replace(&mut self.sums, new)
    }
}
