//! The link to the host: USART2, which the board's debugger passes on as a serial port.
//! Both directions by DMA, no interrupt: a pass of the main loop looks how far they are.

use core::cell::UnsafeCell;
use embassy_stm32::pac::bdma::vals::{Dir, Size};
use embassy_stm32::pac::{DMA1, DMAMUX1, USART2};
use embassy_stm32::peripherals;
use embassy_stm32::usart::{self, RxDma, RxPin, TxDma, TxPin, Uart};
use embassy_stm32::{Peri, mode::Blocking};

/// Bits per second; every byte takes ten.
pub const BAUD: u32 = 921_600;
/// Bytes that may wait to be sent: 22 ms of the line.
const OUT: usize = 2048;
/// Bytes that may wait to be taken: 5.5 ms of the line.
const IN: usize = 512;
/// DMA channels, from 0.
const SEND: usize = 2;
const RECEIVE: usize = 3;

/// Memory that the DMA reads or writes.
struct Shared<const N: usize>(UnsafeCell<[u8; N]>);

// SAFETY: the one `Link` there is writes what the DMA is not reading, and reads single
// bytes of what it writes.
unsafe impl<const N: usize> Sync for Shared<N> {}

static OUTGOING: Shared<OUT> = Shared(UnsafeCell::new([0; OUT]));
static INCOMING: Shared<IN> = Shared(UnsafeCell::new([0; IN]));

/// The link. Positions count bytes for ever; modulo the buffer they are places in it.
#[derive(Debug)]
pub(super) struct Link {
    /// Bytes ever accepted.
    accepted: usize,
    /// Bytes ever sent, those of the running transfer not included.
    sent: usize,
    /// Bytes of the running transfer; 0 when none runs.
    running: usize,
    /// Place of the next byte to take.
    taken: usize,
}

impl Link {
    /// Starts both directions.
    pub(super) fn start(
        serial: Peri<'static, peripherals::USART2>,
        input: Peri<'static, impl RxPin<peripherals::USART2>>,
        output: Peri<'static, impl TxPin<peripherals::USART2>>,
        send: Peri<'static, peripherals::DMA1_CH3>,
        receive: Peri<'static, peripherals::DMA1_CH4>,
    ) -> Result<Self, usart::ConfigError> {
        let requests = (
            TxDma::<peripherals::USART2>::request(&*send),
            RxDma::<peripherals::USART2>::request(&*receive),
        );
        core::mem::forget((send, receive));
        let mut config = usart::Config::default();
        config.baudrate = BAUD;
        let driver: Uart<'static, Blocking> = Uart::new_blocking(serial, input, output, config)?;
        // The driver has set the pins, the rate and the clock; from here on it is the DMA's.
        core::mem::forget(driver);
        DMAMUX1.ccr(SEND).write(|w| w.set_dmareq_id(requests.0));
        DMAMUX1.ccr(RECEIVE).write(|w| w.set_dmareq_id(requests.1));
        DMA1.ch(SEND)
            .par()
            .write_value(USART2.tdr().as_ptr() as u32);
        let receiver = DMA1.ch(RECEIVE);
        receiver.par().write_value(USART2.rdr().as_ptr() as u32);
        receiver.mar().write_value(INCOMING.0.get() as u32);
        receiver.ndtr().write(|w| w.set_ndt(IN as u16));
        receiver.cr().write(|w| {
            w.set_dir(Dir::FROM_PERIPHERAL);
            w.set_circ(true);
            w.set_minc(true);
            w.set_psize(Size::BITS8);
            w.set_msize(Size::BITS8);
            w.set_en(true);
        });
        USART2.cr3().modify(|w| {
            w.set_dmat(true);
            w.set_dmar(true);
        });
        Ok(Self {
            accepted: 0,
            sent: 0,
            running: 0,
            taken: 0,
        })
    }

    /// Starts the next transfer when the last one is over.
    pub(super) fn pump(&mut self) {
        let channel = DMA1.ch(SEND);
        if self.running > 0 {
            if channel.ndtr().read().ndt() != 0 {
                return;
            }
            channel.cr().modify(|w| w.set_en(false));
            self.sent = self.sent.wrapping_add(self.running);
            self.running = 0;
        }
        let waiting = self.accepted.wrapping_sub(self.sent);
        if waiting == 0 {
            return;
        }
        let from = self.sent % OUT;
        self.running = waiting.min(OUT - from);
        channel
            .mar()
            .write_value(OUTGOING.0.get() as u32 + from as u32);
        channel.ndtr().write(|w| w.set_ndt(self.running as u16));
        channel.cr().write(|w| {
            w.set_dir(Dir::FROM_MEMORY);
            w.set_minc(true);
            w.set_psize(Size::BITS8);
            w.set_msize(Size::BITS8);
            w.set_en(true);
        });
    }

    /// Accepts a frame, or says that there is no room for the whole of it.
    pub(super) fn send(&mut self, frame: &[u8]) -> bool {
        self.pump();
        if frame.len() > OUT - self.accepted.wrapping_sub(self.sent) {
            return false;
        }
        for &byte in frame {
            let place = self.accepted % OUT;
            // SAFETY: the place is inside the buffer, and not among those that wait to be
            // sent, which are all that the DMA may be reading.
            unsafe {
                OUTGOING
                    .0
                    .get()
                    .cast::<u8>()
                    .add(place)
                    .write_volatile(byte);
            }
            self.accepted = self.accepted.wrapping_add(1);
        }
        // The DMA must find the bytes in memory.
        cortex_m::asm::dmb();
        self.pump();
        true
    }

    /// Takes bytes that have come.
    pub(super) fn receive(&mut self, bytes: &mut [u8]) -> usize {
        // After an overrun the receiver waits for its flag to be taken back.
        USART2.icr().write(|w| {
            w.set_ore(true);
            w.set_fe(true);
            w.set_ne(true);
            w.set_pe(true);
        });
        let left = usize::from(DMA1.ch(RECEIVE).ndtr().read().ndt());
        let end = (IN - left) % IN;
        let mut count = 0;
        for byte in bytes {
            if self.taken == end {
                break;
            }
            // SAFETY: the place is inside the buffer; volatile, because the DMA writes it.
            *byte = unsafe {
                INCOMING
                    .0
                    .get()
                    .cast::<u8>()
                    .add(self.taken % IN)
                    .read_volatile()
            };
            self.taken = (self.taken + 1) % IN;
            count += 1;
        }
        count
    }
}
