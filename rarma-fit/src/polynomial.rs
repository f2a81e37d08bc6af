//! Arithmetic of monic polynomials 1 + Σ aᵢ q⁻ⁱ inside the unit circle.

use rarma_core::real::Real;

/// Reflection coefficients k₁…k_p of A (step-down), k_p = a_p; none unless every
/// root lies inside the unit circle.
pub(super) fn reflections<T: Real, const N: usize>(a: &[T]) -> Option<[T; N]> {
    let p = a.len();
    if p > N {
        return None;
    }
    let mut work = [T::ZERO; N];
    work[..p].copy_from_slice(a);
    let mut out = [T::ZERO; N];
    for m in (1..=p).rev() {
        let k = work[m - 1];
        let rest = T::ONE - k * k;
        if !(rest > T::ZERO) {
            return None;
        }
        out[m - 1] = k;
        let before = work;
        for i in 0..m - 1 {
            work[i] = (before[i] - k * before[m - 2 - i]) / rest;
        }
    }
    Some(out)
}

/// One step up (Levinson): a of order m − 1 becomes that of order m with a_m = k.
#[inline(always)]
pub(super) fn step_up<T: Real>(a: &mut [T], m: usize, k: T) {
    for i in 0..(m - 1) / 2 {
        let (x, y) = (a[i], a[m - 2 - i]);
        a[i] = x + k * y;
        a[m - 2 - i] = y + k * x;
    }
    if (m - 1) % 2 == 1 {
        a[(m - 1) / 2] *= T::ONE + k;
    }
    a[m - 1] = k;
}

/// Autocovariance r(0)…r(L−1) of x = e/A with white e of variance 1, by running
/// Levinson's recursion backwards; none unless A is stable. p ≤ N.
pub(super) fn autocovariance<T: Real, const N: usize>(a: &[T], out: &mut [T]) -> Option<()> {
    let p = a.len();
    let k = reflections::<T, N>(a)?;
    let mut power = T::ONE;
    for k in &k[..p] {
        power /= T::ONE - *k * *k;
    }
    let mut stage = [T::ZERO; N];
    for m in 0..out.len() {
        if m == 0 {
            out[0] = power;
            continue;
        }
        // r(m) = −Σ aᵢ⁽ᵐ⁻¹⁾ r(m−i) − k_m·E_{m−1}
        let order = (m - 1).min(p);
        let mut sum = T::ZERO;
        for i in 0..order {
            sum -= stage[i] * out[m - 1 - i];
        }
        if m <= p {
            sum -= k[m - 1] * power;
            power *= T::ONE - k[m - 1] * k[m - 1];
            step_up(&mut stage, m, k[m - 1]);
        } else {
            sum = T::ZERO;
            for i in 0..p {
                sum -= a[i] * out[m - 1 - i];
            }
        }
        out[m] = sum;
    }
    out.iter().all(|x| x.is_finite()).then_some(())
}

/// Rows of the factorisation in [`reflect`]: enough for roots up to 0.99; nearer
/// ones end a little further inside, which for a start is welcome.
const ROWS: usize = 400;

