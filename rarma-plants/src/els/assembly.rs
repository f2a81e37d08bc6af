//! From the description to matrices.

use super::beam::{Element, Segment, Theory};
use super::config::{Clamping, ElsConfig, Place};
use super::error::{ElsModelError, check};
use super::link::Link;
use super::ring::Ring;
use nalgebra::{DMatrix, Matrix2};

/// Coordinates of a node.
pub(super) const PER_NODE: usize = 5;
pub(super) const X: usize = 0;
pub(super) const SLOPE_X: usize = 1;
pub(super) const Y: usize = 2;
pub(super) const SLOPE_Y: usize = 3;
pub(super) const TWIST: usize = 4;
/// Two places this close are one node, m.
const SAME_M: f64 = 1e-9;

/// The assembled system without its link. Coordinates that are held are left out.
#[derive(Clone, Debug)]
pub struct ElsModel {
    /// Stiffness, N/m and the like.
    pub(super) stiffness: DMatrix<f64>,
    /// Stiffness times loss factor, part by part.
    pub(super) lossy: DMatrix<f64>,
    pub(super) mass: DMatrix<f64>,
    /// Row of each coordinate of each node; none where it is held.
    rows: Vec<Option<usize>>,
    /// Nodes of the holder, m from the tool joint.
    pub(super) holder_m: Vec<f64>,
    /// Nodes of the spindle, m from its nose.
    pub(super) spindle_m: Vec<f64>,
    /// Nose of the spindle, m from the tool joint; for pictures.
    pub(super) nose_m: f64,
    pub(super) link: Link,
    pub(super) tool_joint_n_per_m: f64,
}

/// Matrices over all coordinates, before those that are held are left out.
struct Builder {
    stiffness: DMatrix<f64>,
    lossy: DMatrix<f64>,
    mass: DMatrix<f64>,
}

impl ElsModel {
    /// Assembles the system.
    ///
    /// # Errors
    /// As [`ElsConfig::validate`].
    pub fn new(config: &ElsConfig) -> Result<Self, ElsModelError> {
        config.validate()?;
        let (mut on_holder, mut on_spindle, mut nose_m) = (Vec::new(), Vec::new(), 0.0);
        if let Clamping::Spindle {
            joints, bearings, ..
        } = &config.clamping
        {
            on_holder.extend(joints.iter().map(|j| j.0));
            on_spindle.extend(joints.iter().map(|j| j.1));
            on_spindle.extend(bearings.iter().map(|b| b.0));
            nose_m = joints.first().map_or(0.0, |j| j.0 - j.1);
        }
        let holder = mesh(&config.holder, &on_holder);
        let spindle = match &config.clamping {
            Clamping::Spindle { segments, .. } => mesh(segments, &on_spindle),
            _ => Vec::new(),
        };
        let (holder_m, spindle_m) = (places(&holder), places(&spindle));
        let size = PER_NODE * (holder_m.len() + spindle_m.len());
        let mut b = Builder {
            stiffness: DMatrix::zeros(size, size),
            lossy: DMatrix::zeros(size, size),
            mass: DMatrix::zeros(size, size),
        };
        b.body(&holder, 0, config.theory);
        b.body(&spindle, holder_m.len(), config.theory);
        if let Clamping::Spindle {
            joints, bearings, ..
        } = &config.clamping
        {
            let spindle_node = |at: f64| holder_m.len() + nearest(&spindle_m, at);
            for (low, high, ring) in joints {
                let ends = (nearest(&holder_m, *low), Some(spindle_node(*high)));
                b.ring(ring, ends);
            }
            for (at, ring) in bearings {
                b.ring(ring, (spindle_node(*at), None));
            }
        }
        let top = holder_m.len() - 1;
        let held: Vec<usize> = match config.clamping {
            Clamping::Fixed => (0..PER_NODE).map(|c| PER_NODE * top + c).collect(),
            Clamping::Pinned => [X, Y]
                .into_iter()
                .flat_map(|c| [c, PER_NODE * top + c])
                .collect(),
            Clamping::Free | Clamping::Spindle { .. } => Vec::new(),
        };
        let kept: Vec<usize> = (0..size).filter(|i| !held.contains(i)).collect();
        let mut rows = vec![None; size];
        for (row, &i) in kept.iter().enumerate() {
            rows[i] = Some(row);
        }
        let keep = |m: &DMatrix<f64>| m.select_rows(&kept).select_columns(&kept);
        Ok(Self {
            stiffness: keep(&b.stiffness),
            lossy: keep(&b.lossy),
            mass: keep(&b.mass),
            rows,
            holder_m,
            spindle_m,
            nose_m,
            link: config.link,
            tool_joint_n_per_m: config.tool_joint_n_per_m,
        })
    }

    /// Coordinates that move.
    #[must_use]
    pub fn size(&self) -> usize {
        self.mass.nrows()
    }

