//! The clock tree: everything from the crystal through one PLL; see [`timing`].
//!
//! Above 150 MHz the core needs its boosted voltage, and above 80 MHz its clock must rise in two
//! steps with 1 µs between them (RM0440, 6.1.5). The HAL does neither: its register data has
//! R1MODE at bit 0 of PWR_CR5, where nothing is (it is bit 8), and it rises in one step. So the
//! chip starts on its slow oscillator, boost is switched on here, the HAL brings the core to
//! half its speed, and the last step is made here. The HAL goes on thinking that the buses run at
//! half: what it would derive from them is derived from SYSCLK, or set here.

use super::timing;
use embassy_stm32::pac::flash::vals::Latency;
use embassy_stm32::pac::pwr::regs::Cr5;
use embassy_stm32::pac::rcc::vals::Hpre;
use embassy_stm32::pac::{DAC1, DAC3, DAC4, FLASH, PWR, RCC};
use embassy_stm32::rcc::{
    self, AHBPrescaler, Hse, HseMode, Hsi48Config, Pll, PllMul, PllPreDiv, PllRDiv, PllSource,
    Sysclk, mux,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, peripherals};

/// Cycles of the core at half its speed, at least 1 µs.
const STEP: u32 = timing::TICK_HZ / 2 / 1_000_000 + 1;
/// DAC_MCR, HFSEL: a bus of more than 160 MHz.
const DAC_BUS: u8 = 0b10;
const _: () = assert!(timing::TICK_HZ > 160_000_000);

/// Starts every clock; the chip runs on its slow oscillator, and its power interface is on.
pub(super) fn start(clocks: &mut Peri<'static, peripherals::RCC>) {
    // Every other bit is reserved and 0.
    PWR.cr5().write_value(Cr5(0));
    rcc::reinit(half_speed(), clocks);
    FLASH.acr().modify(|w| w.set_latency(Latency::WS4));
    while FLASH.acr().read().latency() != Latency::WS4 {}
    cortex_m::asm::delay(STEP);
    RCC.cfgr().modify(|w| w.set_hpre(Hpre::DIV1));
}

/// Tells the DACs in use how fast their bus is.
pub(super) fn tell_dacs() {
    for dac in [DAC1, DAC3, DAC4] {
        dac.mcr().modify(|w| w.set_hfsel(DAC_BUS));
    }
}

/// SYSCLK at its speed, the core and the buses at half of it.
fn half_speed() -> rcc::Config {
    const _: () = assert!(matches!(timing::PLL, (5, 68, 2)));
    let mut rcc = rcc::Config::new();
    rcc.hse = Some(Hse {
        freq: Hertz(timing::CRYSTAL_HZ),
        mode: HseMode::Oscillator,
    });
    // For the random number generator.
    rcc.hsi48 = Some(Hsi48Config::new());
    rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV5,
        mul: PllMul::MUL68,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    rcc.sys = Sysclk::PLL1_R;
    rcc.ahb_pre = AHBPrescaler::DIV2;
    rcc.boost = true;
    rcc.mux.adc12sel = mux::Adcsel::SYS;
    rcc.mux.adc345sel = mux::Adcsel::SYS;
    rcc.mux.usart2sel = mux::Uartsel::SYS;
    rcc
}
