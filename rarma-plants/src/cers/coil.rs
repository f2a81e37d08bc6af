//! One magnet: coil, iron, eddy currents, gap.
//!
//! Rate: [`Coil::step`] once a substep, half a microsecond to a few.
//!
//! ```text
//! dλ/dt = u − R·i,   λ = N·A·B + Lσ·i
//! N·i = B_lin(B)·2(s + δ)/µ₀ + (l/µ)·Σ w_n(B − x_n),   dx_n/dt = p_n(B − x_n)
//! B_lin = B·(1 − (B/B_s)⁶)^(−1/6),   F = cos α·A·B²/µ₀
//! ```
//!
//! The state is the flux linkage, so that motion gives its EMF by itself. The sum is the
//! partial-fraction form of diffusion into a lamination, z/tanh z; what lies beyond the terms
//! kept is one more, of the same first moment. At rest the law of forces follows.

use crate::error::{PlantError, non_negative, positive, require};
use core::f64::consts::PI;

/// Vacuum, V·s/(A·m).
const MU_0: f64 = 1.256_637_062_12e-6;
/// Relaxations of a lamination: five of their own and one for the rest.
const TERMS: usize = 6;
/// Part of the saturation flux that B stays below.
const MOST: f64 = 0.999;

/// What a magnet is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoilConfig {
    /// Turns, both legs.
    pub turns: f64,
    /// Area of one pole, m².
    pub pole_area_m2: f64,
    /// Half the angle between the poles, rad.
    pub pole_angle_rad: f64,
    /// Path in iron, m; 0 for ideal iron.
    pub iron_path_m: f64,
    /// Relative permeability.
    pub permeability: f64,
    /// Flux density at the knee, T.
    pub saturation_t: f64,
    /// Leakage inductance, H.
    pub leakage_h: f64,
    /// Resistance, Ω.
    pub resistance_ohm: f64,
    /// Thickness of a lamination, m; 0 for none.
    pub lamination_m: f64,
    /// Conductivity of the iron, S/m.
    pub conductivity_s_per_m: f64,
    /// What the gap is wider than it is thought to be, m.
    pub gap_error_m: f64,
}

impl Default for CoilConfig {
    fn default() -> Self {
        Self {
            turns: 100.0,
            pole_area_m2: 1e-4,
            pole_angle_rad: PI / 8.0,
            iron_path_m: 0.12,
            permeability: 3000.0,
            saturation_t: 1.3,
            leakage_h: 0.5e-3,
            resistance_ohm: 4.0,
            lamination_m: 0.35e-3,
            conductivity_s_per_m: 2e6,
            gap_error_m: 0.0,
        }
    }
}

impl CoilConfig {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        positive(self.turns, "turns")?;
        positive(self.pole_area_m2, "pole_area_m2")?;
        require((0.0..1.5).contains(&self.pole_angle_rad), "pole_angle_rad")?;
        non_negative(self.iron_path_m, "iron_path_m")?;
        positive(self.permeability, "permeability")?;
        positive(self.saturation_t, "saturation_t")?;
        non_negative(self.leakage_h, "leakage_h")?;
        positive(self.resistance_ohm, "resistance_ohm")?;
        non_negative(self.lamination_m, "lamination_m")?;
        positive(self.conductivity_s_per_m, "conductivity_s_per_m")?;
        require(self.gap_error_m.abs() < 1e-3, "gap_error_m")
    }

    /// Force at rest, N, at a current and the gap it is thought to be.
    #[must_use]
    pub fn force_at_rest_n(&self, current_a: f64, gap_m: f64) -> f64 {
        let gap = gap_m + self.gap_error_m + self.iron_path_m / (2.0 * self.permeability);
        let linear = MU_0 * self.turns * current_a / (2.0 * gap);
        let b = linear / (1.0 + (linear / self.saturation_t).powi(6)).powf(1.0 / 6.0);
        self.pull(b)
    }

    fn pull(&self, b: f64) -> f64 {
        self.pole_angle_rad.cos() * self.pole_area_m2 * b * b / MU_0
    }
}

/// A magnet that runs.
#[derive(Clone, Debug)]
pub struct Coil {
    config: CoilConfig,
    dt: f64,
    linkage: f64,
    flux_t: f64,
    current_a: f64,
    /// Weight and decay of each relaxation, how much of a ramp of B within a substep is
    /// left at its end, and the state B − x_n.
    weight: [f64; TERMS],
    keep: [f64; TERMS],
    ramp: [f64; TERMS],
    behind: [f64; TERMS],
}

