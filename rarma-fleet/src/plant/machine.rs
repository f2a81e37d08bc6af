//! What a machine is.

use super::geometry::Geometry;
use crate::record::Name;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rarma_plants::population::ranges;

/// Compliance in a plane, µm/N: c(θ) = xx·cos²θ + yy·sin²θ + xy·sin 2θ. A linear machine has no other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compliance {
    /// Along the first axis.
    pub xx: f64,
    /// Along the second.
    pub yy: f64,
    /// Across.
    pub xy: f64,
}

impl Compliance {
    /// In a direction, radians.
    #[must_use]
    pub fn along(&self, angle: f64) -> f64 {
        let (s, c) = angle.sin_cos();
        self.xx * c * c + self.yy * s * s + 2.0 * self.xy * s * c
    }

    /// With more in one direction, as of a joint that has come loose there.
    #[must_use]
    pub fn softened(&self, angle: f64, by: f64) -> Self {
        let (s, c) = angle.sin_cos();
        Self {
            xx: self.xx + by * c * c,
            yy: self.yy + by * s * s,
            xy: self.xy + by * s * c,
        }
    }

    /// All of it times something.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self {
            xx: self.xx * factor,
            yy: self.yy * factor,
            xy: self.xy * factor,
        }
    }
}

/// A mode of the structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueMode {
    /// `X` or `Y`.
    pub axis: char,
    /// Natural frequency, Hz.
    pub f_hz: f64,
    /// Damping ratio, 1.
    pub zeta: f64,
    /// Modal stiffness, N/µm.
    pub n_per_um: f64,
}

/// A machine as it is at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineNow {
    /// Compliance of the plane XY.
    pub plane: Compliance,
    /// Its modes.
    pub modes: Vec<TrueMode>,
    /// Specific cutting force of what it cuts, N/mm².
    pub ks_n_per_mm2: f64,
    /// Loops and errors of the plane XY.
    pub geometry: Geometry,
}

impl MachineNow {
    /// Widest stable cut in a direction, mm: the least over the modes of 2kζ(1+ζ)/(Ks·cos²), where cos is
    /// that of the angle between direction and mode (not below 0.2: no machine is without cross talk).
    #[must_use]
    pub fn width_mm(&self, angle: f64) -> f64 {
        (self.modes.iter())
            .map(|m| self.width_of(m, angle))
            .fold(f64::INFINITY, f64::min)
    }

    fn width_of(&self, m: &TrueMode, angle: f64) -> f64 {
        let axis = if m.axis == 'X' {
            0.0
        } else {
            std::f64::consts::FRAC_PI_2
        };
        let part = (angle - axis).cos().powi(2).max(0.04);
        2.0 * m.n_per_um * 1e3 * m.zeta * (1.0 + m.zeta) / (self.ks_n_per_mm2 * part)
    }

    /// Frequency of the chatter beyond that width, Hz: of the mode that is the least there, f·√(1+2ζ).
    #[must_use]
    pub fn chatter_hz(&self, angle: f64) -> f64 {
        let width = |m: &&TrueMode| self.width_of(m, angle);
        let least = self
            .modes
            .iter()
            .min_by(|a, b| width(a).total_cmp(&width(b)));
        least.map_or(f64::NAN, |m| m.f_hz * (1.0 + 2.0 * m.zeta).sqrt())
    }

    /// That of the worst of the twelve directions that are tested.
    #[must_use]
    pub fn limit_mm(&self) -> f64 {
        (0..12)
            .map(|n| self.width_mm(f64::from(n).to_radians() * 30.0))
            .fold(f64::INFINITY, f64::min)
    }
}

/// A machine as it was drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Its name.
    pub name: Name,
    /// What it was when it was new.
    pub new: MachineNow,
    /// What a degree of the hall adds to its compliance, 1/K.
    pub compliance_per_k: f64,
    /// What a degree adds to its damping, 1/K.
    pub damping_per_k: f64,
    /// Mean of the alarms of a day.
    pub alarms_a_day: f64,
}

impl Drawn {
    /// Draws machine number `n`: modes, damping, stiffness and material from the ranges of the population
    /// of cuts; stiffness of the plane from the machines of the thesis (8.4 to 12.4 N/µm, 10 to 30 % more
    /// in the stiffest direction).
    pub(super) fn draw(n: usize, rng: &mut ChaCha8Rng) -> Self {
        let mean = 1.0 / rng.random_range(8.4..12.4);
        let angle = rng.random_range(0.0..std::f64::consts::PI);
        let more = rng.random_range(0.1..0.3);
        let even = Compliance {
            xx: mean * (1.0 - more / 2.0),
            yy: mean * (1.0 - more / 2.0),
            xy: 0.0,
        };
        let modes = ['X', 'X', 'Y', 'Y']
            .into_iter()
            .fold(Vec::new(), |mut modes, axis| {
                let f_hz = loop {
                    let f: f64 = ranges::MODE_HZ.draw(rng);
                    // Two modes nearer than a quarter are not told apart from test to test.
                    if modes
                        .iter()
                        .all(|m: &TrueMode| (m.f_hz / f).ln().abs() > 0.25)
                    {
                        break f;
                    }
                };
                modes.push(TrueMode {
                    axis,
                    f_hz,
                    zeta: ranges::ZETA.draw(rng),
                    n_per_um: ranges::STIFFNESS_N_PER_M.draw(rng) * 1e-6,
                });
                modes
            });
        Self {
            name: Name::new(&format!("M{:03}", n + 1)).expect("a letter and digits"),
            new: MachineNow {
                plane: even.softened(angle, mean * more),
                modes,
                ks_n_per_mm2: ranges::CUTTING_N_PER_M2.draw(rng) * 1e-6,
                geometry: Geometry::draw(rng),
            },
            compliance_per_k: rng.random_range(0.0..0.001),
            damping_per_k: rng.random_range(0.0..0.006),
            alarms_a_day: rng.random_range(0.5..4.0),
        }
    }
}
