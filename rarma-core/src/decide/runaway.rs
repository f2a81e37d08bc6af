//! Does a vibration grow by its own damping? The model says so where ζ is negative for certain, and
//! its power has risen meanwhile. Nothing but self-excitation does both: what is rung or forced
//! grows with what rings it, not by itself.
//!
//! Rate: decision rate.

use crate::real::Real;
use crate::visit::state;

/// ζ is negative for certain so many standard deviations below zero, where no speed is known and
/// where one is. Without a speed no line can call, and this is all there is: with 3, of the chatter of the
/// recordings 0.79 is told or warned of, with 2 it is 0.88. With a speed 2 tell no more, and noise
/// 60 dB below the signal raises an alarm in 2 of 87 quiet recordings more; with 1, no call comes
/// earlier.
const SDS: (f64, f64) = (2.0, 3.0);
/// The power has become this many times what it was when ζ became negative: 6 dB, more than a
/// lock-in wanders. Half as much calls no earlier where it grows, four times as much 0.02 s later in
/// the median of all (both with two standard deviations).
const GROWN: f64 = 4.0;
/// The model's own growth ∫−ζω dt explains at least this part of what was seen: it remembers 0.1 s, and
/// ζ follows a growth that has begun. Chosen by that, not varied.
const EXPLAINED: f64 = 0.5;

/// Growth of one mode.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Runaway<T> {
    /// Power when ζ became negative for certain; none while it is not.
    from: Option<T>,
    /// Logarithm of the growth of the amplitude since, by the model.
    by_model: T,
    is_certain: bool,
}

state! { Runaway<T> { from, by_model, is_certain } }

impl<T: Real> Default for Runaway<T> {
    fn default() -> Self {
        Self {
            from: None,
            by_model: T::ZERO,
            is_certain: false,
        }
    }
}

impl<T: Real> Runaway<T> {
    /// One decision: frequency, Hz, damping ratio with its standard deviation, and power of a mode;
    /// `period_s` since the last one. `knows_speed`: lines may call, too.
    pub fn note(
        &mut self,
        f_hz: T,
        (damping, sd): (T, T),
        power: T,
        knows_speed: bool,
        period_s: T,
    ) {
        let sds = if knows_speed { SDS.1 } else { SDS.0 };
        if !(damping + T::from_f64(sds) * sd < T::ZERO) {
            *self = Self::default();
            return;
        }
        let from = *self.from.get_or_insert(power);
        self.by_model -= damping * T::from_f64(2.0) * T::PI * f_hz * period_s;
        if from > T::ZERO && power > from * T::from_f64(GROWN) {
            let seen = T::from_f64(0.5) * (power / from).ln();
            self.is_certain |= self.by_model > T::from_f64(EXPLAINED) * seen;
        }
    }

    /// It grows by itself: from then on until its ζ is not negative for certain.
    pub fn is_certain(&self) -> bool {
        self.is_certain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;
    const F_HZ: f64 = 900.0;

    /// When a vibration is held to run away, s, that grows by `rate` a second and whose ζ is read
    /// as `damping`.
    fn called_s(rate: f64, damping: f64, sd: f64) -> Option<f64> {
        called_with_s(rate, (damping, sd), true)
    }

    fn called_with_s(rate: f64, damping: (f64, f64), knows_speed: bool) -> Option<f64> {
        let mut runaway = Runaway::<f64>::default();
        (0..250).find_map(|n| {
            let t = f64::from(n) * PERIOD_S;
            let power = 1e-6 * (2.0 * rate * t).exp().min(1e4);
            runaway.note(F_HZ, damping, power, knows_speed, PERIOD_S);
            runaway.is_certain().then_some(t)
        })
    }

    fn omega() -> f64 {
        core::f64::consts::TAU * F_HZ
    }

    #[test]
    fn what_grows_by_its_own_damping_is_held_after_six_decibels() {
        let zeta = -0.0035;
        let rate = -zeta * omega();
        let called = called_s(rate, zeta, 0.0004).expect("it grows");
        let six_db = 2f64.ln() / rate;
        assert!(
            (six_db..six_db + 2.0 * PERIOD_S).contains(&called),
            "{called}"
        );
    }

    #[test]
    fn what_does_not_grow_or_is_not_certain_is_not() {
        // A limit cycle reads next to zero and stays.
        assert_eq!(called_s(0.0, -0.001, 0.0001), None);
        // A mode that noise rings: negative by chance, and never for certain.
        assert_eq!(called_s(20.0, -0.0035, 0.002), None);
        // A damped one that something else makes louder.
        assert_eq!(called_s(20.0, 0.01, 0.001), None);
    }

    #[test]
    fn two_deviations_are_enough_where_no_speed_is_known() {
        let (zeta, sd) = (-0.0035, 0.0014);
        let rate = -zeta * omega();
        assert_eq!(called_with_s(rate, (zeta, sd), true), None);
        assert!(called_with_s(rate, (zeta, sd), false).is_some());
        assert_eq!(called_with_s(rate, (zeta, 0.002), false), None);
    }

    #[test]
    fn a_growth_that_the_model_does_not_explain_is_somebody_elses() {
        // An entry: forty times as fast as ζ says.
        let zeta = -0.0005;
        assert_eq!(called_s(-40.0 * zeta * omega(), zeta, 0.0001), None);
    }

    #[test]
    fn it_ends_with_the_certainty() {
        let mut runaway = Runaway::<f32>::default();
        for n in 0..100u16 {
            let power = (f32::from(n) * 0.1).exp();
            runaway.note(900.0, (-0.01, 0.001), power, true, 0.002);
        }
        assert!(runaway.is_certain());
        runaway.note(900.0, (-0.001, 0.001), 1e4, true, 0.002);
        assert!(!runaway.is_certain());
        runaway.note(900.0, (f32::NAN, 0.001), 1e4, true, 0.002);
        assert!(!runaway.is_certain());
    }
}
