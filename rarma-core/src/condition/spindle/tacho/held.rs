//! The last pulses of a tacho and the smooth rotation through them.

use crate::real::Real;
use crate::visit::state;

/// Pulses the speed is read off.
const HELD: usize = 12;
/// Least pulses of a reading, and least for one that follows a change of speed.
pub(super) const LEAST: usize = 3;
const LEAST_CURVED: usize = 6;

/// Time in samples from each pulse to the last one, and the count of pulses between;
/// newest first.
#[derive(Debug, Clone)]
pub(super) struct Held<T> {
    pulses: [(T, T); HELD],
    used: usize,
}

state! { Held<T> {
    pulses, used;
    where *used <= HELD
} }

impl<T: Real> Held<T> {
    /// No pulses.
    pub(super) fn new() -> Self {
        Self {
            pulses: [(T::ZERO, T::ZERO); HELD],
            used: 0,
        }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.used = 0;
    }

    /// Adds a pulse `count` after the last one.
    pub(super) fn add(&mut self, interval: T, count: T) {
        if self.used == 0 {
            self.used = 1;
            self.pulses[0] = (T::ZERO, T::ZERO);
        }
        self.used = (self.used + 1).min(HELD);
        self.pulses.rotate_right(1);
        self.pulses[0] = (T::ZERO, T::ZERO);
        for (time, index) in self.pulses.iter_mut().take(self.used).skip(1) {
            *time += interval;
            *index += count;
        }
    }

    /// Interval at the last pulse, its standard deviation, and the scatter of the
    /// pulses about the fit, samples.
    pub(super) fn fit(&self) -> Option<(T, T, T)> {
        let pulses = self.pulses.get(..self.used)?;
        if pulses.len() < LEAST {
            return None;
        }
        // Orthogonal polynomials over the counts: 1, a, q. Times and counts run
        // backwards from the last pulse.
        let n = T::from_u32(pulses.len() as u32);
        let mean = pulses.iter().map(|p| p.1).sum::<T>() / n;
        let mean_time = pulses.iter().map(|p| p.0).sum::<T>() / n;
        let (mut aa, mut aaa, mut at) = (T::ZERO, T::ZERO, T::ZERO);
        for (time, count) in pulses {
            let a = *count - mean;
            aa += a * a;
            aaa += a * a * a;
            at += a * (*time - mean_time);
        }
        let slope = at / aa;
        let (offset, tilt) = (aa / n, aaa / aa);
        let curved = pulses.len() >= LEAST_CURVED;
        let quadratic = |a: T| a * a - tilt * a - offset;
        let (mut qq, mut qt) = (T::ZERO, T::ZERO);
        for (time, count) in pulses {
            let q = quadratic(*count - mean);
            qq += q * q;
            qt += q * (*time - mean_time);
        }
        let bend = if curved { qt / qq } else { T::ZERO };
        let mut squares = T::ZERO;
        for (time, count) in pulses {
            let a = *count - mean;
            let off = *time - mean_time - slope * a - bend * quadratic(a);
            squares += off * off;
        }
        let free = n - T::from_f64(if curved { 3.0 } else { 2.0 });
        let variance = squares / free;
        // Slope where the count is 0, a = −mean.
        let lean = -T::from_f64(2.0) * mean - tilt;
        let interval = slope + bend * lean;
        let mut spread = T::ONE / aa;
        if curved {
            spread += lean * lean / qq;
        }
        if !(interval > T::ZERO) {
            return None;
        }
        Some((interval, (variance * spread).sqrt(), variance.sqrt()))
    }
}
