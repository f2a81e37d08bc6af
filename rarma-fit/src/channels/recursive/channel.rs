//! What one channel keeps: its past, and its past filtered by 1/C.

use alloc::vec;
use alloc::vec::Vec;

/// The regressor of a channel and its gradient, newest first.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    /// −y(t−1) … −y(t−p).
    pub outputs: Vec<f64>,
    /// e(t−1) … e(t−q).
    pub errors: Vec<f64>,
    /// The same filtered by 1/C; as many as A or C needs, whichever is longer.
    pub outputs_f: Vec<f64>,
    pub errors_f: Vec<f64>,
}

impl Channel {
    pub fn new(p: usize, q: usize) -> Self {
        Self {
            outputs: vec![0.0; p],
            errors: vec![0.0; q],
            outputs_f: vec![0.0; p.max(q)],
            errors_f: vec![0.0; q],
        }
    }

    pub fn clear(&mut self) {
        self.all().for_each(|x| *x = 0.0);
    }

    /// Every number.
    pub fn all(&mut self) -> impl Iterator<Item = &mut f64> {
        let Self {
            outputs,
            errors,
            outputs_f,
            errors_f,
        } = self;
        outputs
            .iter_mut()
            .chain(errors)
            .chain(outputs_f)
            .chain(errors_f)
    }

    /// e = y − φᵀθ, and the shift of φ by this sample.
    pub fn predict(&mut self, y: f64, a: &[f64], c: &[f64]) -> f64 {
        let mut e = y;
        let past = self.outputs.iter().chain(&self.errors);
        for (x, parameter) in past.zip(a.iter().chain(c)) {
            e -= x * parameter;
        }
        shift(&mut self.outputs, -y);
        shift(&mut self.errors, e);
        e
    }

    /// Both 1/C filters, and the shift of ψ by this sample: returns −y_f and e_f, with
    /// x_f = x − Σ c_j·x_f(t−j).
    pub fn filter(&mut self, y: f64, e: f64, c: &[f64]) -> (f64, f64) {
        let (mut y_f, mut e_f) = (-y, e);
        for ((c, y), e) in c.iter().zip(&self.outputs_f).zip(&self.errors_f) {
            y_f -= c * y;
            e_f -= c * e;
        }
        shift(&mut self.outputs_f, y_f);
        shift(&mut self.errors_f, e_f);
        (y_f, e_f)
    }

    /// ψ of this channel: of a, and of its own c.
    pub fn gradient(&self, p: usize) -> (&[f64], &[f64]) {
        (&self.outputs_f[..p], &self.errors_f)
    }
}

fn shift(past: &mut [f64], newest: f64) {
    let last = past.len().saturating_sub(1);
    past.copy_within(..last, 1.min(past.len()));
    if let Some(first) = past.first_mut() {
        *first = newest;
    }
}