    /// Mass that moves along x as a rigid body, kg: all of it where nothing is held.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        let nodes = self.holder_m.len() + self.spindle_m.len();
        let rows: Vec<usize> = (0..nodes).filter_map(|n| self.row(n, X)).collect();
        rows.iter()
            .flat_map(|i| rows.iter().map(move |j| (*i, *j)))
            .map(|(i, j)| self.mass[(i, j)])
            .sum()
    }

    pub(super) fn row(&self, node: usize, coordinate: usize) -> Option<usize> {
        self.rows[PER_NODE * node + coordinate]
    }

    /// Node nearest to a place.
    ///
    /// # Errors
    /// A place that is not finite, or on a spindle that is not there.
    pub(super) fn node(&self, place: Place) -> Result<usize, ElsModelError> {
        let (at, nodes, first) = match place {
            Place::Holder(at) => (at, &self.holder_m, 0),
            Place::Spindle(at) => (at, &self.spindle_m, self.holder_m.len()),
        };
        check(at.is_finite() && !nodes.is_empty(), "place")?;
        Ok(first + nearest(nodes, at))
    }

    /// Stiffness and lossy stiffness with the link under a load.
    pub(super) fn linked(
        &self,
        load_n: f64,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), ElsModelError> {
        let tensor = self.link.tensor(load_n)?;
        let (mut k, mut lossy) = (self.stiffness.clone(), self.lossy.clone());
        for (i, a) in [X, Y].into_iter().enumerate() {
            for (j, b) in [X, Y].into_iter().enumerate() {
                if let (Some(r), Some(c)) = (self.row(0, a), self.row(0, b)) {
                    k[(r, c)] += tensor[(i, j)];
                    lossy[(r, c)] += self.link.loss * tensor[(i, j)];
                }
            }
        }
        Ok((k, lossy))
    }
}

impl Builder {
    fn body(&mut self, pieces: &[(f64, &Segment)], first: usize, theory: Theory) {
        for (k, (length_m, segment)) in pieces.iter().enumerate() {
            let element = segment.element(*length_m, theory);
            self.element(&element, first + k, segment.material.loss);
        }
    }

    fn element(&mut self, e: &Element, node: usize, loss: f64) {
        let place = |c: usize| PER_NODE * node + c;
        let next = |c: usize| PER_NODE * (node + 1) + c;
        for (u, s) in [(X, SLOPE_X), (Y, SLOPE_Y)] {
            let at = [place(u), place(s), next(u), next(s)];
            for i in 0..4 {
                for j in 0..4 {
                    self.stiffness[(at[i], at[j])] += e.stiffness[(i, j)];
                    self.lossy[(at[i], at[j])] += loss * e.stiffness[(i, j)];
                    self.mass[(at[i], at[j])] += e.mass[(i, j)];
                }
            }
        }
        let at = [place(TWIST), next(TWIST)];
        for i in 0..2 {
            for j in 0..2 {
                self.stiffness[(at[i], at[j])] += e.twist_stiffness[(i, j)];
                self.lossy[(at[i], at[j])] += loss * e.twist_stiffness[(i, j)];
                self.mass[(at[i], at[j])] += e.twist_mass[(i, j)];
            }
        }
    }

    fn ring(&mut self, ring: &Ring, (from, to): (usize, Option<usize>)) {
        self.spring(&ring.tensor(), ring.loss, (X, Y), (from, to));
        self.spring(
            &ring.tilt_tensor(),
            ring.loss,
            (SLOPE_X, SLOPE_Y),
            (from, to),
        );
        let twist = Matrix2::new(ring.twist_n_m_per_rad, 0.0, 0.0, 0.0);
        self.spring(&twist, ring.loss, (TWIST, TWIST), (from, to));
    }

    /// A spring between two nodes, or a node and the housing, in two coordinates.
    fn spring(
        &mut self,
        k: &Matrix2<f64>,
        loss: f64,
        coordinates: (usize, usize),
        (from, to): (usize, Option<usize>),
    ) {
        let at = [coordinates.0, coordinates.1];
        let mut put = |row: usize, column: usize, x: f64| {
            self.stiffness[(row, column)] += x;
            self.lossy[(row, column)] += loss * x;
        };
        for i in 0..2 {
            for j in 0..2 {
                let (a, b) = (PER_NODE * from + at[i], PER_NODE * from + at[j]);
                put(a, b, k[(i, j)]);
                if let Some(to) = to {
                    let (c, d) = (PER_NODE * to + at[i], PER_NODE * to + at[j]);
                    put(c, d, k[(i, j)]);
                    put(a, d, -k[(i, j)]);
                    put(c, b, -k[(i, j)]);
                }
            }
        }
    }
}

/// Elements of a body: length and section, with a node at each of `wanted`.
fn mesh<'a>(segments: &'a [Segment], wanted: &[f64]) -> Vec<(f64, &'a Segment)> {
    let mut out = Vec::new();
    let mut start = 0.0;
    for s in segments {
        let mut cuts: Vec<f64> = (0..=s.elements)
            .map(|i| start + s.length_m * i as f64 / s.elements as f64)
            .collect();
        let inside = |at: &&f64| **at > start && **at < start + s.length_m;
        cuts.extend(wanted.iter().filter(inside));
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|b, a| *b - *a < SAME_M);
        out.extend(cuts.windows(2).map(|w| (w[1] - w[0], s)));
        start += s.length_m;
    }
    out
}

fn places(pieces: &[(f64, &Segment)]) -> Vec<f64> {
    if pieces.is_empty() {
        return Vec::new();
    }
    let mut at = 0.0;
    let mut out = vec![0.0];
    out.extend(pieces.iter().map(|(length, _)| {
        at += length;
        at
    }));
    out
}

fn nearest(nodes: &[f64], at: f64) -> usize {
    let far = |k: usize| (nodes[k] - at).abs();
    (0..nodes.len()).fold(0, |best, k| if far(k) < far(best) { k } else { best })
}
