//! The surface a cut leaves: its profile, roughness, and where it lies.
//!
//! Responsibility: from the motion of the tool to the machined profile. Rate: one
//! call per integration step while recording; no allocation after building.
//!
//! Everything the tips have swept is gone; what is left is the envelope of their
//! paths. Heights are counted into the workpiece: positive where more was cut away
//! than was meant.

use super::error::{PlantError, positive};
use super::milling::{MillSample, Milling};
use super::turning::TurnSample;
use core::f64::consts::PI;

/// Points of the profile in one feed (per tooth or per revolution).
const POINTS_PER_FEED: f64 = 24.0;
/// Sampling lengths that Rz is the mean of.
const LENGTHS: usize = 5;

/// What is measured on a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Mean deviation from the mean line, m.
    pub ra_m: f64,
    /// Peak to valley, mean over five sampling lengths, m.
    pub rz_m: f64,
    /// Where the mean line lies, m; positive: too much was cut away (surface
    /// location error).
    pub location_m: f64,
}

/// A profile at an even pitch.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Distance of two points, m.
    pub pitch_m: f64,
    /// Depth below the nominal surface, m, positive into the workpiece.
    pub depth_m: Vec<f64>,
}

impl Profile {
    /// Ra, Rz and location; the straight mean line is taken off first. No filter
    /// separates waviness from roughness: with chatter both are there.
    #[must_use]
    pub fn roughness(&self) -> Roughness {
        let n = self.depth_m.len().max(1) as f64;
        let mean = self.depth_m.iter().sum::<f64>() / n;
        let centre = 0.5 * (n - 1.0);
        let (mut sxy, mut sxx) = (0.0, 0.0);
        for (i, y) in self.depth_m.iter().enumerate() {
            let t = i as f64 - centre;
            sxy += t * (y - mean);
            sxx += t * t;
        }
        let slope = if sxx > 0.0 { sxy / sxx } else { 0.0 };
        let flat: Vec<f64> = self
            .depth_m
            .iter()
            .enumerate()
            .map(|(i, y)| y - mean - slope * (i as f64 - centre))
            .collect();
        let part = (flat.len() / LENGTHS).max(1);
        let (mut total, mut parts) = (0.0, 0.0_f64);
        for piece in flat.chunks_exact(part) {
            let top = piece.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let bottom = piece.iter().copied().fold(f64::INFINITY, f64::min);
            total += top - bottom;
            parts += 1.0;
        }
        Roughness {
            ra_m: flat.iter().map(|y| y.abs()).sum::<f64>() / n,
            rz_m: total / parts.max(1.0),
            location_m: mean,
        }
    }
}

/// Which wall of a milled path is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wall {
    /// At φ = 0, on the +y side: left by up-milling, or one side of a slot.
    Up,
    /// At φ = π, on the -y side: left by down-milling.
    Down,
}

/// Records the wall that milling leaves along a stretch of the feed.
#[derive(Clone, Debug)]
pub struct WallRecorder {
    wall: Wall,
    radius: f64,
    runout: Vec<f64>,
    from: f64,
    pitch: f64,
    deepest: Vec<f64>,
    window: f64,
    before: Vec<Option<(f64, f64)>>,
}

impl WallRecorder {
    /// Along `length_m` of the feed from `from_m` on.
    ///
    /// # Errors
    /// `OutOfRange` without a feed or a length.
    pub fn new(mill: &Milling, wall: Wall, from_m: f64, length_m: f64) -> Result<Self, PlantError> {
        let c = mill.config();
        positive(c.feed_per_tooth_m, "feed_per_tooth_m")?;
        positive(length_m, "length_m")?;
        let pitch = c.feed_per_tooth_m / POINTS_PER_FEED;
        let radius = 0.5 * c.diameter_m;
        let mut runout = c.runout_m.clone();
        runout.resize(c.teeth, 0.0);
        // Beyond two revolutions' feed from the wall's foot a tip is higher than any
        // cusp; vibration is allowed for by a factor.
        let reach = 4.0 * c.feed_per_tooth_m * c.teeth as f64 + 4e-4;
        Ok(Self {
            wall,
            radius,
            runout,
            from: from_m,
            pitch,
            deepest: vec![f64::NEG_INFINITY; (length_m / pitch).ceil() as usize],
            window: (reach / radius).clamp(0.02, 0.8),
            before: vec![None; c.teeth],
        })
    }

