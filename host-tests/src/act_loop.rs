//! The whole loop: a virtual cut at the speed that turns, what hears it (act_ear), advice,
//! policy, a controller, its spindle, and the cut again; sample by sample.

use crate::act_ear::{Core, Ear};
use crate::advice::Case;
use rarma_cli::Failure;
use rarma_cli::controller::{ActRecord, Actor, Chatter, Controller};
use rarma_core::act::{ActConfig, ActOrder, Overrides, Reading};
use rarma_plants::converter::ConverterConfig;
use rarma_plants::cut::{Process, Scenario, VirtualCut};
use rarma_plants::process::Schedule;
use rarma_plants::sound::{MicrophoneConfig, Pickup};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Length of a run, s, and when the tool enters.
pub const LENGTH_S: f64 = 7.0;
const ENTERS_S: f64 = 0.8;
/// It is as deep as it gets after so long, s.
const ENTRY_S: f64 = 0.05;
/// Samples a second.
pub const FS_HZ: f64 = 48_000.0;
/// The policy steps so often, and the spindle, s.
const STEP_S: f64 = 0.02;
const SPINDLE_S: f64 = 0.001;
/// The amplitude at the end is that of the last of it, s.
const END_S: f64 = 0.5;

/// A simulated spindle behind a controller with one override for both, as the spindle of
/// LinuxCNC's simulation does: an order is in force one step later, the drive changes by 5000
/// 1/min in a second, and its mass follows with 14 ms.
#[derive(Debug)]
pub struct Spindle {
    program_hz: f64,
    ordered: Overrides,
    in_force: Overrides,
    drive_hz: f64,
    /// Turns a second now.
    pub hz: f64,
}

/// See [`Spindle`].
const DRIVE_HZ_PER_S: f64 = 5000.0 / 60.0;
const MASS_S: f64 = 0.014;

impl Spindle {
    /// At the programmed speed.
    #[must_use]
    pub fn turning(program_hz: f64) -> Self {
        let as_programmed = Overrides {
            spindle: 1.0,
            feed: 1.0,
        };
        Self {
            program_hz,
            ordered: as_programmed,
            in_force: as_programmed,
            drive_hz: program_hz,
            hz: program_hz,
        }
    }

    fn step(&mut self, dt_s: f64) -> f64 {
        let most = DRIVE_HZ_PER_S * dt_s;
        let left = self.program_hz * self.in_force.spindle - self.drive_hz;
        self.drive_hz += left.clamp(-most, most);
        self.hz += (self.drive_hz - self.hz) * dt_s / MASS_S;
        self.hz
    }
}

/// A hand on the [`Spindle`].
#[derive(Debug, Clone)]
pub struct SimulatedController(pub Arc<Mutex<Spindle>>);

impl SimulatedController {
    /// The spindle.
    pub fn spindle(&self) -> MutexGuard<'_, Spindle> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Controller for SimulatedController {
    fn range(&self) -> Option<(f64, f64)> {
        Some((0.5, 1.5))
    }

    fn read(&mut self) -> Result<Option<Reading>, Failure> {
        let mut spindle = self.spindle();
        spindle.in_force = spindle.ordered;
        Ok(Some(Reading {
            program_hz: spindle.program_hz,
            actual_hz: Some(spindle.hz),
            overrides: spindle.in_force,
            operator: None,
            running: true,
            stopped: false,
        }))
    }

    fn propose(&mut self, _: &[f64]) -> Result<(), Failure> {
        Ok(())
    }

    fn order(&mut self, order: ActOrder) -> Result<(), Failure> {
        match order {
            ActOrder::Set(to) | ActOrder::GiveBack(to) => self.spindle().ordered = to,
            ActOrder::Leave => {}
        }
        Ok(())
    }

    fn believe(&mut self, _: f64) {}
}

/// What turns the spindle of the cut.
pub trait Turns {
    /// Time goes on by so much, s: the speed that turns now, turns a second.
    fn turn(&mut self, actor: &Actor, dt_s: f64) -> f64;
}

impl Turns for SimulatedController {
    fn turn(&mut self, _: &Actor, dt_s: f64) -> f64 {
        self.spindle().step(dt_s)
    }
}

/// What came of one cut.
#[derive(Debug)]
pub struct Played {
    /// What the actor said.
    pub records: Vec<ActRecord>,
    /// Alarms: called at, s, and released at.
    pub alarms: Vec<(f64, Option<f64>)>,
    /// Speed over time, s and turns a second.
    pub speeds: Vec<(f64, f64)>,
    /// Frequency of the first alarm, Hz.
    pub heard_hz: Option<f64>,
    /// The last half second: turns of the spindle, and the place of the tool, m.
    pub last: Vec<(f64, [f64; 2])>,
    /// Its swing (from the least to the most in the direction that swings more, in each 20 ms) over
    /// time, s and m.
    pub swing_m: Vec<(f64, f64)>,
}

/// From the least to the most of the tool's place, m, by direction.
#[derive(Debug, Clone, Copy)]
struct Extent([(f64, f64); 2]);

impl Extent {
    const NONE: Self = Self([(f64::MAX, f64::MIN); 2]);

    fn take(&mut self, position_m: [f64; 2]) {
        for ((least, most), x) in self.0.iter_mut().zip(position_m) {
            (*least, *most) = (least.min(x), most.max(x));
        }
    }

    fn swing_m(&self) -> f64 {
        self.0
            .iter()
            .map(|(least, most)| most - least)
            .fold(0.0, f64::max)
    }
}

/// What may be ordered in these loops.
pub const LIMITS: (f64, f64) = (0.5, 1.5);

