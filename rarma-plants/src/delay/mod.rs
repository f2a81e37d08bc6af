//! The delay equation of a cut, taken apart by semi-discretisation: stability,
//! limits, and the damping and frequency a machine has *while it cuts*.
//!
//! Slow path: for truth tables and charts, never per step. Independent of the
//! time simulation (another discretisation, no surface memory, no noise), so
//! each checks the other.
//!
//! M q̈ + C q̇ + K q = F, F(t) = -Σⱼ Kⱼ(t)·\[r(t) - r(t-τⱼ)\] - R(t)·ṙ(t), with
//! periodic Kⱼ and R. Over each small step the coefficients are replaced by their
//! exact means and the delayed response by a straight line (first order); the
//! rest is solved exactly. The product of the steps of one period is the
//! monodromy map; its eigenvalues μ are the Floquet multipliers. The error falls
//! with the square of the step.
//!
//! Glossary: *root* exponent s with μ = e^(s·T); *Hopf* a complex pair crosses
//! |μ| = 1 (chatter at a new frequency); *flip* μ = -1 (every second tooth);
//! *fold* μ = +1.
//!
//! Source: T. Insperger, G. Stépán, Semi-Discretization for Time-Delay Systems,
//! Springer 2011 (method); the matrix-free Arnoldi iteration is textbook.

mod krylov;
mod limit;
mod milling;
mod roots;
mod step;
mod turning;
mod varied;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod varied_tests;

pub use limit::{Border, DepthSearch, limit, limit_by};
pub use milling::milling_delay;
pub use roots::{Crossing, Root};
pub use turning::{turning_delay, turning_roots};
pub use varied::MOST_VARIED_STEPS;

use super::error::{PlantError, require};
use super::modal::Mode;
use step::StepMap;
use varied::Swinging;

/// Steps of a period at most.
pub const MOST_STEPS: usize = 100_000;
/// Steps times the square of the state of the modes at most: 160 MB.
pub const MOST_NUMBERS: usize = 20_000_000;

/// `Ok` where the maps of so many steps of so many modes may be held.
pub(crate) fn too_many(steps: usize, modes: usize, name: &'static str) -> Result<(), PlantError> {
    let most = MOST_STEPS.min(MOST_NUMBERS / (4 * modes * modes).max(1));
    if steps > most {
        return Err(PlantError::TooLarge { name, most });
    }
    Ok(())
}

/// Directions a force acts in: x, y, and the moment about the tool's axis.
pub(crate) const CHANNELS: usize = 3;
/// Directions of the response that make chips: x and y.
pub(crate) const RESPONSES: usize = 2;

/// A matrix from responses to forces.
pub(crate) type Coupling = [[f64; RESPONSES]; CHANNELS];

/// One mode as the cut sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seen {
    pub mode: Mode,
    /// Generalised force = Σ input·F.
    pub input: [f64; CHANNELS],
    /// What the mode adds to the chip per metre of its coordinate.
    pub chip: [f64; RESPONSES],
    /// What it adds to the motion of the edge.
    pub motion: [f64; RESPONSES],
}

/// The cut over one step: regeneration per delay (in steps, and N/m), and rubbing
/// (N·s/m).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct StepLaw {
    pub regeneration: Vec<(usize, Coupling)>,
    pub rubbing: Coupling,
}

/// A cut as a linear, periodic delay equation, discretised.
///
/// Built by [`milling_delay`] and [`turning_delay`].
#[derive(Clone, Debug)]
pub struct DelaySystem {
    seen: Vec<Seen>,
    period_s: f64,
    maps: Vec<StepMap>,
    /// Longest delay, steps.
    history: usize,
    /// Displacements are carried times this, so that they weigh like velocities.
    scale: f64,
    /// The steps, instead of `maps`, where the spindle speed swings.
    swinging: Option<Swinging>,
}

