//! Promise: stored settings outlive what can happen to a flash beside a power cut. What is
//! damaged twice is named, with what is in force instead; a page or a half may go; a flash
//! that is full or worn says so and keeps what it has; numbers of another firmware and the
//! former store's settings are kept, and hold up neither a start nor a save.

use firmware::store::{Kept, Store, StoreError, VALUE_BYTES};
use hal_sim::SimBox;
use hal_sim::rig::{RigSetUp, SECTOR, SimFlash, SimRig, WORD};
use host_tests::flash_trials::{Tally, Trial, any_value};
use host_tests::former_store::{Former, TwoMaps};
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_box::guard::FaultCode;
use rarma_box::settings::{
    COUNT, SETTINGS, Setting, SettingValue, Settings, from_record, to_record,
};
use rarma_box::wire::{Command, Telemetry};
use rayon::prelude::*;

fn load(flash: &mut SimFlash) -> (Store, firmware::store::Loaded, Settings) {
    let mut settings = Settings::default();
    let range = flash.range();
    let (store, loaded) = Store::load(flash, range, &mut settings);
    (store, loaded, settings)
}

/// A flash with every setting stored, and some of them again.
fn used(pages: usize, again: usize, rng: &mut ChaCha8Rng) -> (SimFlash, Settings) {
    let mut flash = SimFlash::new(pages, 1);
    let range = flash.range();
    let (mut store, loaded, mut settings) = load(&mut flash);
    assert_eq!(
        loaded,
        firmware::store::Loaded::default(),
        "an erased chip: nothing to say"
    );
    let some: Vec<&Setting> = (0..again)
        .map(|_| SETTINGS.choose(rng).expect("some"))
        .collect();
    for setting in SETTINGS.iter().chain(some) {
        let value = any_value(setting, rng);
        let kept = store.write(&mut flash, range.clone(), setting, Some(value));
        assert_eq!(kept, Ok(Kept::Twice));
        settings.set(setting.number, value).expect("in range");
    }
    (flash, settings)
}

/// The first words of a setting's newest records.
fn words_of(flash: &mut SimFlash, number: u16) -> Vec<usize> {
    use embedded_storage::nor_flash::ReadNorFlash;
    let mut found = Vec::new();
    for word in 0..flash.range().end as usize / WORD {
        let mut bytes = [0; WORD];
        let at = (word * WORD) as u32;
        flash.read(at, &mut bytes).expect("inside");
        let [a, b, c, d, e, f, ..] = bytes;
        let tag = u32::from_le_bytes([a, b, c, d]);
        if matches!(tag & 0x3F, 6 | 34) && u16::from_le_bytes([e, f]) == number {
            found.push((tag >> 6, word));
        }
    }
    let newest = found.iter().map(|(order, _)| *order).max();
    found.retain(|(order, _)| Some(*order) == newest);
    found.into_iter().map(|(_, word)| word).collect()
}

#[test]
fn both_copies_damaged_cost_one_setting_and_it_is_named() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for mends in [false, true] {
        for (place, setting) in SETTINGS.iter().enumerate() {
            let (mut flash, settings) = used(4, 0, &mut rng);
            flash.mends = mends;
            let range = flash.range();
            // An older value of half of them is there as well.
            let older = place % 2 == 0;
            let mut now = settings.clone();
            if older {
                let (mut store, _, _) = load(&mut flash);
                let value = any_value(setting, &mut rng);
                store
                    .write(&mut flash, range.clone(), setting, Some(value))
                    .expect("room");
                now.set(setting.number, value).expect("in range");
            }
            // Bits of the value's first word, in each of them.
            let words = words_of(&mut flash, setting.number);
            assert!(words.len() >= 2);
            for word in words {
                flash.flip(word + 1, rng.random_range(0..32));
                if mends {
                    flash.flip(word + 1, rng.random_range(32..64));
                }
            }
            let (_, loaded, found) = load(&mut flash);
            let marks = if older {
                loaded.older
            } else {
                loaded.defaulted
            };
            assert!(
                marks.has(place) && marks.len() == 1,
                "{}: {loaded:?}",
                setting.name
            );
            assert!(loaded.repaired.is_empty() && !loaded.lost, "{loaded:?}");
            let mut wanted = settings.clone();
            if !older {
                let default = setting.default_value();
                wanted.set(setting.number, default).expect("in range");
            }
            assert_eq!(found, wanted, "{}", setting.name);
            // Told once: the damage has been cleared away.
            let (_, again, same) = load(&mut flash);
            assert_eq!((again.older, again.defaulted), Default::default());
            assert_eq!((again.damaged_words, same), (0, found));
        }
    }
}

