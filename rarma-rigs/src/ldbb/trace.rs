//! Time to angle, and one run as means in fixed bins of angle.

use super::error::LdbbError;
use super::terms::Sense;
use rarma_core::real::Real;

/// Time to angle from both triggers.
///
/// The machine moves in along the radius, stops, runs the arc at its feed, stops, and moves
/// out. The gauge crosses the trigger length at `on_s` and `off_s`, each `lead_s` from the
/// arc's end; what is between is the arc:
///
/// ```text
/// θ(t) = start + d·sweep·(t − t0)/(t1 − t0),   t0 = on + lead, t1 = off − lead
/// ```
///
/// With both triggers the feed need not be known, and capture is exactly what the program
/// runs. Acceleration at the two ends is left out: v/a of the arc's time, 0.03 s of a minute.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngleMap<T> {
    /// Angle at which the arc begins, rad.
    pub start_rad: T,
    /// Angle it covers, rad, 0 or more.
    pub sweep_rad: T,
    /// Direction.
    pub sense: Sense,
    /// The arc begins, s.
    pub from_s: T,
    /// The arc ends, s.
    pub to_s: T,
}

impl<T: Real> AngleMap<T> {
    /// From the times of the triggers, s.
    ///
    /// # Errors
    /// `OutOfRange`: no time is left between the triggers, or no angle.
    pub fn from_triggers(
        start_rad: T,
        sweep_rad: T,
        sense: Sense,
        (on_s, off_s): (T, T),
        lead_s: T,
    ) -> Result<Self, LdbbError> {
        let (from_s, to_s) = (on_s + lead_s, off_s - lead_s);
        if !(to_s > from_s && from_s.is_finite() && to_s.is_finite()) {
            return Err(LdbbError::OutOfRange { name: "triggers" });
        }
        if !(sweep_rad > T::ZERO && start_rad.is_finite()) {
            return Err(LdbbError::OutOfRange { name: "sweep" });
        }
        Ok(Self {
            start_rad,
            sweep_rad,
            sense,
            from_s,
            to_s,
        })
    }

    /// Angle run since the arc's beginning, rad; negative before it.
    pub fn run_rad(&self, t_s: T) -> T {
        self.sweep_rad * (t_s - self.from_s) / (self.to_s - self.from_s)
    }

    /// Angle at a time, rad; not wrapped.
    pub fn theta(&self, t_s: T) -> T {
        self.start_rad + self.sense.sign::<T>() * self.run_rad(t_s)
    }

    /// Angle at a time within the capture: the arc less `overshoot_rad` at each end.
    pub fn captured(&self, t_s: T, overshoot_rad: T) -> Option<T> {
        let run = self.run_rad(t_s);
        (run >= overshoot_rad && run < self.sweep_rad - overshoot_rad).then(|| self.theta(t_s))
    }

    /// Feed along a circle of this radius, m/s, as the triggers say it.
    pub fn feed_m_s(&self, radius_m: T) -> T {
        self.sweep_rad * radius_m / (self.to_s - self.from_s)
    }
}

/// An angle this far below an edge, in bins, counts to the bin above it.
const EDGE: f32 = 1e-3;

/// The bin of an angle, rad.
pub(super) fn bin_of<T: Real>(theta: T, bins: usize) -> usize {
    let turns = theta.to_f32() * (1.0 / core::f32::consts::TAU);
    let part = turns - libm::floorf(turns);
    // Readings at whole degrees lie on edges: rounding must not deal them out by chance.
    let bin = (part * bins as f32 + EDGE) as usize;
    bin % bins.max(1)
}

/// Mean length change in each of `BINS` equal sectors; the first begins at θ = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trace<T, const BINS: usize> {
    mean: [T; BINS],
    count: [u16; BINS],
}

impl<T: Real, const BINS: usize> Default for Trace<T, BINS> {
    fn default() -> Self {
        Self {
            mean: [T::ZERO; BINS],
            count: [0; BINS],
        }
    }
}

impl<T: Real, const BINS: usize> Trace<T, BINS> {
    /// Takes a reading: θ, rad, and Δr, m. False, and nothing taken, where one is not finite.
    pub fn add(&mut self, theta: T, dr_m: T) -> bool {
        if !(theta.is_finite() && dr_m.is_finite()) {
            return false;
        }
        let bin = bin_of(theta, BINS);
        if let (Some(mean), Some(count)) = (self.mean.get_mut(bin), self.count.get_mut(bin)) {
            *count = count.saturating_add(1);
            *mean += (dr_m - *mean) / T::from_u32(u32::from(*count));
        }
        true
    }

