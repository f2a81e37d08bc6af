//! One half of the store: a journal over the pages of its part of the flash.
//!
//! Records are found wherever they stand; the newest of a number counts. A page in use
//! begins with a record of its own that counts pages, and the greatest count is the page
//! that takes new records. When it is full, a page that holds nothing needed is erased and
//! is the next; if that was the last such page, the records that are still needed of the
//! page after it are copied first. So a page is erased only once everything in it stands
//! elsewhere, and it is erased right before it is used, whatever it reads as: an erase that
//! a power cut ended may read as a perfect one.

mod index;
mod mend;
mod write;

pub(super) use index::Index;

use super::record::{Claim, PAGE, RECORD_MOST, Record, WORD, size};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;

/// What the record of a page says: this format.
const FORMAT: &[u8] = &[2];
/// Bytes of the record of a page.
const OWN_BYTES: u32 = size(FORMAT.len()) as u32;
/// How often a word is looked at where it may read differently every time.
const LOOKS: u32 = 16;
/// Words of what may be a blank stretch that are read at once: a read by itself costs as much as these.
const STRETCH: usize = 8;

/// What stands at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    Blank,
    /// A word of no sound record.
    Garbage([u8; WORD]),
    /// A sound one, of which this is the head.
    Record(Claim),
}

impl Found {
    /// Bytes it takes.
    pub fn size(&self) -> u32 {
        match self {
            Self::Record(claim) => claim.size() as u32,
            _ => WORD as u32,
        }
    }
}

/// Whether there was a page to be used next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Room {
    /// There was.
    Had,
    /// There is now.
    Made,
}

/// A part of the flash: a whole number of pages, at least two.
pub(super) struct Half<'a, F> {
    flash: &'a mut F,
    pub range: Range<u32>,
    /// Bytes left free before the next record: the word there may be one whose writing a
    /// power cut ended so early that it reads erased, and another time does not.
    gap: &'a mut u32,
    /// What was read last.
    bytes: [u8; RECORD_MOST],
}

/// [`Half::gap`] after a start.
pub(super) const GAP: u32 = WORD as u32;

impl<'a, F: NorFlash> Half<'a, F> {
    pub fn new(flash: &'a mut F, range: Range<u32>, gap: &'a mut u32) -> Self {
        Self {
            flash,
            range,
            gap,
            bytes: [0; RECORD_MOST],
        }
    }

    const PAGE_BYTES: u32 = F::ERASE_SIZE as u32;
    /// Records take whole words of the flash.
    const FITS: () =
        assert!(WORD.is_multiple_of(F::WRITE_SIZE) && WORD.is_multiple_of(F::READ_SIZE));

    fn pages(&self) -> impl Iterator<Item = u32> + use<F> {
        self.range.clone().step_by(F::ERASE_SIZE)
    }

    /// The other pages, from the one after `page` around.
    fn others(&self, page: u32) -> impl Iterator<Item = u32> + use<F> {
        let (before, after) = (
            self.range.start..page,
            page + Self::PAGE_BYTES..self.range.end,
        );
        after.chain(before).step_by(F::ERASE_SIZE)
    }

    /// Every page but the one that takes records.
    pub fn beside_head(&mut self) -> impl Iterator<Item = u32> + use<F> {
        let head = self.head().map(|(page, _)| page);
        self.pages().filter(move |page| Some(*page) != head)
    }

    /// Of [`Index::damaged`]; pages beyond its bits are never emptied for their age.
    fn bit(&self, page: u32) -> u32 {
        let number = (page - self.range.start) / Self::PAGE_BYTES;
        1_u32.checked_shl(number).unwrap_or(0)
    }

    fn page_of(&self, at: u32) -> u32 {
        at - (at - self.range.start) % Self::PAGE_BYTES
    }

    fn end_of(&self, page: u32) -> u32 {
        page + Self::PAGE_BYTES
    }

    /// What stands at an address; a record ends in its page.
    pub fn look(&mut self, at: u32) -> Found {
        let () = Self::FITS;
        let mut word = [0; WORD];
        if self.flash.read(at, &mut word).is_err() {
            return Found::Garbage(word);
        }
        if word == [0xFF; WORD] {
            return Found::Blank;
        }
        let room = self.end_of(self.page_of(at)) - at;
        let claim = Claim::of(word).filter(|claim| claim.size() as u32 <= room);
        let sound = claim.filter(|claim| {
            let record = self.bytes.get_mut(..claim.size());
            let parts = record.and_then(<[u8]>::split_first_chunk_mut::<WORD>);
            parts.is_some_and(|(first, rest)| {
                *first = word;
                self.flash.read(at + WORD as u32, rest).is_ok()
            }) && claim.is_sound(&self.bytes)
        });
        sound.map_or(Found::Garbage(word), Found::Record)
    }

