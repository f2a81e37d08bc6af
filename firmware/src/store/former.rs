//! Settings of the store before this one, read once and taken over.
//!
//! That store (firmware 0.1 until then) was the map of `sequential-storage` 8. Its pages
//! begin with a word of zeros and end with one once they are full; in between are items:
//! CRC-32C of the data, length, CRC-16 of the length, then the number and the value.

use super::half::{GAP, Half};
use super::record::{Record, VALUE_BYTES, WORD};
use super::{StoreError, halves, place_of};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use rarma_box::settings::{COUNT, SETTINGS};

/// The record that said that the range was a store.
const FORMAT_KEY: u16 = 0;
/// Bits of a marker's word that are zero, of 64; some may have aged.
const MARKED: u32 = 60;

/// The range as the former store left it.
struct Former<'a, F> {
    flash: &'a mut F,
    range: Range<u32>,
}

/// An item whose checks hold: its number and value.
struct Item {
    number: u16,
    length: usize,
    bytes: [u8; VALUE_BYTES + WORD],
}

impl Item {
    fn value(&self) -> &[u8] {
        self.bytes.get(2..2 + self.length).unwrap_or_default()
    }
}

impl<F: NorFlash> Former<'_, F> {
    fn word(&mut self, at: u32) -> [u8; WORD] {
        let mut word = [0xFF; WORD];
        // What cannot be read is no item: its checks do not hold.
        let _ = self.flash.read(at, &mut word);
        word
    }

    fn is_marked(&mut self, at: u32) -> bool {
        u64::from_le_bytes(self.word(at)).count_zeros() >= MARKED
    }

    fn page(&self, number: u32) -> u32 {
        self.range.start + number * F::ERASE_SIZE as u32
    }

    fn count(&self) -> u32 {
        (self.range.end - self.range.start) / F::ERASE_SIZE as u32
    }

    fn end(page: u32) -> u32 {
        page + F::ERASE_SIZE as u32 - WORD as u32
    }

    /// The page after the one that was written last: from it around they are in order.
    fn first(&mut self) -> u32 {
        let open = (0..self.count()).find(|&k| {
            let page = self.page(k);
            self.is_marked(page) && !self.is_marked(Self::end(page))
        });
        let blank = (0..self.count()).find(|&k| !self.is_marked(self.page(k)));
        open.map_or(blank.unwrap_or(0), |k| (k + 1) % self.count())
    }

    /// Every sound item, the oldest first, with its address.
    fn each(&mut self, mut take: impl FnMut(u32, &Item)) {
        let (first, count) = (self.first(), self.count());
        for k in 0..count {
            let page = self.page((first + k) % count);
            if !self.is_marked(page) {
                continue;
            }
            let mut at = page + WORD as u32;
            while at < Self::end(page) {
                let (item, size) = self.item(at, Self::end(page));
                if let Some(item) = item {
                    take(at, &item);
                }
                at += size;
            }
        }
    }

    /// The item at an address, and how far the next one is.
    fn item(&mut self, at: u32, end: u32) -> (Option<Item>, u32) {
        let [a, b, c, d, e, f, g, h] = self.word(at);
        let length = usize::from(u16::from_le_bytes([e, f]));
        let size = (WORD + length.next_multiple_of(WORD)) as u32;
        if crc16(&[e, f]) != u16::from_le_bytes([g, h]) || size > end - at {
            return (None, WORD as u32);
        }
        let mut read = || {
            let mut bytes = [0; VALUE_BYTES + WORD];
            let data = bytes.get_mut(..length.next_multiple_of(WORD))?;
            self.flash.read(at + WORD as u32, data).ok()?;
            let sound = crc32(bytes.get(..length)?) == u32::from_le_bytes([a, b, c, d]);
            let [low, high, ..] = bytes;
            sound.then_some(Item {
                number: u16::from_le_bytes([low, high]),
                length: length.checked_sub(2)?,
                bytes,
            })
        };
        (read(), size)
    }

    /// The newest item of every setting, 0 if there is none.
    fn newest(&mut self) -> [u32; COUNT] {
        let mut newest = [0; COUNT];
        self.each(|at, item| {
            if let Some(there) = place_of(item.number).and_then(|k| newest.get_mut(k)) {
                *there = at;
            }
        });
        newest
    }

    /// A page that can be erased without losing a setting: one that holds no items, or else
    /// none that counts. The former store keeps one of the first kind.
    fn free(&mut self, newest: &[u32; COUNT]) -> Option<u32> {
        let mut unneeded = None;
        for k in 0..self.count() {
            let page = self.page(k);
            if !self.is_marked(page) {
                return Some(page);
            }
            if !newest.iter().any(|at| (page..Self::end(page)).contains(at)) {
                unneeded = unneeded.or(Some(page));
            }
        }
        unneeded
    }
}

