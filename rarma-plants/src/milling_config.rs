//! What a milling cut is described by: arc of engagement, cutter, coefficients,
//! structure, timeline.

use super::error::{PlantError, non_negative, positive, require};
use super::modal::{Mode, ShapedMode};
use super::process::{Contact, ForceNoise, ProcessDamping, Schedule, Wear};
use super::variation::SpeedVariation;
use super::workpiece::Workpiece;
use core::f64::consts::{PI, TAU};

/// Arc of the cut, angles from +y clockwise, 0 ≤ entry < exit ≤ π.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engagement {
    /// Angle at which a tooth enters, rad.
    pub entry_rad: f64,
    /// Angle at which it leaves, rad.
    pub exit_rad: f64,
}

impl Engagement {
    /// Full immersion.
    pub const SLOT: Self = Self {
        entry_rad: 0.0,
        exit_rad: PI,
    };

    /// Up-milling with radial immersion `a` = width of cut over diameter, 0 to 1:
    /// from 0 to acos(1-2a).
    #[must_use]
    pub fn up(a: f64) -> Self {
        Self {
            entry_rad: 0.0,
            exit_rad: (1.0 - 2.0 * a).acos(),
        }
    }

    /// Down-milling with radial immersion `a`: from acos(2a-1) to π.
    #[must_use]
    pub fn down(a: f64) -> Self {
        Self {
            entry_rad: (2.0 * a - 1.0).acos(),
            exit_rad: PI,
        }
    }

    /// Part of the cell centred on `angle` that lies in the arc, 0 to 1. The
    /// halves at the ends make the sum over cells the trapezoidal rule.
    pub(super) fn weight(&self, angle: f64, cell: f64) -> f64 {
        [-TAU, 0.0, TAU]
            .iter()
            .map(|turn| {
                let low = (angle + turn - 0.5 * cell).max(self.entry_rad);
                let high = (angle + turn + 0.5 * cell).min(self.exit_rad);
                (high - low).max(0.0) / cell
            })
            .sum::<f64>()
            .min(1.0)
    }
}

