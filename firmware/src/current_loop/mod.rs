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

mod channel;
mod order;

pub use order::{CoilAction, CoilLimits, CoilOrder, CoilReport, CoilTrip, ForceScale};

use crate::board::{AdcCode, COILS, CoilBridge};
use channel::{Channel, LOST_PERIODS, Scale};
use rarma_core::cers::{Block, Seen, Source};
use rarma_core::guard::FaultCode;

/// The loop. The board owns it where its interrupt is.
#[derive(Debug, Clone, Default)]
pub struct CurrentLoop {
    order: CoilOrder,
    channels: [Channel; COILS],
    periods: u32,
    age: u32,
    counted: u32,
    zero_count: u32,
    missed: u32,
    scale: Scale,
    /// The order's numbers are numbers.
    sound: bool,
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

    /// Main side: starts a signal on top of the targets, + in the coils +x and +y, − in −x and
    /// −y. It runs until it is over, another one starts, or the switches open.
    pub fn excite(&mut self, signal: &Source) {
        self.signal = Some(*signal);
    }

    /// Main side: gives an order, takes what has been seen since the last one.
    pub fn exchange(&mut self, order: &CoilOrder) -> CoilReport {
        if order.clear {
            self.trip = None;
        }
        if order.action == CoilAction::Calibrate && self.order.action != CoilAction::Calibrate {
            self.zero_count = 0;
            for channel in &mut self.channels {
                channel.begin_calibration();
            }
        }
        if self.order.action == CoilAction::Calibrate
            && order.action != CoilAction::Calibrate
            && self.zero_count > 0
        {
            for channel in &mut self.channels {
                channel.end_calibration(self.zero_count);
            }
        }
        let past = self.order;
        self.order = *order;
        self.order.clear = false;
        self.scale = Scale::new(&order.limits);
        let finite = order.target_a.iter().all(|a| a.is_finite());
        self.sound = finite && order.per_volt > 0.0 && order.per_volt < 1.0;
        if order.quiet
            && let Some(signal) = &mut self.signal
        {
            signal.end();
        }
        self.age = 0;
        let (mut means, mut wrong) = ([None; COILS], None);
        let channels = self.channels.iter_mut().zip(&mut means).enumerate();
        for (k, (channel, means)) in channels {
            let (mean, odd) = channel.exchange(self.counted, k, &past);
            *means = Some(mean);
            wrong = wrong.or(odd.map(|(code, value)| (code, k as u8, value)));
        }
        if self.closed
            && let Some((code, coil, value)) = wrong
        {
            self.let_go(code, coil, value);
        }
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
        for (k, (channel, mean)) in self.channels.iter().zip(means).enumerate() {
            let Some(mean) = mean else { continue };
            report.current_a[k] = mean.current_a;
            report.square_a2[k] = mean.square_a2;
            report.duty[k] = mean.duty;
            report.zero_a[k] = channel.zero_a;
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
                    self.let_go(FaultCode::Bridge, 0, self.missed as f32);
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
                    channel.restart();
                }
                self.closed = true;
            }
            let change = self.change(bridge);
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

    /// Codes to currents, and what can be told from them at once.
    #[inline]
    fn read(&mut self, codes: &[AdcCode; COILS]) {
        self.counted += 1;
        let mut doubtful = false;
        for (channel, code) in self.channels.iter_mut().zip(codes) {
            doubtful |= channel.take(*code, &self.scale);
        }
        if self.order.action == CoilAction::Calibrate {
            self.zero_count = self.zero_count.wrapping_add(1);
            for channel in &mut self.channels {
                channel.calibrate(&self.scale);
            }
        }
        if doubtful && self.closed {
            let mut each = self.channels.iter().enumerate();
            if let Some((k, (code, value))) = each.find_map(|(k, c)| Some((k, c.accuse()?))) {
                self.let_go(code, k as u8, value);
            }
        }
    }

    /// The signal's change of the currents in x and y, A; shows it what it has done.
    #[inline]
    fn change<B: CoilBridge>(&mut self, bridge: &mut B) -> [f32; 2] {
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
        if !(self.sound && (dx + dy).is_finite()) {
            self.let_go(FaultCode::NotFinite, 0, 0.0);
            return duty;
        }
        let mut held = false;
        let most = order.limits.most_target_a;
        let [xp, xm, yp, ym] = order.target_a;
        let wanted = [xp + dx, xm - dx, yp + dy, ym - dy];
        let channels = self.channels.iter_mut().zip(&order.tuning).zip(&wanted);
        for (((channel, tuning), wanted), duty) in channels.zip(&mut duty) {
            let mut target = *wanted;
            // A limit that is not a number lets nothing through.
            if !(target <= most) {
                target = most.max(0.0);
                held = true;
            }
            if target < 0.0 {
                target = 0.0;
                held = true;
            }
            let drive = channel
                .regulator
                .update(tuning, target, channel.current_a, order.per_volt);
            held |= drive.limiting;
            channel.duty = drive.duty;
            channel.sum_duty += drive.duty;
            *duty = drive.duty;
        }
        self.limiting |= held;
        self.limited = self
            .limited
            .wrapping_add(u32::from(held && self.signal.is_some()));
        duty
    }
}
