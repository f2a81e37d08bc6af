//! The current loop: four coils, their regulators, and the trips that cannot wait.
//!
//! Rate: once a PWM period, in the interrupt of the current converter
//! ([`CurrentLoop::period`]). Fast path: fixed work, no allocation, no logging. The main
//! side exchanges an order for a report once a millisecond ([`CurrentLoop::exchange`], a
//! copy of a few words, in a critical section on a real board).
//!
//! The loop switches off by itself, for good until it is told to forget, when an order is
//! older than its lease: a main side that hangs cannot leave a coil on.

use crate::board::{AdcCode, COILS, CoilBridge};
use rarma_core::cers::{Regulator, Tuning};
use rarma_core::guard::FaultCode;

/// What the loop is to do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum CoilAction {
    /// Nothing: switches open.
    #[default]
    Off,
    /// Switches open; take the mean of the currents as their zeros.
    Calibrate,
    /// Regulate to the targets.
    Regulate,
}

/// What the loop may never exceed, and how it reads its sensors.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CoilLimits {
    /// Current from one end of the sensor's range to the other, A; zero is in its middle.
    pub span_a: f32,
    /// A target is cut to 0..=this, A.
    pub most_target_a: f32,
    /// A measured current beyond this is a fault, A.
    pub trip_a: f32,
    /// An order lasts this many periods.
    pub lease_periods: u32,
    /// Periods in 1 ms.
    pub periods_per_ms: u32,
}

/// What the main side tells the loop. Any order renews the lease.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CoilOrder {
    /// What to do.
    pub action: CoilAction,
    /// Currents wanted, A.
    pub target_a: [f32; COILS],
    /// 1/supply voltage, 1/V.
    pub per_volt: f32,
    /// Coefficients.
    pub tuning: Tuning,
    /// Limits.
    pub limits: CoilLimits,
    /// Forget a trip.
    pub clear: bool,
}

/// Why the loop has let go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoilTrip {
    /// What.
    pub code: FaultCode,
    /// Which coil.
    pub coil: u8,
    /// With which value, in the unit of the code.
    pub value: f32,
}

/// What the loop tells the main side: means since the last exchange.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CoilReport {
    /// Periods since start-up.
    pub periods: u32,
    /// Periods in the means below.
    pub counted: u32,
    /// Mean current, A.
    pub current_a: [f32; COILS],
    /// Mean square of the current, A².
    pub square_a2: [f32; COILS],
    /// Mean duty.
    pub duty: [f32; COILS],
    /// Currents that were measured as zero, A.
    pub zero_a: [f32; COILS],
    /// Switches may be closed.
    pub regulating: bool,
    /// A target was cut, or the supply held a current back.
    pub limiting: bool,
    /// Why the loop has let go, since it has.
    pub trip: Option<CoilTrip>,
}

/// Periods in a row with a sensor at the end of its range, or without a conversion, that
/// are a fault: one is a disturbance.
const LOST_PERIODS: u8 = 3;
/// Periods in a row beyond the limit that are a fault.
const OVER_PERIODS: u8 = 2;
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

#[derive(Debug, Clone, Copy, Default)]
struct Channel {
    regulator: Regulator,
    zero_a: f32,
    current_a: f32,
    last: AdcCode,
    same: u32,
    lost: u8,
    over: u8,
    open: u32,
    sum_a: f32,
    sum_a2: f32,
    sum_duty: f32,
    duty: f32,
    zero_sum: f32,
}

/// The loop. The board owns it where its interrupt is.
#[derive(Debug, Clone, Default)]
pub struct CurrentLoop {
    order: CoilOrder,
    channels: [Channel; COILS],
    periods: u32,
    age: u32,
    counted: u32,
    zero_count: u32,
    missed: u8,
    limiting: bool,
    closed: bool,
    trip: Option<CoilTrip>,
}

impl CurrentLoop {
    /// A loop that has no order: off.
    pub fn new() -> Self {
        Self::default()
    }

    /// Main side: gives an order, takes what has been seen since the last one.
    pub fn exchange(&mut self, order: &CoilOrder) -> CoilReport {
        if order.clear {
            self.trip = None;
        }
        if order.action == CoilAction::Calibrate && self.order.action != CoilAction::Calibrate {
            self.zero_count = 0;
            for channel in &mut self.channels {
                channel.zero_sum = 0.0;
            }
        }
        if self.order.action == CoilAction::Calibrate
            && order.action != CoilAction::Calibrate
            && self.zero_count > 0
        {
            let part = 1.0 / self.zero_count as f32;
            for channel in &mut self.channels {
                channel.zero_a = channel.zero_sum * part;
            }
        }
        self.order = *order;
        self.order.clear = false;
        self.age = 0;
        let mut report = CoilReport {
            periods: self.periods,
            counted: self.counted,
            regulating: self.closed,
            limiting: self.limiting,
            trip: self.trip,
            ..CoilReport::default()
        };
        let part = 1.0 / self.counted.max(1) as f32;
        for (k, channel) in self.channels.iter_mut().enumerate() {
            report.current_a[k] = channel.sum_a * part;
            report.square_a2[k] = channel.sum_a2 * part;
            report.duty[k] = channel.sum_duty * part;
            report.zero_a[k] = channel.zero_a;
            channel.sum_a = 0.0;
            channel.sum_a2 = 0.0;
            channel.sum_duty = 0.0;
        }
        self.counted = 0;
        self.limiting = false;
        report
    }

