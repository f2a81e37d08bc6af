//! A converter on I2C, as the ADS1015 and ADS1115 (data sheets SBAS473, SBAS444).

use super::{SimTime, Trouble};
use embedded_hal::i2c::{
    Error, ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation, SevenBitAddress,
};

/// The bus did not carry it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct I2cError(pub ErrorKind);

impl Error for I2cError {
    fn kind(&self) -> ErrorKind {
        self.0
    }
}

/// Which of the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdcBits {
    /// ADS1015: 12 bits, up to 3300 conversions a second.
    Twelve,
    /// ADS1115: 16 bits, up to 860.
    Sixteen,
}

impl AdcBits {
    fn rate_hz(self, setting: usize) -> f64 {
        let rates = match self {
            Self::Twelve => [128, 250, 490, 920, 1600, 2400, 3300, 3300],
            Self::Sixteen => [8, 16, 32, 64, 128, 250, 475, 860],
        };
        f64::from(rates[setting & 7])
    }

    /// Codes below the least one that a conversion gives, left-aligned in 16 bits.
    fn cut(self) -> i32 {
        match self {
            Self::Twelve => !0xF,
            Self::Sixteen => !0,
        }
    }
}

/// Address with the address pin at ground.
const ADDRESS: SevenBitAddress = 0x48;
/// Registers, by the pointer: result, configuration, thresholds of the comparator.
const RESULT: usize = 0;
const CONFIG: usize = 1;
const REGISTERS: usize = 4;
/// Bit of the configuration: a conversion is asked for (written), none runs (read).
const READY: u16 = 1 << 15;
/// Bit of the configuration: one conversion at a time.
const ONE_SHOT: u16 = 1 << 8;
/// Full scale by the amplifier's setting, V.
const RANGES_V: [f64; 8] = [6.144, 4.096, 2.048, 1.024, 0.512, 0.256, 0.256, 0.256];
/// Inputs by the multiplexer's setting, as (+, −); none is ground.
const INPUTS: [(u8, Option<u8>); 8] = [
    (0, Some(1)),
    (0, Some(3)),
    (1, Some(3)),
    (2, Some(3)),
    (0, None),
    (1, None),
    (2, None),
    (3, None),
];

/// The converter. It takes its input at the end of a conversion, whose length the rate sets; the bus takes
/// the time of its bits.
///
/// `input` gives a channel's voltage at a time in s.
#[derive(Debug)]
pub struct I2cAdc<F> {
    input: F,
    bits: AdcBits,
    time: SimTime,
    ns_per_bit: u64,
    registers: [u16; REGISTERS],
    pointer: usize,
    /// When the conversion that runs began, ns.
    began_ns: Option<u64>,
    /// Nobody answers.
    pub torn_off: Trouble,
}

impl<F: FnMut(u8, f64) -> f64> I2cAdc<F> {
    /// On a bus of this clock, Hz.
    pub fn new(bits: AdcBits, bus_hz: u32, time: SimTime, input: F) -> Self {
        Self {
            input,
            bits,
            time,
            ns_per_bit: 1_000_000_000 / u64::from(bus_hz.max(1)),
            // As after power-up: idle, ±2.048 V, one conversion at a time, comparator off.
            registers: [0, 0x8583, 0x8000, 0x7FFF],
            pointer: RESULT,
            began_ns: None,
            torn_off: Trouble::default(),
        }
    }

    fn field(&self, shift: u32) -> usize {
        usize::from(self.registers[CONFIG] >> shift & 7)
    }

    /// Ends what has ended by now.
    fn go_on(&mut self) {
        let length_ns = (1e9 / self.bits.rate_hz(self.field(5))) as u64;
        let Some(began_ns) = self.began_ns else {
            return;
        };
        let done = (self.time.ns() - began_ns) / length_ns;
        if done == 0 {
            return;
        }
        let ended_ns = began_ns + done * length_ns;
        let (plus, minus) = INPUTS[self.field(12)];
        let at_s = 1e-9 * ended_ns as f64;
        let mut volts = (self.input)(plus, at_s);
        if let Some(minus) = minus {
            volts -= (self.input)(minus, at_s);
        }
        let code = (volts / RANGES_V[self.field(9)] * 32768.0).round();
        // A float cast takes NaN for 0.
        let code = (code.clamp(-32768.0, 32767.0) as i32) & self.bits.cut();
        self.registers[RESULT] = code as u16;
        self.began_ns = (self.registers[CONFIG] & ONE_SHOT == 0).then_some(ended_ns);
    }

    fn told(&mut self, bytes: &[u8]) {
        let &[pointer, ref value @ ..] = bytes else {
            return;
        };
        self.pointer = usize::from(pointer) % REGISTERS;
        if let &[high, low] = value
            && self.pointer != RESULT
        {
            self.registers[self.pointer] = u16::from_be_bytes([high, low]);
            let config = self.registers[CONFIG];
            if self.pointer == CONFIG && (config & ONE_SHOT == 0 || config & READY != 0) {
                self.began_ns = Some(self.time.ns());
            }
        }
    }

    fn says(&self) -> u16 {
        let value = self.registers[self.pointer];
        if self.pointer != CONFIG {
            return value;
        }
        let idle = self.began_ns.is_none();
        value & !READY | if idle { READY } else { 0 }
    }
}

impl<F> ErrorType for I2cAdc<F> {
    type Error = I2cError;
}

impl<F: FnMut(u8, f64) -> f64> I2c for I2cAdc<F> {
    fn transaction(
        &mut self,
        address: SevenBitAddress,
        operations: &mut [Operation<'_>],
    ) -> Result<(), I2cError> {
        // The address, and whether somebody answers.
        self.time.pass_ns(9 * self.ns_per_bit);
        if self.torn_off.stands() || address != ADDRESS {
            return Err(I2cError(ErrorKind::NoAcknowledge(
                NoAcknowledgeSource::Address,
            )));
        }
        for operation in operations {
            let length = match operation {
                Operation::Write(bytes) => bytes.len(),
                Operation::Read(bytes) => bytes.len(),
            };
            self.time.pass_ns(9 * self.ns_per_bit * length as u64);
            self.go_on();
            match operation {
                Operation::Write(bytes) => self.told(bytes),
                Operation::Read(bytes) => {
                    let value = self.says().to_be_bytes();
                    for (k, place) in bytes.iter_mut().enumerate() {
                        *place = value[k % 2];
                    }
                }
            }
        }
        Ok(())
    }
}
