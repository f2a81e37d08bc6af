//! Gain of the regulator with the gap.
//!
//! Rate: once a millisecond or a period; one division.

use super::current::Tuning;
use super::design::Geometry;

/// How the inductance of a coil changes with its gap.
///
/// ```text
/// L(s) = Lσ + 2k/(s + δ),   kp(s) = kp(s₀)·L(s)/L(s₀)
/// ```
///
/// The integral's gain is the resistance's and stays. From 150 to 100 µm an ideal magnet's
/// inductance rises 1.5 times: unscheduled, the crossover and with it the bandwidth fall
/// as much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapSchedule {
    tuning: Tuning,
    /// Part of the gain that does not change.
    leakage: f32,
    /// Part that goes as 1/(s + δ), m.
    gap_m: f32,
    offset_m: f32,
    least_m: f32,
}

impl GapSchedule {
    /// From a tuning for the inductance at the geometry's gap at rest. Gaps below 0.35 of
    /// that (where the exciter trips) are taken as that.
    pub fn new(tuning: Tuning, geometry: &Geometry<f32>) -> Self {
        let at_rest = geometry.inductance_h(geometry.gap_m);
        let leakage = geometry.leakage * 2.0 * geometry.k() / geometry.gap_m / at_rest;
        let offset_m = geometry.iron_gap_m();
        Self {
            tuning,
            leakage,
            gap_m: (1.0 - leakage) * (geometry.gap_m + offset_m),
            offset_m,
            least_m: 0.35 * geometry.gap_m,
        }
    }

    /// Coefficients at a gap in m; those at rest if it is not finite.
    #[inline]
    pub fn at(&self, gap_m: f32) -> Tuning {
        let factor = self.leakage + self.gap_m / (gap_m.max(self.least_m) + self.offset_m);
        if !(gap_m.abs() <= f32::MAX) {
            return self.tuning;
        }
        Tuning {
            proportional: self.tuning.proportional * factor,
            ..self.tuning
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cers::RegulatorConfig;

    fn schedule(geometry: &Geometry<f32>) -> (Tuning, GapSchedule) {
        let tuning = RegulatorConfig {
            inductance_h: geometry.inductance_h(geometry.gap_m),
            resistance_ohm: 4.0,
            rate_hz: 40e3,
            crossover: 1.0 / 18.0,
            most_duty: 0.95,
        }
        .tuning()
        .unwrap();
        (tuning, GapSchedule::new(tuning, geometry))
    }

    #[test]
    fn gain_follows_the_inductance() {
        let ideal = Geometry::textbook();
        let (tuning, s) = schedule(&ideal);
        assert!((s.at(100e-6).proportional / tuning.proportional - 1.5).abs() < 1e-5);
        let real = Geometry {
            iron_path_m: 0.12,
            leakage: 0.15,
            ..Geometry::textbook()
        };
        let (tuning, s) = schedule(&real);
        for gap in [100e-6, 150e-6, 200e-6] {
            let want = real.inductance_h(gap) / real.inductance_h(real.gap_m);
            let got = s.at(gap).proportional / tuning.proportional;
            assert!((got / want - 1.0).abs() < 1e-5, "{gap}: {got} {want}");
            assert_eq!(s.at(gap).integral, tuning.integral);
        }
    }

    #[test]
    fn nonsense_and_closed_gaps_do_not_raise_the_gain_without_end() {
        let (tuning, s) = schedule(&Geometry::textbook());
        assert_eq!(s.at(f32::NAN), tuning);
        assert_eq!(s.at(f32::INFINITY), tuning);
        let most = s.at(-1.0).proportional / tuning.proportional;
        assert!((2.8..2.9).contains(&most), "{most}");
    }
}
