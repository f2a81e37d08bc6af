//! The machine: where the spindle really is, and how far it gives way.

use super::stiffness::Around;
use std::f64::consts::TAU;

/// Geometric errors in the plane, by their definitions; x, y are the commanded place and
/// R the radius. The radial error follows by geometry, to all orders.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Geometry {
    /// Centre of the circle off the ball on the table, m.
    pub centre_m: [f64; 2],
    /// Length of the bar beyond the nominal one, m (shortens every reading).
    pub bar_m: f64,
    /// Scale: ex = sx·x, ey = sy·y.
    pub scale: [f64; 2],
    /// Squareness, rad: ex = −β·y; positive: +X and +Y more than 90° apart.
    pub squareness_rad: f64,
    /// Bow of X and Y, m: ey = cX·(x/R)², ex = cY·(y/R)².
    pub bow_m: [f64; 2],
    /// Backlash, m: ex = −(Bx/2)·sgn ẋ, ey = −(By/2)·sgn ẏ.
    pub backlash_m: [f64; 2],
    /// Lateral play, m: ey = +(Lx/2)·sgn ẋ, ex = +(Ly/2)·sgn ẏ.
    pub play_m: [f64; 2],
    /// Servo lag, s: e = −τ·velocity.
    pub lag_s: [f64; 2],
    /// Cyclic error: amplitude, m; both axes share a pitch.
    pub cyclic_m: [f64; 2],
    /// Phase of it, rad.
    pub cyclic_rad: [f64; 2],
    /// Height of the outward bump after a reversal of X, Y, m; it is highest 1° after.
    pub spike_m: [f64; 2],
}

impl Geometry {
    /// This and `factor` times what it grows by.
    #[must_use]
    pub fn grown(&self, by: &Self, factor: f64) -> Self {
        let pair = |a: [f64; 2], b: [f64; 2]| [a[0] + factor * b[0], a[1] + factor * b[1]];
        Self {
            centre_m: pair(self.centre_m, by.centre_m),
            bar_m: self.bar_m + factor * by.bar_m,
            scale: pair(self.scale, by.scale),
            squareness_rad: self.squareness_rad + factor * by.squareness_rad,
            bow_m: pair(self.bow_m, by.bow_m),
            backlash_m: pair(self.backlash_m, by.backlash_m),
            play_m: pair(self.play_m, by.play_m),
            lag_s: pair(self.lag_s, by.lag_s),
            cyclic_m: pair(self.cyclic_m, by.cyclic_m),
            cyclic_rad: pair(self.cyclic_rad, by.cyclic_rad),
            spike_m: pair(self.spike_m, by.spike_m),
        }
    }
}

/// A machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineConfig {
    /// Radius of the circle, m.
    pub radius_m: f64,
    /// Pitch of the cyclic errors, m.
    pub pitch_m: f64,
    /// Errors without load.
    pub geometry: Geometry,
    /// What is added to them for every newton.
    pub per_newton: Geometry,
    /// Stiffness while the axes move, N/m.
    pub stiffness_n_per_m: Around,
    /// Compliance that is added while they stand: guideways stick, and give way by
    /// pre-sliding without the servo seeing it; part of the moving compliance.
    pub standing: Around,
    /// Curvature: deflection c·F·(1 + q·F), 1/N.
    pub curvature_per_n: f64,
    /// Width of the hysteresis loop, m.
    pub hysteresis_m: Around,
    /// Force over which the sliders of the hysteresis let go, N.
    pub slip_n: f64,
    /// Stiffness grows by this part times sin φ with the bar's inclination φ.
    pub per_inclination: f64,
}

impl MachineConfig {
    /// An ideal machine of one stiffness.
    pub fn ideal(stiffness_n_per_m: f64) -> Self {
        Self {
            radius_m: 0.15,
            pitch_m: 0.01,
            geometry: Geometry::default(),
            per_newton: Geometry::default(),
            stiffness_n_per_m: Around::constant(stiffness_n_per_m),
            standing: Around::constant(0.0),
            curvature_per_n: 0.0,
            hysteresis_m: Around::constant(0.0),
            slip_n: 30.0,
            per_inclination: 0.0,
        }
    }
}

/// Where the spindle is told to be, and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Commanded {
    /// Angle, rad.
    pub theta: f64,
    /// Distance from the centre, m.
    pub radius_m: f64,
    /// Speed along the circle, m/s; positive counter-clockwise.
    pub speed_m_s: f64,
    /// Inclination of the bar, rad.
    pub inclination_rad: f64,
}

/// The machine with what it remembers.
#[derive(Debug, Clone)]
pub struct Machine {
    /// What it is.
    pub config: MachineConfig,
    /// Force on the sliders, −slip to slip, N.
    slider_n: f64,
    force_n: f64,
}

impl Machine {
    /// Unloaded.
    pub fn new(config: MachineConfig) -> Self {
        Self {
            config,
            slider_n: 0.0,
            force_n: 0.0,
        }
    }

    /// Length change of the bar in the plane, m, at a force in the plane, N.
    pub fn length_change_m(&mut self, at: &Commanded, force_n: f64) -> f64 {
        self.load(force_n);
        self.config.radial_m(at, force_n) + self.deflection_m(at, force_n)
    }

