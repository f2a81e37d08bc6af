//! One step of the semi-discretisation, solved exactly.

use super::{CHANNELS, Coupling, RESPONSES, Seen, StepLaw};
use crate::error::{PlantError, require};

/// Terms of the exponential series are added until one is below this part of the first: with 50 steps a period
/// ‖A·dt‖ ≈ 0.13, which are eleven; deep cuts and long steps need more.
const NEGLIGIBLE: f64 = 1e-17;
/// Largest sum of a row of A·dt: beyond it the terms, up to e²⁰, would cancel to
/// worse than 1e-7, and the step resolves nothing.
const LONGEST: f64 = 20.0;

/// xₖ₊₁ = P·xₖ + Σⱼ G₀·Kⱼ·rₖ₋ₘ + G₁·Kⱼ·rₖ₋ₘ₊₁.
///
/// x holds (ω·q, v) of each mode. P = e^(Ã·dt) with the present part of the
/// cutting force in Ã; G₁ = dt·φ₂·B, G₀ = dt·(φ₁ - φ₂)·B with φ₁ = Σ (Ãdt)ᵏ/(k+1)!
/// and φ₂ = Σ (Ãdt)ᵏ/(k+2)!: the delayed force is a straight line in the step.
#[derive(Clone, Debug)]
pub(super) struct StepMap {
    n: usize,
    p: Vec<f64>,
    g0: Vec<[f64; CHANNELS]>,
    g1: Vec<[f64; CHANNELS]>,
    delayed: Vec<(usize, Coupling)>,
}

impl StepMap {
    /// The step of length `dt` s.
    ///
    /// # Errors
    /// `OutOfRange` where the step is too long for the cut's stiffness.
    pub(super) fn new(
        seen: &[Seen],
        law: &StepLaw,
        dt: f64,
        scale: f64,
    ) -> Result<Self, PlantError> {
        let n = 2 * seen.len();
        let mut present = [[0.0; RESPONSES]; CHANNELS];
        for (_, k) in &law.regeneration {
            for (row, add) in present.iter_mut().zip(k) {
                for (x, y) in row.iter_mut().zip(add) {
                    *x += y;
                }
            }
        }
        // Ã·dt, row by row, and B·dt.
        let mut a = vec![0.0; n * n];
        let mut b = vec![[0.0; CHANNELS]; n];
        for (i, s) in seen.iter().enumerate() {
            let (w, m) = (s.mode.omega(), s.mode.mass_kg());
            a[2 * i * n + 2 * i + 1] += w * dt;
            a[(2 * i + 1) * n + 2 * i] -= w * dt;
            a[(2 * i + 1) * n + 2 * i + 1] -= 2.0 * s.mode.zeta * w * dt;
            for (l, o) in seen.iter().enumerate() {
                let through = |k: &Coupling, shape: [f64; RESPONSES]| -> f64 {
                    let row = |c: usize| k[c][0] * shape[0] + k[c][1] * shape[1];
                    (0..CHANNELS).map(|c| s.input[c] * row(c)).sum::<f64>() / m
                };
                let row = (2 * i + 1) * n + 2 * l;
                a[row] -= through(&present, o.chip) / o.mode.omega() * dt;
                a[row + 1] -= through(&law.rubbing, o.motion) * dt;
            }
            for c in 0..CHANNELS {
                b[2 * i + 1][c] = s.input[c] / m * dt;
            }
        }
        let size = (0..n)
            .map(|i| a[i * n..(i + 1) * n].iter().map(|x| x.abs()).sum())
            .fold(0.0, f64::max);
        require(size <= LONGEST, "steps_per_period")?;
        let mut p = identity(n);
        let mut power = identity(n);
        let mut product_of = vec![0.0; n * n];
        // (Ãdt)ᵏ·B·dt.
        let mut carried = b.clone();
        let mut carried_on = vec![[0.0; CHANNELS]; n];
        let (mut g0, mut g1) = (
            vec![[0.0; CHANNELS]; n],
            b.iter().map(|r| r.map(|x| 0.5 * x)).collect::<Vec<_>>(),
        );
        for (g, x) in g0.iter_mut().zip(&b) {
            *g = x.map(|x| 0.5 * x);
        }
        let (mut factorial, mut term) = (1.0, 1.0);
        for k in 1.. {
            let kf = f64::from(k);
            factorial *= kf;
            term *= size / kf;
            if !(term > NEGLIGIBLE) {
                break;
            }
            product(&a, &power, n, &mut product_of);
            core::mem::swap(&mut power, &mut product_of);
            for (x, y) in p.iter_mut().zip(&power) {
                *x += y / factorial;
            }
            for (i, row) in carried_on.iter_mut().enumerate() {
                *row = [0.0; CHANNELS];
                for (x, carried) in a[i * n..(i + 1) * n].iter().zip(&carried) {
                    for (row, carried) in row.iter_mut().zip(carried) {
                        *row += x * carried;
                    }
                }
            }
            core::mem::swap(&mut carried, &mut carried_on);
            let second = 1.0 / (factorial * (kf + 1.0) * (kf + 2.0));
            let first = 1.0 / (factorial * (kf + 1.0)) - second;
            for i in 0..n {
                for c in 0..CHANNELS {
                    g0[i][c] += first * carried[i][c];
                    g1[i][c] += second * carried[i][c];
                }
            }
        }
        let delayed = law
            .regeneration
            .iter()
            .map(|(lag, k)| (*lag, k.map(|row| row.map(|x| x / scale))))
            .collect();
        Ok(Self {
            n,
            p,
            g0,
            g1,
            delayed,
        })
    }

