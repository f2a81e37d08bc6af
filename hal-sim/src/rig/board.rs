//! The simulated board.

use super::bridge::SimBridge;
use super::fault::{FaultEvent, FaultKind};
use super::flash::{SECTOR, SECTORS, SimFlash};
use super::link::RigLink;
use super::plant::{Plant, RigConfig, Spoilt};
use firmware::board::{
    AdcCode, Contacts, DacCode, Emergency, Lights, Pulse, ResetCause, SensorCodes, WATCHDOG_US,
};
use firmware::current_loop::{CoilOrder, CoilReport};
use firmware::{Block, BoardError, BoardErrorKind, BoxBoard, CurrentLoop};
use rarma_core::guard::KEPT_BYTES;
use std::fmt;
use std::ops::Range;

/// A period of the current loop, µs.
pub(super) const PERIOD_US: u64 = 25;
const LOOP_HZ: f64 = 40_000.0;
const SAMPLE_HZ: f64 = 48_000.0;
/// Periods that one `wait` lasts.
const WAIT_PERIODS: u64 = 10;

/// Why a verb failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RigError(pub BoardErrorKind);

impl BoardError for RigError {
    fn kind(&self) -> BoardErrorKind {
        self.0
    }
}

/// What a rig is set up with.
#[derive(Debug, Clone, PartialEq)]
pub struct RigSetUp {
    /// The plant.
    pub plant: RigConfig,
    /// Seed of everything random.
    pub seed: u64,
    /// Spindle frequency, Hz; 0 stands still.
    pub spindle_hz: f64,
    /// Faults to come.
    pub faults: Vec<FaultEvent>,
}

impl Default for RigSetUp {
    fn default() -> Self {
        Self {
            plant: RigConfig::default(),
            seed: 1,
            spindle_hz: 50.0,
            faults: Vec::new(),
        }
    }
}

/// The simulated board.
pub struct SimRig {
    pub(super) now_us: u64,
    start_us: u64,
    sound: Box<dyn Iterator<Item = f32>>,
    sound_given: u64,
    sample_offset: u64,
    held: f32,
    missing: u32,
    pub(super) plant: Plant,
    pub(super) bridge: SimBridge,
    coil_loop: CurrentLoop,
    faults: Vec<FaultEvent>,
    done: Vec<bool>,
    spindle_hz: f64,
    next_pulse_s: f64,
    gate: bool,
    valve: u16,
    gap_held: [u16; 2],
    /// Both contacts, as somebody holds them.
    pub contacts: Contacts,
    fed_us: u64,
    cause: ResetCause,
    kept: [u8; KEPT_BYTES],
    /// Flash of the settings.
    pub flash: SimFlash,
    /// The link.
    pub link: RigLink,
    pub(super) reset: Option<ResetCause>,
    /// Lights as they are.
    pub lights: Lights,
    last_on_us: Option<u64>,
    current_until_us: u64,
    off_for_us: u64,
}

impl fmt::Debug for SimRig {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SimRig")
            .field("now_us", &self.now_us)
            .field("gate", &self.gate)
            .field("plant", &self.plant)
            .finish_non_exhaustive()
    }
}

impl SimRig {
    /// A rig that hears `sound`, 48 kHz in parts of full scale. Contacts are closed.
    pub fn new(set_up: RigSetUp, sound: impl Iterator<Item = f32> + 'static) -> Self {
        Self {
            now_us: 0,
            start_us: 0,
            sound: Box::new(sound),
            sound_given: 0,
            sample_offset: 0,
            held: 0.0,
            missing: 0,
            plant: Plant::new(set_up.plant, set_up.seed),
            bridge: SimBridge::default(),
            coil_loop: CurrentLoop::new(),
            done: vec![false; set_up.faults.len()],
            faults: set_up.faults,
            spindle_hz: set_up.spindle_hz,
            next_pulse_s: 0.0,
            gate: false,
            valve: 0,
            gap_held: [0; 2],
            contacts: Contacts {
                enable: true,
                stop_chain: true,
            },
            fed_us: 0,
            cause: ResetCause::PowerOn,
            kept: [0xA5; KEPT_BYTES],
            flash: SimFlash::default(),
            link: RigLink::new(set_up.seed.wrapping_add(1)),
            reset: None,
            lights: Lights::default(),
            last_on_us: None,
            current_until_us: 0,
            off_for_us: 0,
        }
    }

    /// Time of the simulated world, µs; a reset does not set it back.
    pub fn world_us(&self) -> u64 {
        self.now_us
    }

    /// Adds a fault.
    pub fn add_fault(&mut self, event: FaultEvent) {
        self.faults.push(event);
        self.done.push(false);
    }

    /// Whether a fault of this kind stands now, and where.
    pub(super) fn stands(&self, kind: FaultKind) -> Option<usize> {
        let now = self.now_us;
        self.faults
            .iter()
            .find(|f| f.kind == kind && (f.from_us..f.to_us).contains(&now))
            .map(|f| f.place)
    }

