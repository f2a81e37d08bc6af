//! The microphone: a state machine clocks it and takes its bits, a DMA channel writes them round and round.
//!
//! No interrupt is taken for a sample: how many there are follows from the clock and the DMA's
//! place ([`ring::written`]), so that a lost one is counted and a clock that stops is noticed.

use super::basics::{Irqs, now_us};
use super::i2s;
use crate::board::Block;
use crate::boards::ring;
use core::cell::UnsafeCell;
use embassy_rp::Peri;
use embassy_rp::pac::DMA;
use embassy_rp::pac::dma::regs::{ChTransCount, CtrlTrig};
use embassy_rp::pac::dma::vals::{DataSize, TransCountMode};
use embassy_rp::peripherals::{DMA_CH0, PIN_10, PIN_11, PIN_12, PIO0};
use embassy_rp::pio::{Config, Direction, FifoJoin, Pio, ShiftConfig, ShiftDirection};

/// Length of the ring: 171 ms, the longest that the DMA wraps by itself. Four times as long as the erase of
/// a sector of flash takes as a rule, in which nobody takes samples.
const RING: usize = 8192;
/// Its bytes, as a power of two.
const RING_BITS: u8 = 15;
const _: () = assert!(RING * size_of::<u32>() == 1 << RING_BITS);
/// The channel.
const CHANNEL: usize = 0;

/// The ring. The DMA wraps at addresses that are a multiple of its length.
#[repr(align(32768))]
struct Ring(UnsafeCell<[u32; RING]>);

// SAFETY: the CPU only reads it, one word at a time, while the DMA writes.
unsafe impl Sync for Ring {}

static WORDS: Ring = Ring(UnsafeCell::new([0; RING]));

/// What the microphone needs of the chip.
pub(super) struct Parts {
    pub pio: Peri<'static, PIO0>,
    pub dma: Peri<'static, DMA_CH0>,
    pub sck: Peri<'static, PIN_10>,
    pub ws: Peri<'static, PIN_11>,
    pub sd: Peri<'static, PIN_12>,
}

/// The clock or the DMA stands still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stopped;

/// The microphone, sampled since it was started.
#[derive(Debug)]
pub(super) struct Microphone {
    started_us: u64,
    /// Number of the next sample to take.
    taken: u64,
}

impl Microphone {
    /// Starts the clock, and waits until the microphone gives sound.
    pub(super) fn start(parts: Parts) -> Self {
        let Pio {
            mut common,
            mut sm0,
            irq_flags,
            ..
        } = Pio::new(parts.pio, Irqs);
        let loaded = common.load_program(&i2s::program());
        let sck = common.make_pio_pin(parts.sck);
        let ws = common.make_pio_pin(parts.ws);
        let sd = common.make_pio_pin(parts.sd);
        let mut config = Config::default();
        config.use_program(&loaded, &[&sck, &ws]);
        config.set_in_pins(&[&sd]);
        config.clock_divider = (i2s::DIVIDER_256 as u16).into();
        config.clock_divider /= 256;
        config.fifo_join = FifoJoin::RxOnly;
        config.shift_in = ShiftConfig {
            threshold: i2s::SAMPLE_BITS as u8,
            direction: ShiftDirection::Left,
            auto_fill: true,
        };
        sm0.set_config(&config);
        sm0.set_pin_dirs(Direction::Out, &[&sck, &ws]);
        sm0.set_pin_dirs(Direction::In, &[&sd]);
        let (from, request) = (sm0.rx_fifo_ptr() as u32, sm0.rx_treq());
        fill_ring(from, request);
        sm0.set_enable(true);
        let started_us = now_us();
        // They run for ever: dropped, they would stop the machine and let the pins go.
        core::mem::forget((common, sm0, irq_flags, parts.dma));
        while now_us() - started_us < i2s::START_UP_US {}
        let mut this = Self {
            started_us,
            taken: 0,
        };
        // What came until now is no sound.
        this.taken = this.written().unwrap_or(0);
        this
    }

    /// Samples written since the start.
    fn written(&self) -> Result<u64, Stopped> {
        let expected = i2s::expected(now_us() - self.started_us);
        let bytes = DMA.ch(CHANNEL).write_addr().read() - WORDS.0.get() as u32;
        let place = bytes as usize / size_of::<u32>() % RING;
        ring::written(expected, place as u32, RING as u32).ok_or(Stopped)
    }

    /// Takes the samples that there are; see [`Board::samples`](crate::board::Board::samples).
    pub(super) fn take(&mut self, block: &mut [f32]) -> Result<Block, Stopped> {
        let written = self.written()?;
        let window = ring::window(self.taken, written, RING as u32);
        let there = usize::try_from(written - window.from).unwrap_or(RING);
        let samples = block.len().min(there);
        for (place, number) in block.iter_mut().zip(window.from..written) {
            let index = number as usize % RING;
            // SAFETY: the index is inside the ring; volatile, because the DMA writes it.
            let word = unsafe { WORDS.0.get().cast::<u32>().add(index).read_volatile() };
            *place = i2s::sample(word);
        }
        self.taken = window.from + samples as u64;
        Ok(Block {
            samples,
            missing: window.missing,
        })
    }
}

/// Lets the channel write what the state machine pushes round and round, without an end.
fn fill_ring(from: u32, request: embassy_rp::pac::dma::vals::TreqSel) {
    let channel = DMA.ch(CHANNEL);
    channel.read_addr().write_value(from);
    channel.write_addr().write_value(WORDS.0.get() as u32);
    let mut count = ChTransCount(0);
    count.set_count(1);
    count.set_mode(TransCountMode::ENDLESS);
    channel.trans_count().write_value(count);
    let mut control = CtrlTrig(0);
    control.set_en(true);
    control.set_high_priority(true);
    control.set_data_size(DataSize::SIZE_WORD);
    control.set_incr_write(true);
    control.set_ring_sel(true);
    control.set_ring_size(RING_BITS);
    control.set_chain_to(CHANNEL as u8);
    control.set_treq_sel(request);
    channel.ctrl_trig().write_value(control);
}
