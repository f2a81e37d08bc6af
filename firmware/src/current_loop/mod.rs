//! The current loop: four coils, their regulators, and the trips that cannot wait.
//!
//! Rate: once a PWM period, in the interrupt of the current converter
//! ([`CurrentLoop::period`]). Fast path: fixed work, no allocation, no logging. The main
//! side exchanges an order for a report once a millisecond ([`MainSide::exchange`]); the loop is kept
//! away while a few words are copied, in a critical section on a real board.
//!
//! A signal ([`Source`]) runs on top of the targets; one that measures is shown the force and
//! the motion of every period. It starts and ends with the orders of the main side, and with
//! the switches.
//!
//! The loop switches off by itself, for good until it is told to forget, when an order is
//! older than its lease: a main side that hangs cannot leave a coil on.

mod channel;
mod main_side;

pub use main_side::{Held, MainSide};

use crate::board::{AdcCode, COILS, CoilAction, CoilBridge, CoilTrip};
use channel::{Channel, LOST_PERIODS};
use main_side::Ready;
use rarma_box::guard::FaultCode;
use rarma_rigs::cers::{Block, Seen, Source};

/// The loop. The board owns it where its interrupt is.
#[derive(Debug, Clone, Default)]
pub struct CurrentLoop {
    ready: Ready,
    channels: [Channel; COILS],
    periods: u32,
    age: u32,
    counted: u32,
    zero_count: u32,
    missed: u32,
    /// How often the switches have been closed.
    closings: u32,
    limiting: bool,
    closed: bool,
    trip: Option<CoilTrip>,
    signal: Option<Source>,
    /// The signal's change of the currents in x and y, A; none before its first period.
    change: Option<[f32; 2]>,
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
        self.change = None;
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
                    self.trips(FaultCode::Bridge, 0, self.missed as f32);
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
            self.trips(FaultCode::Comparator, coil, current);
        }
        if self.closed && self.age > self.ready.order.limits.lease_periods {
            self.trips(FaultCode::OrderStale, 0, self.age as f32);
        }
        if self.ready.order.action == CoilAction::Regulate && self.trip.is_none() {
            if !self.closed {
                bridge.rearm();
                for channel in &mut self.channels {
                    channel.restart();
                }
                self.closed = true;
                self.closings = self.closings.wrapping_add(1);
            }
            let duty = self.regulate();
            if self.trip.is_none() {
                if bridge.set_duty(duty).is_err() {
                    self.trips(FaultCode::Bridge, 0, 0.0);
                } else {
                    self.look_ahead(bridge);
                    return;
                }
            }
        }
        // Every other path ends here, at every period.
        bridge.off();
        self.closed = false;
        self.signal = None;
        self.change = None;
        for channel in &mut self.channels {
            channel.duty = 0.0;
        }
    }

    fn trips(&mut self, code: FaultCode, coil: u8, value: f32) {
        self.let_go(CoilTrip { code, coil, value });
    }

    /// Trips, unless it has tripped already; why it has.
    fn let_go(&mut self, trip: CoilTrip) -> Option<CoilTrip> {
        self.trip = self.trip.or(Some(trip));
        self.trip
    }

    /// Codes to currents, and what can be told from them at once.
    #[inline]
    fn read(&mut self, codes: &[AdcCode; COILS]) {
        self.counted += 1;
        let mut doubtful = false;
        for (channel, code) in self.channels.iter_mut().zip(codes) {
            doubtful |= channel.take(*code, &self.ready.scale);
        }
        if self.ready.order.action == CoilAction::Calibrate {
            self.zero_count = self.zero_count.wrapping_add(1);
            for channel in &mut self.channels {
                channel.calibrate(&self.ready.scale);
            }
        }
        if doubtful && self.closed {
            let mut each = self.channels.iter().enumerate();
            if let Some((k, (code, value))) = each.find_map(|(k, c)| Some((k, c.accuse()?))) {
                self.trips(code, k as u8, value);
            }
        }
    }

    /// Shows the signal what it has done, and takes its change of the next period: when this period's
    /// duty is out, so that the duty need not wait for either.
    #[inline]
    fn look_ahead<B: CoilBridge>(&mut self, bridge: &mut B) {
        let Some(signal) = &mut self.signal else {
            self.change = None;
            return;
        };
        if self.change.is_some()
            && let (Some(axis), Some(scale)) = (signal.measures(), &self.ready.order.force)
        {
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
            if block.is_some() {
                self.block = block;
            }
        }
        self.change = signal.next_period();
        if self.change.is_none() {
            self.signal = None;
        }
    }

    #[inline]
    fn regulate(&mut self) -> [f32; COILS] {
        let mut duty = [0.0; COILS];
        let [dx, dy] = self.change.unwrap_or([0.0; 2]);
        let order = &self.ready.order;
        if !(self.ready.sound && (dx + dy).is_finite()) {
            self.trips(FaultCode::NotFinite, 0, 0.0);
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
            channel.sums.duty += drive.duty;
            *duty = drive.duty;
        }
        self.limiting |= held;
        self.limited = self
            .limited
            .wrapping_add(u32::from(held && self.signal.is_some()));
        duty
    }
}
