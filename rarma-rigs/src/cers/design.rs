//! What a magnet is made of, and the figures a designer asks for.
//!
//! Rate: slow path. Words: *pole*, one of the two legs of a horseshoe; *gap*, the distance
//! between one pole and the rotor; *bias*, the current of both coils of an axis at rest.

use super::error::{CersError, within};
use super::force::Magnet;
use rarma_core::real::Real;

/// µ₀, V·s/(A·m).
pub const MU_0: f64 = 1.256_637_062_12e-6;

/// One horseshoe magnet with its rotor, SI.
///
/// ```text
/// k = µ₀N²A/4,   L = Lσ + 2k/(s + δ),   δ = l_Fe/(2µ_r),   B = µ₀N·i/(2(s + δ))
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry<T> {
    /// Turns N, both legs together, 1 to 10 000.
    pub turns: T,
    /// Area of one pole A, m², 1e-7 to 1e-1.
    pub pole_area_m2: T,
    /// Gap at rest s₀, m, 1e-5 to 1e-2.
    pub gap_m: T,
    /// Half the angle between the poles α, rad, 0 to 1.2; 22.5° with eight poles.
    pub pole_angle_rad: T,
    /// Path in iron l_Fe, m, 0 to 10. 0: ideal iron.
    pub iron_path_m: T,
    /// Relative permeability of the iron µ_r, 10 to 1e6.
    pub permeability: T,
    /// Leakage inductance over 2k/s₀, 0 to 1; 0.1 to 0.2 is usual.
    pub leakage: T,
    /// Flux density at which the iron bends B_s, T, 0.1 to 3; 1.2 to 1.5 for laminations.
    pub saturation_t: T,
}

