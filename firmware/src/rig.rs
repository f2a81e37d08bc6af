//! The output duty: set points, ramps and limits of the coils and the valve.
//!
//! Rate: once a millisecond. No command exceeds a limit here: set points are checked when
//! they come, and cut again where they leave.

use crate::bar::BarDuty;
use crate::board::{BoxBoard, COILS, DacCode, SensorCodes};
use crate::current_loop::{CoilAction, CoilLimits, CoilOrder, CoilReport};
use rarma_core::cers::{RegulatorConfig, Tuning};
use rarma_core::guard::{Denial, Mode, Permission, RigCodes, RigCoils, RigLimits, RigState};
use rarma_core::ldbb::{BarSet, ForceLaw, ValveConfig};
use rarma_core::settings::{
    CERS_BIAS, CERS_GAP, CERS_GAP_SPAN, CERS_INDUCTANCE, CERS_MOST, CERS_NOMINAL, CERS_OVERSPEED,
    CERS_RAMP, CERS_RESISTANCE, CERS_SPAN, CERS_THERMAL, CERS_TRIP, LDBB_CROSSOVER, LDBB_DITHER,
    LDBB_DITHER_RATE, LDBB_GAIN, LDBB_GAUGE_LIMIT, LDBB_GAUGE_SPAN, LDBB_INCLINATION, LDBB_LAG,
    LDBB_MOST, LDBB_OFFSET, LDBB_PRESSURE_SPAN, LDBB_RATE, LDBB_REST, LDBB_SETTLE, LDBB_TOLERANCE,
    LDBB_TRIM, LDBB_VALVE_SPAN, LDBB_WEIGHT, LDBB_WINDOW, LDBB_WINDOW_TIME, SUPPLY_HIGH,
    SUPPLY_LOW, SUPPLY_SPAN, Settings,
};
use rarma_core::wire::{CircleJob, StandJob};

/// An order of the current loop lasts this long, s: the main side may be late by two
/// milliseconds, no more.
pub const LEASE_S: f64 = 3e-3;
/// Gain crossover of the current loop as a part of its rate: 60° of phase margin.
const CROSSOVER: f32 = 1.0 / 18.0;
/// Largest duty: the rest of a period is for sampling.
const MOST_DUTY: f32 = 0.95;
/// The supply the regulators reckon with is never less than this, V.
const LEAST_SUPPLY_V: f32 = 5.0;

/// What the settings say about the outputs, as of the last arming.
#[derive(Debug, Clone, Copy)]
pub struct RigPlan {
    limits: RigLimits,
    coil_limits: CoilLimits,
    tuning: Tuning,
    bias_a: f32,
    ramp_s: f32,
    rest_pa: f32,
    valve: ValveConfig,
    bar: BarSet,
    valve_span_pa: f32,
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
        Ok(Self {
            tuning: regulator.tuning().map_err(|_| Denial::Settings)?,
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
            bias_a: s.real(CERS_BIAS),
            ramp_s: s.real(CERS_RAMP),
            rest_pa: s.real(LDBB_REST),
            valve: valve(s),
            bar: bar(s),
            valve_span_pa: s.real(LDBB_VALVE_SPAN),
        }
    }

    /// Limits and scales of the watch.
    pub fn limits(&self) -> &RigLimits {
        &self.limits
    }
}

/// Set points on their way.
#[derive(Debug)]
pub struct RigDuty {
    plan: RigPlan,
    /// Working point: A per coil, Pa.
    wanted_a: f32,
    wanted_pa: f32,
    /// Set points now.
    now_a: f32,
    now_pa: f32,
    clear: bool,
    report: CoilReport,
    last_periods: u32,
    arrived: bool,
    /// Valve loop and sequence of a circle.
    pub(crate) bar: BarDuty,
}

impl RigDuty {
    /// Everything off.
    pub fn new(plan: RigPlan) -> Self {
        Self {
            plan,
            wanted_a: 0.0,
            wanted_pa: 0.0,
            now_a: 0.0,
            now_pa: 0.0,
            clear: false,
            report: CoilReport::default(),
            last_periods: 0,
            arrived: true,
            bar: BarDuty::default(),
        }
    }

    /// Outputs are about to be armed with this plan.
    pub fn arm(&mut self, plan: RigPlan) {
        self.plan = plan;
        self.wanted_a = plan.bias_a;
        self.wanted_pa = plan.rest_pa;
        self.fall();
        self.clear = true;
    }

    /// Set points to nothing, at once.
    pub fn fall(&mut self) {
        self.now_a = 0.0;
        self.now_pa = 0.0;
        self.arrived = false;
        self.bar.fall();
    }

    /// The current loop is to forget its trip.
    pub fn clear(&mut self) {
        self.clear = true;
    }

    /// A new working point of the coils, A.
    ///
    /// # Errors
    /// [`Denial::Limit`].
    pub fn want_current(&mut self, a: f32) -> Result<(), Denial> {
        if !(a >= 0.0 && a <= self.plan.coil_limits.most_target_a) {
            return Err(Denial::Limit);
        }
        self.wanted_a = a;
        Ok(())
    }