    /// Mean of a bin, m; none where it is empty.
    pub fn mean(&self, bin: usize) -> Option<T> {
        self.mean.get(bin).copied().filter(|_| self.count(bin) > 0)
    }

    /// Becomes the mean of this and another run, in bins that both have; the others are empty.
    pub fn average_with(&mut self, other: &Self) {
        for k in 0..BINS {
            let mean = self.mean(k).zip(other.mean(k));
            if let (Some(here), Some(count)) = (self.mean.get_mut(k), self.count.get_mut(k)) {
                *count = u16::from(mean.is_some());
                *here = mean.map_or(T::ZERO, |(a, b)| T::from_f64(0.5) * (a + b));
            }
        }
    }

    /// Readings in a bin.
    pub fn count(&self, bin: usize) -> u16 {
        self.count.get(bin).copied().unwrap_or(0)
    }

    /// Bins with readings.
    pub fn filled(&self) -> usize {
        self.count.iter().filter(|n| **n > 0).count()
    }

    /// Angle of the middle of a bin, rad.
    pub fn angle(bin: usize) -> T {
        let part = (T::from_u32(bin as u32) + T::from_f64(0.5)) / T::from_u32(BINS as u32);
        T::from_f64(2.0) * T::PI * part
    }

    /// Angles (rad) and means (m) of the bins with readings.
    pub fn points(&self) -> impl Iterator<Item = (T, T)> + '_ {
        (0..BINS).filter_map(|k| Some((Self::angle(k), self.mean(k)?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_triggers_fix_the_angle() {
        let tau = core::f64::consts::TAU;
        let sweep = 390f64.to_radians();
        let overshoot = 15f64.to_radians();
        let start = -overshoot;
        let map =
            AngleMap::from_triggers(start, sweep, Sense::Ccw, (2.0, 63.0), 0.5).expect("triggers");
        assert!((map.theta(2.5) - start).abs() < 1e-12);
        assert!((map.theta(62.5) - (start + sweep)).abs() < 1e-12);
        assert!((map.feed_m_s(0.15) - 0.15 * sweep / 60.0).abs() < 1e-12);
        // Capture is one whole turn.
        let inside: Vec<f64> = (0..6500)
            .filter_map(|k| map.captured(0.01 * f64::from(k), overshoot))
            .collect();
        let covered = inside[inside.len() - 1] - inside[0];
        assert!((covered - tau).abs() < 2.0 * 0.01 * sweep / 60.0);
        let back = AngleMap {
            sense: Sense::Cw,
            ..map
        };
        assert!(back.theta(30.0) < back.theta(29.0));
        assert!(
            AngleMap::from_triggers(0.0, sweep, Sense::Cw, (2.0, 2.5), 0.5).is_err(),
            "no time left"
        );
    }

    #[test]
    fn bins_hold_means_all_round() {
        let mut trace = Trace::<f32, 36>::default();
        for k in 0..720 {
            let deg = 0.5 * k as f32 - 89.75;
            assert!(trace.add(deg.to_radians(), 1e-6 * deg));
        }
        assert_eq!(trace.filled(), 36);
        // −90° is 270°.
        assert!((trace.mean(27).expect("filled") + 85.0e-6).abs() < 1e-9);
        assert_eq!(trace.count(0), 20);
        assert!(!trace.add(f32::NAN, 0.0) && !trace.add(0.0, f32::INFINITY));
        assert_eq!(trace.points().count(), 36);
    }

    #[test]
    fn a_mean_of_two_has_the_bins_of_both() {
        let run = |bins: [usize; 2], dr_m: f64| {
            let mut trace = Trace::<f64, 4>::default();
            for bin in bins {
                assert!(trace.add(Trace::<f64, 4>::angle(bin), dr_m));
            }
            trace
        };
        let mut mean = run([0, 1], 2e-6);
        mean.average_with(&run([1, 2], 4e-6));
        let means = [0, 1, 2, 3].map(|bin| mean.mean(bin));
        assert_eq!(means, [None, Some(3e-6), None, None]);
    }
}