    /// Takes the latest step of the machine; false once the stretch is passed.
    pub fn take(&mut self, mill: &Milling, s: &MillSample) -> bool {
        for j in 0..self.before.len() {
            let angle = mill.tooth_angle_rad(j);
            let off = match self.wall {
                Wall::Up => (angle + PI).rem_euclid(2.0 * PI) - PI,
                Wall::Down => angle - PI,
            };
            if off.abs() > self.window {
                self.before[j] = None;
                continue;
            }
            let r = self.radius + self.runout[j];
            let (sin, cos) = angle.sin_cos();
            let x = s.feed_m + s.position_m[0] + r * sin;
            let y = s.position_m[1] + r * cos;
            let depth = match self.wall {
                Wall::Up => y - self.radius,
                Wall::Down => -y - self.radius,
            };
            if let Some(before) = self.before[j] {
                self.sweep(before, (x, depth));
            }
            self.before[j] = Some((x, depth));
        }
        s.feed_m < self.from + self.pitch * self.deepest.len() as f64 + self.radius * self.window
    }

    /// Lowers the profile to a straight piece of a tip's path.
    fn sweep(&mut self, a: (f64, f64), b: (f64, f64)) {
        let (a, b) = if a.0 <= b.0 { (a, b) } else { (b, a) };
        let place = |x: f64| (x - self.from) / self.pitch;
        let first = place(a.0).ceil().max(0.0) as usize;
        let last = place(b.0).floor();
        if last < 0.0 || b.0 <= a.0 {
            return;
        }
        let end = (last as usize + 1).min(self.deepest.len());
        for (i, deepest) in self.deepest.iter_mut().enumerate().take(end).skip(first) {
            let x = self.from + i as f64 * self.pitch;
            let part = (x - a.0) / (b.0 - a.0);
            *deepest = deepest.max(a.1 + part * (b.1 - a.1));
        }
    }

    /// The profile, without points that no tip has passed.
    #[must_use]
    pub fn profile(&self) -> Profile {
        Profile {
            pitch_m: self.pitch,
            depth_m: self
                .deepest
                .iter()
                .copied()
                .filter(|d| d.is_finite())
                .collect(),
        }
    }
}

