//! A box, two hosts and whoever sits on the line between: everything that is said to the box
//! is kept, so that it can be said again, later, in another order.

use crate::rig::quiet;
use firmware::board::Origin;
use hal_sim::rig::{RigSetUp, SimBox, SimHost, SimRig};
use rarma_box::guard::Mode;
use rarma_box::wire::{Answer, Command, LinkKey, Telemetry};

/// The key of the tests.
pub const KEY: LinkKey = LinkKey(*b"thirty-two bytes that nobody saw");
/// Heartbeats come this often, µs.
const HEARTBEAT_US: u64 = 100_000;

/// A frame that was said, and its number.
pub type Frame = (u32, Vec<u8>);

/// A box, two hosts, and whoever sits on the line between. Its hosts do nothing by themselves but send heartbeats while they are told
/// to.
pub struct Bench {
    /// The box; its own host is the first.
    pub all: SimBox,
    /// The second host.
    pub second: SimHost,
    /// Everything that was said, in order.
    pub said: Vec<Vec<u8>>,
    /// The first host sends heartbeats.
    pub beats: bool,
    next_beat_us: u64,
}

impl Default for Bench {
    fn default() -> Self {
        Self::new(None, Origin::OwnPort)
    }
}

impl Bench {
    /// A box that is in CERS, nobody in control; with a key, it and both hosts know it.
    ///
    /// # Panics
    /// The box does not come to that.
    pub fn new(key: Option<LinkKey>, origin: Origin) -> Self {
        let rig = SimRig::new(RigSetUp::default(), quiet(1));
        let mut all = SimBox::new(rig);
        all.send(&Command::Start(Mode::Cers));
        if let Some(key) = key {
            let setting = rarma_box::settings::LINK_KEY.number();
            let value = rarma_box::settings::SettingValue::Key(key);
            all.send(&Command::Set { setting, value });
            all.host.speaker.set_key(Some(key));
            all.send(&Command::Save { setting });
        }
        all.send(&Command::Release);
        all.host.takes_control = false;
        all.host.heartbeat_us = None;
        all.run_for(0.1);
        assert_eq!(all.app.supervisor().mode(), Mode::Cers);
        assert!(all.host.speaker.is_free());
        all.rig.link.origin = origin;
        let mut second = SimHost::new(2, key);
        second.heartbeat_us = None;
        let mut bench = Self {
            all,
            second,
            said: Vec::new(),
            beats: false,
            next_beat_us: 0,
        };
        bench.run(0.3);
        bench
    }

    /// Time goes on, s.
    pub fn run(&mut self, seconds: f64) {
        let until_us = self.all.rig.world_us() + (1e6 * seconds) as u64;
        while self.all.rig.world_us() < until_us {
            let now_us = self.all.rig.world_us();
            if self.beats && now_us >= self.next_beat_us {
                self.next_beat_us = now_us + HEARTBEAT_US;
                let frame = self.make(1, Command::Heartbeat);
                self.put(&frame);
            }
            let bytes = self.all.step_and_take();
            self.second.hears(self.all.rig.world_us(), &bytes);
        }
    }

    /// A frame of the first host or the second that is not on its way yet.
    pub fn make(&mut self, host: u32, command: Command) -> Frame {
        if host == 1 {
            self.all.host.command(&command)
        } else {
            self.second.command(&command)
        }
    }

    /// A frame comes to the box, whoever made it.
    pub fn put(&mut self, (_, bytes): &Frame) {
        self.said.push(bytes.clone());
        self.all.rig.link.host_sends(bytes);
    }

    /// A frame comes to the box, and its answer.
    ///
    /// # Panics
    /// There is none.
    pub fn come(&mut self, frame: &Frame) -> Answer {
        self.all.host.heard.clear();
        self.put(frame);
        self.run(0.01);
        let heard = &self.all.host.heard;
        let answer = heard.iter().rev().find_map(|h| match &h.message {
            Telemetry::Reply(reply) if reply.to == frame.0 => Some(reply.answer.clone()),
            _ => None,
        });
        answer.expect("every frame is answered")
    }

    /// A host says something, and its answer.
    pub fn ask(&mut self, host: u32, command: Command) -> Answer {
        let frame = self.make(host, command);
        self.come(&frame)
    }

    /// The first host takes control and arms; outputs are at their working point.
    ///
    /// # Panics
    /// They are not.
    pub fn armed(&mut self) {
        self.take_and_arm();
        self.run(0.4);
        assert!(self.is_on());
    }

    /// The first host takes control, if it has not got it, and says `arm`: its frame.
    pub fn take_and_arm(&mut self) -> Frame {
        if !self.all.host.speaker.in_control() {
            assert_eq!(self.ask(1, Command::Take { turn: 0 }), Answer::Done);
        }
        self.beats = true;
        self.run(0.01);
        let arm = self.make(1, Command::Arm);
        assert_eq!(self.come(&arm), Answer::Done);
        arm
    }

    /// Whoever stands at the machine releases the enable input for so long, ms, and presses
    /// it again.
    pub fn press_again(&mut self, ms: u32) {
        self.all.rig.contacts.enable = false;
        self.run(1e-3 * f64::from(ms));
        self.all.rig.contacts.enable = true;
        self.run(0.005);
    }

    /// Outputs are on, or on their way there.
    pub fn is_on(&self) -> bool {
        self.all.app.supervisor().stage().in_use() || self.all.rig.outputs_on()
    }

    /// The reset line is pulled: a panic.
    ///
    /// # Panics
    /// It does not restart.
    pub fn restart(&mut self) {
        let resets = self.all.resets;
        self.beats = false;
        self.all.rig.add_fault(hal_sim::rig::FaultEvent {
            kind: hal_sim::rig::FaultKind::Panic,
            place: 0,
            from_us: self.all.rig.world_us(),
            to_us: u64::MAX,
        });
        self.run(0.3);
        assert_eq!(self.all.resets, resets + 1);
    }
}
