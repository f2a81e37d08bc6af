//! Boxes that are light: no sound is heard, but frames are the box's own, at the box's rates, and
//! commands are answered. Time goes as fast as is asked for and the wire takes it, and stands while nobody listens.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::guard::{Mode, Stage};
use rarma_box::settings::{MONITOR_SPINDLE, SETTINGS, SettingValue};
use rarma_box::wire::{
    AlarmMessage, Answer, Command, ControlMessage, Deframer, Handed, Identity, MAX_FRAME,
    ModeMessage, NOBODY, Order, Reply, SettingMessage, SpindleMessage, Started, Status, Telemetry,
    Verdict, encode, open,
};
use rarma_core::decide::{Label, Origin, Reason, State};
use rarma_core::monitor::SpeedSource;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

pub const FS_HZ: f64 = 48_000.0;

/// A stretch of one state, and the alarm that was called at its beginning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    pub from_s: u64,
    pub to_s: u64,
    pub state: State,
}

/// What really was.
#[derive(Debug, Default)]
pub struct Truth {
    pub runs: Vec<Run>,
    pub frames: u64,
}

pub struct SimulatedBox {
    pub port: u16,
    pub session: u32,
    pub truth: Arc<Mutex<Truth>>,
    /// How far it is, s.
    pub at_s: Arc<AtomicU64>,
    /// The speed that it was told last, 1/min.
    pub told_rpm: Arc<Mutex<Option<f32>>>,
    thread: Option<JoinHandle<()>>,
}

/// How a box of the plant goes on.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// So long, s.
    pub seconds: u64,
    /// Time between two verdicts, s.
    pub every_s: u64,
    /// So many of them in a row, then a pause: what a machine that does other things, too, keeps up with.
    pub row: u64,
    /// The pause.
    pub pause: Duration,
}

impl SimulatedBox {
    pub fn start(seed: u64, plan: Plan, stop: &Arc<AtomicBool>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        listener.set_nonblocking(true).unwrap();
        let session = 1000 + seed as u32;
        let one = Self {
            port: listener.local_addr().unwrap().port(),
            session,
            truth: Arc::default(),
            at_s: Arc::default(),
            told_rpm: Arc::default(),
            thread: None,
        };
        let mut machine = Machine {
            rng: ChaCha8Rng::seed_from_u64(seed),
            session,
            sequence: 0,
            state: State::Idle,
            left_s: 30,
            from_s: 0,
            truth: Arc::clone(&one.truth),
            told_rpm: Arc::clone(&one.told_rpm),
            holder: ControlMessage {
                turn: 1,
                by: NOBODY,
                why: Handed::Start,
                key: false,
            },
            out: Vec::new(),
        };
        let (at_s, stop) = (Arc::clone(&one.at_s), Arc::clone(stop));
        let thread = thread::spawn(move || machine.run(&listener, plan, &at_s, &stop));
        Self {
            thread: Some(thread),
            ..one
        }
    }