/// Profile along the feed of a turned surface: arcs of the nose radius, one each
/// revolution, as deep as the tool was when it passed. The chip-thickness direction
/// of the model is taken as the normal of the surface.
///
/// `samples` are those at one angle of the workpiece, one per revolution.
#[must_use]
pub fn turned_profile(samples: &[TurnSample], feed_m: f64, nose_radius_m: f64) -> Profile {
    let pitch_m = feed_m / POINTS_PER_FEED;
    let n = (samples.len() as f64 * POINTS_PER_FEED) as usize;
    // An arc matters where it is not above what its neighbours can reach.
    let swing = samples
        .iter()
        .map(|s| s.position_m.abs())
        .fold(0.0, f64::max);
    let reach = (4.0 * swing * nose_radius_m).sqrt() + feed_m;
    let near = ((reach / feed_m).ceil() as usize).min(samples.len());
    let depth_m = (near * POINTS_PER_FEED as usize
        ..n.saturating_sub(near * POINTS_PER_FEED as usize))
        .map(|i| {
            let z = i as f64 * pitch_m;
            let k = (z / feed_m).round() as usize;
            let range = k.saturating_sub(near)..(k + near + 1).min(samples.len());
            range
                .map(|k| {
                    let d = z - k as f64 * feed_m;
                    samples[k].position_m - d * d / (2.0 * nose_radius_m)
                })
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    Profile { pitch_m, depth_m }
}

#[cfg(test)]
mod tests {
    use super::super::milling::{Engagement, MillingConfig};
    use super::super::modal::Mode;
    use super::super::process::Schedule;
    use super::*;

    fn wall(config: MillingConfig, wall: Wall) -> Roughness {
        let mut mill = Milling::new(config).expect("valid");
        let feed = mill.config().feed_per_tooth_m * mill.config().teeth as f64;
        let mut recorder = WallRecorder::new(&mill, wall, 60.0 * feed, 40.0 * feed).expect("valid");
        loop {
            let s = mill.step();
            if !recorder.take(&mill, &s) {
                return recorder.profile().roughness();
            }
        }
    }

    fn rigid() -> MillingConfig {
        MillingConfig {
            feed_per_tooth_m: 0.2e-3,
            depth: Schedule::constant(1e-3),
            engagement: Engagement::down(0.3),
            min_step_rate_hz: 400_000.0,
            ..MillingConfig::default()
        }
    }

    #[test]
    fn cusps_of_a_rigid_cutter() {
        // fz²/(8R) high; parabolas: Ra = 0.2566·fz²/(8R) about the mean at 2/3.
        let want = 0.2e-3_f64.powi(2) / (8.0 * 0.01);
        for side in [Wall::Up, Wall::Down] {
            let r = wall(rigid(), side);
            assert!((r.rz_m / want - 1.0).abs() < 0.05, "{side:?} {r:?} {want}");
            assert!((r.ra_m / (0.2566 * want) - 1.0).abs() < 0.05, "{r:?}");
            assert!((r.location_m / (-want / 3.0) - 1.0).abs() < 0.1, "{r:?}");
        }
    }

    #[test]
    fn runout_leaves_the_mark_of_the_longest_tooth() {
        let mut config = rigid();
        config.runout_m = vec![0.0, 5e-6];
        // Longer by more than the cusp: it alone makes the surface, at twice the feed.
        let want = 0.4e-3_f64.powi(2) / (8.0 * 0.01);
        let r = wall(config, Wall::Down);
        assert!((r.rz_m / want - 1.0).abs() < 0.05, "{r:?} {want}");
        assert!((r.location_m - 5e-6 + want / 3.0).abs() < 0.1e-6, "{r:?}");
    }

    #[test]
    fn a_soft_cutter_leaves_the_wall_where_the_force_put_it() {
        // A stiff, heavily damped mode follows the force statically. Down-milling:
        // at φ = π the chip ends, so the force there is nearly nothing; a constant
        // edge force of one tooth shows: Fy = -Fr·cos π = +b·Kne.
        let mut config = rigid();
        config.kt_n_per_m2 = 1.0;
        config.kn_n_per_m2 = 0.0;
        config.kn_edge_n_per_m = 20e3;
        config.modes_y = vec![Mode::from_stiffness(8000.0, 0.7, 1e7)];
        let r = wall(config.clone(), Wall::Down);
        let stiff = wall(rigid(), Wall::Down);
        let want = 20e3 * 1e-3 / 1e7;
        assert!(
            (stiff.location_m - r.location_m - want).abs() < 0.25 * want,
            "{r:?} {want}"
        );
    }

    #[test]
    fn turned_profile_of_a_still_and_of_a_swinging_tool() {
        let at = |q: fn(usize) -> f64| -> Roughness {
            let s: Vec<TurnSample> = (0..400)
                .map(|k| TurnSample {
                    position_m: q(k),
                    ..TurnSample::default()
                })
                .collect();
            turned_profile(&s, 0.1e-3, 0.8e-3).roughness()
        };
        let cusp = 0.1e-3_f64.powi(2) / (8.0 * 0.8e-3);
        let still = at(|_| 0.0);
        assert!((still.rz_m / cusp - 1.0).abs() < 0.02, "{still:?} {cusp}");
        // Every other arc 10 µm shallower leaves no trace: arcs at twice the feed.
        let odd = at(|k| if k % 2 == 0 { 0.0 } else { -1e-5 });
        assert!((odd.rz_m / (4.0 * cusp) - 1.0).abs() < 0.02, "{odd:?}");
        let wavy = at(|k| 2e-5 * (k as f64 * 0.1).sin());
        assert!(
            (wavy.ra_m / (2e-5 * 2.0 / PI) - 1.0).abs() < 0.1,
            "{wavy:?}"
        );
    }
}
