//! A store of settings against everything that can happen to a flash, and a plain map of
//! what was acknowledged.

use crate::former_store::{Former, TwoMaps};
use embedded_storage::nor_flash::ReadNorFlash;
use firmware::store::Store;
use hal_sim::rig::{SECTOR, SimFlash, WORD, WORD_BITS};
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::settings::{COUNT, Kind, SETTINGS, Setting, SettingValue, Settings};
use rarma_box::wire::LinkKey;

/// What a trial needs of a store.
pub trait Subject {
    /// Reads what is stored. True if it said that something was not as it should be.
    fn load(&mut self, flash: &mut SimFlash, settings: &mut Settings) -> bool;
    /// Whether a page holds anything for it.
    fn uses(&self, flash: &mut SimFlash, page: usize) -> bool {
        let words = page * SECTOR / WORD..(page + 1) * SECTOR / WORD;
        words.into_iter().any(|word| !flash.is_erased(word))
    }
    /// True if it said that the value is stored.
    fn save(&mut self, flash: &mut SimFlash, setting: &Setting, value: SettingValue) -> bool;
}

impl Subject for Store {
    /// A page whose erase or own record was cut is none of its.
    fn uses(&self, flash: &mut SimFlash, page: usize) -> bool {
        let mut word = [0; WORD];
        flash
            .read((page * SECTOR) as u32, &mut word)
            .expect("inside");
        let mut words = page * SECTOR / WORD + 2..(page + 1) * SECTOR / WORD;
        let is_laid = word[0] & 0x3F == 1 && word[4..6] == [0xFF; 2];
        is_laid && words.any(|word| !flash.is_erased(word))
    }

    fn load(&mut self, flash: &mut SimFlash, settings: &mut Settings) -> bool {
        let range = flash.range();
        let (store, loaded) = Self::load(flash, range, settings);
        *self = store;
        let named = [loaded.repaired, loaded.older, loaded.defaulted, loaded.once];
        loaded.lost || loaded.damaged_words > 0 || named.iter().any(|marks| !marks.is_empty())
    }

    fn save(&mut self, flash: &mut SimFlash, setting: &Setting, value: SettingValue) -> bool {
        let range = flash.range();
        self.write(flash, range, setting, Some(value)).is_ok()
    }
}

impl Subject for Former {
    fn load(&mut self, flash: &mut SimFlash, settings: &mut Settings) -> bool {
        Self::load(self, flash, settings)
    }

    fn save(&mut self, flash: &mut SimFlash, setting: &Setting, value: SettingValue) -> bool {
        Self::save(self, flash, setting, Some(value))
    }
}

impl Subject for TwoMaps {
    fn load(&mut self, flash: &mut SimFlash, settings: &mut Settings) -> bool {
        Self::load(self, flash, settings)
    }

    fn save(&mut self, flash: &mut SimFlash, setting: &Setting, value: SettingValue) -> bool {
        Self::save(self, flash, setting, Some(value))
    }
}

/// A value of a setting, anywhere in its range.
pub fn any_value(setting: &Setting, rng: &mut ChaCha8Rng) -> SettingValue {
    match setting.kind {
        Kind::Real { low, high, .. } => SettingValue::Real(rng.random_range(low..=high)),
        Kind::Whole { low, high, .. } => SettingValue::Whole(rng.random_range(low..=high)),
        Kind::Key => SettingValue::Key(LinkKey(rng.random())),
    }
}

/// What came of a trial.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Power cuts in a save, and in a start.
    pub cuts: (u32, u32),
    /// Bits or pairs of bits of one word that flipped where something is stored.
    pub flips: u32,
    /// Saves that were cut: the old value is in force, or the new one.
    pub old_new: (u32, u32),
    /// Events that cost a setting that was not being written, and settings lost by them.
    pub losing: (u32, u32),
    /// The most settings that one event cost.
    pub worst: u32,
    /// Of the losing events, those of which nothing was said.
    pub silent: u32,
    /// Flips of which nothing was said.
    pub untold_flips: u32,
    /// Saves that failed though power held.
    pub refused: u32,
    /// The most pages that one start erased.
    pub erases: u32,
    /// Starts after nothing had happened at which a value was another one.
    pub unsteady: u32,
}

/// Which settings differ, beside one.
fn differing(a: &Settings, b: &Settings, but: Option<u16>) -> u32 {
    let differs =
        |s: &&Setting| Some(s.number) != but && a.to_store(s.number) != b.to_store(s.number);
    SETTINGS.iter().filter(differs).count() as u32
}

/// A word in a page in use that is not erased.
fn a_stored_word(
    subject: &impl Subject,
    flash: &mut SimFlash,
    rng: &mut ChaCha8Rng,
) -> Option<usize> {
    let pages = flash.range().end as usize / SECTOR;
    let mut words = Vec::new();
    for page in 0..pages {
        if subject.uses(flash, page) {
            words.extend(page * SECTOR / WORD..(page + 1) * SECTOR / WORD);
        }
    }
    words.retain(|&word| !flash.is_erased(word));
    words.choose(rng).copied()
}

