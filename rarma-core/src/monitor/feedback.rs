//! What a decision tells those that hear the next sample: the only way back in the chain.

use super::{MAX_MODES, Monitor};
use crate::decide::Mode;
use crate::real::Real;

/// Made at the end of a decision, handed over before the next sample is heard.
#[derive(Debug, Clone, Copy)]
pub(super) struct Feedback<'a, T> {
    /// The modes that were judged; none where the model was not ready.
    pub modes: Option<&'a [Option<Mode<T>>; MAX_MODES]>,
    /// An alarm is in force: what may be the chatter is neither removed nor taken for the rotation.
    pub alarm_stands: bool,
    /// An alarm has just ended: what was heard of each mode is forgotten.
    pub alarm_ended: bool,
}

impl<T: Real> Monitor<T> {
    /// Hands it over: the modes to the speed, the alarm to the lines that are removed and to the modes' tests.
    pub(super) fn hand_back(&mut self, back: &Feedback<'_, T>) {
        if let Some(modes) = back.modes {
            self.spindle.hear_modes(modes, self.period_s);
        }
        self.spindle.hold_standing(back.alarm_stands);
        if back.alarm_ended {
            for slot in &mut self.slots {
                slot.clear();
            }
        }
    }
}
