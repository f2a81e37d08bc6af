//! What the settings say about the outputs: limits, scales, gains, the law of force.

use crate::board::{COILS, GAPS};
use crate::board::{CoilLimits, ForceScale};
use rarma_box::guard::{Denial, RigLimits};
use rarma_box::settings::{
    CERS_BIAS, CERS_GAIN_XM, CERS_GAIN_XP, CERS_GAIN_YM, CERS_GAIN_YP, CERS_GAP, CERS_GAP_CORNER,
    CERS_GAP_SPAN, CERS_INDUCTANCE, CERS_IRON_PATH, CERS_KNEE_XM, CERS_KNEE_XP, CERS_KNEE_YM,
    CERS_KNEE_YP, CERS_LAMINATION, CERS_LEAKAGE, CERS_MOST, CERS_NOMINAL, CERS_OFFSET_XM,
    CERS_OFFSET_XP, CERS_OFFSET_YM, CERS_OFFSET_YP, CERS_OVERSPEED, CERS_POLE_ANGLE, CERS_RAMP,
    CERS_RESISTANCE, CERS_SPAN, CERS_THERMAL, CERS_THERMISTOR, CERS_TRIP, CERS_WINDING_LIMIT, Key,
    LDBB_CROSSOVER, LDBB_DITHER, LDBB_DITHER_RATE, LDBB_GAIN, LDBB_GAUGE_LIMIT, LDBB_GAUGE_SPAN,
    LDBB_INCLINATION, LDBB_LAG, LDBB_MOST, LDBB_OFFSET, LDBB_PRESSURE_SPAN, LDBB_RATE, LDBB_REST,
    LDBB_SETTLE, LDBB_TOLERANCE, LDBB_TRIM, LDBB_VALVE_SPAN, LDBB_WEIGHT, LDBB_WINDOW,
    LDBB_WINDOW_TIME, Real, SUPPLY_HIGH, SUPPLY_LOW, SUPPLY_SPAN, Settings,
};
use rarma_rigs::cers::{
    AxisForce, Eddy, GapSchedule, Geometry, Magnet, Reach, RegulatorConfig, SensorPath, Tuning,
};
use rarma_rigs::ldbb::{BarSet, ForceLaw, ValveConfig};

/// An order of the current loop lasts this long, s: the main side may be late by two
/// milliseconds, no more.
pub const LEASE_S: f64 = 3e-3;
/// Gain crossover of the current loop as a part of its rate: 60° of phase margin.
const CROSSOVER: f32 = 1.0 / 18.0;
/// Largest duty: the rest of a period is for sampling.
const MOST_DUTY: f32 = 0.95;
/// The supply the regulators reckon with is never less than this, V.
pub(super) const LEAST_SUPPLY_V: f32 = 5.0;
/// Conductivity of silicon steel, S/m.
const STEEL_S_PER_M: f32 = 2e6;

/// What the settings say about the outputs, as of the last arming.
#[derive(Debug, Clone, Copy)]
pub struct RigPlan {
    pub(super) limits: RigLimits,
    pub(super) coil_limits: CoilLimits,
    pub(super) tuning: Tuning,
    schedule: Option<GapSchedule>,
    pub(super) force: ForceScale,
    pub(super) path: SensorPath,
    pub(super) bias_a: f32,
    pub(super) ramp_s: f32,
    pub(super) rest_pa: f32,
    pub(super) valve: ValveConfig,
    pub(super) bar: BarSet,
    pub(super) valve_span_pa: f32,
    inductance_h: f32,
    loop_hz: f32,
    calibrated: bool,
}

