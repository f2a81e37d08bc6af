//! Vibration modes of a structure, advanced exactly from step to step.
//!
//! Responsibility: the linear structure, nothing of the cut. One [`Mode`] is
//! the mass-spring-damper m·q̈ + c·q̇ + k·q = F seen at the tool tip in one
//! direction; a [`ModeBank`] adds the modes of that direction.
//!
//! Rate: [`ModeBank::step`] runs once per integration step, without allocation.
//!
//! Glossary: *f* undamped natural frequency, *ζ* damping ratio, *FOH*
//! first-order hold (the force is a straight line within a step).

mod step_table;

use super::error::{PlantError, positive, require};
use super::linalg::Square;
use core::f64::consts::TAU;
pub(super) use step_table::StepTable;

/// One mode of vibration at the point and in the direction where the force acts.
///
/// m·q̈ + 2ζω·m·q̇ + k·q = F, ω = 2π·f, k = m·ω². Displacement, velocity and
/// force share one positive direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Undamped natural frequency, Hz, > 0.
    pub f_hz: f64,
    /// Damping ratio, 1, between -1 and 1. Negative makes a mode that grows.
    pub zeta: f64,
    /// Modal stiffness, N/m, > 0.
    pub stiffness_n_per_m: f64,
}

impl Mode {
    /// Mode from its stiffness in N/m.
    #[must_use]
    pub const fn from_stiffness(f_hz: f64, zeta: f64, stiffness_n_per_m: f64) -> Self {
        Self {
            f_hz,
            zeta,
            stiffness_n_per_m,
        }
    }

    /// Mode from its modal mass in kg: k = m·(2πf)².
    #[must_use]
    pub fn from_mass(f_hz: f64, zeta: f64, mass_kg: f64) -> Self {
        let w = TAU * f_hz;
        Self {
            f_hz,
            zeta,
            stiffness_n_per_m: mass_kg * w * w,
        }
    }

    /// Undamped angular frequency ω, rad/s.
    #[must_use]
    pub fn omega(&self) -> f64 {
        TAU * self.f_hz
    }

    /// Modal mass, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.stiffness_n_per_m / (self.omega() * self.omega())
    }

    /// Receptance q/F at angular frequency `w` rad/s as (real, imaginary), m/N,
    /// for the time factor e^(+jwt): the imaginary part is negative for ζ > 0.
    #[must_use]
    pub fn receptance(&self, w: f64) -> (f64, f64) {
        let r = w / self.omega();
        let re = 1.0 - r * r;
        let im = 2.0 * self.zeta * r;
        let den = self.stiffness_n_per_m * (re * re + im * im);
        (re / den, -im / den)
    }

    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        positive(self.f_hz, "f_hz")?;
        require(self.zeta.is_finite() && self.zeta.abs() < 1.0, "zeta")?;
        positive(self.stiffness_n_per_m, "stiffness_n_per_m")
    }
}

/// A mode with its shape at the tool tip: how far its coordinate moves the tip in x
/// and y and turns the cutter. A bending mode along x is (1, 0, 0).
///
/// Generalised force = x·Fx + y·Fy + turn·Mz, Mz in the sense of rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapedMode {
    /// Frequency, damping and modal stiffness of the coordinate.
    pub mode: Mode,
    /// Displacement in x per displacement of the coordinate, 1.
    pub x: f64,
    /// Displacement in y, 1.
    pub y: f64,
    /// Rotation of the cutter in the sense of the spindle, rad/m.
    pub turn_rad_per_m: f64,
    /// How far it moves the place of the sensor over how far it moves the tool, 1.
    pub at_sensor: f64,
}

impl ShapedMode {
    /// A mode that moves the tip along x only.
    #[must_use]
    pub const fn along_x(mode: Mode) -> Self {
        Self {
            mode,
            x: 1.0,
            y: 0.0,
            turn_rad_per_m: 0.0,
            at_sensor: 1.0,
        }
    }

    /// A mode that moves the tip along y only.
    #[must_use]
    pub const fn along_y(mode: Mode) -> Self {
        Self {
            mode,
            x: 0.0,
            y: 1.0,
            turn_rad_per_m: 0.0,
            at_sensor: 1.0,
        }
    }

