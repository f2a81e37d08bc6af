//! Static deflection.

use super::assembly::ElsModel;
use super::config::Place;
use super::error::{ElsModelError, check};
use super::modes::{eigen, rigid};
use nalgebra::{Matrix2, Vector2};

/// How far a place moves under a force at the tool joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deflection {
    /// Along x, m.
    pub x_m: f64,
    /// Along y, m.
    pub y_m: f64,
}

impl Deflection {
    /// Length of it, m.
    #[must_use]
    pub fn total_m(&self) -> f64 {
        self.x_m.hypot(self.y_m)
    }
}

impl ElsModel {
    /// Compliance (m/N) of each place to a force at the tip: column j is the motion in
    /// (x, y) for a unit force in x (j = 0) or y. The link pushes and is no support.
    ///
    /// # Errors
    /// `Singular` where a motion is free; a place out of range.
    pub fn compliances(&self, places: &[Place]) -> Result<Vec<Matrix2<f64>>, ElsModelError> {
        let (values, _) = eigen(&self.stiffness, &self.mass)?;
        let free = rigid(&values);
        if free > 0 {
            return Err(ElsModelError::Singular { free });
        }
        let force = self.input(Place::Holder(0.0))?;
        let moved = self
            .stiffness
            .clone()
            .cholesky()
            .ok_or(ElsModelError::Singular { free: 1 })?
            .solve(&force);
        places
            .iter()
            .map(|&place| {
                let c = self.input(place)?.transpose() * &moved;
                Ok(Matrix2::new(c[(0, 0)], c[(0, 1)], c[(1, 0)], c[(1, 1)]))
            })
            .collect()
    }

    /// Compliance that the load sees, m/N: the tip's, and the tool joint in series.
    ///
    /// # Errors
    /// As [`Self::compliances`].
    pub fn tool_joint_compliance(&self) -> Result<Matrix2<f64>, ElsModelError> {
        let tip = self.compliances(&[Place::Holder(0.0)])?[0];
        Ok(tip + Matrix2::identity() / self.tool_joint_n_per_m)
    }

    /// Motion under `load_n` at `angle_rad` (from x towards y) for a compliance.
    ///
    /// # Errors
    /// A load or an angle that is not finite.
    pub fn deflection(
        compliance: &Matrix2<f64>,
        load_n: f64,
        angle_rad: f64,
    ) -> Result<Deflection, ElsModelError> {
        check(load_n.is_finite() && angle_rad.is_finite(), "load")?;
        let d = compliance * Vector2::new(angle_rad.cos(), angle_rad.sin()) * load_n;
        Ok(Deflection { x_m: d.x, y_m: d.y })
    }
}