#[test]
fn a_page_or_a_half_that_is_gone_costs_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for pages in [4, 16] {
        let (flash, settings) = used(pages, 700, &mut rng);
        let gone = (0..pages).map(|page| page..page + 1);
        for gone in gone.chain([0..pages / 2, pages / 2..pages]) {
            for erased in [false, true] {
                let mut flash = flash.clone();
                if erased {
                    use embedded_storage::nor_flash::NorFlash;
                    let (from, to) = (gone.start * SECTOR, gone.end * SECTOR);
                    flash.erase(from as u32, to as u32).expect("erased");
                } else {
                    flash.scramble(gone.clone());
                }
                let (_, loaded, found) = load(&mut flash);
                assert_eq!(found, settings, "{gone:?}: {loaded:?}");
                assert!(loaded.older.is_empty() && loaded.defaulted.is_empty() && !loaded.lost);
                let (_, again, found) = load(&mut flash);
                assert_eq!((again.repaired.len(), found), (0, settings.clone()));
            }
        }
    }
}

#[test]
fn a_flash_of_garbage_is_told_and_works_again() {
    for seed in 0..50 {
        let mut flash = SimFlash::new(4, seed);
        flash.scramble(0..4);
        let range = flash.range();
        let (mut store, loaded, settings) = load(&mut flash);
        assert!(loaded.lost);
        assert_eq!(settings, Settings::default());
        let value = Some(SettingValue::Whole(0));
        assert_eq!(
            store.write(&mut flash, range, &SETTINGS[0], value),
            Ok(Kept::Twice)
        );
        let (_, again, settings) = load(&mut flash);
        assert!(!again.lost);
        assert_eq!(settings.get(SETTINGS[0].number), value);
    }
}

#[test]
fn worn_pages_are_passed_over_and_a_worn_half_is_told() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let (good, _) = used(16, 200, &mut rng);
    let range = good.range();
    for (bad, expected) in [
        (vec![3, 4, 11], Some(Kept::Twice)),
        ((8..16).collect(), Some(Kept::Once)),
        ((0..16).collect(), None),
    ] {
        let mut flash = good.clone();
        flash.bad_pages.extend(bad);
        let (mut store, _, mut known) = load(&mut flash);
        let (mut last, mut once) = (None, 0);
        for _ in 0..2_000 {
            let setting = SETTINGS.choose(&mut rng).expect("some");
            let value = any_value(setting, &mut rng);
            let kept = store.write(&mut flash, range.clone(), setting, Some(value));
            if kept.is_ok() {
                known.set(setting.number, value).expect("in range");
            }
            last = Some(kept);
            once += u32::from(kept == Ok(Kept::Once));
            let (again, loaded, found) = load(&mut flash);
            assert_eq!(found, known, "{loaded:?}");
            store = again;
            if kept.is_err() {
                break;
            }
        }
        match expected {
            // A page is known to be worn once a save has tried it; the next start mends that.
            Some(Kept::Twice) => assert!(once < 50, "{once}"),
            Some(kept) => assert_eq!(last, Some(Ok(kept))),
            None => assert_eq!(last, Some(Err(StoreError::Flash))),
        }
    }
}

#[test]
fn a_full_flash_says_so_and_keeps_everything() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (mut flash, settings) = used(4, 100, &mut rng);
    let range = flash.range();
    flash.fill();
    let (mut store, _, found) = load(&mut flash);
    assert_eq!(found, settings);
    let new = store.put(&mut flash, range.clone(), 5000, &[1; VALUE_BYTES]);
    assert_eq!(new, Err(StoreError::Full));
    // What is there already can be saved again, many times.
    let mut known = settings;
    for _ in 0..1_000 {
        let setting = SETTINGS.choose(&mut rng).expect("some");
        let value = any_value(setting, &mut rng);
        let kept = store.write(&mut flash, range.clone(), setting, Some(value));
        assert_eq!(kept, Ok(Kept::Twice));
        known.set(setting.number, value).expect("in range");
    }
    let (store, _, found) = load(&mut flash);
    assert_eq!(found, known);
    // And no number of the other firmware was lost for it.
    let foreign = (1000..3000).take_while(|n| store.get(&mut flash, range.clone(), *n).is_some());
    let foreign = foreign.count();
    println!("{COUNT} settings and {foreign} other numbers in two pages of 2 KiB, twice");
    // Half the range, but for a page kept free, holds records of 16 bytes.
    let room = (SECTOR - 16) / 16 - COUNT;
    assert!((room - 8..=room).contains(&foreign), "{foreign} of {room}");
}

