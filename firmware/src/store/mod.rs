//! Settings in flash, each as a record of its own that stands twice.
//!
//! Slow path. The range is two halves, each a journal of its own (`half`); every save
//! goes to the first half, then to the second. So whatever one event does, a power cut in
//! the middle of a word or an erase, a bit that flips, a page that wears out, or a half
//! that is wiped, the other half has every setting. [`Store::load`] (`start`) makes the halves
//! agree again (`both`), empties pages that hold damaged words, and says what it found by name.
//! No record has a part in another's being read.

mod both;
mod former;
mod half;
mod marks;
mod record;
mod start;

pub use marks::Marks;
pub use record::VALUE_BYTES;

use crate::board::BoxBoard;
use both::{Both, halves};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use half::GAP;
use rarma_box::settings::{
    COUNT, RecordError, Setting, SettingValue, Settings, find, from_record, to_record,
};
use record::{Record, WORD};
use start::Loading;

/// The second half opens its pages this much earlier, so that one save erases one page.
const EARLIER_BYTES: u32 = 4 * 16;
/// No place in the range: nothing is stored.
const NOWHERE: u16 = u16::MAX;

/// Why the flash did not take a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoreError {
    /// There is no room.
    Full,
    /// The flash failed.
    Flash,
    /// The range the board gives is not usable.
    Range,
}

/// How a record stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    /// In both halves.
    Twice,
    /// In one half; the other did not take it.
    Once,
}

/// What reading the store brought.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Loaded {
    /// Settings with a stored value in force.
    pub stored: u16,
    /// Settings whose record is sound but not usable: their defaults are in force.
    pub refused: Marks,
    /// Settings of which one half had no good record, or an older one. The newest is in force.
    pub repaired: Marks,
    /// Settings whose newest record is lost: an older one is in force.
    pub older: Marks,
    /// Settings whose only record is lost: their defaults are in force.
    pub defaulted: Marks,
    /// Settings that stand in one half: the other did not take them.
    pub once: Marks,
    /// Damaged words in pages in use, those of a save that a power cut ended too.
    pub damaged_words: u32,
    /// Something stood there and nothing of it is a record: all defaults are in force.
    pub lost: bool,
}

/// Where everything stands.
#[derive(Debug, Clone)]
pub struct Store {
    /// Place of a good copy of each setting's newest record, in words of the range: what is
    /// damaged elsewhere is not read again while outputs are on.
    places: [u16; COUNT],
    /// Order of the next save.
    next: u32,
    /// See [`half::Half::gap`].
    gaps: [u32; 2],
    /// Numbers stand in it that no setting has.
    foreign: bool,
}

fn place_of(number: u16) -> Option<usize> {
    find(number).map(|(place, _)| place)
}

impl Default for Store {
    fn default() -> Self {
        Self {
            places: [NOWHERE; COUNT],
            next: 1,
            gaps: [GAP; 2],
            foreign: false,
        }
    }
}

impl Store {
    /// Reads every stored setting into `settings`, and mends what a power cut or age have
    /// done. What cannot be used leaves its default; records of numbers that are not in the
    /// table are kept.
    pub fn load<F: NorFlash>(
        flash: &mut F,
        range: Range<u32>,
        settings: &mut Settings,
    ) -> (Self, Loaded) {
        let mut loading = Loading::new();
        while !loading.go_on(flash, &range, settings) {}
        (loading.store, loading.loaded)
    }

    /// [`Self::load`] from a board, whose watchdog runs.
    pub(crate) fn load_from<B: BoxBoard>(board: &mut B, settings: &mut Settings) -> (Self, Loaded) {
        let mut loading = Loading::new();
        loop {
            board.feed_watchdog();
            let (flash, range) = board.flash();
            if loading.go_on(flash, &range, settings) {
                return (loading.store, loading.loaded);
            }
        }
    }

