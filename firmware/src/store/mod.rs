//! Settings in flash, each as a record of its own that stands twice.
//!
//! Slow path. The range is two halves, each a journal of its own (`half`); every save
//! goes to the first half, then to the second. So whatever one event does, a power cut in
//! the middle of a word or an erase, a bit that flips, a page that wears out, or a half
//! that is wiped, the other half has every setting. [`Store::load`] makes the halves agree again,
//! empties pages that hold damaged words, and says what it found by name. No record has a
//! part in another's being read.

mod former;
mod half;
mod marks;
mod record;

pub use marks::Marks;
pub use record::VALUE_BYTES;

use crate::board::BoxBoard;
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use half::{Found, GAP, Half, Index, Room};
use rarma_core::settings::{
    COUNT, RecordError, SETTINGS, Setting, SettingValue, Settings, find, from_record, to_record,
};
use record::{Claim, PAGE, Record, WORD};

/// The second half opens its pages this much earlier, so that one save erases one page.
const EARLIER_BYTES: u32 = 4 * 16;
/// How often the halves are made to agree before the rest is left to the next start.
const ROUNDS: u32 = 4;
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
    /// See [`Half::gap`].
    gaps: [u32; 2],
}

fn place_of(number: u16) -> Option<usize> {
    find(number).map(|(place, _)| place)
}

/// The range in two halves of whole pages, at least two each.
fn halves<F: NorFlash>(range: &Range<u32>) -> Result<[Range<u32>; 2], StoreError> {
    let page = F::ERASE_SIZE as u32;
    let pages = range.end.saturating_sub(range.start) / page;
    if pages < 4 || !range.start.is_multiple_of(page) {
        return Err(StoreError::Range);
    }
    let middle = range.start + pages / 2 * page;
    Ok([range.start..middle, middle..middle + pages / 2 * page])
}

/// Both halves while they are being read and mended.
struct Both<'a, F> {
    flash: &'a mut F,
    ranges: [Range<u32>; 2],
    gaps: [u32; 2],
}

