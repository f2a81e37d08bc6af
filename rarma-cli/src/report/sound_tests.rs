//! Promises of what is kept of a sound.

use super::*;

const FS: f64 = 8_000.0;
const BAND: (f64, f64) = (300.0, 2_500.0);

/// Noise with a tone of 1 kHz in its second half.
fn samples(n: usize) -> Vec<f64> {
    let mut random = 7_u64;
    (0..n)
        .map(|i| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let noise = (random >> 40) as f64 / f64::from(1_u32 << 24) - 0.5;
            let loud = if i >= n / 2 { 1.0 } else { 0.0 };
            0.01 * noise + loud * (std::f64::consts::TAU * 1_000.0 * i as f64 / FS).sin()
        })
        .collect()
}

#[test]
fn a_short_one_is_kept_and_a_long_one_is_bounded() {
    let all = samples(5 * WHOLE + 12_345);
    let short = Sound::of(&all[..WHOLE], FS, BAND);
    assert_eq!(short.whole(), Some(&all[..WHOLE]));
    let long = Sound::of(&all, FS, BAND);
    assert_eq!((long.whole(), long.samples()), (None, all.len() as u64));
    let Kept::Thin(thin) = &long.kept else {
        panic!("not thinned")
    };
    let (stretches, columns) = (thin.envelope.all.len(), thin.spectra.columns.len());
    assert!(
        (STRETCHES / 2..=STRETCHES).contains(&stretches),
        "{stretches}"
    );
    assert!((COLUMNS / 2..=COLUMNS).contains(&columns), "{columns}");
}

#[test]
fn the_envelope_of_a_long_one_is_that_of_its_samples() {
    let all = samples(3 * WHOLE);
    let long = Sound::of(&all, FS, BAND);
    let Kept::Thin(thin) = &long.kept else {
        panic!("not thinned")
    };
    let step = thin.envelope.step as usize;
    for column in 0..840 {
        let at = |c: usize| c * all.len() / 840;
        let (from, to) = (at(column), at(column + 1));
        let (low, high) = long.between(from as u64, to as u64).expect("samples");
        // The stretches that begin in the column, to the end of the last.
        let from = from.div_ceil(step) * step;
        let to = (to.div_ceil(step) * step).min(all.len());
        let inside = || all[from..to].iter().map(|x| f64::from(*x as f32));
        assert_eq!(low, inside().fold(f64::MAX, f64::min), "{column}");
        assert_eq!(high, inside().fold(f64::MIN, f64::max), "{column}");
    }
}

#[test]
fn the_spectra_of_a_long_one_hold_its_tone_when_and_where_it_was() {
    let all = samples(4 * WHOLE);
    let long = Sound::of(&all, FS, BAND);
    let n = all.len() as u64;
    let level = |from: u64, to: u64| {
        let (window, power) = long.spectrum(from, to).expect("spectra");
        let bin = (1_000.0 * window as f64 / FS).round() as usize;
        power[bin - 1..=bin + 1].iter().copied().fold(0.0, f64::max)
    };
    // A tone of amplitude 1 has power 1 at its line, whatever is averaged.
    for column in 0..720 {
        let (from, to) = (column * n / 720, (column + 1) * n / 720);
        let power = level(from, to);
        match column {
            0..355 => assert!(power < 1e-4, "{column}: {power}"),
            365.. => assert!((0.9..1.1).contains(&power), "{column}: {power}"),
            _ => {}
        }
    }
}
