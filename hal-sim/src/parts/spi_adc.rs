//! A converter on SPI, as the MCP3208.

use super::{SimTime, Trouble};
use embedded_hal::spi::{Error, ErrorKind, ErrorType, Operation, SpiDevice};

/// The bus did not carry it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SpiError;

impl Error for SpiError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// Clocks of a conversion, with the command that asks for it.
const CLOCKS: usize = 24;
const TOP: f64 = 4095.0;

/// Eight inputs of 12 bits. A conversion is 24 clocks: five zeros, the start bit, single-ended, three bits of
/// the channel; the code comes with the last twelve. Single-ended only.
///
/// `input` gives a channel's part of the range at a time in s.
#[derive(Debug)]
pub struct SpiAdc<F> {
    input: F,
    time: SimTime,
    ns_per_bit: u64,
    /// The bus fails.
    pub broken: Trouble,
    /// Nothing drives the data line, which a pull-up holds.
    pub torn_off: Trouble,
}

impl<F: FnMut(u8, f64) -> f64> SpiAdc<F> {
    /// On a bus of this clock, Hz; every transfer takes its time.
    pub fn new(bus_hz: u32, time: SimTime, input: F) -> Self {
        Self {
            input,
            time,
            ns_per_bit: 1_000_000_000 / u64::from(bus_hz.max(1)),
            broken: Trouble::default(),
            torn_off: Trouble::default(),
        }
    }

    /// Three bytes of the converter for three of the board.
    fn answer(&mut self, command: &[u8]) -> [u8; CLOCKS / 8] {
        if self.torn_off.stands() {
            return [0xFF; CLOCKS / 8];
        }
        let &[first, second, ..] = command else {
            return [0; CLOCKS / 8];
        };
        if first & 0xFE != 0b0000_0110 {
            return [0; CLOCKS / 8];
        }
        let channel = (first & 1) << 2 | second >> 6;
        let part = (self.input)(channel, self.time.seconds());
        // A float cast takes NaN for 0.
        let code = (part * TOP).round().clamp(0.0, TOP) as u16;
        let [high, low] = code.to_be_bytes();
        [0, high, low]
    }
}

impl<F> ErrorType for SpiAdc<F> {
    type Error = SpiError;
}

impl<F: FnMut(u8, f64) -> f64> SpiDevice for SpiAdc<F> {
    /// Each transfer of three bytes is a conversion; others carry nothing.
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), SpiError> {
        if self.broken.stands() {
            return Err(SpiError);
        }
        for operation in operations {
            let bits = match operation {
                Operation::TransferInPlace(bytes) => {
                    let answer = self.answer(bytes);
                    for (place, byte) in bytes.iter_mut().zip(answer) {
                        *place = byte;
                    }
                    8 * bytes.len()
                }
                Operation::Transfer(read, write) => {
                    let answer = self.answer(write);
                    for (place, byte) in read.iter_mut().zip(answer) {
                        *place = byte;
                    }
                    8 * read.len().max(write.len())
                }
                Operation::Write(bytes) => 8 * bytes.len(),
                Operation::Read(bytes) => {
                    bytes.fill(0);
                    8 * bytes.len()
                }
                Operation::DelayNs(ns) => {
                    self.time.pass_ns(u64::from(*ns));
                    0
                }
            };
            self.time.pass_ns(self.ns_per_bit * bits as u64);
        }
        Ok(())
    }
}
