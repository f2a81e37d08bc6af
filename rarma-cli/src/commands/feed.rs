//! `rarma monitor` for samples that are in memory: another program feeds them block by block.

use super::listening::Ears;
use super::monitor;
use super::process::{self, Added};
use super::source::About;
use crate::advice::{Advisor, Missing, Reach};
use crate::args::MonitorArgs;
use crate::collect::News;
use crate::failure::Failure;
use crate::record::Summary;

/// A monitor of one channel; what it says is what `rarma monitor` says of the same samples in a
/// file.
#[derive(Clone)]
pub struct Feed {
    ears: Ears<1>,
    advisor: Advisor,
    added: Option<Added>,
}

impl Feed {
    /// Nothing heard yet. Of `args` the input does not count, nor do a second channel, a tacho
    /// and a file with speeds.
    ///
    /// # Errors
    /// As those of the command.
    pub fn new(args: &MonitorArgs, about: &About, reach: Reach) -> Result<Self, Failure> {
        let structure = process::structure(args.structure.as_deref())?;
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
            advisor.take(&news);
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

    /// The closing record, with advice.
    ///
    /// # Errors
    /// None but a defect of this program.
    pub fn finish(self) -> Result<Summary, Failure> {
        let mut summary = self.ears.finish()?;
        self.advisor.add_to(&mut summary);
        Ok(summary)
    }
}
