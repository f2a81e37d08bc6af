//! The whole loop: a virtual cut at the speed that turns, the monitor that hears it, advice,
//! policy, a controller, its spindle, and the cut again; sample by sample.

use crate::advice::Case;
use crate::statistics::rms;
use hal_sim::plant::converter::ConverterConfig;
use hal_sim::plant::cut::{Process, Scenario, VirtualCut};
use hal_sim::plant::process::Schedule;
use hal_sim::plant::sound::{MicrophoneConfig, Pickup};
use rarma_cli::Failure;
use rarma_cli::controller::{ActRecord, Actor, Controller, What};
use rarma_core::Monitor;
use rarma_core::act::{Order, Overrides, Reading};
use rarma_core::decide::{AlarmEvent, Label, State};
use rarma_core::monitor::MonitorConfig;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Length of a run, s, and when the tool enters.
pub const LENGTH_S: f64 = 7.0;
const ENTERS_S: (f64, f64) = (0.8, 0.85);
const FS_HZ: f64 = 48_000.0;
/// The policy steps so often, and the spindle, s.
const STEP_S: f64 = 0.02;
const SPINDLE_S: f64 = 0.001;
/// Amplitudes are read in windows of, s.
const WINDOW_S: f64 = 0.02;
/// Two speeds this near have one root, as a part.
const GRID: f64 = 0.002;

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

    fn order(&mut self, order: Order) -> Result<(), Failure> {
        match order {
            Order::Set(to) | Order::GiveBack(to) => self.spindle().ordered = to,
            Order::Leave => {}
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
    /// Amplitude of the tool in windows, m rms.
    pub windows_m: Vec<f64>,
}

/// Plays a cut of this case with an actor and what turns its spindle.
///
/// # Panics
/// The case, the monitor or the actor has a defect.
pub fn play(case: &Case, actor: &mut Actor, spindle: &mut impl Turns) -> Played {
    let hz = case.cut.spindle_hz();
    let Process::Milling(mut config) = case.process.clone() else {
        panic!("only a milling spindle changes its speed")
    };
    let depth = [(0.0, 0.0), (ENTERS_S.0, 0.0), (ENTERS_S.1, case.depth_m)];
    config.depth = Schedule::new(&depth).expect("a depth");
    // How far it may be turned; it is told before it gets there.
    let far = LENGTH_S + 100.0;
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
        duration_s: LENGTH_S,
    };
    let mut cut = VirtualCut::new(&scenario).expect("a cut");
    let mut monitor = Monitor::<f32>::new(&MonitorConfig {
        full_scale: Some(1.0),
        spindle_hz: Some(hz),
        teeth: u32::try_from(case.cut.teeth()).ok(),
        ..MonitorConfig::new(FS_HZ)
    })
    .expect("in range");
    let every = |s: f64| (s * FS_HZ).round() as usize;
    let mut out = Played {
        records: Vec::new(),
        alarms: Vec::new(),
        speeds: Vec::new(),
        windows_m: Vec::new(),
    };
    let (mut chatter_hz, mut window) = (None, Vec::new());
    let mut n = 0;
    while let Some(reading) = cut.next() {
        n += 1;
        let t_s = n as f64 / FS_HZ;
        let [x, y] = cut.machine().position_m;
        window.extend([x, y]);
        if window.len() >= 2 * every(WINDOW_S) {
            out.windows_m.push(without_mean(&window));
            window.clear();
        }
        if n % every(SPINDLE_S) == 0 {
            let hz = spindle.turn(actor, SPINDLE_S);
            cut.turn(hz);
        }
        if let Some(report) = monitor.push(reading.value) {
            match report.event {
                AlarmEvent::On { frequency, .. } => {
                    chatter_hz = Some(f64::from(frequency));
                    out.alarms.push((t_s, None));
                }
                AlarmEvent::Off { .. } => {
                    chatter_hz = None;
                    if let Some(last) = out.alarms.last_mut() {
                        last.1 = Some(t_s);
                    }
                }
                AlarmEvent::None => {}
            }
            if let (Some(f), State::Chatter) = (&mut chatter_hz, report.state) {
                let excited = report.modes.iter().flatten();
                let excited = excited.filter(|m| m.label == Label::SelfExcited);
                let loudest = excited.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
                *f = loudest.map_or(*f, |m| f64::from(m.frequency));
            }
        }
        if n % every(STEP_S) == 0 {
            actor.heard(t_s, chatter_hz);
            let step = actor.step(t_s, |record| out.records.push(record));
            step.expect("no log");
            if let Some(hz) = actor.reading().and_then(Reading::spindle_hz) {
                monitor.tell_speed(hz as f32).expect("in range");
                out.speeds.push((t_s, cut.machine().spindle_hz));
            }
        }
    }
    out
}

