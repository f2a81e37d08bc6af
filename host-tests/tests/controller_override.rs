//! Promise: when a real controller turns the spindle override and the chatter ends, the alarm
//! is released soon after, told of the speed or not, and no speed is invented.
//!
//! The cut is the shipped scenario `override-turned`; its speed is what a simulated spindle of
//! LinuxCNC did. *Stable*: when the dominant root of the delay equation, at the depth and the
//! speed of the moment, stops growing. `--nocapture` prints the table of docs/bench.md.

use hal_sim::plant::cut::Process;
use hal_sim::plant::process::Schedule;
use host_tests::bars::{all_judged, holds};
use host_tests::watch::each;
use rarma_cli::ear::{self, Forced};
use rarma_cli::scenario::{self, Loaded};
use rarma_core::decide::AlarmEvent;
use rarma_core::monitor::{Monitor, MonitorConfig, SpindleReport};

const SCENARIO: &str = "override-turned";
const SEEDS: u64 = 8;
/// The control tells so often, and so much later than it happens, s.
const TELLS_S: f64 = 0.02;
const LATE_S: f64 = 0.05;
/// A speed further off than this part is another one.
const NEAR: f64 = 0.03;

/// Who tells the speed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Told {
    /// The control, all the time.
    Live,
    /// Somebody, before the cut.
    Once,
}

/// What is true of the cut.
struct Truth {
    /// The spindle, turns a second, over time.
    spindle_hz: Schedule,
    /// From when on, and until when, it chatters, s.
    onset_s: f64,
    stable_s: f64,
    end_s: f64,
}

impl Truth {
    fn of(loaded: &Loaded) -> Self {
        let Process::Milling(cut) = &loaded.scenario.process else {
            panic!("a milling cut")
        };
        let truth = loaded.scenario.truth().expect("a truth");
        Self {
            spindle_hz: cut.speed.clone().expect("a speed that changes"),
            onset_s: truth.onset_s.expect("an onset"),
            stable_s: truth.end_s.expect("an end"),
            end_s: loaded.scenario.duration_s,
        }
    }
}

/// The speed that the monitor believes in, by what it is near to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Claim {
    None,
    True,
    /// Off the true one, and the one that was told before the cut.
    Told,
    /// Neither of them.
    Invented,
}

fn claim(report: &SpindleReport<f32>, true_hz: f64, told_hz: f64) -> Claim {
    let Some(hz) = report.spindle_hz.map(f64::from) else {
        return Claim::None;
    };
    let near = |to: f64| (hz / to - 1.0).abs() <= NEAR;
    match (near(true_hz), near(told_hz)) {
        (true, _) => Claim::True,
        (false, true) => Claim::Told,
        (false, false) => Claim::Invented,
    }
}

/// What the monitor said of one cut.
#[derive(Debug)]
struct Heard {
    /// Alarms: from, to, s, and frequency, Hz.
    alarms: Vec<(f64, f64, f32)>,
    /// The speed it believed in at the end, 1/min, and what that is.
    end_rpm: Option<f32>,
    end: Claim,
    /// Part of the time after the chatter in which it believed in an invented one.
    invented: f64,
}

impl Heard {
    /// From the onset to the first alarm of the chatter, s; none if it is not called.
    fn called_s(&self, truth: &Truth) -> Option<f64> {
        let mut in_chatter = self
            .alarms
            .iter()
            .filter(|(on, off, _)| *on < truth.stable_s && *off > truth.onset_s);
        in_chatter.next().map(|(on, ..)| on - truth.onset_s)
    }

    /// From the end of the chatter to that of the last alarm, s; to the end of the cut if one
    /// stands there.
    fn released_s(&self, truth: &Truth) -> f64 {
        let last = self.alarms.last().map_or(0.0, |(_, off, _)| *off);
        (last - truth.stable_s).max(0.0)
    }
}

