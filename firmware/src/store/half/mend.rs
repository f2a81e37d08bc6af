//! Mending a half at a start: what a power cut or age have left in it.

use super::{Half, Index, OWN_BYTES};
use crate::store::record::{PAGE, WORD};
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash> Half<'_, F> {
    /// Whether nothing is written in this half, but for pages' own records that may be torn:
    /// the first save of all was cut.
    pub fn is_blank(&mut self) -> bool {
        self.pages()
            .all(|page| self.next(page + OWN_BYTES, self.end_of(page)).is_none())
    }

    /// Erases pages that hold nothing but their own record: a power cut may have ended its
    /// writing, and it reads well at times.
    pub fn drop_empty_pages(&mut self) {
        for page in self.pages() {
            let (own, end) = (page + OWN_BYTES, self.end_of(page));
            if self.next(own, end).is_none()
                && !(page..own).step_by(WORD).all(|at| self.is_erased(at))
            {
                // If that fails it stays as it is.
                let _ = self.clear(page);
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
        while let Some((there, found)) = self.next(at, self.end_of(page)) {
            if let Some(record) = self.record(there) {
                before = last.replace(record);
            }
            at = there + found.size();
        }
        if let Some(record) = last.filter(|record| record.claim.number != PAGE)
            && before != last
        {
            // If that fails it stands as before.
            let _ = self.append(&record, 0);
        }
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
        Some(self.clear(page))
    }

    /// Erases a page. False if the flash says that it failed.
    pub fn clear(&mut self, page: u32) -> bool {
        self.flash.erase(page, self.end_of(page)).is_ok()
    }
}
