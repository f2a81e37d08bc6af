//! Spindle, holder and tool as the exciter meets them: modes that change with speed.
//!
//! The modes are those of the thesis' table 3 (modal analysis, at rest): seven in X, five of
//! its six in Y, the last having no damping in print. The table's columns are interleaved in
//! the text at hand; which value belongs to Y is our reading. It gives no stiffness and no
//! shape: those are ours.

use crate::error::{PlantError, require};
use crate::modal::{FohStep, Mode, ShapedMode};

/// Frequency Hz and damping ratio of the thesis' table 3, X.
pub const TABLE_3_X: [(f64, f64); 7] = [
    (390.0, 0.033),
    (531.0, 0.032),
    (807.0, 0.071),
    (932.0, 0.059),
    (1710.0, 0.059),
    (2160.0, 0.048),
    (2315.0, 0.028),
];
/// The same for Y.
pub const TABLE_3_Y: [(f64, f64); 5] = [
    (502.0, 0.046),
    (800.0, 0.042),
    (974.0, 0.070),
    (1240.0, 0.072),
    (2280.0, 0.050),
];

/// How a structure changes with the speed of its spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithSpeed {
    /// Speed at which the changes below are reached, revolutions/s.
    pub at_hz: f64,
    /// Change of every natural frequency there, part of it; grows with the square of the
    /// speed (bearings are relieved by centrifugal force).
    pub frequency_part: f64,
    /// Change of every damping ratio there, part of it; grows with the speed (oil).
    pub damping_part: f64,
}

impl Default for WithSpeed {
    fn default() -> Self {
        Self {
            at_hz: 300.0,
            frequency_part: -0.04,
            damping_part: 0.8,
        }
    }
}

/// A structure, at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureConfig {
    /// Modes; the shape says how they move the rotor, `at_sensor` how much of it the
    /// accelerometer at the front bearing sees.
    pub modes: Vec<ShapedMode>,
    /// What speed does.
    pub with_speed: WithSpeed,
}

impl StructureConfig {
    /// Table 3, every mode of 40 N/µm, turned by `skew_rad` out of its direction so that
    /// the cross receptances are not zero.
    #[must_use]
    pub fn table_3(skew_rad: f64) -> Self {
        let (s, c) = skew_rad.sin_cos();
        let mode = |&(f, zeta): &(f64, f64), x, y| ShapedMode {
            mode: Mode::from_stiffness(f, zeta, 40e6),
            x,
            y,
            turn_rad_per_m: 0.0,
            at_sensor: 0.3,
        };
        let mut modes: Vec<_> = TABLE_3_X.iter().map(|m| mode(m, c, s)).collect();
        modes.extend(TABLE_3_Y.iter().map(|m| mode(m, -s, c)));
        Self {
            modes,
            with_speed: WithSpeed::default(),
        }
    }

    /// The modes at a speed of the spindle, revolutions/s. Stiffness falls with the square of
    /// the frequency: the mass stays.
    #[must_use]
    pub fn at(&self, spindle_hz: f64) -> Vec<ShapedMode> {
        let r = spindle_hz / self.with_speed.at_hz;
        let f = 1.0 + self.with_speed.frequency_part * r * r;
        let z = 1.0 + self.with_speed.damping_part * r.abs();
        self.modes
            .iter()
            .map(|m| ShapedMode {
                mode: Mode::from_stiffness(
                    m.mode.f_hz * f,
                    m.mode.zeta * z,
                    m.mode.stiffness_n_per_m * f * f,
                ),
                ..*m
            })
            .collect()
    }

    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        for m in &self.modes {
            m.validate()?;
        }
        let w = &self.with_speed;
        require(w.at_hz.is_finite() && w.at_hz > 0.0, "at_hz")?;
        require(w.frequency_part.abs() < 0.5, "frequency_part")?;
        require((-0.9..20.0).contains(&w.damping_part), "damping_part")
    }
}

