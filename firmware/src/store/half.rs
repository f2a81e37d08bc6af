//! One half of the store: a journal over the pages of its part of the flash.
//!
//! Records are found wherever they stand; the newest of a number counts. A page in use
//! begins with a record of its own that counts pages, and the greatest count is the page
//! that takes new records. When it is full, a page that holds nothing needed is erased and
//! is the next; if that was the last such page, the records that are still needed of the
//! page after it are copied first. So a page is erased only once everything in it stands
//! elsewhere, and it is erased right before it is used, whatever it reads as: an erase that
//! a power cut ended may read as a perfect one.

use super::record::{Claim, PAGE, RECORD_MOST, Record, WORD, size};
use super::{StoreError, place_of};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use rarma_core::settings::COUNT;

/// What the record of a page says: this format.
const FORMAT: &[u8] = &[2];
/// Bytes of the record of a page.
const OWN_BYTES: u32 = size(FORMAT.len()) as u32;
/// How often a save tries to find room, and pages it erases for it at most: a worn half must
/// not hold up the box for longer than its watchdog waits.
const TRIES: u32 = 3;
const ERASES: u32 = 2;
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

    /// Whether nothing is written in this half, but for pages' own records that may be torn:
    /// the first save of all was cut.
    pub fn is_blank(&mut self) -> bool {
        self.pages().all(|page| {
            let mut places = (page + OWN_BYTES..self.end_of(page)).step_by(WORD);
            places.all(|at| self.look(at) == Found::Blank)
        })
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

    /// Bytes of what is needed in a page.
    fn needed(&mut self, index: &Index, page: u32) -> u32 {
        let (mut at, mut bytes) = (page, 0);
        while at < self.end_of(page) {
            let found = self.look(at);
            if let Found::Record(record) = found
                && self.is_needed(index, at, &record)
            {
                bytes += found.size();
            }
            at += found.size();
        }
        bytes
    }

    /// Whether a word reads erased, not only once: after a power cut it may do so at times.
    fn is_erased(&mut self, at: u32) -> bool {
        (0..LOOKS).all(|_| self.look(at) == Found::Blank)
    }

    /// Writes a record behind everything in a page, keeping so much room after it. None if
    /// there is no room for one that reads as it should.
    fn put(&mut self, page: u32, record: &Record, margin: u32) -> Option<u32> {
        let (end, size) = (self.end_of(page), record.bytes().len() as u32);
        let mut at = end;
        while at > page && self.look(at - WORD as u32) == Found::Blank {
            at -= WORD as u32;
        }
        if at > page {
            at += *self.gap;
        }
        let mut failed = 0;
        while at + size + margin <= end && failed < TRIES {
            let mut words = (at..at + size).step_by(WORD);
            if let Some(unsure) = words.find(|word| !self.is_erased(*word)) {
                at = unsure + WORD as u32;
                continue;
            }
            let written = self.flash.write(at, record.bytes());
            if written.is_ok() && self.look(at) == Found::Record(*record) {
                *self.gap = 0;
                return Some(at);
            }
            // The words behind those that do not take it may.
            at += size;
            failed += 1;
        }
        None
    }

    /// Writes a record to the head, without making room.
    pub fn put_in_head(&mut self, record: &Record) -> Option<u32> {
        let (head, _) = self.head()?;
        self.put(head, record, 0)
    }

    /// Erases a page and makes it the head. False if it does not hold that.
    pub fn lay(&mut self, page: u32, count: u32) -> bool {
        let end = self.end_of(page);
        self.flash.erase(page, end).is_ok()
            && (page..end)
                .step_by(WORD)
                .all(|at| self.look(at) == Found::Blank)
            && Record::new(PAGE, count, FORMAT)
                .is_some_and(|record| self.put(page, &record, 0) == Some(page))
    }

    /// Makes a page that holds nothing needed the head, the next one around if possible.
    pub fn open(&mut self, index: &Index) -> Result<(), StoreError> {
        let head = self.head();
        let count = head.map_or(1, |(_, count)| count + 1);
        let mut tries = 0;
        // Without a head the last page counts as one, and may be used last of all.
        let last = self.range.end - Self::PAGE_BYTES;
        let from = head.map_or(last, |(page, _)| page);
        let last = head.is_none().then_some(last);
        // What an erase has left unreadable comes last.
        for sound in [true, false] {
            for page in self.others(from).chain(last) {
                if self.is_sound(page) != sound || self.needed(index, page) > 0 {
                    continue;
                }
                if self.lay(page, count) {
                    return Ok(());
                }
                tries += 1;
                if tries == ERASES {
                    return Err(StoreError::Flash);
                }
            }
        }
        Err(if tries > 0 {
            StoreError::Flash
        } else {
            StoreError::Full
        })
    }

    /// Copies what is needed of a page to the head, and notes where it is then.
    fn evacuate(&mut self, index: &mut Index, page: u32) -> Result<(), StoreError> {
        let (head, _) = self.head().ok_or(StoreError::Flash)?;
        let mut at = page;
        while at < self.end_of(page) {
            let found = self.look(at);
            if let Found::Record(record) = found
                && self.is_needed(index, at, &record)
            {
                let put = self.put(head, &record, 0).ok_or(StoreError::Flash)?;
                let word = ((put - self.range.start) / WORD as u32) as u16;
                let place = place_of(record.claim.number);
                if let Some(there) = place.and_then(|place| index.place.get_mut(place)) {
                    *there = word;
                }
            }
            at += found.size();
        }
        Ok(())
    }

    /// Whether a page is blank or has been in use, as far as its beginning tells.
    fn is_sound(&mut self, page: u32) -> bool {
        self.look(page) == Found::Blank || self.count(page).is_some()
    }

    /// Sees to it that the head is not the only page that could be used next. None if there
    /// is no way to.
    pub fn make_room(&mut self, index: &mut Index) -> Option<Room> {
        let Some((head, _)) = self.head() else {
            return Some(Room::Had);
        };
        let mut full = None;
        for page in self.others(head) {
            if self.needed(index, page) > 0 {
                full = full.or(Some(page));
            } else if self.is_sound(page) {
                return Some(Room::Had);
            }
        }
        match full {
            Some(page) => self.evacuate(index, page).ok().map(|()| Room::Made),
            // What is left is to be erased when it is used.
            None => Some(Room::Had),
        }
    }

    /// Adds a record, keeping so much room behind it while that costs nothing.
    pub fn append(&mut self, record: &Record, margin: u32) -> Result<u32, StoreError> {
        for tried in 0..TRIES {
            let margin = if tried == 0 { margin } else { 0 };
            if let Some((head, _)) = self.head()
                && let Some(at) = self.put(head, record, margin)
            {
                return Ok(at);
            }
            let index = self.index();
            if self.is_full(&index, record) {
                return Err(StoreError::Full);
            }
            self.open(&index)?;
            let mut index = self.index();
            self.make_room(&mut index);
        }
        Err(StoreError::Flash)
    }

    /// Erases pages that hold nothing but their own record: a power cut may have ended its
    /// writing, and it reads well at times.
    pub fn drop_empty_pages(&mut self) {
        for page in self.pages() {
            let (own, end) = (page + OWN_BYTES, self.end_of(page));
            let mut rest = (own..end).step_by(WORD);
            if rest.all(|at| self.look(at) == Found::Blank)
                && !(page..own).step_by(WORD).all(|at| self.is_erased(at))
            {
                // If that fails it stays as it is.
                let _ = self.flash.erase(page, end);
            }
        }
    }

    /// Writes the last record once more, unless that has been done or something was written
    /// at this start: a power cut may have ended its writing so late that it reads well now,
    /// and another time does not.
    pub fn seal(&mut self) {
        let Some((page, _)) = self.head().filter(|_| *self.gap > 0) else {
            return;
        };
        let (mut at, mut last, mut before) = (page, None, None);
        while at < self.end_of(page) {
            let found = self.look(at);
            if let Found::Record(record) = found {
                before = last.replace(record);
            }
            at += found.size();
        }
        if let Some(record) = last.filter(|record| record.claim.number != PAGE)
            && before != last
        {
            // If that fails it stands as before.
            let _ = self.append(&record, 0);
        }
    }

    /// Whether there is no room for a record, whatever is erased: one page stays free.
    pub fn is_full(&mut self, index: &Index, record: &Record) -> bool {
        let mut bytes = record.bytes().len() as u32;
        let (mut pages, mut needed) = (0, 0);
        for page in self.pages() {
            pages += 1;
            needed += self.needed(index, page);
        }
        if self.search(record.claim.number).is_some() {
            bytes = 0;
        }
        let page = Self::PAGE_BYTES - OWN_BYTES - RECORD_MOST as u32;
        needed + bytes > (pages - 1) * page
    }

    /// Empties a page with damaged words, the head after others: what is needed is copied, the
    /// page is erased. None if there is no such page, false if it did not work.
    pub fn mend(&mut self, index: &mut Index) -> Option<bool> {
        let head = self.head().map(|(page, _)| page);
        let pages = index.damaged | index.spoilt;
        let is_one = |this: &Self, page: u32| pages & this.bit(page) != 0;
        let other = self
            .pages()
            .find(|page| is_one(self, *page) && Some(*page) != head);
        let page = other.or(head.filter(|page| is_one(self, *page)))?;
        let rest = !self.bit(page);
        (index.damaged, index.spoilt) = (index.damaged & rest, index.spoilt & rest);
        if self.needed(index, page) > 0 {
            let opened = self.open(index).is_ok();
            let head = self.head().map(|(page, _)| page);
            // Without a free page there is one that a power cut kept from being filled.
            if !opened && head == Some(page) || self.evacuate(index, page).is_err() {
                return Some(false);
            }
        }
        Some(self.flash.erase(page, self.end_of(page)).is_ok())
    }

    /// Erases a page beside the head. Only while the other half has everything.
    pub fn give_up(&mut self) -> bool {
        let Some((head, _)) = self.head() else {
            return false;
        };
        let page = self.others(head).next();
        page.is_some_and(|page| self.flash.erase(page, self.end_of(page)).is_ok())
    }
}
