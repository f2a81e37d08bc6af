//! `rarma monitor --tacho`: the channel of a recording that holds a tacho's pulses.

use rarma_core::condition::PulseDetector;

/// A pulse is at least this part of the channel's span high: what lies below is noise
/// between pulses that are fewer than the detector's memory expects.
const LEAST_HEIGHT: f64 = 0.3;
/// Of a pipe the span is learned: the detector begins anew where it has grown by this
/// much, at the price of one pulse.
const GROWN: f64 = 1.25;

/// Pulses out of samples. The channel is not judged: pulses are no vibration, flat and
/// clipped is what they should be.
pub(super) struct Tacho {
    fs: f64,
    detector: PulseDetector<f64>,
    /// Of a pipe: what the detector was told of the span, and the ends so far.
    learned: Option<(f64, f64, f64)>,
}

impl Tacho {
    /// For samples of rate `fs`, Hz, whose span is known of a file.
    pub(super) fn new(fs: f64, span: Option<f64>) -> Self {
        Self {
            fs,
            detector: detector(fs, span.unwrap_or(0.0)),
            learned: span.is_none().then_some((0.0, f64::MAX, f64::MIN)),
        }
    }

    /// Where a pulse has begun since the sample before, how long ago, samples.
    pub(super) fn process(&mut self, x: f64) -> Option<f32> {
        if let Some((span, low, high)) = &mut self.learned
            && x.is_finite()
        {
            (*low, *high) = (low.min(x), high.max(x));
            if *high - *low > GROWN * *span {
                *span = *high - *low;
                self.detector = detector(self.fs, *span);
            }
        }
        self.detector.process(x).map(|before| before as f32)
    }
}

fn detector(fs: f64, span: f64) -> PulseDetector<f64> {
    PulseDetector::new(fs, (LEAST_HEIGHT * span).max(f64::MIN_POSITIVE))
}
