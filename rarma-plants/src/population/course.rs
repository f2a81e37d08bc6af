//! What is done with a machine over time: air, entry, depth, exit, changes of speed.

use super::machine::Machine;
use super::ranges::{self as r, chance, one_of};
use super::state::{Cutting, Judge, Stretch};
use crate::PlantError;
use crate::cut::Process;
use crate::process::Schedule;
use crate::variation::SpeedVariation;
use rand_chacha::ChaCha8Rng;

/// Chatter nearer to a multiple of the speed than this part of it, and than [`NEAR_HZ`],
/// is on it: turns do not tell the two apart (see the turns of the mean in play.rs).
const NEAR_TURNS: f64 = 0.055;
/// See [`NEAR_TURNS`].
const NEAR_HZ: f64 = 1.5;

/// A speed that swings is told straight between points this far apart, s: at four swings a
/// second and RVA 0.2 that is off by 0.02 %.
const SWING_EVERY_S: f64 = 0.002;
/// Before a steady cut begins, and how long the tool takes into it, s.
const STEADY: (f64, f64) = (0.5, 0.1);

/// How a cut comes and goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Course {
    /// Under way before the first sample.
    AtFirst,
    /// From air into the cut.
    Entry,
    /// From air, then deeper and deeper.
    Grows,
    /// In and out several times.
    ComesAndGoes,
}

impl Course {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::AtFirst, Self::Entry, Self::Grows, Self::ComesAndGoes];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::AtFirst => "at the first sample",
            Self::Entry => "entry",
            Self::Grows => "grows",
            Self::ComesAndGoes => "comes and goes",
        }
    }
}

/// How a speed changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Changes {
    /// The override is turned quickly.
    pub steps: bool,
    /// The override is turned slowly.
    pub ramps: bool,
    /// It runs up before the cut.
    pub run_up: bool,
}

/// A cut over time.
#[derive(Clone, Debug)]
pub(super) struct Planned {
    pub process: Process,
    pub course: Course,
    /// How its speed changes.
    pub changes: Changes,
    /// The tool leaves the cut before the end.
    pub exits: bool,
    /// At full depth and nominal speed the dominant root lies on a multiple of the speed:
    /// a flip of an even number of teeth, or by chance.
    pub on_multiple: bool,
    /// Simulated before the recording begins, s; stretches are in time of the recording.
    pub lead_s: f64,
    pub length_s: f64,
    pub stretches: Vec<Stretch>,
    /// Frequency and damping of the least damped root at full depth and nominal speed.
    pub operational: (f64, f64),
    /// Full depth over the limit at the nominal speed.
    pub limit_part: f64,
}

impl Planned {
    /// Spindle speed at a time of the recording, s, Hz.
    pub(super) fn speed_at(&self, t_s: f64) -> f64 {
        match &self.process {
            Process::Milling(c) => c.spindle_at(t_s + self.lead_s),
            Process::Turning(c) => c.spindle_at(t_s + self.lead_s),
        }
    }

    /// Spindle speed over time, straight between points: (s of the recording, Hz).
    pub(super) fn speeds(&self) -> Vec<(f64, f64)> {
        let nominal = self.process.spindle_hz();
        if self.process.variation().is_some() {
            let count = (self.length_s / SWING_EVERY_S).ceil() as u32;
            let times = (0..=count).map(|k| f64::from(k) * SWING_EVERY_S);
            return times.map(|t| (t, self.speed_at(t))).collect();
        }
        let Process::Milling(c) = &self.process else {
            return vec![(0.0, nominal)];
        };
        let Some(speed) = &c.speed else {
            return vec![(0.0, nominal)];
        };
        let mut out = vec![(0.0, speed.at(self.lead_s))];
        let later = speed.points().iter().filter(|p| p.0 > self.lead_s);
        out.extend(later.map(|p| (p.0 - self.lead_s, p.1)));
        out
    }
}

/// Draws what happens and works out what follows.
///
/// # Errors
/// What the plant refuses: a defect of the ranges.
pub(super) fn plan(rng: &mut ChaCha8Rng, machine: &Machine) -> Result<Planned, PlantError> {
    let part = {
        let u: f64 = r::Span::even(0.0, 1.0).draw(rng);
        let (deep, between) = r::DEEP_BETWEEN;
        if u < deep {
            r::DEEP.draw(rng)
        } else if u < deep + between {
            r::BETWEEN.draw(rng)
        } else {
            r::SHALLOW.draw(rng)
        }
    };
    let depth_m = part * machine.limit_m;
    let length_s = r::LENGTH_S.draw(rng);
    let course = one_of(rng, &Course::ALL);
    let lead_s = match course {
        Course::AtFirst => r::LEAD_S,
        _ => 0.0,
    };
    let depth = depths(rng, course, depth_m, length_s)?;
    let air_s = match course {
        Course::AtFirst => 0.0,
        _ => depth.points().first().map_or(0.0, |p| p.0),
    };
    let exits = depth.points().last().is_some_and(|p| p.1 == 0.0);
    let mut process = machine.process.at_depth(depth);
    let mut changes = Changes::default();
    if let Process::Milling(c) = &mut process {
        let (speed, how) = speeds(rng, c.spindle_hz, air_s, (lead_s, length_s))?;
        c.speed = speed;
        changes = how;
    }
    let mut judge = Judge::new(&process, machine.limit_m);
    let root = judge.root(process.spindle_hz(), depth_m)?;
    let turn_hz = process.spindle_hz();
    let nearest_hz = (root.f_hz / turn_hz).round() * turn_hz;
    let near_hz = (NEAR_TURNS * turn_hz).min(NEAR_HZ);
    Ok(Planned {
        stretches: judge.stretches(lead_s, length_s)?,
        operational: (root.f_hz, root.zeta),
        on_multiple: (root.f_hz - nearest_hz).abs() < near_hz,
        process,
        course,
        changes,
        exits,
        lead_s,
        length_s,
        limit_part: part,
    })
}

