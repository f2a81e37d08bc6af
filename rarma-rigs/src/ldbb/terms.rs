//! What each machine error adds to the length of the bar.

use rarma_core::real::Real;

/// Terms there can be: twelve of the machine, two for a cyclic error of each axis.
pub const MAX_TERMS: usize = 16;
const TERMS: usize = 12;

/// Direction of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sense {
    /// Counter-clockwise, from +X towards +Y: d = +1.
    Ccw,
    /// Clockwise: d = −1.
    Cw,
}

impl Sense {
    /// d.
    pub fn sign<T: Real>(self) -> T {
        match self {
            Self::Ccw => T::ONE,
            Self::Cw => -T::ONE,
        }
    }

    /// As it is spelled in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ccw => "ccw",
            Self::Cw => "cw",
        }
    }

    /// The other one.
    pub const fn reversed(self) -> Self {
        match self {
            Self::Ccw => Self::Cw,
            Self::Cw => Self::Ccw,
        }
    }
}

/// The circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle<T> {
    /// Radius, m.
    pub radius_m: T,
    /// Feed along it, m/s.
    pub feed_m_s: T,
    /// Pitch of a cyclic error that is sought, m; 0: none.
    pub pitch_m: T,
}

/// Which terms are fitted.
///
/// | k | column | coefficient, m |
/// |---|---|---|
/// | 0 | 1 | radius |
/// | 1, 2 | cos θ, sin θ | centre |
/// | 3, 4 | cos 2θ, sin 2θ | C2 = R(sx − sy)/2, S2 = −βR/2 |
/// | 5, 6 | cos 3θ, sin 3θ | C3 = −cY/4, S3 = cX/4 |
/// | 7, 8 | d/2·sgn(sin θ)·cos θ, −d/2·sgn(cos θ)·sin θ | backlash of X, Y |
/// | 9, 10 | −d/2·\|sin θ\|, d/2·\|cos θ\| | lateral play of X, Y |
/// | 11 | d·sin 2θ | v(τx − τy)/2 |
/// | 12 to 15 | cos θ·(sin, cos)(2πR·cos θ/P), sin θ·(sin, cos)(2πR·sin θ/P) | cyclic error of X, Y |
///
/// Where they come from: a machine error (ex, ey) makes the bar longer by ex·cos θ + ey·sin θ,
/// and by e²/2R more, which is left out (8 nm at 50 µm).
///
/// *Both directions*: all twelve; condition 7.5. *One direction*: the servo's term is the
/// squareness', and lateral play is nearly radius and cos 2θ (condition 58): the first nine.
/// *Part of a circle*: the first five.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Terms {
    /// Of the twelve, how many.
    pub machine: usize,
    /// Cyclic errors as well.
    pub cyclic: bool,
}

impl Terms {
    /// The most that readings of this kind determine.
    pub const fn of(both: bool, covered_deg: f32, cyclic: bool) -> Self {
        let whole = covered_deg >= 345.0;
        Self {
            machine: if !whole {
                5
            } else if both {
                TERMS
            } else {
                9
            },
            cyclic: cyclic && whole,
        }
    }

    /// How many.
    pub const fn count(self) -> usize {
        self.machine + if self.cyclic { 4 } else { 0 }
    }

    /// The row of a reading at θ.
    ///
    /// At a reversal itself (sin θ or cos θ exactly 0) an axis stands: its sign is 0.
    pub fn row<T: Real>(self, theta: T, sense: Sense, circle: &Circle<T>) -> [T; MAX_TERMS] {
        let (s, c) = theta.sin_cos();
        let two = T::from_f64(2.0);
        let (s2, c2) = (two * s * c, c * c - s * s);
        let (s3, c3) = (s2 * c + c2 * s, c2 * c - s2 * s);
        let half = sense.sign::<T>() / two;
        let mut out = [T::ZERO; MAX_TERMS];
        let machine = [
            T::ONE,
            c,
            s,
            c2,
            s2,
            c3,
            s3,
            half * sign(s) * c,
            -(half * sign(c) * s),
            -(half * s.abs()),
            half * c.abs(),
            sense.sign::<T>() * s2,
        ];
        for (place, x) in out.iter_mut().zip(machine).take(self.machine) {
            *place = x;
        }
        if self.cyclic && circle.pitch_m > T::ZERO {
            let turn = two * T::PI * circle.radius_m / circle.pitch_m;
            let (sx, cx) = (turn * c).sin_cos();
            let (sy, cy) = (turn * s).sin_cos();
            let cyclic = [c * sx, c * cx, s * sy, s * cy];
            for (place, x) in out.iter_mut().skip(self.machine).zip(cyclic) {
                *place = x;
            }
        }
        out
    }
}

fn sign<T: Real>(x: T) -> T {
    if x > T::ZERO {
        T::ONE
    } else if x < T::ZERO {
        -T::ONE
    } else {
        T::ZERO
    }
}