    /// A new working point of the pressure, Pa.
    ///
    /// # Errors
    /// [`Denial::Limit`].
    pub fn want_pressure(&mut self, pa: f32) -> Result<(), Denial> {
        if !(pa >= 0.0 && pa <= self.plan.limits.most_pa) {
            return Err(Denial::Limit);
        }
        self.bar.end_test();
        self.wanted_pa = pa;
        Ok(())
    }

    /// A test of circles; after it the bar is held at rest.
    ///
    /// # Errors
    /// [`Denial::Limit`].
    pub fn want_circle(&mut self, job: &CircleJob) -> Result<(), Denial> {
        self.bar.want(job, &self.plan.bar)?;
        self.wanted_pa = self.plan.rest_pa;
        Ok(())
    }

    /// A static test; after it the bar is held at rest.
    ///
    /// # Errors
    /// [`Denial::Limit`].
    pub fn want_stand(&mut self, job: &StandJob) -> Result<(), Denial> {
        self.bar
            .want_stand(job, &self.plan.bar, self.plan.limits.gauge_limit_m)?;
        self.wanted_pa = self.plan.rest_pa;
        Ok(())
    }

    /// The plan in force.
    pub fn plan(&self) -> &RigPlan {
        &self.plan
    }

    /// The last report of the current loop.
    pub fn report(&self) -> &CoilReport {
        &self.report
    }

    /// The set points have arrived where the last permission sends them.
    pub fn arrived(&self) -> bool {
        self.arrived
    }

    /// The pressure set point, Pa.
    pub fn set_pa(&self) -> f32 {
        self.now_pa
    }

    /// One millisecond: moves the set points, orders coils and valve. `gate` is whether
    /// outputs are on now. False if the valve refused.
    pub fn step<B: BoxBoard>(
        &mut self,
        board: &mut B,
        mode: Mode,
        permission: Permission,
        gate: bool,
        state: &RigState,
    ) -> bool {
        let cers = gate && mode == Mode::Cers;
        let ldbb = gate && mode == Mode::Ldbb;
        let to = |wanted: f32, on: bool| if on && permission.rise { wanted } else { 0.0 };
        let a_ms = self.plan.bias_a / (1e3 * self.plan.ramp_s);
        self.now_a = if cers {
            toward(self.now_a, to(self.wanted_a, cers), a_ms)
        } else {
            0.0
        };
        let mut command_pa = 0.0;
        let wanted_pa = to(self.wanted_pa, ldbb);
        if ldbb {
            (self.now_pa, command_pa) =
                self.bar
                    .step(&self.plan.valve, wanted_pa, permission.rise, state);
        } else {
            self.now_pa = 0.0;
            self.bar.fall();
        }
        self.arrived = match mode {
            Mode::Cers => self.now_a == to(self.wanted_a, cers),
            // A test moves the set point by itself.
            Mode::Ldbb => self.now_pa == wanted_pa || self.bar.busy(),
            Mode::Safe | Mode::Monitor => true,
        };
        let order = CoilOrder {
            action: if permission.calibrate && mode == Mode::Cers {
                CoilAction::Calibrate
            } else if cers {
                CoilAction::Regulate
            } else {
                CoilAction::Off
            },
            target_a: [self.now_a; COILS],
            per_volt: 1.0 / state.supply_v.max(LEAST_SUPPLY_V),
            tuning: self.plan.tuning,
            limits: self.plan.coil_limits,
            clear: core::mem::take(&mut self.clear),
        };
        self.report = board.coils(&order);
        let pa = if ldbb {
            command_pa.clamp(0.0, self.plan.limits.most_pa)
        } else {
            0.0
        };
        board
            .valve(DacCode::from_fraction(pa / self.plan.valve_span_pa))
            .is_ok()
    }

    /// Whether the current loop has run since the last call.
    pub fn loop_ran(&mut self) -> bool {
        let ran = self.report.periods != self.last_periods;
        self.last_periods = self.report.periods;
        ran
    }

    /// The coils as the watch wants them. With switches open there is no current, whatever a
    /// sensor without a zero says.
    pub fn coils(&self) -> RigCoils {
        if !self.report.regulating {
            return RigCoils {
                ms: 1.0,
                ..RigCoils::default()
            };
        }
        RigCoils {
            current_a: self.report.current_a,
            square_a2: self.report.square_a2,
            duty: self.report.duty,
            ms: 1.0,
        }
    }
}

/// The codes as the watch wants them.
pub fn codes(sensors: &SensorCodes) -> RigCodes {
    RigCodes {
        gap: sensors.gap.map(|code| code.0),
        pressure: sensors.pressure.0,
        gauge: sensors.gauge.0,
        supply: sensors.supply.0,
    }
}

fn toward(now: f32, to: f32, step: f32) -> f32 {
    if now < to {
        (now + step).min(to)
    } else {
        (now - step).max(to)
    }
}
