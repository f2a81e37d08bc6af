//! Which of two microphones is listened to: the second takes over when the first is bad.
//!
//! One model at a time: the memory has no room for a second monitor, nor the core the time.
//! Two sensors in one verdict are the PC's (`rarma monitor --second`).

use rarma_box::guard::FaultCode;

/// The choice, and who has been dropped.
#[derive(Debug, Clone, Copy, Default)]
pub struct Microphones {
    both: bool,
    now: u8,
    dropped: [bool; 2],
}

impl Microphones {
    /// The first one, nobody dropped; `both`: there is a second one.
    pub fn begin(both: bool) -> Self {
        Self {
            both,
            ..Self::default()
        }
    }

    /// The one that is listened to, 0 or 1.
    pub fn now(&self) -> u8 {
        self.now
    }

    /// The samples have this fault: the microphone that is dropped for it, if there is another
    /// one that has not been. A clipped signal is the cut's: the other one would clip too.
    pub fn fault(&mut self, code: FaultCode) -> Option<u8> {
        let bad = matches!(
            code,
            FaultCode::SamplesStopped
                | FaultCode::SamplesStuck
                | FaultCode::SamplesNotFinite
                | FaultCode::SamplesLoud
        );
        let other = 1 - self.now.min(1);
        let [first, second] = &mut self.dropped;
        let (mine, others) = if other == 1 {
            (first, second)
        } else {
            (second, first)
        };
        if !(bad && self.both) || *others {
            return None;
        }
        *mine = true;
        let was = self.now;
        self.now = other;
        Some(was)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_dropped_once_and_the_last_one_is_kept() {
        let mut one = Microphones::begin(false);
        assert_eq!((one.fault(FaultCode::SamplesStuck), one.now()), (None, 0));
        let mut two = Microphones::begin(true);
        assert_eq!(two.fault(FaultCode::SamplesClipped), None);
        assert_eq!(
            (two.fault(FaultCode::SamplesStuck), two.now()),
            (Some(0), 1)
        );
        assert_eq!((two.fault(FaultCode::SamplesLoud), two.now()), (None, 1));
    }
}
