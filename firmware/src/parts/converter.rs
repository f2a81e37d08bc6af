//! A converter or gauge that answers a command of three bytes on SPI.

use super::PartFailed;
use crate::board::AdcCode;
use embedded_hal::spi::SpiDevice;

/// 24 clocks: three bytes go out, three come back, and the code stands somewhere in these. So work the
/// MCP3204 and MCP3208 (12 bits at the end; commands 06 00 00 and on) and many gauges.
///
/// A converter that is torn off answers ones or zeros, which is an end of the range, as
/// [`SensorCodes`](crate::board::SensorCodes) wants it.
#[derive(Debug)]
pub struct SpiConverter<S> {
    spi: S,
    bits: u32,
    after: u32,
}

impl<S: SpiDevice> SpiConverter<S> {
    /// `bits` of the code, 8 to 16, and bits that come after it, 0 and more; none where they do not fit into
    /// the 24.
    pub fn new(spi: S, bits: u32, after: u32) -> Option<Self> {
        ((8..=16).contains(&bits) && after <= 24 - bits).then_some(Self { spi, bits, after })
    }

    /// Sends a command and takes the code of the same 24 clocks. The upper bits again fill the lower, so that
    /// the greatest code is [`AdcCode::FULL`].
    ///
    /// # Errors
    /// [`PartFailed::Converter`]: the bus refused.
    pub fn code(&mut self, command: [u8; 3]) -> Result<AdcCode, PartFailed> {
        let mut bytes = command;
        self.spi
            .transfer_in_place(&mut bytes)
            .map_err(|_| PartFailed::Converter)?;
        let [first, second, third] = bytes;
        let word = u32::from_be_bytes([0, first, second, third]) >> self.after;
        let top = word << (32 - self.bits);
        Ok(AdcCode(((top | top >> self.bits) >> 16) as u16))
    }
}
