//! Promise: in real recordings the speed is found from the sound, where the sound
//! shows it, and its lines are taken out.
//!
//! Print the table with
//! `cargo test --release -p host-tests --test spindle_recordings -- --nocapture`.

use host_tests::resources::{Known, shared_or_skip};
use host_tests::statistics::quantile;
use rarma_core::condition::{
    Band, BandFilter, Finding, Lock, SpeedFinder, SpeedFinderConfig, SpindleLines,
    SpindleLinesConfig,
};

/// A recording and what is true of it.
struct Case {
    name: &'static str,
    told_hz: f64,
    teeth: Option<u32>,
    /// Where cutting goes on, s.
    from_to_s: (f64, f64),
    /// True spindle frequency, Hz, and how far the sound may be off it, relative.
    true_hz: (f64, f64),
    /// Least part of the cycles with an answer, %, and power left, dB.
    least_percent: usize,
    left_db: Option<(f64, f64)>,
}

/// What was found.
#[derive(Debug, Default)]
struct Outcome {
    found_hz: Vec<f64>,
    cycles: usize,
    contradictions: usize,
    /// Part of the samples with a lock, and power left over power that came, dB.
    locked: f64,
    left_db: f64,
    tracked_hz: Vec<f64>,
}

fn run(case: &Case, known: &Known, told_hz: Option<f64>) -> Outcome {
    let fs = known.recording.fs;
    let mut filter = BandFilter::<f32>::new(Band::usual(fs), fs).expect("band");
    let fs_hz = fs / filter.factor() as f64;
    let band = Band::usual(fs);
    let teeth = case.teeth.filter(|_| told_hz.is_some());
    let mut finder = SpeedFinder::<f32>::new(&SpeedFinderConfig {
        fs_hz,
        band,
        told_hz,
        teeth,
    })
    .expect("settings");
    let mut lines = SpindleLines::<f32, 48>::new(&SpindleLinesConfig {
        teeth,
        ..SpindleLinesConfig::new(fs_hz, band)
    })
    .expect("settings");
    let mut o = Outcome::default();
    let (mut came, mut left, mut locked, mut count) = (0.0, 0.0, 0, 0);
    let samples = &known.recording.samples;
    let (from, to) = case.from_to_s;
    let (from, to) = ((from * fs) as usize, (to * fs) as usize);
    for x in &samples[from.min(samples.len())..to.min(samples.len())] {
        let Some(y) = filter.process(*x as f32) else {
            continue;
        };
        match finder.push(y) {
            Some(Finding::Found(comb)) => {
                o.cycles += 1;
                o.found_hz.push(f64::from(comb.spacing_hz));
                if lines.lock() != Lock::Locked {
                    lines.start(comb.spacing_hz, comb.sd_hz);
                }
            }
            Some(Finding::Contradiction { .. }) => {
                o.cycles += 1;
                o.contradictions += 1;
            }
            Some(Finding::NotEstimable) => o.cycles += 1,
            None => {}
        }
        let out = lines.process(y);
        count += 1;
        if lines.lock() == Lock::Locked {
            locked += 1;
            came += f64::from(y * y);
            left += f64::from(out * out);
            if count % 500 == 0
                && let Some((hz, _)) = lines.spindle_hz()
            {
                o.tracked_hz.push(f64::from(hz));
            }
        }
    }
    o.locked = f64::from(locked) / f64::from(count);
    o.left_db = 10.0 * (left / came).log10();
    o
}

fn range(x: &[f64]) -> String {
    if x.is_empty() {
        return "none".into();
    }
    format!(
        "{:.2} ({:.2} to {:.2})",
        quantile(x, 0.5),
        quantile(x, 0.0),
        quantile(x, 1.0)
    )
}

#[test]
fn the_speed_of_real_cuts_is_found() {
    let Some(shared) = shared_or_skip("the_speed_of_real_cuts_is_found") else {
        return;
    };
    let yang = |name, rpm: f64, true_hz, left_db| Case {
        name,
        told_hz: rpm / 60.0,
        teeth: None,
        from_to_s: (0.5, 13.2),
        true_hz: (true_hz, 0.003),
        least_percent: 80,
        left_db,
    };
    let cases = [
        Case {
            name: "hafez_mill_sound/chatter",
            told_hz: 27.6,
            teeth: Some(6),
            from_to_s: (2.0, 15.6),
            true_hz: (27.6, 0.01),
            least_percent: 0,
            left_db: None,
        },
        Case {
            name: "hafez_mill_sound/stable",
            told_hz: 75.0,
            teeth: None,
            from_to_s: (1.6, 7.2),
            true_hz: (74.8, 0.01),
            least_percent: 70,
            left_db: Some((-4.0, -1.0)),
        },
        Case {
            name: "purdue_mt_cutting_video_audio/Exp0-1_video_audio",
            told_hz: 75.0,
            teeth: Some(5),
            from_to_s: (23.0, 77.0),
            true_hz: (76.2, 0.015),
            least_percent: 40,
            left_db: Some((-5.0, -1.0)),
        },
        yang(
            "yang_hurco_accel/EBI_F18IN_T50_D0p125_3000RPM_5A_ON_VICE_X",
            3000.0,
            49.962,
            Some((-27.0, -18.0)),
        ),
        yang(
            "yang_hurco_accel/EBI_F20IN_T50_D0p05IN_4000RPM_X",
            4000.0,
            66.642,
            Some((-25.0, -15.0)),
        ),
        yang(
            "yang_hurco_accel/EBI_T50_0p25IN_6900RPM_X",
            6900.0,
            114.957,
            Some((-4.0, -1.0)),
        ),
    ];
    println!(
        "| recording | search | found | cycles found / contradicted / all | locked | left | tracked |"
    );
    println!("|---|---|---|---|---|---|---|");
    for case in &cases {
        let known = Known::read(&shared, case.name);
        for (search, told) in [
            ("told", Some(case.told_hz)),
            ("told 9 % wrong", Some(case.told_hz * 1.09)),
            ("blind", None),
        ] {
            let o = run(case, &known, told);
            println!(
                "| {} | {search} | {} | {} / {} / {} | {:.0} % | {:.1} dB | {} |",
                case.name,
                range(&o.found_hz),
                o.found_hz.len(),
                o.contradictions,
                o.cycles,
                100.0 * o.locked,
                o.left_db,
                range(&o.tracked_hz),
            );
            let (truth, within) = case.true_hz;
            for hz in o.found_hz.iter().chain(&o.tracked_hz) {
                let ratio = (hz / truth).round().max(1.0);
                let off = (hz / ratio / truth - 1.0).abs();
                assert!(off < within, "{} {search}: {hz} Hz", case.name);
            }
            if search == "told" {
                assert!(
                    o.found_hz.len() * 100 >= o.cycles * case.least_percent,
                    "{o:?}"
                );
                assert_eq!(o.contradictions, 0);
            }
            if search == "told 9 % wrong" {
                assert!(o.found_hz.is_empty(), "{}: {o:?}", case.name);
            }
            if let Some((lo, hi)) = case.left_db.filter(|_| search == "told") {
                assert!((lo..hi).contains(&o.left_db), "{}: {o:?}", case.name);
            }
        }
    }
}
