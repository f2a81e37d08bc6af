//! Joints and bearings: springs around a circle.

use core::f64::consts::TAU;
use nalgebra::{Matrix2, Vector2};

/// A stiffness that depends on the direction as the radius of an ellipse does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elliptic {
    /// Largest stiffness, N/m, > 0.
    pub major_n_per_m: f64,
    /// Smallest stiffness, N/m, > 0.
    pub minor_n_per_m: f64,
    /// Direction of the largest, rad from x towards y.
    pub angle_rad: f64,
}

impl Elliptic {
    /// The same all round.
    #[must_use]
    pub const fn even(n_per_m: f64) -> Self {
        Self {
            major_n_per_m: n_per_m,
            minor_n_per_m: n_per_m,
            angle_rad: 0.0,
        }
    }

    /// Radius of the ellipse at an angle, N/m.
    #[must_use]
    pub fn at(&self, angle_rad: f64) -> f64 {
        let (s, c) = (angle_rad - self.angle_rad).sin_cos();
        let (a, b) = (self.major_n_per_m, self.minor_n_per_m);
        a * b / ((b * c).powi(2) + (a * s).powi(2)).sqrt()
    }

    /// Times a factor.
    #[must_use]
    pub fn scaled(&self, by: f64) -> Self {
        Self {
            major_n_per_m: self.major_n_per_m * by,
            minor_n_per_m: self.minor_n_per_m * by,
            ..*self
        }
    }
}

/// Springs around a circle in a plane across the axis, between two bodies or a body and
/// the housing, which does not move.
///
/// Spring i stands at ψ_i = ψ₀ + 2πi/n and takes 2/n of the elliptic stiffness at that
/// angle:
///
/// ```text
/// K = (2/n)·Σ k(ψ_i)·n_i·n_iᵀ,   n_i = (cos ψ_i, sin ψ_i)
/// ```
///
/// so that an even ring of k has K = k·I whatever n ≥ 3 is. Four springs on the axes of
/// the ellipse give exactly its two stiffnesses; three (a polygonal taper) couple x and y.
/// Many stand for a distributed stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Springs, at least 3.
    pub springs: usize,
    /// Angle of the first, rad.
    pub first_rad: f64,
    /// Radial stiffness of the whole ring.
    pub radial: Elliptic,
    /// Stiffness against tilting about a diameter, N·m/rad, 0 or more; spread as the
    /// radial stiffness is.
    pub tilt_n_m_per_rad: f64,
    /// Stiffness against turning about the axis, N·m/rad, 0 or more.
    pub twist_n_m_per_rad: f64,
    /// Loss factor of all of it, 0 or more.
    pub loss: f64,
}

impl Ring {
    /// Translational stiffness, N/m.
    #[must_use]
    pub fn tensor(&self) -> Matrix2<f64> {
        let n = self.springs as f64;
        (0..self.springs).fold(Matrix2::zeros(), |sum, i| {
            let angle = self.first_rad + TAU * i as f64 / n;
            let e = Vector2::new(angle.cos(), angle.sin());
            sum + e * e.transpose() * (2.0 / n * self.radial.at(angle))
        })
    }

    /// Tilt stiffness by slopes (dx/dz, dy/dz), N·m/rad.
    #[must_use]
    pub fn tilt_tensor(&self) -> Matrix2<f64> {
        let k = self.tensor();
        let mean = 0.5 * k.trace();
        if mean > 0.0 {
            k * (self.tilt_n_m_per_rad / mean)
        } else {
            Matrix2::zeros()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(springs: usize, major: f64, minor: f64) -> Ring {
        Ring {
            springs,
            first_rad: 0.0,
            radial: Elliptic {
                major_n_per_m: major,
                minor_n_per_m: minor,
                angle_rad: 0.0,
            },
            tilt_n_m_per_rad: 0.0,
            twist_n_m_per_rad: 0.0,
            loss: 0.0,
        }
    }

    #[test]
    fn an_even_ring_is_even() {
        for n in [3, 4, 5, 72] {
            let k = ring(n, 8e7, 8e7).tensor();
            assert!((k - Matrix2::identity() * 8e7).norm() < 1.0, "{n}: {k}");
        }
    }

    #[test]
    fn an_ellipse_has_its_axes() {
        let k = ring(4, 9e7, 7.5e7).tensor();
        assert!((k[(0, 0)] / 9e7 - 1.0).abs() < 1e-12 && (k[(1, 1)] / 7.5e7 - 1.0).abs() < 1e-12);
        let e = ring(4, 9e7, 7.5e7).radial;
        assert!(
            (e.at(0.0) - 9e7).abs() < 1e-3
                && (e.at(core::f64::consts::FRAC_PI_2) - 7.5e7).abs() < 1e-3
        );
        let three = Ring {
            first_rad: 0.2,
            ..ring(3, 9e7, 7.5e7)
        };
        assert!(three.tensor()[(0, 1)].abs() > 1e5, "three springs couple");
    }
}
