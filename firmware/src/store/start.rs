//! Reading the store at a start, in steps: what a power cut or age have done is mended, then
//! the values are taken.

use super::both::{Both, halves};
use super::half::{Index, Room};
use super::record::WORD;
use super::{Loaded, Store, former};
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use rarma_box::settings::{SETTINGS, Settings, from_record};

/// How often the halves are made to agree before the rest is left to the next start.
const ROUNDS: u32 = 4;

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
pub(super) struct Loading {
    step: Step,
    pub store: Store,
    pub loaded: Loaded,
    /// What the halves agreed on.
    agreed: Option<[Index; 2]>,
    tidied: u32,
}

impl Loading {
    pub fn new() -> Self {
        Self {
            step: Step::Agree,
            store: Store::default(),
            loaded: Loaded::default(),
            agreed: None,
            tidied: 0,
        }
    }

    /// One step: two erases, and two more if pages are worn. True once it was the last.
    pub fn go_on<F: NorFlash>(
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
    if indices.iter().any(Index::has_foreign) {
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
            None if both.give_up(which, &indices) => {
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

impl Store {
    /// Where everything stands, and every value that can be used.
    fn take<F: NorFlash>(
        &mut self,
        both: &mut Both<'_, F>,
        range: &Range<u32>,
        settings: &mut Settings,
        loaded: &mut Loaded,
    ) {
        let indices = both.indices();
        self.foreign = indices.iter().any(Index::has_foreign);
        self.next = indices
            .iter()
            .map(|index| index.top.order)
            .fold(0, u32::max)
            + 1;
        for (place, setting) in SETTINGS.iter().enumerate() {
            let orders = indices.iter().map(|index| index.order(place));
            let newest = orders.fold(0, u32::max);
            let found = (0..).zip(&indices).find_map(|(which, index)| {
                (index.order(place) == newest).then_some(())?;
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
}
