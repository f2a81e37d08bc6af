//! Stiffness of joints and bearings from what was measured: load steps of a loaded ball
//! bar, receptances of an exciter.
//!
//! A load at the tip alone cannot tell two springs in series apart; receptances can,
//! since each mode bends them differently. What the data do not determine is refused.

use super::assembly::ElsModel;
use super::config::{Clamping, ElsConfig, Place};
use super::error::{ElsModelError, check};
use super::ring::Ring;
use nalgebra::{DMatrix, DVector, Vector2};
use rarma_rigs::els::Receptance;
use std::fmt;

/// Deflection along the load under one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadStep {
    /// Direction of load and gauge, rad from x towards y.
    pub angle_rad: f64,
    /// Load, N.
    pub load_n: f64,
    /// Change of length that the gauge shows, m; its zero does not matter.
    pub deflection_m: f64,
}

/// Compliance of one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compliance {
    /// Direction, rad.
    pub angle_rad: f64,
    /// Along the load, m/N.
    pub m_per_n: f64,
    /// Standard deviation, m/N.
    pub sd_m_per_n: f64,
}

/// A receptance tensor at the tip at one frequency, no load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Frequency, Hz.
    pub f_hz: f64,
    /// What was measured, m/N.
    pub g: Receptance<f64>,
    /// Standard deviation of each part, m/N, > 0.
    pub sd: f64,
}

/// A stiffness that is sought; the model's own is where the search starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Radial stiffness of a joint, both axes alike.
    Joint(usize),
    /// Tilt stiffness of a joint.
    JointTilt(usize),
    /// Larger radial stiffness of a bearing.
    BearingMajor(usize),
    /// Smaller radial stiffness of a bearing.
    BearingMinor(usize),
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joint(k) => write!(f, "joint[{k}].radial"),
            Self::JointTilt(k) => write!(f, "joint[{k}].tilt"),
            Self::BearingMajor(k) => write!(f, "bearing[{k}].major"),
            Self::BearingMinor(k) => write!(f, "bearing[{k}].minor"),
        }
    }
}

/// One stiffness found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Which.
    pub unknown: Unknown,
    /// N/m, or N·m/rad for a tilt stiffness.
    pub value: f64,
    /// Its standard deviation, same unit.
    pub sd: f64,
}

/// A fitted model.
#[derive(Clone, Debug, PartialEq)]
pub struct JointFit {
    /// The system with the stiffnesses found.
    pub config: ElsConfig,
    /// Them, in the order asked for.
    pub found: Vec<Found>,
    /// Root mean square of the residuals in their standard deviations: 1 for a model that
    /// is right and data as good as they are said to be.
    pub misfit: f64,
    /// Steps taken.
    pub rounds: u32,
}

/// Slope of deflection over load in each direction, by least squares with a zero of its
/// own per direction; the noise is common to all and comes from the residuals.
///
/// # Errors
/// A value that is not finite; a direction with fewer than two loads, or no direction with
/// three (there is no residual then).
pub fn compliances(steps: &[LoadStep]) -> Result<Vec<Compliance>, ElsModelError> {
    let finite = |s: &LoadStep| {
        s.angle_rad.is_finite() && s.load_n.is_finite() && s.deflection_m.is_finite()
    };
    check(steps.iter().all(finite), "load step")?;
    let mut angles: Vec<f64> = steps.iter().map(|s| s.angle_rad).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|b, a| (*b - *a).abs() < 1e-9);
    let (mut out, mut spread) = (Vec::new(), Vec::new());
    let (mut squares, mut spare) = (0.0, 0.0);
    for angle_rad in angles {
        let here: Vec<&LoadStep> = steps
            .iter()
            .filter(|s| (s.angle_rad - angle_rad).abs() < 1e-9)
            .collect();
        let n = here.len() as f64;
        let load = here.iter().map(|s| s.load_n).sum::<f64>() / n;
        let moved = here.iter().map(|s| s.deflection_m).sum::<f64>() / n;
        let sff: f64 = here.iter().map(|s| (s.load_n - load).powi(2)).sum();
        check(
            sff > 0.0,
            "number of different loads in a direction (at least 2)",
        )?;
        let m_per_n = here
            .iter()
            .map(|s| (s.load_n - load) * (s.deflection_m - moved))
            .sum::<f64>()
            / sff;
        squares += here
            .iter()
            .map(|s| (s.deflection_m - moved - m_per_n * (s.load_n - load)).powi(2))
            .sum::<f64>();
        spare += n - 2.0;
        spread.push(sff);
        out.push(Compliance {
            angle_rad,
            m_per_n,
            sd_m_per_n: 0.0,
        });
    }
    check(
        spare > 0.0,
        "number of loads in a direction (at least 3 in one)",
    )?;
    for (c, sff) in out.iter_mut().zip(spread) {
        c.sd_m_per_n = (squares / spare / sff).sqrt();
    }
    Ok(out)
}

