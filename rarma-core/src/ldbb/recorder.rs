//! One run on the box: means in fixed cells of time, turned into angle when both
//! triggers are known.

use super::terms::Sense;
use super::trace::{AngleMap, Trace};

/// Cells of a run; at 390° half a degree each.
pub const CELLS: usize = 780;
/// The cells last this much longer than the programmed arc.
pub const RESERVE: f32 = 1.2;
/// Bins by which two runs are compared.
const COARSE: usize = 36;
/// A run that is this many times nearer to the last one when it is turned round has been
/// run the other way round,
const TURNED: f32 = 4.0;
/// if it is further from it than this as it is, m: centre and shape must tell the two apart.
const APART_M: f32 = 2e-6;

/// See the module.
#[derive(Debug, Clone)]
pub struct Recorder {
    gauge_m: [f32; CELLS],
    count: [u16; CELLS],
    cell_s: f32,
    pressure_pa: f32,
    readings: u32,
    last: Option<Trace<f32, COARSE>>,
}

impl Default for Recorder {
    fn default() -> Self {
        Self {
            gauge_m: [0.0; CELLS],
            count: [0; CELLS],
            cell_s: 1.0,
            pressure_pa: 0.0,
            readings: 0,
            last: None,
        }
    }
}

impl Recorder {
    /// A new run whose arc should last `arc_s`.
    pub fn begin(&mut self, arc_s: f32) {
        self.gauge_m = [0.0; CELLS];
        self.count = [0; CELLS];
        self.cell_s = RESERVE * arc_s / CELLS as f32;
        self.pressure_pa = 0.0;
        self.readings = 0;
    }

    /// A new test: the run before is no measure for the next one.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// A reading `t_s` after the arc should have begun.
    pub fn add(&mut self, t_s: f32, gauge_m: f32, pressure_pa: f32) {
        if !(t_s >= 0.0 && gauge_m.is_finite() && pressure_pa.is_finite()) {
            return;
        }
        let cell = (t_s / self.cell_s) as usize;
        if let (Some(mean), Some(count)) = (self.gauge_m.get_mut(cell), self.count.get_mut(cell)) {
            *count = count.saturating_add(1);
            *mean += (gauge_m - *mean) / f32::from(*count);
            self.readings += 1;
            self.pressure_pa += (pressure_pa - self.pressure_pa) / self.readings as f32;
        }
    }

    /// Mean pressure of the run, Pa.
    pub fn pressure_pa(&self) -> f32 {
        self.pressure_pa
    }

    /// The capture in bins of angle. Times of `map` count from where [`Self::add`]'s do.
    pub fn trace<const BINS: usize>(
        &self,
        map: &AngleMap<f32>,
        overshoot_rad: f32,
    ) -> Trace<f32, BINS> {
        let mut out = Trace::default();
        for (k, (mean, count)) in self.gauge_m.iter().zip(&self.count).enumerate() {
            let t_s = (k as f32 + 0.5) * self.cell_s;
            if *count > 0
                && let Some(theta) = map.captured(t_s, overshoot_rad)
            {
                let _ = out.add(theta, *mean);
            }
        }
        out
    }

    /// Whether the run fits the one before it better when it is turned round; it becomes
    /// the measure for the next one if not. The first run has no measure.
    pub fn turned(&mut self, map: &AngleMap<f32>, overshoot_rad: f32) -> bool {
        let back = AngleMap {
            sense: match map.sense {
                Sense::Ccw => Sense::Cw,
                Sense::Cw => Sense::Ccw,
            },
            ..*map
        };
        let this: Trace<f32, COARSE> = self.trace(map, overshoot_rad);
        if let Some(last) = &self.last {
            let other: Trace<f32, COARSE> = self.trace(&back, overshoot_rad);
            let (d, turned) = (apart(&this, last), apart(&other, last));
            if d > APART_M * APART_M && TURNED * TURNED * turned < d {
                return true;
            }
        }
        self.last = Some(this);
        false
    }
}

/// Mean square of the distance of two runs, their mean distance taken off, m².
fn apart(a: &Trace<f32, COARSE>, b: &Trace<f32, COARSE>) -> f32 {
    let both = || (0..COARSE).filter_map(|k| Some(a.mean(k)? - b.mean(k)?));
    let n = both().count().max(1) as f32;
    let mean = both().sum::<f32>() / n;
    both().map(|d| (d - mean) * (d - mean)).sum::<f32>() / n
}
