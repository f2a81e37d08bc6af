//! Limits and stiffness all round, from a receptance tensor.

use rarma_rigs::els::{
    CutConfig, ElsError, Limit, PolarPoint, Receptance, extremes, polar_limits, reciprocity,
    static_stiffness,
};
use serde::Serialize;

/// Directions of a diagram.
pub const DIRECTIONS: usize = 72;

/// Compliance over the largest receptance below which a direction is rigid: rounding.
const RIGID: f64 = 1e-12;

/// What is cut, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// Cutting coefficients, SI.
    pub config: CutConfig<f64>,
    /// Where the chip thickness is measured, rad from the force.
    pub chip_angle_rad: f64,
    /// Replace both cross receptances by their mean.
    pub symmetrise: bool,
}

/// One direction of the force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Direction {
    /// From u towards v, degrees.
    pub angle_deg: f64,
    /// Limiting width of cut, mm; null where there is none.
    pub width_mm: Option<f64>,
    /// Frequency of the chatter there, Hz.
    pub chatter_hz: Option<f64>,
    /// Static stiffness along this direction, N/µm, where the band tells it.
    pub stiffness_n_per_um: Option<f64>,
    /// Its standard deviation.
    pub stiffness_sd_n_per_um: Option<f64>,
}

/// Limits all round and what is remarkable about them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagram {
    /// Specific cutting stiffness, N/mm².
    pub ks_n_per_mm2: f64,
    /// Teeth in the cut on average.
    pub teeth_in_cut: f64,
    /// Overlap factor.
    pub overlap: f64,
    /// Angle from the force to the chip thickness, degrees.
    pub chip_angle_deg: f64,
    /// Distance of the cross receptances from reciprocity, 0 to 1; null without both.
    pub reciprocity: Option<f64>,
    /// Whether they were replaced by their mean.
    pub symmetrised: bool,
    /// By direction, over a whole turn.
    pub polar: Vec<Direction>,
    /// Direction of the largest limit.
    pub best: Direction,
    /// Direction of the smallest.
    pub worst: Direction,
}

/// Computes a diagram. `both_cross` says that both cross receptances were measured;
/// `static_band_hz` is where the static stiffness is read, if anywhere.
///
/// # Errors
/// As [`polar_limits`].
pub fn diagram(
    f: &[f64],
    g: &[Receptance<f64>],
    cut: &Cut,
    both_cross: bool,
    static_band_hz: Option<(f64, f64)>,
) -> Result<Diagram, ElsError> {
    let apart = reciprocity(g)?;
    let mean: Vec<Receptance<f64>>;
    let g = if cut.symmetrise {
        mean = g.iter().map(Receptance::symmetrised).collect();
        &mean
    } else {
        g
    };
    let largest = g.iter().fold(0.0, |m: f64, g| m.max(g.largest()));
    let mut points = [PolarPoint::default(); DIRECTIONS];
    polar_limits(f, g, cut.config, cut.chip_angle_rad, &mut points)?;
    let direction = |p: &PolarPoint<f64>| {
        let (width_mm, chatter_hz) = match p.limit {
            Limit::Width {
                width_m,
                chatter_hz,
            } => (Some(1e3 * width_m), Some(chatter_hz)),
            Limit::Unlimited => (None, None),
        };
        let along: Vec<_> = g.iter().map(|g| g.directional(p.angle, p.angle)).collect();
        let k = static_band_hz
            .and_then(|(low, high)| static_stiffness(f, &along, low, high).ok())
            .filter(|k| k.compliance_m_per_n > RIGID * largest);
        Direction {
            angle_deg: p.angle.to_degrees(),
            width_mm,
            chatter_hz,
            stiffness_n_per_um: k.map(|k| 1e-6 * k.n_per_m),
            stiffness_sd_n_per_um: k.map(|k| 1e-6 * k.sd_n_per_m),
        }
    };
    let ends = extremes(&points).ok_or(ElsError::TooFewLines { needed: 1 })?;
    Ok(Diagram {
        ks_n_per_mm2: 1e-6 * cut.config.ks_n_per_m2,
        teeth_in_cut: cut.config.teeth_in_cut,
        overlap: cut.config.overlap,
        chip_angle_deg: cut.chip_angle_rad.to_degrees(),
        reciprocity: both_cross.then_some(apart.distance),
        symmetrised: cut.symmetrise,
        polar: points.iter().map(direction).collect(),
        best: direction(&ends.best),
        worst: direction(&ends.worst),
    })
}
