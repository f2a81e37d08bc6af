//! The same cut changed in a way that should not matter: how often is the answer another?

use super::detectors::{ALL, Recording, Said, named};
use super::score::judge;
use crate::Defect;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rarma_core::Order;
use rarma_plants::population::Cut;
use rarma_plants::population::heard::Heard;

/// What should not matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// The recording begins so much later, s.
    Later(f64),
    /// The amplifier is set to this part.
    Gain(f32),
    /// White noise, of this part of the recording's root of the mean square.
    Noise(f64),
    /// Another sampling rate, this part of it.
    Rate(usize, usize),
    /// Another order of the model.
    Order(Order),
}

/// All that are tried.
pub const CHANGES: [Change; 7] = [
    Change::Later(0.05),
    Change::Later(0.33),
    Change::Gain(0.2),
    Change::Noise(1e-3),
    // 48 kHz to 44.1 kHz.
    Change::Rate(147, 160),
    Change::Order(Order::O65),
    Change::Order(Order::O43),
];

/// Answers of one change, over many cuts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Flips {
    /// Cuts with chatter that was under way, or began, after the new start.
    pub chatters: u32,
    /// Of them, those of which only one of the two was called.
    pub other_chatters: u32,
    /// Cuts without chatter.
    pub quiet: u32,
    /// Of them, those of which only one has a false alarm.
    pub other_quiet: u32,
}

impl Flips {
    /// Adds those of a cut.
    pub fn add(&mut self, more: Self) {
        self.chatters += more.chatters;
        self.other_chatters += more.other_chatters;
        self.quiet += more.quiet;
        self.other_quiet += more.other_quiet;
    }

    /// The part of the answers that is another.
    pub fn part(&self) -> Option<f64> {
        let all = self.chatters + self.quiet;
        let others = self.other_chatters + self.other_quiet;
        (all > 0).then(|| f64::from(others) / f64::from(all))
    }
}

impl Change {
    /// For tables.
    pub fn name(self) -> String {
        match self {
            Self::Later(s) => format!("begins {s} s later"),
            Self::Gain(gain) => format!("{gain} of the gain"),
            Self::Noise(part) => format!("noise {:.0} dB below", -20.0 * part.log10()),
            Self::Rate(of, all) => format!("{of}/{all} of the sampling rate"),
            Self::Order(order) => format!("order ({},{})", order.p(), order.q()),
        }
    }

    /// How much earlier everything is in the changed recording, s.
    fn shift_s(self) -> f64 {
        if let Self::Later(s) = self { s } else { 0.0 }
    }

    /// The changed recording.
    fn of(self, heard: &Heard, seed: u64) -> Heard {
        let mut changed = heard.clone();
        match self {
            Self::Later(s) => {
                let from = ((s * heard.fs_hz).round() as usize).min(heard.samples.len());
                changed.samples.drain(..from);
            }
            Self::Gain(gain) => changed.samples.iter_mut().for_each(|x| *x *= gain),
            Self::Noise(part) => {
                let power: f64 = heard.samples.iter().map(|x| f64::from(*x).powi(2)).sum();
                let rms = (power / heard.samples.len().max(1) as f64).sqrt();
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                for x in &mut changed.samples {
                    let noise: f64 = StandardNormal.sample(&mut rng);
                    *x += (part * rms * noise) as f32;
                }
            }
            Self::Rate(of, all) => resample(&mut changed, of, all),
            Self::Order(_) => {}
        }
        changed
    }
}

/// Another sampling rate: what lies above half of it is gone, all else is as it was.
fn resample(heard: &mut Heard, of: usize, all: usize) {
    let blocks = heard.samples.len() / all;
    let (length, new) = (blocks * all, blocks * of);
    heard.samples.truncate(length);
    let (forward, back) = (rarma_fourier::forward(length), rarma_fourier::inverse(new));
    let mut whole: Vec<f64> = heard.samples.iter().map(|x| f64::from(*x)).collect();
    let (mut spectrum, mut samples) = (forward.make_output_vec(), back.make_output_vec());
    // Both lengths are right, so that neither can fail.
    let _ = forward.process(&mut whole, &mut spectrum);
    spectrum.resize(new / 2 + 1, Default::default());
    // The first, and the last where there is one of half the rate, are real.
    if let Some(last) = spectrum.last_mut()
        && new % 2 == 0
    {
        last.im = 0.0;
    }
    let _ = back.process(&mut spectrum, &mut samples);
    heard.samples = samples.iter().map(|x| (x / length as f64) as f32).collect();
    heard.fs_hz *= of as f64 / all as f64;
}

