//! One half of the store: a journal over the pages of its part of the flash.
//!
//! Records are found wherever they stand; the newest of a number counts. A page in use
//! begins with a record of its own that counts pages, and the greatest count is the page
//! that takes new records. When it is full, a page that holds nothing needed is erased and
//! is the next; if that was the last such page, the records that are still needed of the
//! page after it are copied first. So a page is erased only once everything in it stands
//! elsewhere, and it is erased right before it is used, whatever it reads as: an erase that
//! a power cut ended may read as a perfect one.

mod mend;
mod write;

use super::place_of;
use super::record::{Claim, PAGE, RECORD_MOST, Record, WORD, size};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use rarma_box::settings::COUNT;

/// What the record of a page says: this format.
const FORMAT: &[u8] = &[2];
/// Bytes of the record of a page.
const OWN_BYTES: u32 = size(FORMAT.len()) as u32;
/// How often a word is looked at where it may read differently every time.
const LOOKS: u32 = 16;

/// What stands at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    Blank,
    /// A word of no sound record.
    Garbage([u8; WORD]),
    Record(Record),
}

impl Found {
    /// Bytes it takes.
    pub fn size(&self) -> u32 {
        match self {
            Self::Record(record) => record.claim.size() as u32,
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

/// The newest records of a half.
#[derive(Debug, Clone, Copy)]
pub(super) struct Index {
    /// Order of each setting's newest record; 0 if there is none.
    pub order: [u32; COUNT],
    /// Where it stands, in words from the beginning of the half.
    place: [u16; COUNT],
    /// The newest of all.
    pub top: Claim,
    /// Sound records, those of pages too.
    pub records: u32,
    /// Of them, of numbers that no setting has.
    pub foreign: u32,
    /// Words of no sound record, in pages in use.
    pub garbage: u32,
    /// Pages with such words: bit 0 is the first page's.
    damaged: u32,
    /// Pages with such words and nothing else, as an erase leaves them that a power cut ended:
    /// what was there may be read again another time.
    pub spoilt: u32,
}

/// A part of the flash: a whole number of pages, at least two.
pub(super) struct Half<'a, F> {
    pub flash: &'a mut F,
    pub range: Range<u32>,
    /// Bytes left free before the next record: the word there may be one whose writing a
    /// power cut ended so early that it reads erased, and another time does not.
    pub gap: &'a mut u32,
}

/// [`Half::gap`] after a start.
pub(super) const GAP: u32 = WORD as u32;

impl<F: NorFlash> Half<'_, F> {
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
        let record = Claim::of(word).filter(|claim| claim.size() as u32 <= room);
        let record = record.and_then(|claim| {
            let mut bytes = [0; RECORD_MOST];
            self.flash.read(at, bytes.get_mut(..claim.size())?).ok()?;
            Record::checked(bytes)
        });
        record.map_or(Found::Garbage(word), Found::Record)
    }

    /// The count of a page in use.
    fn count(&mut self, page: u32) -> Option<u32> {
        match self.look(page) {
            Found::Record(record) if record.claim.number == PAGE => Some(record.claim.order),
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

    /// The newest records. Of two copies of one save the one in the later page counts.
    pub fn index(&mut self) -> Index {
        let mut index = Index {
            order: [0; COUNT],
            place: [0; COUNT],
            top: Claim::NONE,
            records: 0,
            foreign: 0,
            garbage: 0,
            damaged: 0,
            spoilt: 0,
        };
        for page in self.pages() {
            let (mut at, records, mut garbage) = (page, index.records, 0);
            while at < self.end_of(page) {
                let found = self.look(at);
                match &found {
                    Found::Blank => {}
                    Found::Garbage(_) => garbage += 1,
                    Found::Record(record) => self.note(&mut index, at, record.claim),
                }
                at += found.size();
            }
            if index.records > records && garbage > 0 {
                index.garbage += garbage;
                index.damaged |= self.bit(page);
            } else if garbage > 0 {
                index.spoilt |= self.bit(page);
            }
        }
        index
    }

    fn note(&mut self, index: &mut Index, at: u32, claim: Claim) {
        index.records += 1;
        if claim.number == PAGE {
            return;
        }
        if claim.order > index.top.order {
            index.top = claim;
        }
        let Some(place) = place_of(claim.number) else {
            index.foreign += 1;
            return;
        };
        let word = ((at - self.range.start) / WORD as u32) as u16;
        if let (Some(order), Some(there)) = (index.order.get_mut(place), index.place.get_mut(place))
        {
            let newer = claim.order > *order
                || claim.order == *order && {
                    let known = self.range.start + u32::from(*there) * WORD as u32;
                    let (known, this) = (self.page_of(known), self.page_of(at));
                    self.count(this) >= self.count(known)
                };
            if newer {
                (*order, *there) = (claim.order, word);
            }
        }
    }

    /// Where a setting's newest record stands.
    fn newest(&self, index: &Index, place: usize) -> Option<u32> {
        index.order.get(place).filter(|order| **order > 0)?;
        let word = index.place.get(place)?;
        Some(self.range.start + u32::from(*word) * WORD as u32)
    }

    /// A setting's newest record, and where it stands; looked at until it reads well.
    pub fn read(&mut self, index: &Index, place: usize) -> Option<(u32, Record)> {
        let at = self.newest(index, place)?;
        (0..LOOKS).find_map(|_| match self.look(at) {
            Found::Record(record) => Some((at, record)),
            _ => None,
        })
    }

    /// The newest record of a number, and where it stands.
    pub fn search(&mut self, number: u16) -> Option<(u32, Record)> {
        let mut newest: Option<(u32, Record)> = None;
        let mut at = self.range.start;
        while at < self.range.end {
            let found = self.look(at);
            if let Found::Record(record) = found
                && record.claim.number == number
            {
                let newer = newest.is_none_or(|(known, best)| {
                    let (order, most) = (record.claim.order, best.claim.order);
                    order > most
                        || order == most && {
                            let (known, this) = (self.page_of(known), self.page_of(at));
                            self.count(this) >= self.count(known)
                        }
                });
                if newer {
                    newest = Some((at, record));
                }
            }
            at += found.size();
        }
        newest
    }

    /// Whether a record is the only newest one of its number.
    fn is_needed(&mut self, index: &Index, at: u32, record: &Record) -> bool {
        match record.claim.number {
            PAGE => false,
            number => match place_of(number) {
                Some(place) => self.newest(index, place) == Some(at),
                None => self.search(number).is_some_and(|(place, _)| place == at),
            },
        }
    }

    /// The next record of a page that is needed, from a place in it on.
    pub fn next_needed(&mut self, index: &Index, from: u32) -> Option<(u32, Record)> {
        let (mut at, end) = (from, self.end_of(self.page_of(from)));
        while at < end {
            let found = self.look(at);
            if let Found::Record(record) = found
                && self.is_needed(index, at, &record)
            {
                return Some((at, record));
            }
            at += found.size();
        }
        None
    }

    /// Bytes of what is needed in a page.
    fn needed(&mut self, index: &Index, page: u32) -> u32 {
        let (mut at, end, mut bytes) = (page, self.end_of(page), 0);
        while at < end
            && let Some((there, record)) = self.next_needed(index, at)
        {
            let size = record.claim.size() as u32;
            (at, bytes) = (there + size, bytes + size);
        }
        bytes
    }

    /// Whether a word reads erased, not only once: after a power cut it may do so at times.
    fn is_erased(&mut self, at: u32) -> bool {
        (0..LOOKS).all(|_| self.look(at) == Found::Blank)
    }
}
