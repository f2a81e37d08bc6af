//! Where in a run the axes turn round: the only marks of its angle beside the triggers.
//!
//! Backlash lets the bar's length step where an axis turns round, at 0°, 90°, 180° and 270° of
//! the circle. A run is told to begin at θ0. Were it run the other way round, what is taken for
//! θ would be 2·θ0 − θ, and the steps would stand at 2·θ0 − k·90°: at 60° and not at 0° for
//! a circle that begins at −15°. And where the feed varies within the run, they stand early or
//! late, though both triggers are right.
//!
//! Rate: once a run. A step is what a line on both sides does not explain:
//!
//! ```text
//! d_i = r(b + i) − r(b − 1 − i),  i = 1..n within 8°;  step(b): d at i = −½ by regression
//! ```
//!
//! The two cells at b are left out: the step lies somewhere in them. Smooth errors are odd
//! in third order only: 0.04 µm for 3 µm of the third harmonic. Lateral play makes a kink there, from
//! the sums r(b + i) + r(b − 1 − i); a place is where step and kink together are strongest.

use super::trace::AngleMap;
use heapless::Vec;

/// Angle on each side of a step, rad.
const SIDE_RAD: f32 = 8.0 * DEG;
/// Cells of it.
const LEAST_SIDE: usize = 6;
/// Cells at each end of the arc in which the feed is not there yet.
const EDGE: usize = 3;
const MOST_SIDE: usize = 32;
/// A step further than this from its place is not looked for, rad.
const REACH_RAD: f32 = 12.0 * DEG;
/// Steps that stand out are this many times what the filter gives elsewhere, RMS,
const STANDS_OUT: f32 = 4.0;
/// and higher than this, m: the seal's friction, let go, gives 0.1 µm.
const LEAST_M: f32 = 0.25e-6;
/// A step whose place counts is this much of what is there: a spike without backlash is a kink
/// beside its place as well.
const MOSTLY: f32 = 0.8;
/// and this many times as high as one that stands out: beside a weak one a kink may be stronger.
const CERTAIN: f32 = 2.0;
/// Two steps that stand out where they should, and this many times the power that stands
/// where they should not, prove a direction.
const POWER: f32 = 4.0;
const ENOUGH: u8 = 2;
const DEG: f32 = core::f32::consts::PI / 180.0;
const QUARTER_RAD: f32 = core::f32::consts::FRAC_PI_2;

/// What the reversals of a run say.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Reversals {
    /// How many stand out where they should, five at most in 390°.
    pub seen: u8,
    /// They show that the run went the way it was told.
    pub proven: bool,
    /// They show that it went the other way.
    pub turned: bool,
    /// Greatest angle by which one of them is off its place, rad; 0 where none is seen.
    pub off_rad: f32,
}

/// Steps about places a quarter of a turn apart.
#[derive(Debug, Clone, Copy, Default)]
struct Places {
    seen: u8,
    power: f32,
    off_rad: f32,
}

/// Looks at a run in cells of `cell_s`, means and counts. Times of `map` count from the first
/// cell's beginning.
pub(super) fn look(
    mean: &[f32],
    count: &[u16],
    cell_s: f32,
    map: &AngleMap<f32>,
) -> Option<Reversals> {
    let cell_rad = map.sweep_rad * cell_s / (map.to_s - map.from_s);
    let side = (SIDE_RAD / cell_rad) as usize;
    if !(cell_rad > 0.0) || !(LEAST_SIDE..=MOST_SIDE).contains(&side) {
        return None;
    }
    // Before and after the arc the machine stands, or is on its way in or out.
    let cells = (map.to_s / cell_s) as usize;
    let filter = Filter::new(
        mean.get(..cells).unwrap_or(mean),
        count.get(..cells).unwrap_or(count),
        side,
    );
    let theta = |cell: usize| map.theta(cell as f32 * cell_s);
    let other = 2.0 * map.start_rad;
    let apart = nearest(other).abs();
    // What the filter gives where neither hypothesis has a step.
    let (mut floor, mut n) = (0.0, 0.0f32);
    for cell in 0..filter.mean.len() {
        let at = theta(cell);
        let clear = REACH_RAD + 5.0 * DEG;
        if nearest(at).abs() > clear
            && nearest(other - at).abs() > clear
            && let Some(mark) = filter.at(cell)
        {
            floor += mark.step_m * mark.step_m;
            n += 1.0;
        }
    }
    if n < 1.0 {
        return None;
    }
    let least = (STANDS_OUT * libm::sqrtf(floor / n)).max(LEAST_M);
    let reach = REACH_RAD.min(0.45 * apart.max(0.5 * QUARTER_RAD * f32::from(apart < DEG)));
    let right = places(&filter, theta, 0.0, reach, least);
    let wrong = places(&filter, theta, other, reach, least);
    // Where the two hypotheses have their steps in one place, nothing tells them apart.
    let tells = apart > SIDE_RAD;
    Some(Reversals {
        seen: right.seen,
        proven: tells && right.seen >= ENOUGH && right.power > POWER * wrong.power,
        turned: tells && wrong.seen >= ENOUGH && wrong.power > POWER * right.power,
        off_rad: right.off_rad,
    })
}

