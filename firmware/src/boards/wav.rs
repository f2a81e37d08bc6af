//! Samples of a WAV file, read as a stream: the emulated board's microphone.
//!
//! PCM of 16, 24 and 32 bits and 32-bit float, any number of channels; one
//! channel is taken. PCM is scaled to ±1.

/// A source of bytes: a file behind semihosting, or a slice in a test.
pub trait ByteSource {
    /// Fills the front of `buffer` and returns how many bytes; 0 at the end.
    fn read_bytes(&mut self, buffer: &mut [u8]) -> usize;
}

/// Why a WAV is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WavError {
    /// No RIFF/WAVE header, or the file ends inside it.
    Header,
    /// A format other than 16-, 24- or 32-bit PCM or 32-bit float.
    Format {
        /// Format tag.
        tag: u16,
        /// Bits per sample.
        bits: u16,
    },
    /// The channel is not there.
    Channel {
        /// Channels in the file.
        channels: u16,
    },
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Coding {
    Pcm16,
    Pcm24,
    Pcm32,
    Float32,
}

const BUFFER: usize = 4096;

/// One channel of a WAV.
#[derive(Debug)]
pub struct WavSource<S> {
    bytes: S,
    coding: Coding,
    channels: u16,
    channel: u16,
    rate: u32,
    data_left: u64,
    buffer: [u8; BUFFER],
    from: usize,
    to: usize,
}

impl<S: ByteSource> WavSource<S> {
    /// Reads the header up to the samples.
    ///
    /// # Errors
    /// See [`WavError`].
    pub fn open(bytes: S, channel: u16) -> Result<Self, WavError> {
        let mut this = Self {
            bytes,
            coding: Coding::Pcm16,
            channels: 0,
            channel,
            rate: 0,
            data_left: 0,
            buffer: [0; BUFFER],
            from: 0,
            to: 0,
        };
        let mut riff = [0u8; 12];
        this.exact(&mut riff)?;
        if &riff[..4] != b"RIFF" || &riff[8..] != b"WAVE" {
            return Err(WavError::Header);
        }
        loop {
            let mut head = [0u8; 8];
            this.exact(&mut head)?;
            let size = u32::from_le_bytes([head[4], head[5], head[6], head[7]]);
            match &head[..4] {
                b"fmt " => this.format(size)?,
                b"data" => {
                    if this.channels == 0 {
                        return Err(WavError::Header);
                    }
                    this.data_left = u64::from(size);
                    return Ok(this);
                }
                // Chunks are padded to even length.
                _ => this.skip(u64::from(size) + u64::from(size & 1))?,
            }
        }
    }

    /// Sampling rate, Hz.
    pub fn rate(&self) -> u32 {
        self.rate
    }

    fn format(&mut self, size: u32) -> Result<(), WavError> {
        let mut f = [0u8; 16];
        if size < 16 {
            return Err(WavError::Header);
        }
        self.exact(&mut f)?;
        let mut tag = u16::from_le_bytes([f[0], f[1]]);
        let bits = u16::from_le_bytes([f[14], f[15]]);
        let mut rest = size - 16;
        if tag == 0xFFFE && rest >= 10 {
            // Extensible: the tag is the start of the sub-format.
            let mut extension = [0u8; 10];
            self.exact(&mut extension)?;
            rest -= 10;
            tag = u16::from_le_bytes([extension[8], extension[9]]);
        }
        self.skip(u64::from(rest) + u64::from(size & 1))?;
        self.channels = u16::from_le_bytes([f[2], f[3]]);
        self.rate = u32::from_le_bytes([f[4], f[5], f[6], f[7]]);
        self.coding = match (tag, bits) {
            (1, 16) => Coding::Pcm16,
            (1, 24) => Coding::Pcm24,
            (1, 32) => Coding::Pcm32,
            (3, 32) => Coding::Float32,
            _ => return Err(WavError::Format { tag, bits }),
        };
        if self.channel >= self.channels {
            return Err(WavError::Channel {
                channels: self.channels,
            });
        }
        Ok(())
    }

    fn byte(&mut self) -> Option<u8> {
        if self.from == self.to {
            self.from = 0;
            self.to = self.bytes.read_bytes(&mut self.buffer).min(BUFFER);
            if self.to == 0 {
                return None;
            }
        }
        let b = self.buffer.get(self.from).copied();
        self.from += 1;
        b
    }