/// A structure that moves.
#[derive(Clone, Debug)]
pub struct Structure {
    config: StructureConfig,
    now: Vec<ShapedMode>,
    steps: Vec<FohStep>,
    state: Vec<[f64; 2]>,
    dt: f64,
    force_n: [f64; 2],
}

impl Structure {
    /// At rest, for steps of `dt` s.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn new(config: StructureConfig, dt: f64) -> Result<Self, PlantError> {
        config.validate()?;
        let state = vec![[0.0; 2]; config.modes.len()];
        let mut out = Self {
            config,
            now: Vec::new(),
            steps: Vec::new(),
            state,
            dt,
            force_n: [0.0; 2],
        };
        out.turn(0.0);
        Ok(out)
    }

    /// The spindle turns at this speed from now on, revolutions/s.
    pub fn turn(&mut self, spindle_hz: f64) {
        self.now = self.config.at(spindle_hz);
        self.steps = self
            .now
            .iter()
            .map(|m| FohStep::new(&m.mode, self.dt))
            .collect();
    }

    /// One step; the force on the rotor, N in x and y, goes straight from the one before to
    /// this.
    pub fn step(&mut self, force_n: [f64; 2]) {
        for ((m, step), s) in self.now.iter().zip(&self.steps).zip(&mut self.state) {
            let on = |f: [f64; 2]| m.x * f[0] + m.y * f[1];
            *s = step.advance(*s, on(self.force_n), on(force_n));
        }
        self.force_n = force_n;
    }

    fn sum(&self, of: impl Fn(&ShapedMode, &[f64; 2]) -> f64) -> [f64; 2] {
        let mut out = [0.0; 2];
        for (m, s) in self.now.iter().zip(&self.state) {
            let q = of(m, s);
            out[0] += m.x * q;
            out[1] += m.y * q;
        }
        out
    }

    /// Displacement of the rotor, m.
    #[must_use]
    pub fn rotor_m(&self) -> [f64; 2] {
        self.sum(|_, s| s[0])
    }

    /// Velocity of the rotor, m/s.
    #[must_use]
    pub fn rotor_m_per_s(&self) -> [f64; 2] {
        self.sum(|_, s| s[1])
    }

    /// Acceleration at the front bearing, m/s².
    #[must_use]
    pub fn casing_m_per_s2(&self) -> [f64; 2] {
        let force = self.force_n;
        self.sum(|m, s| {
            let w = m.mode.omega();
            let f = m.x * force[0] + m.y * force[1];
            m.at_sensor * (f / m.mode.mass_kg() - 2.0 * m.mode.zeta * w * s[1] - w * w * s[0])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_force_ends_at_the_sum_of_compliances() {
        let config = StructureConfig::table_3(0.1);
        let mut s = Structure::new(config.clone(), 12.5e-6).expect("valid");
        for _ in 0..80_000 {
            s.step([10.0, 0.0]);
        }
        let want: f64 = config
            .modes
            .iter()
            .map(|m| m.x * m.x * 10.0 / m.mode.stiffness_n_per_m)
            .sum();
        assert!((s.rotor_m()[0] / want - 1.0).abs() < 1e-6);
        let a = s.casing_m_per_s2()[0].abs();
        assert!(a < 1e-6, "{a}");
    }

    #[test]
    fn speed_changes_what_it_says() {
        let config = StructureConfig::table_3(0.0);
        let (still, fast) = (config.at(0.0), config.at(300.0));
        for (a, b) in still.iter().zip(&fast) {
            assert!((b.mode.f_hz / a.mode.f_hz - 0.96).abs() < 1e-12);
            assert!((b.mode.zeta / a.mode.zeta - 1.8).abs() < 1e-12);
            assert!((b.mode.mass_kg() / a.mode.mass_kg() - 1.0).abs() < 1e-12);
        }
        assert_eq!(still, config.modes);
    }
}
