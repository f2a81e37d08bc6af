//! The watch over the test rigs' slow signals: coils' heat and resistance, gaps, supply,
//! spindle, pressure, gauge.
//!
//! Rate: once a millisecond. What is found is handed over as it is found; whether it
//! stops anything is the supervisor's to say.

use super::fault::FaultCode;
use super::mode::Mode;
use super::watch::{Disobedience, Follows, Heat, InARow, Still, thermistor_k};

/// Coils, gaps.
const COILS: usize = 4;
const GAPS: usize = 2;
/// Codes nearer to an end of the range than this are no signal: 1 %.
const RAIL: u16 = 655;
/// Bad readings in a row that are a fault, ms.
const BAD_MS: u32 = 2;
/// A displacement that does not move at all for this long, ms.
const STILL_MS: u32 = 100;
/// The transducer's live zero and full scale as parts of the range.
const LIVE: (f32, f32) = (0.1, 0.9);
/// Below and above these parts of the range the transducer is not there.
const LIVE_LOST: (f32, f32) = (0.05, 0.95);
/// A coil below this part of its resistance for [`SHORT_MS`] has shorted turns.
const SHORT_PART: f32 = 0.5;
const SHORT_MS: u32 = 20;
/// Currents below this do not tell a resistance, A.
const SHORT_CURRENT_A: f32 = 0.2;
/// A pressure beyond this many times the greatest set point is a fault.
const PRESSURE_PART: f32 = 1.1;
/// Parts of the nominal gap: warn, trip.
pub const GAP_WARN: f32 = 0.5;
/// See [`GAP_WARN`].
pub const GAP_TRIP: f32 = 0.35;

/// Limits and scales, SI. Made from the settings when outputs are armed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigLimits {
    /// Current a winding carries for ever, A, and its thermal time constant, s.
    pub nominal_a: f32,
    /// See [`Self::nominal_a`].
    pub thermal_s: f32,
    /// Resistance of a coil, Ω.
    pub resistance_ohm: f32,
    /// Nominal gap, and gap at the converter's upper end, m.
    pub gap_m: f32,
    /// See [`Self::gap_m`].
    pub gap_span_m: f32,
    /// Least and greatest supply, and supply at the converter's upper end, V.
    pub supply_v: (f32, f32),
    /// See [`Self::supply_v`].
    pub supply_span_v: f32,
    /// Greatest temperature of a winding, K, and B of the thermistor, K; 0: there is none.
    pub winding_k: f32,
    /// See [`Self::winding_k`].
    pub thermistor_b_k: f32,
    /// Greatest spindle frequency, Hz.
    pub overspeed_hz: f32,
    /// Greatest pressure set point, Pa.
    pub most_pa: f32,
    /// Pressure from live zero to full scale, Pa.
    pub pressure_span_pa: f32,
    /// See [`Follows::update`].
    pub tolerance_pa: f32,
    /// See [`Follows::update`].
    pub settle_s: f32,
    /// See [`Follows::update`].
    pub lag_s: f32,
    /// Length from end to end of the gauge's range, and its limit, m.
    pub gauge_span_m: f32,
    /// See [`Self::gauge_span_m`].
    pub gauge_limit_m: f32,
}

/// One millisecond's codes, left-aligned: 0 to 65535 is the converter's range.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RigCodes {
    /// Displacements.
    pub gap: [u16; GAPS],
    /// Pressure transducer.
    pub pressure: u16,
    /// Length gauge.
    pub gauge: u16,
    /// Supply.
    pub supply: u16,
}

/// The coils over the last millisecond.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RigCoils {
    /// Mean current, A.
    pub current_a: [f32; COILS],
    /// Mean square, A².
    pub square_a2: [f32; COILS],
    /// Mean voltage over the supply's.
    pub duty: [f32; COILS],
    /// Milliseconds these means cover.
    pub ms: f32,
}

/// Everything that is looked at in one millisecond.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RigSeen {
    /// Codes of the slow sensors.
    pub codes: RigCodes,
    /// The coils.
    pub coils: RigCoils,
    /// Pressure set point while the valve is in use, Pa.
    pub set_pa: Option<f32>,
    /// Speed of the tacho where there is one, Hz.
    pub spindle_hz: Option<f32>,
}

