//! Cuts with lines of the spindle, played through the speed finder and the removal of
//! lines, and what came of it.

use crate::signal;
use crate::statistics::rms;
use rarma_core::condition::{
    Band, Finding, Lock, SpeedFinder, SpeedFinderConfig, SpindleLines, SpindleLinesConfig,
};
use rarma_core::real::Real;
use std::f64::consts::TAU;

const FS: f64 = 6000.0;
const BAND: Band = Band {
    low_hz: 300.0,
    high_hz: 2500.0,
};
const MODES: [(f64, f64); 3] = [(980.0, 0.02), (450.0, 0.03), (1500.0, 0.025)];

/// A cut: noise of modes (variance 1 each), lines of the teeth, of runout, a chatter.
#[derive(Clone, Copy)]
pub struct Cut {
    /// What a table calls it.
    pub name: &'static str,
    /// How many of the three modes are there.
    pub modes: usize,
    /// Speed at the beginning, Hz.
    pub spindle_hz: f64,
    /// Teeth.
    pub teeth: u32,
    /// What the finder is told, Hz.
    pub told_hz: Option<f64>,
    /// Whether it is told the teeth.
    pub teeth_told: bool,
    /// Power of the lines over that of the modes, dB.
    pub lines_db: f64,
    /// Power of runout lines at the other multiples, over that of the teeth, dB.
    pub runout_db: Option<f64>,
    /// Relative change of the speed per second, from 3 s to 5 s.
    pub ramp: f64,
    /// Chatter: frequency, Hz, and amplitude over that of a tooth line.
    pub chatter: Option<(f64, f64)>,
    /// Length, s.
    pub seconds: f64,
}

/// Five teeth at 76.4 Hz, told, their lines 20 dB above three modes.
pub const CUT: Cut = Cut {
    name: "",
    modes: 3,
    spindle_hz: 76.4,
    teeth: 5,
    told_hz: Some(76.4),
    teeth_told: true,
    lines_db: 20.0,
    runout_db: None,
    ramp: 0.0,
    chatter: None,
    seconds: 6.0,
};

/// Samples: lines, the rest, chatter; and the speed, Hz.
pub struct Sound {
    /// Lines of the teeth and of runout.
    pub lines: Vec<f64>,
    /// Noise of the modes.
    pub rest: Vec<f64>,
    /// Chatter.
    pub chatter: Vec<f64>,
    /// Speed, Hz.
    pub speed_hz: Vec<f64>,
}

impl Cut {
    fn play(&self, seed: u64) -> Sound {
        let n = (self.seconds * FS) as usize;
        let rest: Vec<f64> = signal::modes(&MODES[..self.modes], FS, 500 + seed)
            .take(n)
            .collect();
        let z = self.teeth;
        let inside = |k: &u32| {
            let f = f64::from(*k) * self.spindle_hz;
            f > BAND.low_hz && f < 2000.0
        };
        let last = (2500.0 / self.spindle_hz) as u32;
        let tooth: Vec<u32> = (1..=last).filter(|k| k % z == 0).filter(inside).collect();
        let other: Vec<u32> = (1..=last).filter(|k| k % z != 0).filter(inside).collect();
        let power = self.modes as f64 * 10f64.powf(self.lines_db / 10.0);
        let a = (2.0 * power / tooth.len() as f64).sqrt();
        let b = self.runout_db.map_or(0.0, |db| {
            (2.0 * power * 10f64.powf(db / 10.0) / other.len() as f64).sqrt()
        });
        let (mut phase, mut speed) = (0.1 * seed as f64, self.spindle_hz);
        let mut sound = Sound {
            lines: vec![],
            rest,
            chatter: vec![],
            speed_hz: vec![],
        };
        for i in 0..n {
            let t = i as f64 / FS;
            if (3.0..5.0).contains(&t) {
                speed += self.ramp * self.spindle_hz / FS;
            }
            phase += TAU * speed / FS;
            let line = |k: &u32| (f64::from(*k) * phase + f64::from(k * k) + seed as f64).sin();
            let lines = a * tooth.iter().map(line).sum::<f64>();
            let lines = lines + b * other.iter().map(line).sum::<f64>();
            let chatter = self
                .chatter
                .map_or(0.0, |(f, part)| part * a * (TAU * f * t + 1.0).sin());
            sound.lines.push(lines);
            sound.chatter.push(chatter);
            sound.speed_hz.push(speed);
        }
        sound
    }
}

/// What came of it.
#[derive(Default, Debug)]
pub struct Outcome {
    /// Answers with a speed.
    pub found: u32,
    /// Answers without one.
    pub none: u32,
    /// Answers against the told one.
    pub contradictions: u32,
    /// Errors of the speeds found, Hz.
    pub found_error: Vec<f64>,
    /// The same over their standard deviations.
    pub found_over_sd: Vec<f64>,
    /// Of the lines' own speed, over its standard deviation, once settled.
    pub tracked_over_sd: Vec<f64>,
    /// The same, Hz.
    pub tracked_error: Vec<f64>,
    /// When the lines locked, s.
    pub lock_s: Vec<f64>,
    /// Locks that were lost.
    pub lost: u32,
    /// Power of lines left over that of the lines, dB, in the last second.
    pub left_db: Vec<f64>,
    /// The same while the speed changes.
    pub left_ramp_db: Vec<f64>,
    /// Amplitude of the chatter left over that of the chatter.
    pub kept: Vec<f64>,
}