/// Whether a page is one of the former store's.
pub(super) fn is_former<F: NorFlash>(flash: &mut F, page: u32) -> bool {
    let range = page..page + F::ERASE_SIZE as u32;
    Former { flash, range }.is_marked(page)
}

/// Takes over what the former store holds and this one does not; a power cut in between
/// leaves the former, and the rest is taken over at the next start.
///
/// # Errors
/// There is no page for it, or the flash failed; what is taken over stands.
pub(super) fn take_over<F: NorFlash>(flash: &mut F, range: Range<u32>) -> Result<(), StoreError> {
    let mut former = Former {
        flash: &mut *flash,
        range: range.clone(),
    };
    let newest = former.newest();
    let free = former.free(&newest);
    let parts = halves::<F>(&range)?;
    let mut known = [0; COUNT];
    let (mut top, mut own, mut gap) = (0, None, GAP);
    for part in &parts {
        let mut half = Half::new(&mut *flash, part.clone(), &mut gap);
        let index = half.index();
        for (known, order) in known.iter_mut().zip(index.orders()) {
            *known = order.max(*known);
        }
        top = index.top.order.max(top);
        if index.records > 0 {
            own = own.or(Some(part.clone()));
        }
    }
    let begun = own.is_some();
    let page = free.filter(|_| !begun);
    let part = own.or_else(|| {
        parts
            .into_iter()
            .find(|part| page.is_some_and(|p| part.contains(&p)))
    });
    let part = part.ok_or(StoreError::Full)?;
    if let Some(page) = page {
        let mut half = Half::new(&mut *flash, part.clone(), &mut gap);
        if !half.lay(page, 1) {
            return Err(StoreError::Flash);
        }
    }
    // The last one taken over may be one whose writing was cut, and is taken once more.
    let last = top;
    for ((setting, at), known) in SETTINGS.iter().zip(newest).zip(known) {
        if at == 0 || known > 0 && known != last {
            continue;
        }
        top += 1;
        move_item(flash, &range, &part, setting.number, at, top, &mut gap)?;
    }
    // Numbers of no setting: a later firmware's, to be kept. There are few or none.
    let mut from = 0;
    while let Some((number, at)) = next_foreign(flash, &range, from) {
        from = at + 1;
        let mut known = false;
        for part in halves::<F>(&range)? {
            let mut half = Half::new(&mut *flash, part, &mut gap);
            known |= half
                .search(number)
                .is_some_and(|(_, claim)| claim.order != last);
        }
        if !known {
            top += 1;
            move_item(flash, &range, &part, number, at, top, &mut gap)?;
        }
    }
    Ok(())
}

fn move_item<F: NorFlash>(
    flash: &mut F,
    range: &Range<u32>,
    part: &Range<u32>,
    number: u16,
    at: u32,
    order: u32,
    gap: &mut u32,
) -> Result<(), StoreError> {
    let mut former = Former {
        flash: &mut *flash,
        range: range.clone(),
    };
    let (item, _) = former.item(at, range.end);
    let record = item.and_then(|item| Record::new(number, order, item.value()));
    let mut half = Half::new(flash, part.clone(), gap);
    record
        .and_then(|record| half.put_in_head(&record))
        .map(|_| ())
        .ok_or(StoreError::Flash)
}

/// The first item from an address on that is the newest of a number that no setting has.
fn next_foreign<F: NorFlash>(flash: &mut F, range: &Range<u32>, from: u32) -> Option<(u16, u32)> {
    let mut former = Former {
        flash,
        range: range.clone(),
    };
    let mut candidate = from;
    loop {
        let mut number = None;
        former.each(|at, item| {
            let foreign = item.number != FORMAT_KEY && place_of(item.number).is_none();
            if at >= candidate && foreign && number.is_none_or(|(_, first)| at < first) {
                number = Some((item.number, at));
            }
        });
        let (number, at) = number?;
        let mut last = at;
        former.each(|at, item| {
            if item.number == number {
                last = at;
            }
        });
        if last == at {
            return Some((number, at));
        }
        candidate = at + 1;
    }
}

/// The crate's own CRC-16 of a length.
fn crc16(bytes: &[u8]) -> u16 {
    let crc = bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| {
            crc >> 1 ^ if crc & 1 == 1 { 0x1A2E } else { 0 }
        })
    });
    match !crc {
        0xFFFF => 0xFFFE,
        crc => crc,
    }
}

/// CRC-32C from the crate's own beginning; two ends it does not use are moved aside.
fn crc32(bytes: &[u8]) -> u32 {
    let crc = bytes.iter().fold(0xEEEE_EEEE, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            crc >> 1 ^ if crc & 1 == 1 { 0x82F6_3B78 } else { 0 }
        })
    });
    match !crc {
        0 => 1,
        crc if matches!(crc as u8, 0 | 0xFF) => crc ^ 1,
        crc => crc,
    }
}
