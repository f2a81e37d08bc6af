//! The main side's end of the current loop: an order is worked out before the loop takes it, and what
//! the loop has counted after, so that the loop is kept away only while both are copied.

use super::CurrentLoop;
use super::channel::{Channel, Scale, Sums};
use crate::board::{COILS, CoilAction, CoilOrder, CoilReport, CoilTrip};
use rarma_box::guard::FaultCode;
use rarma_rigs::cers::Block;

/// The same code for this long while regulating is no current, ms: converters have noise.
const STUCK_MS: u32 = 10;
/// Voltage without current for this long is an open coil, ms.
const OPEN_MS: u32 = 2;
/// A target below this does not tell an open coil, A.
const OPEN_TARGET_A: f32 = 0.1;
/// Less than this part of the target with more than half of the voltage: an open coil.
const OPEN_PART: f32 = 0.3;

/// Where the loop is.
pub trait Held {
    /// Gives the loop for a moment in which its interrupt does not come; none before there is one.
    fn hold<R>(&mut self, act: impl FnOnce(&mut CurrentLoop) -> R) -> Option<R>;
}

impl Held for CurrentLoop {
    fn hold<R>(&mut self, act: impl FnOnce(&mut CurrentLoop) -> R) -> Option<R> {
        Some(act(self))
    }
}

/// An order as the loop wants it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ready {
    pub(super) order: CoilOrder,
    pub(super) scale: Scale,
    /// The order's numbers are numbers.
    pub(super) sound: bool,
}

impl Ready {
    /// Copies field by field: each is short enough for the compiler to move in registers, where it calls
    /// a function for the whole, four times as slow.
    #[inline(always)]
    fn take(&mut self, order: &CoilOrder, scale: Scale, sound: bool) {
        let into = &mut self.order;
        into.action = order.action;
        into.target_a = order.target_a;
        into.per_volt = order.per_volt;
        into.tuning = order.tuning;
        into.quiet = order.quiet;
        into.clear = order.clear;
        into.limits = order.limits;
        match (&order.force, &mut into.force) {
            (Some(force), Some(into)) => {
                let ([x, y], [to_x, to_y]) = (&force.laws, &mut into.laws);
                *to_x = *x;
                *to_y = *y;
                into.gap_span_m = force.gap_span_m;
            }
            (force, into) => *into = *force,
        }
        self.scale = scale;
        self.sound = sound;
    }
}

/// What the loop has counted since the last order, and how it stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted {
    pub(super) sums: [Sums; COILS],
    pub(super) zero_a: [f32; COILS],
    pub(super) periods: u32,
    pub(super) counted: u32,
    /// How often the switches have been closed.
    pub(super) closings: u32,
    pub(super) limited: u32,
    pub(super) regulating: bool,
    pub(super) limiting: bool,
    pub(super) exciting: bool,
    pub(super) trip: Option<CoilTrip>,
    pub(super) block: Option<Block>,
}

/// What the main side keeps of the loop. Slow path: once a millisecond.
#[derive(Debug, Clone, Default)]
pub struct MainSide {
    /// Of the order before.
    target_a: [f32; COILS],
    closings: u32,
    still_ms: [u32; COILS],
    open_ms: [u32; COILS],
}

impl MainSide {
    /// Gives an order, takes what has been seen since the last one; none where no loop is.
    pub fn exchange(&mut self, held: &mut impl Held, order: &CoilOrder) -> Option<CoilReport> {
        let finite = order.target_a.iter().all(|a| a.is_finite());
        let scale = Scale::new(&order.limits);
        let sound = finite && order.per_volt > 0.0 && order.per_volt < 1.0;
        let seen = held.hold(|regulators| regulators.trade(order, scale, sound))?;
        if seen.closings != self.closings {
            // Nothing is known of the time before the switches were closed.
            self.closings = seen.closings;
            (self.still_ms, self.open_ms) = ([0; COILS], [0; COILS]);
        }
        let mut report = CoilReport {
            periods: seen.periods,
            counted: seen.counted,
            zero_a: seen.zero_a,
            regulating: seen.regulating,
            limiting: seen.limiting,
            trip: seen.trip,
            exciting: seen.exciting,
            limited: seen.limited,
            block: seen.block,
            ..CoilReport::default()
        };
        let part = 1.0 / seen.counted.max(1) as f32;
        let mut wrong = None;
        for (k, sums) in seen.sums.iter().enumerate() {
            report.current_a[k] = sums.current_a * part;
            report.square_a2[k] = sums.square_a2 * part;
            report.duty[k] = sums.duty * part;
            wrong = wrong.or(self.wrong(k, seen.counted, sums, &report));
        }
        self.target_a = order.target_a;
        if let Some(trip) = wrong
            && seen.regulating
        {
            report.trip = held.hold(|regulators| regulators.let_go(trip))?;
        }
        Some(report)
    }

    /// What a millisecond's worth tells of a coil: a sensor that does not move, a coil that takes no
    /// current.
    fn wrong(
        &mut self,
        k: usize,
        counted: u32,
        sums: &Sums,
        report: &CoilReport,
    ) -> Option<CoilTrip> {
        let run = |so: bool, n: u32| if so { n.saturating_add(1) } else { 0 };
        let (target_a, current_a) = (self.target_a[k], report.current_a[k]);
        let is_open =
            target_a > OPEN_TARGET_A && report.duty[k] > 0.5 && current_a < OPEN_PART * target_a;
        self.still_ms[k] = run(counted > 0 && sums.changed == 0, self.still_ms[k]);
        self.open_ms[k] = run(is_open, self.open_ms[k]);
        let (code, value) = if self.still_ms[k] >= STUCK_MS {
            (FaultCode::CurrentSensorStuck, f32::from(sums.last))
        } else if self.open_ms[k] >= OPEN_MS {
            (FaultCode::CoilOpen, current_a)
        } else {
            return None;
        };
        Some(CoilTrip {
            code,
            coil: k as u8,
            value,
        })
    }
}

impl CurrentLoop {
    /// An order for what has been counted: copies only, for the loop's interrupt waits. A function
    /// of its own, so that a board can put it into fast memory.
    #[inline(never)]
    fn trade(&mut self, order: &CoilOrder, scale: Scale, sound: bool) -> Counted {
        let was = self.ready.order.action;
        if order.clear {
            self.trip = None;
        }
        if order.action != was {
            self.begin(order.action);
        }
        self.ready.take(order, scale, sound);
        if order.quiet
            && let Some(signal) = &mut self.signal
        {
            signal.end();
        }
        self.age = 0;
        let [a, b, c, d] = &mut self.channels;
        Counted {
            zero_a: [a.zero_a, b.zero_a, c.zero_a, d.zero_a],
            sums: [a.counted(), b.counted(), c.counted(), d.counted()],
            periods: self.periods,
            counted: core::mem::take(&mut self.counted),
            closings: self.closings,
            limited: self.limited,
            regulating: self.closed,
            limiting: core::mem::take(&mut self.limiting),
            exciting: self.signal.is_some(),
            trip: self.trip,
            block: self.block.take(),
        }
    }

    /// Another action than before.
    #[cold]
    #[inline(never)]
    fn begin(&mut self, action: CoilAction) {
        if action == CoilAction::Calibrate {
            self.zero_count = 0;
            self.channels
                .iter_mut()
                .for_each(Channel::begin_calibration);
        } else if self.ready.order.action == CoilAction::Calibrate && self.zero_count > 0 {
            for channel in &mut self.channels {
                channel.end_calibration(self.zero_count);
            }
        }
    }
}
