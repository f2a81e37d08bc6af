//! What goes on around the chip: one period of the coils at a time, pulses and sound,
//! each with the faults that stand.

use super::{PERIOD_US, SAMPLE_HZ, SimRig};
use crate::rig::bridge::SimBridge;
use crate::rig::fault::FaultKind;
use crate::rig::plant::Spoilt;
use firmware::board::{AdcCode, Emergency, ResetCause, WATCHDOG_US};

/// Gain of the second microphone over the first.
const SECOND_GAIN: f32 = 0.8;

impl SimRig {
    pub(super) fn samples_due(&self) -> u64 {
        (self.now_us as f64 * (SAMPLE_HZ * 1e-6)) as u64
    }

    pub(super) fn spoilt(&self) -> Spoilt {
        let at = |kind| self.stands(kind);
        let short = at(FaultKind::CoilShort).map(|coil| (coil, 0.3));
        Spoilt {
            open: at(FaultKind::CoilOpen),
            short: short.or(at(FaultKind::CoilDeadShort).map(|coil| (coil, 0.01))),
            surge: at(FaultKind::CurrentSurge).map(|coil| (coil, 58.0)),
            closing: at(FaultKind::GapClosing).map(|axis| (axis, 2e-3)),
            supply_v: at(FaultKind::SupplyLow)
                .or(at(FaultKind::SupplyDip))
                .map(|_| 30.0)
                .or(at(FaultKind::SupplyUnsteady).map(|_| self.wobbling_v()))
                .or(at(FaultKind::SupplyHigh).map(|_| 62.0)),
            valve_stuck: at(FaultKind::ValveStuck).is_some(),
            valve_adds_pa: if at(FaultKind::PressureHigh).is_some() {
                8e5
            } else {
                0.0
            },
            leak: if at(FaultKind::PressureLeak).is_some() {
                0.4
            } else {
                0.0
            },
            hotter_k: if at(FaultKind::WindingHot).is_some() {
                120.0
            } else {
                0.0
            },
            gauge_m: if at(FaultKind::GaugeRange).is_some() {
                1.05e-3
            } else {
                0.0
            },
        }
    }

    /// The samples of the accelerometer in the period that has just gone by.
    fn accelerate(&mut self, before_us: u64) {
        let (Some(sensor), Some([_, y])) =
            (&mut self.accelerometer, self.plant.acceleration_m_per_s2())
        else {
            return;
        };
        let per_us = SAMPLE_HZ * 1e-6;
        let at = |us: u64| us as f64 * per_us;
        let (from, to) = (at(before_us), at(self.now_us));
        let first = from.floor() as u64 + 1;
        let parts = (first..=to.floor() as u64).map(|n| (n as f64 - from) / (to - from));
        sensor.follow(y, parts);
    }

    /// Codes of the displacement sensors.
    pub(super) fn gap_codes(&mut self) -> [u16; 2] {
        let mut gap = [0; 2];
        for (axis, code) in gap.iter_mut().enumerate() {
            *code = self.plant.gap_code(axis);
            if self.stands(FaultKind::GapLost) == Some(axis) {
                *code = 0;
            }
            if self.stands(FaultKind::GapStuck) == Some(axis) {
                *code = self.gap_held[axis];
            }
            self.gap_held[axis] = *code;
        }
        gap
    }

    /// A supply that hunts: 48 V ± 2 V at 20 Hz.
    fn wobbling_v(&self) -> f64 {
        48.0 + 2.0 * (core::f64::consts::TAU * 20e-6 * self.now_us as f64).sin()
    }

    /// One period of the current loop.
    pub(super) fn period(&mut self, spoilt: &Spoilt) {
        self.now_us += PERIOD_US;
        if self.off_for_us > 0 {
            self.off_for_us = self.off_for_us.saturating_sub(PERIOD_US);
            self.plant
                .coils(1e-6 * PERIOD_US as f64, None, self.spindle_hz, spoilt);
            if self.now_us.is_multiple_of(1000) {
                self.plant.slow(None, spoilt);
            }
            return;
        }
        self.bridge.now = self.bridge.next;
        let driven = self.bridge.now.filter(|_| self.gate_closed());
        let duty = driven.map(|d| d.map(f64::from));
        let before_us = self.now_us - PERIOD_US;
        let dt_s = 1e-6 * PERIOD_US as f64;
        let tripped = self.plant.coils(dt_s, duty, self.spindle_hz, spoilt);
        self.accelerate(before_us);
        if let Some(coil) = tripped {
            self.bridge.trip(coil as u8);
        }
        if !self.faults.is_empty() {
            self.bridge.refuse = self.stands(FaultKind::BridgeRefuses).is_some();
            self.bridge.dead = self.stands(FaultKind::CurrentDead).is_some();
        }
        let bit = |coil: Option<usize>| coil.map_or(0, |k| 1u8 << k);
        let lost = bit(self.stands(FaultKind::CurrentSensorLost));
        let stuck = bit(self.stands(FaultKind::CurrentSensorStuck));
        self.bridge.sample(&mut self.plant, lost, stuck);
        if self.coil_loop.measures() {
            self.bridge.gaps = self.gap_codes().map(AdcCode);
        }
        if self.stands(FaultKind::LoopDead).is_none() {
            self.coil_loop.period(&mut self.bridge);
        }
        if self.now_us.is_multiple_of(1000) {
            let duty = f64::from(self.pins.pwm.duty()) / 65535.0;
            let valve = self.gate_closed().then_some(duty);
            self.plant.slow(valve, spoilt);
        }
        if self.outputs_on() {
            self.last_on_us = Some(self.now_us);
        }
        if self.plant.current_a.iter().any(|i| *i > 0.05) {
            self.current_until_us = self.now_us;
        }
        if self.now_us - self.fed_us > WATCHDOG_US && self.reset.is_none() {
            // The watchdog's reset pulls every output down by itself.
            self.drop_outputs();
            self.pins.relay.contact.hold(false);
            self.bridge = SimBridge::default();
            self.reset = Some(ResetCause::Watchdog);
        }
    }

    pub(super) fn due(&mut self) -> u32 {
        let noisy = self.stands(FaultKind::TachoNoisy).is_some();
        let factor = if self.stands(FaultKind::Overspeed).is_some() {
            8.0
        } else {
            1.0
        };
        let now_s = 1e-6 * self.now_us as f64;
        let mut pulses = 0;
        while self.next_pulse_s <= now_s {
            let mut interval = 1.0 / (self.spindle_hz * factor).max(1e-3);
            if noisy {
                interval *= 0.05 + 2.0 * self.plant.any();
            }
            self.next_pulse_s += interval;
            pulses += 1;
        }
        pulses
    }

    /// What the microphone that is listened to makes of the sound. Faults are the first one's;
    /// the second hangs a little further away.
    pub(super) fn heard(&mut self, x: f32) -> f32 {
        if self.second_microphone {
            return SECOND_GAIN * x;
        }
        if self.faults.is_empty() {
            return x;
        }
        let mut y = x;
        if self.stands(FaultKind::MicClipped).is_some() {
            y = (40.0 * y).clamp(-1.0, 1.0);
        }
        if self.stands(FaultKind::MicNoisy).is_some() {
            y = 0.98 * (2.0 * self.plant.any() as f32 - 1.0);
        }
        if self.stands(FaultKind::MicNan).is_some() {
            return f32::NAN;
        }
        if self.stands(FaultKind::MicStuck).is_some() {
            return self.held;
        }
        self.held = y;
        y
    }
}
