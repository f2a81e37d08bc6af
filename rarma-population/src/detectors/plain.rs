//! What a user could write in ten lines, and the monitor must beat: the largest peak of
//! the spectrum that lies on no multiple of the told speed holds a part of the band's
//! power for a while.
//!
//! It needs the exact speed; without one every peak counts.

use super::{Detector, Recording, Said, Speed};
use crate::Defect;
use rarma_core::condition::{Band, BandFilter};

/// Between two looks, s.
const HOP_S: f64 = 0.05;
/// Looks in a row that must show it: 0.3 s.
const HELD: usize = 6;
/// Quieter than this part of the loudest so far (root mean square) is no cut.
const QUIET: f64 = 0.25;

/// The peak's part of the power.
pub(super) struct Plain;

impl Detector for Plain {
    fn name(&self) -> &'static str {
        "plain"
    }

    fn threshold(&self) -> &'static str {
        "part of the band's power in its largest peak off the multiples, 1"
    }

    fn thresholds(&self) -> &'static [f64] {
        &[0.21, 0.1, 0.15, 0.3, 0.4, 0.5, 0.65]
    }

    fn listen(&self, recording: &Recording, thresholds: &[f64]) -> Result<Vec<Said>, Defect> {
        Ok(said(
            recording.samples(),
            recording.fs_hz(),
            &recording.speed,
            thresholds,
        ))
    }
}

/// One look: time s, part of the power, frequency Hz.
struct Look {
    t_s: f64,
    part: f64,
    f_hz: f64,
}

/// What is said at each of several parts of the power.
fn said(samples: &[f32], fs_hz: f64, speed: &Speed, parts: &[f64]) -> Vec<Said> {
    let looks = looks(samples, fs_hz, speed);
    let held: Vec<f64> = (0..looks.len())
        .map(|i| match (i + 1).checked_sub(HELD) {
            Some(from) => looks[from..=i]
                .iter()
                .map(|l| l.part)
                .fold(f64::INFINITY, f64::min),
            None => 0.0,
        })
        .collect();
    parts
        .iter()
        .map(|part| {
            let mut said = Said::default();
            for (look, held) in looks.iter().zip(&held) {
                if held > part {
                    said.calls(look.t_s, look.t_s + HOP_S, look.f_hz);
                }
            }
            said
        })
        .collect()
}

fn looks(samples: &[f32], fs_hz: f64, speed: &Speed) -> Vec<Look> {
    let band = Band::usual(fs_hz);
    let Ok(mut filter) = BandFilter::<f64>::new(band, fs_hz) else {
        return Vec::new();
    };
    let fs = fs_hz / filter.factor() as f64;
    let y: Vec<f64> = samples
        .iter()
        .filter_map(|x| filter.process(f64::from(*x)))
        .collect();
    let length_s = match fs {
        f if f > 5000.0 => 0.25,
        f if f > 1000.0 => 0.5,
        _ => 1.5,
    };
    let window = (length_s * fs) as usize;
    let hop = ((HOP_S * fs) as usize).max(1);
    let n = (2 * window).next_power_of_two();
    let transform = rarma_fourier::forward(n);
    let mut lines = transform.make_output_vec();
    let mut input = transform.make_input_vec();
    // A line is as wide as the window makes it.
    let width_hz = 2.0 * fs / window as f64;
    let at = |k: usize| k as f64 * fs / n as f64;
    let count = lines.len();
    let usable_at = |turn_hz: Option<f64>| -> Vec<(bool, bool)> {
        let forced = |f_hz: f64| {
            turn_hz.is_some_and(|turn| {
                turn >= 4.0 * width_hz && (f_hz - (f_hz / turn).round() * turn).abs() < width_hz
            })
        };
        (0..count)
            .map(|k| {
                let inside = at(k) >= band.low_hz && at(k) <= band.high_hz;
                (inside, inside && !forced(at(k)))
            })
            .collect()
    };
    let mut turn_hz = speed.first_hz();
    let mut usable = usable_at(turn_hz);
    let mut loudest = 0.0_f64;
    let mut out = Vec::new();
    let mut from = 0;
    while let Some(part) = y.get(from..from + window) {
        let t_s = (from + window) as f64 / fs;
        let now_hz = speed.known_hz(t_s);
        if now_hz != turn_hz {
            turn_hz = now_hz;
            usable = usable_at(turn_hz);
        }
        let rms = (part.iter().map(|x| x * x).sum::<f64>() / window as f64).sqrt();
        loudest = loudest.max(rms);
        input.fill(0.0);
        for (k, (to, x)) in input.iter_mut().zip(part).enumerate() {
            let turn = std::f64::consts::TAU * k as f64 / window as f64;
            *to = 0.5 * (1.0 - turn.cos()) * x;
        }
        if transform.process(&mut input, &mut lines).is_err() {
            break;
        }
        let power: Vec<f64> = lines.iter().map(|z| z.norm_sqr()).collect();
        let sum = |pick: &dyn Fn(usize) -> bool| -> f64 {
            (0..power.len())
                .filter(|k| pick(*k))
                .map(|k| power[k])
                .sum()
        };
        let total = sum(&|k| usable[k].0);
        let peak = (0..power.len())
            .filter(|k| usable[*k].1)
            .max_by(|a, b| power[*a].total_cmp(&power[*b]))
            .unwrap_or(0);
        let line = sum(&|k| usable[k].1 && (at(k) - at(peak)).abs() < width_hz);
        out.push(Look {
            t_s,
            part: if rms > QUIET * loudest && total > 0.0 {
                line / total
            } else {
                0.0
            },
            f_hz: at(peak),
        });
        from += hop;
    }
    out
}
