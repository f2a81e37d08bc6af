//! The truth about a scenario, as the JSON of `rarma simulate --truth` spells it.

use crate::error::ScenarioError;
use crate::scenario::Loaded;
use rarma_plants::delay::{Crossing, Root};
use rarma_plants::error::PlantError;
use rarma_plants::modal::ShapedMode;
use rarma_plants::truth::Truth;
use serde::Serialize;

/// A mode of the structure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModeTruth {
    /// Undamped natural frequency, Hz.
    pub f: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Modal stiffness, N/m.
    pub stiffness: f64,
    /// Shape at the tool: x, y, rotation (rad/m).
    pub shape: [f64; 3],
}

/// A root of the delay equation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RootTruth {
    /// Undamped frequency of its strongest component, Hz.
    pub f: f64,
    /// Operational damping ratio; negative: growing.
    pub zeta: f64,
    /// Growth rate, 1/s.
    pub growth: f64,
    /// Floquet multiplier, real and imaginary part.
    pub multiplier: [f64; 2],
    /// Share of the power in the strongest component.
    pub purity: f64,
}

/// Roots at one condition.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OperationalTruth {
    /// Time, s.
    pub t_s: f64,
    /// Depth, mm.
    pub depth_mm: f64,
    /// Spindle speed, 1/min.
    pub speed_rpm: f64,
    /// Dominant roots, the least damped first.
    pub roots: Vec<RootTruth>,
}

/// The stability limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LimitTruth {
    /// Depth, mm.
    pub depth_mm: f64,
    /// `hopf`, `flip` or `fold`.
    pub crossing: &'static str,
    /// Chatter frequency, Hz.
    pub chatter_hz: f64,
}

/// Everything.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TruthRecord {
    /// Name of the scenario.
    pub scenario: String,
    /// Length, s.
    pub duration_s: f64,
    /// Nominal spindle speed, 1/min.
    pub speed_rpm: f64,
    /// Nominal spindle frequency, Hz.
    pub spindle_hz: f64,
    /// Teeth.
    pub teeth: usize,
    /// Tooth-passing frequency, Hz.
    pub tooth_hz: f64,
    /// First tooth at +y at time 0; then one every 1/`tooth_hz` s (mean pitch).
    pub first_tooth_s: f64,
    /// Modes of the structure.
    pub modes: Vec<ModeTruth>,
    /// The limit at the nominal speed.
    pub limit: Option<LimitTruth>,
    /// Why there is none, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_limit: Option<String>,
    /// The zero-order limit beside it, mm.
    pub zero_order_mm: Option<f64>,
    /// First instability, s.
    pub onset_s: Option<f64>,
    /// Last end of it, s.
    pub end_s: Option<f64>,
    /// Time in the cut, s.
    pub cut_s: Option<[f64; 2]>,
    /// Times on which a gap of the workpiece lies in front of the cutter, s.
    pub interrupted_s: Vec<[f64; 2]>,
    /// Roots while it cuts.
    pub operational: Vec<OperationalTruth>,
}

/// The word for a crossing.
pub fn crossing_word(crossing: Crossing) -> &'static str {
    match crossing {
        Crossing::Hopf => "hopf",
        Crossing::Flip => "flip",
        Crossing::Fold => "fold",
    }
}

impl TruthRecord {
    /// Works it out.
    ///
    /// # Errors
    /// What the plant refuses, in a line.
    pub fn of(loaded: &Loaded) -> Result<Self, ScenarioError> {
        let scenario = &loaded.scenario;
        let truth = scenario.truth().map_err(|why| {
            ScenarioError::whole(&scenario.name, why, "correct the fields it names")
        })?;
        Ok(Self::from(
            scenario.name.clone(),
            scenario.duration_s,
            &truth,
        ))
    }

    /// From the plant's own record.
    pub fn from(scenario: String, duration_s: f64, truth: &Truth) -> Self {
        Self {
            scenario,
            duration_s,
            speed_rpm: 60.0 * truth.spindle_hz,
            spindle_hz: truth.spindle_hz,
            teeth: truth.teeth,
            tooth_hz: truth.tooth_hz,
            first_tooth_s: 0.0,
            modes: truth.modes.iter().map(mode).collect(),
            limit: truth.limit.map(|l| LimitTruth {
                depth_mm: 1e3 * l.depth_m,
                crossing: crossing_word(l.crossing),
                chatter_hz: l.root.f_hz,
            }),
            no_limit: truth.no_limit.map(|why| match why {
                PlantError::NoLimit => {
                    "none between 1 % and four times the largest depth".to_owned()
                }
                why => why.to_string(),
            }),
            zero_order_mm: truth.zero_order_m.map(|d| 1e3 * d),
            onset_s: truth.onset_s,
            end_s: truth.end_s,
            cut_s: truth.cut_s.map(|(a, b)| [a, b]),
            interrupted_s: truth.interrupted_s.iter().map(|(a, b)| [*a, *b]).collect(),
            operational: truth
                .operational
                .iter()
                .map(|o| OperationalTruth {
                    t_s: o.t_s,
                    depth_mm: 1e3 * o.depth_m,
                    speed_rpm: 60.0 * o.spindle_hz,
                    roots: o.roots.iter().map(root).collect(),
                })
                .collect(),
        }
    }
}

fn mode(m: &ShapedMode) -> ModeTruth {
    ModeTruth {
        f: m.mode.f_hz,
        zeta: m.mode.zeta,
        stiffness: m.mode.stiffness_n_per_m,
        shape: [m.x, m.y, m.turn_rad_per_m],
    }
}

fn root(r: &Root) -> RootTruth {
    RootTruth {
        f: r.f_hz,
        zeta: r.zeta,
        growth: r.growth_per_s,
        multiplier: [r.multiplier.0, r.multiplier.1],
        purity: r.purity,
    }
}
