//! What one look through a half has found: the newest record of each number.

use super::{Found, Half};
use crate::store::place_of;
use crate::store::record::{Claim, PAGE, WORD};
use embedded_storage::nor_flash::NorFlash;
use rarma_box::settings::COUNT;

/// Numbers that no setting has, a later firmware's, for which there is a place in an index.
const FOREIGN: usize = 32;
const PLACES: usize = COUNT + FOREIGN;

/// The newest records of a half.
#[derive(Debug, Clone)]
pub(in crate::store) struct Index {
    /// Order of each setting's newest record, then of each foreign number's; 0 if there is none.
    order: [u32; PLACES],
    /// Where it stands, in words from the beginning of the half.
    word: [u16; PLACES],
    /// Bytes it takes.
    size: [u8; PLACES],
    /// The foreign numbers, in the order in which they were found.
    foreign: heapless::Vec<u16, FOREIGN>,
    /// The newest of all.
    pub top: Claim,
    /// Sound records, those of pages too.
    pub records: u32,
    /// Of them, of foreign numbers for which there is no place: they are looked for in the flash.
    beyond: u32,
    /// Words of no sound record, in pages in use.
    pub garbage: u32,
    /// Pages with such words: bit 0 is the first page's.
    pub damaged: u32,
    /// Pages with such words and nothing else, as an erase leaves them that a power cut ended:
    /// what was there may be read again another time.
    pub spoilt: u32,
}

impl Index {
    const BLANK: Self = Self {
        order: [0; PLACES],
        word: [0; PLACES],
        size: [0; PLACES],
        foreign: heapless::Vec::new(),
        top: Claim::NONE,
        records: 0,
        beyond: 0,
        garbage: 0,
        damaged: 0,
        spoilt: 0,
    };

    /// The place of a number; settings have the first ones, in their order.
    fn place(&self, number: u16) -> Option<usize> {
        place_of(number).or_else(|| {
            let foreign = self.foreign.iter().position(|other| *other == number);
            foreign.map(|n| COUNT + n)
        })
    }

    /// Orders of the settings' newest records; 0 if there is none.
    pub fn orders(&self) -> impl Iterator<Item = u32> {
        self.order.into_iter().take(COUNT)
    }

    /// Order of a setting's newest record; 0 if there is none.
    pub fn order(&self, place: usize) -> u32 {
        self.order.get(place).copied().unwrap_or(0)
    }

    /// Whether numbers stand there that no setting has.
    pub fn has_foreign(&self) -> bool {
        !self.foreign.is_empty()
    }

    /// The newest record of a number now stands at this word.
    pub fn moved(&mut self, number: u16, word: u16) {
        let place = self.place(number);
        if let Some(known) = place.and_then(|place| self.word.get_mut(place)) {
            *known = word;
        }
    }
}

impl<F: NorFlash> Half<'_, F> {
    /// The newest records. Of two copies of one save the one in the later page counts.
    pub fn index(&mut self) -> Index {
        let mut index = Index::BLANK;
        for page in self.pages() {
            let (mut at, records, mut garbage) = (page, index.records, 0);
            while let Some((there, found)) = self.next(at, self.end_of(page)) {
                match &found {
                    Found::Record(claim) => self.note(&mut index, there, *claim),
                    _ => garbage += 1,
                }
                at = there + found.size();
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

    /// Notes a record that stands there.
    pub fn note(&mut self, index: &mut Index, at: u32, claim: Claim) {
        index.records += 1;
        if claim.number == PAGE {
            return;
        }
        if claim.order > index.top.order {
            index.top = claim;
        }
        let place = index.place(claim.number).or_else(|| {
            index.foreign.push(claim.number).ok()?;
            Some(COUNT + index.foreign.len() - 1)
        });
        let Some(place) = place else {
            index.beyond += 1;
            return;
        };
        let word = self.word(at);
        if let (Some(order), Some(there), Some(size)) = (
            index.order.get_mut(place),
            index.word.get_mut(place),
            index.size.get_mut(place),
        ) {
            let newer = claim.order > *order
                || claim.order == *order && {
                    let known = self.range.start + u32::from(*there) * WORD as u32;
                    let (known, this) = (self.page_of(known), self.page_of(at));
                    self.count(this) >= self.count(known)
                };
            if newer {
                (*order, *there, *size) = (claim.order, word, claim.size() as u8);
            }
        }
    }

    /// A place in the flash, in words from the beginning of the half.
    pub fn word(&self, at: u32) -> u16 {
        ((at - self.range.start) / WORD as u32) as u16
    }

    /// Where the newest record of a place of the index stands.
    pub fn newest(&self, index: &Index, place: usize) -> Option<u32> {
        index.order.get(place).filter(|order| **order > 0)?;
        let word = index.word.get(place)?;
        Some(self.range.start + u32::from(*word) * WORD as u32)
    }

    /// Where the newest record of a number stands, and its order.
    pub fn find(&mut self, index: &Index, number: u16) -> Option<(u32, u32)> {
        match index.place(number) {
            Some(place) => Some((self.newest(index, place)?, index.order(place))),
            None if index.beyond == 0 => None,
            None => {
                let found = self.search(number);
                found.map(|(at, claim)| (at, claim.order))
            }
        }
    }

    /// Whether a record is the only newest one of its number.
    fn is_needed(&mut self, index: &Index, at: u32, claim: Claim) -> bool {
        claim.number != PAGE
            && self
                .find(index, claim.number)
                .is_some_and(|(newest, _)| newest == at)
    }

    /// The next record of a page that is needed, from a place in it on.
    pub fn next_needed(&mut self, index: &Index, from: u32) -> Option<(u32, Claim)> {
        let (mut at, end) = (from, self.end_of(self.page_of(from)));
        while let Some((there, found)) = self.next(at, end) {
            if let Found::Record(claim) = found
                && self.is_needed(index, there, claim)
            {
                return Some((there, claim));
            }
            at = there + found.size();
        }
        None
    }

    /// Bytes of what is needed in a page.
    pub fn needed(&mut self, index: &Index, page: u32) -> u32 {
        let in_page = page..self.end_of(page);
        let known = (0..).zip(index.size).filter_map(|(place, size)| {
            let at = self.newest(index, place)?;
            in_page.contains(&at).then_some(u32::from(size))
        });
        let mut bytes = known.sum();
        let mut at = page;
        while index.beyond > 0
            && let Some((there, found)) = self.next(at, in_page.end)
        {
            if let Found::Record(claim) = found
                && index.place(claim.number).is_none()
                && self.is_needed(index, there, claim)
            {
                bytes += found.size();
            }
            at = there + found.size();
        }
        bytes
    }
}
