//! Settings of the sequence of a circle.

/// The gauge must have been this far outside before a crossing counts, m.
pub(super) const OUTSIDE_M: f32 = 20e-6;

/// 10 N a run. A seal of 1.5 N turns the force round by 3 N, once on the way in and once
/// within the turn. Without it a loop of 4.5 µm is 0.22 µm too narrow, with 3 kPa 0.10, with
/// 5 kPa 0.06, with 8 kPa 0.03, with 16 kPa 0.01 µm.
const WAY_DOWN_CREEP_PA: f32 = 8e3;

/// The circle and its limits, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProcedureConfig {
    /// Radius, m.
    pub radius_m: f32,
    /// Feed, m/s.
    pub feed_m_s: f32,
    /// Where a counter-clockwise arc begins, and a clockwise one ends, rad.
    pub start_rad: f32,
    /// Length of the arc, rad, up to 390°.
    pub sweep_rad: f32,
    /// Of it, at each end, not captured, rad.
    pub overshoot_rad: f32,
    /// Trigger length of the gauge, m; the machine waits further out than this.
    pub trigger_m: f32,
    /// From the trigger to the arc's beginning, s: trigger length over feed, and the
    /// program's pause there.
    pub lead_s: f32,
    /// Longest wait for the machine to start, s.
    pub wait_s: f32,
    /// Longest time for a pressure to settle, s.
    pub settle_most_s: f32,
    /// Dither after a new pressure, s.
    pub dither_s: f32,
    /// From on-trigger to the arc's end the pressure goes on by this, Pa, the way it came:
    /// up on the way up, down on the way down; 0 where it is to stay. The force of the seal
    /// turns round with the bar's length, and a force that turns round narrows the loop of
    /// the machine's hysteresis; one that goes on does not.
    pub creep_pa: f32,
    /// The feed may be off by this part.
    pub feed_part: f32,
    /// A reversal of an axis may come early or late by this, rad: at 2.5° the feed of half a turn
    /// is 1.4 % off.
    pub feed_within_rad: f32,
    /// Pressure that holds the bar while the machine moves, Pa.
    pub holding_pa: f32,
    /// The pressure may leave its set point by this during a run, Pa.
    pub drift_pa: f32,
    /// Gauge beyond ± this ends the test, m.
    pub gauge_limit_m: f32,
}

impl Default for ProcedureConfig {
    /// The thesis' circle: 150 mm, 1000 mm/min, 390°, of which 15° at each end overshoot.
    fn default() -> Self {
        let degree = core::f32::consts::PI / 180.0;
        Self {
            radius_m: 0.15,
            feed_m_s: 1.0 / 60.0,
            start_rad: -15.0 * degree,
            sweep_rad: 390.0 * degree,
            overshoot_rad: 15.0 * degree,
            trigger_m: 250e-6,
            lead_s: 250e-6 * 60.0 + 0.5,
            wait_s: 60.0,
            settle_most_s: 20.0,
            dither_s: 1.0,
            creep_pa: 0.0,
            feed_part: 0.02,
            feed_within_rad: 2.5 * degree,
            holding_pa: 4e4,
            drift_pa: 5e3,
            gauge_limit_m: 0.9e-3,
        }
    }
}

impl ProcedureConfig {
    /// The same for a test that comes down again and asks for the hysteresis: no dither,
    /// which would shake loose the friction whose hysteresis is sought, and a pressure that
    /// goes on ([`Self::creep_pa`]).
    #[must_use]
    pub fn with_way_down(self) -> Self {
        Self {
            dither_s: 0.0,
            creep_pa: WAY_DOWN_CREEP_PA,
            ..self
        }
    }

    /// Time of the arc at the programmed feed, s.
    pub fn arc_s(&self) -> f32 {
        self.sweep_rad * self.radius_m / self.feed_m_s
    }

    /// Every number is one, and they fit together.
    pub fn is_sound(&self) -> bool {
        let most_sweep = 390.5 * core::f32::consts::PI / 180.0;
        let positive = [
            self.radius_m,
            self.feed_m_s,
            self.sweep_rad,
            self.trigger_m,
            self.lead_s,
            self.wait_s,
            self.settle_most_s,
            self.feed_part,
            self.feed_within_rad,
            self.holding_pa,
            self.drift_pa,
            self.gauge_limit_m,
        ];
        positive.iter().all(|x| x.is_finite() && *x > 0.0)
            && self.start_rad.is_finite()
            && self.sweep_rad <= most_sweep
            && self.overshoot_rad >= 0.0
            && self.dither_s >= 0.0
            && self.creep_pa >= 0.0
            && self.creep_pa.is_finite()
            && 2.0 * self.overshoot_rad < self.sweep_rad
            && self.trigger_m + OUTSIDE_M < self.gauge_limit_m
            && self.feed_part < 0.1
    }
}
