//! Sound that never came: the computer's clock against the count of frames.
//!
//! Where the sound system itself stops for a while, frames are missing and nothing stands in for
//! them. The clock goes on: how far it is ahead of the frames is constant but for the delay of
//! each block, which is never negative. Its least value over half a second, of frames and of the
//! clock, is free of delays: frames that were held up and then come at once make no gap.

/// Stretch of frames whose least delay counts, s.
const STRETCH_S: f64 = 0.5;
/// A rise by less is no gap: clocks are read to the millisecond, and blocks come in bunches.
const LEAST_S: f64 = 0.02;

/// Compares the two.
#[derive(Debug, Clone)]
pub struct Clock {
    fs: f64,
    /// How far the clock was ahead in the stretch before, s.
    ahead_s: Option<f64>,
    /// The least in this stretch, s, and the frame and the time at which that has begun.
    least_s: f64,
    begun: Option<(f64, f64)>,
}

impl Clock {
    /// For frames of rate `fs`, Hz.
    pub fn new(fs: f64) -> Self {
        Self {
            fs,
            ahead_s: None,
            least_s: f64::INFINITY,
            begun: None,
        }
    }

    /// A block that ends with `frames` has come when the clock said `clock_s`. Gives the samples
    /// that are found missing now: the gap is up to half a second ago.
    pub fn note(&mut self, frames: u64, clock_s: f64) -> u64 {
        let frames = frames as f64;
        let (frame, time_s) = *self.begun.get_or_insert((frames, clock_s));
        if clock_s < time_s {
            // Somebody has set the clock back.
            *self = Self::new(self.fs);
            return 0;
        }
        self.least_s = self.least_s.min(clock_s - frames / self.fs);
        if frames - frame < STRETCH_S * self.fs || clock_s - time_s < STRETCH_S {
            return 0;
        }
        self.begun = Some((frames, clock_s));
        let now = std::mem::replace(&mut self.least_s, f64::INFINITY);
        let before = self.ahead_s.replace(now).unwrap_or(now);
        let rise = now - before;
        if rise > LEAST_S {
            (rise * self.fs).round() as u64
        } else {
            0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FS: f64 = 48_000.0;

    /// Missing samples told, over `seconds` of blocks of 128 whose clock is that of `clock`, s, at
    /// the time of the sound, s.
    fn told(seconds: f64, clock: impl Fn(f64) -> f64) -> Vec<(f64, u64)> {
        let mut watch = Clock::new(FS);
        let blocks = (seconds * FS / 128.0) as u64;
        let note = |k: u64| {
            let t = k as f64 * 128.0 / FS;
            // To the millisecond, as a page may read it.
            let clock_s = (1e3 * clock(t)).floor() / 1e3;
            (t, watch.note(k * 128, clock_s))
        };
        let told: Vec<(f64, u64)> = (1..=blocks).map(note).collect();
        told.into_iter().filter(|(_, n)| *n > 0).collect()
    }

    #[test]
    fn delays_and_clocks_that_differ_are_no_gaps() {
        // Blocks in bunches of 20 ms, and a clock that is 300 ppm fast.
        let late = |t: f64| 1e6 + 1.0003 * t + 0.02 * (50.0 * t).fract();
        assert_eq!(told(60.0, late), []);
        // A second in which nothing is handed on, and then all at once.
        assert_eq!(
            told(20.0, |t| t.max(if t > 8.0 && t < 9.0 { 9.0 } else { 0.0 })),
            []
        );
    }

    #[test]
    fn a_clock_that_is_set_back_is_believed_again() {
        let back =
            |t: f64| t + if t > 5.0 { 10.0 } else { 3600.0 } + if t > 9.0 { 0.5 } else { 0.0 };
        let told = told(20.0, back);
        assert_eq!(told.len(), 1, "{told:?}");
        assert!((told[0].1 as f64 / FS - 0.5).abs() < 0.003, "{told:?}");
    }

    #[test]
    fn a_gap_is_told_once_and_with_its_length() {
        let gap = |t: f64| 5.0 + t + if t > 7.3 { 0.3 } else { 0.0 };
        let told = told(20.0, gap);
        assert_eq!(told.len(), 1, "{told:?}");
        let (at, missing) = told[0];
        assert!((7.3..8.4).contains(&at), "{at}");
        assert!((missing as f64 / FS - 0.3).abs() < 0.003, "{missing}");
    }
}