    /// The record at an address.
    pub fn record(&mut self, at: u32) -> Option<Record> {
        match self.look(at) {
            Found::Record(_) => Record::checked(self.bytes),
            _ => None,
        }
    }

    /// The next thing that stands from one address to before another, and where.
    pub fn next(&mut self, from: u32, end: u32) -> Option<(u32, Found)> {
        let mut at = from;
        while at < end {
            let found = self.look(at);
            if found != Found::Blank {
                return Some((at, found));
            }
            at = self.end_of_blank(at + WORD as u32, end);
        }
        None
    }

    /// The first word from an address on that does not read erased, or the end.
    fn end_of_blank(&mut self, from: u32, end: u32) -> u32 {
        let mut at = from;
        while at < end {
            let mut words = [[0; WORD]; STRETCH];
            let left = (end - at) as usize / WORD;
            let words = words.get_mut(..left.min(STRETCH)).unwrap_or_default();
            if self.flash.read(at, words.as_flattened_mut()).is_err() {
                return at;
            }
            let blank = words.iter().take_while(|word| **word == [0xFF; WORD]);
            let blank = blank.count();
            at += (blank * WORD) as u32;
            if blank < STRETCH {
                return at;
            }
        }
        end
    }

    /// The end of what is written in a page: behind it every word reads erased.
    fn end_of_written(&mut self, page: u32) -> u32 {
        let mut end = self.end_of(page);
        while end > page {
            let mut words = [[0; WORD]; STRETCH];
            let left = (end - page) as usize / WORD;
            let words = words.get_mut(..left.min(STRETCH)).unwrap_or_default();
            let from = end - (words.len() * WORD) as u32;
            if self.flash.read(from, words.as_flattened_mut()).is_err() {
                return end;
            }
            let written = words.iter().rposition(|word| *word != [0xFF; WORD]);
            if let Some(last) = written {
                return from + ((last + 1) * WORD) as u32;
            }
            end = from;
        }
        page
    }

    /// The count of a page in use.
    fn count(&mut self, page: u32) -> Option<u32> {
        match self.look(page) {
            Found::Record(claim) if claim.number == PAGE => Some(claim.order),
            _ => None,
        }
    }

    /// The page that takes records, and its count.
    fn head(&mut self) -> Option<(u32, u32)> {
        let mut head = None;
        for page in self.pages() {
            if let Some(count) = self.count(page)
                && head.is_none_or(|(_, most)| count > most)
            {
                head = Some((page, count));
            }
        }
        head
    }

    /// A setting's newest record, and where it stands; looked at until it reads well.
    pub fn read(&mut self, index: &Index, place: usize) -> Option<(u32, Record)> {
        let at = self.newest(index, place)?;
        self.reread(at).map(|record| (at, record))
    }

    /// A record that has been found, looked at until it reads well.
    pub fn reread(&mut self, at: u32) -> Option<Record> {
        (0..LOOKS).find_map(|_| self.record(at))
    }

    /// The newest record of a number, and where it stands.
    pub fn search(&mut self, number: u16) -> Option<(u32, Claim)> {
        let mut newest: Option<(u32, Claim)> = None;
        let mut at = self.range.start;
        while let Some((there, found)) = self.next(at, self.range.end) {
            if let Found::Record(claim) = found
                && claim.number == number
            {
                let newer = newest.is_none_or(|(known, best)| {
                    claim.order > best.order
                        || claim.order == best.order && {
                            let (known, this) = (self.page_of(known), self.page_of(there));
                            self.count(this) >= self.count(known)
                        }
                });
                if newer {
                    newest = Some((there, claim));
                }
            }
            at = there + found.size();
        }
        newest
    }

    /// Whether a word reads erased, not only once: after a power cut it may do so at times.
    fn is_erased(&mut self, at: u32) -> bool {
        (0..LOOKS).all(|_| self.look(at) == Found::Blank)
    }
}
