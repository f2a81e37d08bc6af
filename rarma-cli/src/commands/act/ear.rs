//! From what the monitor says to: it chatters at this frequency.

use crate::collect::News;
use crate::record::{Label, State};

/// Follows the alarm that stands.
#[derive(Debug, Default)]
pub(super) struct Ear {
    chatter_hz: Option<f64>,
}

impl Ear {
    /// The frequency at which it chatters now, Hz; none while no alarm stands.
    pub(super) fn take(&mut self, news: &News) -> Option<f64> {
        match news {
            News::On(alarm) => self.chatter_hz = Some(alarm.f),
            News::Off(_) => self.chatter_hz = None,
            News::Line(line) if line.state == State::Chatter => {
                let excited = line.modes.iter().filter(|m| m.label == Label::SelfExcited);
                let loudest = excited.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
                // Another speed, another frequency.
                if let (Some(f), Some(mode)) = (&mut self.chatter_hz, loudest) {
                    *f = mode.f;
                }
            }
            News::Line(_) | News::None | News::Histogram(_) | News::Notice(_) => {}
        }
        self.chatter_hz
    }
}
