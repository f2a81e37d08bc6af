//! Roots of A tracked from sample to sample as real quadratic factors.
//!
//! A degree-p polynomial is kept as ⌈p/2⌉ factors z² − u·z + v. A factor holds a
//! conjugate pair or two real roots alike, so a mode that becomes overdamped and
//! comes back needs no special case. Rate: once a sample, a fixed number of sweeps.

use super::aberth;
use super::quadratic::{Quadratic, Residue, Roots};
use crate::real::Real;
use crate::visit::StateVisitor;

/// How far the factors are from the polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tracking {
    /// The last sweep moved no factor by more than the tolerance.
    Converged,
    /// Following, but the polynomial moves faster than one sweep can.
    Following,
    /// Lost; being found again from a cold start, a few sweeps a sample.
    Searching,
}

/// Roots of a monic polynomial of degree p ≤ `P`, followed from sample to sample.
///
/// One sweep corrects each factor q_k by the Newton step on the factorisation
/// (Durand–Kerner for quadratic factors):
///
/// ```text
/// q_k ← q_k + (A mod q_k)·(Π_{j≠k} q_j)⁻¹  mod q_k
/// ```
///
/// It converges quadratically, to pairs and to real roots. An odd degree is
/// padded by one root at 0. If a factor fails to settle for `PATIENCE` samples
/// the search starts anew from a circle, still at a fixed cost per sample; until
/// it has converged, [`Tracking::Searching`] is returned and the old factors stay.
///
/// ```
/// use rarma_core::spectrum::{FactorTracker, Roots};
/// // (z² − 1.6 z + 0.95)(z² + 0.5 z + 0.8)
/// let a = [-1.1, 0.95, -0.805, 0.76];
/// let mut tracker = FactorTracker::<f64, 4>::new();
/// tracker.solve(&a, 200).unwrap();
/// let mut v: Vec<f64> = tracker.factors(4).iter().map(|q| q.v).collect();
/// v.sort_by(f64::total_cmp);
/// assert!((v[0] - 0.8).abs() < 1e-12 && (v[1] - 0.95).abs() < 1e-12);
/// ```
#[derive(Debug, Clone)]
pub struct FactorTracker<T, const P: usize> {
    factors: [Quadratic<T>; P],
    search: [Quadratic<T>; P],
    searching: bool,
    attempts: u32,
    unsettled: u32,
    sweeps: u32,
}

/// Samples a factor may stay unsettled before the search starts anew.
const PATIENCE: u32 = 64;
/// Sweeps of one search before it starts from another circle.
const SEARCH_SWEEPS: u32 = 120;
/// Sweeps per sample while searching.
const SEARCH_RATE: u32 = 2;
/// A correction below this counts as following: what is left is of its square.
const SETTLED: f64 = 1e-3;
/// Step of a factor away from another that it coincides with.
const ASIDE: f64 = 0.01;
/// Largest step of u or v in one sweep while following: keeps a bad moment local.
const LARGEST_STEP: f64 = 0.25;

impl<T: Real, const P: usize> Default for FactorTracker<T, P> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real, const P: usize> FactorTracker<T, P> {
    /// Zeros, until [`Self::restart`].
    #[cfg(feature = "monitor")]
    pub(crate) const BLANK: Self = Self {
        factors: [Quadratic::BLANK; P],
        search: [Quadratic::BLANK; P],
        searching: false,
        attempts: 0,
        unsettled: 0,
        sweeps: 0,
    };

    /// Factors on a circle, to be found by the first samples.
    pub fn new() -> Self {
        let start = circle(P.div_ceil(2), 0);
        Self {
            factors: start,
            search: start,
            searching: true,
            attempts: 0,
            unsettled: 0,
            sweeps: 0,
        }
    }