    /// Checks the documented ranges.
    ///
    /// # Errors
    /// As [`Mode::validate`]; `OutOfRange` for a shape that is not finite.
    pub fn validate(&self) -> Result<(), PlantError> {
        self.mode.validate()?;
        let finite = self.x.is_finite()
            && self.y.is_finite()
            && self.turn_rad_per_m.is_finite()
            && self.at_sensor.is_finite();
        require(finite, "shape")
    }
}

/// Exact step of one mode for a force that is linear within the step.
///
/// (q, v)ₖ₊₁ = Φ·(q, v)ₖ + γ₀·Fₖ + γ₁·Fₖ₊₁ with Φ = e^(A·dt). All three come
/// from one exponential of the 4×4 matrix that carries the force and its slope
/// as extra states, in the scaled state (ω·q, v), so that no difference of
/// nearly equal numbers appears at small ω·dt.
///
/// Exact for the linear structure: a free mode decays as e^(-ζωt) to rounding,
/// whatever the step. What a simulator adds on top (the cutting force between
/// the steps) is not exact; see the milling module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FohStep {
    phi: [[f64; 2]; 2],
    gamma0: [f64; 2],
    gamma1: [f64; 2],
}

impl FohStep {
    /// Coefficients for one mode and a step of `dt` seconds.
    #[must_use]
    pub fn new(mode: &Mode, dt: f64) -> Self {
        let w = mode.omega();
        let mut m = Square::zeros(4);
        m.set(0, 1, w * dt);
        m.set(1, 0, -w * dt);
        m.set(1, 1, -2.0 * mode.zeta * w * dt);
        m.set(1, 2, dt / mode.mass_kg());
        m.set(2, 3, 1.0);
        let e = m.exp();
        Self {
            phi: [[e.at(0, 0), e.at(0, 1) / w], [e.at(1, 0) * w, e.at(1, 1)]],
            gamma0: [(e.at(0, 2) - e.at(0, 3)) / w, e.at(1, 2) - e.at(1, 3)],
            gamma1: [e.at(0, 3) / w, e.at(1, 3)],
        }
    }

    /// The straight line from this step to another, at `part` of the way.
    pub(super) fn between(&self, other: &Self, part: f64) -> Self {
        let mix =
            |a: [f64; 2], b: [f64; 2]| [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])];
        Self {
            phi: [
                mix(self.phi[0], other.phi[0]),
                mix(self.phi[1], other.phi[1]),
            ],
            gamma0: mix(self.gamma0, other.gamma0),
            gamma1: mix(self.gamma1, other.gamma1),
        }
    }

    /// State (q m, v m/s) after one step under a force from `f0` to `f1` N.
    #[inline]
    #[must_use]
    pub fn advance(&self, s: [f64; 2], f0: f64, f1: f64) -> [f64; 2] {
        let row = |i: usize| {
            self.phi[i][0] * s[0]
                + self.phi[i][1] * s[1]
                + self.gamma0[i] * f0
                + self.gamma1[i] * f1
        };
        [row(0), row(1)]
    }
}

/// All modes of one direction, summed at the tool tip.
///
/// ```
/// use rarma_plants::modal::{Mode, ModeBank};
/// let mode = Mode::from_stiffness(1000.0, 0.02, 1.0e7);
/// let mut bank = ModeBank::new(&[mode], 1.0e-5)?;
/// for _ in 0..200_000 {
///     bank.step(100.0, 100.0);
/// }
/// assert!((bank.displacement_m() - 100.0 / 1.0e7).abs() < 1e-12);
/// # Ok::<(), rarma_plants::error::PlantError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ModeBank {
    modes: Vec<Mode>,
    steps: Vec<FohStep>,
    state: Vec<[f64; 2]>,
}

