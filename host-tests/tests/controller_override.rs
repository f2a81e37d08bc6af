//! Promise: when a real controller turns the spindle override and the chatter ends, the alarm
//! is released soon after, told of the speed or not, and no speed is invented.
//!
//! The cut is the shipped scenario `override-turned`; its speed is what a simulated spindle of
//! LinuxCNC did. *Stable*: when the dominant root of the delay equation, at the depth and the
//! speed of the moment, stops growing. `--nocapture` prints the table of docs/bench.md.

use host_tests::bars::{all_judged, holds};
use host_tests::statistics::quantile;
use host_tests::watch::each;
use rarma_core::decide::AlarmEvent;
use rarma_core::monitor::{Monitor, MonitorConfig, SpindleReport};
use rarma_plants::cut::{Process, VirtualCut};
use rarma_plants::process::Schedule;
use rarma_scenarios::ear::{self, Forced};
use rarma_scenarios::scenario::{self, Loaded};

const SCENARIO: &str = "override-turned";
const SEEDS: u64 = 8;
/// The control tells so often, and so much later than it happens, s.
const TELLS_S: f64 = 0.02;
const LATE_S: f64 = 0.05;
/// A speed further off than this part is another one.
const NEAR: f64 = 0.03;
/// The amplitude is read in windows of, and has gone at this many times what it is in the end.
const WINDOW_S: f64 = 0.02;
const GONE: f64 = 2.0;

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
    /// From when on the speed is the new one, s.
    turned_s: f64,
    end_s: f64,
}

impl Truth {
    fn of(loaded: &Loaded) -> Self {
        let Process::Milling(cut) = &loaded.scenario.process else {
            panic!("a milling cut")
        };
        let truth = loaded.scenario.truth().expect("a truth");
        let spindle_hz = cut.speed.clone().expect("a speed that changes");
        Self {
            turned_s: spindle_hz.end_s(),
            spindle_hz,
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
    /// Part of the time at the new speed in which it believed in an invented one.
    invented: f64,
    /// It said that the sound contradicts the speed that it was told.
    contradicted: bool,
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
    let band = loaded.band();
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
        contradicted: false,
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
        if t_s > truth.turned_s {
            out.contradicted |= report.spindle.contradiction.is_some();
            decisions += 1.0;
            out.invented += f64::from(u8::from(out.end == Claim::Invented));
        }
    }
    out.invented /= decisions;
    let still = standing.map(|(on, f_hz)| (on, truth.end_s, f_hz));
    out.alarms.extend(still);
    out
}

/// Root mean square of the tool's motion in x about its mean, µm: in the last half second of
/// the chatter and in the last of the cut; and from stable until it has gone, s.
fn amplitudes(loaded: &Loaded, truth: &Truth) -> (f64, f64, f64) {
    let mut cut = VirtualCut::new(&loaded.scenario).expect("a cut");
    let fs_hz = cut.sample_rate_hz();
    let mut x_um = Vec::with_capacity(cut.len());
    while cut.next().is_some() {
        x_um.push(1e6 * cut.machine().position_m[0]);
    }
    let rms = |from_s: f64, to_s: f64| {
        let part = &x_um[(from_s * fs_hz) as usize..(to_s * fs_hz) as usize];
        let mean = part.iter().sum::<f64>() / part.len() as f64;
        (part.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / part.len() as f64).sqrt()
    };
    let chatter_um = rms(truth.stable_s - 0.5, truth.stable_s);
    let stable_um = rms(truth.end_s - 0.5, truth.end_s);
    let windows = ((truth.end_s - truth.stable_s) / WINDOW_S) as usize;
    let loud = |k: &usize| {
        let from_s = truth.stable_s + WINDOW_S * *k as f64;
        rms(from_s, from_s + WINDOW_S) > GONE * stable_um
    };
    let last = (0..windows).rev().find(loud);
    let gone_s = last.map_or(0.0, |k| WINDOW_S * (k + 1) as f64);
    (chatter_um, stable_um, gone_s)
}

/// Prints a row of the table and judges it.
fn row(truth: &Truth, told: Told, name: &str, most_s: f64) {
    let runs = each((1..=SEEDS).collect(), |seed| heard(seed, told));
    let called: Vec<f64> = runs.iter().filter_map(|r| r.called_s(truth)).collect();
    let first_s = called.iter().copied().fold(f64::NAN, f64::min);
    let last_s = called.iter().copied().fold(f64::NAN, f64::max);
    let released: Vec<f64> = runs.iter().map(|r| r.released_s(truth)).collect();
    let [least_s, middle_s, longest_s] = [0.0, 0.5, 1.0].map(|part| quantile(&released, part));
    let at_end = |claim| runs.iter().filter(|r| r.end == claim).count();
    let [none, right, as_told, invented] =
        [Claim::None, Claim::True, Claim::Told, Claim::Invented].map(at_end);
    let contradicted = runs.iter().filter(|r| r.contradicted).count();
    let part = runs.iter().map(|r| r.invented).sum::<f64>() / runs.len() as f64;
    println!(
        "| {name} | {} | {first_s:.2} to {last_s:.2} | {least_s:.2}, {middle_s:.2}, {longest_s:.2} | {none}, {right}, {as_told}, {invented} | {part:.3} | {contradicted} |",
        called.len()
    );
    for run in &runs {
        println!("{run:.3?}");
    }
    let cuts = SEEDS as f64;
    let bar = |what: &str| format!("controller: {what}, {name}");
    holds(&bar("cuts called"), called.len() as f64, cuts..=cuts);
    holds(&bar("released, s"), longest_s, 0.0..=most_s);
    holds(&bar("speeds invented"), invented as f64, 0.0..=0.0);
    if told == Told::Live {
        holds(&bar("true speeds"), right as f64, cuts..=cuts);
    }
}

#[test]
fn chatter_that_an_override_ends_is_released() {
    let loaded = scenario::load(SCENARIO, None).expect("a shipped scenario");
    let truth = Truth::of(&loaded);
    let (chatter_um, stable_um, gone_s) = amplitudes(&loaded, &truth);
    println!(
        "chatters from {:.3} to {:.3} s; {chatter_um:.0} µm rms, then {stable_um:.0}; gone {gone_s:.2} s after",
        truth.onset_s, truth.stable_s
    );
    // Else nothing has ended.
    assert!(chatter_um > 3.0 * stable_um, "{chatter_um} {stable_um}");
    println!(
        "| speed | called | after the onset, s | released, s: least, median, most | at the end: none, true, the told one, invented | invented, part of the time | contradicted |"
    );
    println!("|---|---|---|---|---|---|---|");
    row(&truth, Told::Live, "told live", 0.6);
    row(&truth, Told::Once, "told once", 2.0);
    all_judged("controller");
}
