//! Samples of any driver, asked for at a fixed rate.

use super::PartFailed;
use crate::board::{Block, Clock};
use embedded_hal::delay::DelayNs;

/// Asks a driver for a sample at n/rate from the first read on, and tells how many it came too late for.
///
/// For converters and accelerometers on a bus, up to some kHz: what the processor does in between delays a
/// sample by up to its own length. A faster one needs DMA, or the sensor's own memory.
#[derive(Debug)]
pub struct Polled<C, D, F> {
    clock: C,
    delay: D,
    read: F,
    rate_hz: u32,
    start_us: Option<u64>,
    next: u64,
    failed: bool,
}

impl<C: Clock, D: DelayNs, E, F: FnMut() -> Result<f32, E>> Polled<C, D, F> {
    /// `read` gives a sample, full scale ±1, in far less than a period; `rate_hz` is 1 to 1 000 000.
    pub fn new(rate_hz: u32, clock: C, delay: D, read: F) -> Self {
        Self {
            clock,
            delay,
            read,
            rate_hz: rate_hz.clamp(1, 1_000_000),
            start_us: None,
            next: 0,
            failed: false,
        }
    }

    /// How long the sample is over its time by now, µs; below 0 it is still to come.
    fn late_us(&mut self) -> i64 {
        let now_us = self.clock.now_us();
        let start_us = *self.start_us.get_or_insert(now_us);
        let due_us = start_us + self.next * 1_000_000 / u64::from(self.rate_hz);
        now_us as i64 - due_us as i64
    }

    /// Waits for a sample and gives it, one alone, so that the work on it is done before the next is due;
    /// see [`Board::samples`](crate::board::Board::samples).
    ///
    /// # Errors
    /// The driver has failed, now or before: [`PartFailed::Converter`].
    pub fn samples(&mut self, block: &mut [f32]) -> Result<Block, PartFailed> {
        let Some(place) = block.first_mut() else {
            return Ok(Block {
                samples: 0,
                missing: 0,
            });
        };
        let late_us = self.late_us();
        // Whole periods that have gone by without a sample.
        let missing = late_us.max(0) as u64 * u64::from(self.rate_hz) / 1_000_000;
        self.next += missing;
        if let Ok(early_us) = u32::try_from(-late_us) {
            self.delay.delay_us(early_us);
        }
        if !self.failed
            && let Ok(x) = (self.read)()
        {
            *place = x;
            self.next += 1;
            return Ok(Block {
                samples: 1,
                missing: u32::try_from(missing).unwrap_or(u32::MAX),
            });
        }
        self.failed = true;
        Err(PartFailed::Converter)
    }
}
