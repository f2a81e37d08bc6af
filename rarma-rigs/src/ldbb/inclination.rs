//! What a bar that is inclined to the plane of the circle needs.

use super::error::LdbbError;
use super::force::{ForceLaw, HOLDING_N};
use rarma_core::real::Real;

/// A bar at an angle to the plane, and what is kept of the level test.
///
/// "The same ratio of force and feed", as the thesis has it, can be read in more than one
/// way. Here: the angular rate is always that of the level test; the force is chosen so that
/// either its part in the plane is the level one (`in_plane`), or that along the bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inclination<T> {
    /// Angle of the bar above the plane, rad, within ±80°.
    pub angle_rad: T,
    /// Length from ball to ball, m.
    pub length_m: T,
    /// Feed of the level test, m/s.
    pub feed_m_s: T,
    /// Weight of the bar that its lower ball does not carry, N, along the vertical: half of
    /// it where the bar is uniform. 0 where the plane is not level.
    pub weight_n: T,
    /// Keep the force in the plane (true), or along the bar (false).
    pub in_plane: bool,
}

/// What to set for one force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting<T> {
    /// Radius of the circle, m: L·cos φ.
    pub radius_m: T,
    /// Feed along it, m/s.
    pub feed_m_s: T,
    /// Force along the bar, N.
    pub force_n: T,
    /// Force in the plane, N.
    pub in_plane_n: T,
    /// Pressure, Pa.
    pub pressure_pa: T,
}

impl<T: Real> Inclination<T> {
    /// What gives `force_n`, the force of the level test. The bar's weight along itself,
    /// w·sin φ, adds to the cylinder's force on the upper ball where φ < 0 and takes from it
    /// where φ > 0.
    ///
    /// # Errors
    /// `OutOfReach` where the pressure is above `most_pa`, `BelowHolding`, `OutOfRange`.
    pub fn setting(
        &self,
        law: &ForceLaw<T>,
        force_n: T,
        most_pa: T,
    ) -> Result<Setting<T>, LdbbError> {
        let limit = T::PI * T::from_f64(80.0 / 180.0);
        if !(self.angle_rad.abs() <= limit) {
            return Err(LdbbError::OutOfRange {
                name: "inclination",
            });
        }
        if !(self.length_m > T::ZERO && self.feed_m_s > T::ZERO && force_n.is_finite()) {
            return Err(LdbbError::OutOfRange { name: "force" });
        }
        let (sin, cos) = self.angle_rad.sin_cos();
        let along = if self.in_plane {
            force_n / cos
        } else {
            force_n
        };
        // Rounding of 0.4 bar must not refuse the holding force itself.
        if !(along >= T::from_f64(HOLDING_N - 0.5)) {
            return Err(LdbbError::BelowHolding {
                force_n: along.to_f32(),
            });
        }
        let pressure_pa = law.pressure_pa(along + self.weight_n * sin);
        if !(pressure_pa <= most_pa) {
            return Err(LdbbError::OutOfReach {
                force_n: along.to_f32(),
                needed_pa: pressure_pa.to_f32(),
                most_pa: most_pa.to_f32(),
            });
        }
        Ok(Setting {
            radius_m: self.length_m * cos,
            feed_m_s: self.feed_m_s * cos,
            force_n: along,
            in_plane_n: along * cos,
            pressure_pa,
        })
    }

    /// A change of the bar's length as a displacement in the plane, where the machine is far
    /// stiffer across the plane: ΔL/cos φ.
    pub fn in_plane_m(&self, length_change_m: T) -> T {
        length_change_m / self.angle_rad.sin_cos().1
    }
}

/// The bar as it stands under the box: force law, inclination, weight, and what the valve may
/// give. Jobs name the pressures of the level bar; the force in the plane is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarSet {
    /// Pressure to force along the bar.
    pub law: ForceLaw<f32>,
    /// Angle above the plane, rad.
    pub inclination_rad: f32,
    /// See [`Inclination::weight_n`].
    pub weight_n: f32,
    /// Greatest pressure, Pa.
    pub most_pa: f32,
}

impl BarSet {
    /// Cosine of the inclination.
    pub fn cos(&self) -> f32 {
        self.inclination_rad.sin_cos().1
    }

