//! A chatter lamp on embassy: a NUCLEO-G474RE with a microphone at A0 (PA0) lights LD2 while it
//! hears chatter.
//!
//! The converter runs 384 000 times a second and adds up sixteen conversions, the DMA fills one half
//! of a buffer while the other is listened to. Where that takes too long the driver says so, and the
//! monitor is told that samples are missing.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Exten, Rovsm, SampleTime, Trovs};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk, mux};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{MasterMode, RoundTo, Timer};
use embassy_stm32::{Config, bind_interrupts, dma, peripherals, triggers};
use rarma_core::prelude::*;
use static_cell::StaticCell;

const FS_HZ: u32 = 24_000;
const CONVERSIONS: u32 = 16;
/// 10 ms, and of as many the DMA is ahead.
const BLOCK: usize = 240;

bind_interrupts!(struct Irqs {
    DMA1_CHANNEL1 => dma::InterruptHandler<peripherals::DMA1_CH1>;
});

/// Too large for the stack: it is begun in its place.
static MONITOR: StaticCell<Monitor<f32>> = StaticCell::new();
static RING: StaticCell<[u16; 2 * BLOCK]> = StaticCell::new();

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let parts = embassy_stm32::init(clocks());
    let mut lamp = Output::new(parts.PA5, Level::Low, Speed::Low);
    let config = MonitorConfig {
        order: Order::O43,
        full_scale: Some(1.0),
        ..MonitorConfig::new(f64::from(FS_HZ))
    };
    let monitor = MONITOR.init_with(Monitor::unstarted);
    monitor.restart(&config).expect("settings in their ranges");

    let adc = Adc::new(
        parts.ADC1,
        AdcConfig {
            oversampling_ratio: Some(CONVERSIONS.trailing_zeros() as u8 - 1),
            oversampling_mode: Some((Rovsm::RESUMED, Trovs::TRIGGERED, true)),
            ..AdcConfig::default()
        },
    );
    let mut samples = adc.into_ring_buffered(
        parts.DMA1_CH1,
        RING.init([0; 2 * BLOCK]),
        Irqs,
        [(parts.PA0.degrade_adc(), SampleTime::CYCLES24_5)].into_iter(),
        triggers::TIM6_TRGO,
        Exten::RISING_EDGE,
    );
    let timer = Timer::new(parts.TIM6);
    timer.set_frequency(Hertz(CONVERSIONS * FS_HZ), RoundTo::Slower);
    timer
        .regs_basic()
        .cr2()
        .modify(|w| w.set_mms(MasterMode::UPDATE));
    timer.start();

    // Codes from 0 to this; silence lies in the middle.
    let middle = (CONVERSIONS * 4096 / 2) as f32;
    let mut block = [0; BLOCK];
    loop {
        if samples.read(&mut block).await.is_err() {
            // How many is not told.
            monitor.missing(BLOCK as u32);
            continue;
        }
        for code in block {
            if let Some(report) = monitor.push((f32::from(code) - middle) / middle) {
                lamp.set_level(Level::from(report.state == State::Chatter));
            }
        }
    }
}

/// The board's crystal, and 76.8 MHz: 200 times the conversions, and below the 80 MHz from which on the core's
/// clock must rise in two steps.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse {
        freq: Hertz(24_000_000),
        mode: HseMode::Oscillator,
    });
    config.rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV5,
        mul: PllMul::MUL32,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.mux.adc12sel = mux::Adcsel::SYS;
    config
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