/// The slow signals in SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RigState {
    /// Gaps, m.
    pub gap_m: [f32; GAPS],
    /// Pressure, Pa.
    pub pressure_pa: f32,
    /// Length, m, from the middle of the gauge's range.
    pub gauge_m: f32,
    /// Supply of the power stage, V.
    pub supply_v: f32,
}

impl RigLimits {
    /// Codes to SI.
    pub fn state(&self, codes: &RigCodes) -> RigState {
        let part = |code: u16| f32::from(code) * (1.0 / 65535.0);
        let (low, high) = LIVE;
        RigState {
            gap_m: codes.gap.map(|code| part(code) * self.gap_span_m),
            pressure_pa: (part(codes.pressure) - low) / (high - low) * self.pressure_span_pa,
            gauge_m: (part(codes.gauge) - 0.5) * self.gauge_span_m,
            supply_v: part(codes.supply) * self.supply_span_v,
        }
    }
}

#[derive(Debug, Clone, Copy, Default)]
struct Gap {
    lost: InARow,
    still: Still,
    narrow: InARow,
    closed: InARow,
}

/// Watches the slow signals of the test rigs.
#[derive(Debug, Clone, Default)]
pub struct RigWatch {
    heat: [Heat; COILS],
    short: [InARow; COILS],
    gap: [Gap; GAPS],
    supply_low: InARow,
    supply_high: InARow,
    pressure_lost: InARow,
    pressure_high: InARow,
    gauge_lost: InARow,
    gauge_range: InARow,
    overspeed: InARow,
    winding_lost: InARow,
    winding_hot: InARow,
    follows: Follows,
    following: bool,
}

impl RigWatch {
    /// One millisecond.
    pub fn update(
        &mut self,
        mode: Mode,
        limits: &RigLimits,
        seen: &RigSeen,
        found: &mut impl FnMut(FaultCode, u8, f32),
    ) {
        let RigSeen {
            codes,
            coils,
            set_pa,
            spindle_hz,
        } = seen;
        let state = limits.state(codes);
        let v = state.supply_v;
        if self.supply_low.bad(!(v >= limits.supply_v.0), BAD_MS) {
            found(FaultCode::SupplyLow, 0, v);
        }
        if self.supply_high.bad(!(v <= limits.supply_v.1), BAD_MS) {
            found(FaultCode::SupplyHigh, 0, v);
        }
        self.heat(limits, coils, found);
        match mode {
            Mode::Cers => {
                self.coils(limits, coils, v, found);
                self.gaps(limits, codes, &state, found);
                self.winding(limits, codes.gauge, found);
                let fast = spindle_hz.is_some_and(|hz| !(hz <= limits.overspeed_hz));
                if self.overspeed.bad(fast, BAD_MS) {
                    found(FaultCode::Overspeed, 0, spindle_hz.unwrap_or(0.0));
                }
            }
            Mode::Ldbb => self.bar(limits, codes, &state, *set_pa, found),
            Mode::Safe | Mode::Monitor => {}
        }
        if mode != Mode::Ldbb || set_pa.is_none() {
            self.following = false;
        }
    }

    /// How full the windings are; they cool whatever the mode.
    pub fn theta(&self) -> [f32; COILS] {
        self.heat.map(|h| h.theta())
    }

    fn heat(
        &mut self,
        limits: &RigLimits,
        coils: &RigCoils,
        found: &mut impl FnMut(FaultCode, u8, f32),
    ) {
        let per = 1.0 / (limits.nominal_a * limits.nominal_a);
        for (k, (heat, square)) in self.heat.iter_mut().zip(&coils.square_a2).enumerate() {
            let theta = heat.update(square * per, 1e-3 * coils.ms, limits.thermal_s);
            if theta >= 1.0 {
                found(FaultCode::Overload, k as u8, theta);
            }
        }
    }