    /// Shows every number of the state to `visitor`, as
    /// [`RecursiveArma::visit_state`](crate::estimate::RecursiveArma::visit_state) does.
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<T>) {
        let Self {
            factors,
            search,
            searching,
            attempts,
            unsettled,
            sweeps,
        } = self;
        for factor in factors.iter_mut().chain(search) {
            visitor.number(&mut factor.u);
            visitor.number(&mut factor.v);
        }
        let mut is_searching = u32::from(*searching);
        visitor.count(&mut is_searching);
        *searching = is_searching != 0;
        for n in [attempts, unsettled, sweeps] {
            visitor.count(n);
        }
    }

    /// Forgets everything, as [`Self::new`] knows nothing.
    pub fn restart(&mut self) {
        *self = Self::new();
    }

    /// Factors of a polynomial of degree `p`: ⌈p/2⌉ of them, in an order that is
    /// kept from sample to sample.
    pub fn factors(&self, p: usize) -> &[Quadratic<T>] {
        &self.factors[..p.div_ceil(2)]
    }

    /// The polynomial is another one: the next calls of [`Self::track`] seek its roots
    /// from a cold start.
    #[inline(always)]
    pub fn search(&mut self) {
        self.searching = true;
        self.sweeps = SEARCH_SWEEPS;
    }

    /// Follows z^p + a₁ z^(p-1) + … + a_p by one sweep (two while searching).
    #[inline(always)]
    pub fn track(&mut self, a: &[T]) -> Tracking {
        let m = a.len().div_ceil(2);
        if self.searching {
            for _ in 0..SEARCH_RATE {
                let moved = sweep(a, &mut self.search[..m], T::from_f64(1e3));
                self.sweeps += 1;
                if moved < T::from_f64(SETTLED) {
                    adopt(&mut self.factors[..m], &self.search[..m]);
                    self.searching = false;
                    self.unsettled = 0;
                    return Tracking::Converged;
                }
                if !moved.is_finite() || self.sweeps > SEARCH_SWEEPS {
                    self.attempts = self.attempts.wrapping_add(1);
                    self.search = circle(m, self.attempts);
                    self.sweeps = 0;
                }
            }
            return Tracking::Searching;
        }
        let moved = sweep(a, &mut self.factors[..m], T::from_f64(LARGEST_STEP));
        if moved < T::from_f64(SETTLED) {
            self.unsettled = 0;
            return Tracking::Converged;
        }
        self.unsettled += 1;
        if self.unsettled == PATIENCE / 4 {
            pair_neighbours(&mut self.factors[..m]);
        }
        if !moved.is_finite() || self.unsettled > PATIENCE {
            self.searching = true;
            self.sweeps = 0;
            self.search = circle(m, self.attempts);
        }
        Tracking::Following
    }

    /// Solves from a cold start, at most `sweeps` sweeps. Slow path.
    ///
    /// Returns the number of sweeps taken, or none if it did not converge.
    pub fn solve(&mut self, a: &[T], sweeps: u32) -> Option<u32> {
        let m = a.len().div_ceil(2);
        if a.iter().any(|x| !x.is_finite()) {
            return None;
        }
        self.searching = false;
        let mut quiet = 0;
        for attempt in 0..4 {
            self.factors = circle(m, attempt);
            for n in 0..sweeps {
                let moved = sweep(a, &mut self.factors[..m], T::from_f64(1e3));
                if !moved.is_finite() {
                    break;
                }
                // A close pair settles slowly: two quiet sweeps in a row.
                quiet = if moved < tolerance::<T>() {
                    quiet + 1
                } else {
                    0
                };
                if quiet == 2 {
                    self.unsettled = 0;
                    return Some(n + 1);
                }
            }
            if attempt == 0 && aberth::solve(a, &mut self.factors) {
                self.unsettled = 0;
                return Some(sweeps);
            }
        }
        None
    }
}

/// Cold start: a sweep that moves nothing by more than this leaves an error of
/// rounding size, because the error is squared by each sweep.
fn tolerance<T: Real>() -> T {
    T::EPSILON.sqrt() * T::from_f64(4.0)
}

/// m factors with roots on a circle, turned a little with each attempt.
fn circle<T: Real, const P: usize>(m: usize, attempt: u32) -> [Quadratic<T>; P] {
    let turn = T::from_f64(0.5) + T::from_f64(0.07) * T::from_u32(attempt % 5);
    let radius = T::from_f64(0.95) - T::from_f64(0.08) * T::from_u32(attempt % 7);
    core::array::from_fn(|k| {
        let angle = T::PI * (T::from_u32(k as u32) + turn) / T::from_u32(m.max(1) as u32);
        let (_, cos) = angle.sin_cos();
        Quadratic {
            u: T::from_f64(2.0) * radius * cos,
            v: radius * radius,
        }
    })
}

