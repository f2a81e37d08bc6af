//! Promise: in virtual cuts the amplitude statistic confirms chatter and does not call
//! a stable cut self-excited once the spindle's lines are out of its band.
//!
//! Tables: `cargo test --release -p host-tests --test amplitude_of_cuts -- --nocapture`.

use host_tests::amplitude::{Heard, Listening, listen};
use host_tests::bars::{all_judged, holds};
use rarma_core::decide::Amplitude;
use rarma_plants::cut::VirtualCut;
use rarma_plants::delay::DepthSearch;
use rarma_plants::truth::{limit_of, roots};
use rarma_scenarios::ear;
use rarma_scenarios::scenario;

/// Memory, s, and length of each cut after it has settled, s.
const MEMORY_S: f64 = 2.0;
const SECONDS: f64 = 6.0;

fn cut(name: &str, part: f64, remove_lines: bool) -> Heard {
    let loaded = scenario::load(name, None).expect("a shipped scenario");
    let process = &loaded.scenario.process;
    let deepest = process.depth().largest();
    let search = DepthSearch::between(0.02 * deepest, 10.0 * deepest);
    let limit = limit_of(process, f64::INFINITY, &search).expect("a limit");
    let played = ear::held(&loaded, process, part * limit.depth_m, SECONDS, 5);
    let cut = VirtualCut::new(&played).expect("a cut");
    let how = Listening {
        fs_hz: cut.sample_rate_hz(),
        band: loaded.band(),
        order: loaded.hints.order,
        memory_s: MEMORY_S,
        spindle_hz: (process.teeth() > 1).then(|| process.spindle_hz()),
        remove_lines,
    };
    let samples: Vec<f64> = cut.map(|r| f64::from(r.value)).collect();
    let heard = listen(&how, &samples);
    let root = roots(process, 0.0, part * limit.depth_m, 1).expect("roots")[0];
    println!(
        "| {name} | {part} | {} | {:.1} | {:.3} | {:.1} | {:.3} | {:.3} | {:.0} | {:.1} | {} |",
        if remove_lines { "out" } else { "in" },
        root.f_hz,
        100.0 * root.zeta,
        heard.mode.0,
        100.0 * heard.mode.1,
        heard.scintillation,
        heard.last.effective,
        heard.last.z,
        heard.shares()
    );
    heard
}

#[test]
fn stable_and_chattering_cuts() {
    println!(
        "| scenario | depth/limit | lines | root Hz | root ζ % | f read | ζ read % | S, median | N | z | forced / suspicious / self-excited / not stationary / too short, % |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    use Amplitude::{Forced, SelfExcited, TooShort};
    for (name, milling) in [
        ("turning-980", false),
        ("two-tooth-benchmark", true),
        ("three-mode-chatter", true),
    ] {
        for part in [0.5, 0.9, 1.1, 1.5] {
            let heard = cut(name, part, milling);
            if milling {
                // For the table: what the spindle's lines change.
                cut(name, part, false);
            }
            if part > 1.0 {
                assert!(heard.share(SelfExcited) > 0.9, "{name} {part}");
                assert!(heard.scintillation < 0.3, "{name} {part}");
            } else {
                let mistaken = heard.share(SelfExcited);
                let most = if part > 0.8 { 0.35 } else { 0.02 };
                assert!(mistaken <= most, "{name} {part}: {mistaken}");
                assert!((0.55..1.35).contains(&heard.scintillation), "{name} {part}");
                let linear = heard.share(Forced) + heard.share(TooShort);
                holds(
                    &format!("amplitude of cuts: linear, {name}, {part} of the limit"),
                    linear,
                    0.4..=1.0,
                );
            }
        }
    }
    all_judged("amplitude of cuts");
    // Not judged: at 7 revolutions a second the roots of the delay lie 7 Hz apart, and
    // several of them are in the band of the one mode.
    for part in [0.5, 0.9, 1.1, 1.5] {
        cut("slender-bar", part, false);
    }
}