/// Finds the stiffnesses by weighted least squares over compliances and receptances, in
/// the logarithm of each (so none becomes negative), by Levenberg and Marquardt with
/// differences for derivatives.
///
/// # Errors
/// Data or unknowns out of range; `Singular` where the data do not determine an unknown
/// (a change by a factor of e shows less than its own noise); as [`ElsModel::new`].
pub fn fit_joints(
    start: &ElsConfig,
    unknowns: &[Unknown],
    statics: &[Compliance],
    lines: &[Line],
) -> Result<JointFit, ElsModelError> {
    check(!unknowns.is_empty(), "unknowns")?;
    let sound = statics.iter().all(|c| c.sd_m_per_n > 0.0) && lines.iter().all(|l| l.sd > 0.0);
    check(sound, "standard deviation of a measurement")?;
    let count = statics.len() + 8 * lines.len();
    check(count > unknowns.len(), "number of measurements")?;
    let residuals = |x: &DVector<f64>| residuals(start, unknowns, x, statics, lines);
    let mut x = DVector::zeros(unknowns.len());
    let mut r = residuals(&x)?;
    let (mut damping, mut rounds) = (1e-2, 0);
    let mut jacobian = slopes(&x, &residuals)?;
    'search: while rounds < 60 {
        rounds += 1;
        let normal = jacobian.transpose() * &jacobian;
        let gradient = jacobian.transpose() * &r;
        loop {
            let mut damped = normal.clone();
            for i in 0..unknowns.len() {
                damped[(i, i)] *= 1.0 + damping;
                damped[(i, i)] += 1e-12;
            }
            let step = damped.lu().solve(&-&gradient);
            let step = step.ok_or(ElsModelError::Singular { free: 1 })?;
            let step = step.map(|s| s.clamp(-1.0, 1.0));
            let trial = &x + &step;
            if let Ok(next) = residuals(&trial)
                && next.norm_squared() < r.norm_squared()
            {
                let gained = 1.0 - next.norm_squared() / r.norm_squared();
                (x, r) = (trial, next);
                jacobian = slopes(&x, &residuals)?;
                damping = (damping / 10.0_f64).max(1e-9);
                if gained < 1e-10 {
                    break 'search;
                }
                break;
            }
            damping *= 5.0;
            if damping > 1e6 {
                break 'search;
            }
        }
    }
    let spare = (r.len() - unknowns.len()) as f64;
    let misfit = (r.norm_squared() / spare).sqrt();
    // By singular values: the inverse of a normal matrix hides what is not determined.
    let singular = jacobian.svd(false, true);
    let turned = singular.v_t.ok_or(ElsModelError::Singular { free: 1 })?;
    let sd = |i: usize| {
        let parts = turned.column(i).component_div(&singular.singular_values);
        parts.norm() * misfit.max(1.0)
    };
    let free = (0..unknowns.len()).filter(|&i| !(sd(i) < 1.0)).count();
    if free > 0 {
        return Err(ElsModelError::Singular { free });
    }
    let config = changed(start, unknowns, &x)?;
    let found = unknowns
        .iter()
        .enumerate()
        .map(|(i, &unknown)| {
            let value = *stiffness(&mut config.clone(), unknown)?;
            Ok(Found {
                unknown,
                value,
                sd: value * sd(i),
            })
        })
        .collect::<Result<_, ElsModelError>>()?;
    Ok(JointFit {
        config,
        found,
        misfit,
        rounds,
    })
}