#[test]
fn numbers_of_another_firmware_and_long_values_are_kept() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut flash, _) = used(4, 0, &mut rng);
    let range = flash.range();
    let (mut store, _, mut known) = load(&mut flash);
    let long: Vec<Vec<u8>> = (1..=VALUE_BYTES)
        .step_by(13)
        .map(|n| vec![n as u8; n])
        .collect();
    for (number, value) in (9000..).zip(&long) {
        assert_eq!(
            store.put(&mut flash, range.clone(), number, value),
            Ok(Kept::Twice)
        );
    }
    assert!(
        store
            .put(&mut flash, range.clone(), 9100, &[0; VALUE_BYTES + 1])
            .is_err()
    );
    for round in 0..2_000 {
        let setting = SETTINGS.choose(&mut rng).expect("some");
        let value = any_value(setting, &mut rng);
        store
            .write(&mut flash, range.clone(), setting, Some(value))
            .expect("room");
        known.set(setting.number, value).expect("in range");
        if round % 500 == 100 {
            // One half is wiped: they come back from the other.
            let half = round / 500 % 2;
            flash.scramble(2 * half..2 * half + 2);
            let (again, _, found) = load(&mut flash);
            assert_eq!(found, known);
            store = again;
        }
    }
    for (number, value) in (9000..).zip(&long) {
        let found = store.get(&mut flash, range.clone(), number);
        assert_eq!(found.as_deref(), Some(value.as_slice()));
    }
}

/// Thirty settings of a later firmware, then so many saves that both halves are full: what a start and a save take
/// is counted in reads of the flash. One, and what is done with it, takes the board some 600 cycles of 163.2 MHz; the watchdog waits 94 ms
/// at the worst and is fed between the steps of a start, of which there are three and more; the samples' ring lasts
/// 43 ms, of which an erase takes 24.5.
#[test]
fn numbers_of_another_firmware_hold_up_neither_a_start_nor_a_save() {
    const READ_S: f64 = 600.0 / 163.2e6;
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let (mut flash, _) = used(16, 0, &mut rng);
    let range = flash.range();
    let (mut store, ..) = load(&mut flash);
    for number in 9000..9030 {
        let kept = store.put(&mut flash, range.clone(), number, &[1; 6]);
        assert_eq!(kept, Ok(Kept::Twice));
    }
    let (mut longest_start_s, mut longest_save_s) = (0.0_f64, 0.0_f64);
    for round in 0..3000 {
        let setting = SETTINGS.choose(&mut rng).expect("some");
        let value = any_value(setting, &mut rng);
        let before = flash.reads();
        let kept = store.write(&mut flash, range.clone(), setting, Some(value));
        assert_eq!(kept, Ok(Kept::Twice));
        longest_save_s = longest_save_s.max((flash.reads() - before) as f64 * READ_S);
        if round % 100 == 0 {
            let before = flash.reads();
            store = load(&mut flash).0;
            longest_start_s = longest_start_s.max((flash.reads() - before) as f64 * READ_S);
        }
    }
    println!("a start {longest_start_s:.4} s, a save {longest_save_s:.4} s");
    assert!(flash.wear().iter().all(|erases| *erases > 0));
    assert!(longest_start_s < 2.0 * 0.094, "{longest_start_s} s");
    assert!(longest_save_s < 0.043 - 0.0245, "{longest_save_s} s");
    for number in 9000..9030 {
        let value = store.get(&mut flash, range.clone(), number);
        assert_eq!(value.as_deref(), Some(&[1; 6][..]), "{number}");
    }
}

