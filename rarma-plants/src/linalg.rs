//! The few dense matrix operations the plants need when they are built:
//! exponential, semidefinite Cholesky factor, discrete Lyapunov equation.
//!
//! Sizes are small (at most a few tens) and nothing here runs per sample.

/// Square matrix, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Square {
    n: usize,
    v: Vec<f64>,
}

impl Square {
    pub(crate) fn zeros(n: usize) -> Self {
        Self {
            n,
            v: vec![0.0; n * n],
        }
    }

    pub(crate) fn identity(n: usize) -> Self {
        let mut m = Self::zeros(n);
        for i in 0..n {
            m.set(i, i, 1.0);
        }
        m
    }

    pub(crate) fn n(&self) -> usize {
        self.n
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.v[i * self.n + j]
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, x: f64) {
        self.v[i * self.n + j] = x;
    }

    pub(crate) fn transpose(&self) -> Self {
        let mut out = Self::zeros(self.n);
        for i in 0..self.n {
            for j in 0..self.n {
                out.set(j, i, self.at(i, j));
            }
        }
        out
    }

    pub(crate) fn mul(&self, other: &Self) -> Self {
        let n = self.n;
        let mut out = Self::zeros(n);
        for i in 0..n {
            for k in 0..n {
                let a = self.at(i, k);
                for j in 0..n {
                    out.v[i * n + j] += a * other.at(k, j);
                }
            }
        }
        out
    }

    pub(crate) fn add(&self, other: &Self) -> Self {
        let v = self.v.iter().zip(&other.v).map(|(a, b)| a + b).collect();
        Self { n: self.n, v }
    }

    pub(crate) fn scale(&self, s: f64) -> Self {
        Self {
            n: self.n,
            v: self.v.iter().map(|a| a * s).collect(),
        }
    }

    /// Product with a vector.
    pub(crate) fn apply(&self, x: &[f64], out: &mut [f64]) {
        for (row, o) in self.v.chunks_exact(self.n).zip(out) {
            *o = row.iter().zip(x).map(|(a, b)| a * b).sum();
        }
    }

    fn max_row_sum(&self) -> f64 {
        self.v
            .chunks_exact(self.n)
            .map(|row| row.iter().map(|a| a.abs()).sum::<f64>())
            .fold(0.0, f64::max)
    }

    /// Matrix exponential: halve until the norm is below 1/4, sum the Taylor
    /// series to rounding (18 terms leave less than 1e-26), square back.
    pub(crate) fn exp(&self) -> Self {
        let mut halvings = 0;
        let mut norm = self.max_row_sum();
        while norm > 0.25 {
            norm *= 0.5;
            halvings += 1;
        }
        let a = self.scale(0.5_f64.powi(halvings));
        let mut sum = Self::identity(self.n);
        let mut term = Self::identity(self.n);
        for k in 1..=18 {
            term = term.mul(&a).scale(1.0 / f64::from(k));
            sum = sum.add(&term);
        }
        for _ in 0..halvings {
            sum = sum.mul(&sum);
        }
        sum
    }

    /// Lower factor L with L·Lᵀ = self for a symmetric positive semidefinite
    /// matrix. A pivot lost in rounding (below 1e-15 of the original diagonal
    /// entry) ends its column: that direction carries no noise.
    pub(crate) fn cholesky_psd(&self) -> Self {
        let n = self.n;
        let mut l = Self::zeros(n);
        for j in 0..n {
            let used: f64 = (0..j).map(|k| l.at(j, k).powi(2)).sum();
            let pivot = self.at(j, j) - used;
            if pivot <= 1e-15 * self.at(j, j) {
                continue;
            }
            let d = pivot.sqrt();
            l.set(j, j, d);
            for i in j + 1..n {
                let used: f64 = (0..j).map(|k| l.at(i, k) * l.at(j, k)).sum();
                l.set(i, j, (self.at(i, j) - used) / d);
            }
        }
        l
    }
}

/// Solves Σ = Φ Σ Φᵀ + Q by doubling (Smith): after k rounds the first 2ᵏ
/// terms of Σ Φⁱ Q Φⁱᵀ are summed. Φ must be stable.
pub(crate) fn discrete_lyapunov(phi: &Square, q: &Square) -> Square {
    let mut power = phi.clone();
    let mut sum = q.clone();
    for _ in 0..60 {
        let add = power.mul(&sum).mul(&power.transpose());
        sum = sum.add(&add);
        power = power.mul(&power);
        if power.max_row_sum() < 1e-20 {
            break;
        }
    }
    sum
}

/// Process noise of the sampled system ẋ = A x + w, E[w wᵀ] = W δ(t), by Van
/// Loan's block exponential. Returns Φ = e^(A·dt) and Q = ∫ e^(As) W e^(Aᵀs) ds.
pub(crate) fn van_loan(a: &Square, w: &Square, dt: f64) -> (Square, Square) {
    let n = a.n();
    let mut block = Square::zeros(2 * n);
    for i in 0..n {
        for j in 0..n {
            block.set(i, j, -a.at(i, j) * dt);
            block.set(i, n + j, w.at(i, j) * dt);
            block.set(n + i, n + j, a.at(j, i) * dt);
        }
    }
    let e = block.exp();
    let mut phi = Square::zeros(n);
    let mut upper = Square::zeros(n);
    for i in 0..n {
        for j in 0..n {
            phi.set(j, i, e.at(n + i, n + j));
            upper.set(i, j, e.at(i, n + j));
        }
    }
    let q = phi.mul(&upper);
    let q = q.add(&q.transpose()).scale(0.5);
    (phi, q)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_of_a_rotation() {
        let mut a = Square::zeros(2);
        a.set(0, 1, 7.0);
        a.set(1, 0, -7.0);
        let e = a.exp();
        assert!((e.at(0, 0) - 7.0_f64.cos()).abs() < 1e-13);
        assert!((e.at(0, 1) - 7.0_f64.sin()).abs() < 1e-13);
    }

    #[test]
    fn factor_times_transpose_gives_back() {
        let mut q = Square::zeros(3);
        for i in 0..3 {
            for j in 0..3 {
                // Rank 2: row 2 = row 0 + row 1.
                let rows = [[2.0, 1.0, 3.0], [1.0, 2.0, 3.0], [3.0, 3.0, 6.0]];
                q.set(i, j, rows[i][j]);
            }
        }
        let l = q.cholesky_psd();
        let back = l.mul(&l.transpose());
        for i in 0..3 {
            for j in 0..3 {
                assert!((back.at(i, j) - q.at(i, j)).abs() < 1e-12);
            }
        }
        assert_eq!(l.at(2, 2), 0.0);
    }

    #[test]
    fn lyapunov_scalar() {
        let phi = Square::identity(1).scale(0.9);
        let s = discrete_lyapunov(&phi, &Square::identity(1));
        assert!((s.at(0, 0) - 1.0 / (1.0 - 0.81)).abs() < 1e-12);
    }
}
