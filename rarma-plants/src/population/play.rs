//! The machine of a cut at work, with its own forces and with those of a rigid tool, step by
//! step; and what of the difference is free of the rotation.
//!
//! A chip that follows the motion does two things: it changes the lines that the rotation
//! forces, and it feeds a vibration of its own. Only the second is chatter. What repeats from turn to
//! turn is the first: its mean over turns is taken out, cell by cell of the turn.

use crate::PlantError;
use crate::cut::{Machine, Process};
use crate::milling::MillSample;
use crate::process::{Contact, Schedule};
use crate::sound::{Microphone, MicrophoneConfig, Pickup};

/// The mean is taken over so many turns before and after, at least, and over this time,
/// s: what lies within 1/(their time) of a multiple is taken for forced.
const TURNS: usize = 5;
/// See [`TURNS`].
const TIME_S: f64 = 0.2;
/// Fewer turns than this have no mean to speak of: nothing is taken for free in them.
const LEAST_TURNS: usize = 3;

/// What a sensor at the machine feels, step by step.
#[derive(Clone)]
pub(super) struct Motion {
    /// Steps in a turn.
    per_turn: usize,
    /// Time of each step, s.
    times_s: Vec<f64>,
    /// What is felt.
    felt: Vec<f64>,
    rate_hz: f64,
    timed: bool,
}

/// Plays a process for so long, s.
///
/// # Errors
/// What the plant refuses: a defect of the ranges.
pub(super) fn play(
    process: &Process,
    contact: Contact,
    listens: &MicrophoneConfig,
    length_s: f64,
) -> Result<Motion, PlantError> {
    let mut process = process.clone();
    match &mut process {
        Process::Milling(c) => c.contact = contact,
        Process::Turning(c) => c.contact = contact,
    }
    let mut machine = Machine::new(&process)?;
    let mut out = Motion {
        per_turn: match &machine {
            Machine::Milling(m) => m.steps_per_tooth() * m.config().teeth,
            Machine::Turning(m) => m.steps_per_turn(),
        },
        times_s: Vec::new(),
        felt: Vec::new(),
        rate_hz: machine.step_rate_hz(),
        timed: machine.changes_speed(),
    };
    loop {
        let s = machine.step();
        let m = match listens.pickup {
            Pickup::Acceleration => s.sensor[2],
            Pickup::Velocity => s.sensor[1],
            Pickup::Displacement => s.sensor[0],
        };
        out.times_s.push(s.t);
        out.felt
            .push(listens.gain[0] * m[0] + listens.gain[1] * m[1]);
        if s.t >= length_s {
            return Ok(out);
        }
    }
}

impl Motion {
    /// What reaches the converter, in its unit.
    ///
    /// # Errors
    /// As [`play`].
    pub(super) fn sound(
        &self,
        listens: &MicrophoneConfig,
        length_s: f64,
    ) -> Result<Vec<f64>, PlantError> {
        let config = MicrophoneConfig {
            gain: [1.0, 0.0],
            ..listens.clone()
        };
        let count = (length_s * config.sample_rate_hz).round() as usize;
        let full_scale = config.converter.full_scale;
        let mut microphone = if self.timed {
            Microphone::timed(config, self.rate_hz)?
        } else {
            Microphone::new(config, self.rate_hz)?
        };
        let last = self.times_s.last().copied().unwrap_or(0.0);
        let mut steps = self.times_s.iter().zip(&self.felt);
        let mut beyond = 0.0;
        Ok((0..count)
            .map(|_| {
                let reading = microphone.next_reading(|| {
                    // The filter looks a little ahead of the last sample.
                    let (t, felt) = steps.next().map_or_else(
                        || {
                            beyond += 1.0;
                            (last + beyond / self.rate_hz, 0.0)
                        },
                        |(t, felt)| (*t, *felt),
                    );
                    MillSample {
                        t,
                        sensor: [[felt, 0.0]; 3],
                        ..MillSample::default()
                    }
                });
                full_scale * f64::from(reading.value)
            })
            .collect())
    }

    /// The difference to another that was played alike.
    pub(super) fn beyond(mut self, other: &Self) -> Self {
        for (a, b) in self.felt.iter_mut().zip(&other.felt) {
            *a -= b;
        }
        self
    }

    /// Without what repeats from turn to turn between two of these times, s.
    pub(super) fn free(mut self, borders_s: &[f64]) -> Self {
        let mut from = 0;
        let ends = borders_s
            .iter()
            .map(|t| self.times_s.partition_point(|s| s < t))
            .chain([self.felt.len()]);
        let ends: Vec<usize> = ends.collect();
        for to in ends {
            if to > from {
                let turn_s = self.per_turn as f64 * self.step_s(from, to);
                let reach = ((TIME_S / turn_s) as usize).max(TURNS);
                without_mean(&mut self.felt[from..to], self.per_turn, reach);
                from = to;
            }
        }
        self
    }

    fn step_s(&self, from: usize, to: usize) -> f64 {
        let steps = (to - 1 - from).max(1) as f64;
        ((self.times_s[to - 1] - self.times_s[from]) / steps).max(1.0 / self.rate_hz)
    }
}

/// Takes the mean over `reach` turns before and after out of each cell of the turn.
fn without_mean(felt: &mut [f64], per_turn: usize, reach: usize) {
    if felt.len() < LEAST_TURNS * per_turn {
        felt.fill(0.0);
        return;
    }
    let mut cell: Vec<f64> = Vec::new();
    for first in 0..per_turn {
        cell.clear();
        cell.extend(felt[first..].iter().step_by(per_turn));
        let mut sum: f64 = cell.iter().take(reach).sum();
        let mut count = cell.len().min(reach);
        for (turn, x) in felt[first..].iter_mut().step_by(per_turn).enumerate() {
            if let Some(next) = cell.get(turn + reach) {
                sum += next;
                count += 1;
            }
            if let Some(old) = (turn + 1).checked_sub(reach + 2) {
                sum -= cell[old];
                count -= 1;
            }
            *x -= sum / count as f64;
        }
    }
}

/// Times at which a schedule bends, s.
pub(super) fn borders_s(process: &Process) -> Vec<f64> {
    let speed = match process {
        Process::Milling(c) => c.speed.as_ref(),
        Process::Turning(_) => None,
    };
    let mut out: Vec<f64> = [Some(process.depth()), speed]
        .into_iter()
        .flatten()
        .flat_map(Schedule::points)
        .map(|p| p.0)
        .collect();
    out.sort_by(f64::total_cmp);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    /// A line on a multiple goes, one between two multiples stays.
    #[test]
    fn what_repeats_goes_and_what_is_free_stays() {
        let per_turn = 100;
        let power = |turns_per_wave: f64| {
            let mut x: Vec<f64> = (0..4000)
                .map(|n| (TAU * turns_per_wave * f64::from(n) / 100.0).sin())
                .collect();
            without_mean(&mut x, per_turn, 5);
            x.iter().map(|x| x * x).sum::<f64>() / 4000.0
        };
        assert!(power(7.0) < 1e-20);
        assert!((power(7.41) - 0.5).abs() < 0.1, "{}", power(7.41));
    }
}
