//! One run on the box: means in fixed cells of time, turned into angle when both
//! triggers are known.

use super::reversals::{self, Reversals};
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

/// Records one run of a circle.
#[derive(Debug, Clone)]
pub struct Recorder {
    gauge_m: [f32; CELLS],
    count: [u16; CELLS],
    cell_s: f32,
    pressure_pa: f32,
    readings: u32,
    /// The run before, as it was told and turned round.
    last: Option<(Trace<f32, COARSE>, Trace<f32, COARSE>)>,
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

    /// What the reversals of the axes say of the run.
    pub fn reversals(&self, map: &AngleMap<f32>) -> Reversals {
        reversals::look(&self.gauge_m, &self.count, self.cell_s, map).unwrap_or_default()
    }

    /// How the run goes with the one before it; it becomes the measure for the next one where
    /// neither is turned. The first run has no measure.
    pub fn beside(&mut self, map: &AngleMap<f32>, overshoot_rad: f32) -> Beside {
        let back = AngleMap {
            sense: match map.sense {
                Sense::Ccw => Sense::Cw,
                Sense::Cw => Sense::Ccw,
            },
            ..*map
        };
        let this: Trace<f32, COARSE> = self.trace(map, overshoot_rad);
        let turned: Trace<f32, COARSE> = self.trace(&back, overshoot_rad);
        let mut out = Beside::Open;
        if let Some((last, last_turned)) = &self.last {
            let (most, much) = (APART_M * APART_M, TURNED * TURNED);
            let beats = |a: f32, b: f32| b > most && much * a < b;
            let as_told = apart(&this, last);
            if beats(apart(&turned, last), as_told) {
                return Beside::Turned;
            }
            if beats(apart(&this, last_turned), as_told) {
                return Beside::LastTurned;
            }
            if beats(as_told, apart(&turned, last)) && beats(as_told, apart(&this, last_turned)) {
                out = Beside::Alike;
            }
        }
        self.last = Some((this, turned));
        out
    }
}

/// A run beside the one before it. A circle does not begin on an axis of symmetry: turning
/// one round and turning the other round are two different things.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// There is none, or nothing tells.
    Open,
    /// Four times nearer to it as both are told than if either were turned round.
    Alike,
    /// Four times nearer to it if this one is turned round.
    Turned,
    /// Four times nearer to it if that one is turned round.
    LastTurned,
}

/// Mean square of the distance of two runs, their mean distance taken off, m².
fn apart(a: &Trace<f32, COARSE>, b: &Trace<f32, COARSE>) -> f32 {
    let both = || (0..COARSE).filter_map(|k| Some(a.mean(k)? - b.mean(k)?));
    let n = both().count().max(1) as f32;
    let mean = both().sum::<f32>() / n;
    both().map(|d| (d - mean) * (d - mean)).sum::<f32>() / n
}
