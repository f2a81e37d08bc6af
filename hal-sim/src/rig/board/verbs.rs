//! The verbs of the box, over the plant; what stands between is spoilt by faults.

use super::{LOOP_HZ, PERIOD_US, SAMPLE_HZ, SimRig, WAIT_PERIODS};
use crate::parts::NoTime;
use crate::rig::fault::FaultKind;
use crate::rig::flash::{SECTOR, SECTORS, SimFlash};
use crate::rig::plant::Spoilt;
use firmware::board::{
    AdcCode, CoilOrder, CoilReport, Contacts, DacCode, FlashSeen, Lights, Origin, Pulse,
    ResetCause, SensorCodes, WATCHDOG_US,
};
use firmware::{Block, Board, BoardErrorKind, BoxBoard};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::guard::KEPT_BYTES;
use rarma_rigs::cers::Source;
use std::ops::Range;

impl Board for SimRig {
    type Error = BoardErrorKind;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, BoardErrorKind> {
        let first = !self.second_microphone;
        if first && self.stands(FaultKind::MicDead).is_some() {
            let due = self.samples_due();
            // What the converter did not convert was never a sample.
            while self.sound_given < due {
                self.sound.next();
                self.sound_given += 1;
            }
            return Err(BoardErrorKind::Converter);
        }
        if first && self.falls_due(FaultKind::MicOverrun).is_some() {
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
            let x = match &mut self.accelerometer {
                Some(sensor) => sensor.waiting.pop_front(),
                None => self.sound.next(),
            };
            let x = x.unwrap_or(0.0);
            self.sound_given += 1;
            *place = self.heard(x);
            samples += 1;
        }
        Ok(Block {
            samples,
            missing: std::mem::take(&mut self.missing),
        })
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), BoardErrorKind> {
        let blocked = self.stands(FaultKind::LinkBlocked).is_some();
        if self.link.box_sends(frame, blocked) {
            Ok(())
        } else {
            Err(BoardErrorKind::Busy)
        }
    }
}

impl BoxBoard for SimRig {
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

    fn listen_to(&mut self, microphone: u8) {
        self.second_microphone = microphone == 1;
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
        let report = self.main_side.exchange(&mut self.coil_loop, order);
        report.unwrap_or_default()
    }

    fn excite(&mut self, signal: &Source) {
        self.coil_loop.excite(signal);
    }

    fn sensors(&mut self) -> Result<SensorCodes, BoardErrorKind> {
        if self.stands(FaultKind::SensorsDead).is_some() {
            return Err(BoardErrorKind::Converter);
        }
        let spoilt = if self.faults.is_empty() {
            Spoilt::default()
        } else {
            self.spoilt()
        };
        let gap = self.gap_codes();
        let mut pressure = self.plant.pressure_code();
        if self.stands(FaultKind::PressureLost).is_some() {
            pressure = 0;
        }
        let mut gauge = self.plant.gauge_code(&spoilt);
        if self.stands(FaultKind::GaugeLost).is_some() {
            gauge = u16::MAX;
        }
        let fitted = self.plant.config.thermistor.is_some();
        if fitted && self.stands(FaultKind::ThermistorLost).is_some() {
            gauge = 0;
        }
        Ok(SensorCodes {
            gap: gap.map(AdcCode),
            pressure: AdcCode(pressure),
            gauge: AdcCode(gauge),
            supply: AdcCode(self.plant.supply_code(&spoilt)),
        })
    }

    fn valve(&mut self, code: DacCode) -> Result<(), BoardErrorKind> {
        let refuses = self.stands(FaultKind::ValveRefuses).is_some();
        self.pins.pwm.refuses.set(refuses);
        let closed = self.energised();
        Ok(self.pins.valve.set(code, closed)?)
    }

    fn contacts(&mut self) -> Contacts {
        let closed = |by_hand, kind| by_hand && self.stands(kind).is_none();
        let enable = closed(self.contacts.enable, FaultKind::EnableLost);
        let stop_chain = closed(self.contacts.stop_chain, FaultKind::EmergencyStop);
        let pins = &mut self.pins;
        pins.enable.hold(enable);
        pins.enable.unreadable.set(self.unreadable.enable);
        pins.stop_chain.hold(stop_chain);
        pins.stop_chain.unreadable.set(self.unreadable.stop_chain);
        pins.contacts.read()
    }

    fn energise(&mut self) -> Result<(), BoardErrorKind> {
        let contacts = self.contacts();
        let refuses = self.stands(FaultKind::GateRefuses).is_some();
        let pins = &mut self.pins;
        pins.relay.refuses.set(refuses);
        pins.relay.contact.unreadable.set(self.unreadable.gate);
        Ok(pins.gate.close(contacts, &mut NoTime)?)
    }

    fn energised(&mut self) -> bool {
        let pins = &mut self.pins;
        pins.relay.contact.unreadable.set(self.unreadable.gate);
        pins.gate.is_closed()
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

    fn entropy(&mut self) -> u32 {
        let mut generator = ChaCha8Rng::seed_from_u64(self.draws);
        self.draws = generator.random();
        generator.random()
    }

    fn flash(&mut self) -> (&mut SimFlash, Range<u32>) {
        self.flash.worn = self.stands(FaultKind::FlashWorn).is_some();
        if self.stands(FaultKind::FlashFull).is_some() {
            self.flash.fill();
        }
        (&mut self.flash, 0..(SECTOR * SECTORS) as u32)
    }

    fn flash_seen(&mut self) -> FlashSeen {
        self.flash.take_seen()
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, BoardErrorKind> {
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

    fn origin(&mut self) -> Origin {
        self.link.origin
    }

    fn lights(&mut self, lights: Lights) {
        self.lights = lights;
    }
}