impl Coil {
    /// Without current, for substeps of `dt` s.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn new(config: CoilConfig, dt: f64) -> Result<Self, PlantError> {
        config.validate()?;
        positive(dt, "dt")?;
        let mut out = Self {
            config,
            dt,
            linkage: 0.0,
            flux_t: 0.0,
            current_a: 0.0,
            weight: [0.0; TERMS],
            keep: [0.0; TERMS],
            ramp: [0.0; TERMS],
            behind: [0.0; TERMS],
        };
        if config.lamination_m > 0.0 && config.iron_path_m > 0.0 {
            let mu = MU_0 * config.permeability;
            let unit =
                (2.0 * PI / config.lamination_m).powi(2) / (config.conductivity_s_per_m * mu);
            let mut left = PI * PI / 6.0;
            let mut relax = |n: usize, weight: f64, p: f64| {
                out.weight[n] = weight;
                out.keep[n] = (-p * dt).exp();
                out.ramp[n] = (1.0 - out.keep[n]) / (p * dt);
            };
            for n in 1..TERMS {
                let square = (n * n) as f64;
                left -= 1.0 / square;
                relax(n - 1, 2.0, unit * square);
            }
            // The rest: Σ 2jω/p_n at low frequency, as one relaxation above the others.
            let p = 1.6 * unit * (TERMS * TERMS) as f64;
            relax(TERMS - 1, 2.0 * left / unit * p, p);
        }
        Ok(out)
    }

    /// What it is made of.
    #[must_use]
    pub fn config(&self) -> &CoilConfig {
        &self.config
    }

    /// Current, A.
    #[must_use]
    pub fn current_a(&self) -> f64 {
        self.current_a
    }

    /// Flux density in the gap, T.
    #[must_use]
    pub fn flux_t(&self) -> f64 {
        self.flux_t
    }

    /// Force towards the magnet, N.
    #[must_use]
    pub fn force_n(&self) -> f64 {
        self.config.pull(self.flux_t)
    }

    /// Magnetomotive force of a flux density and its slope, A and A/T, at the true gap.
    fn drive(&self, b: f64, gap: f64) -> (f64, f64) {
        let c = &self.config;
        let part = (b / c.saturation_t).abs().min(MOST).powi(6);
        let left = 1.0 - part;
        // Far below the knee three terms of the series are exact to 1e-10, at a tenth of the
        // time of the power.
        let bend = if part < 1e-3 {
            1.0 + part * (1.0 / 6.0 + part * (7.0 / 72.0 + part * (91.0 / 1296.0)))
        } else {
            left.powf(-1.0 / 6.0)
        };
        let wide = 2.0 * gap / MU_0 + c.iron_path_m / (MU_0 * c.permeability);
        let iron = c.iron_path_m / (MU_0 * c.permeability);
        // B runs straight from its last value to `b`: exact for the relaxations, whatever
        // their time against the substep.
        let (mut lag, mut stiff) = (0.0, 0.0);
        for n in 0..TERMS {
            lag +=
                self.weight[n] * (self.keep[n] * self.behind[n] + self.ramp[n] * (b - self.flux_t));
            stiff += self.weight[n] * self.ramp[n];
        }
        (
            b * bend * wide + iron * lag,
            bend / left * wide + iron * stiff,
        )
    }

    /// One substep at the mean voltage `volts` and the gap it is thought to have, m; diodes
    /// keep the current from turning round. Gives the current at its end, A.
    pub fn step(&mut self, volts: f64, gap_m: f64) -> f64 {
        let c = self.config;
        let gap = (gap_m + c.gap_error_m).max(1e-6);
        self.linkage += self.dt * (volts - c.resistance_ohm * self.current_a);
        let area = c.turns * c.pole_area_m2;
        let most = MOST * c.saturation_t;
        let mut b = self.flux_t;
        for _ in 0..8 {
            let (mmf, slope) = self.drive(b, gap);
            let off = area * b + c.leakage_h / c.turns * mmf - self.linkage;
            let by = off / (area + c.leakage_h / c.turns * slope);
            b = (b - by).clamp(-most, most);
            if by.abs() < 1e-9 {
                break;
            }
        }
        let (mmf, slope) = self.drive(b, gap);
        self.current_a = mmf / c.turns;
        if self.current_a < 0.0 {
            // Diodes block: what flux the eddy currents hold decays without the coil.
            b -= mmf / slope;
            self.current_a = 0.0;
            self.linkage = area * b;
        }
        for n in 0..TERMS {
            self.behind[n] = self.keep[n] * self.behind[n] + self.ramp[n] * (b - self.flux_t);
        }
        self.flux_t = b;
        self.current_a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.5e-6;

    /// The flux behind the current at 1, 2 and 5 kHz against diffusion into a lamination,
    /// at a coarse and a fine substep.
    #[test]
    fn flux_lags_the_current_as_diffusion_says() {
        use rarma_rigs::cers::Eddy;
        let config = CoilConfig {
            saturation_t: 3.0,
            ..CoilConfig::default()
        };
        let eddy = Eddy {
            lamination_m: config.lamination_m,
            conductivity_s_per_m: config.conductivity_s_per_m,
            permeability: config.permeability,
            iron_path_m: config.iron_path_m,
            gap_m: 150e-6,
        };
        for dt in [0.5e-6, 3.125e-6] {
            for f in [1e3, 2e3, 5e3] {
                let mut coil = Coil::new(config, dt).expect("valid");
                let periods = (0.02 / dt).round() as usize;
                let (mut i, mut b) = ([0.0; 2], [0.0; 2]);
                for n in 0..3 * periods {
                    let t = n as f64 * dt;
                    let current = coil.step(4.0 * 0.8 + 2.0 * (2.0 * PI * f * t).sin(), 150e-6);
                    if n >= 2 * periods {
                        let (s, c) = (2.0 * PI * f * t).sin_cos();
                        i = [i[0] + current * c, i[1] - current * s];
                        b = [b[0] + coil.flux_t() * c, b[1] - coil.flux_t() * s];
                    }
                }
                let size = b[0].hypot(b[1]) / i[0].hypot(i[1]);
                let angle = b[1].atan2(b[0]) - i[1].atan2(i[0]);
                let rest = MU_0 * config.turns / (2.0 * 170e-6);
                let g = eddy.flux(f);
                assert!(
                    (size / rest / g.abs() - 1.0).abs() < 0.004,
                    "{dt} {f}: {size}"
                );
                let off = (angle - g.im.atan2(g.re)).to_degrees();
                assert!(off.abs() < 0.25, "{dt} {f}: {off}");
            }
        }
    }

    #[test]
    fn a_voltage_held_gives_ohms_current_and_the_static_force() {
        for volts in [2.0, 6.0, 11.0] {
            let mut coil = Coil::new(CoilConfig::default(), DT).expect("valid");
            for _ in 0..60_000 {
                coil.step(volts, 150e-6);
            }
            assert!(
                (coil.current_a() - volts / 4.0).abs() < 1e-4,
                "{}",
                coil.current_a()
            );
            let law = coil.config().force_at_rest_n(coil.current_a(), 150e-6);
            assert!((coil.force_n() / law - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn work_of_the_terminals_is_the_energy_of_the_field() {
        // Ideal iron: ½·L·i² with L = Lσ + 2k/s; and turned off by −48 V in 70 µs.
        let config = CoilConfig {
            iron_path_m: 0.0,
            leakage_h: 0.0,
            saturation_t: 3.0,
            ..CoilConfig::default()
        };
        let mut coil = Coil::new(config, DT).expect("valid");
        let mut work = 0.0;
        while coil.current_a() < 0.8 {
            let before = coil.current_a();
            let after = coil.step(48.0, 150e-6);
            work += DT * 0.5 * (before + after) * (48.0 - 4.0 * 0.5 * (before + after));
        }
        assert!((work / 1.34e-3 - 1.0).abs() < 0.02, "{work}");
        let mut off = 0.0;
        while coil.current_a() > 0.0 {
            coil.step(-48.0, 150e-6);
            off += DT;
        }
        println!("0.8 A to nothing at 48 V: {:.1} µs", 1e6 * off);
        assert!((62e-6..74e-6).contains(&off), "{off}");
    }

    #[test]
    fn motion_induces_the_constant_of_the_force() {
        // At constant current u = R·i + (2k·i/s²)·(−ds/dt) for ideal iron: at 0.8 A and
        // 150 µm 22.3 V·s/m, the force constant of one coil over cos α.
        let config = CoilConfig {
            iron_path_m: 0.0,
            leakage_h: 0.0,
            saturation_t: 3.0,
            ..CoilConfig::default()
        };
        let mut coil = Coil::new(config, DT).expect("valid");
        while coil.current_a() < 0.8 {
            coil.step(48.0, 150e-6);
        }
        // Short enough for the current to stay: flux linkage must follow the voltage.
        let (before, amps, gap) = (coil.linkage, coil.current_a(), 149e-6);
        let slope = -1e-6 / (40.0 * DT);
        for n in 1..=40 {
            let s = 150e-6 + slope * DT * f64::from(n);
            let emf = 2.0 * 3.1416e-7 * amps / (s * s) * -slope;
            coil.step(4.0 * amps + emf, s);
        }
        assert!((coil.current_a() / amps - 1.0).abs() < 1e-4, "{amps}");
        assert!((coil.linkage / before - 150e-6 / gap).abs() < 1e-3);
    }

    #[test]
    fn diodes_keep_the_current_from_turning() {
        let mut coil = Coil::new(CoilConfig::default(), DT).expect("valid");
        for _ in 0..200 {
            coil.step(48.0, 150e-6);
        }
        for _ in 0..4000 {
            assert!(coil.step(-48.0, 150e-6) >= 0.0);
        }
        assert_eq!(coil.current_a(), 0.0);
        assert!(coil.flux_t() < 1e-6);
    }
}
