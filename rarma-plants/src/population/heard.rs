//! A cut as it is recorded, and when its chatter can be heard.
//!
//! The same cut is played twice: as it is, and driven by the forces of a rigid tool
//! ([`Contact::Rigid`]), which is forced vibration and nothing else. What differs, and does
//! not repeat from turn to turn, is fed by the cut. Its part of the power in the band says
//! when chatter can be heard: no detector and no spectrum is asked.

use super::play::{Motion, borders_s, play};
use super::state::{Cutting, Stretch, state_at};
use super::{Cut, line, ranges as r};
use crate::PlantError;
use crate::converter::{Converter, ConverterConfig};
use crate::cut::Process;
use crate::process::Contact;
use rarma_core::condition::{Band, BandFilter};

/// Chatter can be heard where it holds this part of the band's power.
pub const AUDIBLE: f64 = 0.2;
/// Power is looked at in windows of this length, s, one beginning every [`HOP_S`].
const WINDOW_S: f64 = 0.05;
/// See [`WINDOW_S`].
const HOP_S: f64 = 0.01;
/// Chatter that pauses for less is one; one that is shorter than this is none, s.
const PAUSE_S: f64 = 0.2;
/// Steps of the machine per sample, least.
const LEAST_OVERSAMPLING: f64 = 1.05;
/// Range and bits before the room is added: nothing is lost in them.
const WIDE: ConverterConfig = ConverterConfig {
    full_scale: 1e5,
    bits: 32,
    dither: false,
};

/// A recording with its truth.
#[derive(Clone, Debug)]
pub struct Heard {
    /// Sampling rate, Hz.
    pub fs_hz: f64,
    /// Samples, parts of full scale.
    pub samples: Vec<f32>,
    /// When chatter can be heard, from and to, s.
    pub chatter_s: Vec<(f64, f64)>,
    /// Lowest and highest frequency of the strongest line of what the cut feeds
    /// while it can be heard, Hz: as recorded, folded where the sampler folds.
    pub chatter_hz: Option<(f64, f64)>,
    /// Root of the mean square of the forced vibration in the band, while it cuts, parts of full scale: what the levels of
    /// the room are over.
    pub reference: f64,
}

/// A recording's part in the monitor's band, and its rate, Hz.
fn in_band(fs_hz: f64, sound: impl Iterator<Item = f64>) -> (Vec<f64>, f64) {
    let Ok(mut filter) = BandFilter::<f64>::new(Band::usual(fs_hz), fs_hz) else {
        return (Vec::new(), fs_hz);
    };
    let rate_hz = fs_hz / filter.factor() as f64;
    (sound.filter_map(|x| filter.process(x)).collect(), rate_hz)
}

/// Power in windows, one beginning every [`HOP_S`].
fn powers((sound, fs_hz): &(Vec<f64>, f64)) -> Vec<f64> {
    let squares: Vec<f64> = sound.iter().map(|y| y * y).collect();
    let window = ((WINDOW_S * fs_hz) as usize).max(1);
    // A hop is no whole number of samples at every rate.
    (0..)
        .map(|k| (f64::from(k) * HOP_S * fs_hz).round() as usize)
        .map_while(|from| squares.get(from..from + window))
        .map(|w| w.iter().sum::<f64>() / window as f64)
        .collect()
}

