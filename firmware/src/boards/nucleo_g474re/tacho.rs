//! The tacho: TIM2 captures its counter at every rising edge, the DMA keeps the captures.

use super::{clock, timing};
use crate::board::Pulse;
use core::cell::UnsafeCell;
use embassy_stm32::Peri;
use embassy_stm32::gpio::Pull;
use embassy_stm32::pac::bdma::vals::{Dir, Size};
use embassy_stm32::pac::timer::vals::{CcmrInputCcs, FilterValue};
use embassy_stm32::pac::{DMA1, DMAMUX1, TIM2};
use embassy_stm32::peripherals;
use embassy_stm32::timer::input_capture::CapturePin;
use embassy_stm32::timer::{Ch3, Dma, TimerPin};

/// Captures that are kept: more in one millisecond is no spindle.
const RING: usize = 32;
/// The DMA's channel, from 0.
const CHANNEL: usize = 4;
/// The capture's channel, from 0.
const CAPTURE: usize = 2;

/// Captures as the DMA writes them.
struct Ring(UnsafeCell<[u32; RING]>);

// SAFETY: the CPU only reads it, one word at a time, while the DMA writes.
unsafe impl Sync for Ring {}

static RING_OF_CAPTURES: Ring = Ring(UnsafeCell::new([0; RING]));

/// The tacho.
#[derive(Debug)]
pub(super) struct Tacho {
    taken: usize,
}

impl Tacho {
    /// Starts capturing; the clock runs already.
    pub(super) fn start(
        pin: Peri<'static, impl TimerPin<peripherals::TIM2, Ch3>>,
        dma: Peri<'static, peripherals::DMA1_CH5>,
    ) -> Self {
        let request = Dma::<peripherals::TIM2, Ch3>::request(&*dma);
        core::mem::forget(dma);
        core::mem::forget(CapturePin::new(pin, Pull::Down));
        DMAMUX1.ccr(CHANNEL).write(|w| w.set_dmareq_id(request));
        let channel = DMA1.ch(CHANNEL);
        channel.par().write_value(TIM2.ccr(CAPTURE).as_ptr() as u32);
        channel.mar().write_value(RING_OF_CAPTURES.0.get() as u32);
        channel.ndtr().write(|w| w.set_ndt(RING as u16));
        channel.cr().write(|w| {
            w.set_dir(Dir::FROM_PERIPHERAL);
            w.set_circ(true);
            w.set_minc(true);
            w.set_psize(Size::BITS32);
            w.set_msize(Size::BITS32);
            w.set_en(true);
        });
        TIM2.ccmr_input(CAPTURE / 2).modify(|w| {
            w.set_ccs(CAPTURE % 2, CcmrInputCcs::TI4);
            // An edge counts after eight ticks at the new level: 50 ns.
            w.set_icf(CAPTURE % 2, FilterValue::FCK_INT_N8);
        });
        TIM2.dier().modify(|w| w.set_ccde(CAPTURE, true));
        TIM2.ccer().modify(|w| w.set_cce(CAPTURE, true));
        Self { taken: 0 }
    }

    /// The oldest pulse not taken yet; `started` is when sampling began.
    pub(super) fn pulse(&mut self, started: u64) -> Option<Pulse> {
        let left = usize::from(DMA1.ch(CHANNEL).ndtr().read().ndt());
        if self.taken == (RING - left) % RING {
            return None;
        }
        // SAFETY: the index is inside the ring; volatile, because the DMA writes it.
        let capture = unsafe {
            RING_OF_CAPTURES
                .0
                .get()
                .cast::<u32>()
                .add(self.taken % RING)
                .read_volatile()
        };
        self.taken = (self.taken + 1) % RING;
        let moment = timing::captured(capture, clock::now());
        let (sample, before) = timing::sample_after(started, moment);
        Some(Pulse { sample, before })
    }
}
