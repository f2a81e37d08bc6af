//! Frames as a box sends them, made by hand: records of any length, restart and gap.

use rarma_box::wire::{MAX_FRAME, RAW_SAMPLES, Raw, Telemetry, encode};

/// A run of a box that sends frames.
#[derive(Debug, Clone, Copy)]
pub struct Sender {
    /// The run.
    pub session: u32,
    sequence: u32,
}

impl Sender {
    /// A box that has just started.
    #[must_use]
    pub fn new(session: u32) -> Self {
        Self {
            session,
            sequence: 0,
        }
    }

    /// A frame.
    ///
    /// # Panics
    /// The message is too long for one.
    pub fn frame(&mut self, message: &Telemetry) -> Vec<u8> {
        let mut out = [0; MAX_FRAME];
        let frame = encode(message, self.session, self.sequence, &mut out);
        self.sequence = self.sequence.wrapping_add(1);
        frame.expect("a frame").to_vec()
    }

    /// The message that tells the rate.
    pub fn started(&mut self, fs_hz: f64) -> Vec<u8> {
        self.frame(&Telemetry::Started { fs_hz, p: 8, q: 7 })
    }

    /// Samples from number `first` on, block by block.
    ///
    /// # Panics
    /// Never: a block has room for its samples.
    pub fn raw(&mut self, first: u64, codes: &[i16]) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (k, block) in codes.chunks(RAW_SAMPLES).enumerate() {
            let mut raw = Raw::new(first + (k * RAW_SAMPLES) as u64);
            for code in block {
                let added = raw.bytes.extend_from_slice(&code.to_le_bytes());
                added.expect("room for a block");
            }
            bytes.extend(self.frame(&Telemetry::Raw(raw)));
        }
        bytes
    }
}
