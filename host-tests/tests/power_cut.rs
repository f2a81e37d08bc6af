//! Promise: one event costs at most the setting that is being written. Power may go away in
//! the middle of any word or erase of a save or a start, with bits that read differently
//! every time; bits may flip while the box is off. Afterwards every setting has the value
//! that was acknowledged, the one being written its old value or its new one, and what was
//! damaged is told.

use firmware::store::Store;
use hal_sim::rig::SimFlash;
use host_tests::flash_trials::{Subject, Tally, Trial, any_value};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rarma_box::settings::{COUNT, SETTINGS, Setting, SettingValue, Settings};
use rayon::prelude::*;

/// How often each word and erase is cut.
const WAYS: usize = 2;

fn loaded(flash: &mut SimFlash) -> Settings {
    let mut settings = Settings::default();
    let range = flash.range();
    let (_, found) = Store::load(flash, range, &mut settings);
    assert!(
        !found.lost && found.refused.is_empty() && found.older.is_empty(),
        "{found:?}"
    );
    assert!(
        found.defaulted.is_empty() && found.once.is_empty(),
        "{found:?}"
    );
    settings
}

/// One save, cut in each of its words and erases, each of them torn in several ways, and the
/// start after it cut as well.
fn cut_everywhere(
    flash: &SimFlash,
    store: &Store,
    before: &Settings,
    (setting, value): (&Setting, SettingValue),
) -> usize {
    let range = flash.range();
    let mut whole = flash.clone();
    let save = |flash: &mut SimFlash| {
        store
            .clone()
            .write(flash, range.clone(), setting, Some(value))
    };
    save(&mut whole).expect("a good flash");
    let steps = whole.touched() - flash.touched();
    let mut after = before.clone();
    after.set(setting.number, value).expect("in range");
    for power_for in 0..steps {
        for way in 0..WAYS {
            let mut flash = flash.clone();
            flash.reseed((WAYS * power_for + way) as u64);
            flash.power_for = Some(power_for);
            let _ = save(&mut flash);
            assert!(flash.lost_power());
            flash.power_up();
            if way % 2 == 1 {
                flash.power_for = Some(way);
                Store::load(&mut flash, range.clone(), &mut Settings::default());
                flash.power_up();
            }
            let found = loaded(&mut flash);
            let name = setting.name;
            assert!(
                found == *before || found == after,
                "{name} cut after {power_for}"
            );
            for _ in 0..3 {
                assert_eq!(loaded(&mut flash), found, "{name} cut after {power_for}");
            }
            // And the next save works.
            let (mut store, _) = Store::load(&mut flash, range.clone(), &mut Settings::default());
            store
                .write(&mut flash, range.clone(), setting, Some(value))
                .expect("power is back");
            assert_eq!(loaded(&mut flash), after);
        }
    }
    steps
}

#[test]
fn cut_in_every_word_and_erase_of_saves() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut flash = SimFlash::default();
    let range = flash.range();
    let mut known = Settings::default();
    let (mut store, _) = Store::load(&mut flash, range.clone(), &mut known);
    let (mut cuts, mut erasing) = (0, 0);
    // From an empty flash to one whose pages have gone around.
    for k in 0..300 {
        let setting = &SETTINGS[(k * 29) % COUNT];
        let value = any_value(setting, &mut rng);
        let erases = flash.wear().iter().sum::<u32>();
        let mut trial = flash.clone();
        let mut next = store.clone();
        next.write(&mut trial, range.clone(), setting, Some(value))
            .expect("a good flash");
        let erases = trial.wear().iter().sum::<u32>() > erases;
        if erases || k < 2 || k % 97 == 0 {
            cuts += WAYS * cut_everywhere(&flash, &store, &known, (setting, value));
            erasing += usize::from(erases);
        }
        (flash, store) = (trial, next);
        known.set(setting.number, value).expect("in range");
    }
    println!("{cuts} cuts, {erasing} saves that erased a page");
    assert!(cuts > 1_000 && erasing >= 5, "{cuts} {erasing}");
}

/// Every kind of flash: with and without check bits, the smallest and the board's.
fn kinds(cuts: u32, seed: u64) -> Vec<Trial> {
    let mut kinds = Vec::new();
    for (mends, pages) in [(true, 4), (false, 4), (true, 16), (false, 16)] {
        kinds.push(Trial {
            cuts,
            flips: 0.3,
            pages,
            mends,
            seed,
        });
    }
    kinds
}

fn run<S: Subject + Default>(trials: &[Trial]) -> Vec<Tally> {
    trials
        .par_iter()
        .map(|trial| trial.run(&mut S::default()))
        .collect()
}

fn held(trials: &[Trial]) {
    for (trial, tally) in trials.iter().zip(run::<Store>(trials)) {
        println!("{trial:?}\n  {tally:?}");
        assert_eq!(tally.losing, (0, 0), "{tally:?}");
        assert_eq!((tally.unsteady, tally.refused), (0, 0), "{tally:?}");
        assert_eq!(tally.untold_flips, 0, "{tally:?}");
        // What it is about has come: cuts that kept the old value and the new one, cuts of
        // the mending, flips.
        let (old, new) = tally.old_new;
        assert_eq!(old + new, tally.cuts.0);
        let part = tally.cuts.0 / 50;
        assert!(
            old > part && new > part && tally.cuts.1 > part && tally.flips > part,
            "{tally:?}"
        );
    }
}

#[test]
fn ten_thousand_cuts_with_torn_words_torn_erases_and_bits_that_flip() {
    held(&kinds(2_500, 2));
}

#[test]
#[ignore = "minutes: 200 000 cuts"]
fn ten_thousand_cuts_with_torn_words_torn_erases_and_bits_that_flip_long() {
    let trials: Vec<Trial> = (0..20).flat_map(|seed| kinds(2_500, 100 + seed)).collect();
    held(&trials);
}