fn heard(seed: u64, told: Told) -> Heard {
    let loaded = scenario::load(SCENARIO, Some(seed)).expect("a shipped scenario");
    let truth = Truth::of(&loaded);
    let band = ear::band(&loaded);
    let sound = ear::hear(&loaded.scenario, band, Forced::Kept).expect("a cut");
    let start_hz = truth.spindle_hz.at(0.0);
    let config = MonitorConfig {
        full_scale: Some(1.0),
        band: Some(band),
        order: loaded.hints.order,
        spindle_hz: Some(start_hz),
        teeth: u32::try_from(loaded.scenario.process.teeth()).ok(),
        ..MonitorConfig::new(sound.fs)
    };
    let mut monitor = Monitor::<f32>::new(&config).expect("in range");
    let every = (TELLS_S * sound.fs).round() as usize;
    let mut out = Heard {
        alarms: Vec::new(),
        end_rpm: None,
        end: Claim::None,
        invented: 0.0,
    };
    let (mut standing, mut decisions) = (None, 0.0);
    for (n, x) in sound.samples.iter().enumerate() {
        let t_s = n as f64 / sound.fs;
        if told == Told::Live && n % every == 0 {
            let told_hz = truth.spindle_hz.at(t_s - LATE_S);
            monitor.tell_speed(told_hz as f32).expect("in range");
        }
        let Some(report) = monitor.push(*x as f32) else {
            continue;
        };
        match report.event {
            AlarmEvent::On { frequency, .. } => standing = Some((t_s, frequency)),
            AlarmEvent::Off { .. } => {
                let called = standing.take();
                out.alarms.extend(called.map(|(on, f_hz)| (on, t_s, f_hz)));
            }
            AlarmEvent::None => {}
        }
        out.end = claim(&report.spindle, truth.spindle_hz.at(t_s), start_hz);
        out.end_rpm = report.spindle.spindle_hz.map(|hz| 60.0 * hz);
        if t_s > truth.stable_s {
            decisions += 1.0;
            out.invented += f64::from(u8::from(out.end == Claim::Invented));
        }
    }
    out.invented /= decisions;
    let still = standing.map(|(on, f_hz)| (on, truth.end_s, f_hz));
    out.alarms.extend(still);
    out
}

/// Prints a row of the table and judges it.
fn row(told: Told, name: &str, most_s: f64) {
    let truth = Truth::of(&scenario::load(SCENARIO, None).expect("a shipped scenario"));
    let runs = each((1..=SEEDS).collect(), |seed| heard(seed, told));
    for run in &runs {
        println!("{told:?} {run:.3?}");
    }
    let called: Vec<f64> = runs.iter().filter_map(|r| r.called_s(&truth)).collect();
    let mut released: Vec<f64> = runs.iter().map(|r| r.released_s(&truth)).collect();
    released.sort_by(f64::total_cmp);
    let again = |run: &Heard| run.alarms.iter().filter(|a| a.0 > truth.stable_s).count();
    let again: usize = runs.iter().map(again).sum();
    let at_end = |claim| runs.iter().filter(|r| r.end == claim).count();
    let [none, right, as_told, invented] =
        [Claim::None, Claim::True, Claim::Told, Claim::Invented].map(at_end);
    let (first, last) = called
        .iter()
        .fold((f64::NAN, f64::NAN), |(a, b), x| (a.min(*x), b.max(*x)));
    let middle = released[released.len() / 2];
    let longest = released[released.len() - 1];
    let part = runs.iter().map(|r| r.invented).sum::<f64>() / runs.len() as f64;
    println!(
        "| speed | called | after, s | released, s: median, most | again | at the end: none, true, the told one, invented | invented, part of the time |"
    );
    println!(
        "| {name} | {} | {first:.2} to {last:.2} | {middle:.2}, {longest:.2} | {again} | {none}, {right}, {as_told}, {invented} | {part:.2} |",
        called.len()
    );
    let seeds = SEEDS as f64;
    holds(
        &format!("controller: cuts called, {name}"),
        called.len() as f64,
        seeds..=seeds,
    );
    holds(
        &format!("controller: released, s, {name}"),
        longest,
        0.0..=most_s,
    );
    holds(
        &format!("controller: invented speeds, {name}"),
        invented as f64,
        0.0..=0.0,
    );
    if told == Told::Live {
        holds(
            &format!("controller: true speeds, {name}"),
            right as f64,
            seeds..=seeds,
        );
    }
}

#[test]
fn chatter_that_an_override_ends_is_released() {
    let truth = Truth::of(&scenario::load(SCENARIO, None).expect("a shipped scenario"));
    println!(
        "chatters from {:.3} s, stable from {:.3} s on",
        truth.onset_s, truth.stable_s
    );
    row(Told::Live, "told live", 0.6);
    row(Told::Once, "told once", 2.0);
    all_judged("controller");
}
