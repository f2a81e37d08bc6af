//! The pressure: ramps, a slow outer loop on the transducer, dither, and when it is settled.
//!
//! Rate: once a millisecond. The regulator has a loop of its own, good to 1 % of its range and
//! 0.5 % hysteresis (5.7 N); the outer loop takes that out, slower than the regulator so that
//! the two do not fight.

/// What the loop may do, SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValveConfig {
    /// The reference moves no faster, Pa/s.
    pub rate_pa_s: f32,
    /// Lag of regulator and cylinder, s.
    pub lag_s: f32,
    /// Crossover of the outer loop, Hz; 0 switches it off. At 0.5 Hz, a lag of 0.1 s (taken
    /// out by the proportional part) and 20 ms of dead time leave 86° of phase.
    pub crossover_hz: f32,
    /// The outer loop adds or takes no more than this, Pa: what a sound regulator is off.
    /// A leak or a stuck valve needs more, and shows.
    pub most_trim_pa: f32,
    /// Greatest pressure the regulator is asked for, Pa.
    pub most_pa: f32,
    /// Settled: nearer than this, Pa,
    pub settle_pa: f32,
    /// moving slower than this, Pa/s,
    pub settle_pa_s: f32,
    /// for this long, s.
    pub settle_s: f32,
    /// Amplitude of the dither, Pa, and its frequency, Hz.
    pub dither_pa: f32,
    /// See [`Self::dither_pa`].
    pub dither_hz: f32,
}

impl Default for ValveConfig {
    fn default() -> Self {
        Self {
            rate_pa_s: 1e6,
            lag_s: 0.1,
            crossover_hz: 0.5,
            most_trim_pa: 2.5e4,
            most_pa: 9e5,
            settle_pa: 2e3,
            settle_pa_s: 2e3,
            settle_s: 1.0,
            dither_pa: 5e3,
            dither_hz: 7.0,
        }
    }
}

/// What comes out in one millisecond.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ValveOut {
    /// What the regulator is asked for, Pa.
    pub command_pa: f32,
    /// Reference on its ramp, Pa: what the watch compares the transducer with.
    pub reference_pa: f32,
    /// The reference has arrived, and the pressure is settled there.
    pub settled: bool,
    /// The outer loop is at its limit: the regulator is not what it was.
    pub limiting: bool,
}

/// Smoothing of the transducer, s, and the slower one whose distance tells the slope.
const FAST_S: f32 = 0.1;
const SLOW_S: f32 = 0.6;
/// The outer loop works while the expected pressure is within this of the reference, Pa.
const STILL_PA: f32 = 500.0;

/// Controls the pressure.
#[derive(Debug, Clone, Copy, Default)]
pub struct ValveLoop {
    reference_pa: f32,
    expected_pa: f32,
    fast_pa: f32,
    slow_pa: f32,
    integral_pa: f32,
    quiet_s: f32,
    phase: f32,
    started: bool,
}

impl ValveLoop {
    /// Everything from zero: the valve has been vented.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Reference, Pa.
    pub fn reference_pa(&self) -> f32 {
        self.reference_pa
    }