/// The machine of a plan in a steady cut: from air into full depth, and so to the end, with a
/// speed that is constant or swings.
///
/// # Errors
/// What the plant refuses; `Unsettled` where the truth of the swing cannot be told.
pub(super) fn steady(
    planned: &Planned,
    variation: Option<SpeedVariation>,
    length_s: f64,
) -> Result<Planned, PlantError> {
    let full_m = planned.process.depth().largest();
    let in_s = STEADY.0 + STEADY.1;
    let depth = Schedule::new(&[(STEADY.0, 0.0), (in_s, full_m)])?;
    let hz = planned.process.spindle_hz();
    let process = planned.process.at_spindle_hz(hz).at_depth(depth);
    let process = process.with_variation(variation);
    let root = Judge::new(&process, full_m).root(hz, full_m)?;
    let stretch = |from_s: f64, cutting: Cutting| Stretch { from_s, cutting };
    let stretches = vec![
        stretch(0.0, Cutting::Air),
        stretch(STEADY.0, Cutting::Margin),
        stretch(in_s, Cutting::of(root.zeta)),
    ];
    Ok(Planned {
        course: Course::Entry,
        changes: Changes::default(),
        exits: false,
        lead_s: 0.0,
        length_s,
        stretches,
        operational: (root.f_hz, root.zeta),
        process,
        ..planned.clone()
    })
}

fn depths(
    rng: &mut ChaCha8Rng,
    course: Course,
    depth_m: f64,
    length_s: f64,
) -> Result<Schedule, PlantError> {
    if course == Course::AtFirst {
        return Ok(Schedule::constant(depth_m));
    }
    let mut t = r::AIR_S.draw(rng);
    let mut points = vec![(t, 0.0)];
    match course {
        Course::Grows => {
            t += r::ENTRY_S.draw(rng);
            points.push((t, 0.3 * depth_m));
            t += r::GROWING_S.draw(rng);
            points.push((t, depth_m));
        }
        Course::ComesAndGoes => {
            while t + 1.0 < length_s {
                let ramp = r::ENTRY_S.draw(rng).min(0.1);
                points.push((t + ramp, depth_m));
                t += ramp + r::Span::even(0.4, 1.2).draw(rng);
                points.push((t, depth_m));
                points.push((t + ramp, 0.0));
                t += ramp + r::Span::even(0.3, 0.8).draw(rng);
                points.push((t, 0.0));
            }
        }
        _ => {
            t += r::ENTRY_S.draw(rng);
            points.push((t, depth_m));
        }
    }
    // Half of the others leave the cut before the end.
    if course != Course::ComesAndGoes && chance(rng, 0.5) {
        let out = length_s - r::Span::even(0.3, 1.0).draw(rng);
        if out > t + 0.3 {
            points.push((out, depth_m));
            points.push((out + r::ENTRY_S.draw(rng), 0.0));
        }
    }
    Schedule::new(&points)
}

/// A run-up before the cut, and an override by hand, at most three times.
fn speeds(
    rng: &mut ChaCha8Rng,
    nominal_hz: f64,
    air_s: f64,
    (lead_s, length_s): (f64, f64),
) -> Result<(Option<Schedule>, Changes), PlantError> {
    let mut changes = Changes::default();
    let mut points = Vec::new();
    if air_s > 0.0 && chance(rng, r::RUN_UP.0) {
        changes.run_up = true;
        points.push((0.0, nominal_hz * r::RUN_UP.1.draw(rng)));
        points.push((0.8 * air_s, nominal_hz));
    }
    if chance(rng, r::OVERRIDE.0) {
        let slow = chance(rng, 0.5);
        changes.steps = !slow;
        changes.ramps = slow;
        let mut t = lead_s + air_s + r::Span::even(0.8, 2.0).draw(rng);
        let mut now = nominal_hz;
        for _ in 0..3 {
            if t > lead_s + length_s - 0.5 {
                break;
            }
            points.push((t, now));
            let sign = one_of(rng, &[-1.0, 1.0]);
            now = nominal_hz * (1.0 + sign * r::OVERRIDE.1.draw(rng));
            t += r::OVERRIDE_S[usize::from(slow)].draw(rng);
            points.push((t, now));
            t += r::Span::even(0.8, 2.5).draw(rng);
        }
    }
    let schedule = if points.is_empty() {
        None
    } else {
        Some(Schedule::new(&points)?)
    };
    Ok((schedule, changes))
}
