//! A NOR flash like the STM32G4's, and hostile: words of 64 bits with eight check bits, pages
//! of 2 KiB, power that goes away in the middle of a word or an erase.
//!
//! Physics. An erased bit is 1, a programmed one 0. Programming only makes zeros; an erase
//! makes a whole page ones. One that is cut short leaves each bit of its word or page as it
//! was, as it should be, or in between: such a *weak* bit reads differently every time. Bits
//! that age flip and stay so. The chip does not program a word that does not read erased,
//! except with zeros. One wrong bit of the 72 is mended by the read and counted, two are
//! counted and handed out as they are, more may be mended into nonsense.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use firmware::board::FlashSeen;
use firmware::store::Store;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::settings::{SETTINGS, Setting, Settings};
use std::collections::BTreeSet;
use std::ops::Range;

/// Smallest write, bytes: a double word with its check bits, as on the G4.
pub const WORD: usize = 8;
/// Erase sector, bytes.
pub const SECTOR: usize = 2048;
/// Sectors for settings, unless another number is asked for.
pub const SECTORS: usize = 4;
/// Bits of a word, with its check bits.
pub const WORD_BITS: u32 = 72;

/// Numbers that no setting has.
const FOREIGN: Range<u16> = 1000..3000;
const ALL: u128 = (1 << WORD_BITS) - 1;

/// Why the flash did not do it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlashError {
    /// The power went away.
    PowerLost,
    /// Outside the flash or off the grid.
    Range,
    /// The word is not erased: its check bits cannot be written twice, except by zeros.
    NotErased,
    /// It is worn out.
    Worn,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Range => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// A word: 64 bits of data, eight check bits above them.
#[derive(Debug, Clone, Copy)]
struct Cells {
    bits: u128,
    /// Those that read differently every time.
    weak: u128,
}

/// The flash.
#[derive(Debug, Clone)]
pub struct SimFlash {
    words: Vec<Cells>,
    /// Words that can still be programmed, and pages erased, before the power goes away in
    /// the middle of the next one.
    pub power_for: Option<usize>,
    /// Every write and erase fails from now on.
    pub worn: bool,
    /// Whether there are check bits; without them data is read as it is.
    pub mends: bool,
    /// Pages, by number, whose erase leaves some bits as they were, and says nothing.
    pub bad_pages: BTreeSet<usize>,
    wear: Vec<u32>,
    touched: usize,
    reads: usize,
    dead: bool,
    seen: FlashSeen,
    rng: ChaCha8Rng,
}

impl Default for SimFlash {
    fn default() -> Self {
        Self::new(SECTORS, 0)
    }
}

/// Which check bits each data bit takes part in: an odd number of them, no two the same, so
/// that one wrong bit is known and two are seen.
const COLUMNS: [u8; 64] = {
    let (mut columns, mut bit, mut column) = ([0; 64], 0, 0u8);
    while bit < 64 {
        column += 1;
        if column.count_ones() % 2 == 1 && column.count_ones() > 1 {
            columns[bit] = column;
            bit += 1;
        }
    }
    columns
};

/// Which data bits each check bit is the parity of.
const ROWS: [u64; 8] = {
    let (mut rows, mut bit) = ([0; 8], 0);
    while bit < 64 {
        let mut row = 0;
        while row < 8 {
            rows[row] |= ((COLUMNS[bit] >> row & 1) as u64) << bit;
            row += 1;
        }
        bit += 1;
    }
    rows
};

fn check_bits(data: u64) -> u8 {
    (0..8).fold(0, |check, row| {
        check | (((data & ROWS[row]).count_ones() % 2) as u8) << row
    })
}

fn coded(data: u64) -> u128 {
    u128::from(data) | u128::from(check_bits(data)) << 64
}

/// What a read makes of a word: data, whether a bit was mended, whether it could not be.
fn decoded(bits: u128) -> (u64, bool, bool) {
    let data = bits as u64;
    // A virgin word is no code word, and is known for what it is.
    if bits == ALL {
        return (data, false, false);
    }
    if (bits ^ ALL).count_ones() == 1 {
        return (u64::MAX, true, false);
    }
    let syndrome = check_bits(data) ^ (bits >> 64) as u8;
    if syndrome == 0 {
        return (data, false, false);
    }
    if syndrome.is_power_of_two() {
        return (data, true, false);
    }
    if let Some(bit) = COLUMNS.iter().position(|column| *column == syndrome) {
        return (data ^ 1 << bit, true, false);
    }
    (data, false, true)
}