/// Configuration of [`Milling`](super::milling::Milling). SI units throughout.
#[derive(Clone, Debug, PartialEq)]
pub struct MillingConfig {
    /// Number of teeth, ≥ 1.
    pub teeth: usize,
    /// Pitch from each tooth to the next, rad, one per tooth, summing to 2π;
    /// empty: equal. Rounded to whole cells.
    pub pitch_rad: Vec<f64>,
    /// Radial runout of each tooth, m; empty: none.
    pub runout_m: Vec<f64>,
    /// Spindle frequency, Hz, > 0; the nominal one if there is a schedule.
    pub spindle_hz: f64,
    /// Spindle frequency over time, Hz, if it changes: between half and twice the
    /// nominal one.
    pub speed: Option<Schedule>,
    /// Swing of the speed about that, if any; its frequency is RVF times the nominal one.
    pub variation: Option<SpeedVariation>,
    /// Feed per tooth in +x, m, ≥ 0 (mean over the teeth).
    pub feed_per_tooth_m: f64,
    /// Tangential cutting coefficient Kt, N/m², > 0.
    pub kt_n_per_m2: f64,
    /// Radial cutting coefficient Kn, N/m², ≥ 0.
    pub kn_n_per_m2: f64,
    /// Tangential edge coefficient, N/m, ≥ 0.
    pub kt_edge_n_per_m: f64,
    /// Radial edge coefficient, N/m, ≥ 0.
    pub kn_edge_n_per_m: f64,
    /// Arc of the cut.
    pub engagement: Engagement,
    /// Diameter of the cutter, m, > 0. Only helix, torsion and workpieces ask for it.
    pub diameter_m: f64,
    /// Helix angle of the edges, rad, 0 to below π/2.
    pub helix_rad: f64,
    /// Modes in x (feed).
    pub modes_x: Vec<Mode>,
    /// Modes in y.
    pub modes_y: Vec<Mode>,
    /// Modes of any other shape: skew bending, torsion.
    pub modes_other: Vec<ShapedMode>,
    /// Axial depth over time.
    pub depth: Schedule,
    /// Stock with its ends and gaps; `None`: material everywhere in the arc.
    pub workpiece: Option<Workpiece>,
    /// Wear of the edges.
    pub wear: Wear,
    /// Flank rubbing, if any.
    pub process_damping: Option<ProcessDamping>,
    /// Broadband excitation.
    pub noise: ForceNoise,
    /// Loss of contact, or the linear equation.
    pub contact: Contact,
    /// Least integration rate, Hz, > 0. The rate used is the next one up with a
    /// whole number of steps per mean tooth period. 50 steps per period of the
    /// fastest mode that matters keep limits within about 1 %.
    pub min_step_rate_hz: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for MillingConfig {
    /// Two equal teeth, a slot in air at 10 000 rpm on a rigid machine.
    fn default() -> Self {
        Self {
            teeth: 2,
            pitch_rad: Vec::new(),
            runout_m: Vec::new(),
            spindle_hz: 10_000.0 / 60.0,
            speed: None,
            variation: None,
            feed_per_tooth_m: 0.0,
            kt_n_per_m2: 6.0e8,
            kn_n_per_m2: 2.0e8,
            kt_edge_n_per_m: 0.0,
            kn_edge_n_per_m: 0.0,
            engagement: Engagement::SLOT,
            diameter_m: 0.02,
            helix_rad: 0.0,
            modes_x: Vec::new(),
            modes_y: Vec::new(),
            modes_other: Vec::new(),
            depth: Schedule::constant(0.0),
            workpiece: None,
            wear: Wear::default(),
            process_damping: None,
            noise: ForceNoise::default(),
            contact: Contact::Real,
            min_step_rate_hz: 96_000.0,
            seed: 0,
        }
    }
}

impl MillingConfig {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` or `WrongLength` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        require(self.teeth >= 1, "teeth")?;
        let per_tooth = |n: usize| n == 0 || n == self.teeth;
        if !per_tooth(self.pitch_rad.len()) {
            return Err(PlantError::WrongLength { name: "pitch_rad" });
        }
        if !per_tooth(self.runout_m.len()) {
            return Err(PlantError::WrongLength { name: "runout_m" });
        }
        if !self.pitch_rad.is_empty() {
            require(self.pitch_rad.iter().all(|p| *p > 0.0), "pitch_rad")?;
            require(
                (self.pitch_rad.iter().sum::<f64>() - TAU).abs() < 1e-6,
                "pitch_rad",
            )?;
        }
        require(self.runout_m.iter().all(|r| r.is_finite()), "runout_m")?;
        positive(self.spindle_hz, "spindle_hz")?;
        non_negative(self.feed_per_tooth_m, "feed_per_tooth_m")?;
        positive(self.kt_n_per_m2, "kt_n_per_m2")?;
        non_negative(self.kn_n_per_m2, "kn_n_per_m2")?;
        non_negative(self.kt_edge_n_per_m, "kt_edge_n_per_m")?;
        non_negative(self.kn_edge_n_per_m, "kn_edge_n_per_m")?;
        let e = self.engagement;
        require(e.entry_rad >= 0.0 && e.entry_rad < e.exit_rad, "engagement")?;
        require(e.exit_rad <= PI + 1e-9, "engagement")?;
        positive(self.diameter_m, "diameter_m")?;
        require((0.0..1.55).contains(&self.helix_rad), "helix_rad")?;
        for shape in &self.modes_other {
            shape.validate()?;
        }
        self.depth.validate()?;
        if let Some(speed) = &self.speed {
            let named = |_| PlantError::OutOfRange { name: "speed" };
            speed.validate().map_err(named)?;
            require(speed.smallest() >= 0.5 * self.spindle_hz, "speed")?;
            require(speed.largest() <= 2.0 * self.spindle_hz, "speed")?;
        }
        if let Some(variation) = &self.variation {
            variation.validate()?;
        }
        if let Some(piece) = &self.workpiece {
            piece.validate()?;
        }
        self.wear.validate()?;
        if let Some(p) = &self.process_damping {
            p.validate()?;
        }
        self.noise.validate()?;
        positive(self.min_step_rate_hz, "min_step_rate_hz")
    }

    /// Spindle frequency at time `t` s, Hz.
    #[must_use]
    pub fn spindle_at(&self, t: f64) -> f64 {
        let swing = self.variation.map(|v| v.factor(self.spindle_hz, t));
        self.carrier_at(t) * swing.unwrap_or(1.0)
    }

    /// The same without its swing.
    #[must_use]
    pub fn carrier_at(&self, t: f64) -> f64 {
        self.speed.as_ref().map_or(self.spindle_hz, |s| s.at(t))
    }

    /// Lowest and highest spindle frequency there will be without its swing, Hz.
    #[must_use]
    pub fn carriers_hz(&self) -> (f64, f64) {
        self.speed
            .as_ref()
            .map_or((self.spindle_hz, self.spindle_hz), |s| {
                (s.smallest(), s.largest())
            })
    }

    /// Lowest spindle frequency there will be, Hz.
    #[must_use]
    pub fn slowest_hz(&self) -> f64 {
        self.carriers_hz().0 * (1.0 - self.variation.map_or(0.0, |v| v.amplitude))
    }

    /// Highest spindle frequency there will be, Hz.
    #[must_use]
    pub fn fastest_hz(&self) -> f64 {
        self.carriers_hz().1 * (1.0 + self.variation.map_or(0.0, |v| v.amplitude))
    }

    /// All modes with their shapes: x, then y, then the others.
    #[must_use]
    pub fn shaped_modes(&self) -> Vec<ShapedMode> {
        let x = self.modes_x.iter().map(|m| ShapedMode::along_x(*m));
        let y = self.modes_y.iter().map(|m| ShapedMode::along_y(*m));
        x.chain(y).chain(self.modes_other.iter().copied()).collect()
    }

    /// Angle by which the edge at height `z_m` trails its tip, rad.
    #[must_use]
    pub fn helix_lag_rad(&self, z_m: f64) -> f64 {
        2.0 * z_m * self.helix_rad.tan() / self.diameter_m
    }

    /// Feed during one radian of rotation, m/rad. A cutter that has turned ahead
    /// by ϑ meets each angle ϑ/Ω earlier, when the feed was this times ϑ shorter:
    /// so torsion changes the chip.
    #[must_use]
    pub fn feed_ahead_m_per_rad(&self) -> f64 {
        self.feed_per_tooth_m * self.teeth as f64 / TAU
    }

    /// Tooth-passing frequency (mean over unequal pitches), Hz.
    #[must_use]
    pub fn tooth_hz(&self) -> f64 {
        self.spindle_hz * self.teeth as f64
    }
}
