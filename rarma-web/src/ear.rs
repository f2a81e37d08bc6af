//! One channel of live sound or of a file through the monitor of `rarma monitor`.

use crate::clock::Clock;
use crate::filler::{Filler, Piece};
use crate::settings::Settings;
use crate::view::Gaps;
use rarma_cli::Failure;
use rarma_cli::advice::{Missing, Reach};
use rarma_cli::collect::News;
use rarma_cli::commands::Feed;
use rarma_cli::record::Summary;

/// What was heard, sample by sample, and what was said of it.
#[derive(Debug)]
pub enum Said<'a> {
    /// A sample that was heard; one that is missing is 0.
    Sample(f32),
    /// So many samples are missing.
    Missing(u64),
    /// The monitor says something.
    News(&'a News),
}

/// Listens.
#[derive(Clone)]
pub struct Ear {
    feed: Feed,
    filler: Option<Filler>,
    clock: Clock,
    gaps: Gaps,
    samples: u64,
}

impl Ear {
    /// Nothing heard yet. `live`: zeros in a row are sound that was lost; in a file they are what
    /// somebody recorded. `samples`: how many there are, where that is known.
    ///
    /// # Errors
    /// A setting that does not fit, in one line.
    pub fn new(settings: &Settings, live: bool, samples: Option<u64>) -> Result<Self, Failure> {
        let (args, about) = (settings.args()?, settings.about(samples));
        Ok(Self {
            feed: Feed::new(&args, &about, Reach::default())?,
            filler: live.then(|| Filler::new(settings.fs)),
            clock: Clock::new(settings.fs),
            gaps: Gaps::default(),
            samples: 0,
        })
    }

    /// Takes the samples that come next.
    pub fn push(&mut self, samples: &[f32], hear: &mut dyn FnMut(Said<'_>)) {
        let Self {
            feed,
            filler,
            gaps,
            samples: heard,
            ..
        } = self;
        let mut take = |piece| match piece {
            Piece::Sample(x) => {
                *heard += 1;
                gaps.sound();
                hear(Said::Sample(x));
                feed.sample(x, &mut |news| hear(Said::News(&news)));
            }
            Piece::Missing(n) => {
                *heard += n;
                gaps.missing(n);
                feed.missing(n);
                hear(Said::Missing(n));
            }
        };
        match filler {
            Some(filler) => {
                samples.iter().for_each(|x| filler.push(*x, &mut take));
                filler.end_of_block(&mut take);
            }
            None => samples.iter().for_each(|x| take(Piece::Sample(*x))),
        }
    }

    /// So many samples are missing before the next one; nothing before the beginning.
    pub fn missing(&mut self, n: u64, hear: &mut dyn FnMut(Said<'_>)) {
        if n == 0 || !self.has_begun() {
            return;
        }
        self.samples += n;
        self.gaps.missing(n);
        self.feed.missing(n);
        hear(Said::Missing(n));
        self.gaps.sound();
    }

    /// See [`Clock::note`].
    pub fn note_clock(&mut self, frames: u64, clock_s: f64) -> u64 {
        self.clock.note(frames, clock_s)
    }

    /// The speed of the spindle is this from now on, 1/min.
    ///
    /// # Errors
    /// Out of range; nothing has changed then.
    pub fn tell_speed(&mut self, rpm: f64) -> Result<(), Failure> {
        self.feed.tell_speed(rpm / 60.0)
    }

    /// Sound has come.
    pub fn has_begun(&self) -> bool {
        self.filler.as_ref().is_none_or(Filler::has_begun)
    }

    /// Samples so far, missing ones included.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// What is missing so far.
    pub fn gaps(&self) -> Gaps {
        self.gaps
    }

    /// What would have to be told to give advice.
    pub fn missing_for_advice(&self) -> Vec<Missing> {
        self.feed.missing_for_advice()
    }

    /// The closing record, as if the sound ended now; it may go on.
    ///
    /// # Errors
    /// None but a defect of this program.
    pub fn summary(&self) -> Result<Summary, Failure> {
        self.feed.clone().finish()
    }
}