    /// Pressure that gives in the plane what `level_pa` gives a level bar, Pa.
    ///
    /// # Errors
    /// As [`Inclination::setting`].
    pub fn pressure_pa(&self, level_pa: f32) -> Result<f32, LdbbError> {
        let incline = Inclination {
            angle_rad: self.inclination_rad,
            // Not used for a pressure.
            length_m: 1.0,
            feed_m_s: 1.0,
            weight_n: self.weight_n,
            in_plane: true,
        };
        let force_n = self.law.force_n(level_pa);
        // What a level bar is asked for it gets: not even rounding changes it.
        if self.inclination_rad == 0.0 {
            return if level_pa <= self.most_pa {
                Ok(level_pa)
            } else {
                Err(LdbbError::OutOfReach {
                    force_n,
                    needed_pa: level_pa,
                    most_pa: self.most_pa,
                })
            };
        }
        Ok(incline
            .setting(&self.law, force_n, self.most_pa)?
            .pressure_pa)
    }

    /// Force in the plane at a pressure, N.
    pub fn in_plane_n(&self, pressure_pa: f32) -> f32 {
        let (sin, cos) = self.inclination_rad.sin_cos();
        (self.law.force_n(pressure_pa) - self.weight_n * sin) * cos
    }

    /// Length change of the bar as a displacement in the plane, m.
    pub fn in_plane_m(&self, length_change_m: f32) -> f32 {
        length_change_m / self.cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_box_asks_for_the_level_force_in_the_plane() {
        let mut bar = BarSet {
            law: ForceLaw::standard(),
            inclination_rad: 0.0,
            weight_n: 6.0,
            most_pa: 7.2e5,
        };
        assert_eq!(bar.pressure_pa(7e5), Ok(7e5));
        assert!(bar.pressure_pa(7.3e5).is_err());
        bar.inclination_rad = 30f32.to_radians();
        // 364 N in the plane are 420.3 N along the bar and 423.3 N of the cylinder.
        let p = bar.pressure_pa(3e5).expect("in reach");
        assert!((p - 3.4707e5).abs() < 20.0, "{p}");
        assert!((bar.in_plane_n(p) - 364.0).abs() < 0.01);
        assert!(matches!(
            bar.pressure_pa(7e5),
            Err(LdbbError::OutOfReach { .. })
        ));
        assert!((bar.in_plane_m(1e-6) - 1.1547e-6).abs() < 1e-10);
    }

    fn at(degrees: f64) -> Inclination<f64> {
        Inclination {
            angle_rad: degrees.to_radians(),
            length_m: 0.15,
            feed_m_s: 1.0 / 60.0,
            weight_n: 0.0,
            in_plane: true,
        }
    }

    #[test]
    fn the_inclinations_of_the_thesis() {
        let law = ForceLaw::standard();
        // Radius mm, feed mm/min, force N, pressure bar.
        for (deg, want) in [
            (-10.0, (147.7, 985.0, 881.4, 7.11)),
            (30.0, (129.9, 866.0, 1002.3, 8.07)),
        ] {
            let s = at(deg).setting(&law, 868.0, 9e5).expect("in reach");
            assert!((1e3 * s.radius_m - want.0).abs() < 0.05, "{s:?}");
            assert!((6e4 * s.feed_m_s - want.1).abs() < 0.5, "{s:?}");
            assert!((s.force_n - want.2).abs() < 0.5, "{s:?}");
            assert!((1e-5 * s.pressure_pa - want.3).abs() < 0.006, "{s:?}");
        }
        let why = at(45.0).setting(&law, 868.0, 9e5).expect_err("9.85 bar");
        let LdbbError::OutOfReach {
            force_n, needed_pa, ..
        } = why
        else {
            panic!("{why}")
        };
        assert!((force_n - 1227.5).abs() < 0.1 && (needed_pa - 9.853e5).abs() < 100.0);
        // Along the bar it is in reach, with less in the plane.
        let along = Inclination {
            in_plane: false,
            ..at(45.0)
        };
        let s = along.setting(&law, 868.0, 9e5).expect("7 bar");
        assert!((s.in_plane_n - 613.8).abs() < 0.1);
    }

    #[test]
    fn weight_and_refusals() {
        let law = ForceLaw::standard();
        let heavy = Inclination {
            weight_n: 10.0,
            ..at(30.0)
        };
        let difference = heavy
            .setting(&law, 400.0, 9e5)
            .expect("in reach")
            .pressure_pa
            - at(30.0)
                .setting(&law, 400.0, 9e5)
                .expect("in reach")
                .pressure_pa;
        assert!((difference * 126e-5 - 5.0).abs() < 1e-9);
        assert!(matches!(
            at(0.0).setting(&law, 20.0, 9e5),
            Err(LdbbError::BelowHolding { .. })
        ));
        assert!(at(0.0).setting(&law, 36.0, 9e5).is_ok());
        assert!(at(85.0).setting(&law, 100.0, 9e5).is_err());
    }
}