    pub fn join(&mut self) {
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

struct Machine {
    rng: ChaCha8Rng,
    session: u32,
    sequence: u32,
    state: State,
    left_s: u64,
    from_s: u64,
    truth: Arc<Mutex<Truth>>,
    told_rpm: Arc<Mutex<Option<f32>>>,
    holder: ControlMessage,
    out: Vec<u8>,
}

impl Machine {
    fn run(&mut self, listener: &TcpListener, plan: Plan, at_s: &AtomicU64, stop: &AtomicBool) {
        let mut t = 0;
        let mut host: Option<(TcpStream, Deframer)> = None;
        while !stop.load(Ordering::Relaxed) {
            let Some((socket, deframer)) = &mut host else {
                match listener.accept() {
                    Ok((socket, _)) => {
                        // What is on its way when a gateway is killed is lost: keep it short.
                        socket
                            .set_write_timeout(Some(Duration::from_millis(500)))
                            .unwrap();
                        socket
                            .set_read_timeout(Some(Duration::from_secs(2)))
                            .unwrap();
                        let mut deframer = Deframer::default();
                        let mut socket = socket;
                        // The host asks who this is before it can make anything of verdicts.
                        if self.hear(&mut socket, &mut deframer, true) {
                            if t >= plan.seconds {
                                // Its last words may have been lost: without more of them nobody would know.
                                let verdict = self.verdict(plan.seconds);
                                self.say(&verdict);
                            }
                            socket.set_nonblocking(true).unwrap();
                            host = Some((socket, deframer));
                        }
                    }
                    Err(_) => thread::sleep(Duration::from_millis(5)),
                }
                continue;
            };
            let mut here = self.hear(socket, deframer, false);
            if t < plan.seconds {
                self.step(t, plan.every_s);
                t += plan.every_s;
                if t >= plan.seconds {
                    self.end(plan.seconds);
                }
                at_s.store(t, Ordering::Relaxed);
            } else {
                thread::sleep(Duration::from_millis(10));
            }
            let pause = (t / plan.every_s).is_multiple_of(plan.row);
            if self.out.len() > 4096 || pause || t >= plan.seconds {
                here &= self.flush(socket, stop);
            }
            if pause {
                thread::sleep(plan.pause);
            }
            if !here {
                self.out.clear();
                host = None;
            }
        }
        self.truth.lock().unwrap().frames = u64::from(self.sequence);
    }

    fn flush(&mut self, socket: &mut TcpStream, stop: &AtomicBool) -> bool {
        let mut sent = 0;
        while sent < self.out.len() && !stop.load(Ordering::Relaxed) {
            match socket.write(&self.out[sent..]) {
                Ok(0) => return false,
                Ok(n) => sent += n,
                Err(why) if why.kind() == ErrorKind::WouldBlock => {
                    thread::sleep(Duration::from_millis(1))
                }
                Err(_) => return false,
            }
        }
        self.out.clear();
        true
    }

    fn say(&mut self, message: &Telemetry) {
        let mut buffer = [0; MAX_FRAME];
        let frame = encode(message, self.session, self.sequence, &mut buffer).unwrap();
        self.out.extend_from_slice(frame);
        self.sequence += 1;
    }

    /// One verdict, and what comes with it.
    fn step(&mut self, t: u64, every_s: u64) {
        if self.left_s == 0 {
            let before = self.state;
            self.truth.lock().unwrap().runs.push(Run {
                from_s: self.from_s,
                to_s: t,
                state: before,
            });
            let (next, least, most) = match (before, self.rng.random_range(0..10)) {
                (State::Idle, _) => (State::Stable, 60, 1200),
                (State::Stable, 0..=1) => (State::Warning, 2, 10),
                (State::Stable, 2) => (State::Invalid, 2, 20),
                (State::Stable, _) => (State::Idle, 60, 900),
                (State::Warning, 0..=5) => (State::Chatter, 3, 40),
                (State::Warning | State::Invalid, _) => (State::Stable, 60, 600),
                (State::Chatter, 0..=2) => (State::Idle, 300, 1800),
                (_, _) => (State::Stable, 30, 300),
            };
            (self.state, self.from_s) = (next, t);
            self.left_s = self.rng.random_range(least..most) / every_s * every_s + every_s;
            if (before == State::Chatter) != (next == State::Chatter) {
                self.say(&Telemetry::Alarm(AlarmMessage {
                    sample: (t as f64 * FS_HZ) as u64,
                    on: next == State::Chatter,
                    frequency: 900.0,
                    damping: -0.004,
                }));
            }
        }
        self.left_s = self.left_s.saturating_sub(every_s);
        let verdict = self.verdict(t);
        self.say(&verdict);
        if t.is_multiple_of(60) {
            let status = self.status(t);
            self.say(&status);
        }
    }

    fn end(&mut self, t: u64) {
        self.truth.lock().unwrap().runs.push(Run {
            from_s: self.from_s,
            to_s: t,
            state: self.state,
        });
        // One more verdict, of another state, closes the last stretch.
        self.state = if self.state == State::Idle {
            State::Starting
        } else {
            State::Idle
        };
        let verdict = self.verdict(t);
        self.say(&verdict);
    }

    fn verdict(&mut self, t: u64) -> Telemetry {
        let mut modes = heapless::Vec::new();
        for frequency in [320.0_f32, 900.0, 1450.0] {
            let _ = modes.push(ModeMessage {
                frequency: frequency + self.rng.random_range(-2.0..2.0),
                frequency_sd: 1.5,
                damping: if self.state == State::Chatter && frequency == 900.0 {
                    -0.003
                } else {
                    0.03
                },
                damping_sd: 0.004,
                amplitude: 0.05,
                gradient: 0.0,
                label: if self.state == State::Chatter {
                    Label::SelfExcited
                } else {
                    Label::Structural
                },
                harmonic: None,
                origin: Origin::Free,
                time_left_s: None,
            });
        }
        let hz = self.told_rpm.lock().unwrap().map_or(80.0, |rpm| rpm / 60.0);
        Telemetry::Verdict(Verdict {
            sample: (t as f64 * FS_HZ) as u64,
            state: self.state,
            reason: Reason::None,
            level: 0.2,
            modes,
            spindle: SpindleMessage {
                hz: Some(hz),
                source: SpeedSource::Told,
                locked: true,
                notch_hz: 3.0,
                removed_power: 0.0,
            },
            amplitude: None,
        })
    }

    fn status(&self, t: u64) -> Telemetry {
        Telemetry::Status(Status {
            now_us: t * 1_000_000,
            mode: Mode::Monitor,
            stage: Stage::Off,
            energised: false,
            contacts: (false, true),
            fault: None,
            current_a: [0.0; 4],
            heat: 0.0,
            gap_m: [0.0; 2],
            pressure_pa: 0.0,
            gauge_m: 0.0,
            supply_v: 0.0,
            limiting: false,
            press_again: false,
            control: self.holder,
        })
    }

    /// Takes what the host says; with `wait` until it has asked who this is. False: it is gone.
    fn hear(&mut self, socket: &mut TcpStream, deframer: &mut Deframer, wait: bool) -> bool {
        loop {
            let mut bytes = [0; 1024];
            let n = match socket.read(&mut bytes) {
                Ok(0) => return false,
                Ok(n) => n,
                Err(why) if why.kind() == ErrorKind::WouldBlock => return !wait,
                Err(_) => return false,
            };
            let mut identified = false;
            for &byte in &bytes[..n] {
                let Some(Ok(stuffed)) = deframer.collect(byte) else {
                    continue;
                };
                let mut plain = [0; MAX_FRAME];
                let Ok(opened) = open(stuffed, &mut plain) else {
                    continue;
                };
                let Ok((order, _)) = opened.order() else {
                    continue;
                };
                identified |= order.command == Command::Identify;
                let answer = self.answer(order);
                let reply = Reply {
                    by: order.by,
                    to: opened.head.sequence,
                    answer,
                };
                self.say(&Telemetry::Reply(reply));
            }
            if !wait || identified {
                if wait {
                    let out = std::mem::take(&mut self.out);
                    return socket.write_all(&out).is_ok();
                }
                return true;
            }
        }
    }

    fn answer(&mut self, order: Order) -> Answer {
        match order.command {
            Command::Identify => Answer::Identity(Identity {
                board: "light".try_into().unwrap(),
                version: "0.1.0".try_into().unwrap(),
                schema: 1,
                settings: SETTINGS.len() as u16,
                sample_rate_hz: FS_HZ as f32,
                loop_rate_hz: 40_000.0,
                started: Started::PowerOn,
                before: None,
                control: self.holder,
            }),
            Command::Read { setting } => Answer::Setting(SettingMessage {
                setting,
                value: SettingValue::Whole(1),
                stored: None,
            }),
            Command::Take { .. } => {
                self.holder = ControlMessage {
                    turn: self.holder.turn + 1,
                    by: order.by,
                    why: Handed::Taken,
                    key: false,
                };
                self.say(&Telemetry::Control(self.holder));
                Answer::Done
            }
            Command::Release => {
                self.holder = ControlMessage {
                    turn: self.holder.turn + 1,
                    by: NOBODY,
                    why: Handed::GivenUp,
                    key: false,
                };
                self.say(&Telemetry::Control(self.holder));
                Answer::Done
            }
            Command::Set {
                setting,
                value: SettingValue::Real(hz),
            } if setting == MONITOR_SPINDLE.number() => {
                *self.told_rpm.lock().unwrap() = Some(hz * 60.0);
                Answer::Done
            }
            // Nothing else is ever asked of a box by a gateway; it would be seen here.
            other => panic!("a gateway said {other:?}"),
        }
    }
}