    fn exact(&mut self, out: &mut [u8]) -> Result<(), WavError> {
        for place in out {
            *place = self.byte().ok_or(WavError::Header)?;
        }
        Ok(())
    }

    fn skip(&mut self, count: u64) -> Result<(), WavError> {
        for _ in 0..count {
            self.byte().ok_or(WavError::Header)?;
        }
        Ok(())
    }

    fn width(&self) -> usize {
        match self.coding {
            Coding::Pcm16 => 2,
            Coding::Pcm24 => 3,
            Coding::Pcm32 | Coding::Float32 => 4,
        }
    }

    /// One sample of one channel, none at the end of the data.
    fn value(&mut self) -> Option<f32> {
        let width = self.width();
        if self.data_left < width as u64 {
            return None;
        }
        self.data_left -= width as u64;
        let mut b = [0u8; 4];
        for place in b.iter_mut().take(width) {
            *place = self.byte()?;
        }
        Some(match self.coding {
            Coding::Pcm16 => f32::from(i16::from_le_bytes([b[0], b[1]])) / 32768.0,
            Coding::Pcm24 => (i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8) as f32 / 8_388_608.0,
            Coding::Pcm32 => i32::from_le_bytes(b) as f32 / 2_147_483_648.0,
            Coding::Float32 => f32::from_le_bytes(b),
        })
    }

    /// One sample of the chosen channel.
    fn frame(&mut self) -> Option<f32> {
        let mut chosen = None;
        for channel in 0..self.channels {
            let x = self.value()?;
            if channel == self.channel {
                chosen = Some(x);
            }
        }
        chosen
    }

    /// Writes samples to the front of the block, and returns how many; 0 at the end.
    pub fn read(&mut self, block: &mut [f32]) -> usize {
        let mut samples = 0;
        for place in block {
            match self.frame() {
                Some(x) => *place = x,
                None => break,
            }
            samples += 1;
        }
        samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl ByteSource for &[u8] {
        fn read_bytes(&mut self, buffer: &mut [u8]) -> usize {
            let n = self.len().min(buffer.len()).min(7);
            buffer[..n].copy_from_slice(&self[..n]);
            *self = &self[n..];
            n
        }
    }

    fn wav(tag: u16, channels: u16, bits: u16, data: &[u8]) -> Vec<u8> {
        let mut w = b"RIFF\0\0\0\0WAVELIST\x03\0\0\0abc\0fmt \x10\0\0\0".to_vec();
        w.extend(tag.to_le_bytes());
        w.extend(channels.to_le_bytes());
        w.extend(48_000u32.to_le_bytes());
        w.extend([0; 6]);
        w.extend(bits.to_le_bytes());
        w.extend(b"data");
        w.extend((data.len() as u32).to_le_bytes());
        w.extend(data);
        w
    }

    #[test]
    fn takes_one_channel_and_scales_it() {
        let data: Vec<u8> = [1i16, 16384, 2, -32768]
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let file = wav(1, 2, 16, &data);
        let mut source = WavSource::open(file.as_slice(), 1).unwrap();
        assert_eq!(source.rate(), 48_000);
        let mut block = [9.0; 8];
        assert_eq!(source.read(&mut block), 2);
        assert_eq!(block[..2], [0.5, -1.0]);
        assert_eq!(source.read(&mut block), 0);

        let file = wav(1, 1, 24, &[0, 0, 0xC0, 0, 0, 0x40]);
        let mut source = WavSource::open(file.as_slice(), 0).unwrap();
        assert_eq!(source.read(&mut block), 2);
        assert_eq!(block[..2], [-0.5, 0.5]);
    }

    #[test]
    fn refuses_what_it_does_not_read() {
        let open = |bytes: &[u8], channel| WavSource::open(bytes, channel).err();
        assert_eq!(open(b"RIFF", 0), Some(WavError::Header));
        assert_eq!(
            open(&wav(1, 1, 16, &[0; 4])[..30], 0),
            Some(WavError::Header)
        );
        assert_eq!(
            open(&wav(1, 1, 8, &[0]), 0),
            Some(WavError::Format { tag: 1, bits: 8 })
        );
        assert_eq!(
            open(&wav(1, 2, 16, &[0; 4]), 2),
            Some(WavError::Channel { channels: 2 })
        );
    }
}