    /// The state after the step; `past[now]` is the response at its start.
    pub(super) fn apply(
        &self,
        state: &[f64],
        past: &[[f64; RESPONSES]],
        now: usize,
        next: &mut [f64],
    ) {
        let (mut f0, mut f1) = ([0.0; CHANNELS], [0.0; CHANNELS]);
        for (lag, k) in &self.delayed {
            let (r0, r1) = (past[now - lag], past[now + 1 - lag]);
            for c in 0..CHANNELS {
                f0[c] += k[c][0] * r0[0] + k[c][1] * r0[1];
                f1[c] += k[c][0] * r1[0] + k[c][1] * r1[1];
            }
        }
        for (i, out) in next.iter_mut().enumerate() {
            let row = &self.p[i * self.n..(i + 1) * self.n];
            let mut sum: f64 = row.iter().zip(state).map(|(p, x)| p * x).sum();
            for c in 0..CHANNELS {
                sum += self.g0[i][c] * f0[c] + self.g1[i][c] * f1[c];
            }
            *out = sum;
        }
    }
}

impl StepMap {
    /// [`Self::apply`] of the straight line from this step to another at `part` of the
    /// way; both have the same delays.
    pub(super) fn apply_between(
        &self,
        other: &Self,
        part: f64,
        state: &[f64],
        past: &[[f64; RESPONSES]],
        now: usize,
        next: &mut [f64],
    ) {
        let forces = |map: &Self| {
            let (mut f0, mut f1) = ([0.0; CHANNELS], [0.0; CHANNELS]);
            for (lag, k) in &map.delayed {
                let (r0, r1) = (past[now - lag], past[now + 1 - lag]);
                for c in 0..CHANNELS {
                    f0[c] += k[c][0] * r0[0] + k[c][1] * r0[1];
                    f1[c] += k[c][0] * r1[0] + k[c][1] * r1[1];
                }
            }
            (f0, f1)
        };
        // The cut of a phase is the same at every length of its step.
        let (f0, f1) = forces(self);
        let n = self.n;
        for (i, out) in next.iter_mut().enumerate() {
            let rows = self.p[i * n..(i + 1) * n]
                .iter()
                .zip(&other.p[i * n..(i + 1) * n]);
            let (mut one, mut two) = (0.0, 0.0);
            for ((p, q), x) in rows.zip(state) {
                one += p * x;
                two += q * x;
            }
            for c in 0..CHANNELS {
                one += self.g0[i][c] * f0[c] + self.g1[i][c] * f1[c];
                two += other.g0[i][c] * f0[c] + other.g1[i][c] * f1[c];
            }
            *out = one + part * (two - one);
        }
    }
}

fn identity(n: usize) -> Vec<f64> {
    let mut m = vec![0.0; n * n];
    for i in 0..n {
        m[i * n + i] = 1.0;
    }
    m
}

fn product(a: &[f64], b: &[f64], n: usize, out: &mut [f64]) {
    for (out, row) in out.chunks_exact_mut(n).zip(a.chunks_exact(n)) {
        out.fill(0.0);
        for (x, b) in row.iter().zip(b.chunks_exact(n)) {
            if *x != 0.0 {
                for (out, b) in out.iter_mut().zip(b) {
                    *out += x * b;
                }
            }
        }
    }
}