impl SimFlash {
    /// An erased flash of so many pages.
    pub fn new(pages: usize, seed: u64) -> Self {
        let erased = Cells { bits: ALL, weak: 0 };
        Self {
            words: vec![erased; pages * SECTOR / WORD],
            power_for: None,
            worn: false,
            mends: true,
            bad_pages: BTreeSet::new(),
            wear: vec![0; pages],
            touched: 0,
            reads: 0,
            dead: false,
            seen: FlashSeen::default(),
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// From here on chance is another one.
    pub fn reseed(&mut self, seed: u64) {
        self.rng = ChaCha8Rng::seed_from_u64(seed);
    }

    /// All of it.
    pub fn range(&self) -> Range<u32> {
        0..(self.words.len() * WORD) as u32
    }

    /// Power is back; what was written is what is there.
    pub fn power_up(&mut self) {
        self.dead = false;
        self.power_for = None;
    }

    /// Whether the power went away during an operation.
    pub fn lost_power(&self) -> bool {
        self.dead
    }

    /// Records of numbers that no setting has, until there is no room: a later firmware's.
    /// Once; the second call finds no room.
    pub fn fill(&mut self) {
        let range = self.range();
        let (mut store, _) = Store::load(self, range.clone(), &mut Settings::default());
        for number in FOREIGN {
            let foreign = Setting {
                number,
                ..SETTINGS[0]
            };
            let value = Some(foreign.default_value());
            if store.write(self, range.clone(), &foreign, value).is_err() {
                return;
            }
        }
    }

    /// What the check bits have said since the last call.
    pub fn take_seen(&mut self) -> FlashSeen {
        std::mem::take(&mut self.seen)
    }

    /// Words programmed and pages erased so far.
    pub fn touched(&self) -> usize {
        self.touched
    }

    /// Reads so far, of whatever length.
    pub fn reads(&self) -> usize {
        self.reads
    }

    /// Erases of each page so far.
    pub fn wear(&self) -> &[u32] {
        &self.wear
    }

    /// Whether nothing is written in a word, as data reads.
    pub fn is_erased(&self, word: usize) -> bool {
        self.words[word].bits as u64 == u64::MAX
    }

    /// A bit of a word flips and stays so; check bits are those from 64 on.
    pub fn flip(&mut self, word: usize, bit: u32) {
        self.words[word].bits ^= 1 << bit;
    }

    /// Holds these bytes from a place on, with check bits that fit, whatever was there; what
    /// goes beyond its end is left out.
    pub fn overwrite(&mut self, at: usize, bytes: &[u8]) {
        for (place, byte) in (at..).zip(bytes) {
            let Some(word) = self.words.get_mut(place / WORD) else {
                return;
            };
            let mut data = (word.bits as u64).to_le_bytes();
            data[place % WORD] = *byte;
            *word = Cells {
                bits: coded(u64::from_le_bytes(data)),
                weak: 0,
            };
        }
    }

    /// Anything at all, with check bits that fit or not.
    pub fn scramble(&mut self, pages: Range<usize>) {
        for word in pages.start * SECTOR / WORD..pages.end * SECTOR / WORD {
            let data = self.rng.random();
            self.words[word] = Cells {
                bits: coded(data),
                weak: 0,
            };
        }
    }

    /// A bit pattern of which some, none or most bits are set, for what a cut left.
    fn some_bits(&mut self) -> u128 {
        let share = match self.rng.random_range(0..6) {
            0 => 0.0,
            1 => 1.0,
            2 => 0.02,
            3 => 0.98,
            _ => self.rng.random(),
        };
        (0..WORD_BITS).fold(0, |bits, bit| {
            bits | u128::from(self.rng.random_bool(share)) << bit
        })
    }

    /// A word on its way to other bits when the power goes away.
    fn tear(&mut self, word: usize, wanted: u128, share: impl Fn(&mut Self) -> u128) {
        let done = share(self);
        let weak = share(self) & share(self);
        let cells = &mut self.words[word];
        let moving = cells.bits ^ wanted;
        cells.bits = cells.bits & !done | wanted & done;
        cells.weak |= moving & weak & !done;
    }

    /// One word or page; false if the power goes away in it.
    fn has_power(&mut self) -> bool {
        if let Some(left) = &mut self.power_for {
            if *left == 0 {
                self.dead = true;
                return false;
            }
            *left -= 1;
        }
        self.touched += 1;
        true
    }

    /// What a word reads as now.
    fn read_word(&mut self, word: usize) -> u64 {
        let Cells { mut bits, weak } = self.words[word];
        if weak != 0 {
            bits ^= weak & self.rng.random::<u128>();
        }
        if !self.mends {
            return bits as u64;
        }
        let (data, mended, spoilt) = decoded(bits);
        self.seen.corrected_words += u32::from(mended);
        self.seen.unreadable_words += u32::from(spoilt);
        data
    }

    fn check(&self, from: u32, to: u32, grid: usize) -> Result<Range<usize>, FlashError> {
        if self.dead {
            return Err(FlashError::PowerLost);
        }
        let (from, to) = (from as usize, to as usize);
        let inside = from <= to && to <= self.words.len() * WORD;
        if !inside || !from.is_multiple_of(grid) || !to.is_multiple_of(grid) {
            return Err(FlashError::Range);
        }
        Ok(from..to)
    }
}

impl ErrorType for SimFlash {
    type Error = FlashError;
}

impl ReadNorFlash for SimFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let range = self.check(offset, offset + bytes.len() as u32, 1)?;
        self.reads += 1;
        let mut at = range.start;
        while at < range.end {
            let word = at / WORD;
            let data = self.read_word(word).to_le_bytes();
            let end = range.end.min((word + 1) * WORD);
            bytes[at - range.start..end - range.start]
                .copy_from_slice(&data[at % WORD..][..end - at]);
            at = end;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.words.len() * WORD
    }
}

impl NorFlash for SimFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let range = self.check(from, to, SECTOR)?;
        if self.worn {
            return Err(FlashError::Worn);
        }
        for page in range.start / SECTOR..range.end / SECTOR {
            let words = page * SECTOR / WORD..(page + 1) * SECTOR / WORD;
            self.wear[page] += 1;
            if !self.has_power() {
                // One state of the whole page, or one of each word.
                let of_all = self.some_bits();
                let each = self.rng.random_bool(0.5);
                for word in words {
                    if each {
                        self.tear(word, ALL, Self::some_bits);
                    } else {
                        self.tear(word, ALL, |this| {
                            of_all.rotate_left(this.rng.random_range(0..9))
                        });
                    }
                }
                return Err(FlashError::PowerLost);
            }
            let sticks = self.bad_pages.contains(&page);
            for word in words {
                // The same bits every time, one in eight.
                let stuck =
                    (word as u128 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15_F39C_C060_5CED_C835);
                let stuck = stuck & stuck >> 7 & stuck >> 19;
                let kept = if sticks { stuck } else { 0 };
                let cells = &mut self.words[word];
                cells.bits |= ALL & !kept;
                cells.weak = 0;
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let range = self.check(offset, offset + bytes.len() as u32, WORD)?;
        if self.worn {
            return Err(FlashError::Worn);
        }
        let (words, _) = bytes.as_chunks::<WORD>();
        for (word, data) in (range.start / WORD..).zip(words) {
            let data = u64::from_le_bytes(*data);
            if self.read_word(word) != u64::MAX && data != 0 {
                return Err(FlashError::NotErased);
            }
            // Check bits of a word that is programmed twice fit no more, but for zeros.
            let wanted = self.words[word].bits & coded(data);
            if !self.has_power() {
                self.tear(word, wanted, Self::some_bits);
                return Err(FlashError::PowerLost);
            }
            let cells = &mut self.words[word];
            cells.bits = wanted;
            cells.weak &= wanted;
        }
        Ok(())
    }
}
