//! Compressed files made by hand: FLAC of verbatim subframes, MPEG-4 around it, and MP3 of
//! silence. What they hold is known to the last bit, and no encoder is needed.

/// Frames of a FLAC block.
pub const BLOCK: usize = 1000;

/// Bits, most significant first.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    held: u32,
}

impl Bits {
    fn put(&mut self, value: u64, width: u32) {
        for k in (0..width).rev() {
            if self.held.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let bit = (value >> k & 1) as u8;
            *self.bytes.last_mut().unwrap() |= bit << (7 - self.held % 8);
            self.held += 1;
        }
    }
}

fn crc(bytes: &[u8], polynomial: u32, width: u32) -> u32 {
    bytes.iter().fold(0, |crc, byte| {
        let crc = crc ^ u32::from(*byte) << (width - 8);
        (0..8).fold(crc, |crc, _| {
            let out = crc >> (width - 1) & 1;
            ((crc << 1) ^ (out * polynomial)) & ((1 << width) - 1)
        })
    })
}

/// The stream's description: block sizes, rate, channels, bits, frames.
pub fn stream_info(rate: u32, channels: usize, frames: u64) -> Vec<u8> {
    let mut b = Bits::default();
    b.put(BLOCK as u64, 16);
    b.put(BLOCK as u64, 16);
    b.put(0, 24);
    b.put(0, 24);
    b.put(rate.into(), 20);
    b.put(channels as u64 - 1, 3);
    b.put(15, 5);
    b.put(frames, 36);
    b.bytes.extend([0; 16]);
    b.bytes
}

/// One frame for each block of 16 bit samples, the channels side by side.
pub fn flac_frames(channels: &[Vec<i16>]) -> Vec<Vec<u8>> {
    let length = channels[0].len();
    let blocks = (0..length).step_by(BLOCK).enumerate();
    let frame = |(number, from): (usize, usize)| {
        assert!(number < 128, "a longer number has another form");
        let n = BLOCK.min(length - from);
        let mut b = Bits::default();
        b.put(0xfff8, 16);
        // Its size and the stream's rate; channels by themselves; the stream's bits.
        b.put(0b0111_0000, 8);
        b.put((channels.len() as u64 - 1) << 4, 8);
        b.put(number as u64, 8);
        b.put(n as u64 - 1, 16);
        b.put(crc(&b.bytes, 0x07, 8).into(), 8);
        for channel in channels {
            b.put(0b10, 8);
            for x in &channel[from..from + n] {
                b.put((*x as u16).into(), 16);
            }
        }
        b.put(crc(&b.bytes, 0x8005, 16).into(), 16);
        b.bytes
    };
    blocks.map(frame).collect()
}

/// A FLAC file.
pub fn flac(rate: u32, channels: &[Vec<i16>]) -> Vec<u8> {
    let info = stream_info(rate, channels.len(), channels[0].len() as u64);
    let mut out = b"fLaC\x80\0\0\x22".to_vec();
    out.extend(info);
    out.extend(flac_frames(channels).concat());
    out
}

/// A box of an MPEG-4 file.
pub fn boxed(name: &[u8; 4], body: &[u8]) -> Vec<u8> {
    let mut out = (body.len() as u32 + 8).to_be_bytes().to_vec();
    out.extend(name);
    out.extend(body);
    out
}

/// Numbers of 32 bits in a row.
fn words(all: &[u32]) -> Vec<u8> {
    all.iter().flat_map(|w| w.to_be_bytes()).collect()
}

/// Bytes, and how many frames of sound are in them.
pub type Packet = (Vec<u8>, u32);

/// An MPEG-4 file.
pub struct Movie {
    pub rate: u32,
    pub channels: usize,
    /// `soun` or `vide`.
    pub handler: [u8; 4],
    /// Name of the sample entry.
    pub codec: [u8; 4],
    /// The box inside of it.
    pub inside: Vec<u8>,
    /// Packets and how many frames each holds.
    pub packets: Vec<Packet>,
    /// Where the sound begins, frames.
    pub begins: Option<u32>,
    /// The index stands before the sound.
    pub index_first: bool,
}

