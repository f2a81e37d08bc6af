//! The chip set up as this board: clock tree, interrupts, every part started.

use super::clock::{self, ClockInterrupt};
use super::link::Link;
use super::samples::{self, Microphones};
use super::settings_flash::SettingsFlash;
use super::tacho::Tacho;
use super::{bridges, clock_tree, injected, memory, outputs, random, supply};
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, InjectedTrigger};
use embassy_stm32::comp::{self, Comp, Hysteresis, InvertingInput};
use embassy_stm32::dac::{Dac, DacChannel, Value};
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{AfType, Flex, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::opamp::{OpAmp, OpAmpSpeed};
use embassy_stm32::pac;
use embassy_stm32::timer::complementary_pwm::{ComplementaryPwm, ComplementaryPwmPin};
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::timer::{BkIn1, BreakInputPin};
use embassy_stm32::triggers::TIM1_TRGO2;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Peri, bind_interrupts, peripherals};

use crate::board::{ResetCause, WATCHDOG_US};
use crate::current_loop::MainSide;
use crate::parts::LightPins;
use rarma_box::guard::KEPT_BYTES;

macro_rules! pin_set {
    (; $($name:ident: $pin:ident, $function:literal, $connector:literal, $signal:literal;)*) => {
        /// The board's pins by what they are for.
        struct Pins { $($name: Peri<'static, peripherals::$pin>,)* }
    };
}
with_every_pin!(pin_set);

macro_rules! taken {
    ($chip:ident; $($name:ident: $pin:ident, $function:literal, $connector:literal, $signal:literal;)*) => {
        Pins { $($name: $chip.$pin,)* }
    };
}

bind_interrupts!(struct Interrupts {
    PVD_PVM => supply::SupplyInterrupt;
    TIM2 => ClockInterrupt;
    ADC3 => bridges::PeriodInterrupt;
    COMP1_2_3 => comp::InterruptHandler<peripherals::COMP1>;
    COMP4_5_6 => comp::InterruptHandler<peripherals::COMP4>, comp::InterruptHandler<peripherals::COMP5>;
    COMP7 => comp::InterruptHandler<peripherals::COMP7>;
});

/// OPAMP4's output inside the chip, a channel of ADC5 (reference manual RM0440, 21.4.11).
const OPAMP4_CHANNEL: u8 = 5;

/// The board.
#[allow(missing_debug_implementations)] // the HAL's drivers have none
pub struct Nucleo {
    pub(super) microphones: Microphones,
    pub(super) coils: MainSide,
    pub(super) tacho: Tacho,
    pub(super) link: Link,
    pub(super) flash: SettingsFlash,
    pub(super) watchdog: IndependentWatchdog<'static, peripherals::IWDG>,
    pub(super) enable: Input<'static>,
    pub(super) leds: LightPins<Output<'static>, Output<'static>, Output<'static>>,
    pub(super) reset_cause: ResetCause,
    pub(super) kept: [u8; KEPT_BYTES],
}

impl Nucleo {
    /// Starts the clock tree and every part of the board, all outputs off. To be called
    /// once.
    ///
    /// # Panics
    /// When called twice, or when the board's numbers do not fit the chip.
    #[inline(never)]
    pub fn set_up() -> Self {
        let (reset_cause, kept) = past();
        // On the slow oscillator at first: see `clock_tree`.
        let mut chip = embassy_stm32::init(embassy_stm32::Config::default());
        clock_tree::start(&mut chip.RCC);
        memory::start();
        let pins = with_every_pin!(taken, chip);
        let mut watchdog = IndependentWatchdog::new(chip.IWDG, WATCHDOG_US as u32);
        watchdog.unleash();
        clock::start(chip.TIM2);
        random::start();

        let mut valve = DacChannel::new_blocking(chip.DAC1, pins.valve);
        valve.set(Value::Bit12Right(0));
        core::mem::forget(valve);
        core::mem::forget(Output::new(pins.power_stage, Level::Low, Speed::Low));
        // The pin breaks the timer, and is read as well: high is a closed chain.
        let function = BreakInputPin::<peripherals::TIM1, BkIn1>::af_num(&*pins.emergency_stop);
        let mut stop = Flex::new(pins.emergency_stop);
        stop.set_as_af_unchecked(function, AfType::input(Pull::Down));
        core::mem::forget(stop);

        // Thresholds of the comparators, inside the chip.
        let mut thresholds = Dac::<embassy_stm32::mode::Blocking>::new_internal(chip.DAC3);
        thresholds
            .ch1()
            .set(Value::Bit12Right(bridges::trip_code()));
        thresholds
            .ch2()
            .set(Value::Bit12Right(bridges::trip_code()));
        core::mem::forget(thresholds);
        let mut thresholds = Dac::<embassy_stm32::mode::Blocking>::new_internal(chip.DAC4);
        thresholds
            .ch1()
            .set(Value::Bit12Right(bridges::trip_code()));
        core::mem::forget(thresholds);
        clock_tree::tell_dacs();

        let (mut x1, mut x2) = (pins.current_x1, pins.current_x2);
        let (mut y1, mut y2) = (pins.current_y1, pins.current_y2);
        core::mem::forget(Comp::new(chip.COMP1, x1.reborrow(), Interrupts, trips()));
        core::mem::forget(Comp::new(chip.COMP4, x2.reborrow(), Interrupts, trips()));
        core::mem::forget(Comp::new(chip.COMP5, y1.reborrow(), Interrupts, trips()));
        core::mem::forget(Comp::new(chip.COMP7, y2.reborrow(), Interrupts, trips()));

        let mut follower = OpAmp::new(chip.OPAMP4, OpAmpSpeed::HighSpeed);
        core::mem::forget(follower.buffer_int(pins.supply));
        core::mem::forget(follower);
        core::mem::forget(Adc::new(chip.ADC3, AdcConfig::default()));
        core::mem::forget(Adc::new(chip.ADC4, AdcConfig::default()));
        core::mem::forget(Adc::new(chip.ADC5, AdcConfig::default()));
        injected::start(
            pac::ADC3,
            &[
                AdcChannel::<peripherals::ADC3>::degrade_adc(x1).get_hw_channel(),
                AdcChannel::<peripherals::ADC3>::degrade_adc(x2).get_hw_channel(),
                AdcChannel::<peripherals::ADC3>::degrade_adc(y1).get_hw_channel(),
            ],
            InjectedTrigger::<peripherals::ADC3>::signal(&TIM1_TRGO2),
        );
        injected::start(
            pac::ADC4,
            &[
                AdcChannel::<peripherals::ADC4>::degrade_adc(y2).get_hw_channel(),
                AdcChannel::<peripherals::ADC4>::degrade_adc(pins.gap_x).get_hw_channel(),
                AdcChannel::<peripherals::ADC4>::degrade_adc(pins.gap_y).get_hw_channel(),
            ],
            InjectedTrigger::<peripherals::ADC4>::signal(&TIM1_TRGO2),
        );
        injected::start(
            pac::ADC5,
            &[
                AdcChannel::<peripherals::ADC5>::degrade_adc(pins.pressure).get_hw_channel(),
                AdcChannel::<peripherals::ADC5>::degrade_adc(pins.gauge).get_hw_channel(),
                OPAMP4_CHANNEL,
            ],
            InjectedTrigger::<peripherals::ADC5>::signal(&TIM1_TRGO2),
        );

        let push_pull = OutputType::PushPull;
        bridges::start(ComplementaryPwm::new(
            chip.TIM1,
            Some(PwmPin::new(pins.coil_x1_high, push_pull)),
            Some(ComplementaryPwmPin::new(pins.coil_x1_low, push_pull)),
            Some(PwmPin::new(pins.coil_x2_high, push_pull)),
            Some(ComplementaryPwmPin::new(pins.coil_x2_low, push_pull)),
            Some(PwmPin::new(pins.coil_y1_high, push_pull)),
            Some(ComplementaryPwmPin::new(pins.coil_y1_low, push_pull)),
            Some(PwmPin::new(pins.coil_y2_high, push_pull)),
            Some(ComplementaryPwmPin::new(pins.coil_y2_low, push_pull)),
            bridges::RATE.0,
            bridges::RATE.1,
        ));

        let link = Link::start(
            chip.USART2,
            pins.link_in,
            pins.link_out,
            chip.DMA1_CH3,
            chip.DMA1_CH4,
        );
        let Ok(link) = link else {
            panic!("the link's rate cannot be made from this clock");
        };
        let tacho = Tacho::start(pins.tacho, chip.DMA1_CH5);
        let microphones = Microphones::start(samples::Peripherals {
            adc_1: chip.ADC1,
            adc_2: chip.ADC2,
            dma_1: chip.DMA1_CH1,
            dma_2: chip.DMA1_CH2,
            trigger: chip.TIM6,
            microphone_1: pins.microphone_1,
            microphone_2: pins.microphone_2,
        });
        supply::start();
        clock::watch_crystal();
        Self {
            microphones,
            coils: MainSide::default(),
            tacho,
            link,
            flash: SettingsFlash(Flash::new_blocking(chip.FLASH)),
            watchdog,
            enable: Input::new(pins.enable, Pull::Down),
            leds: LightPins::new(
                Output::new(pins.led_alive, Level::Low, Speed::Low),
                Output::new(pins.led_energised, Level::Low, Speed::Low),
                Output::new(pins.led_warning, Level::Low, Speed::Low),
            ),
            reset_cause,
            kept,
        }
    }
}

impl Nucleo {
    /// Ends the start, once: what runs without waiting is copied into the lower part of the start's stack,
    /// which is read-only from here on, and the current loop runs.
    pub fn start_loop(&mut self) {
        memory::copy_program();
        bridges::start_loop();
    }
}

/// Why the chip was reset, and what was kept across it. Clears the chip's flags.
fn past() -> (ResetCause, [u8; KEPT_BYTES]) {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    let (marked, kept) = outputs::kept();
    let cause = if flags.borrstf() {
        // The same flag for both: memory that outlived it makes it a brown-out.
        if marked {
            ResetCause::BrownOut
        } else {
            ResetCause::PowerOn
        }
    } else if flags.iwdgrstf() {
        ResetCause::Watchdog
    } else if flags.sftrstf() {
        ResetCause::Software
    } else {
        ResetCause::Pin
    };
    if !marked {
        outputs::keep(&[0; KEPT_BYTES]);
    }
    (cause, kept)
}

/// Comparators against the DAC inside the chip, output high when the current is beyond it.
fn trips() -> comp::Config {
    let mut config = comp::Config::default();
    config.inverting_input = InvertingInput::Dac1;
    config.hysteresis = Hysteresis::Hyst20M;
    config
}
