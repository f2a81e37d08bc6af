//! How the speed is told.

use super::detectors::Speed;
use rarma_plants::population::Cut;

/// How the speed is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Told {
    /// To the last digit.
    Exact,
    /// Up to 1 % off.
    One,
    /// 3 % too high or too low.
    Three,
    /// That of another job: 0.6 to 1.6 times, at least 10 % off.
    Wrong,
    /// Not at all.
    None,
    /// As the control knows it, ten times a second, a little late.
    Live,
}

/// Between two tellings of a control, s.
const EVERY_S: f64 = 0.1;

impl Told {
    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::One => "within 1 %",
            Self::Three => "3 % off",
            Self::Wrong => "wrong",
            Self::None => "not told",
            Self::Live => "live",
        }
    }

    /// What is told of a cut.
    pub fn speed(self, cut: &Cut) -> Speed {
        let e = cut.error;
        let factor = match self {
            Self::Exact => 1.0,
            Self::One => 1.0 + 0.01 * e,
            Self::Three => 1.0 + 0.03_f64.copysign(e),
            Self::Wrong if e < 0.0 => 0.9 + 0.3 * e,
            Self::Wrong => 1.1 + 0.5 * e,
            Self::None => return Speed::Unknown,
            Self::Live => return Speed::Live(live(cut)),
        };
        Speed::Told(factor * cut.spindle_hz())
    }
}

/// What a control tells, s and Hz: the true speed in whole 1/min, ten times a second, as
/// late as the cut's draw says.
pub fn live(cut: &Cut) -> Vec<(f64, f64)> {
    let told = |t_s: f64| (60.0 * cut.speed_at(t_s)).round() / 60.0;
    let count = (cut.length_s() / EVERY_S) as usize;
    (0..=count)
        .map(|k| {
            let t_s = k as f64 * EVERY_S;
            (t_s, told((t_s - cut.delay_s).max(0.0)))
        })
        .collect()
}
