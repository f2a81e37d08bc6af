//! Covariance of the parameters in factored form, P = U·D·Uᵀ.
//!
//! U is unit upper triangular and D diagonal and positive. Every operation here
//! multiplies a diagonal element by a ratio of positive numbers or adds to it, so
//! P stays symmetric and positive definite by construction, also in `f32` and
//! after any number of samples; a plain covariance recursion in `f32` loses
//! definiteness within minutes on narrow-band signals. Rate: once a sample.
//!
//! Columns of U are stored contiguously: `u[j][i]` is U(i, j) for i < j.

use crate::real::Real;
use crate::visit::{self, StateVisitor};

/// Runs an expression for each block of columns: four in a block, three where there are
/// more than twelve columns, which is what counts least (decision note 84). The first
/// sixteen are written out, so that with an order known when the code is built each block
/// has its own straight code: indices without bounds checks, no loop.
macro_rules! each_block {
    ($n:ident, $work:ident) => {
        if N > 12 {
            each_block!(@ $n, $work, 0 3 6 9 12 15);
        } else {
            each_block!(@ $n, $work, 0 4 8);
        }
        for j in 16..$n {
            $work!(j, 1);
        }
    };
    (@ $n:ident, $work:ident, $($k:literal)*) => {
        $(
            if N <= 12 && $k + 3 < $n && $k + 3 < N {
                $work!($k, 4);
            } else if $k + 2 < $n && $k + 2 < N && $k + 2 < 16 {
                $work!($k, 3);
            } else if $k + 1 < $n && $k + 1 < N && $k + 1 < 16 {
                $work!($k, 2);
            } else if $k < $n && $k < N {
                $work!($k, 1);
            }
        )*
    };
}

/// Least value of a diagonal factor: a normal number of `f32`, far below any that
/// matters.
const LEAST_FACTOR: f64 = 1e-30;

/// Factors of an n × n covariance, n ≤ N (N is storage, n the order in use).
#[derive(Debug, Clone)]
pub struct UdFactors<T, const N: usize> {
    u: [[T; N]; N],
    d: [T; N],
}

impl<T: Real, const N: usize> UdFactors<T, N> {
    /// Zeros, until [`Self::reset`].
    pub(crate) const BLANK: Self = Self {
        u: [[T::ZERO; N]; N],
        d: [T::ZERO; N],
    };

    /// `variance` times the identity.
    pub fn diagonal(variance: T) -> Self {
        Self {
            d: [variance; N],
            ..Self::BLANK
        }
    }

    /// Back to `variance` times the identity, in place.
    pub fn reset(&mut self, variance: T) {
        self.u.as_flattened_mut().fill(T::ZERO);
        self.d.fill(variance);
    }