    /// What is stored for one setting; none if nothing, or "not set".
    ///
    /// # Errors
    /// Inside: the record is there and not usable. Outside: the flash cannot be read.
    pub fn read<F: NorFlash>(
        &self,
        flash: &mut F,
        range: Range<u32>,
        setting: &Setting,
    ) -> Result<Result<Option<SettingValue>, RecordError>, StoreError> {
        let [first, second] = halves::<F>(&range)?;
        let place = place_of(setting.number).and_then(|place| self.places.get(place));
        let Some(word) = place.filter(|word| **word != NOWHERE) else {
            return Ok(Ok(None));
        };
        let at = range.start + u32::from(*word) * WORD as u32;
        let which = usize::from(!first.contains(&at));
        let mut both = Both {
            flash,
            ranges: [first, second],
            gaps: self.gaps,
        };
        let found = both.half(which).record(at);
        let its = found.filter(|record| record.claim.number == setting.number);
        // A save has moved it since, or it has aged.
        let record = its.or_else(|| both.newest(setting.number));
        let record = record.ok_or(StoreError::Flash)?;
        Ok(from_record(setting, record.value()))
    }

    /// Stores a value; with none, that the setting follows its default.
    ///
    /// A power cut at any point leaves the old record or the new one.
    ///
    /// # Errors
    /// See [`StoreError`]; the old record is still there then.
    pub fn write<F: NorFlash>(
        &mut self,
        flash: &mut F,
        range: Range<u32>,
        setting: &Setting,
        value: Option<SettingValue>,
    ) -> Result<Kept, StoreError> {
        self.put(
            flash,
            range,
            setting.number,
            to_record(setting, value).as_slice(),
        )
    }

    /// The value stored under a number, whether a setting has it or not; none if there is
    /// none. Looks at every record.
    pub fn get<F: NorFlash>(
        &self,
        flash: &mut F,
        range: Range<u32>,
        number: u16,
    ) -> Option<heapless::Vec<u8, VALUE_BYTES>> {
        let ranges = halves::<F>(&range).ok()?;
        let gaps = self.gaps;
        let record = Both {
            flash,
            ranges,
            gaps,
        }
        .newest(number)?;
        heapless::Vec::from_slice(record.value()).ok()
    }

    /// Stores 1 to [`VALUE_BYTES`] bytes under a number; [`Self::write`] for what is no
    /// number.
    ///
    /// # Errors
    /// See [`StoreError`]; the old record is still there then.
    pub fn put<F: NorFlash>(
        &mut self,
        flash: &mut F,
        range: Range<u32>,
        number: u16,
        value: &[u8],
    ) -> Result<Kept, StoreError> {
        let ranges = halves::<F>(&range)?;
        let record = Record::new(number, self.next, value).ok_or(StoreError::Full)?;
        // A save that failed may have left its order behind.
        self.next += 1;
        let gaps = self.gaps;
        let mut both = Both {
            flash,
            ranges,
            gaps,
        };
        let place = place_of(number).and_then(|place| self.places.get_mut(place));
        self.foreign |= place.is_none();
        // What takes more room than before has to have it in both halves.
        if place.as_ref().is_none_or(|there| **there == NOWHERE) {
            for which in [0, 1] {
                if !self.foreign && both.half(which).has_room_for_all() {
                    continue;
                }
                let index = both.half(which).index();
                if both.half(which).is_full(&index, &record) {
                    return Err(StoreError::Full);
                }
            }
        }
        let first = both.half(0).append(&record, 0);
        let second = both.half(1).append(&record, EARLIER_BYTES);
        self.gaps = both.gaps;
        let (at, kept) = match (first, second) {
            (Ok(at), Ok(_)) => (at, Kept::Twice),
            (Ok(at), Err(_)) | (Err(_), Ok(at)) => (at, Kept::Once),
            (Err(why), Err(_)) => return Err(why),
        };
        if let Some(there) = place {
            *there = ((at - range.start) / WORD as u32) as u16;
        }
        Ok(kept)
    }
}
