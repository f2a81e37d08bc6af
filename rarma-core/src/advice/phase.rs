//! What the phase of the waves says: on which side of its mode chatter lies, and how far.
//!
//! One mode of frequency f_m and damping ζ, waves w = f/(n·N), θ = 2π·w, and a cut that pulls
//! with the load h = K·b/(2k_m). Near its frequency the mode is a pole of first order, and what
//! regeneration makes of it is, with s = σ + jω the root while it cuts:
//!
//! ```text
//! s/ω_m = j − ζ + j·h·(1 − e^(−s·τ))         τ = 1/(n·N), ω·τ = θ, g = e^(−σ·τ)
//! f/f_m − 1 = h·(1 − g·cos θ)                the imaginary part
//! σ/ω_m     = −ζ − h·g·sin θ                 the real part
//! ```
//!
//! At the limit g = 1, and the two give f/f_m − 1 = −ζ·tan(θ/2): the well-known
//! ε = 3π + 2ψ, ψ the phase of the receptance. Chatter lies above its mode for a fraction of
//! waves between ½ and 1, below it (h < 0: the cut pulls the other way round, as it does for
//! half of all directions in milling) between 0 and ½. Beyond the limit it lies further off,
//! about in the ratio of the depths. So f, w and the mode give the depth.

use super::lobes::Side;
use crate::real::Real;

/// Steps of a bisection: to a part in 10⁷ of its range.
const HALVINGS: u32 = 24;
/// Growth a wave, σ/ω, that is looked for at most: e times in a third of a wave.
const MOST_GROWTH: f64 = 0.5;

/// Where in its wave the next tooth meets chatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase<T> {
    /// Waves between two teeth.
    pub waves: T,
    /// Above its mode or below.
    pub side: Side,
    sin: T,
    cos: T,
}

/// The phase at so many waves between two teeth, > 0.
pub(crate) fn phase_of<T: Real>(waves: T) -> Phase<T> {
    let off = waves - waves.round();
    let (sin, cos) = (off * T::from_f64(core::f64::consts::TAU)).sin_cos();
    Phase {
        waves,
        side: if sin < T::ZERO {
            Side::Above
        } else {
            Side::Below
        },
        sin,
        cos,
    }
}

/// Where a falling function passes 0 in 0..=`most`.
fn root<T: Real>(most: T, f: impl Fn(T) -> T) -> T {
    let (mut low, mut high) = (T::ZERO, most);
    if !(f(low) > T::ZERO) {
        return low;
    }
    let half = T::from_f64(0.5);
    for _ in 0..HALVINGS {
        let middle = (low + high) * half;
        if f(middle) > T::ZERO {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

impl<T: Real> Phase<T> {
    /// e^(−σ·τ) at a growth σ/ω_m.
    fn kept(&self, growth: T) -> T {
        (-(growth * self.waves * T::from_f64(core::f64::consts::TAU))).exp()
    }

    /// The load at the limit, ζ/|sin θ|; huge on a flip or a whole number of waves.
    pub fn limit_load(&self, zeta: T) -> T {
        zeta / self.sin.abs().max(T::from_f64(1e-6))
    }
}

/// The load of a cut that chatters at `ratio` = f/f_m of its mode: the pair of equations of
/// this module solved for h and σ. `None` where the frequency lies on the side of the mode on
/// which its phase says it does not.
///
/// Where the frequency lies nearer to the mode than at the limit (a chatter whose teeth leave
/// the cut has lost some of its load) the load of the limit is given.
pub(crate) fn load_of<T: Real>(phase: &Phase<T>, ratio: T, zeta: T) -> Option<T> {
    let off = (ratio - T::ONE) * phase.side.sign();
    if !(off > T::ZERO) {
        return None;
    }
    let sin = phase.sin * phase.side.sign();
    let load = |growth| off / (T::ONE - phase.kept(growth) * phase.cos);
    let excess = |growth| -zeta - load(growth) * phase.kept(growth) * sin - growth;
    let growth = root(T::from_f64(MOST_GROWTH), excess);
    if growth > T::ZERO {
        Some(load(growth))
    } else {
        Some(phase.limit_load(zeta))
    }
}

/// Growth of a cut of this load, σ/ω_m, ≥ 0.
pub(super) fn growth_of<T: Real>(phase: &Phase<T>, load: T, zeta: T) -> T {
    let sin = phase.sin * phase.side.sign();
    root(T::ONE, |growth| {
        -zeta - load * phase.kept(growth) * sin - growth
    })
}

/// Frequency over that of the mode, f/f_m, at which a cut of this load chatters.
pub(crate) fn ratio_of<T: Real>(phase: &Phase<T>, load: T, zeta: T) -> T {
    let growth = growth_of(phase, load, zeta);
    T::ONE + load * phase.side.sign() * (T::ONE - phase.kept(growth) * phase.cos)
}
