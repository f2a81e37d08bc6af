//! The microphones: ADC1 and ADC2, triggered together by TIM6, into rings by DMA.
//!
//! Each trigger makes one conversion; the converters' oversamplers add up eight to a
//! sample of 15 bits. No interrupt is taken for a sample: how many there are follows from
//! the clock and the DMA's place ([`ring::written`]), so that a lost one is counted and a
//! converter that stops is noticed.

use super::timing::{OVERSAMPLING, TICKS_PER_SAMPLE, TICKS_PER_TRIGGER};
use super::{clock, scaling};
use crate::board::Block;
use crate::boards::ring;
use core::cell::UnsafeCell;
use embassy_stm32::adc::{
    Adc, AdcChannel, AdcConfig, Dmacfg, Dmaen, Exten, RegularTrigger, Rovsm, RxDma, SampleTime,
    Trovs,
};
use embassy_stm32::pac::bdma::vals::{Dir, Pl, Size};
use embassy_stm32::pac::timer::vals::Mms;
use embassy_stm32::pac::{self, DMA1, DMAMUX1, TIM6};
use embassy_stm32::peripherals::{self, ADC1, ADC2};
use embassy_stm32::triggers::TIM6_TRGO;
use embassy_stm32::{Peri, rcc};

/// Length of each ring: 43 ms.
const RING: usize = 2048;

/// A ring that the DMA writes.
#[repr(align(4))]
struct Ring(UnsafeCell<[u16; RING]>);

// SAFETY: the CPU only reads it, one half-word at a time, while the DMA writes.
unsafe impl Sync for Ring {}

impl Ring {
    const fn new() -> Self {
        Self(UnsafeCell::new([0; RING]))
    }

    fn address(&self) -> *mut u16 {
        self.0.get().cast()
    }

    /// The sample of that number, if it has not been overwritten.
    #[inline]
    fn sample(&self, number: u64) -> u16 {
        let index = number as usize % RING;
        // SAFETY: the index is inside the ring; volatile, because the DMA writes it.
        unsafe { self.address().add(index).read_volatile() }
    }
}

static RINGS: [Ring; 2] = [Ring::new(), Ring::new()];

/// The converter or its DMA stands still.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stopped;

/// What the microphones need of the chip.
pub(super) struct Peripherals<M1, M2> {
    pub adc_1: Peri<'static, ADC1>,
    pub adc_2: Peri<'static, ADC2>,
    pub dma_1: Peri<'static, peripherals::DMA1_CH1>,
    pub dma_2: Peri<'static, peripherals::DMA1_CH2>,
    pub trigger: Peri<'static, peripherals::TIM6>,
    pub microphone_1: M1,
    pub microphone_2: M2,
}

/// The microphones, sampled since they were started.
#[derive(Debug)]
pub(super) struct Microphones {
    /// Ticks at which sampling began.
    started: u64,
    /// Number of the next sample to take.
    taken: u64,
    /// The second one is listened to.
    second: bool,
}

impl Microphones {
    /// Starts sampling both microphones.
    pub(super) fn start<M1: AdcChannel<ADC1>, M2: AdcChannel<ADC2>>(
        parts: Peripherals<M1, M2>,
    ) -> Self {
        let requests = (
            RxDma::<ADC1>::request(&*parts.dma_1),
            RxDma::<ADC2>::request(&*parts.dma_2),
        );
        let channels = (
            parts.microphone_1.degrade_adc().get_hw_channel(),
            parts.microphone_2.degrade_adc().get_hw_channel(),
        );
        // Calibrated and switched on by the driver, which is not given back.
        core::mem::forget(Adc::new(parts.adc_1, oversampled()));
        core::mem::forget(Adc::new(parts.adc_2, oversampled()));
        let signals = (
            RegularTrigger::<ADC1>::signal(&TIM6_TRGO),
            RegularTrigger::<ADC2>::signal(&TIM6_TRGO),
        );
        convert_on_trigger(pac::ADC1, channels.0, signals.0);
        convert_on_trigger(pac::ADC2, channels.1, signals.1);
        fill_ring(0, requests.0, pac::ADC1, &RINGS[0]);
        fill_ring(1, requests.1, pac::ADC2, &RINGS[1]);
        for adc in [pac::ADC1, pac::ADC2] {
            adc.cr().modify(|w| w.set_adstart(true));
        }

        rcc::enable_and_reset::<peripherals::TIM6>();
        core::mem::forget(parts.trigger);
        TIM6.arr()
            .write(|w| w.set_arr(TICKS_PER_TRIGGER as u16 - 1));
        TIM6.cr2().modify(|w| w.set_mms(Mms::UPDATE));
        let started = critical_section::with(|_| {
            TIM6.cr1().modify(|w| w.set_cen(true));
            clock::now()
        });
        Self {
            started,
            taken: 0,
            second: false,
        }
    }

