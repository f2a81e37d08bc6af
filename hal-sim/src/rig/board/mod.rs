//! The simulated board.

mod verbs;
mod world;

use super::bridge::SimBridge;
use super::fault::{FaultEvent, FaultKind};
use super::flash::SimFlash;
use super::link::RigLink;
use super::plant::{Plant, RigConfig};
use crate::parts::{SimInput, SimPwm, SimRelay, Wire};
use firmware::board::{Contacts, Emergency, Lights, ResetCause};
use firmware::current_loop::MainSide;
use firmware::parts::{ContactPins, Gate, PwmValve};
use firmware::{Clock, CurrentLoop};
use rarma_box::guard::KEPT_BYTES;
use rarma_plants::cers::ExciterConfig;
use std::collections::VecDeque;
use std::fmt;

/// A period of the current loop, µs.
pub(super) const PERIOD_US: u64 = 25;
const LOOP_HZ: f64 = 40_000.0;
const SAMPLE_HZ: f64 = 48_000.0;
/// Periods that one `wait` lasts.
const WAIT_PERIODS: u64 = 10;

/// Which pins of the rig cannot be read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Unreadable {
    /// The enable input's.
    pub enable: bool,
    /// The emergency-stop chain's.
    pub stop_chain: bool,
    /// The gate's read-back.
    pub gate: bool,
}

/// What is at the board's pins, and the verbs made of these.
#[derive(Debug)]
struct Pins {
    enable: Wire,
    stop_chain: Wire,
    relay: SimRelay,
    pwm: SimPwm,
    contacts: ContactPins<SimInput, SimInput>,
    gate: Gate<SimRelay, SimInput>,
    valve: PwmValve<SimPwm>,
}

impl Pins {
    fn new() -> Self {
        let (enable, stop_chain) = (Wire::default(), Wire::default());
        let (relay, pwm) = (SimRelay::default(), SimPwm::default());
        Self {
            contacts: ContactPins::new(enable.input(), stop_chain.input()),
            gate: Gate::new(relay.clone(), relay.contact.input()),
            valve: PwmValve::new(pwm.clone()),
            enable,
            stop_chain,
            relay,
            pwm,
        }
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
    /// Magnets and a spindle behind the coils; none: chokes, and gaps that run out a little.
    /// Faults of coils are the chokes' alone.
    pub magnets: Option<ExciterConfig>,
    /// What is heard is the accelerometer at the front bearing, along y: full scale, m/s².
    /// Needs magnets.
    pub accelerometer_m_per_s2: Option<f64>,
}

impl Default for RigSetUp {
    fn default() -> Self {
        Self {
            plant: RigConfig::default(),
            seed: 1,
            spindle_hz: 50.0,
            faults: Vec::new(),
            magnets: None,
            accelerometer_m_per_s2: None,
        }
    }
}

/// Samples made from the plant's acceleration, and not taken yet.
#[derive(Debug)]
struct Accelerometer {
    per_full_scale: f64,
    last: f64,
    waiting: VecDeque<f32>,
}

impl Accelerometer {
    fn new(full_scale: f64) -> Self {
        Self {
            per_full_scale: 1.0 / full_scale,
            last: 0.0,
            waiting: VecDeque::new(),
        }
    }

    /// The acceleration at the end of a period; straight lines in between. `parts` are the
    /// places of the samples within the period, 0 to 1.
    fn follow(&mut self, acceleration: f64, parts: impl Iterator<Item = f64>) {
        let now = acceleration * self.per_full_scale;
        for part in parts {
            let x = self.last + (now - self.last) * part;
            self.waiting.push_back(x.clamp(-1.0, 1.0) as f32);
        }
        self.last = now;
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
    accelerometer: Option<Accelerometer>,
    second_microphone: bool,
    missing: u32,
    pub(super) plant: Plant,
    pub(super) bridge: SimBridge,
    coil_loop: CurrentLoop,
    main_side: MainSide,
    faults: Vec<FaultEvent>,
    done: Vec<bool>,
    spindle_hz: f64,
    next_pulse_s: f64,
    pins: Pins,
    /// Pins that fail.
    pub unreadable: Unreadable,
    gap_held: [u16; 2],
    /// Both contacts, as somebody holds them.
    pub contacts: Contacts,
    fed_us: u64,
    cause: ResetCause,
    kept: [u8; KEPT_BYTES],
    /// What [`firmware::BoxBoard::entropy`] is drawn from: the seed unless it is set, so that a
    /// scenario can be run again bit by bit. It moves on with every number drawn and outlives
    /// a reset. Whoever knows it foresees every session.
    pub draws: u64,
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
            .field("gate", &self.gate_closed())
            .field("plant", &self.plant)
            .finish_non_exhaustive()
    }
}

impl SimRig {
    /// A rig that hears `sound`, 48 kHz in parts of full scale. Contacts are closed.
    ///
    /// # Panics
    /// If the plant of the magnets is out of its range, or magnets and faults of coils come
    /// together.
    pub fn new(set_up: RigSetUp, sound: impl Iterator<Item = f32> + 'static) -> Self {
        let mut plant = Plant::new(set_up.plant, set_up.seed);
        if let Some(magnets) = set_up.magnets {
            let of_coils = |f: &FaultEvent| f.kind.needs_chokes();
            assert!(
                !set_up.faults.iter().any(of_coils),
                "faults of coils need a rig without magnets"
            );
            if let Err(why) = plant.attach(magnets, set_up.seed) {
                panic!("magnets: {why}");
            }
        }
        Self {
            now_us: 0,
            start_us: 0,
            sound: Box::new(sound),
            sound_given: 0,
            sample_offset: 0,
            held: 0.0,
            second_microphone: false,
            accelerometer: set_up.accelerometer_m_per_s2.map(Accelerometer::new),
            missing: 0,
            plant,
            bridge: SimBridge::default(),
            coil_loop: CurrentLoop::new(),
            main_side: MainSide::default(),
            done: vec![false; set_up.faults.len()],
            faults: set_up.faults,
            spindle_hz: set_up.spindle_hz,
            next_pulse_s: 0.0,
            pins: Pins::new(),
            unreadable: Unreadable::default(),
            gap_held: [0; 2],
            contacts: Contacts {
                enable: true,
                stop_chain: true,
            },
            fed_us: 0,
            cause: ResetCause::PowerOn,
            kept: [0xA5; KEPT_BYTES],
            draws: set_up.seed,
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

    fn gate_closed(&self) -> bool {
        self.pins.relay.is_closed()
    }

    /// Any switch closed, or the valve driven: energy can get out.
    pub fn outputs_on(&self) -> bool {
        (self.bridge.now.is_some() || self.pins.pwm.duty() > 0) && self.gate_closed()
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
        self.main_side = MainSide::default();
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
}

impl Clock for SimRig {
    fn now_us(&mut self) -> u64 {
        self.now_us - self.start_us
    }
}

impl Emergency for SimRig {
    fn drop_outputs(&mut self) {
        let welded = self.stands(FaultKind::GateWelded).is_some();
        self.pins.relay.welded.set(welded);
        self.pins.gate.open();
        self.bridge.next = None;
        self.bridge.now = None;
        self.pins.valve.shut();
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        self.kept = *bytes;
    }
}
