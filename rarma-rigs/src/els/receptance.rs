//! The receptance tensor of a plane at one frequency.

use super::complex::Complex;
use rarma_core::real::Real;

/// Displacement over force at one frequency in two orthogonal directions u and v, m/N,
/// e^{+jωt}. Measured by an exciter or a hammer, or computed.
///
/// Field names say response first, excitation second. The thesis writes the excitation
/// first: its Gvu is `resp_u_exc_v` here.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Receptance<T> {
    /// Direct, u.
    pub resp_u_exc_u: Complex<T>,
    /// Cross: response in u to a force in v.
    pub resp_u_exc_v: Complex<T>,
    /// Cross: response in v to a force in u.
    pub resp_v_exc_u: Complex<T>,
    /// Direct, v.
    pub resp_v_exc_v: Complex<T>,
}

impl<T: Real> Receptance<T> {
    /// A plane that moves in u only.
    pub fn along_u(direct: Complex<T>) -> Self {
        Self {
            resp_u_exc_u: direct,
            ..Self::default()
        }
    }

    /// A mode of this direct receptance whose direction stands at `angle` rad from u
    /// towards v: e·eᵀ times it.
    pub fn of_mode(direct: Complex<T>, angle: T) -> Self {
        let (s, c) = angle.sin_cos();
        let cross = direct.scale(s * c);
        Self {
            resp_u_exc_u: direct.scale(c * c),
            resp_u_exc_v: cross,
            resp_v_exc_u: cross,
            resp_v_exc_v: direct.scale(s * s),
        }
    }

    /// Sum, mode by mode.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            resp_u_exc_u: self.resp_u_exc_u + other.resp_u_exc_u,
            resp_u_exc_v: self.resp_u_exc_v + other.resp_u_exc_v,
            resp_v_exc_u: self.resp_v_exc_u + other.resp_v_exc_u,
            resp_v_exc_v: self.resp_v_exc_v + other.resp_v_exc_v,
        }
    }

    /// The same with both cross receptances at their mean, as reciprocity wants them.
    pub fn symmetrised(&self) -> Self {
        let mean = (self.resp_u_exc_v + self.resp_v_exc_u).scale(T::from_f64(0.5));
        Self {
            resp_u_exc_v: mean,
            resp_v_exc_u: mean,
            ..*self
        }
    }

    /// Receptance from a force at `exc_angle` α to the displacement at `resp_angle` β,
    /// both rad from u towards v, m/N:
    ///
    /// ```text
    /// G = eᵀ·[Guu Guv; Gvu Gvv]·p,   p = (cos α, sin α),   e = (cos β, sin β)
    ///   = Guu cos α cos β + Gvv sin α sin β + Guv cos β sin α + Gvu sin β cos α
    /// ```
    ///
    /// with G_ab the response in a to a force in b. With reciprocity the cross term is
    /// Guv·sin(α + β). The thesis' eqs (57) to (63) give a force in u no response in
    /// v·sin β and come to Guv·cos(β − α), which is wrong: at α = β = 0 a cross
    /// receptance would move the tool along a force it does not cross.
    ///
    /// ```
    /// use rarma_rigs::els::{Complex, Receptance};
    /// let g = Receptance::<f64>::of_mode(Complex::new(2e-8, -1e-8), 0.5);
    /// let along = g.directional(0.5, 0.5);
    /// assert!((along.re - 2e-8).abs() < 1e-20 && (along.im + 1e-8).abs() < 1e-20);
    /// ```
    pub fn directional(&self, exc_angle: T, resp_angle: T) -> Complex<T> {
        let (sa, ca) = exc_angle.sin_cos();
        let (sb, cb) = resp_angle.sin_cos();
        self.between((ca, sa), (cb, sb))
    }

    /// The same for directions as vectors (u, v): eᵀ·G·p. Not normalised: a force
    /// vector in N gives m.
    pub fn between(&self, p: (T, T), e: (T, T)) -> Complex<T> {
        let u = self.resp_u_exc_u.scale(p.0) + self.resp_u_exc_v.scale(p.1);
        let v = self.resp_v_exc_u.scale(p.0) + self.resp_v_exc_v.scale(p.1);
        u.scale(e.0) + v.scale(e.1)
    }

    /// Largest magnitude of the four, m/N.
    pub fn largest(&self) -> T {
        self.resp_u_exc_u
            .abs()
            .max(self.resp_u_exc_v.abs())
            .max(self.resp_v_exc_u.abs())
            .max(self.resp_v_exc_v.abs())
    }

    /// All four are finite.
    pub fn is_finite(&self) -> bool {
        self.resp_u_exc_u.is_finite()
            && self.resp_u_exc_v.is_finite()
            && self.resp_v_exc_u.is_finite()
            && self.resp_v_exc_v.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cross_receptances_keep_their_sides() {
        let g = Receptance {
            resp_u_exc_v: Complex::new(1.0, 0.0),
            ..Receptance::default()
        };
        let quarter = core::f64::consts::FRAC_PI_2;
        assert!((g.directional(quarter, 0.0).re - 1.0).abs() < 1e-15);
        assert!(g.directional(0.0, quarter).re.abs() < 1e-15);
        let mean = g.symmetrised();
        assert_eq!(mean.resp_u_exc_v, mean.resp_v_exc_u);
        assert!((mean.directional(0.0, quarter).re - 0.5).abs() < 1e-15);
    }

    #[test]
    fn turning_both_directions_by_half_a_turn_changes_nothing() {
        let g = Receptance::of_mode(Complex::new(3.0, -2.0), 0.3)
            .plus(&Receptance::of_mode(Complex::new(-1.0, -5.0), 1.9));
        let pi = core::f64::consts::PI;
        for k in 0..8 {
            let a = 0.7 * f64::from(k);
            let (x, y) = (
                g.directional(a, a + 0.4),
                g.directional(a + pi, a + pi + 0.4),
            );
            assert!((x - y).abs() < 1e-14);
            let z = g.directional(a + pi, a + 0.4);
            assert!((x + z).abs() < 1e-14, "one of them turns the sign");
        }
    }
}