/// What may happen to a flash.
#[derive(Debug, Clone, Copy)]
pub struct Trial {
    /// Power cuts in saves, until the end.
    pub cuts: u32,
    /// Part of the sessions in which a bit flips instead.
    pub flips: f64,
    /// Pages.
    pub pages: usize,
    /// Whether the flash has check bits; if it has, two bits of a word flip at times.
    pub mends: bool,
    /// Seed.
    pub seed: u64,
}

impl Trial {
    /// Runs it. The oracle is what was acknowledged.
    pub fn run(&self, subject: &mut impl Subject) -> Tally {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut flash = SimFlash::new(self.pages, self.seed);
        flash.mends = self.mends;
        let mut tally = Tally::default();
        let mut known = Settings::default();
        subject.load(&mut flash, &mut Settings::default());
        for setting in &SETTINGS {
            let value = any_value(setting, &mut rng);
            assert!(subject.save(&mut flash, setting, value), "a good flash");
            known.set(setting.number, value).expect("in range");
        }
        while tally.cuts.0 < self.cuts {
            // Saves that nothing happens to, so that pages fill.
            for _ in 0..rng.random_range(0..6) {
                self.save(subject, &mut flash, &mut known, &mut rng, &mut tally);
            }
            let mut flying = None;
            let mut flipped = false;
            if rng.random_bool(self.flips) {
                flipped = self.flip(subject, &mut flash, &mut rng);
                tally.flips += u32::from(flipped);
            } else {
                // Most saves take a few words, those that make room erase and copy.
                let most = if rng.random_bool(0.7) { 5 } else { 200 };
                flash.power_for = Some(rng.random_range(0..most));
                while !flash.lost_power() {
                    let setting = SETTINGS.choose(&mut rng).expect("settings");
                    let value = any_value(setting, &mut rng);
                    let saved = subject.save(&mut flash, setting, value);
                    if flash.lost_power() {
                        flying = Some((setting, value));
                    } else if saved {
                        known.set(setting.number, value).expect("in range");
                    } else {
                        tally.refused += 1;
                    }
                }
                tally.cuts.0 += 1;
            }
            flash.power_up();
            // Power may go away again while the store mends itself.
            if !flipped && rng.random_bool(0.3) {
                flash.power_for = Some(rng.random_range(0..60));
                subject.load(&mut flash, &mut Settings::default());
                tally.cuts.1 += u32::from(flash.lost_power());
                flash.power_up();
            }
            flash.take_seen();
            let erases: u32 = flash.wear().iter().sum();
            let mut now = Settings::default();
            let told = subject.load(&mut flash, &mut now);
            let seen = flash.take_seen();
            tally.erases = tally.erases.max(flash.wear().iter().sum::<u32>() - erases);
            let told = told || seen.corrected_words + seen.unreadable_words > 0;
            tally.untold_flips += u32::from(flipped && !told);
            let mut but = None;
            if let Some((setting, value)) = flying {
                let there = now.to_store(setting.number);
                if there == Some(value) {
                    tally.old_new.1 += 1;
                    but = Some(setting.number);
                } else if there == known.to_store(setting.number) {
                    tally.old_new.0 += 1;
                }
            }
            let lost = differing(&now, &known, but);
            if lost > 0 {
                tally.losing.0 += 1;
                tally.losing.1 += lost;
                tally.worst = tally.worst.max(lost);
                tally.silent += u32::from(!told);
            }
            known = now;
            // Nothing happens, and nothing is another value.
            let mut again = Settings::default();
            subject.load(&mut flash, &mut again);
            tally.unsteady += u32::from(again != known);
            known = again;
            if lost > 0 {
                // The next event starts from a full table again.
                for setting in &SETTINGS {
                    let value = any_value(setting, &mut rng);
                    if subject.save(&mut flash, setting, value) {
                        known.set(setting.number, value).expect("in range");
                    }
                }
            }
        }
        tally
    }

    fn save(
        &self,
        subject: &mut impl Subject,
        flash: &mut SimFlash,
        known: &mut Settings,
        rng: &mut ChaCha8Rng,
        tally: &mut Tally,
    ) {
        let setting = &SETTINGS[rng.random_range(0..COUNT)];
        let value = any_value(setting, rng);
        if subject.save(flash, setting, value) {
            known.set(setting.number, value).expect("in range");
        } else {
            tally.refused += 1;
        }
    }

    /// A bit flips where something is stored; at times two of one word, where one is mended.
    fn flip(&self, subject: &impl Subject, flash: &mut SimFlash, rng: &mut ChaCha8Rng) -> bool {
        let Some(word) = a_stored_word(subject, flash, rng) else {
            return false;
        };
        let bits = if self.mends { WORD_BITS } else { 64 };
        let bit = rng.random_range(0..bits);
        flash.flip(word, bit);
        if self.mends && rng.random_bool(0.5) {
            flash.flip(word, (bit + rng.random_range(1..bits)) % bits);
        }
        true
    }
}
