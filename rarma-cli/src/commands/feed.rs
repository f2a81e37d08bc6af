//! `rarma monitor` for samples that are in memory: another program feeds them block by block.

use super::listening::Ears;
use super::monitor;
use super::process::{self, Added};
use super::source::About;
use crate::advice::{Advisor, Memory, Missing, Reach};
use crate::args::MonitorArgs;
use crate::collect::{Collector, News};
use crate::failure::Failure;
use crate::record::Summary;
use rarma_core::decide::Structure;
use rarma_core::estimate::StateVisitor;
use serde::{Deserialize, Serialize};

/// A monitor of one channel; what it says is what `rarma monitor` says of the same samples in a
/// file.
#[derive(Clone)]
pub struct Feed {
    ears: Ears<1>,
    advisor: Advisor,
    added: Option<Added>,
}

/// What a [`Feed`] keeps of what it has said, beside the state of its signal chain: in a form that
/// names its fields, for some of them are there or not.
#[derive(Clone, Serialize, Deserialize)]
pub struct Said {
    collector: Collector,
    advice: Memory,
    added: Option<Vec<process::Readings>>,
}

impl Feed {
    /// Nothing heard yet. Of `args` the input does not count, nor do a second channel, a tacho
    /// and a file with speeds.
    ///
    /// # Errors
    /// As those of the command.
    pub fn new(args: &MonitorArgs, about: &About, reach: Reach) -> Result<Self, Failure> {
        let structure = process::structure(args.structure.as_deref())?;
        Self::of_structure(args, about, reach, structure)
    }

    /// As [`Self::new`], with a structure that was read already, whatever `args` names.
    ///
    /// # Errors
    /// As there.
    pub fn of_structure(
        args: &MonitorArgs,
        about: &About,
        reach: Reach,
        structure: Option<Structure<f64>>,
    ) -> Result<Self, Failure> {
        let job = monitor::job(args, about)?;
        Ok(Self {
            ears: Ears::one(&job)?,
            advisor: Advisor::new(args, reach, structure),
            added: structure.map(Added::new),
        })
    }

    /// Takes the next sample.
    pub fn sample(&mut self, x: f32, hear: &mut impl FnMut(News)) {
        let Self {
            ears,
            advisor,
            added,
        } = self;
        ears.sample([x], None, &mut |mut news| {
            if let (News::Line(line), Some(added)) = (&mut news, &mut *added) {
                added.take(line);
            }
            advisor.take(&mut news);
            hear(news);
        });
    }

    /// So many samples are missing before the next one.
    pub fn missing(&mut self, samples: u64) {
        // One channel has nothing to say of it.
        self.ears.missing(samples, &mut |_| {});
    }

    /// The control tells the speed of the spindle, Hz.
    ///
    /// # Errors
    /// Out of range; nothing has changed then.
    pub fn tell_speed(&mut self, spindle_hz: f64) -> Result<(), Failure> {
        self.ears.tell_speed(spindle_hz)
    }

    /// What would have to be told to give advice.
    pub fn missing_for_advice(&self) -> Vec<Missing> {
        self.advisor.missing()
    }

    /// Shows every number of its signal chain to `visitor`, to be kept and gone on from later, as
    /// [`RecursiveArma::visit_state`](rarma_core::estimate::RecursiveArma::visit_state) does. What
    /// was said so far is kept by [`Self::said`].
    #[must_use]
    pub fn visit_state(&mut self, visitor: &mut impl StateVisitor<f32>) -> bool {
        self.ears.visit_state(visitor)
    }

    /// What it has said so far.
    pub fn said(&self) -> Said {
        Said {
            collector: self.ears.collector().clone(),
            advice: self.advisor.memory().clone(),
            added: self.added.as_ref().map(|added| added.heard().to_vec()),
        }
    }

    /// Goes on with what one of the same settings has said; false where it is not of such a one.
    #[must_use]
    pub fn go_on(&mut self, said: Said) -> bool {
        let added = match (&mut self.added, said.added) {
            (None, None) => true,
            (Some(added), Some(heard)) => added.go_on(heard),
            _ => false,
        };
        added && self.ears.go_on(said.collector) && self.advisor.go_on(said.advice)
    }

    /// The closing record, with advice.
    ///
    /// # Errors
    /// None but a defect of this program.
    pub fn finish(mut self) -> Result<Summary, Failure> {
        let mut summary = self.ears.finish()?;
        self.advisor.add_to(&mut summary);
        Ok(summary)
    }
}
