//! Steps of a mode whose length swings.

use super::{FohStep, Mode};

/// Lengths of a step for which a mode is solved; between them it is interpolated. With 0.13
/// rad a step and speeds of half to twice the mean the straight line is off by 5e-8 of a
/// step: 5e-5 of a damping of 1 %. Half as many lengths: four times that.
const LENGTHS: usize = 512;

/// The exact step of one mode for any length within a range.
#[derive(Clone, Debug)]
pub(crate) struct StepTable {
    least_s: f64,
    per_s: f64,
    steps: Vec<FohStep>,
}

impl StepTable {
    /// For steps from `least_s` to `most_s` s.
    pub(crate) fn new(mode: &Mode, least_s: f64, most_s: f64) -> Self {
        let width = (most_s - least_s).max(1e-9 * most_s) / (LENGTHS - 1) as f64;
        let steps = (0..LENGTHS).map(|i| FohStep::new(mode, least_s + width * i as f64));
        Self {
            least_s,
            per_s: 1.0 / width,
            steps: steps.collect(),
        }
    }

    /// The step of this length, s.
    #[inline]
    pub(crate) fn at(&self, dt: f64) -> FohStep {
        let place = ((dt - self.least_s) * self.per_s).clamp(0.0, (LENGTHS - 1) as f64);
        let below = (place as usize).min(LENGTHS - 2);
        self.steps[below].between(&self.steps[below + 1], place - below as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_between_are_those_that_are_solved() {
        let mode = Mode::from_stiffness(900.0, 0.01, 1e7);
        let table = StepTable::new(&mode, 1e-5, 4e-5);
        for dt in [1e-5, 1.234e-5, 2.345e-5, 3.999e-5] {
            let (a, b) = (table.at(dt), FohStep::new(&mode, dt));
            let (x, y) = (
                a.advance([1e-5, 0.02], 3.0, 5.0),
                b.advance([1e-5, 0.02], 3.0, 5.0),
            );
            assert!((x[0] / y[0] - 1.0).abs() < 2e-7, "{dt}");
            assert!((x[1] - y[1]).abs() < 1e-7 * 0.06, "{dt}: {x:?} {y:?}");
        }
    }
}
