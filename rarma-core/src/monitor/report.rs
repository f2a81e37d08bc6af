//! What a monitor says at each decision.

use super::amplitude::AmplitudeReport;
use super::identifier::MAX_MODES;
use super::spindle::SpindleReport;
use crate::decide::{AlarmEvent, Label, Mode, Reason, State};
use crate::real::Real;

/// The verdict of one decision.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report<T> {
    /// Input samples taken so far; divided by the rate, the time.
    pub sample: u64,
    /// The verdict.
    pub state: State,
    /// Why.
    pub reason: Reason,
    /// What happened to the alarm just now.
    pub event: AlarmEvent<T>,
    /// Root mean square of the band, input units.
    pub level: T,
    /// Modes sorted by frequency; none fill up the end.
    pub modes: [Option<Mode<T>>; MAX_MODES],
    /// What is known of the spindle.
    pub spindle: SpindleReport<T>,
    /// What the amplitude of the mode that matters says.
    pub amplitude: Option<AmplitudeReport<T>>,
    /// The alarm that stands: mean frequency (Hz) and lowest damping so far.
    pub standing: Option<(T, T)>,
}

impl<T: Real> Report<T> {
    /// Sorts the modes by frequency and labels the one an alarm stands on, which is in
    /// place `alarm` as the modes come.
    pub(super) fn in_order(mut self, alarm: Option<usize>) -> Self {
        let mut sorted: [Option<Mode<T>>; MAX_MODES] = [None; MAX_MODES];
        for (slot, mode) in self.modes.iter().enumerate() {
            let Some(mut mode) = *mode else { continue };
            if alarm == Some(slot) {
                mode.label = Label::SelfExcited;
            }
            // Carried along: each place keeps the lower of the two.
            let mut carried = Some(mode);
            for place in &mut sorted {
                let lower = match (*place, carried) {
                    (Some(there), Some(new)) => new.frequency < there.frequency,
                    (None, _) => true,
                    (_, None) => false,
                };
                if lower {
                    core::mem::swap(place, &mut carried);
                }
            }
        }
        self.modes = sorted;
        self
    }
}
