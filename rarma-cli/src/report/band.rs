//! Confidence bands of the damping: modes followed from line to line.

use super::Scene;
use crate::record::Label;
use rarma_pictures::Axis;
use rarma_pictures::Panel;
use rarma_pictures::put;
use rarma_pictures::text::px;

/// Standard deviations that hold 95 % of a normal distribution.
const CONFIDENCE: f64 = 1.96;
/// One point of a band in so many pixels.
const STEP: f64 = 2.0;
/// A mode further than this (relative) from where it was, or gone for longer than so many
/// pixels, is another one.
const SAME: f64 = 0.06;
const GONE: f64 = 7.0;

/// One mode on its way.
struct Track {
    f: f64,
    /// Place, upper and lower edge, pixels.
    points: Vec<(f64, f64, f64)>,
}

/// The bands of all modes of a label as one path: ζ ± 1.96 sd, cut at the axis.
pub(super) fn path(panel: &Panel<'_>, scene: &Scene<'_>, label: Label, y: &Axis) -> String {
    let mut d = String::new();
    for track in tracks(panel, scene, label, y) {
        let (Some(first), Some(last)) = (track.points.first(), track.points.last()) else {
            continue;
        };
        // A mode that was there for an instant is still to be seen.
        let widened = [(first.0 - 0.5 * STEP, first.1, first.2)];
        let end = [(last.0 + 0.5 * STEP, last.1, last.2)];
        let points = || widened.iter().chain(&track.points).chain(&end);
        let mut pen = 'M';
        for (x, top, _) in points() {
            put!(d, "{pen}{} {}", px(*x), px(*top));
            pen = 'L';
        }
        for (x, _, bottom) in points().rev() {
            put!(d, "L{} {}", px(*x), px(*bottom));
        }
        d.push('Z');
    }
    d
}

fn tracks(panel: &Panel<'_>, scene: &Scene<'_>, label: Label, y: &Axis) -> Vec<Track> {
    let mut tracks: Vec<Track> = Vec::new();
    // Those that may still go on.
    let mut open: Vec<usize> = Vec::new();
    let mut column = f64::MIN;
    for moment in scene.job.course.moments() {
        let x = panel.x.at(moment.t);
        if x < column + STEP || moment.modes().is_empty() {
            continue;
        }
        column = x;
        open.retain(|&k| tracks[k].points.last().is_some_and(|p| p.0 > x - GONE));
        for mode in moment.modes().iter().filter(|m| m.label == label) {
            let width = CONFIDENCE * mode.zeta_sd;
            let (low, high) = (100.0 * (mode.zeta - width), 100.0 * (mode.zeta + width));
            if !(mode.f.is_finite() && low.is_finite() && high > y.lo()) {
                continue;
            }
            let point = (x, y.at(high), y.at(low));
            let same = |&&k: &&usize| {
                let track = &tracks[k];
                (track.f - mode.f).abs() < SAME * mode.f
                    && track.points.last().is_some_and(|p| p.0 < x)
            };
            match open.iter().find(same).copied() {
                Some(k) => {
                    tracks[k].f = mode.f;
                    tracks[k].points.push(point);
                }
                None => {
                    open.push(tracks.len());
                    tracks.push(Track {
                        f: mode.f,
                        points: vec![point],
                    });
                }
            }
        }
    }
    tracks
}
