//! The computational model's answers: frequencies against load, shapes, deflection.

use rarma_plants::els::link::LinkLaw;
use rarma_plants::els::{ElsConfig, ElsModel, ElsModelError, NaturalMode, Place, Shape};
use serde::Serialize;

/// Directions of the deflection diagram.
const DIRECTIONS: usize = 72;
/// Stiffness of a link that grounds the tip, over that of the tip itself.
const GROUNDED: f64 = 1e4;

/// A natural frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Frequency {
    /// Hz.
    pub f: f64,
    /// Damping ratio from the loss factors.
    pub zeta: f64,
    /// `bending` or `torsion`.
    pub shape: &'static str,
}

/// Natural frequencies under one load.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadCase {
    /// Load of the link, N.
    pub load_n: f64,
    /// Its stiffness along its axis, N/µm.
    pub link_n_per_um: f64,
    /// By rising frequency.
    pub modes: Vec<Frequency>,
}

/// A mode's picture.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// Hz.
    pub f: f64,
    /// `bending` or `torsion`.
    pub shape: &'static str,
    /// Nodes of the holder: m from the tool joint, x, y, twist·radius scale, largest 1.
    pub holder: Vec<[f64; 4]>,
    /// Nodes of the spindle.
    pub spindle: Vec<[f64; 4]>,
}

/// Deflection all round under one load, µm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DeflectionCase {
    /// Load, N.
    pub load_n: f64,
    /// Directions, degrees from x towards y.
    pub angle_deg: Vec<f64>,
    /// At the tool joint, its own compliance included.
    pub tool_joint_um: Vec<f64>,
    /// Half-way up the holder.
    pub middle_um: Vec<f64>,
    /// At the front bearing; empty without a spindle.
    pub bearing_um: Vec<f64>,
}

fn name(shape: Shape) -> &'static str {
    match shape {
        Shape::Bending => "bending",
        Shape::Torsion => "torsion",
    }
}

/// Natural frequencies under each load.
///
/// # Errors
/// As [`ElsModel::natural_modes`].
pub fn load_cases(
    model: &ElsModel,
    link: &rarma_plants::els::link::Link,
    loads_n: &[f64],
    count: usize,
) -> Result<Vec<LoadCase>, ElsModelError> {
    loads_n
        .iter()
        .map(|&load_n| {
            let modes = model.natural_modes(load_n, count)?;
            Ok(LoadCase {
                load_n,
                link_n_per_um: 1e-6 * link.along_n_per_m(load_n)?,
                modes: modes
                    .iter()
                    .map(|m| Frequency {
                        f: m.f_hz,
                        zeta: m.zeta,
                        shape: name(m.shape),
                    })
                    .collect(),
            })
        })
        .collect()
}

/// The lowest modes with the tip free, and with it grounded.
///
/// # Errors
/// As [`ElsModel::natural_modes`] and [`ElsModel::compliances`].
pub fn shapes(
    config: &ElsConfig,
    count: usize,
) -> Result<(Vec<Picture>, Vec<Picture>), ElsModelError> {
    let with = |law: LinkLaw| -> Result<Vec<Picture>, ElsModelError> {
        let mut changed = config.clone();
        changed.link.law = law;
        if law != LinkLaw::Constant(0.0) {
            changed.link.across = 1.0;
        }
        let model = ElsModel::new(&changed)?;
        Ok(model
            .natural_modes(0.0, count)?
            .iter()
            .map(picture)
            .collect())
    };
    let tip = ElsModel::new(config)?.compliances(&[Place::Holder(0.0)])?[0];
    let grounded = GROUNDED / (0.5 * tip.trace());
    Ok((
        with(LinkLaw::Constant(0.0))?,
        with(LinkLaw::Constant(grounded))?,
    ))
}

fn picture(mode: &NaturalMode) -> Picture {
    let across = mode
        .nodes
        .iter()
        .fold(0.0, |m: f64, n| m.max(n[1].hypot(n[2])));
    let twist = mode.nodes.iter().fold(0.0, |m: f64, n| m.max(n[3].abs()));
    let torsion = mode.shape == Shape::Torsion;
    let scaled = |n: &[f64; 4]| {
        let one = |x: f64, most: f64| if most > 0.0 { x / most } else { 0.0 };
        if torsion {
            [n[0], 0.0, 0.0, one(n[3], twist)]
        } else {
            [n[0], one(n[1], across), one(n[2], across), 0.0]
        }
    };
    let (holder, spindle) = mode.nodes.split_at(mode.holder_nodes);
    Picture {
        f: mode.f_hz,
        shape: name(mode.shape),
        holder: holder.iter().map(scaled).collect(),
        spindle: spindle.iter().map(scaled).collect(),
    }
}

/// Deflection at tool joint, middle of the holder and front bearing for each load, all
/// round.
///
/// # Errors
/// As [`ElsModel::compliances`].
pub fn deflections(
    model: &ElsModel,
    middle_m: f64,
    bearing_m: Option<f64>,
    loads_n: &[f64],
) -> Result<Vec<DeflectionCase>, ElsModelError> {
    let mut places = vec![Place::Holder(middle_m)];
    places.extend(bearing_m.map(Place::Spindle));
    let compliances = model.compliances(&places)?;
    let tool_joint = model.tool_joint_compliance()?;
    let angles: Vec<f64> = (0..DIRECTIONS)
        .map(|k| 360.0 * k as f64 / DIRECTIONS as f64)
        .collect();
    loads_n
        .iter()
        .map(|&load_n| {
            let around = |c: &_| -> Result<Vec<f64>, ElsModelError> {
                angles
                    .iter()
                    .map(|a| Ok(1e6 * ElsModel::deflection(c, load_n, a.to_radians())?.total_m()))
                    .collect()
            };
            Ok(DeflectionCase {
                load_n,
                angle_deg: angles.clone(),
                tool_joint_um: around(&tool_joint)?,
                middle_um: around(&compliances[0])?,
                bearing_um: compliances.get(1).map_or(Ok(Vec::new()), around)?,
            })
        })
        .collect()
}