/// Central differences of the residuals by each logarithm.
fn slopes(
    x: &DVector<f64>,
    residuals: &impl Fn(&DVector<f64>) -> Result<DVector<f64>, ElsModelError>,
) -> Result<DMatrix<f64>, ElsModelError> {
    const STEP: f64 = 1e-3;
    let columns = (0..x.len())
        .map(|i| {
            let at = |step: f64| {
                let mut moved = x.clone();
                moved[i] += step;
                residuals(&moved)
            };
            Ok((at(STEP)? - at(-STEP)?) / (2.0 * STEP))
        })
        .collect::<Result<Vec<_>, ElsModelError>>()?;
    Ok(DMatrix::from_columns(&columns))
}

fn residuals(
    start: &ElsConfig,
    unknowns: &[Unknown],
    x: &DVector<f64>,
    statics: &[Compliance],
    lines: &[Line],
) -> Result<DVector<f64>, ElsModelError> {
    let model = ElsModel::new(&changed(start, unknowns, x)?)?;
    let mut out = Vec::with_capacity(statics.len() + 8 * lines.len());
    if !statics.is_empty() {
        let c = model.tool_joint_compliance()?;
        for s in statics {
            let e = Vector2::new(s.angle_rad.cos(), s.angle_rad.sin());
            out.push((e.dot(&(c * e)) - s.m_per_n) / s.sd_m_per_n);
        }
    }
    if !lines.is_empty() {
        let f: Vec<f64> = lines.iter().map(|l| l.f_hz).collect();
        let model = model.receptance(0.0, Place::Holder(0.0), &f)?;
        for (l, g) in lines.iter().zip(&model) {
            let d = [
                g.resp_u_exc_u - l.g.resp_u_exc_u,
                g.resp_u_exc_v - l.g.resp_u_exc_v,
                g.resp_v_exc_u - l.g.resp_v_exc_u,
                g.resp_v_exc_v - l.g.resp_v_exc_v,
            ];
            out.extend(d.iter().flat_map(|d| [d.re / l.sd, d.im / l.sd]));
        }
    }
    Ok(DVector::from_vec(out))
}

fn changed(
    start: &ElsConfig,
    unknowns: &[Unknown],
    x: &DVector<f64>,
) -> Result<ElsConfig, ElsModelError> {
    let mut out = start.clone();
    for (&unknown, &log) in unknowns.iter().zip(x.iter()) {
        if let Unknown::Joint(_) = unknown {
            let ring = ring(&mut out, unknown)?;
            ring.radial = ring.radial.scaled(log.exp());
        } else {
            *stiffness(&mut out, unknown)? *= log.exp();
        }
    }
    // Two axes that passed each other change their names.
    if let Clamping::Spindle { bearings, .. } = &mut out.clamping {
        for (_, ring) in bearings {
            let r = &mut ring.radial;
            if r.minor_n_per_m > r.major_n_per_m {
                core::mem::swap(&mut r.minor_n_per_m, &mut r.major_n_per_m);
                r.angle_rad += core::f64::consts::FRAC_PI_2;
            }
        }
    }
    Ok(out)
}

fn ring(config: &mut ElsConfig, unknown: Unknown) -> Result<&mut Ring, ElsModelError> {
    let missing = || ElsModelError::OutOfRange {
        name: unknown.to_string(),
    };
    let Clamping::Spindle {
        joints, bearings, ..
    } = &mut config.clamping
    else {
        return Err(missing());
    };
    match unknown {
        Unknown::Joint(k) | Unknown::JointTilt(k) => joints.get_mut(k).map(|j| &mut j.2),
        Unknown::BearingMajor(k) | Unknown::BearingMinor(k) => {
            bearings.get_mut(k).map(|b| &mut b.1)
        }
    }
    .ok_or_else(missing)
}

fn stiffness(config: &mut ElsConfig, unknown: Unknown) -> Result<&mut f64, ElsModelError> {
    let ring = ring(config, unknown)?;
    Ok(match unknown {
        Unknown::Joint(_) | Unknown::BearingMajor(_) => &mut ring.radial.major_n_per_m,
        Unknown::JointTilt(_) => &mut ring.tilt_n_m_per_rad,
        Unknown::BearingMinor(_) => &mut ring.radial.minor_n_per_m,
    })
}