impl<T: Real> Geometry<T> {
    /// 100 turns on 100 mm², 150 µm gap, 22.5°, ideal iron, no leakage.
    pub fn textbook() -> Self {
        Self {
            turns: T::from_f64(100.0),
            pole_area_m2: T::from_f64(1e-4),
            gap_m: T::from_f64(150e-6),
            pole_angle_rad: T::PI / T::from_f64(8.0),
            iron_path_m: T::ZERO,
            permeability: T::from_f64(3000.0),
            leakage: T::ZERO,
            saturation_t: T::from_f64(1.2),
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// `OutOfRange` with the first field.
    pub fn validate(&self) -> Result<(), CersError> {
        let check =
            |x: T, low: f64, high: f64, name| within(x, T::from_f64(low), T::from_f64(high), name);
        check(self.turns, 1.0, 1e4, "turns")?;
        check(self.pole_area_m2, 1e-7, 1e-1, "pole_area_m2")?;
        check(self.gap_m, 1e-5, 1e-2, "gap_m")?;
        check(self.pole_angle_rad, 0.0, 1.2, "pole_angle_rad")?;
        check(self.iron_path_m, 0.0, 10.0, "iron_path_m")?;
        check(self.permeability, 10.0, 1e6, "permeability")?;
        check(self.leakage, 0.0, 1.0, "leakage")?;
        check(self.saturation_t, 0.1, 3.0, "saturation_t")
    }

    /// k, N·m²/A².
    pub fn k(&self) -> T {
        T::from_f64(MU_0 / 4.0) * self.turns * self.turns * self.pole_area_m2
    }

    /// δ, m: what the iron adds to the gap.
    pub fn iron_gap_m(&self) -> T {
        self.iron_path_m / (T::from_f64(2.0) * self.permeability)
    }

    /// The magnet as the law of forces sees it before any calibration.
    pub fn magnet(&self) -> Magnet<T> {
        let (_, cos) = self.pole_angle_rad.sin_cos();
        Magnet {
            gain: self.k() * cos,
            gap_offset_m: self.iron_gap_m(),
            saturation_a_per_m: self.saturation_t / self.flux_per_field(),
        }
    }

    /// B over i/(s + δ), T·m/A: µ₀N/2.
    pub fn flux_per_field(&self) -> T {
        T::from_f64(MU_0 / 2.0) * self.turns
    }

    /// Flux density at `current_a` and `gap_m`, iron not bending, T.
    pub fn flux_density_t(&self, current_a: T, gap_m: T) -> T {
        self.flux_per_field() * current_a / (gap_m + self.iron_gap_m())
    }

    /// Inductance of one coil at `gap_m`, H. Leakage does not change with the gap.
    pub fn inductance_h(&self, gap_m: T) -> T {
        let two_k = T::from_f64(2.0) * self.k();
        self.leakage * two_k / self.gap_m + two_k / (gap_m + self.iron_gap_m())
    }

    /// Current at which B reaches `flux_t` at rest, iron not bending, A.
    pub fn current_at_a(&self, flux_t: T) -> T {
        flux_t * (self.gap_m + self.iron_gap_m()) / self.flux_per_field()
    }

    /// Largest slope of the force of an axis, N/s, with `volts` left for the inductance:
    /// 2 cos α·i₀·U/(s₀ + δ). Turns and area cancel.
    pub fn slew_n_per_s(&self, bias_a: T, volts: T) -> T {
        let (_, cos) = self.pole_angle_rad.sin_cos();
        T::from_f64(2.0) * cos * bias_a * volts / (self.gap_m + self.iron_gap_m())
    }

    /// Largest amplitude of a sinusoidal force at `f_hz`, N: the smaller of what the slope
    /// allows and of k_i·i₀, where the weaker coil reaches zero current.
    pub fn peak_force_n(&self, bias_a: T, volts: T, f_hz: T) -> T {
        let by_slope = self.slew_n_per_s(bias_a, volts) / (T::from_f64(2.0) * T::PI * f_hz);
        let axis = self
            .magnet()
            .linear(bias_a, self.gap_m, self.pole_angle_rad);
        by_slope.min(axis.per_ampere * bias_a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal to the digits printed, or within 0.5 %, whichever is wider.
    fn as_printed(x: f64, printed: f64, last_digit: f64) -> bool {
        (x - printed).abs() <= (0.5 * last_digit).max(0.005 * printed)
    }

    #[test]
    fn five_designs_have_the_printed_figures() {
        // Turns, mm², B₀ T, kᵢ N/A, kₓ N/µm, L₀ mH, A at 1.2 T; last digits 0.001, 0.1,
        // 0.001, 0.01, 0.1.
        for (n, area, b0, ki, kx, l0, amps) in [
            (40.0, 60.0, 0.134, 4.0, 0.020, 0.40, 7.2),
            (60.0, 100.0, 0.201, 14.9, 0.073, 1.51, 4.8),
            (80.0, 100.0, 0.268, 26.4, 0.130, 2.68, 3.6),
            (100.0, 100.0, 0.335, 41.3, 0.203, 4.19, 2.9),
            (120.0, 100.0, 0.402, 59.4, 0.293, 6.03, 2.4),
        ] {
            let g = Geometry {
                turns: n,
                pole_area_m2: area * 1e-6,
                ..Geometry::textbook()
            };
            let linear = g.magnet().linear(0.8, g.gap_m, g.pole_angle_rad);
            assert!(as_printed(g.flux_density_t(0.8, g.gap_m), b0, 1e-3));
            // The knee of the iron, 1/(1 + r⁶), is in the derivatives: 0.14 % at 0.402 T.
            assert!(as_printed(linear.per_ampere, ki, 0.1), "{linear:?}");
            assert!(as_printed(linear.per_metre * 1e-6, kx, 1e-3), "{linear:?}");
            assert!(as_printed(1e3 * g.inductance_h(g.gap_m), l0, 0.01));
            assert!(as_printed(g.current_at_a(1.2), amps, 0.1));
        }
    }

    #[test]
    fn slope_and_peak_force_have_the_printed_figures() {
        let g = Geometry::<f64>::textbook();
        for (volts, slope, digit, peaks) in [
            (12.0, 1.2e5, 1e4, [18.8, 9.4, 3.8]),
            (24.0, 2.4e5, 1e4, [37.6, 18.8, 7.5]),
            (48.0, 4.7e5, 1e4, [75.0, 37.6, 15.1]),
        ] {
            assert!(as_printed(g.slew_n_per_s(0.8, volts), slope, digit));
            for (f, peak) in [1e3, 2e3, 5e3].into_iter().zip(peaks) {
                let capped = f64::min(peak, 33.0);
                let x = g.peak_force_n(0.8, volts, f);
                assert!(as_printed(x, capped, 0.1), "{volts} V {f} Hz: {x}");
            }
        }
    }

    #[test]
    fn leakage_adds_to_the_coil_and_not_to_the_gap() {
        let with = Geometry {
            leakage: 0.15,
            ..Geometry::<f64>::textbook()
        };
        let without = Geometry::<f64>::textbook();
        let at = |s| with.inductance_h(s) - without.inductance_h(s);
        assert!((at(150e-6) / 0.15 / without.inductance_h(150e-6) - 1.0).abs() < 1e-12);
        assert!((at(100e-6) - at(200e-6)).abs() < 1e-12);
        assert_eq!(with.magnet(), without.magnet());
    }

    #[test]
    fn fields_out_of_range_are_named() {
        let good = Geometry::<f64>::textbook();
        assert_eq!(good.validate(), Ok(()));
        let name = |g: Geometry<f64>| g.validate().unwrap_err();
        assert_eq!(
            name(Geometry {
                gap_m: f64::NAN,
                ..good
            }),
            CersError::OutOfRange { name: "gap_m" }
        );
        assert_eq!(
            name(Geometry {
                saturation_t: 5.0,
                ..good
            }),
            CersError::OutOfRange {
                name: "saturation_t"
            }
        );
    }
}
