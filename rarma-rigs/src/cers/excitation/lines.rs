//! Which lines of a period are excited, and how strongly.

use crate::cers::error::{CersError, within};
use rarma_core::real::Real;

/// Which of the lines belong to a direction: X and Y at once are told apart by their lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineSet {
    /// All.
    All,
    /// 1, 3, 5 …
    Odd,
    /// 2, 4, 6 …
    Even,
}

/// Orders of a spindle that no line may be near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dodge<T> {
    /// Speed, revolutions/s, above 0.
    pub spindle_hz: T,
    /// Half the width about every multiple that stays free, Hz, above 0: the speed's
    /// uncertainty times the order, and the window's main lobe.
    pub clearance_hz: T,
}

/// The lines of a periodic signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lines<T> {
    spacing_hz: T,
    first: usize,
    last: usize,
    set: LineSet,
    dodge: Option<Dodge<T>>,
}

impl<T: Real> Lines<T> {
    /// Lines k·`spacing_hz` from `low_hz` to `high_hz`, of a set, none within the clearance
    /// of a multiple of the spindle's speed. The spacing is rate/N for a period of N
    /// samples.
    ///
    /// # Errors
    /// `OutOfRange`; `NoLines` if none is left.
    pub fn new(
        spacing_hz: T,
        (low_hz, high_hz): (T, T),
        set: LineSet,
        dodge: Option<Dodge<T>>,
    ) -> Result<Self, CersError> {
        let value = T::from_f64;
        within(spacing_hz, value(1e-3), value(1e4), "spacing_hz")?;
        within(low_hz, T::ZERO, value(1e6), "low_hz")?;
        within(high_hz, low_hz, value(1e6), "high_hz")?;
        if let Some(d) = dodge {
            within(d.spindle_hz, value(0.1), value(1e5), "spindle_hz")?;
            within(d.clearance_hz, value(1e-6), value(1e5), "clearance_hz")?;
        }
        let place = |f: T| f.to_f64() / spacing_hz.to_f64();
        let out = Self {
            spacing_hz,
            first: (libm::ceil(place(low_hz) - 1e-6) as usize).max(1),
            last: libm::floor(place(high_hz) + 1e-6) as usize,
            set,
            dodge,
        };
        if out.count() == 0 {
            return Err(CersError::NoLines);
        }
        Ok(out)
    }

    /// Line `k` is excited.
    pub fn has(&self, k: usize) -> bool {
        let mine = match self.set {
            LineSet::All => true,
            LineSet::Odd => k % 2 == 1,
            LineSet::Even => k.is_multiple_of(2),
        };
        if !mine || k < self.first || k > self.last {
            return false;
        }
        self.dodge.is_none_or(|d| {
            let orders = self.hz(k) / d.spindle_hz;
            let away = (orders - orders.round()).abs() * d.spindle_hz;
            // The mean force at order 0 is no disturbance.
            orders < T::from_f64(0.5) || away > d.clearance_hz
        })
    }

    /// Frequency of line `k`, Hz.
    pub fn hz(&self, k: usize) -> T {
        T::from_u32(k as u32) * self.spacing_hz
    }

    /// The lines by rising frequency.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        (self.first..=self.last).filter(|k| self.has(*k))
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.iter().count()
    }

    /// The last one.
    pub fn last(&self) -> usize {
        self.last
    }
}

/// Amplitude of the current over frequency that the supply can drive.
///
/// ```text
/// i(f) = i_most for f ≤ f_c = U/(2πL·i_most),   i_most·f_c/f above
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VoltageShape<T> {
    /// Voltage that is left for the inductance, V: supply·duty − R·i − drops, over the crest
    /// factor of the signal.
    pub volts: T,
    /// Inductance of a coil, H.
    pub inductance_h: T,
    /// Amplitude at low frequency, A; at most the bias.
    pub most_a: T,
}

impl<T: Real> VoltageShape<T> {
    /// f_c, Hz.
    pub fn corner_hz(&self) -> T {
        self.volts / (T::from_f64(2.0) * T::PI * self.inductance_h * self.most_a)
    }

    /// Amplitude at `f_hz`, A.
    pub fn amplitude_a(&self, f_hz: T) -> T {
        let corner = self.corner_hz();
        if f_hz > corner {
            self.most_a * corner / f_hz
        } else {
            self.most_a
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_is_near_an_order_and_few_are_lost() {
        let spacing = 20e3 / 4096.0;
        for rpm in [600.0, 5000.0, 18_000.0] {
            let dodge = Dodge {
                spindle_hz: rpm / 60.0,
                clearance_hz: 1.5,
            };
            let band = (50.0, 5000.0);
            let all = Lines::<f64>::new(spacing, band, LineSet::All, None).unwrap();
            let some = Lines::new(spacing, band, LineSet::All, Some(dodge)).unwrap();
            for k in some.iter() {
                let f = all.hz(k);
                let order = (f / dodge.spindle_hz).round();
                let away = (f - order * dodge.spindle_hz).abs();
                assert!(order == 0.0 || away > 1.5, "{f} Hz, order {order}");
            }
            let lost = 1.0 - some.count() as f64 / all.count() as f64;
            let due = 3.0 / dodge.spindle_hz;
            assert!((lost - due).abs() < 0.05 + 0.2 * due, "{rpm}: {lost} {due}");
        }
    }

    #[test]
    fn odd_and_even_share_nothing_and_leave_nothing() {
        let of = |set| Lines::<f32>::new(5.0, (100.0, 2000.0), set, None).unwrap();
        let (odd, even, all) = (of(LineSet::Odd), of(LineSet::Even), of(LineSet::All));
        assert_eq!(odd.count() + even.count(), all.count());
        assert!(odd.iter().all(|k| !even.has(k)));
        assert_eq!(all.iter().next(), Some(20));
        assert_eq!(all.iter().last(), Some(400));
    }

    #[test]
    fn a_comb_that_leaves_nothing_is_refused() {
        let dodge = Dodge {
            spindle_hz: 10.0,
            clearance_hz: 6.0,
        };
        let none = Lines::<f64>::new(5.0, (100.0, 2000.0), LineSet::All, Some(dodge));
        assert_eq!(none, Err(CersError::NoLines));
    }

    #[test]
    fn the_corner_is_the_published_one() {
        let shape = VoltageShape {
            volts: 48.0,
            inductance_h: 4.19e-3,
            most_a: 0.8,
        };
        let corner: f64 = shape.corner_hz();
        assert!((corner / 2.3e3 - 1.0).abs() < 0.015, "{corner}");
        assert_eq!(shape.amplitude_a(1e3), 0.8);
        assert!((shape.amplitude_a(2.0 * corner) - 0.4).abs() < 1e-12);
    }
}
