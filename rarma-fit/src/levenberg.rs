//! Least squares of a nonlinear model: Levenberg–Marquardt on a triangular factor.

use super::triangle::Triangle;
use rarma_core::real::Real;

/// A sum of squares of residuals r(θ) to be made small.
pub(super) trait Problem<T, const N: usize> {
    /// Number of parameters in use.
    fn n(&self) -> usize;
    /// θ is in the region where the model exists.
    fn admissible(&self, theta: &[T; N]) -> bool;
    /// Σr² at an admissible θ.
    fn cost(&self, theta: &[T; N]) -> T;
    /// Equations J·δ = −r at θ.
    fn linearise(&self, theta: &[T; N]) -> Triangle<T, N>;
}

/// Where a search ended.
#[derive(Debug, Clone, Copy)]
pub(super) struct Minimum<T, const N: usize> {
    pub theta: [T; N],
    pub cost: T,
    pub iterations: u32,
    pub converged: bool,
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits<T> {
    /// Distance to the minimum in standard deviations of the parameters.
    pub tolerance: T,
    pub iterations: u32,
    /// Residuals that count, for the variance.
    pub residuals: T,
}

/// Weakest and strongest Marquardt damping, relative to the column lengths.
const WEAKEST: f64 = 1e-6;
const STRONGEST: f64 = 1e3;
/// How often a step that leaves the region is halved.
const HALVINGS: u32 = 5;

/// Goes down from `start`, which must be admissible.
///
/// The step solves (JᵀJ + μ²·D²)·δ = −Jᵀr with D the column lengths of J. It is
/// halved while it leaves the admissible region, and taken only if the cost falls.
/// Converged means: the Gauss–Newton step promises to lower the cost by less than
/// tolerance²·σ², i.e. θ lies within `tolerance` standard deviations of the minimum.
pub(super) fn minimise<T: Real, const N: usize>(
    problem: &impl Problem<T, N>,
    start: [T; N],
    limits: Limits<T>,
) -> Minimum<T, N> {
    let n = problem.n();
    let ten = T::from_f64(10.0);
    let mut best = Minimum {
        theta: start,
        cost: problem.cost(&start),
        iterations: 0,
        converged: false,
    };
    let mut damping = T::from_f64(1e-2);
    while best.iterations < limits.iterations && best.cost.is_finite() {
        best.iterations += 1;
        let triangle = problem.linearise(&best.theta);
        let promised = triangle.explained();
        let sigma2 = best.cost / limits.residuals;
        let rounding = best.cost * T::EPSILON;
        if promised <= (limits.tolerance * limits.tolerance * sigma2).max(rounding) {
            best.converged = true;
            break;
        }
        let mut moved = false;
        while damping <= T::from_f64(STRONGEST) {
            if let Some((theta, cost)) = attempt(problem, &best, &triangle, damping, n) {
                (best.theta, best.cost) = (theta, cost);
                damping = (damping / ten).max(T::from_f64(WEAKEST));
                moved = true;
                break;
            }
            damping *= T::from_f64(4.0);
        }
        if !moved {
            // Nothing lower in any direction: a minimum to within rounding, or the
            // edge of the region.
            break;
        }
    }
    best
}

/// One damped step, if it leads to something lower.
fn attempt<T: Real, const N: usize>(
    problem: &impl Problem<T, N>,
    from: &Minimum<T, N>,
    triangle: &Triangle<T, N>,
    damping: T,
    n: usize,
) -> Option<([T; N], T)> {
    let mut step = triangle.damped(damping).solve()?;
    for _ in 0..HALVINGS {
        let mut theta = from.theta;
        for (t, s) in theta[..n].iter_mut().zip(&step) {
            *t += *s;
        }
        if problem.admissible(&theta) {
            let cost = problem.cost(&theta);
            return (cost < from.cost).then_some((theta, cost));
        }
        for s in &mut step[..n] {
            *s *= T::from_f64(0.5);
        }
    }
    None
}