/// The strongest mark within `reach` of every place `from` + k·90°, and how much of a step each
/// is. Play makes a kink there and no step; beside it a kink looks like a step.
fn places(
    filter: &Filter<'_>,
    theta: impl Fn(usize) -> f32,
    from: f32,
    reach: f32,
    least: f32,
) -> Places {
    let mut out = Places::default();
    let mut n = 0.0f32;
    let mut best: Option<(Mark, f32)> = None;
    for cell in 0..=filter.mean.len() {
        let off = nearest(theta(cell) - from);
        let within = off.abs() <= reach && cell < filter.mean.len();
        if within {
            if let Some(mark) = filter.at(cell)
                && best.is_none_or(|(most, _)| mark.power > most.power)
            {
                best = Some((mark, off));
            }
        } else if let Some((mark, off)) = best.take() {
            n += 1.0;
            out.power += (mark.step_m * mark.step_m - out.power) / n;
            if mark.step_m.abs() > least {
                out.seen = out.seen.saturating_add(1);
                if mark.part > MOSTLY && mark.step_m.abs() > CERTAIN * least {
                    out.off_rad = out.off_rad.max(off.abs());
                }
            }
        }
    }
    out
}

/// Signed distance to the nearest quarter of a turn, rad.
fn nearest(theta: f32) -> f32 {
    let quarters = theta / QUARTER_RAD;
    (quarters - libm::floorf(quarters + 0.5)) * QUARTER_RAD
}

/// Weights of the two filters, from the middle outwards.
struct Filter<'a> {
    mean: &'a [f32],
    count: &'a [u16],
    step: Weights,
    kink: Weights,
}

type Weights = Vec<f32, MOST_SIDE>;

/// What stands at the beginning of a cell.
#[derive(Debug, Clone, Copy)]
struct Mark {
    /// Step, m.
    step_m: f32,
    /// Power of step and kink together, over that of noise.
    power: f32,
    /// The step's part of it.
    part: f32,
}

impl<'a> Filter<'a> {
    fn new(mean: &'a [f32], count: &'a [u16], side: usize) -> Self {
        let x = || (0..side.min(MOST_SIDE)).map(|i| i as f32 + 1.5);
        let moment = |k: i32| x().map(|x| libm::powf(x, k as f32)).sum::<f32>();
        let (m0, m1, m2, m3, m4) = (moment(0), moment(1), moment(2), moment(3), moment(4));
        // Intercept of a line: Σa = 1, Σax = 0.
        let det = m0 * m2 - m1 * m1;
        let step = x().map(|x| (m2 - m1 * x) / det).collect();
        // Slope beside constant and square: x less its part in them, Σwx = 1.
        let det = m0 * m4 - m2 * m2;
        let (c0, c2) = ((m1 * m4 - m2 * m3) / det, (m0 * m3 - m1 * m2) / det);
        let rest = |x: f32| x - c0 - c2 * x * x;
        let norm = x().map(|x| x * rest(x)).sum::<f32>();
        let kink = x().map(|x| rest(x) / norm).collect();
        Self {
            mean,
            count,
            step,
            kink,
        }
    }

