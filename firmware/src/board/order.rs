//! What the main side and the current loop tell each other, once a millisecond.

use super::COILS;
use rarma_box::guard::FaultCode;
use rarma_rigs::cers::{AxisForce, Block, Tuning};

/// What the loop is to do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum CoilAction {
    /// Nothing: switches open.
    #[default]
    Off,
    /// Switches open; take the mean of the currents as their zeros.
    Calibrate,
    /// Regulate to the targets.
    Regulate,
}

/// What the loop may never exceed, and how it reads its sensors.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CoilLimits {
    /// Current from one end of the sensor's range to the other, A; zero is in its middle.
    pub span_a: f32,
    /// A target is cut to 0..=this, A.
    pub most_target_a: f32,
    /// A measured current beyond this is a fault, A.
    pub trip_a: f32,
    /// An order lasts this many periods.
    pub lease_periods: u32,
    /// Periods in 1 ms.
    pub periods_per_ms: u32,
}

/// What turns currents and gaps into forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceScale {
    /// Law of x and of y.
    pub laws: [AxisForce<f32>; 2],
    /// Gap from one end of a displacement sensor's range to the other, m.
    pub gap_span_m: f32,
}

/// What the main side tells the loop. Any order renews the lease.
#[derive(Debug, Clone, Copy, Default)]
pub struct CoilOrder {
    /// What to do.
    pub action: CoilAction,
    /// Currents wanted, A.
    pub target_a: [f32; COILS],
    /// 1/supply voltage, 1/V.
    pub per_volt: f32,
    /// Coefficients of each coil, for its gap of now.
    pub tuning: [Tuning; COILS],
    /// The signal that runs is to fade out.
    pub quiet: bool,
    /// Needed by a signal that measures.
    pub force: Option<ForceScale>,
    /// Limits.
    pub limits: CoilLimits,
    /// Forget a trip.
    pub clear: bool,
}

/// Why the loop has let go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoilTrip {
    /// What.
    pub code: FaultCode,
    /// Which coil.
    pub coil: u8,
    /// With which value, in the unit of the code.
    pub value: f32,
}

/// What the loop tells the main side: means since the last exchange.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CoilReport {
    /// Periods since start-up.
    pub periods: u32,
    /// Periods in the means below.
    pub counted: u32,
    /// Mean current, A.
    pub current_a: [f32; COILS],
    /// Mean square of the current, A².
    pub square_a2: [f32; COILS],
    /// Mean duty.
    pub duty: [f32; COILS],
    /// Currents that were measured as zero, A.
    pub zero_a: [f32; COILS],
    /// Switches may be closed.
    pub regulating: bool,
    /// A target was cut, or the supply held a current back.
    pub limiting: bool,
    /// Why the loop has let go, since it has.
    pub trip: Option<CoilTrip>,
    /// A signal runs.
    pub exciting: bool,
    /// Periods since start-up in which the signal's current was held back by the supply.
    pub limited: u32,
    /// A block of a line that has just been measured.
    pub block: Option<Block>,
}
