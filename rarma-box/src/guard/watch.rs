//! Small judges of one signal: a count of bad readings, a value that never moves, the
//! heat of a winding, a pressure that should follow.
//!
//! Rate: once a millisecond unless said otherwise.

/// Bad readings in a row that are a fault.
#[derive(Debug, Clone, Copy, Default)]
pub struct InARow {
    run: u32,
}

impl InARow {
    /// Takes one reading; true from the `limit`-th bad one in a row on.
    #[inline]
    pub fn bad(&mut self, bad: bool, limit: u32) -> bool {
        self.run = if bad { self.run.saturating_add(1) } else { 0 };
        self.run >= limit
    }
}

/// A code that stays the same. Converters have noise of at least one code.
#[derive(Debug, Clone, Copy, Default)]
pub struct Still {
    last: u16,
    same: InARow,
}

impl Still {
    /// Takes one code; true when the last `limit` ones were all the same.
    #[inline]
    pub fn still(&mut self, code: u16, limit: u32) -> bool {
        let same = code == self.last;
        self.last = code;
        self.same.bad(same, limit)
    }
}

/// A value that has come to rest: within 2 % of where it was for so many milliseconds.
#[derive(Debug, Clone, Copy, Default)]
pub struct Steady {
    around: f32,
    run: u32,
}

/// A value further off than this part of itself has moved.
const STEADY_PART: f32 = 0.02;

impl Steady {
    /// Takes one value; true when the last `limit` ones were around the same.
    #[inline]
    pub fn steady(&mut self, value: f32, limit: u32) -> bool {
        if (value - self.around).abs() <= STEADY_PART * self.around.abs() {
            self.run = self.run.saturating_add(1);
        } else {
            self.around = value;
            self.run = 0;
        }
        self.run >= limit
    }
}

/// Temperature of a 10 kΩ thermistor from the supply of the converter to its input, with
/// 10 kΩ from there to ground, K.
///
/// ```text
/// R = 10 kΩ·(1 − u)/u,   1/T = 1/298.15 K + ln(R/10 kΩ)/B
/// ```
/// u is the part of the converter's range, B in K. A torn wire reads u = 0.
#[must_use]
pub fn thermistor_k(part: f32, b_k: f32) -> f32 {
    1.0 / (1.0 / 298.15 + libm::logf((1.0 - part) / part) / b_k)
}

/// Heat of a winding: dθ/dt = ((i/i_n)² − θ)/τ, full at 1.
///
/// At a steady i > i_n it is full after τ·ln(r/(r − 1)), r = (i/i_n)². Runs once a
/// millisecond from the mean square, not once a period: at 40 kHz and τ = 100 s a step
/// of 2.5·10⁻⁷ would drown in the rounding of single precision near 1.
#[derive(Debug, Clone, Copy, Default)]
pub struct Heat {
    theta: f32,
}

impl Heat {
    /// Takes the mean of (i/i_n)² over `dt_s`. A mean that is not finite counts as twice
    /// the nominal.
    #[inline]
    pub fn update(&mut self, ratio: f32, dt_s: f32, tau_s: f32) -> f32 {
        let ratio = if ratio.is_finite() { ratio } else { 4.0 };
        self.theta += dt_s * (ratio - self.theta) / tau_s;
        self.theta
    }

    /// How full it is, 0 to 1 and beyond.
    pub fn theta(&self) -> f32 {
        self.theta
    }
}

/// How a pressure misbehaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Disobedience {
    /// It does not move when it should.
    Stuck,
    /// It moves, but stays short of what it should be.
    Leak,
    /// It moves, but stays above what it should be.
    Over,
}

/// A pressure that should follow its set point like a first-order lag.
///
/// expected' = (set − expected)/τ. When the measured pressure is further off than the
/// tolerance for the settling time, the movements of the two since they parted tell which
/// it is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Follows {
    expected: f32,
    /// Expected and measured when they parted.
    parted: (f32, f32),
    off: InARow,
    started: bool,
}

impl Follows {
    /// Begins at the present pressure.
    pub fn reset(&mut self, measured: f32) {
        *self = Self {
            expected: measured,
            parted: (measured, measured),
            off: InARow::default(),
            started: true,
        };
    }

    /// One millisecond; all pressures in Pa, times in s.
    pub fn update(
        &mut self,
        set: f32,
        measured: f32,
        lag_s: f32,
        tolerance: f32,
        settle_s: f32,
    ) -> Option<Disobedience> {
        const DT_S: f32 = 1e-3;
        if !self.started {
            self.reset(measured);
        }
        self.expected += (DT_S / (lag_s + DT_S)) * (set - self.expected);
        let short = self.expected - measured;
        let off = !(short.abs() <= tolerance);
        if !off {
            self.parted = (self.expected, measured);
        }
        let limit = (settle_s / DT_S) as u32;
        if !self.off.bad(off, limit.max(1)) {
            return None;
        }
        let wanted = (self.expected - self.parted.0).abs();
        let moved = (measured - self.parted.1).abs();
        Some(if moved < 0.2 * wanted {
            Disobedience::Stuck
        } else if short > 0.0 {
            Disobedience::Leak
        } else {
            Disobedience::Over
        })
    }

    /// How far the pressure is short of the expected one, Pa.
    pub fn short(&self, measured: f32) -> f32 {
        self.expected - measured
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_is_what_has_not_moved() {
        let mut s = Steady::default();
        assert!((0..50).all(|k| !s.steady(48.0 + 0.01 * k as f32, 50)));
        assert!(s.steady(48.4, 50));
        assert!(!s.steady(50.0, 50));
        // A ramp of 2 % in 10 ms never is; nor is a value that is not a number.
        assert!((0..500).all(|k| !s.steady(10.0 + 0.1 * k as f32, 50)));
        assert!((0..500).all(|_| !s.steady(f32::NAN, 50)));
    }

    #[test]
    fn thermistors_read_what_their_tables_say() {
        // B = 3950 K: 10 kΩ at 25 °C, 3.588 kΩ at 50 °C, 0.697 kΩ at 100 °C.
        for (celsius, ohm) in [(25.0, 10e3), (50.0, 3588.0), (100.0, 697.0)] {
            let k = thermistor_k(10e3 / (10e3 + ohm), 3950.0);
            assert!((k - 273.15 - celsius).abs() < 0.2, "{celsius}: {k}");
        }
    }
}