    /// Every number, for one who keeps the state of a model or puts it back.
    pub(crate) fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) {
        let Self { u, d } = self;
        visit::all(u.as_flattened_mut(), visitor);
        visit::all(d, visitor);
    }

    /// The numbers of an n × n covariance alone, for one who keeps the state of a model of this
    /// order in larger storage, or puts it back. Slow path.
    pub fn visit_part(&mut self, n: usize, visitor: &mut impl StateVisitor<T>) {
        for (j, column) in self.u.iter_mut().enumerate().take(n) {
            visit::all(column.iter_mut().take(j), visitor);
        }
        visit::all(self.d.iter_mut().take(n), visitor);
    }

    /// Diagonal factors in use; all positive.
    pub fn d(&self) -> &[T; N] {
        &self.d
    }

    /// Measurement update (Bierman) and forgetting: for one scalar equation with
    /// regressor ψ and noise variance r,
    ///
    /// ```text
    /// α = r + ψᵀPψ,   K = Pψ/α,   P ← (P − Pψ ψᵀP/α)·growth
    /// ```
    ///
    /// Writes Pψ into `gain[..n]` and returns 1/α. Requires r > 0; `growth` is 1/λ.
    #[inline(always)]
    pub fn measure(&mut self, n: usize, psi: &[T; N], r: T, growth: T, gain: &mut [T; N]) -> T {
        // f = Uᵀψ, column by column: α_j = α_{j-1} + f_j·v_j with v = D·f.
        let mut alpha = (r, T::ONE / r);
        macro_rules! block {
            ($j:expr, $size:literal) => {
                alpha = self.measure_block::<$size>($j, psi, alpha, growth, gain)
            };
        }
        each_block!(n, block);
        alpha.1
    }

    /// Columns j to j + B − 1 of [`Self::measure`] in one pass: takes α_{j−1} and its
    /// inverse, gives those of the last. What the columns share (ψ and the gain) is read and written once.
    #[inline(always)]
    fn measure_block<const B: usize>(
        &mut self,
        j: usize,
        psi: &[T; N],
        before: (T, T),
        growth: T,
        gain: &mut [T; N],
    ) -> (T, T) {
        let Some(Ok(columns)) = self.u.get_mut(j..j + B).map(<&mut [[T; N]; B]>::try_from) else {
            return before;
        };
        let mut f: [T; B] = core::array::from_fn(|b| psi[j + b]);
        for i in 0..j {
            let t: [T; B] = core::array::from_fn(|b| columns[b][i] * psi[i]);
            for b in 0..B {
                f[b] += t[b];
            }
        }
        for b in 1..B {
            for i in 0..b {
                f[b] += columns[b][j + i] * psi[j + i];
            }
        }
        let (mut alpha, mut inverse) = before;
        let (mut v, mut lambda) = ([T::ZERO; B], [T::ZERO; B]);
        for b in 0..B {
            let d = self.d[j + b];
            v[b] = d * f[b];
            lambda[b] = f[b] * inverse;
            let next = alpha + f[b] * v[b];
            inverse = T::ONE / next;
            // A strong regressor takes a factor down by up to 1e15 a sample, and its
            // turn to be held comes once in n samples: the sum keeps it above 0.
            self.d[j + b] = d * (alpha * inverse * growth) + T::from_f64(LEAST_FACTOR);
            alpha = next;
        }
        for i in 0..j {
            let u: [T; B] = core::array::from_fn(|b| columns[b][i]);
            let mut g = gain[i];
            let t: [T; B] = core::array::from_fn(|b| v[b] * u[b]);
            for b in 0..B {
                let s = lambda[b] * g;
                g += t[b];
                columns[b][i] = u[b] - s;
            }
            gain[i] = g;
        }
        for i in 0..B {
            let mut g = v[i];
            for b in i + 1..B {
                let u = columns[b][j + i];
                let s = lambda[b] * g;
                let t = v[b] * u;
                g += t;
                columns[b][j + i] = u - s;
            }
            gain[j + i] = g;
        }
        (alpha, inverse)
    }

    /// Brings one diagonal factor, `turn`, into `d_min..=d_max`, each in its turn, so
    /// that no factor is ever further outside than λ⁻ⁿ. The ceiling is what stops
    /// wind-up when a direction is not excited; the floor keeps every factor a normal
    /// number of its type. Returns true if the ceiling held the factor back.
    #[inline(always)]
    pub fn hold(&mut self, turn: usize, d_min: T, d_max: T) -> bool {
        let Some(d) = self.d.get_mut(turn) else {
            return false;
        };
        let limited = *d > d_max;
        if limited {
            *d = d_max;
        } else if *d < d_min {
            *d = d_min;
        }
        limited
    }

    /// Adds `variance` to one diagonal element of P (Agee–Turner rank-one update
    /// with a unit vector): P ← P + variance·e_i·e_iᵀ.
    ///
    /// Adding n·q to one element a sample, each in turn, is a random walk of
    /// variance q a sample on every parameter at O(n²) instead of O(n³).
    #[inline(always)]
    pub fn spread(&mut self, i: usize, variance: T) {
        let mut a = [T::ZERO; N];
        let mut c = variance;
        // a = e_i: nothing happens right of column i, and a(k) for k < i turns
        // into −U(k, i) once column i is through.
        let (Some(d), Some(column)) = (self.d.get_mut(i), self.u.get_mut(i)) else {
            return;
        };
        let before = *d;
        let after = before + c;
        *d = after;
        let inverse = T::ONE / after;
        for (a, u) in a.iter_mut().zip(column.iter_mut()).take(i) {
            *a = -*u;
            *u += c * inverse * *a;
        }
        c = c * before * inverse;
        for j in (0..i).rev() {
            let a_j = a[j];
            let before = self.d[j];
            let after = before + c * a_j * a_j;
            self.d[j] = after;
            let inverse = T::ONE / after;
            let beta = c * a_j * inverse;
            for k in 0..j {
                let u = self.u[j][k];
                a[k] -= a_j * u;
                self.u[j][k] = u + beta * a[k];
            }
            c = c * before * inverse;
        }
    }

    /// Quadratic forms xᵀPx and yᵀPy at once, of vectors that are 0 from element
    /// `used` on. Decision rate.
    pub fn quadratics(&self, n: usize, used: usize, x: &[T; N], y: &[T; N]) -> (T, T) {
        let (mut xx, mut yy) = (T::ZERO, T::ZERO);
        for j in 0..n {
            let (mut f, mut g) = (x[j], y[j]);
            // Four at a time: a sum and a loop's end for each would take as long as the products.
            let (fours, rest) = self.u[j][..j.min(used)].as_chunks::<4>();
            let ((x4, _), (y4, _)) = (x.as_chunks::<4>(), y.as_chunks::<4>());
            for ((u, x), y) in fours.iter().zip(x4).zip(y4) {
                for i in 0..4 {
                    f += u[i] * x[i];
                    g += u[i] * y[i];
                }
            }
            let left = x.iter().zip(y).skip(4 * fours.len());
            for (u, (x, y)) in rest.iter().zip(left) {
                f += *u * *x;
                g += *u * *y;
            }
            xx += self.d[j] * f * f;
            yy += self.d[j] * g * g;
        }
        (xx, yy)
    }

    /// P·x, 0 from element n on. Slow path.
    pub fn product(&self, n: usize, x: &[T; N]) -> [T; N] {
        let mut out = [T::ZERO; N];
        for j in 0..n {
            let mut f = x[j];
            for (u, x) in self.u[j][..j].iter().zip(x) {
                f += *u * *x;
            }
            f *= self.d[j];
            for (out, u) in out.iter_mut().zip(&self.u[j][..j]) {
                *out += *u * f;
            }
            out[j] += f;
        }
        out
    }

    /// Bilinear form xᵀ P y. Slow path.
    pub fn bilinear(&self, n: usize, x: &[T; N], y: &[T; N]) -> T {
        let mut sum = T::ZERO;
        for j in 0..n {
            let (mut f, mut g) = (x[j], y[j]);
            for i in 0..j {
                f += self.u[j][i] * x[i];
                g += self.u[j][i] * y[i];
            }
            sum += self.d[j] * f * g;
        }
        sum
    }

    /// One element of P. Slow path.
    pub fn element(&self, n: usize, row: usize, col: usize) -> T {
        let mut x = [T::ZERO; N];
        let mut y = [T::ZERO; N];
        x[row] = T::ONE;
        y[col] = T::ONE;
        self.bilinear(n, &x, &y)
    }

    /// Every factor finite and every diagonal factor positive, i.e. P finite and
    /// positive definite. Slow path; for tests and the once-a-decision check.
    pub fn is_definite(&self, n: usize) -> bool {
        (0..n).all(|j| {
            self.d[j] > T::ZERO
                && self.d[j].is_finite()
                && self.u[j][..j].iter().all(|u| u.is_finite())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 5;

    fn dense(p: &UdFactors<f64, N>) -> [[f64; N]; N] {
        let mut out = [[0.0; N]; N];
        for (i, row) in out.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x = p.element(N, i, j);
            }
        }
        out
    }

    fn regressor(k: usize) -> [f64; N] {
        core::array::from_fn(|i| libm::sin((k * 7 + i * 3 + i * k) as f64))
    }

    #[test]
    fn follows_the_dense_recursion() {
        let mut ud = UdFactors::<f64, N>::diagonal(2.0);
        let mut p = dense(&ud);
        let (lambda, r) = (0.98, 0.3);
        for k in 0..200 {
            let psi = regressor(k);
            let mut gain = [0.0; N];
            let inverse = ud.measure(N, &psi, r, 1.0 / lambda, &mut gain);
            let _ = ud.hold(k % N, 0.0, 1e30);
            ud.spread(k % N, 1e-3);

            let pp: [f64; N] = core::array::from_fn(|i| (0..N).map(|j| p[i][j] * psi[j]).sum());
            let a: f64 = r + (0..N).map(|i| psi[i] * pp[i]).sum::<f64>();
            for i in 0..N {
                assert!((gain[i] - pp[i]).abs() < 1e-10, "gain at step {k}");
            }
            assert!((inverse * a - 1.0).abs() < 1e-10);
            for i in 0..N {
                for j in 0..N {
                    p[i][j] = (p[i][j] - pp[i] * pp[j] / a) / lambda;
                }
            }
            p[k % N][k % N] += 1e-3;
        }
        let q = dense(&ud);
        let x = regressor(3);
        for (row, y) in q.iter().zip(ud.product(N, &x)) {
            let sum: f64 = row.iter().zip(x).map(|(p, x)| p * x).sum();
            assert!((sum - y).abs() < 1e-12, "{sum} {y}");
        }
        for i in 0..N {
            for j in 0..N {
                assert!(
                    (p[i][j] - q[i][j]).abs() < 1e-9 * p[i][i].max(1e-6),
                    "P({i},{j}) = {} against {}",
                    q[i][j],
                    p[i][j]
                );
            }
        }
    }

    #[test]
    fn ceiling_stops_wind_up() {
        let mut ud = UdFactors::<f32, 3>::diagonal(1.0);
        let mut limited = false;
        for k in 0..10_000 {
            let _ = ud.measure(3, &[0.0; 3], 1.0, 1.0 / 0.99, &mut [0.0; 3]);
            limited |= ud.hold(k % 3, 1e-20, 1e4);
        }
        assert!(limited && ud.is_definite(3));
        assert!(ud.d().iter().all(|&d| (0.99e4..1.04e4).contains(&d)));
    }

    #[test]
    fn no_factor_reaches_zero() {
        let mut ud = UdFactors::<f32, 3>::diagonal(1.0);
        for k in 0..100_000u32 {
            let psi = [1e6, 1e6 * (k % 7) as f32, -1e6 * (k % 5) as f32];
            let _ = ud.measure(3, &psi, 1e-20, 1.0, &mut [0.0; 3]);
            assert!(ud.is_definite(3), "{:?}", ud.d());
        }
    }
}
