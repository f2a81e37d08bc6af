//! Without a controller there is no clock to go by but the sound's own: a recording says the
//! same, however fast it is read.

use super::STEP;
use super::ear::Ear;
use crate::collect::News;
use crate::commands::monitor::Beside;
use crate::controller::{ActRecord, Actor};
use crate::failure::Failure;
use std::collections::VecDeque;

/// Steps of the policy between the samples.
pub(super) struct BySound {
    actor: Actor,
    ear: Ear,
    chatter_hz: Option<f64>,
    next_s: f64,
    said: VecDeque<ActRecord>,
    failed: Option<Failure>,
}

impl BySound {
    pub(super) fn new(actor: Actor, first: ActRecord) -> Self {
        Self {
            actor,
            ear: Ear::default(),
            chatter_hz: None,
            next_s: 0.0,
            said: VecDeque::from([first]),
            failed: None,
        }
    }

    /// What has failed meanwhile.
    ///
    /// # Errors
    /// The log could not be written.
    pub(super) fn end(self) -> Result<(), Failure> {
        self.failed.map_or(Ok(()), Err)
    }
}

impl Beside for BySound {
    fn begins(&mut self, _: bool) -> Result<(), Failure> {
        Ok(())
    }

    fn speed_rpm(&mut self, t_s: f64) -> Option<f64> {
        if t_s >= self.next_s && self.failed.is_none() {
            self.next_s = t_s + STEP.as_secs_f64();
            self.actor.heard(t_s, self.chatter_hz);
            let said = &mut self.said;
            let step = self.actor.step(t_s, |record| said.push_back(record));
            self.failed = step.err();
        }
        None
    }

    fn take(&mut self, news: &News) {
        self.chatter_hz = self.ear.take(news);
        if let News::Line(line) = news
            && let Some(rpm) = line.spindle.rpm
        {
            self.actor.believe(rpm / 60.0);
        }
    }

    fn said(&mut self) -> Option<ActRecord> {
        self.said.pop_front()
    }

    fn failed(&self) -> bool {
        self.failed.is_some()
    }
}
