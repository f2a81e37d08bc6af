//! The columns of an ARX equation, filtered.

use rarma_core::real::Real;

/// Columns of shifted series, each through 1/A and at rest before the first equation, so that what went before the
/// record does not ring through the filter.
///
/// There are two series, of the output and of the input, newest column first. With s(t−i) in column i and h the
/// impulse response of 1/A, column i is column i−1 one sample later, but for the value that it begins with, t₀ being
/// the first equation:
///
/// ```text
/// c₀(t) = s(t) − Σ aⱼ c₀(t−j),   cᵢ(t) = cᵢ₋₁(t−1) + s(t₀−i)·h(t−t₀)
/// ```
///
/// One filter for each series, then, and not one for each column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns<T, const N: usize> {
    /// Columns of the output, and of both.
    ends: [usize; 2],
    /// What the columns begin with.
    first: Option<[T; N]>,
    now: [T; N],
    /// Past of each series' first column.
    heads: [[T; N]; 2],
    /// Past of h.
    response: [T; N],
}

impl<T: Real, const N: usize> Columns<T, N> {
    /// `p` columns of the output before those of the input, `k` ≤ N in all; at rest.
    pub fn new(p: usize, k: usize) -> Self {
        Self {
            ends: [p, k],
            first: None,
            now: [T::ZERO; N],
            heads: [[T::ZERO; N]; 2],
            response: [T::ZERO; N],
        }
    }

    /// Takes the columns of the next sample and returns them filtered.
    pub fn filtered(&mut self, a: &[T], row: &[T; N]) -> [T; N] {
        let impulse = match self.first {
            None => T::ONE,
            Some(_) => T::ZERO,
        };
        let first = *self.first.get_or_insert(*row);
        let response = &mut self.response[..a.len()];
        let h = step(a, response, impulse);
        // Once it has died away it is nothing, and not numbers too small to be counted with quickly.
        if response.iter().all(|x| x.abs() < T::EPSILON * T::EPSILON) {
            response.fill(T::ZERO);
        }
        let mut begin = 0;
        for (end, head) in self.ends.into_iter().zip(&mut self.heads) {
            if let [newest, others @ ..] = &mut self.now[begin..end] {
                let mut before = *newest;
                for (column, s) in others.iter_mut().zip(&first[begin + 1..end]) {
                    (*column, before) = (before + *s * h, *column);
                }
                *newest = step(a, &mut head[..a.len()], row[begin]);
            }
            begin = end;
        }
        self.now
    }
}

/// One step of x ← 1/A·input; `past` newest first.
#[inline(always)]
pub(super) fn step<T: Real>(a: &[T], past: &mut [T], input: T) -> T {
    let mut x = input;
    for (a, before) in a.iter().zip(past.iter()) {
        x -= *a * *before;
    }
    if let Some(n) = past.len().checked_sub(1) {
        past.copy_within(..n, 1);
        past[0] = x;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each column by a filter of its own.
    #[test]
    fn shifts_are_as_good_as_filters() {
        let a = [-1.6, 0.9, -0.2];
        let series = |t: usize, of: f64| libm::sin(of * (t * t) as f64);
        let row = |t: usize| -> [f64; 5] {
            let output = [1, 2, 3].map(|i| -series(t - i, 0.3));
            let input = [0, 1].map(|j| series(t - j, 0.7));
            [output[0], output[1], output[2], input[0], input[1]]
        };
        let mut columns = Columns::<f64, 5>::new(3, 5);
        let mut past = [[0.0; 3]; 5];
        for t in 3..200 {
            let got = columns.filtered(&a, &row(t));
            for ((x, past), got) in row(t).into_iter().zip(&mut past).zip(got) {
                let want = step(&a, past, x);
                assert!((got - want).abs() < 1e-12, "{t}: {got} for {want}");
            }
        }
        // Without a filter they are what they are.
        let mut columns = Columns::<f64, 5>::new(0, 2);
        for t in 3..9 {
            let got = columns.filtered(&[], &[series(t, 1.0), series(t - 1, 1.0), 0.0, 0.0, 0.0]);
            assert_eq!(got[..2], [series(t, 1.0), series(t - 1, 1.0)]);
        }
    }
}