    /// Samples written since the start.
    fn written(&self) -> Result<u64, Stopped> {
        let elapsed = clock::now() - self.started;
        let channel = usize::from(self.second);
        let left = usize::from(DMA1.ch(channel).ndtr().read().ndt());
        let place = (RING - left) % RING;
        ring::written(
            elapsed / u64::from(TICKS_PER_SAMPLE),
            place as u32,
            RING as u32,
        )
        .ok_or(Stopped)
    }

    /// Which microphone is taken from now on.
    pub(super) fn choose(&mut self, microphone: u8) {
        self.second = microphone == 1;
    }

    /// Takes the samples of the chosen microphone that there are; see
    /// [`Board::samples`](crate::board::Board::samples).
    pub(super) fn take(&mut self, block: &mut [f32]) -> Result<Block, Stopped> {
        let written = self.written()?;
        let window = ring::window(self.taken, written, RING as u32);
        let there = usize::try_from(written - window.from).unwrap_or(RING);
        let samples = block.len().min(there);
        let [first, second] = &RINGS;
        let chosen = if self.second { second } else { first };
        for (place, number) in block.iter_mut().zip(window.from..written) {
            *place = scaling::microphone(chosen.sample(number));
        }
        self.taken = window.from + samples as u64;
        Ok(Block {
            samples,
            missing: window.missing,
        })
    }

    /// Ticks at which sampling began.
    pub(super) fn started(&self) -> u64 {
        self.started
    }
}

/// One conversion a trigger, eight to a sample, nothing divided.
fn oversampled() -> AdcConfig {
    AdcConfig {
        // Ratio 2^(n + 1).
        oversampling_ratio: Some(OVERSAMPLING.trailing_zeros() as u8 - 1),
        oversampling_shift: Some(0),
        oversampling_mode: Some((Rovsm::CONTINUED, Trovs::TRIGGERED, true)),
        ..AdcConfig::default()
    }
}

/// One channel, converted at every edge of the trigger, handed to the DMA for ever.
fn convert_on_trigger(adc: pac::adc::Adc, channel: u8, signal: u8) {
    // 47.5 cycles of 40.8 MHz: 1.2 µs for the microphone's source to settle, and with the
    // conversion 60 of the 106 cycles between two triggers.
    let time = SampleTime::CYCLES47_5;
    if channel < 10 {
        adc.smpr().modify(|w| w.set_smp(channel.into(), time));
    } else {
        adc.smpr2()
            .modify(|w| w.set_smp(usize::from(channel) - 10, time));
    }
    adc.sqr1().write(|w| {
        w.set_l(0);
        w.set_sq(0, channel);
    });
    adc.cfgr().modify(|w| {
        w.set_cont(false);
        w.set_extsel(signal);
        w.set_exten(Exten::RISING_EDGE);
        w.set_dmacfg(Dmacfg::CIRCULAR);
        w.set_dmaen(Dmaen::ENABLE);
        // A sample nobody fetched is overwritten; the clock notices.
        w.set_ovrmod(pac::adc::vals::Ovrmod::OVERWRITE);
    });
}

/// Lets a DMA channel write the converter's samples round and round.
fn fill_ring(channel: usize, request: u8, adc: pac::adc::Adc, ring: &'static Ring) {
    DMAMUX1.ccr(channel).write(|w| w.set_dmareq_id(request));
    let dma = DMA1.ch(channel);
    dma.par().write_value(adc.dr().as_ptr() as u32);
    dma.mar().write_value(ring.address() as u32);
    dma.ndtr().write(|w| w.set_ndt(RING as u16));
    dma.cr().write(|w| {
        w.set_dir(Dir::FROM_PERIPHERAL);
        w.set_circ(true);
        w.set_minc(true);
        w.set_psize(Size::BITS16);
        w.set_msize(Size::BITS16);
        w.set_pl(Pl::VERY_HIGH);
        w.set_en(true);
    });
}
