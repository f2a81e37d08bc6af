//! Promise: power may go away at any byte of a save. Afterwards every setting has its old
//! value or its new one, and nothing else.

use firmware::store;
use hal_sim::SimBox;
use hal_sim::rig::{RigSetUp, SECTOR, SECTORS, SimFlash, SimRig, WORD};
use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rarma_core::guard::FaultCode;
use rarma_core::settings::{
    COUNT, Kind, SETTINGS, Setting, SettingValue, Settings, from_record, to_record,
};
use rarma_core::wire::{LinkKey, Telemetry};

const RANGE: std::ops::Range<u32> = 0..(SECTOR * SECTORS) as u32;

fn other(setting: &Setting, rng: &mut ChaCha8Rng) -> SettingValue {
    match setting.kind {
        Kind::Real { low, high, .. } => SettingValue::Real(rng.random_range(low..=high)),
        Kind::Whole { low, high, .. } => SettingValue::Whole(rng.random_range(low..=high)),
        Kind::Key => SettingValue::Key(LinkKey(rng.random())),
    }
}

/// A flash that has been written to for a while: every sector has been in use.
fn used(rng: &mut ChaCha8Rng, writes: usize) -> (SimFlash, Settings) {
    let mut flash = SimFlash::default();
    let mut settings = Settings::default();
    assert!(!store::load(&mut flash, RANGE, &mut settings).lost);
    for _ in 0..writes {
        let setting = SETTINGS.choose(rng).expect("settings");
        let value = other(setting, rng);
        store::write(&mut flash, RANGE, setting, Some(value)).expect("a good flash");
        settings.set(setting.number, value).expect("in range");
    }
    (flash, settings)
}

fn loaded(flash: &mut SimFlash) -> Settings {
    let mut settings = Settings::default();
    let found = store::load(flash, RANGE, &mut settings);
    assert!(!found.lost && found.refusals == 0, "{found:?}");
    settings
}

/// Saves with `power_for` bytes of power left; false if the power held.
fn cut(
    flash: &SimFlash,
    before: &Settings,
    setting: &Setting,
    value: SettingValue,
    power_for: usize,
) -> bool {
    let mut flash = flash.clone();
    flash.power_for = Some(power_for);
    let result = store::write(&mut flash, RANGE, setting, Some(value));
    let was_cut = flash.lost_power();
    assert_eq!(result.is_err(), was_cut, "{result:?}");
    flash.power_up();
    let after = loaded(&mut flash);
    let mut new = before.clone();
    new.set(setting.number, value).expect("in range");
    let expected = if was_cut {
        after == *before || after == new
    } else {
        after == new
    };
    assert!(
        expected,
        "cut after {power_for} bytes of saving {}",
        setting.name
    );
    // And the next save works.
    store::write(&mut flash, RANGE, setting, Some(value)).expect("power is back");
    assert_eq!(loaded(&mut flash), new);
    was_cut
}

#[test]
fn cut_at_every_byte_of_saves() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut positions, mut erases) = (0, 0);
    // From an empty flash to one that moves a sector: 2 KiB hold about 128 records.
    for writes in [0, 1, 7, 120, 127, 128, 129, 130, 260, 384, 512, 900] {
        let (mut flash, before) = used(&mut rng, writes);
        // One save, and the one that has to make room if it comes within the next 140.
        for k in 0..140 {
            let setting = &SETTINGS[(writes + k) % COUNT];
            let value = other(setting, &mut rng);
            let was = flash.touched();
            let mut trial = flash.clone();
            store::write(&mut trial, RANGE, setting, Some(value)).expect("a good flash");
            let bytes = trial.touched() - was;
            if k > 0 && bytes < 200 {
                // A key's record is the longest.
                if bytes < 64 && k < 139 {
                    flash = trial;
                    continue;
                }
                break;
            }
            let before = if k == 0 {
                before.clone()
            } else {
                loaded(&mut flash)
            };
            for power_for in 0..=bytes {
                let was_cut = cut(&flash, &before, setting, value, power_for);
                assert_eq!(was_cut, power_for < bytes);
            }
            positions += bytes + 1;
            erases += usize::from(bytes > SECTOR);
            if k > 0 {
                break;
            }
            flash = trial;
        }
    }
    println!("{positions} cuts, {erases} saves that erased a sector");
    assert!(positions > 5_000 && erases >= 1, "{positions} {erases}");
}

#[test]
fn ten_thousand_random_cuts() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut flash, mut settings) = used(&mut rng, 50);
    let (mut cuts, mut old, mut new, mut saves) = (0, 0, 0, 0u32);
    while cuts < 10_000 {
        saves += 1;
        let setting = SETTINGS.choose(&mut rng).expect("settings");
        let value = other(setting, &mut rng);
        // Most saves touch 24 bytes, those that make room some thousand.
        let most = if rng.random_bool(0.5) { 26 } else { 6000 };
        flash.power_for = Some(rng.random_range(0..most));
        let result = store::write(&mut flash, RANGE, setting, Some(value));
        let was_cut = flash.lost_power();
        flash.power_up();
        // Power may go away again while the store repairs itself.
        if was_cut && rng.random_bool(0.3) {
            flash.power_for = Some(rng.random_range(0..3000));
            let _ = store::read(&mut flash, RANGE, setting);
            flash.power_up();
        }
        let after = loaded(&mut flash);
        let mut wanted = settings.clone();
        wanted.set(setting.number, value).expect("in range");
        if was_cut {
            cuts += 1;
            assert!(after == settings || after == wanted, "cut {cuts}");
            if after == wanted { new += 1 } else { old += 1 }
        } else {
            result.expect("power held");
            assert_eq!(after, wanted);
        }
        settings = after;
    }
    println!("{saves} saves, {cuts} cuts: {old} kept the old value, {new} have the new one");
    assert!(old > 1000 && new > 50, "{old} {new}");
}

