//! What hears in the loop of act_loop: the monitor itself, or the whole firmware of the box over its link.

use crate::advice::Case;
use hal_sim::rig::{RigSetUp, SimBox, SimRig};
use rarma_box::guard::Mode;
use rarma_box::settings::{MONITOR_SPINDLE, MONITOR_TEETH, SettingValue};
use rarma_box::wire::{Command, Telemetry};
use rarma_cli::bridge::Bridge;
use rarma_core::Monitor;
use rarma_core::decide::{AlarmEvent, Label, State};
use rarma_core::monitor::MonitorConfig;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// What has been heard since it was asked last.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Heard {
    /// An alarm was called at this frequency, Hz.
    pub called_hz: Option<f64>,
    /// It was released.
    pub released: bool,
    /// While it chatters: the loudest vibration that is self-excited, Hz.
    pub loudest_hz: Option<f64>,
}

/// Hears the sound of a cut, and is told its speed.
pub trait Ear {
    /// The next sample.
    fn hear(&mut self, x: f32) -> Heard;
    /// The speed that turns, turns a second.
    fn tell_speed(&mut self, spindle_hz: f64);
}

/// Of modes by label, amplitude and frequency, see [`Heard::loudest_hz`].
fn loudest_hz(state: State, modes: impl Iterator<Item = (Label, f32, f32)>) -> Option<f64> {
    let excited = modes.filter(|(label, ..)| *label == Label::SelfExcited);
    let loudest = excited.max_by(|a, b| a.1.total_cmp(&b.1));
    loudest
        .filter(|_| state == State::Chatter)
        .map(|(.., hz)| f64::from(hz))
}

/// The monitor of the core.
pub struct Core(Box<Monitor<f32>>);

impl Core {
    /// For this cut, which it is told at the beginning.
    ///
    /// # Panics
    /// The case has a defect.
    #[must_use]
    pub fn of(case: &Case, fs_hz: f64) -> Self {
        let config = MonitorConfig {
            full_scale: Some(1.0),
            spindle_hz: Some(case.cut.spindle_hz()),
            teeth: u32::try_from(case.cut.teeth()).ok(),
            ..MonitorConfig::new(fs_hz)
        };
        Self(Box::new(Monitor::new(&config).expect("in range")))
    }
}

impl Ear for Core {
    fn hear(&mut self, x: f32) -> Heard {
        let Some(report) = self.0.push(x) else {
            return Heard::default();
        };
        let modes = report.modes.iter().flatten();
        Heard {
            called_hz: match report.event {
                AlarmEvent::On { frequency, .. } => Some(f64::from(frequency)),
                AlarmEvent::Off { .. } | AlarmEvent::None => None,
            },
            released: matches!(report.event, AlarmEvent::Off { .. }),
            loudest_hz: loudest_hz(
                report.state,
                modes.map(|m| (m.label, m.amplitude, m.frequency)),
            ),
        }
    }

    fn tell_speed(&mut self, spindle_hz: f64) {
        self.0.tell_speed(spindle_hz as f32).expect("in range");
    }
}

/// The firmware on simulated hardware. What it says comes over its link, and the speed is told over it, as a host in
/// control of it tells it.
pub struct Firmware {
    all: SimBox,
    sound: Arc<Mutex<VecDeque<f32>>>,
    /// Samples given, and the time of the box when the first one was, µs.
    given: u64,
    from_us: u64,
    fs_hz: f64,
}

/// A box needs so long to start, s.
const STARTS_S: f64 = 0.2;
/// Hosts on a network are looked after every so many samples: 5 ms.
const SLICE: u64 = 240;

impl Firmware {
    /// A box with the settings it is shipped with, told the speed and the teeth of this cut.
    ///
    /// # Panics
    /// It does not start to listen.
    #[must_use]
    pub fn of(case: &Case, fs_hz: f64) -> Self {
        let sound: Arc<Mutex<VecDeque<f32>>> = Arc::default();
        let heard = Arc::clone(&sound);
        // Nothing before the cut.
        let next = move || {
            let mut sound = heard.lock().unwrap_or_else(PoisonError::into_inner);
            Some(sound.pop_front().unwrap_or(0.0))
        };
        let rig = SimRig::new(RigSetUp::default(), std::iter::from_fn(next));
        let mut all = SimBox::new(rig);
        let teeth = u32::try_from(case.cut.teeth()).expect("few teeth");
        for (setting, value) in [
            (
                MONITOR_SPINDLE.number(),
                SettingValue::Real(case.cut.spindle_hz() as f32),
            ),
            (MONITOR_TEETH.number(), SettingValue::Whole(teeth)),
        ] {
            all.send(&Command::Set { setting, value });
        }
        all.run_for(STARTS_S);
        all.send(&Command::Start(Mode::Monitor));
        let from_us = all.rig.world_us();
        Self {
            all,
            sound,
            given: 0,
            from_us,
            fs_hz,
        }
    }

    /// Hears in real time, and serves hosts on a network, until there is no sample any more. It is in nobody's control then.
    ///
    /// # Panics
    /// The computer is so slow that the box falls behind by more than a second.
    pub fn serve(mut self, bridge: &mut Bridge, mut sample: impl FnMut() -> Option<f32>) {
        self.all.send(&Command::Release);
        self.all.host.takes_control = false;
        self.all.host.heartbeat_us = None;
        self.all.host.keep_all = false;
        let begun = Instant::now();
        while let Some(x) = sample() {
            let said = self.push(x);
            bridge.say(&said);
            if self.given.is_multiple_of(SLICE) {
                bridge.hear(|frame| self.all.rig.link.host_sends(frame));
                let now = Duration::from_secs_f64(self.given as f64 / self.fs_hz);
                assert!(begun.elapsed() < now + Duration::from_secs(1), "too slow");
                std::thread::sleep(now.saturating_sub(begun.elapsed()));
            }
        }
    }

    /// A sample more, and what the box says meanwhile.
    fn push(&mut self, x: f32) -> Vec<u8> {
        self.sound
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push_back(x);
        self.given += 1;
        // One behind: the box takes no sample that is not there yet.
        let until_us = self.from_us + (1e6 * (self.given - 1) as f64 / self.fs_hz) as u64;
        let mut said = Vec::new();
        while self.all.rig.world_us() < until_us {
            said.extend(self.all.step_and_take());
        }
        said
    }
}

impl Ear for Firmware {
    fn hear(&mut self, x: f32) -> Heard {
        self.push(x);
        let mut out = Heard::default();
        for heard in self.all.host.heard.drain(..) {
            match heard.message {
                Telemetry::Alarm(alarm) if alarm.on => {
                    out.called_hz = Some(f64::from(alarm.frequency));
                }
                Telemetry::Alarm(_) => out.released = true,
                Telemetry::Verdict(verdict) => {
                    let modes = verdict.modes.iter();
                    let modes = modes.map(|m| (m.label, m.amplitude, m.frequency));
                    out.loudest_hz = loudest_hz(verdict.state, modes);
                }
                _ => {}
            }
        }
        out
    }

    fn tell_speed(&mut self, spindle_hz: f64) {
        self.all.send(&Command::Set {
            setting: MONITOR_SPINDLE.number(),
            value: SettingValue::Real(spindle_hz as f32),
        });
    }
}
