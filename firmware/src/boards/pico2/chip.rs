//! The chip, put together as a board that listens.

use super::basics::{Irqs, feed_watchdog, now_us};
use super::link;
use super::microphone::{self, Microphone};
use super::settings_flash::{self, SettingsFlash};
use crate::board::{
    Block, Board, BoardError, BoardErrorKind, Clock, Emergency, Lights, Listener, ResetCause,
    WATCHDOG_US,
};
use crate::parts::OneLight;
use core::ops::Range;
use core::pin::Pin;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use embassy_rp::flash::Flash;
use embassy_rp::gpio::{Level, Output};
use embassy_rp::pac::{POWMAN, PSM, WATCHDOG};
use embassy_rp::peripherals::{PIO0, TRNG, USB};
use embassy_rp::trng::Trng;
use embassy_rp::usb::Driver;
use embassy_rp::{config, trng};
use rarma_box::guard::KEPT_BYTES;

/// Passes of the main loop a second at least: what [`Listener::wait`] waits for at most, Hz.
const PASSES_HZ: u32 = 1000;

/// Register of the always-on domain, behind the kept bytes, that says that the watchdog was started by this
/// program: the ROM resets by the watchdog, too, when it has been given a new image.
const OURS: usize = KEPT_BYTES / 4;
const OURS_IS: u32 = 0x7261_726D;

/// A reset by the watchdog takes everything with it but the oscillators.
fn start_watchdog() {
    PSM.wdsel().write(|w| {
        w.0 = 0x01FF_FFFF;
        w.set_rosc(false);
        w.set_xosc(false);
    });
    feed_watchdog(WATCHDOG_US);
    WATCHDOG.ctrl().modify(|w| w.set_enable(true));
    POWMAN.scratch(OURS).write_value(OURS_IS);
}

/// Resets the chip, which then says [`ResetCause::Software`].
pub fn reset() -> ! {
    WATCHDOG.ctrl().modify(|w| w.set_trigger(true));
    loop {
        cortex_m::asm::nop();
    }
}

/// Why the chip has started. To be asked once, before the watchdog is started.
fn why_started() -> ResetCause {
    let ours = POWMAN.scratch(OURS).read() == OURS_IS;
    POWMAN.scratch(OURS).write_value(0);
    let (watchdog, chip) = (WATCHDOG.reason().read(), POWMAN.chip_reset().read());
    if ours && watchdog.timer() {
        ResetCause::Watchdog
    } else if ours && watchdog.force() {
        ResetCause::Software
    } else if chip.had_bor() {
        ResetCause::BrownOut
    } else if chip.had_por() {
        ResetCause::PowerOn
    } else {
        ResetCause::Pin
    }
}

/// For handlers: there is nothing here to switch off.
#[derive(Debug)]
pub struct LastResort;

impl Clock for LastResort {
    fn now_us(&mut self) -> u64 {
        now_us()
    }
}

impl Emergency for LastResort {
    fn drop_outputs(&mut self) {}

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        for (n, word) in bytes.as_chunks().0.iter().enumerate() {
            POWMAN.scratch(n).write_value(u32::from_le_bytes(*word));
        }
    }
}

/// What of this board fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stalled {
    /// The microphone's clock or the DMA stands still.
    Microphone,
    /// The link has no room.
    Link,
}

impl BoardError for Stalled {
    fn kind(&self) -> BoardErrorKind {
        match self {
            Self::Microphone => BoardErrorKind::Converter,
            Self::Link => BoardErrorKind::Busy,
        }
    }
}

/// The board. `'a` is the life of the future that serves its USB.
#[allow(missing_debug_implementations)] // the HAL's drivers have none
pub struct Pico2<'a> {
    microphone: Microphone,
    /// None until the caller has it.
    usb: Option<Pin<&'a mut dyn Future<Output = ()>>>,
    flash: SettingsFlash,
    random: Trng<'static, TRNG>,
    light: OneLight<Output<'static>>,
    cause: ResetCause,
}

impl<'a> Pico2<'a> {
    /// Starts clocks and microphone. The driver goes into [`link::serve`], whose future goes into
    /// [`Self::start`].
    pub fn prepare() -> (Self, Driver<'static, USB>) {
        // A stack that grows into the static memory is a fault, and writes over nothing.
        let _ = embassy_rp::install_core0_stack_guard();
        let parts = embassy_rp::init(config::Config::default());
        let cause = why_started();
        wake_at_passes();
        let microphone = Microphone::start(microphone::Parts {
            pio: parts.PIO0,
            dma: parts.DMA_CH0,
            sck: parts.PIN_10,
            ws: parts.PIN_11,
            sd: parts.PIN_12,
        });
        let this = Self {
            microphone,
            usb: None,
            flash: SettingsFlash(Flash::new_blocking(parts.FLASH)),
            random: Trng::new(parts.TRNG, Irqs, trng::Config::default()),
            light: OneLight(Output::new(parts.PIN_25, Level::Low)),
            cause,
        };
        (this, Driver::new(parts.USB, Irqs))
    }

    /// From here on the main loop serves USB, and the watchdog runs.
    pub fn start(&mut self, usb: Pin<&'a mut dyn Future<Output = ()>>) {
        self.usb = Some(usb);
        start_watchdog();
    }
}

/// An interrupt that ends a wait.
fn wake_at_passes() {
    // SAFETY: nothing else here uses the counter.
    let mut counter: SYST = unsafe { core::mem::transmute(()) };
    counter.set_clock_source(SystClkSource::Core);
    counter.set_reload(super::i2s::TICK_HZ / PASSES_HZ - 1);
    counter.clear_current();
    counter.enable_counter();
    counter.enable_interrupt();
}

impl Clock for Pico2<'_> {
    fn now_us(&mut self) -> u64 {
        now_us()
    }
}

impl Board for Pico2<'_> {
    type Error = Stalled;

    fn samples(&mut self, block: &mut [f32]) -> Result<Block, Stalled> {
        self.microphone.take(block).map_err(|_| Stalled::Microphone)
    }

    fn send(&mut self, frame: &[u8]) -> Result<(), Stalled> {
        link::send(frame, now_us())
            .then_some(())
            .ok_or(Stalled::Link)
    }
}

impl Listener for Pico2<'_> {
    type Flash = SettingsFlash;

    const NAME: &'static str = "pico2";
    const SAMPLE_RATE_HZ: f64 = super::i2s::SAMPLE_HZ as f64;

    /// An interrupt between the look at USB and the wait ends the wait: the core has marked its event.
    fn wait(&mut self) {
        if let Some(usb) = &mut self.usb {
            link::poll(usb.as_mut());
        }
        cortex_m::asm::wfe();
    }

    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Stalled> {
        Ok(link::receive(bytes))
    }

    fn flash(&mut self) -> (&mut SettingsFlash, Range<u32>) {
        (&mut self.flash, settings_flash::RANGE)
    }

    /// Of the chip's generator of random numbers.
    fn entropy(&mut self) -> u32 {
        self.random.blocking_next_u32()
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        LastResort.keep(bytes);
    }

    fn kept(&mut self) -> [u8; KEPT_BYTES] {
        let mut bytes = [0; KEPT_BYTES];
        for (n, word) in bytes.as_chunks_mut().0.iter_mut().enumerate() {
            *word = POWMAN.scratch(n).read().to_le_bytes();
        }
        bytes
    }

    fn reset_cause(&mut self) -> ResetCause {
        self.cause
    }

    fn feed_watchdog(&mut self) {
        feed_watchdog(WATCHDOG_US);
    }

    fn lights(&mut self, lights: Lights) {
        self.light.show(lights);
    }
}