    /// Fast side: one PWM period.
    #[inline]
    pub fn period<B: CoilBridge>(&mut self, bridge: &mut B) {
        self.periods = self.periods.wrapping_add(1);
        self.age = self.age.saturating_add(1);
        let broken = bridge.broken();
        match bridge.currents() {
            Ok(codes) => {
                self.missed = 0;
                self.read(&codes);
            }
            Err(_) => {
                self.missed = self.missed.saturating_add(1);
                if self.missed >= LOST_PERIODS && self.closed {
                    self.let_go(FaultCode::Bridge, 0, f32::from(self.missed));
                }
            }
        }
        if let Some(coil) = broken
            && self.closed
        {
            let current = self
                .channels
                .get(usize::from(coil))
                .map_or(0.0, |c| c.current_a);
            self.let_go(FaultCode::Comparator, coil, current);
        }
        if self.closed && self.age > self.order.limits.lease_periods {
            self.let_go(FaultCode::OrderStale, 0, self.age as f32);
        }
        if self.order.action == CoilAction::Regulate && self.trip.is_none() {
            if !self.closed {
                bridge.rearm();
                for channel in &mut self.channels {
                    channel.regulator.reset();
                    (channel.same, channel.lost, channel.over, channel.open) = (0, 0, 0, 0);
                }
                self.closed = true;
            }
            let duty = self.regulate();
            if self.trip.is_none() {
                if bridge.set_duty(duty).is_err() {
                    self.let_go(FaultCode::Bridge, 0, 0.0);
                } else {
                    return;
                }
            }
        }
        // Every other path ends here, at every period.
        bridge.off();
        self.closed = false;
        for channel in &mut self.channels {
            channel.duty = 0.0;
        }
    }

    fn let_go(&mut self, code: FaultCode, coil: u8, value: f32) {
        if self.trip.is_none() {
            self.trip = Some(CoilTrip { code, coil, value });
        }
    }

    /// Codes to currents, and what can be told from them.
    #[inline]
    fn read(&mut self, codes: &[AdcCode; COILS]) {
        self.counted += 1;
        let limits = self.order.limits;
        let calibrating = self.order.action == CoilAction::Calibrate;
        if calibrating {
            self.zero_count += 1;
        }
        let mut found: Option<CoilTrip> = None;
        let (stuck, open) = (
            STUCK_MS * limits.periods_per_ms,
            OPEN_MS * limits.periods_per_ms,
        );
        for (k, (channel, &code)) in self.channels.iter_mut().zip(codes).enumerate() {
            let fault = |code, value| {
                Some(CoilTrip {
                    code,
                    coil: k as u8,
                    value,
                })
            };
            let at_end = code.0 < RAIL || code.0 > u16::MAX - RAIL;
            let raw_a = (code.fraction() - 0.5) * limits.span_a;
            if calibrating {
                channel.zero_sum += raw_a;
            }
            if at_end {
                // The last current stands in for one or two periods.
                channel.lost = channel.lost.saturating_add(1);
                if channel.lost >= LOST_PERIODS {
                    found = found.or(fault(FaultCode::CurrentSensorLost, f32::from(code.0)));
                }
            } else {
                channel.lost = 0;
                channel.current_a = raw_a - channel.zero_a;
            }
            channel.same = if code == channel.last {
                channel.same.saturating_add(1)
            } else {
                0
            };
            channel.last = code;
            if channel.same >= stuck {
                found = found.or(fault(FaultCode::CurrentSensorStuck, f32::from(code.0)));
            }
            let i = channel.current_a;
            channel.over = if i.abs() > limits.trip_a {
                channel.over.saturating_add(1)
            } else {
                0
            };
            if channel.over >= OVER_PERIODS {
                found = found.or(fault(FaultCode::OverCurrent, i));
            }
            let target = self.order.target_a[k];
            let idle = target > OPEN_TARGET_A && channel.duty > 0.5 && i < OPEN_PART * target;
            channel.open = if idle {
                channel.open.saturating_add(1)
            } else {
                0
            };
            if channel.open >= open {
                found = found.or(fault(FaultCode::CoilOpen, i));
            }
            channel.sum_a += i;
            channel.sum_a2 += i * i;
            channel.sum_duty += channel.duty;
        }
        if let Some(trip) = found
            && self.closed
        {
            self.let_go(trip.code, trip.coil, trip.value);
        }
    }

    #[inline]
    fn regulate(&mut self) -> [f32; COILS] {
        let mut duty = [0.0; COILS];
        let order = &self.order;
        let mut broken = None;
        let channels = self.channels.iter_mut().zip(order.target_a);
        for ((k, (channel, wanted)), duty) in channels.enumerate().zip(&mut duty) {
            if !(wanted.is_finite() && order.per_volt > 0.0 && order.per_volt < 1.0) {
                broken = Some(k as u8);
                continue;
            }
            let target = wanted.min(order.limits.most_target_a.max(0.0)).max(0.0);
            let drive =
                channel
                    .regulator
                    .update(&order.tuning, target, channel.current_a, order.per_volt);
            self.limiting |= drive.limiting || target != wanted;
            channel.duty = drive.duty;
            *duty = drive.duty;
        }
        if let Some(coil) = broken {
            self.let_go(FaultCode::NotFinite, coil, 0.0);
        }
        duty
    }
}
