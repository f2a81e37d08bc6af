//! What milling and turning share: depth over time, loss of contact, process
//! damping, and the noise of the cutting force.

use super::error::{PlantError, non_negative, positive, require};
use core::f64::consts::TAU;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// What happens when the chip thickness would become negative.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Contact {
    /// The tooth leaves the material: no force, and the surface stays as the
    /// last tooth that did cut left it, however many passes ago. This is what
    /// limits the amplitude of chatter.
    #[default]
    Real,
    /// The force follows a negative chip thickness and every pass writes the
    /// surface: the linear delay equation behind the stability limit. For
    /// stability studies only; no edge force acts.
    Linear,
    /// The forces of a rigid tool: the machine is driven by them, but its motion changes
    /// no chip. This is forced vibration by its definition, and it cannot grow by itself;
    /// what a cut does beyond it is fed back.
    Rigid,
}

/// A quantity over time, piecewise linear and not negative: axial depth (milling),
/// chip width (turning), m; or spindle frequency, Hz.
///
/// Constant before the first and after the last point. Depth 0 is air: the
/// teeth pass without force.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    points: Vec<(f64, f64)>,
}

impl Schedule {
    /// The same value at all times.
    #[must_use]
    pub fn constant(depth_m: f64) -> Self {
        Self {
            points: vec![(0.0, depth_m)],
        }
    }

    /// Straight lines through (time s, depth m).
    ///
    /// # Errors
    /// `WrongLength` without points; `OutOfRange` if times do not increase or a
    /// depth is negative or not finite.
    pub fn new(points: &[(f64, f64)]) -> Result<Self, PlantError> {
        let out = Self {
            points: points.to_vec(),
        };
        out.validate()?;
        Ok(out)
    }

    /// Checks what [`Schedule::new`] checks.
    ///
    /// # Errors
    /// As there.
    pub fn validate(&self) -> Result<(), PlantError> {
        if self.points.is_empty() {
            return Err(PlantError::WrongLength { name: "depth" });
        }
        for (t, b) in &self.points {
            require(t.is_finite(), "depth")?;
            non_negative(*b, "depth")?;
        }
        require(self.points.windows(2).all(|w| w[0].0 < w[1].0), "depth")
    }

    /// Depth at time `t` s, m.
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let after = self.points.partition_point(|p| p.0 <= t);
        match (
            after.checked_sub(1).map(|i| self.points[i]),
            self.points.get(after),
        ) {
            (Some((t0, b0)), Some(&(t1, b1))) => b0 + (b1 - b0) * (t - t0) / (t1 - t0),
            (Some((_, b)), None) | (None, Some(&(_, b))) => b,
            (None, None) => 0.0,
        }
    }

    /// First time at which the depth rises through `depth_m`, s.
    #[must_use]
    pub fn rises_through(&self, depth_m: f64) -> Option<f64> {
        self.points.windows(2).find_map(|w| {
            let ((t0, b0), (t1, b1)) = (w[0], w[1]);
            (b0 < depth_m && b1 >= depth_m).then(|| t0 + (t1 - t0) * (depth_m - b0) / (b1 - b0))
        })
    }

    /// Last time at which the depth falls through `depth_m`, s.
    #[must_use]
    pub fn falls_through(&self, depth_m: f64) -> Option<f64> {
        self.points.windows(2).rev().find_map(|w| {
            let ((t0, b0), (t1, b1)) = (w[0], w[1]);
            (b0 >= depth_m && b1 < depth_m).then(|| t0 + (t1 - t0) * (b0 - depth_m) / (b0 - b1))
        })
    }

    /// Times between which there is any depth, s; `None` if there never is.
    /// Before the first and after the last point the depth stays as it is
    /// there, and the point's time is given.
    #[must_use]
    pub fn in_cut_s(&self) -> Option<(f64, f64)> {
        let first = self.points.iter().position(|p| p.1 > 0.0)?;
        let last = self.points.iter().rposition(|p| p.1 > 0.0)?;
        let end = (last + 1).min(self.points.len() - 1);
        Some((self.points[first.saturating_sub(1)].0, self.points[end].0))
    }

    /// Largest value.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.points.iter().map(|p| p.1).fold(0.0, f64::max)
    }

    /// Smallest value.
    #[must_use]
    pub fn smallest(&self) -> f64 {
        self.points
            .iter()
            .map(|p| p.1)
            .fold(f64::INFINITY, f64::min)
    }

    /// The points (time s, value).
    #[must_use]
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Time of the last point, s.
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.points.last().map_or(0.0, |p| p.0)
    }
}

/// Rubbing of the flank on the waves it has just cut.
///
/// A radial force -C·(b/V)·ṙ on the tool while it cuts (ṙ: velocity of the
/// edge into the material, b: depth, V: cutting speed) and `friction` times as
/// much along the cut. It adds about C·b/(2V√(km)) to the damping ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessDamping {
    /// C, N/m, ≥ 0. Published fits are of the order 1e5 to 1e6 (not verified here).
    pub c_n_per_m: f64,
    /// Ratio of tangential to radial force, 1, ≥ 0.
    pub friction: f64,
    /// Diameter of cutter (milling) or workpiece (turning), m, > 0; with the
    /// spindle speed it gives V.
    pub diameter_m: f64,
}

