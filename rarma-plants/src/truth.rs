//! What is true of a cut, whatever an estimator says: the limit, when it is
//! passed, and the operational damping and frequency at each condition.
//!
//! Slow path. Everything comes from the delay equation, nothing from the signal.

use super::condition::{Condition, arc, entering, in_stock_s, interrupted};
use super::cut::{Process, Scenario};
use super::delay::{
    Border, Crossing, DelaySystem, DepthSearch, Root, limit, limit_by, milling_delay,
    turning_delay, turning_roots,
};
use super::error::PlantError;
use super::milling::MillingConfig;
use super::modal::ShapedMode;
use super::stability::{milling_limit, turning_limit_at};

/// Steps in a period of the fastest mode.
pub const STEPS_PER_PERIOD: f64 = 60.0;
/// The most of them.
const MOST_STEPS_PER_PERIOD: f64 = 64.0 * STEPS_PER_PERIOD;
/// Where the limit is looked for, relative to the largest depth of the cut.
const SEARCH: [f64; 2] = [0.01, 4.0];
/// Instants at which a changing cut is looked at.
const INSTANTS: usize = 120;
/// Roots given at each condition, and conditions at most.
const ROOTS: usize = 4;
const CONDITIONS: usize = 24;

/// The cut at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Operational {
    /// Time, s.
    pub t_s: f64,
    /// Depth or width, m.
    pub depth_m: f64,
    /// Spindle frequency, Hz.
    pub spindle_hz: f64,
    /// Dominant roots of the delay equation, the least damped first.
    pub roots: Vec<Root>,
}

/// What is true of a cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Spindle frequency, Hz; the nominal one if it changes.
    pub spindle_hz: f64,
    /// Number of teeth.
    pub teeth: usize,
    /// Tooth-passing frequency, Hz.
    pub tooth_hz: f64,
    /// Lowest limit at the nominal speed with fresh edges; `None` if there is none
    /// between 1 % and 4 times the largest depth of the cut.
    pub limit: Option<Border>,
    /// Why there is none: none in the range, the search was given up, …
    pub no_limit: Option<PlantError>,
    /// The zero-order limit beside it, m, where there is one.
    pub zero_order_m: Option<f64>,
    /// When the cut first becomes unstable, s.
    pub onset_s: Option<f64>,
    /// When it last stops being so, s.
    pub end_s: Option<f64>,
    /// When there is any depth at all, from and to, s.
    pub cut_s: Option<(f64, f64)>,
    /// Stretches of time on which a gap of the workpiece lies in front of the cutter,
    /// s: the roots, which hold for the full arc, mean little there.
    pub interrupted_s: Vec<(f64, f64)>,
    /// The modes of the structure.
    pub modes: Vec<ShapedMode>,
    /// Roots while it cuts.
    pub operational: Vec<Operational>,
}

impl Scenario {
    /// What is true of it; see [`Truth::of`].
    ///
    /// # Errors
    /// As there.
    pub fn truth(&self) -> Result<Truth, PlantError> {
        Truth::of(&self.process, self.duration_s)
    }
}

impl Truth {
    /// Works out the truth of a cut of `duration_s` seconds.
    ///
    /// With a workpiece that has gaps, the figures hold for the full arc.
    ///
    /// # Errors
    /// As the validation of the process.
    pub fn of(process: &Process, duration_s: f64) -> Result<Self, PlantError> {
        let deepest = process.depth().largest();
        let rigid = process.modes().is_empty();
        let border = if deepest > 0.0 && !rigid {
            let search = DepthSearch {
                low_m: SEARCH[0] * deepest,
                high_m: SEARCH[1] * deepest,
                ratio: 1.08,
                tolerance: 1e-4,
            };
            limit_of(process, f64::INFINITY, &search)
        } else {
            Err(PlantError::NoLimit)
        };
        let instants = if rigid {
            Vec::new()
        } else {
            instants(process, duration_s)
        };
        let mut unstable = Vec::with_capacity(instants.len());
        let mut last: Option<(Condition, bool)> = None;
        for &t in &instants {
            let now = Condition::at(process, t);
            let state = match last {
                Some((before, state)) if before == now && !entering(process, t) => state,
                _ => now.depth_m > 0.0 && radius(process, t, now.depth_m)? >= 1.0,
            };
            last = Some((now, state));
            unstable.push(state);
        }
        let onset = unstable.iter().position(|u| *u);
        let end = unstable.iter().rposition(|u| *u);
        let edge = |from: Option<f64>, to: Option<f64>| match (from, to) {
            (Some(a), Some(b)) => crossing(process, a, b).map(Some),
            _ => Ok(None),
        };
        let before = |i: usize| i.checked_sub(1).map(|i| instants[i]);
        let onset_s = match onset {
            Some(0) => Some(0.0),
            Some(i) => edge(before(i), Some(instants[i]))?,
            None => None,
        };
        let end_s = match end {
            Some(i) => edge(instants.get(i + 1).copied(), Some(instants[i]))?,
            None => None,
        };
        let deep = match process.depth().points() {
            [(_, b)] => (*b > 0.0).then_some((0.0, duration_s)),
            _ => process.depth().in_cut_s(),
        };
        let cut_s = deep.and_then(|(from, to)| {
            let (first, last) = in_stock_s(process);
            let both = (from.max(first), to.min(last));
            (both.0 < both.1).then_some(both)
        });
        Ok(Self {
            spindle_hz: process.spindle_hz(),
            teeth: process.teeth(),
            tooth_hz: process.spindle_hz() * process.teeth() as f64,
            limit: border.ok(),
            no_limit: border.err(),
            zero_order_m: zero_order_m(process),
            onset_s,
            end_s,
            cut_s,
            interrupted_s: interrupted(process, duration_s),
            modes: process.modes(),
            operational: operational(process, &instants)?,
        })
    }