#[test]
fn outdated_and_nonsense_records_leave_the_rest() {
    let mut flash = SimFlash::default();
    let range = flash.range();
    let (mut store, _, _) = load(&mut flash);
    let mut write = |flash: &mut SimFlash, setting: &Setting, value| {
        store
            .write(flash, range.clone(), setting, value)
            .expect("written");
    };
    let threshold = &SETTINGS[8];
    write(&mut flash, threshold, Some(SettingValue::Real(0.02)));
    let outdated = Setting {
        version: 7,
        ..SETTINGS[1]
    };
    write(&mut flash, &outdated, Some(SettingValue::Real(2.0)));
    // Out of today's range, and of the other kind.
    write(&mut flash, &SETTINGS[2], Some(SettingValue::Real(1e6)));
    write(&mut flash, &SETTINGS[3], Some(SettingValue::Whole(1)));
    let (_, found, settings) = load(&mut flash);
    let refused: Vec<usize> = found.refused.settings().map(|(place, _)| place).collect();
    assert_eq!(
        (found.stored, refused, found.lost),
        (1, vec![1, 2, 3], false)
    );
    let mut expected = Settings::default();
    let value = SettingValue::Real(0.02);
    expected.set(threshold.number, value).expect("in range");
    assert_eq!(settings, expected);
    // Reset follows the default, whatever that is by then.
    write(&mut flash, threshold, None);
    assert_eq!(load(&mut flash).2, Settings::default());
}

#[test]
fn records_are_checked_for_meaning() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for setting in &SETTINGS {
        let value = any_value(setting, &mut rng);
        let record = to_record(setting, Some(value));
        assert_eq!(from_record(setting, record.as_slice()), Ok(Some(value)));
        let unset = to_record(setting, None);
        assert_eq!(from_record(setting, unset.as_slice()), Ok(None));
        let nan = to_record(setting, Some(SettingValue::Real(f32::NAN)));
        assert!(from_record(setting, nan.as_slice()).is_err());
        assert!(from_record(setting, &nan.as_slice()[..5]).is_err());
        assert!(setting.check(setting.default_value()).is_ok());
    }
}

/// Settings of the former store are taken over, also if power goes away in the middle.
#[test]
fn the_former_store_is_taken_over() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut cuts = 0;
    for pages in [4, 16] {
        for writes in [0, 1, 7, 100, 126, 127, 300, 900, 2100] {
            let mut flash = SimFlash::new(pages, writes as u64);
            let range = flash.range();
            let mut known = Settings::default();
            Former.load(&mut flash, &mut Settings::default());
            for _ in 0..writes {
                let setting = SETTINGS.choose(&mut rng).expect("some");
                let value = any_value(setting, &mut rng);
                assert!(Former.save(&mut flash, setting, Some(value)));
                known.set(setting.number, value).expect("in range");
            }
            let foreign = Setting {
                number: 7000,
                ..SETTINGS[0]
            };
            assert!(Former.save(&mut flash, &foreign, Some(SettingValue::Whole(1))));
            let former = flash.clone();
            let was = flash.touched();
            let (mut store, loaded, found) = load(&mut flash);
            assert_eq!(found, known, "{pages} pages, {writes} saves: {loaded:?}");
            assert!(!loaded.lost && loaded.older.is_empty() && loaded.defaulted.is_empty());
            assert!(store.get(&mut flash, range.clone(), 7000).is_some());
            let steps = flash.touched() - was;
            let value = any_value(&SETTINGS[0], &mut rng);
            let kept = store.write(&mut flash, range.clone(), &SETTINGS[0], Some(value));
            assert_eq!(kept, Ok(Kept::Twice));
            assert_eq!(load(&mut flash).2.get(SETTINGS[0].number), Some(value));
            for power_for in 0..steps {
                let mut flash = former.clone();
                flash.reseed(power_for as u64);
                flash.power_for = Some(power_for);
                load(&mut flash);
                assert!(flash.lost_power());
                flash.power_up();
                let (store, loaded, found) = load(&mut flash);
                assert_eq!(found, known, "cut after {power_for} of {steps}: {loaded:?}");
                assert!(store.get(&mut flash, range.clone(), 7000).is_some());
                cuts += 1;
            }
        }
    }
    println!("{cuts} cuts while it is taken over");
    assert!(cuts > 1_000, "{cuts}");
}

