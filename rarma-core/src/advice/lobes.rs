//! The lobes of one mode in closed form.
//!
//! A cut of load h is unstable in lobe j = 0, 1, 2, … between its two flanks. On a flank the
//! limit is met at a frequency r = f/f_m where −2h·Re G(r) = 1, G = 1/(1 − r² + 2jζr): with
//! x = r² − 1
//!
//! ```text
//! x² + 4ζ²·(1 + x) = ±4h·x                        + above the mode, − below
//! ```
//!
//! a quadratic with two roots, and the fraction of a wave that goes with each is
//! e = ½ + atan(2ζr/x)/π. With W = f_m/(n·N) a speed lies in lobe j where
//! r₁·W − e₁ < j < r₂·W − e₂. A speed is stable where no j ≥ 0 does.
//!
//! From it the number of waves from which on pockets have merged: lobe k ends above the
//! beginning of lobe k − 1 for k > (e₂·r₁ + (1 − e₁)·r₂)/(r₂ − r₁). At d times the least limit and a
//! small damping that is about (½ + (2/π)·atan(1/(d + √(d² − 1))))/(2ζ·√(d² − 1)): 0.33/ζ at
//! d = 1.5, 0.19/ζ at 2, 0.11/ζ at 3.

use crate::real::Real;

/// A margin that is looked for at most.
pub const MOST_MARGIN: f64 = 8.0;
/// Steps of its bisection.
const HALVINGS: u32 = 16;

/// On which side of its mode chatter lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Above: as in turning.
    Above,
    /// Below: the cut pulls the other way round.
    Below,
}

impl Side {
    pub(super) fn sign<T: Real>(self) -> T {
        match self {
            Self::Above => T::ONE,
            Self::Below => -T::ONE,
        }
    }
}

/// A flank of every lobe: the frequency over that of the mode, and the fraction of a wave.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Flank<T> {
    ratio: T,
    part: T,
}

/// The lobes of a cut of one depth against one mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobes<T> {
    natural_hz: T,
    zeta: T,
    load: T,
    side: Side,
    teeth: T,
    /// None where the cut is stable at every speed.
    flanks: Option<[Flank<T>; 2]>,
}

impl<T: Real> Lobes<T> {
    /// For a mode of this frequency, Hz, and damping ratio, both > 0, a load K·b/(2k_m) > 0,
    /// and so many teeth.
    pub fn new(natural_hz: T, zeta: T, load: T, side: Side, teeth: u32) -> Self {
        Self {
            natural_hz,
            zeta,
            load,
            side,
            teeth: T::from_u32(teeth),
            flanks: flanks(zeta, load, side),
        }
    }

    /// Waves of the mode between two teeth at a speed, turns a second.
    pub fn waves_at(&self, spindle_hz: T) -> T {
        self.natural_hz / (spindle_hz * self.teeth)
    }

    /// Frequency of the mode, Hz.
    pub fn natural_hz(&self) -> T {
        self.natural_hz
    }

    /// Whether a cut at this speed, turns a second, is stable.
    pub fn is_stable(&self, spindle_hz: T) -> bool {
        let Some([low, high]) = self.flanks else {
            return true;
        };
        let waves = self.waves_at(spindle_hz);
        let from = low.ratio * waves - low.part;
        let to = high.ratio * waves - high.part;
        let first = (floor(from) + T::ONE).max(T::ZERO);
        !(first < to)
    }

    /// How many times deeper the cut may be at this speed before it loses its stability: from
    /// 1 to [`MOST_MARGIN`]; 1 where it is unstable.
    pub fn margin(&self, spindle_hz: T) -> T {
        self.limit(spindle_hz, T::ONE)
    }

    /// The depth at which the cut loses its stability at this speed, over the depth that it has: the lobes
    /// as they are drawn. From `least` > 0 to [`MOST_MARGIN`], the ends where it lies beyond.
    pub fn limit(&self, spindle_hz: T, least: T) -> T {
        let deeper = |times: T| Self {
            flanks: flanks(self.zeta, self.load * times, self.side),
            ..*self
        };
        let (mut low, mut high) = (least, T::from_f64(MOST_MARGIN));
        if deeper(high).is_stable(spindle_hz) {
            return high;
        }
        for _ in 0..HALVINGS {
            let middle = (low + high) * T::from_f64(0.5);
            if deeper(middle).is_stable(spindle_hz) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Damping ratio of the mode, load of the cut on it, and the side on which it chatters.
    pub fn of_mode(&self) -> (T, T, Side) {
        (self.zeta, self.load, self.side)
    }

    /// Waves between two teeth from which on there are no pockets any more: the lobes have
    /// merged. `None` where the cut is stable at every speed.
    pub fn most_waves(&self) -> Option<T> {
        let [low, high] = self.flanks?;
        let apart = (high.ratio - low.ratio).max(T::EPSILON);
        Some((high.part * low.ratio + (T::ONE - low.part) * high.ratio) / apart)
    }
}

/// The largest whole number that is not above x.
pub(super) fn floor<T: Real>(x: T) -> T {
    let near = x.round();
    if near > x { near - T::ONE } else { near }
}

fn flanks<T: Real>(zeta: T, load: T, side: Side) -> Option<[Flank<T>; 2]> {
    let two = T::from_f64(2.0);
    let sign: T = side.sign();
    let least = two * zeta * zeta;
    let middle = two * load - sign * least;
    let under = middle * middle - two * least;
    if !(middle > T::ZERO && under > T::ZERO) {
        return None;
    }
    let spread = under.sqrt();
    let (low, high) = (sign * middle - spread, sign * middle + spread);
    // At the very limit of this form the frequency would be imaginary: the cut is far stiffer
    // than the mode there.
    let flank = |x: T| {
        let x = x.max(T::from_f64(-0.99));
        let ratio = (T::ONE + x).sqrt();
        let angle = (two * zeta * ratio).atan2(x.abs()) / T::PI;
        let half = T::from_f64(0.5);
        Flank {
            ratio,
            part: half + sign * angle,
        }
    };
    Some([flank(low), flank(high)])
}
