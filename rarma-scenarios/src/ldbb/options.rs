//! What an evaluation is told.

/// What is known beside the readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Compliance of the bar and its joints, m/N.
    pub bar_m_per_n: f64,
    /// Highest order of the smoothing, 0 to 6.
    pub order: usize,
    /// Standard deviation of the force's gain, part of it.
    pub scale_sd: f64,
    /// Pitch of a cyclic error that is sought, m; 0: none.
    pub pitch_m: f64,
    /// Radius of the circle, m, and feed, m/s.
    pub radius_m: f64,
    /// See [`Self::radius_m`].
    pub feed_m_s: f64,
    /// Names of the plane's axes.
    pub axes: [&'static str; 2],
}

impl Default for Options {
    fn default() -> Self {
        Self {
            bar_m_per_n: 0.0,
            order: 6,
            scale_sd: 0.0,
            pitch_m: 0.0,
            radius_m: 0.15,
            feed_m_s: 1.0 / 60.0,
            axes: ["X", "Y"],
        }
    }
}
