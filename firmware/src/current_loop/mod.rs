//! The current loop: four coils, their regulators, and the trips that cannot wait.
//!
//! Rate: once a PWM period, in the interrupt of the current converter
//! ([`CurrentLoop::period`]). Fast path: fixed work, no allocation, no logging. The main
//! side exchanges an order for a report once a millisecond ([`CurrentLoop::exchange`], a
//! copy of a few words, in a critical section on a real board).
//!
//! A signal ([`Source`]) runs on top of the targets; one that measures is shown the force and
//! the motion of every period. It starts and ends with the orders of the main side, and with
//! the switches.
//!
//! The loop switches off by itself, for good until it is told to forget, when an order is
//! older than its lease: a main side that hangs cannot leave a coil on.

mod order;

pub use order::{CoilAction, CoilLimits, CoilOrder, CoilReport, CoilTrip, ForceScale};

use crate::board::{AdcCode, COILS, CoilBridge};
use rarma_core::cers::{Block, Regulator, Seen, Source};
use rarma_core::guard::FaultCode;

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
    signal: Option<Source>,
    limited: u32,
    block: Option<Block>,
}

impl CurrentLoop {
    /// A loop that has no order: off.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether the signal that runs wants the displacements: a board may leave them out
    /// otherwise.
    #[inline]
    pub fn measures(&self) -> bool {
        self.signal.as_ref().is_some_and(|s| s.measures().is_some())
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
        if let Some(signal) = self.order.signal.take() {
            self.signal = Some(signal);
        }
        if order.quiet
            && let Some(signal) = &mut self.signal
        {
            signal.end();
        }
        self.age = 0;
        let mut report = CoilReport {
            periods: self.periods,
            counted: self.counted,
            regulating: self.closed,
            limiting: self.limiting,
            trip: self.trip,
            exciting: self.signal.is_some(),
            limited: self.limited,
            block: self.block.take(),
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
            let change = self.excite(bridge);
            let duty = self.regulate(change);
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
        self.signal = None;
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

    /// The signal's change of the currents in x and y, A; shows it what it has done.
    #[inline]
    fn excite<B: CoilBridge>(&mut self, bridge: &mut B) -> [f32; 2] {
        let Some(signal) = &mut self.signal else {
            return [0.0; 2];
        };
        let change = signal.next_period();
        if let (Some(axis), Some(scale)) = (signal.measures(), &self.order.force) {
            let gaps = bridge.gaps();
            let [xp, xm, yp, ym] = &self.channels;
            let (plus, minus) = if axis == 0 { (xp, xm) } else { (yp, ym) };
            let [law_x, law_y] = &scale.laws;
            let law = if axis == 0 { law_x } else { law_y };
            // The sensors look at the gaps of the + magnets.
            let [gap_x, gap_y] = gaps.map(|code| code.fraction() * scale.gap_span_m);
            let [x, y] = [law_x.gap_m - gap_x, law_y.gap_m - gap_y];
            let along = if axis == 0 { x } else { y };
            let force = law.force(plus.current_a, minus.current_a, along);
            let block = signal.see(&Seen {
                force_n: force.newton,
                displacement_m: [x, y],
                trusted: force.trusted,
            });
            self.block = block.or(self.block);
        }
        if change.is_none() {
            self.signal = None;
        }
        change.unwrap_or([0.0; 2])
    }

    #[inline]
    fn regulate(&mut self, [dx, dy]: [f32; 2]) -> [f32; COILS] {
        let mut duty = [0.0; COILS];
        let order = &self.order;
        let mut broken = None;
        let exciting = self.signal.is_some();
        let mut held = false;
        let wanted = order.target_a.iter().zip([dx, -dx, dy, -dy]);
        let wanted = wanted.map(|(bias, change)| bias + change);
        let channels = self.channels.iter_mut().zip(&order.tuning).zip(wanted);
        for ((k, ((channel, tuning), wanted)), duty) in channels.enumerate().zip(&mut duty) {
            if !(wanted.is_finite() && order.per_volt > 0.0 && order.per_volt < 1.0) {
                broken = Some(k as u8);
                continue;
            }
            let target = wanted.min(order.limits.most_target_a.max(0.0)).max(0.0);
            let drive = channel
                .regulator
                .update(tuning, target, channel.current_a, order.per_volt);
            held |= drive.limiting || target != wanted;
            channel.duty = drive.duty;
            *duty = drive.duty;
        }
        self.limiting |= held;
        self.limited = self.limited.wrapping_add(u32::from(held && exciting));
        if let Some(coil) = broken {
            self.let_go(FaultCode::NotFinite, coil, 0.0);
        }
        duty
    }
}
