//! Promise: whoever copies, holds back, delays or reorders what two hosts say, the box energises
//! only on a genuine `arm` that comes for the first time and was said after every `stop` that
//! has come.
//!
//! `cargo test --release -p host-tests --test link_replay -- --nocapture`

use firmware::board::Origin;
use host_tests::link_bench::{Bench, Frame, KEY};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::guard::Mode;
use rarma_box::wire::{Command, LinkKey};

/// A frame that was made: what it says, when, and whether it has come.
struct Made {
    frame: Frame,
    command: Command,
    at: u32,
    session: u32,
    has_come: bool,
}

struct Run {
    bench: Bench,
    rng: ChaCha8Rng,
    made: Vec<Made>,
    /// The latest `stop` that has come, by when it was made.
    last_stop: Option<u32>,
    clock: u32,
    /// How often outputs came on, and how often something came that was no news.
    on: u32,
    stale: u32,
}

impl Run {
    fn new(seed: u64, key: Option<LinkKey>, origin: Origin) -> Self {
        Self {
            bench: Bench::new(key, origin),
            rng: ChaCha8Rng::seed_from_u64(seed),
            made: Vec::new(),
            last_stop: None,
            clock: 0,
            on: 0,
            stale: 0,
        }
    }

    fn make(&mut self, host: u32, command: Command) -> usize {
        self.clock += 1;
        let session = self.bench.all.host.session();
        let frame = self.bench.make(host, command);
        self.made.push(Made {
            frame,
            command,
            at: self.clock,
            session,
            has_come: false,
        });
        self.made.len() - 1
    }

    /// A frame comes to the box, for the first time or not; the promise is looked at.
    fn come(&mut self, k: usize) {
        let was_on = self.bench.is_on();
        let session = self.bench.all.host.session();
        let made = &mut self.made[k];
        let first = !std::mem::replace(&mut made.has_come, true);
        let may_energise = first
            && made.command == Command::Arm
            && made.session == session
            && self.last_stop.is_none_or(|at| made.at > at);
        self.stale += u32::from(!first);
        if made.command == Command::Stop && made.session == session {
            self.last_stop = self.last_stop.max(Some(made.at));
        }
        let is_stop = made.command == Command::Stop && made.session == session;
        self.bench.put(&self.made[k].frame);
        self.bench.run(0.003);
        let is_on = self.bench.is_on();
        assert!(
            was_on || !is_on || may_energise,
            "{:?}, made at {} of {}, the last stop at {:?}, first time: {first}",
            self.made[k].command,
            self.made[k].at,
            self.clock,
            self.last_stop
        );
        if first && is_stop && is_on {
            // On its way down, unless this is a frame that the window has given up.
            self.bench.run(0.4);
            let old = self.made[k].at + 64 < self.clock;
            assert!(
                old || !self.bench.is_on(),
                "a stop that came was not obeyed"
            );
        }
        self.on += u32::from(is_on && !was_on);
    }

    fn says(&mut self, host: u32, command: Command, held: f64) {
        let k = self.make(host, command);
        if !self.rng.random_bool(held) {
            self.come(k);
        }
    }

    fn step(&mut self) {
        let host = if self.rng.random_bool(0.7) { 1 } else { 2 };
        match self.rng.random_range(0..20) {
            0..4 => {
                if self.rng.random_bool(0.3) {
                    self.bench.press_again(60);
                }
                for command in [
                    Command::Take { turn: 0 },
                    Command::Clear,
                    Command::Start(Mode::Cers),
                    Command::Heartbeat,
                ] {
                    self.says(host, command, 0.02);
                }
                self.bench.beats = host == 1;
                self.says(host, Command::Arm, 0.3);
            }
            4..6 => self.says(host, Command::Arm, 0.3),
            6..9 => self.says(host, Command::Stop, 0.3),
            9 => self.says(host, Command::Release, 0.1),
            10 => self.says(host, Command::Heartbeat, 0.5),
            11 => self.bench.press_again(60),
            12 => self.bench.run(0.2),
            13 if self.rng.random_bool(0.1) => self.bench.restart(),
            // Whoever sits on the line: any frame there was, the last ones above all.
            _ if !self.made.is_empty() => {
                let back = self.rng.random_range(0..self.made.len().min(24));
                let any = self.rng.random_range(0..self.made.len());
                let recent = self.made.len() - 1 - back;
                let k = if self.rng.random_bool(0.7) {
                    recent
                } else {
                    any
                };
                self.come(k);
            }
            _ => {}
        }
    }
}

fn runs(key: Option<LinkKey>, origin: Origin, seeds: std::ops::Range<u64>) {
    let (mut on, mut stale) = (0, 0);
    for seed in seeds {
        let mut run = Run::new(seed, key, origin);
        for _ in 0..80 {
            run.step();
        }
        on += run.on;
        stale += run.stale;
    }
    println!("{on} times on by a genuine arm, {stale} frames came again");
    assert!(on > 100 && stale > 1000, "{on} {stale}");
}

#[test]
fn nothing_but_a_fresh_arm_energises() {
    runs(None, Origin::OwnPort, 0..120);
}

#[test]
fn nothing_but_a_fresh_arm_energises_with_a_key_over_a_network() {
    runs(Some(KEY), Origin::Network, 1000..1060);
}