/// Plays, adds the room, samples.
///
/// # Errors
/// What the plant refuses: a defect of the ranges.
pub(super) fn hear(cut: &Cut) -> Result<Heard, PlantError> {
    let (sensor, planned) = (&cut.sensor, &cut.planned);
    let stretches = &planned.stretches;
    let mut process = planned.process.clone();
    let rate_hz = match &mut process {
        Process::Milling(c) => &mut c.min_step_rate_hz,
        Process::Turning(c) => &mut c.min_step_rate_hz,
    };
    // The sampler must not be faster than the machine's steps.
    *rate_hz = rate_hz.max(LEAST_OVERSAMPLING * sensor.inner_hz());
    let length_s = planned.lead_s + planned.length_s;
    let listens = sensor.microphone(WIDE);
    let skipped = (planned.lead_s * sensor.inner_hz()).round() as usize;
    let sound = |motion: &Motion| -> Result<Vec<f64>, PlantError> {
        Ok(motion.sound(&listens, length_s)?.split_off(skipped))
    };
    let actual = play(&process, Contact::Real, &listens, length_s)?;
    let rigid = play(&process, Contact::Rigid, &listens, length_s)?;
    let borders_s = borders_s(&process);
    let mut all = sound(&actual)?;
    let forced = sound(&rigid)?;
    let own = sound(&actual.clone().free(&borders_s))?;
    let beyond = actual.beyond(&rigid);
    drop(rigid);
    // What a sampler folds is in the recording, too.
    let recorded =
        |x: &mut dyn Iterator<Item = f64>| in_band(sensor.fs_hz, &mut x.step_by(sensor.folds));
    let cutting = |k: usize| state_at(stretches, k as f64 * HOP_S) != Cutting::Air;
    let quiet = powers(&recorded(&mut forced.iter().copied()));
    let (sum, count) = quiet
        .iter()
        .enumerate()
        .filter(|(k, _)| cutting(*k))
        .fold((0.0, 0), |(s, n), (_, p)| (s + p, n + 1));
    let reference = (sum / f64::from(count.max(1))).sqrt();
    drop(forced);
    let there = recorded(&mut all.iter().copied());
    let added = recorded(&mut sound(&beyond)?.into_iter());
    let (free, own) = if planned.on_multiple {
        (added.clone(), there.clone())
    } else {
        (
            recorded(&mut sound(&beyond.free(&borders_s))?.into_iter()),
            recorded(&mut own.into_iter()),
        )
    };
    cut.room.add_to(&mut all, sensor.inner_hz(), reference);
    let heard = powers(&recorded(&mut all.iter().copied()));
    // What is not there at all is no more free than what repeats: in the first turns of a
    // cut the mean is not yet that of what is there. And no more than the cut itself holds,
    // free or not: where it swings less than a rigid tool would make it, nothing is fed.
    let fed = [powers(&free), powers(&own), powers(&there)];
    let shares: Vec<f64> = powers(&added)
        .iter()
        .zip(&heard)
        .enumerate()
        .map(|(k, (added, heard))| {
            let least = fed
                .iter()
                .filter_map(|p| p.get(k))
                .fold(*added, |a, b| a.min(*b));
            least / heard.max(f64::MIN_POSITIVE)
        })
        .collect();
    let all: Vec<f64> = all.into_iter().step_by(sensor.folds).collect();
    let full_scale = sensor.full_scale(&all);
    let mut converter = Converter::new(
        ConverterConfig {
            full_scale,
            bits: sensor.bits,
            dither: true,
        },
        cut.seed,
    )?;
    let chatter_s = audible(&shares, stretches);
    Ok(Heard {
        fs_hz: sensor.fs_hz,
        samples: all.iter().map(|x| converter.convert(*x).value).collect(),
        chatter_hz: line::range_hz(&free.0, free.1, &chatter_s),
        chatter_s,
        reference: reference / full_scale,
    })
}

/// Stretches in which self-excitation holds its part of the power. They begin in an
/// unstable cut, and end when the part falls below half of that.
fn audible(shares: &[f64], stretches: &[Stretch]) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    let mut since: Option<f64> = None;
    let mut close = |from: f64, to: f64| match out.last_mut() {
        Some(last) if from - last.1 < PAUSE_S => last.1 = to,
        _ => out.push((from, to)),
    };
    for (k, share) in shares.iter().enumerate() {
        // A window is known at its end.
        let t = k as f64 * HOP_S + WINDOW_S;
        match since {
            None => {
                if *share >= AUDIBLE && state_at(stretches, t) == Cutting::Unstable {
                    since = Some(t);
                }
            }
            Some(from) => {
                if *share < 0.5 * AUDIBLE {
                    close(from, t);
                    since = None;
                }
            }
        }
    }
    if let Some(from) = since {
        close(from, shares.len() as f64 * HOP_S + WINDOW_S);
    }
    out.retain(|(from, to)| to - from >= PAUSE_S);
    out
}

/// Clearly stable cutting between two times, away from chatter that can be heard, s.
pub(super) fn quiet_s(
    stretches: &[Stretch],
    chatter_s: &[(f64, f64)],
    (from_s, to_s): (f64, f64),
) -> f64 {
    let hops = ((from_s / HOP_S).ceil() as usize)..((to_s / HOP_S).ceil() as usize);
    let quiet = hops.filter(|k| {
        let t = *k as f64 * HOP_S;
        let near = chatter_s
            .iter()
            .any(|(from, to)| t > from - super::SLACK_S && t < to + super::SLACK_S);
        !near && state_at(stretches, t) == Cutting::Stable
    });
    quiet.count() as f64 * HOP_S
}

/// Whether nobody could tell: a tone in the band, as loud as a chatter that can just be
/// heard, that was never heard without the cut before.
pub(super) fn undecidable(cut: &Cut) -> bool {
    let stretches = &cut.planned.stretches;
    let band = Band::usual(cut.sensor.fs_hz);
    cut.room.lines().any(|tone| {
        let loud = tone.level_db >= r::UNDECIDABLE_DB;
        let inside = (band.low_hz..band.high_hz).contains(&tone.f_hz);
        let begins_s = tone.on_s.0.max(0.0);
        let over = tone.on_s.1 <= 0.0 || begins_s >= cut.planned.length_s;
        let alone = [0.0, 0.5 * r::KNOWN_S, r::KNOWN_S]
            .iter()
            .all(|t| state_at(stretches, begins_s + t) == Cutting::Air);
        loud && inside && !over && !alone
    })
}
