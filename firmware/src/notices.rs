//! What the host should know of the spindle, said once and not at every decision.

use crate::visit::{flag, long};
use rarma_box::wire::{Notice, NoticeMessage, Telemetry};
use rarma_core::condition::TachoFault;
use rarma_core::estimate::StateVisitor;
use rarma_core::monitor::Report;

/// A fault of the tacho that comes back within this time is the same one, s. A tacho
/// that has not had its first pulse is silent for that long at most.
const SAME_FAULT_S: f64 = 1.0;
/// Kinds of faults of a tacho.
const FAULTS: usize = 4;

/// What has been said already.
#[derive(Debug, Clone)]
pub struct Notices {
    contradicted: bool,
    /// Sample at which each kind of fault stood last.
    stood: [Option<u64>; FAULTS],
    same_fault_samples: u64,
}

impl Notices {
    /// Nothing has been said; `fs_hz` is the input's rate.
    pub fn new(fs_hz: f64) -> Self {
        Self {
            contradicted: false,
            stood: [None; FAULTS],
            same_fault_samples: (SAME_FAULT_S * fs_hz) as u64,
        }
    }

    /// See [`MonitorDuty::visit_state`](crate::monitor::MonitorDuty::visit_state).
    pub(crate) fn visit_state(&mut self, visitor: &mut impl StateVisitor<f32>) {
        let Self {
            contradicted,
            stood,
            same_fault_samples: _,
        } = self;
        flag(contradicted, visitor);
        for stood in stood {
            let mut stands = stood.is_some();
            let mut at = stood.unwrap_or(0);
            flag(&mut stands, visitor);
            long(&mut at, visitor);
            *stood = stands.then_some(at);
        }
    }

    /// Decision rate: says what is new in a report.
    pub fn look(&mut self, report: &Report<f32>, say: &mut impl FnMut(&Telemetry)) {
        let sample = report.sample;
        let mut tell = |notice| say(&Telemetry::Notice(NoticeMessage { sample, notice }));
        if let Some((told_hz, found_hz)) = report.spindle.contradiction
            && !self.contradicted
        {
            self.contradicted = true;
            tell(Notice::Contradiction { told_hz, found_hz });
        }
        let Some(fault) = report.spindle.tacho_fault else {
            return;
        };
        let at_start = fault == TachoFault::Silent && sample < self.same_fault_samples;
        let Some(stood) = self.stood.get_mut(fault as usize).filter(|_| !at_start) else {
            return;
        };
        let same = stood.is_some_and(|last| sample.saturating_sub(last) < self.same_fault_samples);
        *stood = Some(sample);
        if !same {
            tell(Notice::Tacho(fault));
        }
    }
}
