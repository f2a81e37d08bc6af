//! The elastic link between tool joint and table: the load stands for its stiffness.

use super::error::{ElsModelError, check};
use core::f64::consts::PI;
use nalgebra::{Matrix2, Vector2};

/// How the stiffness of the link along its axis follows the load it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkLaw {
    /// The same at any load, N/m, 0 or more.
    Constant(f64),
    /// Contact of a ball in its seat (Hertz): k = dF/dδ = (6·E*²·R·F)^⅓. It is this that
    /// makes a load bar stiffer with the load: from nothing at rest to about 100 N/µm at
    /// 1 kN for a ball of 10 mm radius on steel.
    Hertz {
        /// Radius of contact R, m: 1/R = 1/R_ball − 1/R_seat.
        radius_m: f64,
        /// Modulus of contact E*, Pa: 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂; steel on steel
        /// 1.15e11.
        modulus_pa: f64,
    },
}

/// The link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// Stiffness along it.
    pub law: LinkLaw,
    /// Stiffness across it over that along it, 0 or more. Contact without slip:
    /// 2(1 − ν)/(2 − ν) = 0.82 for steel (Mindlin). 0 for a bar that pivots freely.
    pub across: f64,
    /// Direction, rad from x towards y.
    pub angle_rad: f64,
    /// Loss factor, 0 or more.
    pub loss: f64,
}

impl Link {
    /// Stiffness along the link under `load_n`, N/m.
    ///
    /// # Errors
    /// A load that is negative or not finite.
    pub fn along_n_per_m(&self, load_n: f64) -> Result<f64, ElsModelError> {
        check(load_n.is_finite() && load_n >= 0.0, "load_n")?;
        Ok(match self.law {
            LinkLaw::Constant(k) => k,
            LinkLaw::Hertz {
                radius_m,
                modulus_pa,
            } => (6.0 * modulus_pa * modulus_pa * radius_m * load_n).cbrt(),
        })
    }

    /// Stiffness in (x, y) under `load_n`, N/m.
    ///
    /// # Errors
    /// As [`Self::along_n_per_m`].
    pub fn tensor(&self, load_n: f64) -> Result<Matrix2<f64>, ElsModelError> {
        let k = self.along_n_per_m(load_n)?;
        let e = Vector2::new(self.angle_rad.cos(), self.angle_rad.sin());
        let along = e * e.transpose();
        Ok((along + (Matrix2::identity() - along) * self.across) * k)
    }

    /// # Errors
    /// The field that is out of its range.
    pub fn validate(&self) -> Result<(), ElsModelError> {
        let ok = |x: f64| x.is_finite() && x >= 0.0;
        match self.law {
            LinkLaw::Constant(k) => check(ok(k), "link.n_per_m")?,
            LinkLaw::Hertz {
                radius_m,
                modulus_pa,
            } => {
                check(ok(radius_m) && radius_m > 0.0, "link.radius_m")?;
                check(ok(modulus_pa) && modulus_pa > 0.0, "link.modulus_pa")?;
            }
        }
        check(ok(self.across), "link.across")?;
        check(ok(self.loss), "link.loss")?;
        check(self.angle_rad.abs() <= 4.0 * PI, "link.angle_rad")
    }
}
