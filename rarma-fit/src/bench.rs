//! Series with known models, for the tests of this module.

/// Normal noise of variance 1 (sum of twelve uniform numbers).
pub fn white(seed: u32, n: usize) -> Vec<f64> {
    let mut seed = seed.wrapping_mul(2_654_435_761).wrapping_add(12_345);
    (0..n)
        .map(|_| {
            let mut sum = -6.0;
            for _ in 0..12 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum += f64::from(seed >> 8) / 16_777_216.0;
            }
            sum
        })
        .collect()
}

/// A stationary ARMA series of unit noise variance, 3000 samples after rest.
pub fn arma(a: &[f64], c: &[f64], n: usize, seed: u32) -> Vec<f64> {
    const TRANSIENT: usize = 3000;
    let e = white(seed, n + TRANSIENT);
    let mut y = vec![0.0; e.len()];
    for t in 0..e.len() {
        y[t] = e[t];
        for (i, c) in c.iter().enumerate().take(t) {
            y[t] += c * e[t - 1 - i];
        }
        for (i, a) in a.iter().enumerate().take(t) {
            y[t] -= a * y[t - 1 - i];
        }
    }
    y.split_off(TRANSIENT)
}

/// Coefficients of the product of factors 1 − 2r·cos θ·q⁻¹ + r²·q⁻².
pub fn pairs(pairs: &[(f64, f64)]) -> Vec<f64> {
    let mut a = vec![1.0];
    for &(r, theta) in pairs {
        let factor = [1.0, -2.0 * r * theta.cos(), r * r];
        let mut next = vec![0.0; a.len() + 2];
        for (i, x) in a.iter().enumerate() {
            for (j, y) in factor.iter().enumerate() {
                next[i + j] += x * y;
            }
        }
        a = next;
    }
    a.split_off(1)
}