impl Movie {
    /// FLAC inside.
    pub fn flac(rate: u32, channels: &[Vec<i16>]) -> Self {
        let n = channels[0].len() as u64;
        let mut inside = vec![0, 0, 0, 0, 0x80, 0, 0, 0x22];
        inside.extend(stream_info(rate, channels.len(), n));
        let lengths = channels[0].chunks(BLOCK).map(|part| part.len() as u32);
        Self {
            rate,
            channels: channels.len(),
            handler: *b"soun",
            codec: *b"fLaC",
            inside: boxed(b"dfLa", &inside),
            packets: flac_frames(channels).into_iter().zip(lengths).collect(),
            begins: None,
            index_first: false,
        }
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let head = boxed(b"ftyp", b"M4A \0\0\x02\0M4A ");
        let sound: Vec<u8> = self.packets.iter().flat_map(|p| p.0.clone()).collect();
        let data = boxed(b"mdat", &sound);
        let from = |index: usize| (head.len() + index + 8) as u32;
        if self.index_first {
            let index = self.index(from(self.index(0).len()));
            [head, index, data].concat()
        } else {
            let index = self.index(from(0));
            [head, data, index].concat()
        }
    }

    fn index(&self, at: u32) -> Vec<u8> {
        // Headers that cannot be hold billions.
        let frames = self
            .packets
            .iter()
            .fold(0, |sum: u32, p| sum.wrapping_add(p.1));
        let count = self.packets.len() as u32;
        let mut entry = vec![0, 0, 0, 0, 0, 0, 0, 1];
        entry.extend([0; 8]);
        entry.extend((self.channels as u16).to_be_bytes());
        entry.extend(16u16.to_be_bytes());
        entry.extend([0; 4]);
        entry.extend((self.rate << 16).to_be_bytes());
        entry.extend(&self.inside);
        let stsd = [words(&[0, 1]), boxed(&self.codec, &entry)].concat();
        let each = |f: &dyn Fn(&Packet) -> Vec<u32>| {
            let all: Vec<u32> = self.packets.iter().flat_map(f).collect();
            words(&all)
        };
        let stts = [words(&[0, count]), each(&|p| vec![1, p.1])].concat();
        let stsz = [words(&[0, 0, count]), each(&|p| vec![p.0.len() as u32])].concat();
        let stbl = [
            boxed(b"stsd", &stsd),
            boxed(b"stts", &stts),
            boxed(b"stsc", &words(&[0, 1, 1, count, 1])),
            boxed(b"stsz", &stsz),
            boxed(b"stco", &words(&[0, 1, at])),
        ]
        .concat();
        let about = match &self.handler {
            b"vide" => boxed(b"vmhd", &words(&[1, 0, 0])),
            _ => boxed(b"smhd", &words(&[0, 0])),
        };
        let dref = [words(&[0, 1]), boxed(b"url ", &words(&[1]))].concat();
        let dinf = boxed(b"dinf", &boxed(b"dref", &dref));
        let minf = [about, dinf, boxed(b"stbl", &stbl)].concat();
        let hdlr = [words(&[0, 0]), self.handler.to_vec(), vec![0; 13]].concat();
        let mdia = [
            boxed(b"mdhd", &words(&[0, 0, 0, self.rate, frames, 0])),
            boxed(b"hdlr", &hdlr),
            boxed(b"minf", &minf),
        ]
        .concat();
        let mut tkhd = words(&[7, 0, 0, 1, 0, frames]);
        tkhd.extend([0; 60]);
        let edits = self.begins.map_or(Vec::new(), |from| {
            let elst = words(&[0, 1, frames - from, from, 1 << 16]);
            boxed(b"edts", &boxed(b"elst", &elst))
        });
        let trak = [boxed(b"tkhd", &tkhd), edits, boxed(b"mdia", &mdia)].concat();
        let mut mvhd = words(&[0, 0, 0, self.rate, frames]);
        mvhd.extend([0; 80]);
        let moov = [boxed(b"mvhd", &mvhd), boxed(b"trak", &trak)].concat();
        boxed(b"moov", &moov)
    }
}

/// An MP3 of silence, 128 kbit/s at 44 100 Hz, one channel: so many frames.
pub fn mp3(frames: usize) -> Vec<u8> {
    let mut one = vec![0xff, 0xfb, 0x90, 0xc4];
    one.resize(417, 0);
    one.repeat(frames)
}
