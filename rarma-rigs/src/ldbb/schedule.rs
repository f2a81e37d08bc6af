//! Which runs a test consists of.

use super::terms::Sense;
use heapless::Vec;

/// Pressures a schedule holds.
pub const MAX_PRESSURES: usize = 16;

/// One run of a schedule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Number, from 0.
    pub number: u16,
    /// Pressure, Pa.
    pub pressure_pa: f32,
    /// Direction.
    pub sense: Sense,
    /// On the way up (true) or down.
    pub rising: bool,
}

/// Pressures up, and down again if asked for; at each of them one run a direction.
///
/// Directions alternate, so that each run begins where the last one ended.
///
/// The default has no run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Schedule {
    pressures_pa: Vec<f32, MAX_PRESSURES>,
    both: bool,
    down: bool,
}

impl Schedule {
    /// `pressures_pa` rise. None where they do not, or are too many, or none.
    pub fn new(pressures_pa: &[f32], both: bool, down: bool) -> Option<Self> {
        let rising = pressures_pa
            .iter()
            .zip(pressures_pa.get(1..)?)
            .all(|(a, b)| b > a);
        let sound = pressures_pa.iter().all(|p| p.is_finite() && *p > 0.0);
        if pressures_pa.is_empty() || !rising || !sound {
            return None;
        }
        Some(Self {
            pressures_pa: Vec::from_slice(pressures_pa).ok()?,
            both,
            down,
        })
    }

    /// How many runs.
    pub fn runs(&self) -> u16 {
        self.steps() * self.senses()
    }

    /// Run of a number; none beyond the last.
    pub fn run(&self, number: u16) -> Option<Run> {
        if number >= self.runs() {
            return None;
        }
        let up = self.pressures_pa.len() as u16;
        let step = number / self.senses();
        let place = if step < up { step } else { 2 * (up - 1) - step };
        let sense = match (self.both, number % 2) {
            (true, 1) => Sense::Cw,
            _ => Sense::Ccw,
        };
        Some(Run {
            number,
            pressure_pa: *self.pressures_pa.get(usize::from(place))?,
            sense,
            rising: step < up,
        })
    }

    /// Steps of pressure.
    pub fn steps(&self) -> u16 {
        let up = self.pressures_pa.len() as u16;
        if self.down { 2 * up - 1 } else { up }
    }

    /// Runs at one pressure.
    pub fn senses(&self) -> u16 {
        if self.both { 2 } else { 1 }
    }

    /// Whether the way turns round at this run's pressure: the highest, of a schedule that
    /// comes down again.
    pub fn turns_at(&self, run: &Run) -> bool {
        self.down && self.pressures_pa.last() == Some(&run.pressure_pa)
    }

    /// Smallest step between pressures, Pa; the pressure itself where there is one only.
    pub fn least_step_pa(&self) -> f32 {
        let steps = self
            .pressures_pa
            .iter()
            .zip(self.pressures_pa.iter().skip(1));
        let least = steps.map(|(a, b)| b - a).reduce(f32::min);
        least.or(self.pressures_pa.first().copied()).unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_and_down_in_both_directions() {
        let s = Schedule::new(&[1.0, 2.0, 3.0], true, true).expect("rising");
        assert_eq!((s.steps(), s.runs()), (5, 10));
        let all: std::vec::Vec<_> = (0..10).filter_map(|k| s.run(k)).collect();
        let p: std::vec::Vec<f32> = all.iter().map(|r| r.pressure_pa).collect();
        assert_eq!(p, [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 2.0, 2.0, 1.0, 1.0]);
        assert!(
            all.iter()
                .all(|r| (r.sense == Sense::Cw) == (r.number % 2 == 1))
        );
        assert!(all[5].rising && !all[6].rising && s.run(10).is_none());
    }

    #[test]
    fn refusals() {
        assert!(Schedule::new(&[2.0, 1.0], true, false).is_none());
        assert!(Schedule::new(&[], true, false).is_none());
        assert!(Schedule::new(&[f32::NAN], true, false).is_none());
        assert!(Schedule::new(&[1.0; 17], true, false).is_none());
    }
}