    /// A fault of this kind that happens once, when it is due.
    pub(super) fn falls_due(&mut self, kind: FaultKind) -> Option<FaultEvent> {
        let now = self.now_us;
        let due = |(k, f): (usize, &FaultEvent)| {
            (f.kind == kind && f.from_us <= now && !self.done[k]).then_some((k, *f))
        };
        let (k, event) = self.faults.iter().enumerate().find_map(due)?;
        self.done[k] = true;
        Some(event)
    }

    /// Any switch closed, or the valve driven: energy can get out.
    pub fn outputs_on(&self) -> bool {
        let coils = self.bridge.now.is_some() && self.gate;
        coils || (self.valve > 0 && self.gate)
    }

    /// When outputs were on last, µs.
    pub fn last_on_us(&self) -> Option<u64> {
        self.last_on_us
    }

    /// When a coil carried more than 50 mA last, µs.
    pub fn current_until_us(&self) -> u64 {
        self.current_until_us
    }

    /// The plant, to look at.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// What the reset line does: outputs off, everything forgotten but flash and kept bytes.
    pub(super) fn restart(&mut self, cause: ResetCause) {
        self.drop_outputs();
        self.bridge = SimBridge::default();
        self.coil_loop = CurrentLoop::new();
        self.link.clear();
        self.flash.power_up();
        self.cause = cause;
        self.fed_us = self.now_us;
        self.start_us = self.now_us;
        self.sample_offset = self.samples_due();
        self.sound_given = self.sample_offset;
        self.reset = None;
    }

    /// Power stays away for so long, µs.
    pub(super) fn without_power(&mut self, us: u64) {
        self.drop_outputs();
        self.bridge = SimBridge::default();
        self.off_for_us = us;
    }

    fn samples_due(&self) -> u64 {
        (self.now_us as f64 * (SAMPLE_HZ * 1e-6)) as u64
    }

    fn spoilt(&self) -> Spoilt {
        let at = |kind| self.stands(kind);
        let short = at(FaultKind::CoilShort).map(|coil| (coil, 0.3));
        Spoilt {
            open: at(FaultKind::CoilOpen),
            short: short.or(at(FaultKind::CoilDeadShort).map(|coil| (coil, 0.01))),
            surge: at(FaultKind::CurrentSurge).map(|coil| (coil, 58.0)),
            closing: at(FaultKind::GapClosing).map(|axis| (axis, 2e-3)),
            supply_v: at(FaultKind::SupplyLow)
                .map(|_| 30.0)
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
            gauge_m: if at(FaultKind::GaugeRange).is_some() {
                1.05e-3
            } else {
                0.0
            },
        }
    }

