//! Promise: a driver that knows embedded-hal and nothing of this project works on the simulated parts as on
//! real ones, what it reads is what the plant does, and a part that fails is told by name.
//!
//! The driver is `ads1x1x`, of a converter on I2C.

use ads1x1x::{Ads1x1x, DataRate12Bit, TargetAddr, channel::SingleA1};
use firmware::board::{AdcCode, DacCode};
use firmware::parts::{PartFailed, Polled, PwmValve, SpiConverter};
use firmware::{Block, Board, BoardErrorKind, Clock, Job, Outcome};
use hal_sim::SimLink;
use hal_sim::parts::{AdcBits, I2cAdc, SimPwm, SimTime, SpiAdc, Trouble};
use hal_sim::rig::{Plant, RigConfig, RigSetUp, SimBox, SimRig, Spoilt, Unreadable};
use rarma_box::guard::{FaultCode, Mode, Stage};
use rarma_box::wire::{Command, Deframer, MonitorJob, Refusal, Telemetry};
use rarma_core::monitor::MonitorConfig;
use rarma_core::prelude::*;
use rarma_plants::modal_noise::{Drive, ModalNoise, ModalNoiseConfig, NoiseMode, Quantity};

/// The mode that the plant has.
const F_HZ: f64 = 180.0;
const ZETA: f64 = 0.02;
/// Steps of the plant a second: a multiple of the rate below.
const PLANT_HZ: f64 = 100_000.0;
const RATE_HZ: u32 = 1250;
/// Clock of the bus, Hz.
const I2C_HZ: u32 = 400_000;

/// Volts of a structure that a white force shakes, at a time in s that only goes on.
fn structure(seed: u64) -> impl FnMut(u8, f64) -> f64 {
    let mode = NoiseMode {
        f_hz: F_HZ,
        zeta: ZETA,
        rms: 0.4,
    };
    let mut noise = ModalNoise::new(ModalNoiseConfig {
        fs_hz: PLANT_HZ,
        modes: vec![mode],
        drive: Drive::Common,
        quantity: Quantity::Displacement,
        snr_db: None,
        seed,
    })
    .expect("in range");
    let (mut steps, mut volts) = (0u64, 0.0);
    move |channel, t_s| {
        while (steps as f64) < t_s * PLANT_HZ {
            volts = noise.next_sample();
            steps += 1;
        }
        if channel == 1 { volts } else { 0.0 }
    }
}

/// The driver on the simulated bus, asked 1250 times a second.
fn listening(
    time: &SimTime,
) -> (
    impl FnMut(&mut [f32]) -> Result<Block, PartFailed> + use<>,
    Trouble,
) {
    let bus = I2cAdc::new(AdcBits::Twelve, I2C_HZ, time.clone(), structure(5));
    let torn_off = bus.torn_off.clone();
    let mut adc = Ads1x1x::new_ads1015(bus, TargetAddr::Gnd);
    adc.set_data_rate(DataRate12Bit::Sps3300).expect("answers");
    let read = move || nb::block!(adc.read(SingleA1)).map(|code| f32::from(code) / 2048.0);
    let mut source = Polled::new(RATE_HZ, time.clone(), time.clone(), read);
    (move |block: &mut [f32]| source.samples(block), torn_off)
}

#[test]
fn the_plants_mode_comes_through_the_foreign_driver() {
    let time = SimTime::default();
    let (mut source, _) = listening(&time);
    let mut model = Arma21::<f32>::new(RarmaConfig::default());
    let mut roots = FactorTracker::<f32, 2>::new();
    let mut block = [0.0; 16];
    let mut sum_of_squares = 0.0;
    let samples = 20 * RATE_HZ;
    for _ in 0..samples {
        let got = source(&mut block).expect("answers");
        assert_eq!((got.samples, got.missing), (1, 0));
        sum_of_squares += f64::from(block[0]).powi(2);
        model.update(block[0]);
        roots.track(model.a());
    }
    // The last one was asked for at 19.9992 s and has been converted since.
    let took_s = time.seconds();
    assert!((19.9993..20.0).contains(&took_s), "{took_s} s");
    // 0.4 V of 2.048.
    let rms = (sum_of_squares / f64::from(samples)).sqrt();
    assert!((0.17..0.22).contains(&rms), "rms {rms}");
    let pole = &roots.factors(2)[0];
    let fs = RATE_HZ as f32;
    let mode = modal(pole, fs).expect("a pair");
    let (cov, factor) = (model.covariance(), model.covariance_factor());
    let sd = deviation(model.a(), 3, pole, fs, cov, factor).expect("known");
    println!("{mode:?} ± {sd:?}");
    // Four of the model's own deviations, 0.18 Hz and 0.001.
    assert!((179.3..180.7).contains(&mode.frequency), "{mode:?}");
    assert!((0.016..0.024).contains(&mode.damping), "{mode:?}");
}

/// A board that is nothing but parts.
struct OfParts<S> {
    samples: S,
    link: SimLink,
    clock: SimTime,
}

impl<S> Clock for OfParts<S> {
    fn now_us(&mut self) -> u64 {
        self.clock.now_us()
    }
}