/// Limits and scales of the watch, as the settings have them now.
pub fn limits(s: &Settings) -> RigLimits {
    RigLimits {
        nominal_a: s.real(CERS_NOMINAL),
        thermal_s: s.real(CERS_THERMAL),
        resistance_ohm: s.real(CERS_RESISTANCE),
        gap_m: s.real(CERS_GAP),
        gap_span_m: s.real(CERS_GAP_SPAN),
        supply_v: (s.real(SUPPLY_LOW), s.real(SUPPLY_HIGH)),
        supply_span_v: s.real(SUPPLY_SPAN),
        winding_k: s.real(CERS_WINDING_LIMIT),
        thermistor_b_k: s.real(CERS_THERMISTOR),
        overspeed_hz: s.real(CERS_OVERSPEED),
        most_pa: s.real(LDBB_MOST),
        pressure_span_pa: s.real(LDBB_PRESSURE_SPAN),
        tolerance_pa: s.real(LDBB_TOLERANCE),
        settle_s: s.real(LDBB_SETTLE),
        lag_s: s.real(LDBB_LAG),
        gauge_span_m: s.real(LDBB_GAUGE_SPAN),
        gauge_limit_m: s.real(LDBB_GAUGE_LIMIT),
    }
}

/// What the valve loop may do.
pub fn valve(s: &Settings) -> ValveConfig {
    ValveConfig {
        rate_pa_s: s.real(LDBB_RATE),
        lag_s: s.real(LDBB_LAG),
        crossover_hz: s.real(LDBB_CROSSOVER),
        most_trim_pa: s.real(LDBB_TRIM),
        most_pa: s.real(LDBB_MOST),
        settle_pa: s.real(LDBB_WINDOW),
        settle_pa_s: s.real(LDBB_WINDOW),
        settle_s: s.real(LDBB_WINDOW_TIME),
        dither_pa: s.real(LDBB_DITHER),
        dither_hz: s.real(LDBB_DITHER_RATE),
    }
}

/// The ball bar as it stands.
pub fn bar(s: &Settings) -> BarSet {
    BarSet {
        law: ForceLaw {
            gain_n_per_pa: s.real(LDBB_GAIN),
            offset_n: s.real(LDBB_OFFSET),
        },
        inclination_rad: s.real(LDBB_INCLINATION),
        weight_n: s.real(LDBB_WEIGHT),
        most_pa: s.real(LDBB_MOST),
    }
}

impl RigPlan {
    /// The plan of these settings for a current loop of rate `loop_hz`.
    ///
    /// # Errors
    /// [`Denial::Settings`]: they contradict each other.
    pub fn new(s: &Settings, loop_hz: f64) -> Result<Self, Denial> {
        let limits = limits(s);
        let (bias, most, trip) = (s.real(CERS_BIAS), s.real(CERS_MOST), s.real(CERS_TRIP));
        let sound = bias <= most
            && most < trip
            && trip < 0.49 * s.real(CERS_SPAN)
            && limits.supply_v.0 < limits.supply_v.1
            && limits.supply_v.1 < limits.supply_span_v
            && limits.gap_m < 0.98 * limits.gap_span_m
            && s.real(LDBB_REST) <= limits.most_pa
            && limits.most_pa <= s.real(LDBB_VALVE_SPAN)
            && 1.1 * limits.most_pa < 1.05 * limits.pressure_span_pa
            && limits.gauge_limit_m < 0.49 * limits.gauge_span_m;
        if !sound {
            return Err(Denial::Settings);
        }
        let plan = Self::unchecked(s, loop_hz);
        let regulator = RegulatorConfig {
            inductance_h: s.real(CERS_INDUCTANCE),
            resistance_ohm: limits.resistance_ohm,
            rate_hz: loop_hz as f32,
            crossover: CROSSOVER,
            most_duty: MOST_DUTY,
        };
        let tuning = regulator.tuning().map_err(|_| Denial::Settings)?;
        let geometry = Geometry {
            gap_m: limits.gap_m,
            iron_path_m: s.real(CERS_IRON_PATH),
            leakage: s.real(CERS_LEAKAGE),
            ..Geometry::textbook()
        };
        Ok(Self {
            tuning,
            schedule: Some(GapSchedule::new(tuning, &geometry)),
            ..plan
        })
    }

