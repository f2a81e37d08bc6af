//! Promise: chatter beside a tooth line, or on a multiple of the spindle, is found or
//! the monitor says that it cannot tell.
//!
//! A stable cut with its forced lines, of which one mode loses its damping under a
//! constant force: 2 % → 0.05 % in 0.3 s, a few hertz from a tooth line; and flip
//! (period-two) chatter of two teeth, exactly on an odd multiple of the spindle.
//! `--nocapture` prints the table; the long form (50 seeds) is
//! `cargo test --release -p host-tests --test near_harmonic -- --ignored --nocapture`.

use host_tests::bars::{all_judged, holds};
use host_tests::forced::{Forced, ForcedConfig};
use host_tests::statistics::quantile;
use host_tests::watch::{Watched, each, watch};
use rarma_core::monitor::MonitorConfig;

const MODE_HZ: f64 = 980.0;
/// The damping goes from here, in so long, s.
const FROM_S: f64 = 4.0;
const FADE_S: f64 = 0.3;
const END_S: f64 = 9.0;
const BEFORE: f64 = 0.02;
const AFTER: f64 = 0.0005;
/// Called within this of the mode it is the mode, Hz; the tooth lines are 80 Hz and
/// more apart.
const NEAR_HZ: f64 = 15.0;
/// Found or declared within this, ms, nine of ten. At ζ = 0.05 % a mode takes 0.32 s to
/// forget, and two lines 3 Hz apart beat once in 0.33 s: nothing is faster.
const FOUND_MS: f64 = 1500.0;

/// Where the mode that goes lies.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    /// So many Hz above (below for odd seeds) a tooth line.
    Beside(f64),
    /// On an odd multiple of the spindle, half way between tooth lines; with runout or
    /// without.
    Flip { runout: bool },
}

fn signal(place: Place, seed: u64) -> ForcedConfig {
    let mut c = ForcedConfig::drawn(seed);
    c.modes = if seed % 4 >= 2 {
        vec![(MODE_HZ, BEFORE), (450.0, 0.04), (1700.0, 0.03)]
    } else {
        vec![(MODE_HZ, BEFORE)]
    };
    c.fading = Some((0, FROM_S, FADE_S, AFTER));
    match place {
        Place::Beside(off) => {
            let line = MODE_HZ - if seed % 8 >= 4 { -off } else { off };
            // The second to the sixth harmonic of the teeth.
            c.spindle_hz = line / (f64::from(c.teeth) * (2 + seed % 5) as f64);
        }
        Place::Flip { runout } => {
            c.teeth = 2;
            // The third, fifth and seventh multiple: 19 600, 11 760, 8400 rpm.
            c.spindle_hz = MODE_HZ / (3 + 2 * (seed % 3)) as f64;
            if !runout {
                c.runout_db = None;
            }
        }
    }
    c
}

fn listened(place: Place, told: bool, seed: u64) -> Watched {
    let signal = signal(place, seed);
    let config = MonitorConfig {
        spindle_hz: told.then_some(signal.spindle_hz),
        teeth: told.then_some(signal.teeth),
        ..MonitorConfig::new(signal.fs_hz)
    };
    let samples = (END_S * signal.fs_hz) as usize;
    watch(&config, Forced::new(signal).take(samples))
}

fn table(form: &str, seeds: u64) {
    println!(
        "| chatter | speed | seeds | found | ms, median | 90 % | declared | ms, median | neither | called before | reasons after |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let places = [
        ("0.5 Hz beside a tooth line", Place::Beside(0.5)),
        ("3 Hz beside a tooth line", Place::Beside(3.0)),
        ("8 Hz beside a tooth line", Place::Beside(8.0)),
        ("flip, on runout lines", Place::Flip { runout: true }),
        ("flip, no runout", Place::Flip { runout: false }),
    ];
    for (name, place) in places {
        for told in [true, false] {
            let runs = each((0..seeds).collect(), |seed| listened(place, told, seed));
            let (mut found, mut declared, mut neither, mut before) = (vec![], vec![], 0, 0);
            let mut reasons = std::collections::BTreeMap::<String, f64>::new();
            for run in &runs {
                let call = run.first(FROM_S, END_S, Some((MODE_HZ, NEAR_HZ)));
                match (call, run.declared(FROM_S, END_S)) {
                    (Some(call), _) => found.push(1e3 * (call.on_s - FROM_S)),
                    (None, Some(t)) => declared.push(1e3 * (t - FROM_S)),
                    (None, None) => neither += 1,
                }
                before += run.called(1.0, FROM_S);
                for (reason, s) in run.reasons(FROM_S + FADE_S, END_S) {
                    *reasons.entry(reason).or_default() += s;
                }
            }
            let part = |values: &[f64], part: f64| match values {
                [] => "-".to_owned(),
                _ => format!("{:.0}", quantile(values, part)),
            };
            let all = runs.len() as f64 * (END_S - FROM_S - FADE_S);
            let mut reasons: Vec<_> = reasons.into_iter().collect();
            reasons.sort_by(|a, b| b.1.total_cmp(&a.1));
            let words: Vec<String> = reasons
                .iter()
                .take(3)
                .map(|(r, s)| format!("{r} {:.2}", s / all))
                .collect();
            let speed = if told { "told" } else { "not told" };
            println!(
                "| {name} | {speed} | {seeds} | {} | {} | {} | {} | {} | {neither} | {before} | {} |",
                found.len(),
                part(&found, 0.5),
                part(&found, 0.9),
                declared.len(),
                part(&declared, 0.5),
                words.join(", "),
            );
            let of = format!("{name}, {speed}");
            holds(
                &format!("{form}: neither found nor declared, {of}"),
                f64::from(neither),
                0.0..=0.0,
            );
            holds(
                &format!("{form}: called before, {of}"),
                before as f64,
                0.0..=0.0,
            );
            let times: Vec<f64> = found.into_iter().chain(declared).collect();
            let most = if times.is_empty() {
                f64::NAN
            } else {
                quantile(&times, 0.9)
            };
            holds(&format!("{form}: 90 %, ms, {of}"), most, 0.0..=FOUND_MS);
        }
    }
    all_judged(form);
}

#[test]
fn chatter_near_a_forced_line_is_found_or_declared() {
    table("near", 8);
}

#[test]
#[ignore = "long: 50 seeds"]
fn chatter_near_a_forced_line_is_found_or_declared_long() {
    table("near, long", 50);
}