    /// Depth of the limit, m.
    #[must_use]
    pub fn limit_depth_m(&self) -> Option<f64> {
        self.limit.map(|l| l.depth_m)
    }

    /// Chatter frequency at the limit, Hz.
    #[must_use]
    pub fn chatter_hz(&self) -> Option<f64> {
        self.limit.map(|l| l.root.f_hz)
    }
}

/// The milling cut as it is at time `t` s.
fn frozen(c: &MillingConfig, t: f64) -> MillingConfig {
    let fresh = !t.is_finite();
    let worn = if fresh {
        1.0
    } else {
        1.0 + c.wear.cutting_per_s * t
    };
    MillingConfig {
        spindle_hz: if fresh { c.spindle_hz } else { c.carrier_at(t) },
        speed: None,
        kt_n_per_m2: c.kt_n_per_m2 * worn,
        kn_n_per_m2: c.kn_n_per_m2 * worn,
        engagement: arc(c, t),
        ..c.clone()
    }
}

/// The delay equation of milling at a depth, in [`STEPS_PER_PERIOD`], or in more where the cut is so
/// stiff beside its modes that such steps would not resolve it.
///
/// # Errors
/// As [`milling_delay`].
fn delay_of(config: &MillingConfig, depth_m: f64) -> Result<DelaySystem, PlantError> {
    finer(STEPS_PER_PERIOD, |steps| {
        milling_delay(config, depth_m, steps)
    })
}

/// What it gives for steps that are short enough: so many a period of the fastest mode, or two, four, …
/// times as many.
fn finer(
    mut steps: f64,
    at: impl Fn(f64) -> Result<DelaySystem, PlantError>,
) -> Result<DelaySystem, PlantError> {
    loop {
        match at(steps) {
            Err(PlantError::OutOfRange {
                name: "steps_per_period",
            }) if steps < MOST_STEPS_PER_PERIOD => steps *= 2.0,
            other => return other,
        }
    }
}

/// The `wanted` dominant roots of a process as it is at time `t` s, at depth
/// `depth_m`, the least damped first.
///
/// # Errors
/// As the validation of the process.
pub fn roots(
    process: &Process,
    t: f64,
    depth_m: f64,
    wanted: usize,
) -> Result<Vec<Root>, PlantError> {
    roots_in(process, t, depth_m, wanted, STEPS_PER_PERIOD)
}

/// [`roots`] in so many steps a period of the fastest mode: fewer are quicker, and the error falls
/// with the square of a step. Turning at a constant speed has no step.
///
/// # Errors
/// As [`roots`].
pub fn roots_in(
    process: &Process,
    t: f64,
    depth_m: f64,
    wanted: usize,
    steps_per_period: f64,
) -> Result<Vec<Root>, PlantError> {
    let system = match process {
        Process::Milling(c) => {
            let c = frozen(c, t);
            finer(steps_per_period, |steps| milling_delay(&c, depth_m, steps))?
        }
        Process::Turning(c) if c.variation.is_some() => {
            finer(steps_per_period, |steps| turning_delay(c, depth_m, steps))?
        }
        Process::Turning(c) => return turning_roots(c, depth_m, wanted),
    };
    Ok(system.roots(wanted))
}

/// Largest modulus of a multiplier: from 1 on the cut is unstable.
fn radius(process: &Process, t: f64, depth_m: f64) -> Result<f64, PlantError> {
    let radius = match process {
        Process::Milling(c) => delay_of(&frozen(c, t), depth_m)?.radius(),
        Process::Turning(c) if c.variation.is_some() => {
            finer(STEPS_PER_PERIOD, |steps| turning_delay(c, depth_m, steps))?.radius()
        }
        Process::Turning(c) => turning_roots(c, depth_m, 1)?
            .first()
            .map_or(0.0, |r| (r.growth_per_s / c.spindle_hz).exp()),
    };
    if radius.is_nan() {
        return Err(PlantError::Unsettled);
    }
    Ok(radius)
}