/// One case with a simulated controller, which may be ordered or not, and of which this is told.
///
/// # Panics
/// As [`play_heard`].
#[must_use]
pub fn simulated(case: &Case, act: bool, about: Chatter) -> Played {
    simulated_heard(case, &mut Core::of(case, FS_HZ), act, about)
}

/// The same, heard by another ear.
///
/// # Panics
/// As [`play_heard`].
#[must_use]
pub fn simulated_heard(case: &Case, ear: &mut impl Ear, act: bool, about: Chatter) -> Played {
    let spindle = Spindle::turning(case.cut.spindle_hz());
    let mut controller = SimulatedController(Arc::new(Mutex::new(spindle)));
    let config = ActConfig::limits(act, LIMITS.0, LIMITS.1);
    let port = Box::new(controller.clone());
    let mut actor = Actor::new(port, config, about, None).expect("in range");
    play_heard(case, ear, &mut actor, &mut controller)
}

/// The cut of this case, heard by a microphone; the tool enters after so long, s. It may be turned from half to 1.6
/// times its speed.
///
/// # Panics
/// The case has a defect, or is turned, not milled.
#[must_use]
pub fn virtual_cut(case: &Case, enters_s: f64, length_s: f64) -> VirtualCut {
    let hz = case.cut.spindle_hz();
    let Process::Milling(mut config) = case.process.clone() else {
        panic!("only a milling spindle changes its speed")
    };
    let depth = [
        (0.0, 0.0),
        (enters_s, 0.0),
        (enters_s + ENTRY_S, case.depth_m),
    ];
    config.depth = Schedule::new(&depth).expect("a depth");
    // How far it may be turned; it is told before it gets there.
    let far = length_s + 100.0;
    let speeds = [
        (0.0, hz),
        (far, hz),
        (far + 1.0, 0.5 * hz),
        (far + 2.0, 1.6 * hz),
    ];
    config.speed = Some(Schedule::new(&speeds).expect("speeds"));
    let scenario = Scenario {
        name: "loop".to_owned(),
        process: Process::Milling(config),
        microphone: MicrophoneConfig {
            sample_rate_hz: FS_HZ,
            pickup: Pickup::Displacement,
            gain: [1e6, 0.7e6],
            noise_pa: 0.005,
            converter: ConverterConfig {
                full_scale: 1000.0,
                bits: 24,
                dither: true,
            },
            seed: case.cut.seed,
            distance_m: 0.0,
            enclosure: None,
            tones: Vec::new(),
        },
        duration_s: length_s,
    };
    VirtualCut::new(&scenario).expect("a cut")
}

/// Turns, and the place of the tool, m, in the last half second of a cut that turns at so many times its speed
/// from the first revolution on, for so long, s.
///
/// # Panics
/// As [`play_heard`].
#[must_use]
pub fn steady(case: &Case, ratio: f64, length_s: f64) -> Vec<(f64, [f64; 2])> {
    let mut cut = virtual_cut(case, ENTERS_S, length_s);
    cut.turn(ratio * case.cut.spindle_hz());
    let mut turns = 0.0;
    let mut out = Vec::new();
    for n in 1_u32.. {
        if cut.next().is_none() {
            break;
        }
        let machine = cut.machine();
        turns += machine.spindle_hz / FS_HZ;
        if f64::from(n) / FS_HZ > length_s - END_S {
            out.push((turns, machine.position_m));
        }
    }
    out
}

/// Plays a cut of this case with what hears it, an actor and what turns its spindle.
///
/// # Panics
/// The case, the ear or the actor has a defect.
pub fn play_heard(
    case: &Case,
    ear: &mut impl Ear,
    actor: &mut Actor,
    spindle: &mut impl Turns,
) -> Played {
    let mut cut = virtual_cut(case, ENTERS_S, LENGTH_S);
    let every = |s: f64| (s * FS_HZ).round() as usize;
    let mut out = Played {
        records: Vec::new(),
        alarms: Vec::new(),
        speeds: Vec::new(),
        heard_hz: None,
        last: Vec::new(),
        swing_m: Vec::new(),
    };
    let mut extent = Extent::NONE;
    let mut chatter_hz = None;
    let mut turns = 0.0;
    let mut n = 0;
    while let Some(reading) = cut.next() {
        n += 1;
        let t_s = n as f64 / FS_HZ;
        let machine = cut.machine();
        extent.take(machine.position_m);
        turns += machine.spindle_hz / FS_HZ;
        if t_s > LENGTH_S - END_S {
            out.last.push((turns, machine.position_m));
        }
        if n % every(SPINDLE_S) == 0 {
            let hz = spindle.turn(actor, SPINDLE_S);
            cut.turn(hz);
        }
        let heard = ear.hear(reading.value);
        if let Some(f) = heard.called_hz {
            chatter_hz = Some(f);
            out.heard_hz = out.heard_hz.or(chatter_hz);
            out.alarms.push((t_s, None));
        }
        if heard.released {
            chatter_hz = None;
            if let Some(last) = out.alarms.last_mut() {
                last.1 = Some(t_s);
            }
        }
        if let (Some(f), Some(loudest)) = (&mut chatter_hz, heard.loudest_hz) {
            *f = loudest;
        }
        if n % every(STEP_S) == 0 {
            out.swing_m.push((t_s, extent.swing_m()));
            extent = Extent::NONE;
            actor.heard(t_s, chatter_hz);
            let step = actor.step(t_s, |record| out.records.push(record));
            step.expect("no log");
            if let Some(hz) = actor.reading().and_then(Reading::spindle_hz) {
                ear.tell_speed(hz);
                out.speeds.push((t_s, cut.machine().spindle_hz));
            }
        }
    }
    out
}