    /// The scales of these settings, and regulators without gain: for watching, not for
    /// arming.
    pub fn unchecked(s: &Settings, loop_hz: f64) -> Self {
        Self {
            limits: limits(s),
            coil_limits: CoilLimits {
                span_a: s.real(CERS_SPAN),
                most_target_a: s.real(CERS_MOST),
                trip_a: s.real(CERS_TRIP),
                lease_periods: (LEASE_S * loop_hz) as u32,
                periods_per_ms: (loop_hz * 1e-3) as u32,
            },
            tuning: Tuning::default(),
            schedule: None,
            force: force_scale(s),
            path: sensor_path(s, &force_scale(s)),
            inductance_h: s.real(CERS_INDUCTANCE),
            loop_hz: loop_hz as f32,
            calibrated: MAGNETS.iter().all(|[gain, ..]| s.real(*gain) > 0.0),
            bias_a: s.real(CERS_BIAS),
            ramp_s: s.real(CERS_RAMP),
            rest_pa: s.real(LDBB_REST),
            valve: valve(s),
            bar: bar(s),
            valve_span_pa: s.real(LDBB_VALVE_SPAN),
        }
    }

    /// Coefficients of each coil at the gaps of now.
    pub(super) fn tunings(&self, gap_m: [f32; GAPS]) -> [Tuning; COILS] {
        let mut out = [self.tuning; COILS];
        let Some(schedule) = &self.schedule else {
            return out;
        };
        for ((pair, gap), law) in out.chunks_exact_mut(2).zip(gap_m).zip(&self.force.laws) {
            let closing = (law.gap_m - gap) * law.gap_per_displacement;
            if let [plus, minus] = pair {
                *plus = schedule.at(law.gap_m - closing);
                *minus = schedule.at(law.gap_m + closing);
            }
        }
        out
    }

    /// What coils and a supply of so many volts can do.
    /// `spindle_hz` as in [`Reach::spindle_hz`].
    pub fn reach(&self, supply_v: f32, spindle_hz: f32) -> Reach {
        Reach {
            rate_hz: self.loop_hz,
            bias_a: self.bias_a,
            most_a: self.coil_limits.most_target_a,
            volts: MOST_DUTY * supply_v,
            inductance_h: self.inductance_h,
            resistance_ohm: self.limits.resistance_ohm,
            proportional: self.tuning.proportional,
            calibrated: self.calibrated,
            spindle_hz,
        }
    }

    /// Limits and scales of the watch.
    pub fn limits(&self) -> &RigLimits {
        &self.limits
    }
}

/// Constants of the magnets: gain, gap offset, knee of +X, −X, +Y, −Y.
const MAGNETS: [[Key<Real>; 3]; COILS] = [
    [CERS_GAIN_XP, CERS_OFFSET_XP, CERS_KNEE_XP],
    [CERS_GAIN_XM, CERS_OFFSET_XM, CERS_KNEE_XM],
    [CERS_GAIN_YP, CERS_OFFSET_YP, CERS_KNEE_YP],
    [CERS_GAIN_YM, CERS_OFFSET_YM, CERS_KNEE_YM],
];

fn force_scale(s: &Settings) -> ForceScale {
    let [xp, xm, yp, ym] = MAGNETS.map(|[gain, offset, knee]| Magnet {
        gain: s.real(gain),
        gap_offset_m: s.real(offset),
        saturation_a_per_m: s.real(knee),
    });
    let law = |plus, minus| AxisForce::new(plus, minus, s.real(CERS_GAP), s.real(CERS_POLE_ANGLE));
    ForceScale {
        laws: [law(xp, xm), law(yp, ym)],
        gap_span_m: s.real(CERS_GAP_SPAN),
    }
}

fn sensor_path(s: &Settings, scale: &ForceScale) -> SensorPath {
    let bias = s.real(CERS_BIAS);
    let pull_n_per_m = scale.laws.map(|law| {
        let [_, _, pull] = law.derivatives(bias, bias, 0.0);
        pull
    });
    let lamination_m = s.real(CERS_LAMINATION);
    SensorPath {
        pull_n_per_m,
        corner_hz: s.real(CERS_GAP_CORNER),
        eddy: (lamination_m > 0.0).then(|| Eddy {
            lamination_m,
            conductivity_s_per_m: STEEL_S_PER_M,
            permeability: Geometry::<f32>::textbook().permeability,
            iron_path_m: s.real(CERS_IRON_PATH),
            gap_m: s.real(CERS_GAP),
        }),
    }
}
