//! Writing records to a half, and the pages they go to.

use super::{FORMAT, Found, Half, Index, OWN_BYTES, Room};
use crate::store::StoreError;
use crate::store::record::{PAGE, RECORD_MOST, Record, WORD};
use embedded_storage::nor_flash::NorFlash;
use rarma_box::settings::COUNT;

/// How often a save tries to find room, and pages it erases for it at most: a worn half must
/// not hold up the box for longer than its watchdog waits.
const TRIES: u32 = 3;
const ERASES: u32 = 2;

impl<F: NorFlash> Half<'_, F> {
    /// Writes a record behind everything in a page, keeping so much room after it. None if
    /// there is no room for one that reads as it should.
    fn put(&mut self, page: u32, record: &Record, margin: u32) -> Option<u32> {
        let (end, size) = (self.end_of(page), record.bytes().len() as u32);
        let mut at = self.end_of_written(page);
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
            if written.is_ok() && self.record(at) == Some(*record) {
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
            && self.next(page, end).is_none()
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
    pub fn evacuate(&mut self, index: &mut Index, page: u32) -> Result<(), StoreError> {
        let (head, _) = self.head().ok_or(StoreError::Flash)?;
        let (mut at, end) = (page, self.end_of(page));
        while at < end
            && let Some((there, claim)) = self.next_needed(index, at)
        {
            let record = self.reread(there).ok_or(StoreError::Flash)?;
            let put = self.put(head, &record, 0).ok_or(StoreError::Flash)?;
            index.moved(claim.number, self.word(put));
            at = there + claim.size() as u32;
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
            let mut index = self.index();
            if self.is_full(&index, record) {
                return Err(StoreError::Full);
            }
            self.open(&index)?;
            self.make_room(&mut index);
        }
        Err(StoreError::Flash)
    }

    /// Whether there is no room for a record, whatever is erased: one page stays free.
    pub fn is_full(&mut self, index: &Index, record: &Record) -> bool {
        let mut bytes = record.bytes().len() as u32;
        let needed = self.pages().map(|page| self.needed(index, page));
        let needed: u32 = needed.sum();
        if self.find(index, record.claim.number).is_some() {
            bytes = 0;
        }
        needed + bytes > self.room()
    }

    /// Whether every setting there is has room, where nothing else stands.
    pub fn has_room_for_all(&self) -> bool {
        (COUNT * RECORD_MOST) as u32 <= self.room()
    }

    /// Bytes that records can take.
    fn room(&self) -> u32 {
        let page = Self::PAGE_BYTES - OWN_BYTES - RECORD_MOST as u32;
        (self.pages().count() as u32 - 1) * page
    }
}