/// Root mean square of x and y, each about its mean.
fn without_mean(xy: &[f64]) -> f64 {
    let part = |k: usize| {
        let x: Vec<f64> = xy.iter().skip(k).step_by(2).copied().collect();
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        rms(&x.iter().map(|x| x - mean).collect::<Vec<f64>>())
    };
    part(0).hypot(part(1))
}

/// What is true of a played cut, by its delay equation.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Chatter was called at, s.
    pub called_s: Option<f64>,
    /// So many orders were given.
    pub orders: usize,
    /// It was said that there is no speed.
    pub none_said: bool,
    /// At the end: the override in force, and whether the cut is stable there.
    pub end_ratio: f64,
    /// See `end_ratio`.
    pub end_stable: bool,
    /// From the first call until the speed is stable for good, s.
    pub stable_after_s: Option<f64>,
    /// From then until the last alarm is released, s.
    pub released_after_s: Option<f64>,
    /// Amplitude in the last 0.5 s over that of the same cut without orders, dB less.
    pub less_db: Option<f64>,
    /// Alarms called where the cut had been stable for 0.6 s.
    pub false_calls: usize,
}

impl Played {
    /// Judges it, beside the same cut without orders where that was played.
    #[must_use]
    pub fn judge(&self, case: &Case, unturned: Option<&Self>) -> Judged {
        let mut roots: BTreeMap<i64, bool> = BTreeMap::new();
        let hz = case.cut.spindle_hz();
        let mut stable_at = |speed_hz: f64| {
            let key = (speed_hz / hz / GRID).round() as i64;
            let stable = || case.root(key as f64 * GRID).is_none();
            *roots.entry(key).or_insert_with(stable)
        };
        let states: Vec<(f64, bool)> = self
            .speeds
            .iter()
            .map(|(t_s, speed_hz)| (*t_s, stable_at(*speed_hz)))
            .collect();
        let end_stable = states.last().is_some_and(|(_, stable)| *stable);
        let unstable_until = states.iter().rev().find(|(_, stable)| !stable);
        let unstable_until = unstable_until.map(|(t_s, _)| *t_s);
        let called_s = self.alarms.first().map(|(on, _)| *on);
        let after = |from: Option<f64>, to: Option<f64>| Some(to? - from?);
        let begun = |r: &&ActRecord| matches!(r.what, What::Ordered { .. });
        let released = self.alarms.last().and_then(|(_, off)| *off);
        let last = |played: &Self| {
            let from = played
                .windows_m
                .len()
                .saturating_sub((0.5 / WINDOW_S) as usize);
            rms(&played.windows_m[from..])
        };
        let stable_since = |t_s: f64| {
            let mut before = states
                .iter()
                .filter(|(at, _)| *at <= t_s && *at > t_s - 0.6);
            before.all(|(_, stable)| *stable)
        };
        Judged {
            called_s,
            orders: self.records.iter().filter(begun).count(),
            none_said: self.records.iter().any(|r| r.what == What::NoSpeed),
            end_ratio: self.speeds.last().map_or(1.0, |(_, speed)| speed / hz),
            end_stable,
            stable_after_s: after(called_s, unstable_until).filter(|_| end_stable),
            released_after_s: after(unstable_until, released)
                .filter(|_| end_stable)
                .map(|s| s.max(0.0)),
            less_db: unturned.map(|before| 20.0 * (last(before) / last(self)).log10()),
            false_calls: self
                .alarms
                .iter()
                .filter(|(on, _)| stable_since(*on))
                .count(),
        }
    }
}
