//! How the scores of all channels together scatter: what the deviations have to be corrected by
//! where the channels do not tell independent things.
//!
//! With s(t) = Σ_k η_k·u_k/d_k the estimate moves by P·Σ w·s, w the weight of a sample, so its
//! covariance is P·J·P with J = Σ over stretches of (Σ w·s)·(Σ w·s)ᵀ, a stretch being longer than
//! s remembers (the sandwich of misspecified likelihoods: Huber 1967, White 1982; by stretches as
//! means of correlated series are judged). With one channel J is P⁻¹ but for chance.

use alloc::vec;
use alloc::vec::Vec;
use rarma_core::estimate::StateVisitor;

/// Samples of a stretch. A mode's channels stay correlated for as long as it rings: at 2 % and 400 Hz
/// sampled at 5 kHz its time constant is 100. Of half the length part of the correlation is
/// lost, of twice the length half as many stretches make the deviations shakier by 1.4.
const STRETCH: u32 = 100;

/// J and the stretch in work.
#[derive(Debug, Clone)]
pub(super) struct Scores {
    sum: Vec<f64>,
    /// J, row by row, weighed as at the end of the last stretch.
    square: Vec<f64>,
    samples: u32,
    /// Stretches in J.
    stretches: u32,
}

impl Scores {
    pub fn new(n: usize) -> Self {
        Self {
            sum: vec![0.0; n],
            square: vec![0.0; n * n],
            samples: 0,
            stretches: 0,
        }
    }

    pub fn clear(&mut self) {
        *self = Self::new(self.sum.len());
    }

    /// The score of one channel, η·`part`.
    pub fn add(&mut self, eta: &[f64], part: f64) {
        for (sum, x) in self.sum.iter_mut().zip(eta) {
            *sum += x * part;
        }
    }

    /// All channels of a sample are in; `lambda` is what a sample weighs relative to the next.
    pub fn end_sample(&mut self, lambda: f64) {
        self.samples += 1;
        if self.samples < STRETCH {
            return;
        }
        // Within a stretch all weigh the same: it is short beside the memory.
        let n = self.sum.len();
        let kept = libm::pow(lambda, 2.0 * f64::from(STRETCH));
        for (row, x) in self.square.chunks_exact_mut(n).zip(&self.sum) {
            for (square, y) in row.iter_mut().zip(&self.sum) {
                *square = *square * kept + x * y;
            }
        }
        self.sum.fill(0.0);
        self.samples = 0;
        self.stretches = self.stretches.saturating_add(1);
    }

    /// xᵀ·J·x.
    pub fn quadratic(&self, x: &[f64]) -> f64 {
        let rows = self.square.chunks_exact(self.sum.len());
        let dot = |row: &[f64]| row.iter().zip(x).map(|(j, x)| j * x).sum::<f64>();
        rows.zip(x).map(|(row, x)| x * dot(row)).sum()
    }

    /// Every number of the state.
    pub fn visit(&mut self, visitor: &mut impl StateVisitor<f64>) {
        let all = self.sum.iter_mut().chain(&mut self.square);
        all.for_each(|x| visitor.number(x));
        visitor.count(&mut self.samples);
        visitor.count(&mut self.stretches);
    }
}
