//! Compliance in every direction by regression of deflection on force.

use super::error::LdbbError;
use super::error_fit::Measured;
use super::trace::Trace;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Forces are fitted in units of this, N: squares stay of order 1.
const UNIT_N: f64 = 1000.0;
/// |q|/u(q) above this is a nonlinearity.
const CURVED: f64 = 2.0;

/// One direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction<T> {
    /// Angle, rad.
    pub angle_rad: T,
    /// Compliance of the straight line, m/N, less the bar's.
    pub compliance_m_per_n: Measured<T>,
    /// Stiffness, N/m: k = 1/c, u(k) = k²·u(c).
    pub stiffness_n_per_m: Measured<T>,
    /// Curvature q of Δr = r0 + c·F + q·F², m/N².
    pub curvature_m_per_n2: Measured<T>,
    /// |q|/u(q) > 2.
    pub curved: bool,
    /// Part of the deflection's variance that the line explains (R²).
    pub explained: T,
}

#[derive(Debug, Clone, Copy)]
struct Bin<T> {
    /// Columns 1, x, x² with x = F/1000 N.
    triangle: Triangle<T, 3>,
    rest: T,
    runs: u16,
}

/// Accumulates runs at different forces, bin by bin.
///
/// ```text
/// Δr_j(θ) = r0(θ) + c(θ)·F_j (+ q(θ)·F_j²) + e
/// ```
///
/// Deflection on force, not force on deflection: the noise is in Δr, and the other way round
/// k comes out too small (0.25 % at 1.5 µm noise). Noise is taken as the same in
/// every direction: u(c) = σ/√S_FF with σ from the residuals of all bins together. Where the
/// curvature is significant the line's residual holds it, and the uncertainty with it.
///
/// Memory: 60 bytes a bin in single precision.
#[derive(Debug, Clone)]
pub struct StiffnessMap<T, const BINS: usize> {
    bins: [Bin<T>; BINS],
    least_n: T,
    most_n: T,
    runs: u32,
}

impl<T: Real, const BINS: usize> Default for StiffnessMap<T, BINS> {
    fn default() -> Self {
        let mut map = Self::BLANK;
        map.reset();
        map
    }
}

impl<T: Real, const BINS: usize> StiffnessMap<T, BINS> {
    /// Of no use until [`Self::reset`]. Every bit is 0: where it is put, no copy of it is
    /// made first.
    pub const BLANK: Self = Self {
        bins: [Bin {
            triangle: Triangle::BLANK,
            rest: T::ZERO,
            runs: 0,
        }; BINS],
        least_n: T::ZERO,
        most_n: T::ZERO,
        runs: 0,
    };

    /// Forgets all runs, in place: a map is 60 bytes a bin.
    pub fn reset(&mut self) {
        self.bins.fill(Bin {
            triangle: Triangle::new(3),
            rest: T::ZERO,
            runs: 0,
        });
        self.least_n = T::ZERO;
        self.most_n = T::ZERO;
        self.runs = 0;
    }

    /// Takes a run at one force. Bins that are empty in it are passed over.
    ///
    /// # Errors
    /// `NotFinite` for the force; nothing is taken then.
    pub fn add(&mut self, run: &Trace<T, BINS>, force_n: T) -> Result<(), LdbbError> {
        if !force_n.is_finite() {
            return Err(LdbbError::NotFinite {
                index: self.runs as usize,
            });
        }
        let x = force_n / T::from_f64(UNIT_N);
        for (k, bin) in self.bins.iter_mut().enumerate() {
            if let Some(dr) = run.mean(k) {
                bin.add(x, dr);
            }
        }
        let first = self.runs == 0;
        self.least_n = if first {
            force_n
        } else {
            self.least_n.min(force_n)
        };
        self.most_n = if first {
            force_n
        } else {
            self.most_n.max(force_n)
        };
        self.runs += 1;
        Ok(())
    }

    /// Runs taken.
    pub fn runs(&self) -> u32 {
        self.runs
    }

    /// Scatter of the runs' means about their lines (or, with `curved`, parabolas),
    /// all directions together, m.
    ///
    /// # Errors
    /// `TooFew`, `EqualForces`.
    pub fn scatter_m(&self, curved: bool) -> Result<T, LdbbError> {
        let unknowns = if curved { 3 } else { 2 };
        self.forces_differ()?;
        let (mut squares, mut freedom) = (T::ZERO, 0u32);
        for bin in self.usable() {
            squares += bin.rest;
            if !curved {
                squares += bin.beyond_line();
            }
            freedom += u32::from(bin.runs).saturating_sub(unknowns);
        }
        if freedom == 0 {
            return Err(LdbbError::TooFew { needed: 4 });
        }
        Ok((squares / T::from_u32(freedom)).sqrt())
    }