#[test]
fn unknown_outdated_and_nonsense_records_leave_the_rest() {
    use firmware::store::write;
    let mut flash = SimFlash::default();
    store::load(&mut flash, RANGE, &mut Settings::default());
    let threshold = &SETTINGS[8];
    write(&mut flash, RANGE, threshold, Some(SettingValue::Real(0.02))).expect("written");
    // A setting of a later version of the box, and one that meant something else.
    let unknown = Setting {
        number: 9999,
        ..*threshold
    };
    write(&mut flash, RANGE, &unknown, Some(SettingValue::Real(1.0))).expect("written");
    let outdated = Setting {
        version: 7,
        ..SETTINGS[1]
    };
    write(&mut flash, RANGE, &outdated, Some(SettingValue::Real(2.0))).expect("written");
    // Out of today's range, and of the other kind.
    write(
        &mut flash,
        RANGE,
        &SETTINGS[2],
        Some(SettingValue::Real(1e6)),
    )
    .expect("written");
    write(
        &mut flash,
        RANGE,
        &SETTINGS[3],
        Some(SettingValue::Whole(1)),
    )
    .expect("written");
    let mut settings = Settings::default();
    let found = store::load(&mut flash, RANGE, &mut settings);
    assert_eq!((found.stored, found.refusals, found.lost), (1, 3, false));
    assert_eq!(found.refused, Some(SETTINGS[1].number));
    let mut expected = Settings::default();
    expected
        .set(threshold.number, SettingValue::Real(0.02))
        .expect("in range");
    assert_eq!(settings, expected);
    // Reset follows the default, whatever that is by then.
    write(&mut flash, RANGE, threshold, None).expect("written");
    let mut settings = Settings::default();
    store::load(&mut flash, RANGE, &mut settings);
    assert_eq!(settings, Settings::default());
}

#[test]
fn a_flash_of_garbage_is_laid_anew() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..200 {
        let mut flash = SimFlash::default();
        rng.fill(flash.content());
        let mut settings = Settings::default();
        store::load(&mut flash, RANGE, &mut settings);
        for setting in &SETTINGS {
            let value = settings.get(setting.number).expect("a setting");
            assert_eq!(setting.check(value), Ok(()));
        }
        store::write(
            &mut flash,
            RANGE,
            &SETTINGS[0],
            Some(SettingValue::Whole(0)),
        )
        .expect("works again");
        let mut again = Settings::default();
        store::load(&mut flash, RANGE, &mut again);
        assert_eq!(again.get(SETTINGS[0].number), Some(SettingValue::Whole(0)));
    }
}

#[test]
fn records_are_checked_for_meaning() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    for setting in &SETTINGS {
        let value = other(setting, &mut rng);
        assert_eq!(
            from_record(setting, &to_record(setting, Some(value))),
            Ok(Some(value))
        );
        assert_eq!(from_record(setting, &to_record(setting, None)), Ok(None));
        let nan = to_record(setting, Some(SettingValue::Real(f32::NAN)));
        assert!(from_record(setting, &nan).is_err());
        assert!(from_record(setting, &nan[..5]).is_err());
        assert!(setting.check(setting.default_value()).is_ok());
    }
}

/// On the chip a word whose writing was cut short has wrong check bits. Reading it costs no
/// setting, and the host is told.
#[test]
fn a_word_cut_short_is_told_and_costs_no_setting() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (flash, before) = used(&mut rng, 7);
    let setting = &SETTINGS[3];
    let value = other(setting, &mut rng);
    let mut whole = flash.clone();
    store::write(&mut whole, RANGE, setting, Some(value)).expect("a good flash");
    let bytes = whole.touched() - flash.touched();
    assert!(bytes > WORD, "{bytes} bytes: a word of each kind is cut");
    for power_for in 1..bytes {
        let mut flash = flash.clone();
        flash.power_for = Some(power_for);
        assert!(store::write(&mut flash, RANGE, setting, Some(value)).is_err());
        flash.power_up();
        flash.take_unreadable();
        assert_eq!(loaded(&mut flash.clone()), before);

        let mut rig = SimRig::new(RigSetUp::default(), std::iter::repeat(0.0));
        rig.flash = flash;
        let mut all = SimBox::new(rig);
        all.run_for(0.01);
        let told = all.host.heard.iter().any(|heard| {
            matches!(&heard.message, Telemetry::Fault(fault)
                if fault.record.code == FaultCode::FlashUnreadable)
        });
        let is_cut = power_for % WORD != 0;
        assert_eq!(told, is_cut, "power for {power_for} bytes");
        assert_eq!(*all.app.settings(), before);
    }
}