    /// None where a side is not whole.
    fn at(&self, cell: usize) -> Option<Mark> {
        let side = self.step.len();
        let full = |a: usize, b: usize| {
            let counts = self.count.get(a..b)?;
            counts.iter().all(|c| *c > 0).then(|| self.mean.get(a..b))?
        };
        let from = cell.checked_sub(side + 1).filter(|k| *k >= EDGE)?;
        let left = full(from, cell.checked_sub(1)?)?;
        let to = cell + 1 + side;
        let right = (to + EDGE <= self.mean.len()).then(|| full(cell + 1, to))??;
        let (mut step_m, mut kink, mut own) = (0.0, 0.0, (0.0, 0.0));
        let weights = self.step.iter().zip(&self.kink);
        for ((r, l), (a, w)) in right.iter().zip(left.iter().rev()).zip(weights) {
            step_m += a * (r - l);
            kink += w * (r + l);
            own = (own.0 + a * a, own.1 + w * w);
        }
        let (step, kink) = (step_m * step_m / own.0, kink * kink / own.1);
        Some(Mark {
            step_m,
            power: step + kink,
            part: step / (step + kink).max(f32::MIN_POSITIVE),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::terms::Sense;
    use super::*;
    use std::vec::Vec;

    /// Cells of a run: three harmonics, steps of `step_m` at the reversals, run the other way
    /// round where `turned`, `early` rad late in the middle.
    fn run(step_m: f32, turned: bool, late_rad: f32) -> (Vec<f32>, Vec<u16>, AngleMap<f32>) {
        let map = AngleMap {
            start_rad: -15.0 * DEG,
            sweep_rad: 390.0 * DEG,
            sense: Sense::Ccw,
            from_s: 0.0,
            to_s: 30.0,
        };
        let cell_s = 1.2 * 30.0 / 780.0;
        let mut seed = 7u32;
        let mean = (0..650)
            .map(|k| {
                let t = (k as f32 + 0.5) * cell_s;
                let u = t / 30.0;
                let gone = map.sweep_rad * u - late_rad * (u * core::f32::consts::PI).sin();
                let d = if turned { -1.0 } else { 1.0 };
                let th = map.start_rad + d * gone;
                let sign = |v: f32| if v < 0.0 { -1.0 } else { 1.0 };
                let backlash =
                    0.5 * step_m * d * (sign(th.sin()) * th.cos() - sign(th.cos()) * th.sin());
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let noise = (f32::from((seed >> 16) as u16) / 65535.0 - 0.5) * 0.2e-6;
                15e-6 * (th + 1.0).cos()
                    + 6e-6 * (2.0 * th).sin()
                    + 2e-6 * (3.0 * th).cos()
                    + backlash
                    + noise
            })
            .collect::<Vec<f32>>();
        let count = std::vec![40u16; 650];
        (mean, count, map)
    }

    fn seen(step_m: f32, turned: bool, late_rad: f32) -> Reversals {
        let (mean, count, map) = run(step_m, turned, late_rad);
        look(&mean, &count, 1.2 * 30.0 / 780.0, &map).expect("a run")
    }

    #[test]
    fn direction_and_lateness() {
        let right = seen(1e-6, false, 0.0);
        assert!(
            right.proven && !right.turned && right.seen == 5,
            "{right:?}"
        );
        assert!(right.off_rad < 1.0 * DEG, "{right:?}");
        let wrong = seen(1e-6, true, 0.0);
        assert!(wrong.turned && !wrong.proven, "{wrong:?}");
        let late = seen(1e-6, false, 5.0 * DEG);
        assert!(
            late.proven && (late.off_rad - 5.0 * DEG).abs() < DEG,
            "{late:?}"
        );
        // Without backlash nothing is said.
        let none = seen(0.0, false, 5.0 * DEG);
        assert!(none.seen == 0 && !none.proven && !none.turned && none.off_rad == 0.0);
    }

    #[test]
    fn what_cannot_be_told_is_not() {
        let (mean, count, map) = run(1e-6, false, 0.0);
        let cell_s = 1.2 * 30.0 / 780.0;
        // Begun at −45°: both hypotheses have their steps at the same places.
        let map = AngleMap {
            start_rad: -45.0 * DEG,
            ..map
        };
        let found = look(&mean, &count, cell_s, &map).expect("a run");
        assert!(!found.proven && !found.turned);
        // Nothing recorded.
        assert_eq!(look(&mean, &[0; 650], cell_s, &map), None);
        assert_eq!(look(&[], &[], cell_s, &map), None);
        let bad = AngleMap { to_s: 0.0, ..map };
        let _ = look(&mean, &count, cell_s, &bad);
        let _ = look(&mean, &count, f32::NAN, &map);
    }
}
