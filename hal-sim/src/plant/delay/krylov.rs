//! The few dominant eigenvalues of a large map that is only known by what it does.

use nalgebra::{Complex, DMatrix, DVector};

/// Steps between two looks at the eigenvalues.
const BLOCK: usize = 12;
/// Longest basis. Slow turning with a root every few hertz needs the most.
const MOST: usize = 240;
/// Relative change of the wanted eigenvalues that ends the iteration.
const TOLERANCE: f64 = 1e-9;

/// Dominant eigenvalues and their vectors.
pub(super) struct Dominant {
    /// By falling modulus; of a pair only the one with positive imaginary part.
    pub values: Vec<Complex<f64>>,
    /// The map leaves the range of numbers: there are no values.
    pub overflows: bool,
    basis: Vec<Vec<f64>>,
    small: DMatrix<f64>,
}

/// Arnoldi iteration with full orthogonalisation (twice), from a fixed start.
pub(super) fn dominant(
    n: usize,
    wanted: usize,
    mut map: impl FnMut(&[f64]) -> Vec<f64>,
) -> Dominant {
    let most = MOST.min(n);
    let mut h = DMatrix::<f64>::zeros(most + 1, most);
    let mut basis = vec![start(n)];
    let mut before: Vec<Complex<f64>> = Vec::new();
    for k in 0..most {
        let mut w = map(&basis[k]);
        let size = norm(&w);
        if !size.is_finite() {
            return Dominant::none(true);
        }
        for _ in 0..2 {
            for (j, v) in basis.iter().enumerate() {
                let d = dot(v, &w);
                h[(j, k)] += d;
                for (x, y) in w.iter_mut().zip(v) {
                    *x -= d * y;
                }
            }
        }
        let rest = norm(&w);
        h[(k + 1, k)] = rest;
        let exhausted = !(rest > 1e-13 * size) || k + 1 == most;
        if exhausted || (k + 1) % BLOCK == 0 {
            let small = h.view((0, 0), (k + 1, k + 1)).into_owned();
            let values = largest(&small, wanted);
            let settled = values.len() == before.len()
                && values
                    .iter()
                    .zip(&before)
                    .all(|(x, y)| (x - y).norm() <= TOLERANCE * (1.0 + x.norm()));
            if exhausted || settled {
                return Dominant {
                    values,
                    overflows: false,
                    basis,
                    small,
                };
            }
            before = values;
        }
        basis.push(w.iter().map(|x| x / rest).collect());
    }
    Dominant::none(false)
}

impl Dominant {
    fn none(overflows: bool) -> Self {
        Self {
            values: Vec::new(),
            overflows,
            basis: Vec::new(),
            small: DMatrix::zeros(0, 0),
        }
    }

    /// Real and imaginary part of the eigenvector of `values[i]`, by one inverse
    /// iteration on the small matrix.
    pub(super) fn vector(&self, i: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let k = self.small.nrows();
        let value = *self.values.get(i)?;
        // A shift next to the eigenvalue: the matrix stays regular.
        let shift = value + Complex::new(1e-9, 1e-9) * (1.0 + value.norm());
        let matrix = self.small.map(|x| Complex::new(x, 0.0))
            - DMatrix::<Complex<f64>>::identity(k, k) * shift;
        let lu = matrix.lu();
        let mut y = DVector::from_element(k, Complex::new(1.0, 0.0));
        for _ in 0..3 {
            y = lu.solve(&y)?;
            let size = y.norm();
            y /= Complex::new(size, 0.0);
        }
        let n = self.basis.first()?.len();
        let (mut re, mut im) = (vec![0.0; n], vec![0.0; n]);
        for (v, c) in self.basis.iter().zip(y.iter()) {
            for (j, x) in v.iter().enumerate() {
                re[j] += c.re * x;
                im[j] += c.im * x;
            }
        }
        Some((re, im))
    }
}

fn largest(small: &DMatrix<f64>, wanted: usize) -> Vec<Complex<f64>> {
    let scale = small.amax();
    if !(scale > 0.0) || !scale.is_finite() {
        return Vec::new();
    }
    let mut all: Vec<Complex<f64>> = small
        .complex_eigenvalues()
        .iter()
        .copied()
        .filter(|z| z.im >= 0.0)
        .collect();
    all.sort_by(|x, y| y.norm().total_cmp(&x.norm()));
    all.truncate(wanted);
    all
}

/// A fixed vector without symmetry.
fn start(n: usize) -> Vec<f64> {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let v: Vec<f64> = (0..n)
        .map(|_| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        })
        .collect();
    let size = norm(&v);
    v.iter().map(|x| x / size).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
