//! What the cutter meets along its path: the ends of the stock, slots, pockets
//! and holes in it.

use super::error::{PlantError, positive, require};

/// A place without material, in the plane of the feed: x along the feed from the
/// start of the path, y across it from the cutter's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Gap {
    /// A rectangle: a slot across the path, or a pocket.
    Slot {
        /// From and to along the feed, m.
        x_m: [f64; 2],
        /// From and to across it, m.
        y_m: [f64; 2],
    },
    /// A drilled hole.
    Hole {
        /// Centre, m.
        at_m: [f64; 2],
        /// Diameter, m, > 0.
        diameter_m: f64,
    },
}

/// Stock from one place along the feed to another, with gaps.
///
/// Each tooth is asked separately whether it is in material, so that entering,
/// leaving and crossing a gap give the extra entries per revolution that real
/// interrupted cuts have. How far the stock reaches across the feed is the arc of
/// engagement.
#[derive(Clone, Debug, PartialEq)]
pub struct Workpiece {
    /// Where the stock begins and ends along the feed, m; the axis of the cutter
    /// starts at 0.
    pub x_m: [f64; 2],
    /// Places without material.
    pub gaps: Vec<Gap>,
}

impl Workpiece {
    /// Checks the documented ranges.
    ///
    /// # Errors
    /// `OutOfRange` naming the field.
    pub fn validate(&self) -> Result<(), PlantError> {
        let ordered = |x: [f64; 2]| x.iter().all(|v| v.is_finite()) && x[0] < x[1];
        require(ordered(self.x_m), "workpiece")?;
        for gap in &self.gaps {
            match gap {
                Gap::Slot { x_m, y_m } => require(ordered(*x_m) && ordered(*y_m), "workpiece")?,
                Gap::Hole { at_m, diameter_m } => {
                    require(at_m.iter().all(|v| v.is_finite()), "workpiece")?;
                    positive(*diameter_m, "workpiece")?;
                }
            }
        }
        Ok(())
    }

    /// Stretches of the path, m, on which a gap lies in front of a cutter of this
    /// radius; merged and in order.
    #[must_use]
    pub fn interrupted_m(&self, radius_m: f64) -> Vec<(f64, f64)> {
        let mut out: Vec<(f64, f64)> = self
            .gaps
            .iter()
            .map(|gap| match gap {
                Gap::Slot { x_m, .. } => (x_m[0] - radius_m, x_m[1]),
                Gap::Hole { at_m, diameter_m } => {
                    let half = 0.5 * diameter_m;
                    (at_m[0] - half - radius_m, at_m[0] + half)
                }
            })
            .collect();
        out.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut merged: Vec<(f64, f64)> = Vec::new();
        for (from, to) in out {
            match merged.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => merged.push((from, to)),
            }
        }
        merged
    }

    /// Whether there is material at (x, y), m.
    #[inline]
    #[must_use]
    pub fn holds(&self, x: f64, y: f64) -> bool {
        x >= self.x_m[0]
            && x <= self.x_m[1]
            && !self.gaps.iter().any(|gap| match gap {
                Gap::Slot { x_m, y_m } => x >= x_m[0] && x <= x_m[1] && y >= y_m[0] && y <= y_m[1],
                Gap::Hole { at_m, diameter_m } => {
                    let (dx, dy) = (x - at_m[0], y - at_m[1]);
                    dx * dx + dy * dy <= 0.25 * diameter_m * diameter_m
                }
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stock_ends_and_gaps() {
        let piece = Workpiece {
            x_m: [0.0, 0.1],
            gaps: vec![
                Gap::Slot {
                    x_m: [0.02, 0.03],
                    y_m: [-1.0, 1.0],
                },
                Gap::Hole {
                    at_m: [0.05, 0.0],
                    diameter_m: 0.01,
                },
            ],
        };
        assert_eq!(piece.validate(), Ok(()));
        for (x, y, there) in [
            (-0.001, 0.0, false),
            (0.01, 0.0, true),
            (0.025, 0.004, false),
            (0.054, 0.0, false),
            (0.054, 0.004, true),
            (0.101, 0.0, false),
        ] {
            assert_eq!(piece.holds(x, y), there, "{x} {y}");
        }
        let stretches = piece.interrupted_m(0.005);
        assert_eq!(stretches.len(), 2);
        assert!((stretches[0].0 - 0.015).abs() < 1e-12 && (stretches[1].1 - 0.055).abs() < 1e-12);
        let bad = Workpiece {
            x_m: [0.1, 0.0],
            gaps: Vec::new(),
        };
        assert!(bad.validate().is_err());
    }
}