/// How many saves a flash of 10 000 erases a page lasts, and how evenly pages are used.
#[test]
fn pages_wear_evenly() {
    const ERASES: f64 = 10_000.0;
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    for (pages, at_random, least) in [(4, true, 6e5), (16, true, 8e6), (16, false, 8e6)] {
        let (mut flash, _) = used(pages, 0, &mut rng);
        let range = flash.range();
        let (mut store, _, _) = load(&mut flash);
        let saves = 40_000;
        let before = flash.wear().to_vec();
        for _ in 0..saves {
            let setting = &SETTINGS[if at_random {
                rng.random_range(0..COUNT)
            } else {
                7
            }];
            let value = any_value(setting, &mut rng);
            store
                .write(&mut flash, range.clone(), setting, Some(value))
                .expect("room");
        }
        let wear: Vec<u32> = flash
            .wear()
            .iter()
            .zip(&before)
            .map(|(a, b)| a - b)
            .collect();
        let most = *wear.iter().max().expect("pages");
        let last = ERASES * f64::from(saves) / f64::from(most);
        let what = if at_random {
            "any setting"
        } else {
            "one setting"
        };
        println!("{pages} pages, {what}: {last:.3e} saves, erases {wear:?}");
        for half in wear.chunks(pages / 2) {
            // What nobody saves again stays where it is, and its page is not worn.
            let used = half.iter().copied().filter(|n| *n > 0);
            let (fewest, most) = (used.clone().min(), used.max());
            assert!(most <= fewest.map(|n| n + 2), "{wear:?}");
        }
        assert!(last >= least && last < 2.0 * least, "{wear:?}");
    }
}

/// The host is told by name, and again if it asks who the box is.
#[test]
fn damage_is_told_by_name() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let (mut flash, settings) = used(4, 0, &mut rng);
    flash.mends = false;
    let [first, lost] = [&SETTINGS[5], &SETTINGS[9]];
    let word = words_of(&mut flash, first.number)[1];
    flash.flip(word + 1, 3);
    for word in words_of(&mut flash, lost.number) {
        flash.flip(word + 1, 7);
    }
    let mut rig = SimRig::new(RigSetUp::default(), std::iter::repeat(0.0));
    rig.flash = flash;
    let mut all = SimBox::new(rig);
    all.run_for(0.5);
    let told = |all: &SimBox, code: FaultCode| {
        let is = |m: &Telemetry| match m {
            Telemetry::Fault(f) if f.record.code == code => Some(f.record.value as u16),
            _ => None,
        };
        all.host
            .heard
            .iter()
            .filter_map(|h| is(&h.message))
            .collect::<Vec<u16>>()
    };
    assert_eq!(told(&all, FaultCode::SettingRepaired), [first.number]);
    assert_eq!(told(&all, FaultCode::SettingDefault), [lost.number]);
    assert_eq!(told(&all, FaultCode::FlashUnreadable).len(), 1);
    let mut wanted = settings;
    wanted
        .set(lost.number, lost.default_value())
        .expect("in range");
    assert_eq!(*all.app.settings(), wanted);
    all.run_for(1.5);
    all.send(&Command::Identify);
    all.run_for(0.5);
    assert_eq!(told(&all, FaultCode::SettingDefault), [lost.number; 2]);
    assert_eq!(told(&all, FaultCode::SettingRepaired), [first.number; 2]);
}

/// What the store before this one does under the same events, and what two maps of the same
/// library do with a check in every value: the table of decision 62, in docs/bench.md. Eight
/// pages at the least: a map of that library has no room for every setting in four.
#[test]
fn the_former_store_loses_what_this_one_keeps() {
    let trials: Vec<Trial> = [(true, 8), (true, 16), (false, 8), (false, 16)]
        .map(|(mends, pages)| Trial {
            cuts: 400,
            flips: 0.3,
            pages,
            mends,
            seed: 10,
        })
        .to_vec();
    let tallies: Vec<[Tally; 3]> = trials
        .par_iter()
        .map(|trial| {
            [
                trial.run(&mut Store::default()),
                trial.run(&mut Former),
                trial.run(&mut TwoMaps::default()),
            ]
        })
        .collect();
    for (trial, of_each) in trials.iter().zip(&tallies) {
        let flash = if trial.mends { "mended" } else { "bare" };
        for (name, t) in ["two journals", "one map", "two maps"].iter().zip(of_each) {
            println!(
                "| {flash}, {} pages | {name} | {} | {} | {} | {} | {} | {} | {} |",
                trial.pages,
                t.losing.0,
                t.losing.1,
                t.worst,
                t.silent,
                t.untold_flips,
                t.refused,
                t.unsteady,
            );
        }
    }
    let sum = |store: usize, of: fn(&Tally) -> u32| -> u32 {
        tallies.iter().map(|of_each| of(&of_each[store])).sum()
    };
    let losing = |t: &Tally| t.losing.0 + t.unsteady + t.refused + t.untold_flips;
    assert_eq!(sum(0, losing), 0);
    // One map loses whole tables, most of it without a word.
    assert!(sum(1, |t| t.losing.0) > 80 && sum(1, |t| t.silent) > 40);
    assert!(
        tallies
            .iter()
            .any(|of_each| of_each[1].worst as usize > COUNT / 2)
    );
}
