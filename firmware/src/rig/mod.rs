//! The output duty: set points, ramps and limits of the coils and the valve.
//!
//! Rate: once a millisecond. No command exceeds a limit here: set points are checked when
//! they come, and cut again where they leave.

mod plan;

pub use plan::{LEASE_S, RigPlan, bar, limits, valve};

use crate::bar::BarDuty;
use crate::board::{BoxBoard, COILS, CoilAction, CoilOrder, CoilReport, DacCode, SensorCodes};
use crate::exciting::Exciting;
use plan::LEAST_SUPPLY_V;
use rarma_box::guard::{Denial, Mode, Permission, RigCodes, RigCoils, RigState, Steady};
use rarma_box::wire::{CircleJob, StandJob};

/// A supply that has not moved for this long is steady, ms.
const STEADY_MS: u32 = 50;

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
    steady: Steady,
    is_steady: bool,
    /// Signal on top of the bias.
    pub(crate) exciting: Exciting,
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
            steady: Steady::default(),
            is_steady: false,
            exciting: Exciting::default(),
            bar: BarDuty::default(),
        }
    }

    /// The plan of the stored settings, at the start.
    pub fn set_out(&mut self, plan: RigPlan) {
        self.plan = plan;
    }

    /// Outputs are about to be armed with this plan.
    pub fn arm(&mut self, plan: RigPlan) {
        self.plan = plan;
        self.wanted_a = plan.bias_a;
        self.wanted_pa = plan.rest_pa;
        self.fall();
        self.clear = true;
        self.steady = Steady::default();
        self.is_steady = false;
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

    /// The supply has come to rest.
    pub fn steady(&self) -> bool {
        self.is_steady
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
        self.now_a = if cers && self.exciting.runs() {
            // The bias waits until the signal has faded.
            self.now_a
        } else if cers {
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
        self.is_steady = self.steady.steady(state.supply_v, STEADY_MS);
        let at_work = cers && permission.rise && self.arrived;
        let quiet = self.exciting.order(cers && !permission.rise);
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
            tuning: self.plan.tunings(state.gap_m),
            quiet,
            force: Some(self.plan.force),
            limits: self.plan.coil_limits,
            clear: core::mem::take(&mut self.clear),
        };
        self.report = board.coils(&order);
        if at_work && let Some(signal) = self.exciting.start() {
            board.excite(&signal);
        }
        self.exciting.report(&self.report, &self.plan.path);
        let pa = if ldbb {
            command_pa.max(0.0).min(self.plan.limits.most_pa)
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