impl ProcessDamping {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        non_negative(self.c_n_per_m, "c_n_per_m")?;
        non_negative(self.friction, "friction")?;
        positive(self.diameter_m, "diameter_m")
    }

    /// C/V at this spindle speed, N·s/m².
    #[must_use]
    pub fn per_speed(&self, spindle_hz: f64) -> f64 {
        self.c_n_per_m / (core::f64::consts::PI * self.diameter_m * spindle_hz)
    }
}

/// Wear of the edge as a slow growth of its coefficients from time 0 on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wear {
    /// Relative growth of Kt and Kn, 1/s, ≥ 0.
    pub cutting_per_s: f64,
    /// Relative growth of the edge coefficients, 1/s, ≥ 0.
    pub edge_per_s: f64,
}

impl Wear {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        non_negative(self.cutting_per_s, "cutting_per_s")?;
        non_negative(self.edge_per_s, "edge_per_s")
    }
}

/// Broadband excitation that is not regeneration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceNoise {
    /// Standard deviation of the cutting force relative to its value, 1, ≥ 0
    /// (grain, built-up edge, chip breaking). Default 0.
    pub relative: f64,
    /// Standard deviation of a force on the tool that is there even in air, N
    /// per direction, ≥ 0 (bearings, coolant, drives). Default 0.
    pub background_n: f64,
    /// Corner of the first-order low-pass both have passed, Hz, > 0. Default 8000.
    pub bandwidth_hz: f64,
}

impl Default for ForceNoise {
    fn default() -> Self {
        Self {
            relative: 0.0,
            background_n: 0.0,
            bandwidth_hz: 8000.0,
        }
    }
}

impl ForceNoise {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        non_negative(self.relative, "relative")?;
        non_negative(self.background_n, "background_n")?;
        positive(self.bandwidth_hz, "bandwidth_hz")
    }
}

/// Independent low-pass noises of unit variance, sampled exactly.
///
/// xₖ₊₁ = ρ·xₖ + √(1-ρ²)·eₖ with ρ = e^(-2πf·dt): the same variance and the same
/// correlation in time at any step.
#[derive(Clone, Debug)]
pub(crate) struct SmoothNoise<const N: usize> {
    rho: f64,
    kick: f64,
    value: [f64; N],
    rng: ChaCha8Rng,
}

impl<const N: usize> SmoothNoise<N> {
    pub(crate) fn new(bandwidth_hz: f64, dt: f64, seed: u64) -> Self {
        let rho = (-TAU * bandwidth_hz * dt).exp();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let value = core::array::from_fn(|_| StandardNormal.sample(&mut rng));
        Self {
            rho,
            kick: (1.0 - rho * rho).sqrt(),
            value,
            rng,
        }
    }

    /// Another step from here on.
    pub(crate) fn retime(&mut self, bandwidth_hz: f64, dt: f64) {
        self.rho = (-TAU * bandwidth_hz * dt).exp();
        self.kick = (1.0 - self.rho * self.rho).sqrt();
    }

    pub(crate) fn advance(&mut self) -> [f64; N] {
        for x in &mut self.value {
            let e: f64 = StandardNormal.sample(&mut self.rng);
            *x = self.rho * *x + self.kick * e;
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schedule_interpolates_and_finds_the_crossing() {
        let s = Schedule::new(&[(1.0, 0.0), (2.0, 1e-3), (3.0, 1e-3)]).expect("valid");
        assert_eq!(s.at(0.0), 0.0);
        assert!((s.at(1.25) - 0.25e-3).abs() < 1e-18);
        assert_eq!(s.at(9.0), 1e-3);
        assert!((s.rises_through(0.5e-3).expect("crosses") - 1.5).abs() < 1e-12);
        assert_eq!(s.rises_through(2e-3), None);
        assert_eq!(s.falls_through(0.5e-3), None);
        assert_eq!(s.in_cut_s(), Some((1.0, 3.0)));
        let back = Schedule::new(&[(1.0, 2e-3), (3.0, 0.0), (4.0, 0.0)]).expect("valid");
        assert!((back.falls_through(0.5e-3).expect("crosses") - 2.5).abs() < 1e-12);
        assert_eq!(back.in_cut_s(), Some((1.0, 3.0)));
        assert_eq!(Schedule::constant(0.0).in_cut_s(), None);
        assert!(Schedule::new(&[(1.0, 0.0), (1.0, 1e-3)]).is_err());
        assert!(Schedule::new(&[(1.0, -1e-3)]).is_err());
        assert!(Schedule::new(&[]).is_err());
    }

    #[test]
    fn smooth_noise_keeps_its_variance_at_any_step() {
        for dt in [1e-6, 1e-5, 1e-3] {
            let mut noise = SmoothNoise::<1>::new(8000.0, dt, 4);
            let n = 400_000;
            let power = (0..n).map(|_| noise.advance()[0].powi(2)).sum::<f64>() / f64::from(n);
            // Fewest independent samples at 1 µs: 400 000·π·8000·1e-6 ≈ 10 000.
            assert!((power - 1.0).abs() < 0.06, "{dt}: {power}");
        }
    }
}