/// One sweep over all factors; returns how far they are off: the sum of the
/// corrections, and of what the sum of the roots still lacks of −a₁. Without that a
/// factor far away, which takes the others' corrections down with its size, would
/// look settled. Not finite if a correction was not; it has been left out then.
#[inline(always)]
fn sweep<T: Real>(a: &[T], q: &mut [Quadratic<T>], largest_step: T) -> T {
    let m = q.len();
    let odd = a.len() % 2 == 1;
    let mut moved = T::ZERO;
    for k in 0..m {
        let this = q[k];
        // Synthetic division: A = Q·q_k + b₁·(z − u) + b₀, so that
        // A mod q_k = b₁·z + (b₀ − u·b₁).
        let (body, tail) = if odd {
            (a, T::ZERO)
        } else {
            (&a[..a.len() - 1], a[a.len() - 1])
        };
        let (mut b2, mut b1) = (T::ONE, body[0] + this.u);
        for &x in &body[1..] {
            let b = x + this.u * b1 - this.v * b2;
            b2 = b1;
            b1 = b;
        }
        let remainder = Residue {
            alpha: tail - this.v * b2,
            beta: b1,
        };
        let mut product: Option<Residue<T>> = None;
        for (j, other) in q.iter().enumerate() {
            if j != k {
                let difference = Residue {
                    alpha: other.v - this.v,
                    beta: this.u - other.u,
                };
                product = Some(match product {
                    Some(product) => this.multiply(product, difference),
                    None => difference,
                });
            }
        }
        let product = product.unwrap_or(Residue {
            alpha: T::ONE,
            beta: T::ZERO,
        });
        // The inverse modulo q_k is the conjugate over the norm.
        let conjugate = product.alpha + product.beta * this.u;
        let norm = product.alpha * conjugate + product.beta * product.beta * this.v;
        // Zero where two factors share a root: neither can move by its own step, so
        // this one moves aside and is not settled.
        if norm.abs() <= T::from_f64(1e-30) {
            q[k].u += T::from_f64(ASIDE);
            moved += T::ONE;
            continue;
        }
        let inverse = T::ONE / norm;
        let step = this.multiply(
            remainder,
            Residue {
                alpha: conjugate * inverse,
                beta: -product.beta * inverse,
            },
        );
        let (mut du, mut dv) = (-step.beta, step.alpha);
        let size = du.abs() + dv.abs();
        // Also for NaN.
        if !(size <= largest_step) {
            if !size.is_finite() {
                // The factor stays as it was; the caller starts a search.
                return size;
            }
            du = du.clamp(-largest_step, largest_step);
            dv = dv.clamp(-largest_step, largest_step);
        }
        q[k] = Quadratic {
            u: this.u + du,
            v: this.v + dv,
        };
        moved += size;
    }
    let sum = q.iter().fold(T::ZERO, |sum, q| sum + q.u);
    match a.first() {
        Some(&a_1) => moved + (sum + a_1).abs(),
        None => moved,
    }
}

/// Takes over found factors in the order that moves the old ones least, so that
/// a mode keeps its place.
fn adopt<T: Real>(old: &mut [Quadratic<T>], found: &[Quadratic<T>]) {
    let distance = |x: &Quadratic<T>, y: &Quadratic<T>| (x.u - y.u).abs() + (x.v - y.v).abs();
    let mut taken = 0u32;
    for slot in old.iter_mut() {
        let mut best: Option<(usize, T, Quadratic<T>)> = None;
        for (i, candidate) in found.iter().enumerate() {
            let d = distance(slot, candidate);
            if taken & (1 << i) == 0 && best.is_none_or(|(_, b, _)| d < b) {
                best = Some((i, d, *candidate));
            }
        }
        if let Some((i, _, nearest)) = best {
            taken |= 1 << i;
            *slot = nearest;
        }
    }
}

/// Where several factors hold real roots, puts the closest two into one factor:
/// two roots that are about to become a pair must share a factor.
fn pair_neighbours<T: Real>(q: &mut [Quadratic<T>]) {
    let mut first = None;
    for k in 0..q.len() {
        let Roots::Real(a, b) = q[k].roots() else {
            continue;
        };
        let Some((i, c, d)) = first else {
            first = Some((k, a, b));
            continue;
        };
        // Sort the four and join the inner two, the outer two.
        let (lowest, highest) = (a.min(c), b.max(d));
        let (inner_low, inner_high) = (a.max(c), b.min(d));
        if let Some(inner) = q.get_mut(i) {
            *inner = Quadratic {
                u: inner_low + inner_high,
                v: inner_low * inner_high,
            };
        }
        q[k] = Quadratic {
            u: lowest + highest,
            v: lowest * highest,
        };
        first = None;
    }
}

#[cfg(test)]
#[path = "factors_tests.rs"]
mod tests;