    /// One direction; `bar_m_per_n`: compliance of the bar and its joints, taken off. None
    /// where the bin has fewer than three runs. `scatter_m` from [`Self::scatter_m`], for
    /// the line and for the parabola.
    pub fn direction(&self, bin: usize, bar_m_per_n: T, scatter_m: (T, T)) -> Option<Direction<T>> {
        let b = self.bins.get(bin)?;
        if b.runs < 3 {
            return None;
        }
        let unit = T::from_f64(UNIT_N);
        let line = b.triangle.leading(2);
        let found = line.solve()?;
        let spread = line.inverse_normal()?[1][1].sqrt();
        let c = Measured {
            value: found[1] / unit - bar_m_per_n,
            sd: scatter_m.0 * spread / unit,
        };
        let k = T::ONE / c.value;
        let curve = (b.runs > 3)
            .then(|| {
                let q = b.triangle.solve()?[2];
                let spread = b.triangle.inverse_normal()?[2][2].sqrt();
                Some(Measured {
                    value: q / (unit * unit),
                    sd: scatter_m.1 * spread / (unit * unit),
                })
            })
            .flatten()
            .unwrap_or_default();
        let risen = line.explained_by(1);
        Some(Direction {
            angle_rad: Trace::<T, BINS>::angle(bin),
            compliance_m_per_n: c,
            stiffness_n_per_m: Measured {
                value: k,
                sd: k * k * c.sd,
            },
            curvature_m_per_n2: curve,
            curved: curve.value.abs() > T::from_f64(CURVED) * curve.sd && curve.sd > T::ZERO,
            explained: risen / (risen + b.rest + b.beyond_line()),
        })
    }

    /// All directions with at least three runs, in order of angle.
    ///
    /// # Errors
    /// As [`Self::scatter_m`].
    pub fn directions(
        &self,
        bar_m_per_n: T,
    ) -> Result<impl Iterator<Item = Direction<T>> + '_, LdbbError> {
        let line = self.scatter_m(false)?;
        // With three runs a parabola leaves nothing over.
        let scatter = (line, self.scatter_m(true).unwrap_or(line));
        Ok((0..BINS).filter_map(move |k| self.direction(k, bar_m_per_n, scatter)))
    }

    fn usable(&self) -> impl Iterator<Item = &Bin<T>> {
        self.bins.iter().filter(|b| b.runs >= 3)
    }

    fn forces_differ(&self) -> Result<(), LdbbError> {
        if self.runs < 3 {
            return Err(LdbbError::TooFew { needed: 3 });
        }
        // A newton: what the pressure regulator cannot hold apart.
        if !(self.most_n - self.least_n > T::ONE) {
            return Err(LdbbError::EqualForces);
        }
        Ok(())
    }
}

impl<T: Real> Bin<T> {
    fn add(&mut self, x: T, dr: T) {
        let rest = self.triangle.add(&mut [T::ONE, x, x * x], dr);
        self.rest += rest * rest;
        self.runs = self.runs.saturating_add(1);
    }

    /// By how much the sum of squares falls from the line to the parabola.
    fn beyond_line(&self) -> T {
        self.triangle.explained_by(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCES: [f64; 8] = [36.0, 112.0, 238.0, 364.0, 490.0, 616.0, 742.0, 868.0];

    fn run(f: f64) -> Trace<f64, 36> {
        let mut t = Trace::default();
        for k in 0..36 {
            let a = Trace::<f64, 36>::angle(k);
            let c = (1.0 + 0.1 * a.cos()) / 11.8e6;
            assert!(t.add(a, 5e-6 * a.sin() + c * f + 2e-12 * f * f * a.sin()));
        }
        t
    }

    #[test]
    fn exact_without_noise_and_the_bar_comes_off() {
        let mut map = StiffnessMap::<f64, 36>::default();
        for f in FORCES {
            map.add(&run(f), f).expect("finite");
        }
        assert!(map.scatter_m(true).expect("runs") < 1e-15);
        let bar = 1e-9;
        // The line's slope holds the curvature: q times the regression of F² on F.
        let mean = FORCES.iter().sum::<f64>() / 8.0;
        let (mut above, mut below) = (0.0, 0.0);
        for f in FORCES {
            above += (f - mean) * f * f;
            below += (f - mean) * (f - mean);
        }
        let tilt = above / below;
        for d in map.directions(bar).expect("runs") {
            let want = (1.0 + 0.1 * d.angle_rad.cos()) / 11.8e6 - bar;
            let off = d.compliance_m_per_n.value - want;
            assert!((off / 2e-12 / d.angle_rad.sin() / tilt - 1.0).abs() < 1e-6);
            assert!((d.curvature_m_per_n2.value / 2e-12 / d.angle_rad.sin() - 1.0).abs() < 1e-6);
            assert!(d.curved && d.explained > 0.99);
        }
    }

    #[test]
    fn refusals() {
        let mut map = StiffnessMap::<f32, 4>::default();
        let mut t = Trace::default();
        assert!(t.add(0.1, 1e-6));
        assert_eq!(map.scatter_m(false), Err(LdbbError::TooFew { needed: 3 }));
        for _ in 0..4 {
            map.add(&t, 364.0).expect("finite");
        }
        assert_eq!(map.scatter_m(false), Err(LdbbError::EqualForces));
        assert!(map.add(&t, f32::NAN).is_err());
        map.add(&t, 868.0).expect("finite");
        assert_eq!(map.directions(0.0).expect("two forces").count(), 1);
    }
}