    fn coils(
        &mut self,
        limits: &RigLimits,
        coils: &RigCoils,
        supply_v: f32,
        found: &mut impl FnMut(FaultCode, u8, f32),
    ) {
        let means = coils.current_a.iter().zip(&coils.duty);
        for (k, (short, (&i, &duty))) in self.short.iter_mut().zip(means).enumerate() {
            // Over a millisecond L di/dt is small against R i, once the ramp is over.
            let ohm = if i > SHORT_CURRENT_A {
                duty * supply_v / i
            } else {
                limits.resistance_ohm
            };
            if short.bad(!(ohm >= SHORT_PART * limits.resistance_ohm), SHORT_MS) {
                found(FaultCode::CoilShort, k as u8, ohm);
            }
        }
    }

    /// The thermistor, on the input that the gauge has in the other rig.
    fn winding(
        &mut self,
        limits: &RigLimits,
        code: u16,
        found: &mut impl FnMut(FaultCode, u8, f32),
    ) {
        if !(limits.thermistor_b_k > 0.0) {
            return;
        }
        let lost = at_end(code);
        if self.winding_lost.bad(lost, BAD_MS) {
            found(FaultCode::ThermistorLost, 0, f32::from(code));
        }
        let k = thermistor_k(f32::from(code) * (1.0 / 65535.0), limits.thermistor_b_k);
        if self
            .winding_hot
            .bad(!lost && !(k <= limits.winding_k), BAD_MS)
        {
            found(FaultCode::WindingHot, 0, k);
        }
    }

    fn gaps(
        &mut self,
        limits: &RigLimits,
        codes: &RigCodes,
        state: &RigState,
        found: &mut impl FnMut(FaultCode, u8, f32),
    ) {
        let each = codes.gap.iter().zip(&state.gap_m);
        for (k, (gap, (&code, &m))) in self.gap.iter_mut().zip(each).enumerate() {
            let lost = at_end(code);
            if gap.lost.bad(lost, BAD_MS) {
                found(FaultCode::GapSensorLost, k as u8, f32::from(code));
            }
            if gap.still.still(code, STILL_MS) {
                found(FaultCode::GapSensorStuck, k as u8, f32::from(code));
            }
            if gap
                .closed
                .bad(!lost && !(m >= GAP_TRIP * limits.gap_m), BAD_MS)
            {
                found(FaultCode::GapClosed, k as u8, m);
            } else if gap
                .narrow
                .bad(!lost && !(m >= GAP_WARN * limits.gap_m), BAD_MS)
            {
                found(FaultCode::GapNarrow, k as u8, m);
            }
        }
    }

    fn bar(
        &mut self,
        limits: &RigLimits,
        codes: &RigCodes,
        state: &RigState,
        set_pa: Option<f32>,
        found: &mut impl FnMut(FaultCode, u8, f32),
    ) {
        let part = f32::from(codes.pressure) * (1.0 / 65535.0);
        let lost = !(part >= LIVE_LOST.0 && part <= LIVE_LOST.1);
        if self.pressure_lost.bad(lost, BAD_MS) {
            found(FaultCode::PressureSensorLost, 0, f32::from(codes.pressure));
        }
        let p = state.pressure_pa;
        if self
            .pressure_high
            .bad(!lost && !(p <= PRESSURE_PART * limits.most_pa), BAD_MS)
        {
            found(FaultCode::PressureHigh, 0, p);
        }
        if self.gauge_lost.bad(at_end(codes.gauge), BAD_MS) {
            found(FaultCode::GaugeLost, 0, f32::from(codes.gauge));
        }
        let beyond = !at_end(codes.gauge) && !(state.gauge_m.abs() <= limits.gauge_limit_m);
        if self.gauge_range.bad(beyond, BAD_MS) {
            found(FaultCode::GaugeRange, 0, state.gauge_m);
        }
        let Some(set) = set_pa else { return };
        if !self.following {
            self.follows.reset(p);
            self.following = true;
        }
        let off = self
            .follows
            .update(set, p, limits.lag_s, limits.tolerance_pa, limits.settle_s);
        match off {
            None => {}
            Some(Disobedience::Stuck) => found(FaultCode::ValveStuck, 0, p),
            Some(Disobedience::Leak) => found(FaultCode::PressureLeak, 0, self.follows.short(p)),
            Some(Disobedience::Over) => found(FaultCode::PressureHigh, 0, p),
        }
    }
}

fn at_end(code: u16) -> bool {
    !(RAIL..=u16::MAX - RAIL).contains(&code)
}
