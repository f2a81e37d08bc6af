//! The long autoregression by Burg's method, stage by stage.
//!
//! Rate: a part of a stage once a sample, while the model starts.

use super::{BACKWARD, FORWARD, LATTICE_UNIT, LONGEST, SHORTEST, Stage, Start};
use crate::real::Real;

impl<T: Real, const N: usize> Start<T, N> {
    /// Order 0 of the lattice: both errors are the samples themselves.
    pub(super) fn begin_lattice(&mut self, n: usize) {
        self.wanted = (n + n / 2)
            .clamp(SHORTEST, LONGEST)
            .min(self.length.saturating_sub(2) / 4);
        self.order = 0;
        self.cross = T::ZERO;
        self.square = T::ZERO;
        let mut before = T::ZERO;
        for t in 0..self.length {
            let y = self.at(t);
            self.put(BACKWARD + t, y);
            self.put(FORWARD + t, y);
            if t > 0 {
                self.add(y, before);
            }
            before = y;
        }
        self.begin_lattice_stage();
        self.stage = Stage::Lattice;
    }

    /// Burg: k = −2 Σ f·b₋₁ / Σ (f² + b₋₁²), over all samples that have both.
    fn begin_lattice_stage(&mut self) {
        self.order += 1;
        self.place = self.order;
        self.reflection = if self.square > T::ZERO {
            -(self.cross + self.cross) / self.square
        } else {
            T::ZERO
        };
        self.overwritten = self.at(BACKWARD + self.order - 1);
        self.cross = T::ZERO;
        self.square = T::ZERO;
    }

    #[inline(always)]
    fn add(&mut self, forward: T, backward: T) {
        self.cross += forward * backward;
        self.square += forward * forward + backward * backward;
    }

    /// Some samples of one lattice stage: f ← f + k·b₋₁, b ← b₋₁ + k·f.
    pub(super) fn lattice_unit(&mut self) {
        if self.order > self.wanted {
            self.stage = Stage::Rounds;
            self.place = 0;
            return;
        }
        let end = (self.place + LATTICE_UNIT).min(self.length);
        for t in self.place..end {
            let (forward, backward) = (self.at(FORWARD + t), self.overwritten);
            self.overwritten = self.at(BACKWARD + t);
            let f = forward + self.reflection * backward;
            self.put(FORWARD + t, f);
            self.put(BACKWARD + t, backward + self.reflection * forward);
            if t > self.order {
                self.add(f, self.at(BACKWARD + t - 1));
            }
        }
        self.place = end;
        if self.place == self.length {
            self.begin_lattice_stage();
        }
    }

    /// Mean square of what the lattice cannot predict.
    pub(super) fn innovation_variance(&self) -> T {
        let errors = self.store.get(FORWARD + self.wanted..FORWARD + self.length);
        mean_square(errors.unwrap_or(&[]))
    }
}

fn mean_square<T: Real>(x: &[T]) -> T {
    let sum = x.iter().fold(T::ZERO, |sum, x| sum + *x * *x);
    sum / T::from_u32(x.len().max(1) as u32)
}
