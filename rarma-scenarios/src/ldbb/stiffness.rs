//! Stiffness all round: raw, smoothed, with its extremes; from standing axes too.

use super::options::Options;
use super::runs::steps;
use rarma_recordings::input::{RunData, Static};
use rarma_rigs::ldbb::{Harmonics, LdbbError, LoadCycle, StiffnessMap, Trace};
use serde::Serialize;

/// Bins of a circle: 1°.
pub const BINS: usize = 360;

/// One direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ray {
    /// Angle, degrees.
    pub angle_deg: f64,
    /// Stiffness of this bin alone, N/µm.
    pub raw_n_per_um: f64,
    /// Its standard deviation.
    pub raw_sd_n_per_um: f64,
    /// Stiffness of the smoothed compliance, N/µm.
    pub n_per_um: f64,
    /// Its standard deviation.
    pub sd_n_per_um: f64,
    /// Curvature of the deflection, µm/kN², and its standard deviation.
    pub curvature_um_per_kn2: f64,
    /// See [`Self::curvature_um_per_kn2`].
    pub curvature_sd_um_per_kn2: f64,
    /// The curvature stands out of its noise.
    pub curved: bool,
    /// R² of the line.
    pub explained: f64,
}

/// An extreme.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extreme {
    /// Angle, degrees.
    pub angle_deg: f64,
    /// Stiffness, N/µm.
    pub n_per_um: f64,
    /// Standard deviation, N/µm.
    pub sd_n_per_um: f64,
}

/// Stiffness all round.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AllRound {
    /// Largest.
    pub most: Extreme,
    /// Smallest.
    pub least: Extreme,
    /// Mean over the angles, N/µm.
    pub mean_n_per_um: f64,
    /// Every stiffness may be off by this part with the gain of the force.
    pub scale_sd: f64,
    /// Scatter of a run's 1° means about the lines, µm.
    pub scatter_um: f64,
    /// Scatter of the raw compliances about the smoothed ones, over what their noise alone
    /// gives: well above 1, the smoothing takes away more than noise.
    pub smoothing: f64,
    /// Part of the directions that are curved.
    pub curved_part: f64,
    /// Every degree.
    pub rays: Vec<Ray>,
}

/// Forces on the way up and what the bar does at them, in 1° bins.
///
/// # Errors
/// As [`StiffnessMap::add`].
pub fn rising_map(runs: &[RunData]) -> Result<Box<StiffnessMap<f64, BINS>>, LdbbError> {
    let mut map = Box::new(StiffnessMap::<f64, BINS>::default());
    // The senses of one force together: their difference (backlash, servo) is no
    // scatter about the line.
    for level in levels(runs.iter().filter(|r| r.rising)) {
        let mut mean = Trace::default();
        for bin in 0..BINS {
            if let Some((_, dr)) = level.at(bin) {
                let _ = mean.add(Trace::<f64, BINS>::angle(bin), dr);
            }
        }
        map.add(&mean, level.force_n)?;
    }
    Ok(map)
}

/// Stiffness of runs on the way up.
pub fn all_round(runs: &[RunData], options: &Options) -> Result<AllRound, LdbbError> {
    let map = rising_map(runs)?;
    let scatter_m = map.scatter_m(false)?;
    let directions: Vec<_> = map.directions(options.bar_m_per_n)?.collect();
    let pairs = directions
        .iter()
        .map(|d| (d.angle_rad, d.compliance_m_per_n.value));
    let smooth = Harmonics::fit(pairs, options.order)?;
    let rays: Vec<Ray> = directions
        .iter()
        .map(|d| {
            let c = smooth.at(d.angle_rad);
            let sd = smooth.sd_at(d.angle_rad, d.compliance_m_per_n.sd);
            Ray {
                angle_deg: d.angle_rad.to_degrees(),
                raw_n_per_um: 1e-6 * d.stiffness_n_per_m.value,
                raw_sd_n_per_um: 1e-6 * d.stiffness_n_per_m.sd,
                n_per_um: 1e-6 / c,
                sd_n_per_um: 1e-6 * sd / (c * c),
                curvature_um_per_kn2: 1e12 * d.curvature_m_per_n2.value,
                curvature_sd_um_per_kn2: 1e12 * d.curvature_m_per_n2.sd,
                curved: d.curved,
                explained: d.explained,
            }
        })
        .collect();
    let (Some(first), Some(direction)) = (rays.first(), directions.first()) else {
        return Err(LdbbError::TooFew { needed: 3 });
    };
    let extreme = |better: fn(f64, f64) -> bool| {
        // Finer than the bins: the smoothed course is a formula.
        let mut best = (0.0, 1e-6 / smooth.at(0.0));
        for k in 1..3600 {
            let deg = 0.1 * f64::from(k);
            let n = 1e-6 / smooth.at(deg.to_radians());
            if better(n, best.1) {
                best = (deg, n);
            }
        }
        let near = rays.iter().fold(first, |m, r| {
            if (r.angle_deg - best.0).abs() < (m.angle_deg - best.0).abs() {
                r
            } else {
                m
            }
        });
        Extreme {
            angle_deg: best.0,
            n_per_um: best.1,
            sd_n_per_um: near.sd_n_per_um,
        }
    };
    let count = rays.len() as f64;
    Ok(AllRound {
        most: extreme(|a, b| a > b),
        least: extreme(|a, b| a < b),
        mean_n_per_um: rays.iter().map(|r| r.n_per_um).sum::<f64>() / count,
        scale_sd: options.scale_sd,
        scatter_um: 1e6 * scatter_m,
        smoothing: smooth.scatter() / direction.compliance_m_per_n.sd.max(1e-18),
        curved_part: rays.iter().filter(|r| r.curved).count() as f64 / count,
        rays,
    })
}