impl DelaySystem {
    /// From the modes, one period and the laws of its steps.
    pub(crate) fn new(
        seen: Vec<Seen>,
        period_s: f64,
        laws: &[StepLaw],
    ) -> Result<Self, PlantError> {
        require(!seen.is_empty(), "modes")?;
        for s in &seen {
            s.mode.validate()?;
        }
        too_many(laws.len(), seen.len(), "spindle_hz")?;
        let dt = period_s / laws.len() as f64;
        let scale = seen.iter().map(|s| s.mode.omega()).fold(0.0, f64::max);
        let history = laws
            .iter()
            .flat_map(|l| l.regeneration.iter().map(|r| r.0))
            .max()
            .unwrap_or(1);
        let mut maps: Vec<StepMap> = Vec::with_capacity(laws.len());
        for (k, law) in laws.iter().enumerate() {
            // In air, and in turning, one step is as the one before.
            let map = match maps.last() {
                Some(last) if laws[k - 1] == *law => last.clone(),
                _ => StepMap::new(&seen, law, dt, scale)?,
            };
            maps.push(map);
        }
        Ok(Self {
            maps,
            seen,
            period_s,
            history,
            scale,
            swinging: None,
        })
    }

    /// Length of the period over which the multipliers are taken, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Steps in one period.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.swinging
            .as_ref()
            .map_or(self.maps.len(), Swinging::steps)
    }

    /// Length of the state that the monodromy map acts on.
    fn dimension(&self) -> usize {
        2 * self.seen.len() + RESPONSES * self.history
    }

    /// Response that makes chips, scaled, of the modal state (ω·q, v)ᵢ.
    fn response(&self, state: &[f64]) -> [f64; RESPONSES] {
        let mut out = [0.0; RESPONSES];
        for (s, pair) in self.seen.iter().zip(state.chunks_exact(2)) {
            for (o, c) in out.iter_mut().zip(s.chip) {
                *o += self.scale / s.mode.omega() * c * pair[0];
            }
        }
        out
    }

    /// One period: state and history in, state and history out; every response
    /// on the way goes to `watch`.
    fn advance(&self, from: &[f64], mut watch: impl FnMut(usize, [f64; RESPONSES])) -> Vec<f64> {
        let (n, back) = (2 * self.seen.len(), self.history);
        let mut state = from[..n].to_vec();
        let mut next = vec![0.0; n];
        let steps = self.steps();
        let mut past: Vec<[f64; RESPONSES]> = Vec::with_capacity(back + steps + 1);
        past.extend(from[n..].chunks_exact(RESPONSES).map(|c| [c[0], c[1]]));
        past.push(self.response(&state));
        for k in 0..steps {
            watch(k, past[back + k]);
            match &self.swinging {
                None => self.maps[k].apply(&state, &past, back + k, &mut next),
                Some(swinging) => {
                    let (a, b, part) = swinging.around(k);
                    a.apply_between(b, part, &state, &past, back + k, &mut next);
                }
            }
            core::mem::swap(&mut state, &mut next);
            past.push(self.response(&state));
        }
        let kept = &past[steps..steps + back];
        state.extend(kept.iter().flatten());
        state
    }

    /// Largest modulus of the Floquet multipliers: below 1 the cut is stable. Infinite
    /// where a period takes the motion out of the range of numbers; NaN where it cannot
    /// be told, see [`Self::multiplier`].
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius_and_work().0
    }

    /// [`Self::radius`], and the multiplications it took, about.
    fn radius_and_work(&self) -> (f64, f64) {
        let ((re, im), work) = self.largest();
        (re.hypot(im), work)
    }

    /// The Floquet multiplier of largest modulus, (real, imaginary ≥ 0); infinite as
    /// [`Self::radius`], NaN where the eigenvalues do not settle.
    #[must_use]
    pub fn multiplier(&self) -> (f64, f64) {
        self.largest().0
    }

    fn largest(&self) -> ((f64, f64), f64) {
        let found = krylov::dominant(self.dimension(), 1, |x| self.advance(x, |_, _| {}));
        let step = 2 * self.seen.len() * (2 * self.seen.len() + 2 * CHANNELS);
        let work = found.work + (found.maps * self.steps() * step) as f64;
        let value = match found.values.first() {
            _ if found.overflows => (f64::INFINITY, 0.0),
            Some(z) => (z.re, z.im.abs()),
            None if found.at_rest => (0.0, 0.0),
            None => (f64::NAN, 0.0),
        };
        (value, work)
    }

    /// The `wanted` dominant roots, the least damped first, one of each pair.
    ///
    /// The frequency of a root is known from μ only up to multiples of 1/T; the
    /// one given is that of the strongest component of its motion.
    #[must_use]
    pub fn roots(&self, wanted: usize) -> Vec<Root> {
        roots::of(self, wanted)
    }
}
