//! Current of one coil: a PI regulator that knows its limits.
//!
//! Rate: once a period of the current loop. Fast path: no division, no branch on data
//! beyond the clamps.

use core::fmt;

/// What the coil and its supply are, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegulatorConfig {
    /// Inductance at the nominal gap, H, 10 µH to 1 H.
    pub inductance_h: f32,
    /// Resistance, Ω, 0.01 to 100.
    pub resistance_ohm: f32,
    /// Rate of the loop, Hz, 1 to 200 kHz.
    pub rate_hz: f32,
    /// Gain crossover as a part of the rate, 1/1000 to 1/18: the delay of 1.5 periods leaves
    /// a phase margin of 90° − 540°·crossover, 60° at 1/18.
    pub crossover: f32,
    /// Largest magnitude of the duty, 0.1 to 1: the rest of a period is the current
    /// sensors'.
    pub most_duty: f32,
}

/// The field of a [`RegulatorConfig`] that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RegulatorError {
    /// `inductance_h`.
    Inductance,
    /// `resistance_ohm`.
    Resistance,
    /// `rate_hz`.
    Rate,
    /// `crossover`.
    Crossover,
    /// `most_duty`.
    Duty,
}

impl fmt::Display for RegulatorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Self::Inductance => "inductance_h",
            Self::Resistance => "resistance_ohm",
            Self::Rate => "rate_hz",
            Self::Crossover => "crossover",
            Self::Duty => "most_duty",
        };
        write!(f, "{name} is out of its range")
    }
}

impl core::error::Error for RegulatorError {}

/// Coefficients of a regulator; one set serves all coils.
///
/// With L di/dt + R i = u, the zero of the PI on the pole of the coil gives
/// kp = ωc L and ki = ωc R, ωc = 2π·crossover·rate. `integral` is ki/rate.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tuning {
    /// V/A.
    pub proportional: f32,
    /// V/A per period.
    pub integral: f32,
    /// Largest magnitude of the duty.
    pub most_duty: f32,
}

impl RegulatorConfig {
    /// The coefficients.
    ///
    /// # Errors
    /// The first field out of range; NaN is.
    pub fn tuning(&self) -> Result<Tuning, RegulatorError> {
        let within = |x: f32, low: f32, high: f32| x >= low && x <= high;
        if !within(self.inductance_h, 1e-5, 1.0) {
            return Err(RegulatorError::Inductance);
        }
        if !within(self.resistance_ohm, 0.01, 100.0) {
            return Err(RegulatorError::Resistance);
        }
        if !within(self.rate_hz, 1e3, 2e5) {
            return Err(RegulatorError::Rate);
        }
        if !within(self.crossover, 1e-3, 1.0 / 18.0) {
            return Err(RegulatorError::Crossover);
        }
        if !within(self.most_duty, 0.1, 1.0) {
            return Err(RegulatorError::Duty);
        }
        let omega = core::f32::consts::TAU * self.crossover * self.rate_hz;
        Ok(Tuning {
            proportional: omega * self.inductance_h,
            integral: omega * self.resistance_ohm / self.rate_hz,
            most_duty: self.most_duty,
        })
    }
}

/// What a regulator asks of its bridge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Mean voltage over the supply's, within ±`most_duty`.
    pub duty: f32,
    /// The supply's voltage holds the current back.
    pub limiting: bool,
}

/// Regulates one coil.
///
/// u\[n\] = kp·e\[n\] + s\[n\], s\[n+1\] = s\[n\] + ki·e\[n\], duty = u/supply clamped; e = wanted −
/// measured current, so a positive error raises the duty. While the clamp holds, s stands still
/// in the direction of the error (no wind-up).
#[derive(Debug, Clone, Copy, Default)]
pub struct Regulator {
    sum_v: f32,
}

impl Regulator {
    /// One period. `per_volt` is 1/supply, 1/V.
    ///
    /// A current or target that is not finite gives a duty of 0 and leaves the state as it is.
    #[inline]
    pub fn update(
        &mut self,
        tuning: &Tuning,
        target_a: f32,
        current_a: f32,
        per_volt: f32,
    ) -> Drive {
        let error = target_a - current_a;
        let duty = (tuning.proportional * error + self.sum_v) * per_volt;
        if !(duty.abs() <= f32::MAX) {
            return Drive {
                duty: 0.0,
                limiting: true,
            };
        }
        // Not `clamp`, which panics where the limit is not one; this gives no duty there. Nor `min` and
        // `max`, which look for a NaN that cannot come here.
        let most = tuning.most_duty;
        let limiting = !(duty.abs() <= most);
        let clamped = if !limiting {
            duty
        } else if !(most >= 0.0) {
            0.0
        } else if duty < 0.0 {
            -most
        } else {
            most
        };
        if !limiting || error * duty < 0.0 {
            self.sum_v += tuning.integral * error;
        }
        Drive {
            duty: clamped,
            limiting,
        }
    }

