//! The board's verbs: everything but the current loop's interrupt.

use super::chip::Nucleo;
use super::outputs::{self, POWER_STAGE};
use super::samples::Stopped;
use super::settings_flash::{self, SettingsFlash};
use super::timing::{PWM_HZ, SAMPLE_HZ, TICK_HZ};
use super::{bridges, clock, injected, memory, random, scaling, supply};
use crate::board::{
    Block, Board, BoardError, BoardErrorKind, BoxBoard, Clock, CoilOrder, CoilReport, Contacts,
    DacCode, Emergency, FlashSeen, Lights, Origin, Pulse, ResetCause, SensorCodes,
};
use core::ops::Range;
use embassy_stm32::pac::{ADC4, ADC5, DAC1, GPIOA, GPIOC};
use rarma_box::guard::KEPT_BYTES;
use rarma_rigs::cers::Source;

/// Pin of the emergency-stop chain: PA6.
const STOP_CHAIN: usize = 6;
/// Ticks that a pin may take from its order to its input register, 1 µs: one of the slowest kind
/// takes 25 ns at 50 pF, the input another two ticks. To look once, at once, is too soon.
const PIN_TICKS: u64 = TICK_HZ as u64 / 1_000_000;
/// Ticks of the longest sleep, 1 ms less the time to wake.
const SLEEP: u64 = TICK_HZ as u64 / 1000 - 2_000;

/// What the board could not do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NucleoError {
    /// A converter, or what carries its codes, stands still.
    Converter,
    /// The gate does not close.
    Gate,
    /// There is no room for the frame.
    Busy,
}

impl BoardError for NucleoError {
    fn kind(&self) -> BoardErrorKind {
        match self {
            Self::Converter => BoardErrorKind::Converter,
            Self::Gate => BoardErrorKind::Refused,
            Self::Busy => BoardErrorKind::Busy,
        }
    }
}

impl From<Stopped> for NucleoError {
    fn from(_: Stopped) -> Self {
        Self::Converter
    }
}

impl Clock for Nucleo {
    fn now_us(&mut self) -> u64 {
        clock::now_us()
    }
}

impl Board for Nucleo {
    type Error = NucleoError;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, NucleoError> {
        Ok(self.microphones.take(block)?)
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), NucleoError> {
        if self.link.send(frame) {
            Ok(())
        } else {
            Err(NucleoError::Busy)
        }
    }
}

impl Emergency for Nucleo {
    fn drop_outputs(&mut self) {
        outputs::drop_all();
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        outputs::keep(bytes);
    }
}

impl BoxBoard for Nucleo {
    type Flash = SettingsFlash;

    const NAME: &'static str = "nucleo-g474re";
    const SAMPLE_RATE_HZ: f64 = SAMPLE_HZ as f64;
    const LOOP_RATE_HZ: f64 = PWM_HZ as f64;

    fn wait(&mut self) {
        self.link.pump();
        clock::sleep_until(clock::now() + SLEEP);
    }

    fn listen_to(&mut self, microphone: u8) {
        self.microphones.choose(microphone);
    }

    fn pulse(&mut self) -> Option<Pulse> {
        self.tacho.pulse(self.microphones.started())
    }

    fn coils(&mut self, order: &CoilOrder) -> CoilReport {
        bridges::exchange(&mut self.coils, order)
    }

    fn excite(&mut self, signal: &Source) {
        bridges::excite(signal);
    }

    fn sensors(&mut self) -> Result<SensorCodes, NucleoError> {
        // Three channels are converted with every PWM period, so that there is always a
        // fresh set, unless the trigger or the converter has stopped.
        if !injected::take(ADC5) {
            return Err(NucleoError::Converter);
        }
        let gap = |rank| scaling::left_aligned(ADC4.jdr(rank).read().0);
        let slow = |rank| scaling::left_aligned(ADC5.jdr(rank).read().0);
        Ok(SensorCodes {
            gap: [gap(1), gap(2)],
            pressure: slow(0),
            gauge: slow(1),
            supply: slow(2),
        })
    }

    fn valve(&mut self, code: DacCode) -> Result<(), NucleoError> {
        let code = if bridges::gate() {
            scaling::dac_12_bits(code)
        } else {
            0
        };
        DAC1.dhr12r(0).write(|w| w.set_dhr(code));
        Ok(())
    }

    fn contacts(&mut self) -> Contacts {
        Contacts {
            enable: self.enable.is_high(),
            stop_chain: stop_chain(),
        }
    }

    fn energise(&mut self) -> Result<(), NucleoError> {
        if !stop_chain() || supply::is_low() {
            return Err(NucleoError::Gate);
        }
        GPIOC.bsrr().write(|w| w.set_bs(POWER_STAGE, true));
        let last = clock::now() + PIN_TICKS;
        while !power_stage() {
            if clock::now() > last {
                self.drop_outputs();
                return Err(NucleoError::Gate);
            }
        }
        bridges::set_gate(true);
        Ok(())
    }

    fn energised(&mut self) -> bool {
        bridges::gate() && power_stage() && stop_chain()
    }

    fn feed_watchdog(&mut self) {
        self.watchdog.pet();
    }

    fn reset_cause(&mut self) -> ResetCause {
        self.reset_cause
    }

    fn kept(&mut self) -> [u8; KEPT_BYTES] {
        self.kept
    }

    fn brown_out_mv(&mut self) -> Option<u16> {
        Some(memory::brown_out_mv())
    }

    fn entropy(&mut self) -> u32 {
        random::number()
    }

    fn flash(&mut self) -> (&mut Self::Flash, Range<u32>) {
        (&mut self.flash, settings_range())
    }

    fn flash_seen(&mut self) -> FlashSeen {
        settings_flash::seen()
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, NucleoError> {
        Ok(self.link.receive(bytes))
    }

    /// The debugger's serial port is the only one.
    fn origin(&mut self) -> Origin {
        Origin::OwnPort
    }

    fn lights(&mut self, lights: Lights) {
        self.leds.show(lights);
    }
}

/// The emergency-stop chain is closed.
fn stop_chain() -> bool {
    GPIOA.idr().read().idr(STOP_CHAIN) == embassy_stm32::pac::gpio::vals::Idr::HIGH
}

/// The power stage's enable, read back at its pin.
fn power_stage() -> bool {
    GPIOC.idr().read().idr(POWER_STAGE) == embassy_stm32::pac::gpio::vals::Idr::HIGH
}

/// Addresses of the settings, from the start of the flash: the memory map's.
fn settings_range() -> Range<u32> {
    unsafe extern "C" {
        static _settings_start: u8;
        static _settings_end: u8;
    }
    (&raw const _settings_start) as u32..(&raw const _settings_end) as u32
}