/// Replaces C by the polynomial with the same spectrum shape and every root inside
/// |z| < radius. The rows of the Cholesky factor of the banded Toeplitz matrix of
/// C's autocovariance converge to it (Bauer); q ≤ N.
pub(super) fn reflect<T: Real, const N: usize>(c: &mut [T], radius: T) {
    let q = c.len();
    if rarma_core::estimate::schur::inside::<T, N>(c, radius) {
        return;
    }
    if q > 0 && c.iter().all(|x| x.is_finite()) {
        let at = |i: usize| if i == 0 { T::ONE } else { c[i - 1] };
        let mut r0 = T::ZERO;
        let mut r = [T::ZERO; N];
        for i in 0..=q {
            r0 += at(i) * at(i);
        }
        for k in 1..=q {
            for i in 0..=q - k {
                r[k - 1] += at(i) * at(i + k);
            }
        }
        // A little white noise keeps roots on the circle off it.
        r0 *= T::ONE + T::from_f64(1e-4);
        // rows[t mod (q+1)] holds L(t, t−k) at place k; the diagonal apart.
        let mut rows = [[T::ZERO; N]; N];
        let mut diagonal = [T::ZERO; N];
        for t in 0..ROWS {
            let slot = t % q;
            let mut row = [T::ZERO; N];
            for k in (1..=q.min(t)).rev() {
                let mut sum = r[k - 1];
                for m in k + 1..=q.min(t) {
                    sum -= row[m - 1] * rows[(t - k) % q][m - k - 1];
                }
                row[k - 1] = sum / diagonal[(t - k) % q];
            }
            let mut sum = r0;
            for x in &row[..q.min(t)] {
                sum -= *x * *x;
            }
            diagonal[slot] = sum.max(r0 * T::EPSILON).sqrt();
            rows[slot] = row;
        }
        let last = (ROWS - 1) % q;
        for (c, x) in c.iter_mut().zip(&rows[last]) {
            *c = *x / diagonal[last];
        }
    }
    shrink::<T, N>(c, radius);
}

/// Pulls the roots of C towards 0 until they lie inside the radius.
pub(super) fn shrink<T: Real, const N: usize>(c: &mut [T], radius: T) {
    // A little at first, so that light damping survives; then twice as much each time.
    let mut pull = T::from_f64(0.9998);
    for _ in 0..24 {
        if rarma_core::estimate::schur::inside::<T, N>(c, radius) {
            return;
        }
        let mut power = T::ONE;
        for c in c.iter_mut() {
            power *= pull;
            *c *= power;
        }
        pull *= pull;
    }
    c.fill(T::ZERO);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_down_and_up_are_inverse() {
        let a = [-1.1, 0.95, -0.805, 0.76];
        let k = reflections::<f64, 6>(&a).expect("stable");
        let mut back = [0.0; 6];
        for m in 1..=4 {
            step_up(&mut back, m, k[m - 1]);
        }
        for (x, y) in a.iter().zip(&back) {
            assert!((x - y).abs() < 1e-12);
        }
        assert!(k[..4].iter().all(|k| k.abs() < 1.0));
        assert!(reflections::<f64, 6>(&[-2.5, 1.0]).is_none());
        assert!(reflections::<f64, 1>(&[-0.5, 0.1]).is_none());
    }

    #[test]
    fn autocovariance_fulfils_its_equations() {
        let a = [-1.1, 0.95, -0.805, 0.76];
        let mut r = [0.0; 20];
        autocovariance::<f64, 4>(&a, &mut r).expect("stable");
        for k in 0..16usize {
            let sum: f64 = (0..=4)
                .map(|i| if i == 0 { 1.0 } else { a[i - 1] } * r[k.abs_diff(i)])
                .sum();
            let want = f64::from(u8::from(k == 0));
            assert!((sum - want).abs() < 1e-10, "lag {k}: {sum}");
        }
    }

    #[test]
    fn reflection_keeps_the_spectrum() {
        // Roots 0.5 and 1/0.8 become 0.5 and 0.8.
        let mut c = [-(0.5 + 1.25), 0.5 * 1.25];
        reflect::<f64, 3>(&mut c, 0.999);
        assert!(
            (c[0] + 1.3).abs() < 4e-3 && (c[1] - 0.4).abs() < 4e-3,
            "{c:?}"
        );
        let mut kept = [-1.3, 0.4];
        reflect::<f64, 3>(&mut kept, 0.999);
        assert_eq!(kept, [-1.3, 0.4]);
        let mut lost = [f64::NAN, 1.0];
        reflect::<f64, 3>(&mut lost, 0.999);
        assert_eq!(lost, [0.0, 0.0]);
    }
}