    /// Forgets everything; for a coil without current.
    pub fn reset(&mut self) {
        self.sum_v = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> RegulatorConfig {
        RegulatorConfig {
            inductance_h: 4.19e-3,
            resistance_ohm: 4.0,
            rate_hz: 40e3,
            crossover: 1.0 / 18.0,
            most_duty: 0.95,
        }
    }

    /// The coil over one period, and the regulator with one period of computing delay.
    fn step(supply: f32, target: f32, periods: usize) -> Vec<f32> {
        let tuning = config().tuning().unwrap();
        let (mut regulator, mut current, mut duty) = (Regulator::default(), 0.0f32, 0.0f32);
        let dt = 1.0 / 40e3;
        (0..periods)
            .map(|_| {
                let next = regulator
                    .update(&tuning, target, current, 1.0 / supply)
                    .duty;
                let decay = (-dt * 4.0 / 4.19e-3f32).exp();
                current = current * decay + duty * supply / 4.0 * (1.0 - decay);
                duty = next;
                current
            })
            .collect()
    }

    #[test]
    fn gains_are_those_of_the_textbook() {
        // 40 kHz, 60° of phase margin: 2.2 kHz crossover, 58 V/A for 4.19 mH.
        let tuning = config().tuning().unwrap();
        assert!((57.0..60.0).contains(&tuning.proportional), "{tuning:?}");
        assert!((1.38..1.41).contains(&tuning.integral), "{tuning:?}");
    }

    #[test]
    fn small_step_settles_without_much_overshoot() {
        let i = step(48.0, 0.05, 2000);
        let peak = i.iter().copied().fold(0.0, f32::max);
        assert!((0.050..0.056).contains(&peak), "{peak}");
        assert!((i[200] - 0.05).abs() < 1e-3 && (i[1999] - 0.05).abs() < 1e-5);
    }

    #[test]
    fn large_step_slews_at_the_supply_and_does_not_wind_up() {
        let i = step(48.0, 2.0, 4000);
        let peak = i.iter().copied().fold(0.0, f32::max);
        // 0.95·48 V over 4.19 mH: 10.9 A/ms falling to 9 A/ms.
        let reached = i.iter().position(|x| *x > 1.9).unwrap() as f32 / 40.0;
        assert!((0.17..0.25).contains(&reached), "{reached} ms");
        assert!(peak < 2.3, "{peak}");
        assert!((i[3999] - 2.0).abs() < 1e-3);
        // A target that the supply cannot give: held back, and back at once.
        let tuning = config().tuning().unwrap();
        let mut r = Regulator::default();
        for _ in 0..100_000 {
            assert!(r.update(&tuning, 10.0, 1.0, 1.0 / 48.0).limiting);
        }
        assert!(r.update(&tuning, 0.9, 1.0, 1.0 / 48.0).duty < 0.0);
    }

    #[test]
    fn nonsense_gives_no_voltage() {
        let tuning = config().tuning().unwrap();
        let mut r = Regulator::default();
        for (target, current, per_volt) in [
            (f32::NAN, 0.0, 0.02),
            (1.0, f32::INFINITY, 0.02),
            (1.0, 0.0, f32::NAN),
        ] {
            assert_eq!(r.update(&tuning, target, current, per_volt).duty, 0.0);
        }
        assert_eq!(r.sum_v, 0.0);
    }

    #[test]
    fn each_field_out_of_range_is_named() {
        let bad = [
            (
                RegulatorConfig {
                    inductance_h: 0.0,
                    ..config()
                },
                RegulatorError::Inductance,
            ),
            (
                RegulatorConfig {
                    resistance_ohm: f32::NAN,
                    ..config()
                },
                RegulatorError::Resistance,
            ),
            (
                RegulatorConfig {
                    rate_hz: 1.0,
                    ..config()
                },
                RegulatorError::Rate,
            ),
            (
                RegulatorConfig {
                    crossover: 0.2,
                    ..config()
                },
                RegulatorError::Crossover,
            ),
            (
                RegulatorConfig {
                    most_duty: 1.1,
                    ..config()
                },
                RegulatorError::Duty,
            ),
        ];
        for (config, error) in bad {
            assert_eq!(config.tuning(), Err(error));
        }
    }
}