impl<S: FnMut(&mut [f32]) -> Result<Block, PartFailed>> Board for OfParts<S> {
    type Error = BoardErrorKind;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, BoardErrorKind> {
        Ok((self.samples)(block)?)
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), BoardErrorKind> {
        self.link.send(frame)
    }
}

#[test]
fn a_converter_that_is_torn_off_ends_the_job_by_name() {
    let time = SimTime::default();
    let (samples, torn_off) = listening(&time);
    let mut board = OfParts {
        samples,
        link: SimLink::default(),
        clock: time.clone(),
    };
    let job = MonitorJob {
        monitor: MonitorConfig::new(f64::from(RATE_HZ)),
        channel: 0,
        every_s: 0.1,
    };
    let mut job = Job::start(&mut board, &job).expect("in range");
    while time.seconds() < 1.0 {
        assert_eq!(job.step(), None);
    }
    torn_off.set(true);
    let end = job.step();
    assert_eq!(end, Some(Outcome::Refused(Refusal::SourceLost)));
    let mut deframer = Deframer::default();
    let told: Vec<Telemetry> = board
        .link
        .take()
        .into_iter()
        .filter_map(|byte| deframer.push::<Telemetry>(byte)?.ok())
        .map(|(_, message)| message)
        .collect();
    assert!(told.len() > 5, "verdicts came before: {}", told.len());
    assert_eq!(told.last(), Some(&Telemetry::Refused(Refusal::SourceLost)));
}

#[test]
fn a_converter_on_spi_gives_its_channels_or_an_end_of_the_range() {
    let time = SimTime::default();
    let adc = SpiAdc::new(1_000_000, time.clone(), |channel, _| {
        f64::from(channel) / 8.0 + 0.06
    });
    let (broken, torn_off) = (adc.broken.clone(), adc.torn_off.clone());
    let mut converter = SpiConverter::new(adc, 12, 0).expect("fits");
    for channel in 0..8u8 {
        let command = [0x06 | channel >> 2, channel << 6, 0];
        let part = converter.code(command).expect("answers").fraction();
        let is = f32::from(channel) / 8.0 + 0.06;
        // Half a step of 12 bits.
        assert!((part - is).abs() < 1.3e-4, "{channel}: {part} for {is}");
    }
    assert_eq!(time.ns(), 8 * 24_000);
    torn_off.set(true);
    assert_eq!(converter.code([6, 0, 0]), Ok(AdcCode::FULL));
    broken.set(true);
    assert_eq!(converter.code([6, 0, 0]), Err(PartFailed::Converter));
}

#[test]
fn pressure_follows_the_duty_of_the_valve() {
    let pwm = SimPwm::default();
    let mut valve = PwmValve::new(pwm.clone());
    let mut plant = Plant::new(RigConfig::default(), 1);
    let mut pressure_after_s = |seconds: f64, supplied: bool| {
        for _ in 0..(1e3 * seconds) as u32 {
            let duty = f64::from(pwm.duty()) / 65535.0;
            plant.slow(supplied.then_some(duty), &Spoilt::default());
        }
        plant.pressure_pa
    };
    valve.set(DacCode::from_fraction(0.4), true).expect("obeys");
    // 40 % of 9 bar, by a lag of 0.1 s after 20 ms.
    let pa = pressure_after_s(2.0, true);
    assert!((3.59e5..3.61e5).contains(&pa), "{pa}");
    pwm.refuses.set(true);
    let refused = valve.set(DacCode::from_fraction(0.8), true);
    assert_eq!(refused, Err(PartFailed::Valve));
    let pa = pressure_after_s(1.0, true);
    assert!((0.0..1e3).contains(&pa), "{pa}");
}

/// A box with its coils on.
fn energised() -> SimBox {
    let quiet = (0u32..).map(|n| 0.02 * ((n * 7919 % 1000) as f32 / 500.0 - 1.0));
    let mut all = SimBox::new(SimRig::new(RigSetUp::default(), quiet));
    all.run_to(200_000);
    all.send(&Command::Start(Mode::Cers));
    all.run_to(300_000);
    all.send(&Command::Arm);
    all.run_to(1_000_000);
    assert_eq!(all.app.supervisor().stage(), Stage::Ready);
    assert!(all.rig.outputs_on());
    all
}

#[test]
fn a_pin_that_cannot_be_read_is_a_fault_with_a_name() {
    let none = Unreadable::default();
    for (unreadable, name) in [
        (
            Unreadable {
                enable: true,
                ..none
            },
            FaultCode::EnableLost,
        ),
        (
            Unreadable {
                stop_chain: true,
                ..none
            },
            FaultCode::EmergencyStop,
        ),
        (Unreadable { gate: true, ..none }, FaultCode::Gate),
    ] {
        let mut all = energised();
        let from_us = all.rig.world_us();
        all.rig.unreadable = unreadable;
        all.run_for(0.2);
        let fault = all.app.supervisor().fault().expect("latched");
        assert_eq!(fault.code, name);
        assert_eq!(all.app.supervisor().stage(), Stage::Faulted);
        let off_us = all.rig.last_on_us().expect("were on") - from_us;
        assert!(off_us <= 2_000, "{name:?}: off after {off_us} µs");
        assert_eq!(all.resets, 0);
    }
}