/// Listens to a cut as it is, and with every change; what was said is moved to the cut's time.
///
/// # Errors
/// The recording does not suit the monitor: a defect of the population.
pub fn flips(cut: &Cut, heard: &Heard, as_it_is: &Recording) -> Result<Vec<Flips>, Defect> {
    let Some(monitor) = named("monitor").map(|place| ALL[place]) else {
        return Ok(Vec::new());
    };
    let threshold = &monitor.thresholds()[..1];
    let says = |recording: &Recording, shift_s: f64| -> Result<bool, Defect> {
        let mut said = monitor.listen(recording, threshold)?;
        let mut said: Said = said.pop().unwrap_or_default();
        said.begin_later(-shift_s);
        let score = judge(cut, heard, &said, 0.0);
        Ok(if score.chatter {
            score.hit
        } else {
            score.false_alarms > 0
        })
    };
    let usual = says(as_it_is, 0.0)?;
    CHANGES
        .iter()
        .map(|change| {
            if matches!(change, Change::Rate(..)) && as_it_is.aliased {
                // Its lines are folded about a rate that would no longer be the recording's.
                return Ok(Flips::default());
            }
            let changed = change.of(heard, cut.seed);
            let mut recording = as_it_is.of(&changed);
            recording.speed = as_it_is.speed.later(change.shift_s());
            if let Change::Order(order) = change {
                recording.order = *order;
            }
            let is_other = u32::from(says(&recording, change.shift_s())? != usual);
            let has_chatter = !heard.chatter_s.is_empty();
            Ok(Flips {
                chatters: u32::from(has_chatter),
                other_chatters: if has_chatter { is_other } else { 0 },
                quiet: u32::from(!has_chatter),
                other_quiet: if has_chatter { 0 } else { is_other },
            })
        })
        .collect()
}

/// A change's row.
pub fn cells(change: Change, flips: &Flips) -> [String; 4] {
    let part = flips
        .part()
        .map_or("-".to_owned(), |part| format!("{:.1}", 100.0 * part));
    let of = |others: u32, all: u32| format!("{others} of {all}");
    [
        change.name(),
        of(flips.other_chatters, flips.chatters),
        of(flips.other_quiet, flips.quiet),
        part,
    ]
}

/// What [`cells`] are.
pub const HEAD: [&str; 4] = [
    "change",
    "chatters answered otherwise",
    "quiet cuts answered otherwise",
    "of all, %",
];

#[cfg(test)]
mod tests {
    use super::*;

    fn heard() -> Heard {
        Heard {
            fs_hz: 1000.0,
            samples: (0..2000).map(|n| (n as f32 * 0.7).sin()).collect(),
            chatter_s: vec![(0.5, 1.0)],
            chatter_hz: None,
            reference: 0.1,
        }
    }

    fn power(samples: &[f32]) -> f64 {
        samples.iter().map(|x| f64::from(*x).powi(2)).sum()
    }

    #[test]
    fn changes_are_what_they_say() {
        let usual = heard();
        let later = Change::Later(0.33).of(&usual, 1);
        assert_eq!(later.samples[..], usual.samples[330..]);
        let quieter = Change::Gain(0.2).of(&usual, 1);
        let ratio = power(&quieter.samples) / power(&usual.samples);
        assert!((ratio - 0.04).abs() < 1e-5, "{ratio}");
        let noisy = Change::Noise(1e-3).of(&usual, 1);
        let added: Vec<f32> = noisy
            .samples
            .iter()
            .zip(&usual.samples)
            .map(|(a, b)| a - b)
            .collect();
        let below_db = 10.0 * (power(&added) / power(&usual.samples)).log10();
        assert!((-61.0..-59.0).contains(&below_db), "{below_db}");
        let slower = Change::Rate(4, 5).of(&usual, 1);
        assert_eq!((slower.fs_hz, slower.samples.len()), (800.0, 1600));
        for (n, x) in slower.samples.iter().enumerate().skip(100).take(1400) {
            let wanted = (n as f64 * 1.25 * 0.7).sin();
            assert!(
                (f64::from(*x) - wanted).abs() < 0.01,
                "{n}: {x} for {wanted}"
            );
        }
        assert_eq!(
            Change::Order(Order::O43).of(&usual, 1).samples,
            usual.samples
        );
    }
}