/// A run in 1° bins.
pub fn trace(run: &RunData) -> Trace<f64, BINS> {
    let mut out = Trace::default();
    for (theta, dr) in &run.points {
        let _ = out.add(*theta, *dr);
    }
    out
}

/// One direction of a load cycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cycle {
    /// Angle, degrees.
    pub angle_deg: f64,
    /// Largest unloading less loading deflection, µm.
    pub most_um: f64,
    /// What stays at the smallest force, µm.
    pub left_um: f64,
    /// Stiffness on the way up, N/µm, and its standard deviation; static test only.
    pub n_per_um: Option<f64>,
    /// See [`Self::n_per_um`].
    pub sd_n_per_um: Option<f64>,
    /// Force, N, and deflection, µm, up and down.
    pub up: Vec<(f64, f64)>,
    /// See [`Self::up`].
    pub down: Vec<(f64, f64)>,
}

/// Hysteresis while moving: every bin, senses averaged. None without a way down.
pub fn moving_cycles(runs: &[RunData]) -> Result<Option<Vec<Cycle>>, LdbbError> {
    let (up, down): (Vec<&RunData>, Vec<&RunData>) = runs.iter().partition(|r| r.rising);
    if down.len() < 2 {
        return Ok(None);
    }
    let (up, down) = (levels(up), levels(down));
    let mut out = Vec::new();
    for bin in 0..BINS {
        let of = |levels: &[Level]| -> Vec<(f64, f64)> {
            levels.iter().filter_map(|l| l.at(bin)).collect()
        };
        let (u, d) = (of(&up), of(&down));
        if u.len() == up.len() && d.len() == down.len() {
            out.push(cycle(Trace::<f64, BINS>::angle(bin).to_degrees(), u, d)?);
        }
    }
    Ok(Some(out))
}

fn cycle(angle_deg: f64, up: Vec<(f64, f64)>, down: Vec<(f64, f64)>) -> Result<Cycle, LdbbError> {
    let c = LoadCycle::new(&up, &down)?;
    let zero = up.first().map_or(0.0, |p| p.1);
    let um = |list: Vec<(f64, f64)>| list.iter().map(|(f, r)| (*f, 1e6 * (r - zero))).collect();
    Ok(Cycle {
        angle_deg,
        most_um: 1e6 * c.most_m,
        left_um: 1e6 * c.left_m,
        n_per_um: None,
        sd_n_per_um: None,
        up: um(up),
        down: um(down),
    })
}

/// One force level: its runs in both senses.
pub struct Level {
    /// Mean force of its runs, N.
    pub force_n: f64,
    traces: Vec<Trace<f64, BINS>>,
}

impl Level {
    /// Mean length change of its runs in one bin of the angle, m; nothing where a run has none.
    pub fn mean(&self, bin: usize) -> Option<f64> {
        let means: Option<Vec<f64>> = self.traces.iter().map(|t| t.mean(bin)).collect();
        let means = means?;
        Some(means.iter().sum::<f64>() / means.len() as f64)
    }

    fn at(&self, bin: usize) -> Option<(f64, f64)> {
        Some((self.force_n, self.mean(bin)?))
    }
}

/// The force levels of these runs, in the order they come.
pub fn levels<'a>(runs: impl IntoIterator<Item = &'a RunData>) -> Vec<Level> {
    let level = |step: Vec<&RunData>| Level {
        force_n: step.iter().map(|r| r.force_n).sum::<f64>() / step.len() as f64,
        traces: step.into_iter().map(trace).collect(),
    };
    steps(runs).into_iter().map(level).collect()
}

/// Load cycles of the static test, direction by direction in the order they come.
pub fn static_cycles(readings: &[Static], bar_m_per_n: f64) -> Result<Vec<Cycle>, LdbbError> {
    let mut angles: Vec<f64> = Vec::new();
    for r in readings {
        if !angles.iter().any(|a| (a - r.angle_rad).abs() < 1e-6) {
            angles.push(r.angle_rad);
        }
    }
    let mut out = Vec::new();
    for angle in angles {
        let of = |rising: bool| -> Vec<(f64, f64)> {
            readings
                .iter()
                .filter(|r| r.rising == rising && (r.angle_rad - angle).abs() < 1e-6)
                .map(|r| (r.force_n, r.dr_m))
                .collect()
        };
        let up = of(true);
        let mut map = Box::new(StiffnessMap::<f64, 1>::default());
        for (f, dr) in &up {
            let mut t = Trace::<f64, 1>::default();
            let _ = t.add(angle, *dr);
            map.add(&t, *f)?;
        }
        let found = map.directions(bar_m_per_n)?.next();
        let mut c = cycle(angle.to_degrees(), up, of(false))?;
        c.n_per_um = found.map(|d| 1e-6 * d.stiffness_n_per_m.value);
        c.sd_n_per_um = found.map(|d| 1e-6 * d.stiffness_n_per_m.sd);
        out.push(c);
    }
    Ok(out)
}