    /// One period of the current loop.
    fn period(&mut self, spoilt: &Spoilt) {
        self.now_us += PERIOD_US;
        if self.off_for_us > 0 {
            self.off_for_us = self.off_for_us.saturating_sub(PERIOD_US);
            self.plant.coils(1e-6 * PERIOD_US as f64, None, spoilt);
            if self.now_us.is_multiple_of(1000) {
                self.plant.slow(None, spoilt);
            }
            return;
        }
        self.bridge.now = self.bridge.next;
        let driven = self.bridge.now.filter(|_| self.gate);
        let duty = driven.map(|d| d.map(f64::from));
        if let Some(coil) = self.plant.coils(1e-6 * PERIOD_US as f64, duty, spoilt) {
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
        if self.stands(FaultKind::LoopDead).is_none() {
            self.coil_loop.period(&mut self.bridge);
        }
        if self.now_us.is_multiple_of(1000) {
            let valve = self.gate.then_some(f64::from(self.valve) / 65535.0);
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
            self.gate = false;
            self.bridge = SimBridge::default();
            self.reset = Some(ResetCause::Watchdog);
        }
    }

    fn due(&mut self) -> u32 {
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

    fn heard(&mut self, x: f32) -> f32 {
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

impl Emergency for SimRig {
    fn drop_outputs(&mut self) {
        if self.stands(FaultKind::GateWelded).is_none() {
            self.gate = false;
        }
        self.bridge.next = None;
        self.bridge.now = None;
        self.valve = 0;
    }

    fn now_us(&mut self) -> u64 {
        self.now_us - self.start_us
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        self.kept = *bytes;
    }
}

impl BoxBoard for SimRig {
    type Error = RigError;
    type Flash = SimFlash;

    const NAME: &'static str = "simulated rig";
    const SAMPLE_RATE_HZ: f64 = SAMPLE_HZ;
    const LOOP_RATE_HZ: f64 = LOOP_HZ;

    fn wait(&mut self) {
        let mut periods = WAIT_PERIODS;
        if let Some(event) = self.falls_due(FaultKind::MainLate) {
            let _ = event;
            periods = 8_000 / PERIOD_US;
        }
        if self.stands(FaultKind::MainHangs).is_some() {
            periods = 2 * WATCHDOG_US / PERIOD_US;
        }
        for _ in 0..periods {
            let spoilt = if self.faults.is_empty() {
                Spoilt::default()
            } else {
                self.spoilt()
            };
            self.period(&spoilt);
            if self.reset.is_some() {
                return;
            }
        }
    }

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, RigError> {
        if self.stands(FaultKind::MicDead).is_some() {
            let due = self.samples_due();
            // What the converter did not convert was never a sample.
            while self.sound_given < due {
                self.sound.next();
                self.sound_given += 1;
            }
            return Err(RigError(BoardErrorKind::Converter));
        }
        if self.falls_due(FaultKind::MicOverrun).is_some() {
            for _ in 0..500 {
                self.sound.next();
            }
            self.sound_given += 500;
            self.missing += 500;
        }
        let due = self.samples_due();
        let mut samples = 0;
        for place in block {
            if self.sound_given >= due {
                break;
            }
            let x = self.sound.next().unwrap_or(0.0);
            self.sound_given += 1;
            *place = self.heard(x);
            samples += 1;
        }
        Ok(Block {
            samples,
            missing: std::mem::take(&mut self.missing),
        })
    }

    fn pulse(&mut self) -> Option<Pulse> {
        if self.spindle_hz <= 0.0 {
            return None;
        }
        let at_s = self.next_pulse_s;
        if self.due() == 0 || self.stands(FaultKind::TachoLost).is_some() {
            return None;
        }
        let at = at_s * SAMPLE_HZ - self.sample_offset as f64;
        if at < 0.0 {
            return None;
        }
        let sample = at.ceil();
        Some(Pulse {
            sample: sample as u64,
            before: (sample - at) as f32,
        })
    }

    fn coils(&mut self, order: &CoilOrder) -> CoilReport {
        self.coil_loop.exchange(order)
    }

    fn sensors(&mut self) -> Result<SensorCodes, RigError> {
        if self.stands(FaultKind::SensorsDead).is_some() {
            return Err(RigError(BoardErrorKind::Converter));
        }
        let spoilt = if self.faults.is_empty() {
            Spoilt::default()
        } else {
            self.spoilt()
        };
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
        let mut pressure = self.plant.pressure_code();
        if self.stands(FaultKind::PressureLost).is_some() {
            pressure = 0;
        }
        let mut gauge = self.plant.gauge_code(&spoilt);
        if self.stands(FaultKind::GaugeLost).is_some() {
            gauge = u16::MAX;
        }
        Ok(SensorCodes {
            gap: gap.map(AdcCode),
            pressure: AdcCode(pressure),
            gauge: AdcCode(gauge),
            supply: AdcCode(self.plant.supply_code(&spoilt)),
        })
    }

    fn valve(&mut self, code: DacCode) -> Result<(), RigError> {
        if self.stands(FaultKind::ValveRefuses).is_some() {
            self.valve = 0;
            return Err(RigError(BoardErrorKind::Refused));
        }
        self.valve = code.0;
        Ok(())
    }

    fn contacts(&mut self) -> Contacts {
        Contacts {
            enable: self.contacts.enable && self.stands(FaultKind::EnableLost).is_none(),
            stop_chain: self.contacts.stop_chain && self.stands(FaultKind::EmergencyStop).is_none(),
        }
    }

    fn energise(&mut self) -> Result<(), RigError> {
        let stopped = !self.contacts().stop_chain;
        if stopped || self.stands(FaultKind::GateRefuses).is_some() {
            return Err(RigError(BoardErrorKind::Refused));
        }
        self.gate = true;
        Ok(())
    }

    fn energised(&mut self) -> bool {
        self.gate
    }

    fn feed_watchdog(&mut self) {
        self.fed_us = self.now_us;
    }

    fn reset_cause(&mut self) -> ResetCause {
        self.cause
    }

    fn kept(&mut self) -> [u8; KEPT_BYTES] {
        self.kept
    }

    fn flash(&mut self) -> (&mut SimFlash, Range<u32>) {
        self.flash.worn = self.stands(FaultKind::FlashWorn).is_some();
        (&mut self.flash, 0..(SECTOR * SECTORS) as u32)
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, RigError> {
        if self.stands(FaultKind::LinkSilent).is_some() {
            self.link.clear();
            return Ok(0);
        }
        if self.stands(FaultKind::LinkGarbage).is_some() {
            let n = self.link.waiting();
            self.link.clear();
            self.link.garbage(n + 8);
        }
        if self.stands(FaultKind::LinkFlood).is_some() {
            self.link.garbage(bytes.len());
        }
        Ok(self.link.box_takes(bytes))
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), RigError> {
        let blocked = self.stands(FaultKind::LinkBlocked).is_some();
        if self.link.box_sends(frame, blocked) {
            Ok(())
        } else {
            Err(RigError(BoardErrorKind::Busy))
        }
    }

    fn lights(&mut self, lights: Lights) {
        self.lights = lights;
    }
}
