//! How one machine's chatter grows, speed by speed.

use super::Machine;
use rarma_plants::delay::Root;

/// Speeds lie so many steps apart, evenly in the logarithm: 0.86 % for a reach of 50 to 150 %.
pub(super) const CELLS: usize = 128;
/// The first look is this coarse, cells.
const COARSE: usize = 8;
/// A lobe is as wide as one wave between two teeth: it is looked at this often at least.
const PER_LOBE: f64 = 8.0;
/// ... but what repeats more often than that is not looked at in steps of less than so many cells.
const LEAST_OF_LOBE: usize = 1;

/// Growth and frequency of the dominant root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Point {
    /// Below 0 the cut is stable, 1/s. What cannot be told is not stable.
    pub growth_per_s: f64,
    /// Its frequency, Hz.
    pub f_hz: f64,
}

impl Point {
    pub(super) fn of(root: Option<&Root>) -> Self {
        Self {
            growth_per_s: root.map_or(f64::INFINITY, |r| r.growth_per_s),
            f_hz: root.map_or(f64::NAN, |r| r.f_hz),
        }
    }
}

/// A stretch of speeds, turns a second, in cells that are even in the logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    least_hz: f64,
    /// Logarithm of the largest speed over the least.
    ln: f64,
}

impl Span {
    pub(super) fn new(least_hz: f64, most_hz: f64) -> Self {
        Self {
            least_hz,
            ln: (most_hz / least_hz).ln(),
        }
    }

    fn step(&self) -> f64 {
        self.ln / CELLS as f64
    }

    pub(super) fn speed_hz(&self, cell: usize) -> f64 {
        self.least_hz * (self.step() * cell as f64).exp()
    }

    /// Where a speed lies, in cells; beyond the ends it is the end.
    pub(super) fn place(&self, spindle_hz: f64) -> f64 {
        let place = (spindle_hz / self.least_hz).ln() / self.step();
        place.clamp(0.0, CELLS as f64)
    }

    /// Whether a speed lies between two cells.
    pub(super) fn holds(&self, spindle_hz: f64, from: usize, to: usize) -> bool {
        (self.speed_hz(from)..=self.speed_hz(to)).contains(&spindle_hz)
    }
}

/// A machine's dominant root over a stretch of speeds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    pub(super) span: Span,
    /// By the cell; none where its neighbours say enough.
    points: Vec<Option<Point>>,
}

impl Curve {
    /// Nothing has been looked at.
    pub(super) fn new(span: Span) -> Self {
        Self {
            span,
            points: vec![None; CELLS + 1],
        }
    }

    /// Looks at a machine of so many teeth where it matters: in stretches from one cell to another.
    ///
    /// A stretch is halved where a lobe could hide in it, where one end is stable and the other is not, and
    /// where growth that changes as steeply as the steepest seen could pass 0 within.
    pub(super) fn look_at(
        &mut self,
        machine: &Machine,
        teeth: f64,
        matters: impl Fn(usize, usize) -> bool,
    ) {
        let mut steepest = 0.0_f64;
        let mut waiting: Vec<(usize, usize)> = Vec::new();
        for from in (0..CELLS).step_by(COARSE) {
            let to = from + COARSE;
            if matters(from, to) {
                let (a, b) = (self.look(machine, from), self.look(machine, to));
                steepest = steepest.max(self.slope(a, b, COARSE));
                waiting.push((from, to));
            }
        }
        while let Some((from, to)) = waiting.pop() {
            let cells = to - from;
            let (a, b) = (self.look(machine, from), self.look(machine, to));
            let width = self.span.step() * cells as f64;
            let waves = |p: Point, cell| p.f_hz / (self.span.speed_hz(cell) * teeth);
            let waves = waves(a, from).max(waves(b, to));
            let coarse = width * waves * PER_LOBE > 1.0 && cells > LEAST_OF_LOBE;
            let (g, h) = (a.growth_per_s, b.growth_per_s);
            let crosses = (g < 0.0) != (h < 0.0);
            let near = (g + h).abs() < steepest * width;
            if cells > 1 && (coarse || crosses || near) && matters(from, to) {
                let middle = usize::midpoint(from, to);
                let between = self.look(machine, middle);
                for (end, half) in [(a, middle - from), (b, to - middle)] {
                    steepest = steepest.max(self.slope(end, between, half));
                }
                waiting.extend([(from, middle), (middle, to)]);
            }
        }
    }

    /// Whether it is stable somewhere between two cells, or one beside them.
    pub(super) fn is_stable_within(&self, from: usize, to: usize) -> bool {
        let (from, to) = (from.saturating_sub(1), (to + 1).min(CELLS));
        (from..=to).any(|cell| self.at(self.span.speed_hz(cell)).growth_per_s < 0.0)
    }

    fn look(&mut self, machine: &Machine, cell: usize) -> Point {
        if let Some(point) = self.points[cell] {
            return point;
        }
        let roots = machine.roots(self.span.speed_hz(cell), 1.0, 1).ok();
        let point = Point::of(roots.as_ref().and_then(|r| r.first()));
        self.points[cell] = Some(point);
        point
    }

    /// Change of the growth per unit of the logarithm of the speed.
    fn slope(&self, a: Point, b: Point, cells: usize) -> f64 {
        let slope = (a.growth_per_s - b.growth_per_s).abs() / (self.span.step() * cells as f64);
        if slope.is_finite() { slope } else { 0.0 }
    }

    /// At a speed, turns a second: a straight line between those that were looked at.
    pub(super) fn at(&self, spindle_hz: f64) -> Point {
        let place = self.span.place(spindle_hz);
        let looked = |cell: &usize| self.points[*cell].is_some();
        let below = (0..=place as usize).rev().find(looked).unwrap_or(0);
        let above = (place.ceil() as usize..=CELLS).find(looked);
        let (a, b) = (self.points[below], above.and_then(|cell| self.points[cell]));
        let (Some(a), Some(b), Some(above)) = (a, b, above) else {
            return Point::of(None);
        };
        // Nobody has looked here.
        if above - below > COARSE {
            return Point::of(None);
        }
        let part = (place - below as f64) / (above - below).max(1) as f64;
        let between = |a: f64, b: f64| a + part * (b - a);
        Point {
            growth_per_s: between(a.growth_per_s, b.growth_per_s),
            // From one lobe to the next the frequency jumps.
            f_hz: if part < 0.5 { a.f_hz } else { b.f_hz },
        }
    }

    /// So many speeds were looked at.
    #[cfg(test)]
    pub(super) fn looks(&self) -> usize {
        self.points.iter().flatten().count()
    }
}
