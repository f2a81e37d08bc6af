//! The state of a cut over time, by the roots of its delay equation.

use crate::PlantError;
use crate::cut::Process;
use crate::delay::Root;
use crate::truth::roots;
use std::collections::BTreeMap;

/// A true operational damping below this may be called or not, 1: nobody would cut there.
pub const LEAST_DAMPING: f64 = 0.005;
/// So may a cut deeper than this part of its limit, 1.
pub const SAFE_PART: f64 = 0.8;
/// Roots looked at for the least damped one: one and a half for each of most modes.
const ROOTS: usize = 6;
/// Pieces a ramp of the depth is judged in.
const RAMP_PIECES: usize = 6;
/// The same where the speed is not the nominal one: each piece has roots of its own there.
const RAMP_PIECES_ELSEWHERE: usize = 3;
/// Pieces a ramp of the speed is judged in.
const SPEED_PIECES: usize = 4;

/// What the machine is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cutting {
    /// Air.
    Air,
    /// Cutting, clearly below the limit.
    Stable,
    /// Between clearly stable and unstable: either answer is right.
    Margin,
    /// Beyond the limit.
    Unstable,
}

impl Cutting {
    /// Of a cut whose least damped root has this damping, whatever its limit is.
    pub(super) fn of(zeta: f64) -> Self {
        if zeta < 0.0 {
            Self::Unstable
        } else if zeta >= LEAST_DAMPING {
            Self::Stable
        } else {
            Self::Margin
        }
    }
}

/// A stretch of time, from its start, s, to the next one's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Start, s.
    pub from_s: f64,
    /// State.
    pub cutting: Cutting,
}

/// State of the cut at `t` s.
pub(super) fn state_at(stretches: &[Stretch], t: f64) -> Cutting {
    let after = stretches.partition_point(|s| s.from_s <= t);
    stretches
        .get(after.saturating_sub(1))
        .map_or(Cutting::Air, |s| s.cutting)
}

/// Stretches near the limit or beyond it, from and to, s.
pub(super) fn either_s(stretches: &[Stretch], end_s: f64) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    for (k, one) in stretches.iter().enumerate() {
        if !matches!(one.cutting, Cutting::Margin | Cutting::Unstable) {
            continue;
        }
        let from_s = one.from_s.max(0.0);
        let to_s = stretches.get(k + 1).map_or(end_s, |next| next.from_s);
        match out.last_mut() {
            _ if to_s <= from_s => {}
            Some(last) if last.1 >= from_s => last.1 = to_s,
            _ => out.push((from_s, to_s)),
        }
    }
    out
}

/// Works out roots, each once.
pub(super) struct Judge<'a> {
    process: &'a Process,
    limit_m: f64,
    known: BTreeMap<(u64, u64), Root>,
}

impl<'a> Judge<'a> {
    /// For a process whose limit at its nominal speed is known, m.
    pub(super) fn new(process: &'a Process, limit_m: f64) -> Self {
        Self {
            process,
            limit_m,
            known: BTreeMap::new(),
        }
    }

    /// The least damped root.
    ///
    /// # Errors
    /// What the plant refuses: a defect of the ranges.
    pub(super) fn root(&mut self, spindle_hz: f64, depth_m: f64) -> Result<Root, PlantError> {
        // The same to a part in ten thousand is the same.
        let part = |x: f64, of: f64| (1e4 * x / of).round() as u64;
        let key = (
            part(spindle_hz, self.process.spindle_hz()),
            part(depth_m, self.limit_m),
        );
        if let Some(root) = self.known.get(&key) {
            return Ok(*root);
        }
        let swings = self.process.variation();
        let here = self
            .process
            .at_spindle_hz(spindle_hz)
            .with_variation(swings);
        // They come by their growth: a slow one may grow faster than a quick one that is
        // less damped.
        // Over the long period of a swing the others are out of reach.
        let wanted = if swings.is_some() { 1 } else { ROOTS };
        let found = roots(&here, 0.0, depth_m, wanted)?;
        let root = found.into_iter().min_by(|a, b| a.zeta.total_cmp(&b.zeta));
        let root = root.ok_or(PlantError::Unsettled)?;
        self.known.insert(key, root);
        Ok(root)
    }

    /// The state from point to point of the schedules of depth and speed.
    ///
    /// # Errors
    /// As [`Judge::root`].
    pub(super) fn stretches(
        &mut self,
        lead_s: f64,
        length_s: f64,
    ) -> Result<Vec<Stretch>, PlantError> {
        let depth = self.process.depth();
        let speed = match self.process {
            Process::Milling(c) => c.speed.as_ref(),
            Process::Turning(_) => None,
        };
        let nominal_hz = self.process.spindle_hz();
        let speed_at = |t: f64| speed.map_or(nominal_hz, |s| s.at(t));
        let end_s = lead_s + length_s;
        let mut times: Vec<f64> = vec![0.0];
        for schedule in [Some(depth), speed].into_iter().flatten() {
            times.extend(schedule.points().iter().map(|p| p.0));
        }
        times.retain(|t| (0.0..end_s).contains(t));
        times.push(end_s);
        times.sort_by(f64::total_cmp);
        times.dedup();
        let mut out: Vec<Stretch> = Vec::new();
        for pair in times.windows(2) {
            let pieces = if depth.at(pair[0]) != depth.at(pair[1]) {
                if speed_at(pair[0]) == nominal_hz && speed_at(pair[1]) == nominal_hz {
                    RAMP_PIECES
                } else {
                    RAMP_PIECES_ELSEWHERE
                }
            } else if speed_at(pair[0]) != speed_at(pair[1]) {
                SPEED_PIECES
            } else {
                1
            };
            for piece in 0..pieces {
                let at = |k: f64| pair[0] + (pair[1] - pair[0]) * k / pieces as f64;
                let middle = at(piece as f64 + 0.5);
                let cutting = self.state(speed_at(middle), depth.at(middle))?;
                let from_s = at(piece as f64) - lead_s;
                if out.last().is_none_or(|last| last.cutting != cutting) {
                    out.push(Stretch { from_s, cutting });
                }
            }
        }
        Ok(out)
    }

    fn state(&mut self, spindle_hz: f64, depth_m: f64) -> Result<Cutting, PlantError> {
        if depth_m <= 0.0 {
            return Ok(Cutting::Air);
        }
        let zeta = self.root(spindle_hz, depth_m)?.zeta;
        if zeta < 0.0 {
            return Ok(Cutting::Unstable);
        }
        if !(zeta >= LEAST_DAMPING) {
            return Ok(Cutting::Margin);
        }
        // The limit is known at the nominal speed only.
        let near = if spindle_hz == self.process.spindle_hz() {
            depth_m > SAFE_PART * self.limit_m
        } else {
            self.root(spindle_hz, depth_m / SAFE_PART)?.zeta < 0.0
        };
        Ok(if near {
            Cutting::Margin
        } else {
            Cutting::Stable
        })
    }
}