impl ModeBank {
    /// Bank at rest. An empty list is a rigid direction.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn new(modes: &[Mode], dt: f64) -> Result<Self, PlantError> {
        positive(dt, "dt")?;
        for mode in modes {
            mode.validate()?;
        }
        Ok(Self {
            modes: modes.to_vec(),
            steps: modes.iter().map(|m| FohStep::new(m, dt)).collect(),
            state: vec![[0.0; 2]; modes.len()],
        })
    }

    /// From now on steps of `dt` s, out of tables of each mode.
    pub(super) fn retime(&mut self, tables: &[StepTable], dt: f64) {
        for (step, table) in self.steps.iter_mut().zip(tables) {
            *step = table.at(dt);
        }
    }

    /// Displacement at the tip, m.
    #[must_use]
    pub fn displacement_m(&self) -> f64 {
        self.state.iter().map(|s| s[0]).sum()
    }

    /// Velocity at the tip, m/s.
    #[must_use]
    pub fn velocity_m_s(&self) -> f64 {
        self.state.iter().map(|s| s[1]).sum()
    }

    /// Acceleration at the tip under the force that acts now, m/s².
    #[must_use]
    pub fn acceleration_m_s2(&self, force_n: f64) -> f64 {
        self.modes
            .iter()
            .zip(&self.state)
            .map(|(m, s)| {
                let w = m.omega();
                force_n / m.mass_kg() - 2.0 * m.zeta * w * s[1] - w * w * s[0]
            })
            .sum()
    }

    /// Displacement and velocity after a step from `f0` to `f1`, not taken.
    #[inline]
    #[must_use]
    pub fn peek(&self, f0: f64, f1: f64) -> (f64, f64) {
        let mut q = 0.0;
        let mut v = 0.0;
        for (step, s) in self.steps.iter().zip(&self.state) {
            let next = step.advance(*s, f0, f1);
            q += next[0];
            v += next[1];
        }
        (q, v)
    }

    /// Takes the step and returns displacement and velocity after it.
    #[inline]
    pub fn step(&mut self, f0: f64, f1: f64) -> (f64, f64) {
        let mut q = 0.0;
        let mut v = 0.0;
        for (step, s) in self.steps.iter().zip(&mut self.state) {
            *s = step.advance(*s, f0, f1);
            q += s[0];
            v += s[1];
        }
        (q, v)
    }

    /// Sets mode `index` to displacement `q` m and velocity `v` m/s; an index
    /// beyond the last mode is ignored, so that a rigid direction stays rigid.
    pub fn set_state(&mut self, index: usize, q: f64, v: f64) {
        if let Some(s) = self.state.get_mut(index) {
            *s = [q, v];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_decay_is_exact_at_any_step() {
        let mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);
        let (w, z) = (mode.omega(), mode.zeta);
        let wd = w * (1.0 - z * z).sqrt();
        for dt in [1e-6, 2.3e-5, 4e-4] {
            let mut bank = ModeBank::new(&[mode], dt).expect("valid");
            bank.set_state(0, 1e-5, 0.0);
            for _ in 0..100 {
                bank.step(0.0, 0.0);
            }
            let t = 100.0 * dt;
            let want = 1e-5 * (-z * w * t).exp() * ((wd * t).cos() + z * w / wd * (wd * t).sin());
            assert!((bank.displacement_m() - want).abs() < 1e-17 + 1e-12 * want.abs());
        }
    }

    #[test]
    fn ramp_force_matches_closed_form() {
        // q_p(t) = (s/k)·(t - 2ζ/ω) follows F = s·t; start on it.
        let mode = Mode::from_mass(500.0, 0.05, 0.3);
        let (w, k, slope, dt) = (mode.omega(), mode.stiffness_n_per_m, 1.0e4, 7e-5);
        let mut bank = ModeBank::new(&[mode], dt).expect("valid");
        bank.set_state(0, -slope / k * 2.0 * mode.zeta / w, slope / k);
        for n in 0..1000 {
            let t = f64::from(n) * dt;
            bank.step(slope * t, slope * (t + dt));
        }
        let want = slope / k * (1000.0 * dt - 2.0 * mode.zeta / w);
        assert!((bank.displacement_m() / want - 1.0).abs() < 1e-10);
        assert!(bank.acceleration_m_s2(slope * 1000.0 * dt).abs() < 1e-6);
    }

    #[test]
    fn receptance_at_resonance_and_at_rest() {
        let mode = Mode::from_stiffness(980.0, 0.02, 11.8e6);
        let (re, im) = mode.receptance(mode.omega());
        assert!(re.abs() < 1e-20);
        assert!((im * 2.0 * 0.02 * 11.8e6 + 1.0).abs() < 1e-12);
        assert!((mode.receptance(0.0).0 * 11.8e6 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn bad_parameters_are_named() {
        let bad = Mode::from_stiffness(980.0, 1.0, 1.0e6);
        assert_eq!(bad.validate(), Err(PlantError::OutOfRange { name: "zeta" }));
        let nan = Mode::from_stiffness(f64::NAN, 0.1, 1.0e6);
        assert_eq!(nan.validate(), Err(PlantError::OutOfRange { name: "f_hz" }));
    }
}