    /// One step of `dt_s`. A measured pressure that is not finite stops the outer loop where
    /// it is; that the transducer is gone is the watch's to say.
    pub fn step(
        &mut self,
        c: &ValveConfig,
        dt_s: f32,
        set_pa: f32,
        measured_pa: f32,
        dither: bool,
    ) -> ValveOut {
        let set_pa = within(set_pa, 0.0, c.most_pa);
        let step = c.rate_pa_s * dt_s;
        self.reference_pa += within(set_pa - self.reference_pa, -step, step);
        let part = |tau_s: f32| dt_s / (tau_s + dt_s);
        self.expected_pa += part(c.lag_s) * (self.reference_pa - self.expected_pa);
        let mut limiting = false;
        let mut trim_pa = self.integral_pa;
        if measured_pa.is_finite() {
            if !self.started {
                self.started = true;
                self.fast_pa = measured_pa;
                self.slow_pa = measured_pa;
                self.expected_pa = measured_pa;
            }
            self.fast_pa += part(FAST_S) * (measured_pa - self.fast_pa);
            self.slow_pa += part(SLOW_S) * (measured_pa - self.slow_pa);
            // While the reference moves, the regulator's dead time is an error that is none:
            // it would be wound up and overshoot by 6 % of a step.
            if (self.reference_pa - self.expected_pa).abs() < STILL_PA {
                let ki = core::f32::consts::TAU * c.crossover_hz;
                let wanted = self.integral_pa + ki * dt_s * (self.expected_pa - measured_pa);
                self.integral_pa = within(wanted, -c.most_trim_pa, c.most_trim_pa);
                limiting = self.integral_pa != wanted;
                let raw = self.integral_pa + ki * c.lag_s * (self.expected_pa - self.fast_pa);
                trim_pa = within(raw, -c.most_trim_pa, c.most_trim_pa);
            }
        }
        let slope = (self.fast_pa - self.slow_pa) / (SLOW_S - FAST_S);
        let quiet = self.reference_pa == set_pa
            && !dither
            && (self.fast_pa - set_pa).abs() < c.settle_pa
            && slope.abs() < c.settle_pa_s;
        self.quiet_s = if quiet { self.quiet_s + dt_s } else { 0.0 };
        let mut command_pa = self.reference_pa + trim_pa;
        if dither {
            self.phase += c.dither_hz * dt_s;
            if self.phase >= 1.0 {
                self.phase -= 1.0;
            }
            // A triangle: no function call, and its corners are beyond the regulator.
            let triangle = 4.0 * (self.phase - 0.5).abs() - 1.0;
            command_pa += c.dither_pa * triangle;
        }
        ValveOut {
            command_pa: if set_pa > 0.0 || self.reference_pa > 0.0 {
                within(command_pa, 0.0, c.most_pa)
            } else {
                0.0
            },
            reference_pa: self.reference_pa,
            settled: self.quiet_s >= c.settle_s,
            limiting,
        }
    }
}

/// `x` between two limits. Unlike `clamp` it cannot panic, whatever the limits are, and NaN becomes
/// the lower one.
fn within(x: f32, low: f32, high: f32) -> f32 {
    x.max(low).min(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A regulator 1 % off with lag and dead time.
    fn settle(leak: f32) -> (f32, f32, bool, f32) {
        let c = ValveConfig::default();
        let mut valve = ValveLoop::default();
        let (mut p, mut line) = (0.0f32, [0.0f32; 20]);
        let (mut over, mut settled_at, mut limiting) = (0.0f32, f32::INFINITY, false);
        for k in 0..10_000usize {
            let out = valve.step(&c, 1e-3, 4e5, p, false);
            let asked = core::mem::replace(&mut line[k % 20], out.command_pa);
            p += (asked * 1.01 * (1.0 - leak) - p) * (1e-3 / 0.101);
            over = over.max(p - 4e5);
            if out.settled && settled_at.is_infinite() {
                settled_at = 1e-3 * k as f32;
            }
            limiting = out.limiting;
        }
        (p, settled_at, limiting, over)
    }

    #[test]
    fn the_regulators_error_is_taken_out() {
        let (p, settled_at, limiting, over) = settle(0.0);
        assert!((p - 4e5).abs() < 50.0 && !limiting, "{p}");
        // It rests while the set point ramps; 1 % is taken out in 4.9 s.
        assert!((4.0..6.0).contains(&settled_at), "{settled_at} s");
        assert!(over < 4.2e3, "{over} Pa over");
    }

    #[test]
    fn a_leak_is_not_hidden() {
        let (p, settled_at, limiting, _) = settle(0.3);
        assert!(limiting && settled_at.is_infinite());
        assert!(p < 3.2e5, "{p}");
    }

    #[test]
    fn no_pressure_means_none_and_nan_is_not_followed() {
        let c = ValveConfig::default();
        let mut valve = ValveLoop::default();
        for _ in 0..100 {
            assert_eq!(valve.step(&c, 1e-3, 0.0, 3e3, false).command_pa, 0.0);
        }
        let out = valve.step(&c, 1e-3, 1e5, f32::NAN, true);
        assert!(out.command_pa.is_finite() && !out.settled);
    }
}
