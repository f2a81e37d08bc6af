//! What a cut is like at one instant: depth, speed, wear, and where the cutter is
//! in the workpiece.

use super::cut::Process;
use super::milling::{Engagement, MillingConfig, Workpiece};
use core::f64::consts::PI;

/// What the delay equation depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Condition {
    pub depth_m: f64,
    pub spindle_hz: f64,
    pub worn: f64,
}

impl Condition {
    pub(super) fn at(process: &Process, t: f64) -> Self {
        let (spindle_hz, worn) = match process {
            Process::Milling(c) => (c.carrier_at(t), 1.0 + c.wear.cutting_per_s * t),
            Process::Turning(c) => (c.spindle_hz, 1.0),
        };
        let (first, last) = in_stock_s(process);
        Self {
            depth_m: if t > first && t < last {
                process.depth().at(t)
            } else {
                0.0
            },
            spindle_hz,
            worn,
        }
    }
}

/// Feed speed, m/s, and radius, m, of a cutter that has a workpiece.
pub(super) fn path(process: &Process) -> Option<(&Workpiece, f64, f64)> {
    let Process::Milling(c) = process else {
        return None;
    };
    let piece = c.workpiece.as_ref()?;
    Some((piece, c.feed_per_tooth_m * c.tooth_hz(), 0.5 * c.diameter_m))
}

/// When the cutter is in the stock, s: from when its front reaches it until its
/// axis has left it.
pub(super) fn in_stock_s(process: &Process) -> (f64, f64) {
    path(process).map_or(
        (f64::NEG_INFINITY, f64::INFINITY),
        |(piece, speed, radius)| ((piece.x_m[0] - radius) / speed, piece.x_m[1] / speed),
    )
}

/// Whether the arc is still growing because the cutter goes into the stock.
pub(super) fn entering(process: &Process, t: f64) -> bool {
    path(process).is_some_and(|(piece, speed, _)| speed * t < piece.x_m[0] + 1e-3)
}

pub(super) fn interrupted(process: &Process, duration_s: f64) -> Vec<(f64, f64)> {
    let Some((piece, speed, radius)) = path(process) else {
        return Vec::new();
    };
    piece
        .interrupted_m(radius)
        .into_iter()
        .map(|(from, to)| ((from / speed).max(0.0), (to / speed).min(duration_s)))
        .filter(|(from, to)| from < to)
        .collect()
}

/// The arc while the cutter goes into the stock: only its front is in.
pub(super) fn arc(c: &MillingConfig, t: f64) -> Engagement {
    let full = c.engagement;
    let Some(piece) = &c.workpiece else {
        return full;
    };
    let ahead = piece.x_m[0] - c.feed_per_tooth_m * c.tooth_hz() * t;
    let sine = 2.0 * ahead / c.diameter_m;
    if sine <= 0.0 || sine >= 1.0 {
        return full;
    }
    let edge = sine.asin();
    let part = Engagement {
        entry_rad: full.entry_rad.max(edge),
        exit_rad: full.exit_rad.min(PI - edge),
    };
    if part.entry_rad < part.exit_rad {
        part
    } else {
        full
    }
}
