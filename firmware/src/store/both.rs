//! Both halves of the store, and how they come to hold the same.

use super::half::{Found, Half, Index};
use super::record::{Claim, PAGE, Record};
use super::{Loaded, StoreError, place_of};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;

/// The range in two halves of whole pages, at least two each.
pub(super) fn halves<F: NorFlash>(range: &Range<u32>) -> Result<[Range<u32>; 2], StoreError> {
    let page = F::ERASE_SIZE as u32;
    let pages = range.end.saturating_sub(range.start) / page;
    if pages < 4 || !range.start.is_multiple_of(page) {
        return Err(StoreError::Range);
    }
    let middle = range.start + pages / 2 * page;
    Ok([range.start..middle, middle..middle + pages / 2 * page])
}

/// Both halves while they are being read and mended.
pub(super) struct Both<'a, F> {
    pub flash: &'a mut F,
    pub ranges: [Range<u32>; 2],
    /// See [`Half::gap`].
    pub gaps: [u32; 2],
}

impl<F: NorFlash> Both<'_, F> {
    pub fn half(&mut self, which: usize) -> Half<'_, F> {
        let [first, second] = &self.ranges;
        let [gap, other] = &mut self.gaps;
        let (range, gap) = if which == 0 {
            (first, gap)
        } else {
            (second, other)
        };
        Half::new(&mut *self.flash, range.clone(), gap)
    }

    pub fn indices(&mut self) -> [Index; 2] {
        [self.half(0).index(), self.half(1).index()]
    }

    /// The newest record of a number.
    pub fn newest(&mut self, number: u16) -> Option<Record> {
        let first = self.half(0).search(number).map(|found| (0, found));
        let second = self.half(1).search(number).map(|found| (1, found));
        let found = [first, second].into_iter().flatten();
        let (which, (at, _)) = found.max_by_key(|(_, (_, claim))| claim.order)?;
        self.half(which).reread(at)
    }

    /// Copies what one half has and the other lacks. True if there was such a thing and every
    /// copy was taken; once one was not, nothing more is tried at this start.
    pub fn level(&mut self, [first, second]: &[Index; 2], loaded: &mut Loaded) -> bool {
        let mut differed = false;
        let mut refuses = false;
        for (place, orders) in first.orders().zip(second.orders()).enumerate() {
            let (from, index) = match orders {
                (a, b) if a == b => continue,
                (a, b) if a > b => (0, first),
                _ => (1, second),
            };
            differed = true;
            // What read well just now may not a moment later.
            let Some((_, record)) = self.half(from).read(index, place) else {
                continue;
            };
            if refuses {
                loaded.once.add(place);
            } else if self.half(1 - from).append(&record, 0).is_ok() {
                loaded.repaired.add(place);
            } else {
                loaded.once.add(place);
                refuses = true;
            }
        }
        differed && !refuses
    }

    /// The same for numbers that no setting has: a later firmware's, to be kept.
    pub fn level_foreign(&mut self) {
        for from in [0, 1] {
            let [first, second] = self.indices();
            let (index, mut other) = if from == 0 {
                (first, second)
            } else {
                (second, first)
            };
            let (mut at, end) = (self.half(from).range.start, self.half(from).range.end);
            while let Some((this, found)) = self.half(from).next(at, end) {
                at = this + found.size();
                let Found::Record(claim) = found else {
                    continue;
                };
                let number = claim.number;
                if number == PAGE || place_of(number).is_some() {
                    continue;
                }
                let newest = self.half(from).find(&index, number);
                let there = self.half(1 - from).find(&other, number);
                let lacks = there.is_none_or(|(_, order)| order < claim.order);
                if lacks
                    && newest.is_some_and(|(newest, _)| newest == this)
                    && let Some(record) = self.half(from).reread(this)
                {
                    let mut half = self.half(1 - from);
                    // If that fails it stands once, as before.
                    if let Ok(at) = half.append(&record, 0) {
                        half.note(&mut other, at, claim);
                    }
                }
            }
        }
    }

    /// Erases a page of a half that has no room left, because the pages it could use are worn:
    /// one that holds something, all of which the other half has. False if there is none.
    pub fn give_up(&mut self, which: usize, [first, second]: &[Index; 2]) -> bool {
        let (index, other) = if which == 0 {
            (first, second)
        } else {
            (second, first)
        };
        for page in self.half(which).beside_head() {
            let (mut at, end) = (page, page + F::ERASE_SIZE as u32);
            let (mut holds, mut stands) = (false, true);
            while at < end
                && stands
                && let Some((there, claim)) = self.half(which).next_needed(index, at)
            {
                let found = self.half(1 - which).find(other, claim.number);
                let order = found.map(|(_, order)| order);
                (holds, stands) = (true, order >= Some(claim.order));
                at = there + claim.size() as u32;
            }
            if holds && stands {
                return self.half(which).clear(page);
            }
        }
        false
    }

    /// Whether any word of a half begins with this claim, as a sound record or not.
    fn holds(&mut self, which: usize, is: impl Fn(Claim, bool) -> bool) -> bool {
        let mut half = self.half(which);
        let (mut at, end) = (half.range.start, half.range.end);
        while let Some((there, found)) = half.next(at, end) {
            let hit = match found {
                Found::Blank => false,
                Found::Garbage(word) => Claim::of(word).is_some_and(|claim| is(claim, false)),
                Found::Record(claim) => is(claim, true),
            };
            if hit {
                return true;
            }
            at = there + found.size();
        }
        false
    }

    /// Names settings of which a damaged record is newer than every good one. What it says
    /// of itself is believed if it is an order that was given and no other record has it; of
    /// an order after all others if both halves say it, for a save that a power cut ended
    /// has not come to the second half unless it is good in the first.
    pub fn fallen(&mut self, [first, second]: &[Index; 2], loaded: &mut Loaded) {
        let top = first.top.order.max(second.top.order);
        for which in [0, 1] {
            let (mut at, end) = (self.half(which).range.start, self.half(which).range.end);
            while let Some((there, found)) = self.half(which).next(at, end) {
                at = there + found.size();
                let Found::Garbage(word) = found else {
                    continue;
                };
                let Some(claim) = Claim::of(word) else {
                    continue;
                };
                let Some(place) = place_of(claim.number) else {
                    continue;
                };
                let best = first.order(place).max(second.order(place));
                if claim.order <= best {
                    continue;
                }
                let believed = if claim.order > top {
                    self.holds(1 - which, |other, sound| !sound && other == claim)
                } else {
                    let other = |other: Claim, sound: bool| {
                        sound && other.order == claim.order && other.number != PAGE
                    };
                    !self.holds(0, other) && !self.holds(1, other)
                };
                match (believed, best) {
                    (false, _) => {}
                    (true, 0) => loaded.defaulted.add(place),
                    (true, _) => loaded.older.add(place),
                }
            }
        }
    }
}
