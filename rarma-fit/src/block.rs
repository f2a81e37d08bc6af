//! Equations taken many at a time, by reflections.
//!
//! Same factor as one by one with [`Triangle::add`], at a third of the time: one root
//! and one division a column of the block instead of one a row, and products that run
//! down columns, which the compiler turns into vectors.

use super::series::dot;
use super::triangle::Triangle;
use rarma_core::real::Real;

/// Equations in a block.
pub(super) const ROWS: usize = 32;

/// Equations x·θ = b, by columns; rows that are not in use are 0 and say nothing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<T, const N: usize> {
    pub columns: [[T; ROWS]; N],
    pub right: [T; ROWS],
}

impl<T: Real, const N: usize> Block<T, N> {
    /// No equations.
    pub fn new() -> Self {
        Self {
            columns: [[T::ZERO; ROWS]; N],
            right: [T::ZERO; ROWS],
        }
    }
}

/// A triangle that is given single equations and takes them by the block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Collected<T, const N: usize> {
    triangle: Triangle<T, N>,
    block: Block<T, N>,
    rows: usize,
}

impl<T: Real, const N: usize> Collected<T, N> {
    /// No equation yet, n unknowns.
    pub fn new(n: usize) -> Self {
        Self {
            triangle: Triangle::new(n),
            block: Block::new(),
            rows: 0,
        }
    }

    /// Takes one equation x·θ = b.
    #[inline(always)]
    pub fn add(&mut self, x: &[T; N], b: T) {
        let row = self.rows % ROWS;
        for (column, x) in self.block.columns.iter_mut().zip(x).take(self.triangle.n) {
            column[row] = *x;
        }
        self.block.right[row] = b;
        self.rows = row + 1;
        if self.rows == ROWS {
            self.triangle.add_block(&mut self.block);
            self.block = Block::new();
            self.rows = 0;
        }
    }

    /// The triangle of all equations.
    pub fn triangle(mut self) -> Triangle<T, N> {
        self.triangle.add_block(&mut self.block);
        self.triangle
    }
}

impl<T: Real, const N: usize> Triangle<T, N> {
    /// Takes the equations of a block, which is used up: Householder's reflections of the
    /// block below the triangle, column by column.
    pub(super) fn add_block(&mut self, block: &mut Block<T, N>) {
        let n = self.n.min(N);
        for i in 0..n {
            let (done, rest) = block.columns.split_at_mut(i + 1);
            let v = &done[i];
            let below = dot(v, v);
            if !(below > T::ZERO) {
                continue;
            }
            let d = self.r[i][i];
            let length = (d * d + below).sqrt();
            // The diagonal stays positive, as by rotations: what is drawn at random and
            // carried through R⁻¹ is the same. Not d − length, which would cancel.
            let head = -below / (d + length);
            let beta = T::from_f64(2.0) / (head * head + below);
            if !beta.is_finite() {
                continue;
            }
            self.r[i][i] = length;
            let reflect = |top: &mut T, column: &mut [T; ROWS]| {
                let w = beta * (head * *top + dot(v, column));
                *top -= w * head;
                for (x, v) in column.iter_mut().zip(v) {
                    *x -= w * *v;
                }
            };
            for (top, column) in self.r[i][i + 1..n].iter_mut().zip(rest) {
                reflect(top, column);
            }
            reflect(&mut self.z[i], &mut block.right);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the same equations one by one: RᵀR, solution, what is explained.
    fn compare<T: Real, const N: usize>(equations: usize, n: usize, tolerance: f64) {
        let mut single = Triangle::<T, N>::new(n);
        let mut collected = Collected::<T, N>::new(n);
        for k in 0..equations {
            let mut x = [T::ZERO; N];
            for (i, x) in x[..n].iter_mut().enumerate() {
                *x = T::from_f64(libm::sin((3 * k + 5 * i + i * k) as f64));
            }
            let b = T::from_f64(libm::cos(17.0 * k as f64)) + x[0];
            collected.add(&x, b);
            let _ = single.add(&mut x, b);
        }
        let block = collected.triangle();
        let close = |a: T, b: T| {
            let off = (a - b).abs().to_f64();
            assert!(
                off <= tolerance * (1.0 + b.abs().to_f64()),
                "{a:?} {b:?}, {n} of {equations}"
            );
        };
        close(block.explained(), single.explained());
        for (a, b) in block.r.iter().zip(&single.r) {
            a.iter().zip(b).for_each(|(a, b)| close(*a, *b));
        }
        for i in 0..n {
            close(block.column(i), single.column(i));
        }
        match (block.solve(), single.solve()) {
            (Some(a), Some(b)) => a.into_iter().zip(b).for_each(|(a, b)| close(a, b)),
            (a, b) => assert!(a.is_none() && b.is_none(), "{a:?} {b:?}"),
        }
    }

    #[test]
    fn blocks_give_the_triangle_of_single_equations() {
        for equations in [0, 1, 5, 31, 32, 33, 64, 500] {
            for n in [1, 2, 5] {
                compare::<f64, 5>(equations, n, 1e-9);
                compare::<f32, 5>(equations, n, 1e-3);
            }
        }
    }

    #[test]
    fn columns_of_zeros_say_nothing() {
        let mut collected = Collected::<f64, 3>::new(3);
        for k in 0..50 {
            collected.add(&[1.0, 0.0, libm::sin(f64::from(k))], 2.0);
        }
        let triangle = collected.triangle();
        assert!(triangle.solve().is_none());
        assert!((triangle.leading(1).solve().expect("regular")[0] - 2.0).abs() < 1e-12);
    }
}