/// Lowest limit in the range of the search, as the process is at time `t` s; an
/// infinite time means the full arc and fresh edges.
///
/// # Errors
/// `NoLimit` if there is none there; `GivenUp` and `Unsettled` as [`limit`]; else as the
/// validation of the process.
pub fn limit_of(process: &Process, t: f64, search: &DepthSearch) -> Result<Border, PlantError> {
    match process {
        Process::Milling(c) => {
            let c = frozen(c, t);
            limit(search, |b| delay_of(&c, b))
        }
        Process::Turning(_) => {
            let depth_m = limit_by(search, |b| radius(process, t, b))?;
            let roots = roots(process, t, depth_m, 1)?;
            Ok(Border {
                depth_m,
                crossing: Crossing::Hopf,
                root: *roots.first().ok_or(PlantError::NoLimit)?,
            })
        }
    }
}

/// Arc below which the zero-order method misses period doubling, rad.
const LEAST_ARC_RAD: f64 = 0.9;

/// The zero-order limit, m, where the method is valid: equal straight teeth, modes
/// along x and y, no rubbing, an arc of at least 0.9 rad, a speed that does not swing.
#[must_use]
pub fn zero_order_m(process: &Process) -> Option<f64> {
    if process.variation().is_some() {
        return None;
    }
    let found = match process {
        Process::Milling(c) => {
            let arc = c.engagement.exit_rad - c.engagement.entry_rad;
            let valid = c.modes_other.is_empty()
                && c.pitch_rad.is_empty()
                && c.helix_rad == 0.0
                && c.process_damping.is_none()
                && arc >= LEAST_ARC_RAD;
            if !valid {
                return None;
            }
            milling_limit(c)
        }
        Process::Turning(c) if c.process_damping.is_some() => return None,
        Process::Turning(c) => turning_limit_at(&c.modes, c.ks_n_per_m2, c.spindle_hz),
    };
    found.ok().map(|l| l.depth_m)
}

/// The instants at which the condition is looked at: one if nothing changes.
fn instants(process: &Process, duration_s: f64) -> Vec<f64> {
    let mut times: Vec<f64> = process.depth().points().iter().map(|p| p.0).collect();
    let mut changes = times.len() > 1;
    if let Process::Milling(c) = process {
        if let Some(speed) = &c.speed {
            times.extend(speed.points().iter().map(|p| p.0));
            changes = true;
        }
        changes |= c.wear.cutting_per_s > 0.0 || c.workpiece.is_some();
    }
    times.push(0.0);
    if changes {
        times.extend((1..=INSTANTS).map(|i| duration_s * i as f64 / INSTANTS as f64));
    }
    times.retain(|t| (0.0..=duration_s).contains(t));
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// When the cut, stable at `stable` s and not at `unstable` s, changes, to 0.1 ms.
fn crossing(process: &Process, mut stable: f64, mut unstable: f64) -> Result<f64, PlantError> {
    while (unstable - stable).abs() > 1e-4 {
        let middle = 0.5 * (stable + unstable);
        let depth = Condition::at(process, middle).depth_m;
        if depth > 0.0 && radius(process, middle, depth)? >= 1.0 {
            unstable = middle;
        } else {
            stable = middle;
        }
    }
    Ok(0.5 * (stable + unstable))
}

fn operational(process: &Process, instants: &[f64]) -> Result<Vec<Operational>, PlantError> {
    let cutting: Vec<f64> = instants
        .iter()
        .copied()
        .filter(|t| Condition::at(process, *t).depth_m > 0.0)
        .collect();
    // One entry for each stretch on which nothing changes.
    let mut distinct: Vec<f64> = Vec::new();
    for &t in &cutting {
        let same = |last: &f64| {
            Condition::at(process, *last) == Condition::at(process, t) && !entering(process, *last)
        };
        if !distinct.last().is_some_and(same) {
            distinct.push(t);
        }
    }
    let stride = distinct.len().div_ceil(CONDITIONS).max(1);
    let mut out: Vec<Operational> = Vec::new();
    for &t_s in distinct.iter().step_by(stride) {
        let now = Condition::at(process, t_s);
        out.push(Operational {
            t_s,
            depth_m: now.depth_m,
            spindle_hz: now.spindle_hz,
            roots: roots(process, t_s, now.depth_m, ROOTS)?,
        });
    }
    Ok(out)
}
