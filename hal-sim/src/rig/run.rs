//! Board, application and host together: resets, panics and power cuts included.

use super::board::SimRig;
use super::fault::FaultKind;
use super::host::SimHost;
use super::link::Noise;
use firmware::board::{Emergency, ResetCause};
use firmware::{BoxBoard, SensorBox, last_words};
use rarma_box::guard::FaultCode;
use rarma_box::wire::Command;

/// The box at work.
#[derive(Debug)]
pub struct SimBox {
    /// The board.
    pub rig: SimRig,
    /// The host.
    pub host: SimHost,
    /// The application.
    pub app: SensorBox,
    /// Resets so far.
    pub resets: u32,
}

impl SimBox {
    /// Power comes on, and the host takes control.
    pub fn new(rig: SimRig) -> Self {
        let mut this = Self::unattended(rig);
        this.host.greet(this.rig.link.waiting_for_host());
        let bytes = this.host.by_itself(0);
        this.rig.link.host_sends(&bytes);
        this.app.poll(&mut this.rig);
        this.host.greet(this.rig.link.waiting_for_host());
        this
    }

    /// Power comes on, and nobody has said anything yet.
    pub fn unattended(mut rig: SimRig) -> Self {
        let app = SensorBox::start(&mut rig);
        Self {
            rig,
            host: SimHost::default(),
            app,
            resets: 0,
        }
    }

    /// The host sends a command; its sequence number.
    pub fn send(&mut self, command: &Command) -> u32 {
        let (sequence, bytes) = self.host.command(command);
        self.rig.link.host_sends(&bytes);
        sequence
    }

    /// [`Self::step`], and the bytes that came to the host in it.
    pub fn step_and_take(&mut self) -> Vec<u8> {
        let now_us = self.rig.world_us();
        if self.rig.stands(FaultKind::HeartbeatLost).is_none() {
            let bytes = self.host.by_itself(now_us);
            self.rig.link.host_sends(&bytes);
        }
        let noisy = self.rig.stands(FaultKind::LinkNoisy).is_some();
        self.rig.link.burst = noisy.then_some(Noise {
            drop: 0.01,
            double: 0.01,
            change: 0.01,
        });
        self.app.poll(&mut self.rig);
        self.exceptions();
        self.rig.wait();
        if let Some(cause) = self.rig.reset {
            self.reset(cause);
        }
        let bytes = self.rig.link.host_takes();
        self.host.hears(self.rig.world_us(), &bytes);
        bytes
    }

    /// One pass of the main loop and the sleep after it, and the host beside it.
    pub fn step(&mut self) {
        self.step_and_take();
    }

    /// Runs until a world time, µs.
    pub fn run_to(&mut self, world_us: u64) {
        while self.rig.world_us() < world_us {
            self.step();
        }
    }

    /// Runs for so long, s.
    pub fn run_for(&mut self, seconds: f64) {
        self.run_to(self.rig.world_us() + (1e6 * seconds) as u64);
    }

    /// What no application survives.
    fn exceptions(&mut self) {
        for (kind, code) in [
            (FaultKind::Panic, FaultCode::Panic),
            (FaultKind::HardFault, FaultCode::HardFault),
        ] {
            if self.rig.falls_due(kind).is_some() {
                last_words(&mut self.rig, code, 1.0);
                self.reset(ResetCause::Software);
            }
        }
        if self.rig.falls_due(FaultKind::BrownOut).is_some() {
            self.rig.without_power(5_000);
            self.sleep(5_000);
            self.reset(ResetCause::BrownOut);
        }
        if self.rig.falls_due(FaultKind::PowerCut).is_some() {
            self.rig.without_power(50_000);
            self.sleep(50_000);
            // Memory that nothing holds up.
            self.rig.keep(&[0x5A; rarma_box::guard::KEPT_BYTES]);
            self.reset(ResetCause::PowerOn);
        }
    }

    fn sleep(&mut self, us: u64) {
        let until = self.rig.world_us() + us;
        while self.rig.world_us() < until {
            self.rig.wait();
        }
    }

    fn reset(&mut self, cause: ResetCause) {
        self.rig.restart(cause);
        self.app = SensorBox::start(&mut self.rig);
        self.resets += 1;
    }
}