fn db(x: f64) -> f64 {
    10.0 * x.log10()
}

/// Amplitude of `x` at `f`.
fn amplitude(x: &[f64], f: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (i, x) in x.iter().enumerate() {
        let angle = TAU * f * i as f64 / FS;
        re += x * angle.cos();
        im += x * angle.sin();
    }
    2.0 * re.hypot(im) / x.len() as f64
}

/// Plays `seeds` cuts through the finder and the lines.
///
/// # Panics
/// Where the settings are refused.
pub fn run<T: Real>(cut: &Cut, seeds: u64) -> Outcome {
    let mut outcome = Outcome::default();
    for seed in 0..seeds {
        let sound = cut.play(seed);
        let teeth = cut.teeth_told.then_some(cut.teeth);
        let mut finder = SpeedFinder::<T>::new(&SpeedFinderConfig {
            fs_hz: FS,
            band: BAND,
            told_hz: cut.told_hz,
            teeth,
        })
        .expect("settings");
        let mut lines = SpindleLines::<T, 32>::new(&SpindleLinesConfig {
            teeth,
            ..SpindleLinesConfig::new(FS, BAND)
        })
        .expect("settings");
        let mut out = vec![];
        let mut locked = None;
        let mut started = false;
        for i in 0..sound.rest.len() {
            let y = sound.lines[i] + sound.rest[i] + sound.chatter[i];
            match finder.push(T::from_f64(y)) {
                Some(Finding::Found(comb)) => {
                    outcome.found += 1;
                    let hz = comb.spacing_hz.to_f64();
                    let truth = sound.speed_hz[i];
                    let ratio = (hz / truth).round().max(1.0);
                    if cut.ramp == 0.0 {
                        let error = hz / ratio - truth;
                        outcome.found_error.push(error);
                        outcome
                            .found_over_sd
                            .push(error * ratio / comb.sd_hz.to_f64());
                    }
                    if !started || lines.lock() == Lock::Lost {
                        outcome.lost += u32::from(started);
                        started = true;
                        lines.start(comb.spacing_hz, comb.sd_hz);
                    }
                }
                Some(Finding::NotEstimable) => outcome.none += 1,
                Some(Finding::Contradiction { .. }) => outcome.contradictions += 1,
                None => {}
            }
            out.push(lines.process(T::from_f64(y)).to_f64());
            if lines.lock() == Lock::Locked && locked.is_none() {
                locked = Some(i as f64 / FS);
            }
            if i % 1500 == 0
                && i as f64 > 2.0 * FS
                && lines.lock() == Lock::Locked
                && let Some((hz, sd)) = lines.spindle_hz()
            {
                let truth = sound.speed_hz[i];
                let ratio = (hz.to_f64() / truth).round().max(1.0);
                let error = hz.to_f64() / ratio - truth;
                outcome.tracked_error.push(error);
                if cut.ramp == 0.0 {
                    outcome.tracked_over_sd.push(error * ratio / sd.to_f64());
                }
            }
        }
        if lines.lock() == Lock::Lost {
            outcome.lost += 1;
        }
        outcome.lock_s.extend(locked);
        let part = |from: f64, to: f64| {
            let (from, to) = ((from * FS) as usize, (to * FS) as usize);
            let left: Vec<f64> = (from..to)
                .map(|i| out[i] - sound.rest[i] - sound.chatter[i])
                .collect();
            db((rms(&left) / rms(&sound.lines[from..to])).powi(2))
        };
        if cut.lines_db > -100.0 {
            outcome.left_db.push(part(cut.seconds - 1.0, cut.seconds));
            if cut.ramp != 0.0 {
                outcome.left_ramp_db.push(part(3.0, 5.0));
            }
        }
        if let Some((f, _)) = cut.chatter {
            let from = (2.0 * FS) as usize;
            let rest: Vec<f64> = (from..out.len()).map(|i| out[i] - sound.rest[i]).collect();
            outcome
                .kept
                .push(amplitude(&rest, f) / amplitude(&sound.chatter[from..], f));
        }
    }
    outcome
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// One row of the table.
pub fn print(cut: &Cut, o: &Outcome) {
    let max = |x: &[f64]| x.iter().fold(f64::NAN, |a: f64, b| a.max(*b));
    println!(
        "| {} | {}/{}/{} | {:.3} ({:.2} sd) | {:.3} ({:.2} sd) | {} × {:.2}, {:.2} | {} | {:.1}, {:.1} | {:.1} | {:.2} |",
        cut.name,
        o.found,
        o.none,
        o.contradictions,
        rms(&o.found_error),
        rms(&o.found_over_sd),
        rms(&o.tracked_error),
        rms(&o.tracked_over_sd),
        o.lock_s.len(),
        mean(&o.lock_s),
        max(&o.lock_s),
        o.lost,
        mean(&o.left_db),
        max(&o.left_db),
        max(&o.left_ramp_db),
        o.kept.iter().fold(f64::NAN, |a: f64, b| a.min(*b)),
    );
}

/// Head of the table.
pub fn header() {
    println!(
        "| cut | found/none/contradicted | error of the finder, Hz rms | of the tracking | locked: seeds × mean, latest s | lost | lines left, dB: mean, worst | while ramping | chatter kept, least |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
}