impl<F: NorFlash> Both<'_, F> {
    fn half(&mut self, which: usize) -> Half<'_, F> {
        let [first, second] = &self.ranges;
        let [gap, other] = &mut self.gaps;
        let (range, gap) = if which == 0 {
            (first, gap)
        } else {
            (second, other)
        };
        Half {
            range: range.clone(),
            flash: &mut *self.flash,
            gap,
        }
    }

    fn indices(&mut self) -> [Index; 2] {
        [self.half(0).index(), self.half(1).index()]
    }

    /// The newest record of a number.
    fn newest(&mut self, number: u16) -> Option<Record> {
        let first = self.half(0).search(number);
        let second = self.half(1).search(number);
        let records = [first, second].into_iter().flatten();
        let newest = records.max_by_key(|(_, record)| record.claim.order);
        newest.map(|(_, record)| record)
    }

    /// Copies what one half has and the other lacks. True if there was such a thing and every
    /// copy was taken; once one was not, nothing more is tried at this start.
    fn level(&mut self, [first, second]: &[Index; 2], loaded: &mut Loaded) -> bool {
        let mut differed = false;
        let mut refuses = false;
        for (place, orders) in first.order.into_iter().zip(second.order).enumerate() {
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
    fn level_foreign(&mut self) {
        for from in [0, 1] {
            let (mut at, end) = (self.half(from).range.start, self.half(from).range.end);
            while at < end {
                let found = self.half(from).look(at);
                let this = at;
                at += found.size();
                let Found::Record(record) = found else {
                    continue;
                };
                let number = record.claim.number;
                if number == PAGE || place_of(number).is_some() {
                    continue;
                }
                let newest = self.half(from).search(number);
                let there = self.half(1 - from).search(number);
                let lacks = there.is_none_or(|(_, r)| r.claim.order < record.claim.order);
                if lacks && newest.is_some_and(|(newest, _)| newest == this) {
                    // It stands once then, as before.
                    let _ = self.half(1 - from).append(&record, 0);
                }
            }
        }
    }

    /// Whether any word of a half begins with this claim, as a sound record or not.
    fn holds(&mut self, which: usize, is: impl Fn(Claim, bool) -> bool) -> bool {
        let mut half = self.half(which);
        let (mut at, end) = (half.range.start, half.range.end);
        while at < end {
            let found = half.look(at);
            let hit = match found {
                Found::Blank => false,
                Found::Garbage(word) => Claim::of(word).is_some_and(|claim| is(claim, false)),
                Found::Record(record) => is(record.claim, true),
            };
            if hit {
                return true;
            }
            at += found.size();
        }
        false
    }

    /// Names settings of which a damaged record is newer than every good one. What it says
    /// of itself is believed if it is an order that was given and no other record has it; of
    /// an order after all others if both halves say it, for a save that a power cut ended
    /// has not come to the second half unless it is good in the first.
    fn fallen(&mut self, [first, second]: &[Index; 2], loaded: &mut Loaded) {
        let top = first.top.order.max(second.top.order);
        for which in [0, 1] {
            let (mut at, end) = (self.half(which).range.start, self.half(which).range.end);
            while at < end {
                let found = self.half(which).look(at);
                at += found.size();
                let Found::Garbage(word) = found else {
                    continue;
                };
                let Some(claim) = Claim::of(word) else {
                    continue;
                };
                let Some(place) = place_of(claim.number) else {
                    continue;
                };
                let best = |index: &Index| index.order.get(place).copied().unwrap_or(0);
                let best = best(first).max(best(second));
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

/// One stretch of reading a store; between two of them the watchdog can be fed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// The halves are made to agree.
    Agree,
    /// A page of a half with damaged words is emptied, as what was agreed on says: words there
    /// may read differently by now.
    Clear(usize),
    /// One page is emptied, or erased.
    Tidy,
    /// Values are read.
    Take,
}

/// Reading a store, step by step.
#[derive(Debug)]
struct Loading {
    step: Step,
    store: Store,
    loaded: Loaded,
    /// What the halves agreed on.
    agreed: Option<[Index; 2]>,
    tidied: u32,
}

impl Loading {
    fn new() -> Self {
        Self {
            step: Step::Agree,
            store: Store::default(),
            loaded: Loaded::default(),
            agreed: None,
            tidied: 0,
        }
    }

    /// One step: two erases, and two more if pages are worn. True once it was the last.
    fn go_on<F: NorFlash>(
        &mut self,
        flash: &mut F,
        range: &Range<u32>,
        settings: &mut Settings,
    ) -> bool {
        let Ok(ranges) = halves::<F>(range) else {
            return true;
        };
        let gaps = self.store.gaps;
        let mut both = Both {
            flash,
            ranges,
            gaps,
        };
        match self.step {
            Step::Agree => {
                self.agreed = agree(&mut both, range, &mut self.loaded);
                self.step = match self.agreed {
                    Some(_) => Step::Clear(0),
                    None => Step::Take,
                };
            }
            Step::Clear(which) => {
                let index = self
                    .agreed
                    .as_mut()
                    .and_then(|agreed| agreed.get_mut(which));
                let more = index.and_then(|index| both.half(which).mend(index));
                self.step = if more.is_some() {
                    Step::Clear(which)
                } else {
                    both.half(which).seal();
                    if which == 0 {
                        Step::Clear(1)
                    } else {
                        Step::Tidy
                    }
                };
            }
            Step::Tidy => {
                self.tidied += 1;
                let pages = (range.end - range.start) / F::ERASE_SIZE as u32;
                // A page that cannot be mended is left alone in the end.
                if !tidy(&mut both, range) || self.tidied > pages {
                    self.step = Step::Take;
                }
            }
            Step::Take => {
                self.store
                    .take(&mut both, range, settings, &mut self.loaded);
                return true;
            }
        }
        self.store.gaps = both.gaps;
        false
    }
}

/// Makes the halves agree and names what was damaged. With what they agreed on the pages where
/// the last save may have been cut are emptied: from then on nothing reads differently
/// another time. None if nothing is stored.
fn agree<F: NorFlash>(
    both: &mut Both<'_, F>,
    range: &Range<u32>,
    loaded: &mut Loaded,
) -> Option<[Index; 2]> {
    let pages = || range.clone().step_by(F::ERASE_SIZE);
    if pages().any(|page| former::is_former(both.flash, page)) {
        loaded.lost = former::take_over(both.flash, range.clone()).is_err();
        if loaded.lost {
            // It is left as it is; another start may have more luck.
            return None;
        }
    }
    both.half(0).drop_empty_pages();
    both.half(1).drop_empty_pages();
    let mut indices = both.indices();
    if indices.iter().all(|index| index.records == 0) {
        if both.half(0).is_blank() && both.half(1).is_blank() {
            return None;
        }
        loaded.lost = true;
        // If that fails so does every save, and is told.
        let [first, _] = &indices;
        let _ = both.half(0).open(first);
        indices = both.indices();
    }
    loaded.damaged_words = indices.iter().map(|index| index.garbage).sum();
    for _ in 0..ROUNDS {
        if !both.level(&indices, loaded) {
            break;
        }
        indices = both.indices();
    }
    if indices.iter().any(|index| index.foreign > 0) {
        both.level_foreign();
    }
    // What is damaged in one half only stands in the other, if it did before.
    if indices.iter().all(|index| index.garbage > 0) || !loaded.once.is_empty() {
        both.fallen(&indices, loaded);
    }
    Some(indices)
}

/// Empties one page that holds damaged words or is the former store's, or sees to it that
/// there is a free one. False if there is nothing to do.
fn tidy<F: NorFlash>(both: &mut Both<'_, F>, range: &Range<u32>) -> bool {
    for which in [0, 1] {
        let mut indices = both.indices();
        let complete = indices[0].order == indices[1].order;
        let Some(index) = indices.get_mut(which) else {
            continue;
        };
        // Those have been erased, and read as before: they are worn.
        index.spoilt = 0;
        let mut half = both.half(which);
        if half.mend(index) == Some(true) {
            return true;
        }
        match half.make_room(index) {
            Some(Room::Had) => {}
            Some(Room::Made) => return true,
            None if complete && half.give_up() => {
                // The other half has it all.
                let indices = both.indices();
                both.level(&indices, &mut Loaded::default());
                both.level_foreign();
                return true;
            }
            None => {}
        }
    }
    let mut pages = range.clone().step_by(F::ERASE_SIZE);
    let former = pages.find(|page| former::is_former(both.flash, *page));
    former.is_some_and(|page| both.flash.erase(page, page + F::ERASE_SIZE as u32).is_ok())
}

impl Default for Store {
    fn default() -> Self {
        Self {
            places: [NOWHERE; COUNT],
            next: 1,
            gaps: [GAP; 2],
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

    fn take<F: NorFlash>(
        &mut self,
        both: &mut Both<'_, F>,
        range: &Range<u32>,
        settings: &mut Settings,
        loaded: &mut Loaded,
    ) {
        let indices = both.indices();
        self.next = indices
            .iter()
            .map(|index| index.top.order)
            .fold(0, u32::max)
            + 1;
        for (place, setting) in SETTINGS.iter().enumerate() {
            let order = |index: &Index| index.order.get(place).copied().unwrap_or(0);
            let newest = indices.iter().map(order).fold(0, u32::max);
            let found = (0..).zip(&indices).find_map(|(which, index)| {
                (order(index) == newest).then_some(())?;
                both.half(which).read(index, place)
            });
            let Some((at, record)) = found else {
                continue;
            };
            if let Some(there) = self.places.get_mut(place) {
                *there = ((at - range.start) / WORD as u32) as u16;
            }
            match from_record(setting, record.value()) {
                Ok(None) => {}
                // Checked by the record's reader.
                Ok(Some(value)) if settings.set(setting.number, value).is_ok() => {
                    loaded.stored += 1
                }
                Ok(Some(_)) | Err(_) => loaded.refused.add(place),
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
        let is_its =
            |found: &Found| matches!(found, Found::Record(r) if r.claim.number == setting.number);
        let found = Some(both.half(which).look(at)).filter(is_its);
        let record = match found {
            Some(Found::Record(record)) => Some(record),
            // A save has moved it since, or it has aged.
            _ => both.newest(setting.number),
        };
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
        // What takes more room than before has to have it in both halves.
        if place.as_ref().is_none_or(|there| **there == NOWHERE) {
            for which in [0, 1] {
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