    /// The force as it is now; the sliders follow.
    pub fn load(&mut self, force_n: f64) {
        let slip = self.config.slip_n;
        self.slider_n = (self.slider_n + force_n - self.force_n).clamp(-slip, slip);
        self.force_n = force_n;
    }

    /// The axes have moved the load to another direction: the sliders there have not
    /// been bent yet.
    pub fn released(&mut self) {
        self.slider_n = self.force_n.clamp(-self.config.slip_n, self.config.slip_n);
    }

    fn deflection_m(&self, at: &Commanded, force_n: f64) -> f64 {
        let c = &self.config;
        let standing = if at.speed_m_s == 0.0 {
            c.standing.at(at.theta)
        } else {
            0.0
        };
        // Sliders hold the machine back on the way up and keep it out on the way down.
        let held = -0.5 * c.hysteresis_m.at(at.theta) * self.slider_n / c.slip_n;
        c.compliance(at.theta, at.inclination_rad)
            * (1.0 + standing)
            * force_n
            * (1.0 + c.curvature_per_n * force_n)
            + held
    }
}

impl MachineConfig {
    /// Compliance while the axes move, m/N.
    pub fn compliance(&self, theta: f64, inclination_rad: f64) -> f64 {
        let k = self.stiffness_n_per_m.at(theta);
        1.0 / (k * (1.0 + self.per_inclination * inclination_rad.sin()))
    }

    /// What geometry makes of the errors: distance from ball to ball less the bar's
    /// nominal length in the plane, m, without deflection.
    pub fn radial_m(&self, at: &Commanded, force_n: f64) -> f64 {
        let g = self.geometry.grown(&self.per_newton, force_n);
        let (s, c) = at.theta.sin_cos();
        let (x, y) = (at.radius_m * c, at.radius_m * s);
        let (vx, vy) = (-at.speed_m_s * s, at.speed_m_s * c);
        let sign = |v: f64| if v == 0.0 { 0.0 } else { v.signum() };
        let cyclic = |axis: usize, at: f64| {
            g.cyclic_m[axis] * (TAU * at / self.pitch_m + g.cyclic_rad[axis]).sin()
        };
        let r = self.radius_m;
        let ex = g.scale[0] * x - g.squareness_rad * y + g.bow_m[1] * (y / r).powi(2)
            - 0.5 * g.backlash_m[0] * sign(vx)
            + 0.5 * g.play_m[1] * sign(vy)
            - g.lag_s[0] * vx
            + cyclic(0, x);
        let ey = g.scale[1] * y + g.bow_m[0] * (x / r).powi(2) - 0.5 * g.backlash_m[1] * sign(vy)
            + 0.5 * g.play_m[0] * sign(vx)
            - g.lag_s[1] * vy
            + cyclic(1, y);
        let length = (x + ex + g.centre_m[0]).hypot(y + ey + g.centre_m[1]);
        length - r - g.bar_m + spike(&g, at)
    }
}

/// The bump after a reversal: (φ/1°)·e^(1 − φ/1°) after 0° and 180° for X, 90° and 270° for Y.
fn spike(g: &Geometry, at: &Commanded) -> f64 {
    if at.speed_m_s == 0.0 || g.spike_m == [0.0; 2] {
        return 0.0;
    }
    let direction = at.speed_m_s.signum();
    let after = |reversal: f64| {
        let d = (direction * (at.theta.to_degrees() - reversal)).rem_euclid(180.0);
        d * (1.0 - d).exp()
    };
    g.spike_m[0] * after(0.0) + g.spike_m[1] * after(90.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(theta: f64) -> Commanded {
        Commanded {
            theta,
            radius_m: 0.15,
            speed_m_s: 1.0 / 60.0,
            inclination_rad: 0.0,
        }
    }

    #[test]
    fn hysteresis_is_as_wide_as_told_and_does_not_tilt_the_curve() {
        let mut config = MachineConfig::ideal(11.8e6);
        config.hysteresis_m = Around::constant(4e-6);
        let mut m = Machine::new(config);
        let up: Vec<f64> = [36.0, 364.0, 868.0]
            .iter()
            .map(|f| m.length_change_m(&at(0.3), *f))
            .collect();
        assert!(((up[2] - up[0]) / 832.0 * 11.8e6 - 1.0).abs() < 1e-6);
        let down: Vec<f64> = [364.0, 36.0]
            .iter()
            .map(|f| m.length_change_m(&at(0.3), *f))
            .collect();
        assert!((down[0] - up[1] - 4e-6).abs() < 1e-12);
        assert!((down[1] - up[0] - 4e-6).abs() < 1e-12);
    }

    #[test]
    fn errors_grow_with_load() {
        let mut config = MachineConfig::ideal(1e12);
        config.per_newton.squareness_rad = 1e-8;
        let m = |force| config.radial_m(&at(std::f64::consts::FRAC_PI_4), force);
        // −βR/2 at 45°.
        assert!((m(868.0) - m(0.0) + 0.5 * 0.15 * 868e-8).abs() < 1e-10);
    }
}
