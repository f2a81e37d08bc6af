//! The monitor of the firmware over samples on the host, one channel or two.

use super::pair::Pair;
use crate::collect::{Collector, News, WholeRun};
use crate::failure::Failure;
use crate::record::{Run, Summary};
use firmware::monitor::MonitorDuty;
use rarma_box::wire::MonitorJob;
use rarma_core::estimate::StateVisitor;
use rarma_recordings::input::Recording;

/// Listens; what is said goes to whoever hears it, and nothing is kept.
#[derive(Clone)]
pub(super) struct Ears<const CHANNELS: usize> {
    monitor: Monitor,
    collector: Collector,
}

#[derive(Clone)]
enum Monitor {
    One(Box<MonitorDuty>),
    Two(Box<Pair>),
}

impl Ears<1> {
    /// What was said so far, put together.
    pub(super) fn collector(&self) -> &Collector {
        &self.collector
    }

    /// Goes on with what another one has put together; false where that is of other settings.
    pub(super) fn go_on(&mut self, collector: Collector) -> bool {
        let continues = collector.continues(&self.collector);
        if continues {
            self.collector = collector;
        }
        continues
    }

    /// See [`MonitorDuty::visit_state`].
    pub(super) fn visit_state(&mut self, visitor: &mut impl StateVisitor<f32>) -> bool {
        match &mut self.monitor {
            Monitor::One(duty) => duty.visit_state(visitor),
            Monitor::Two(_) => false,
        }
    }

    /// For one channel.
    ///
    /// # Errors
    /// Settings out of range.
    pub(super) fn one(job: &MonitorJob) -> Result<Self, Failure> {
        let refused = |error| Failure::Usage(format!("setting out of range: {error:?}"));
        let duty = Box::new(MonitorDuty::new(job).map_err(refused)?);
        let mut collector = Collector::default();
        collector.take(&duty.started());
        Ok(Self {
            monitor: Monitor::One(duty),
            collector,
        })
    }
}

impl Ears<2> {
    /// For two channels, counted from 0.
    ///
    /// # Errors
    /// Settings out of range.
    pub(super) fn two(job: &MonitorJob, channels: [usize; 2]) -> Result<Self, Failure> {
        let pair = Box::new(Pair::new(job, channels)?);
        let mut collector = Collector::default();
        collector.take(&pair.started());
        Ok(Self {
            monitor: Monitor::Two(pair),
            collector,
        })
    }
}

impl<const CHANNELS: usize> Ears<CHANNELS> {
    /// Takes one sample of each channel, then the pulse of a tacho if one has begun.
    pub(super) fn sample(
        &mut self,
        x: [f32; CHANNELS],
        pulse: Option<f32>,
        hear: &mut impl FnMut(News),
    ) {
        let collector = &mut self.collector;
        match &mut self.monitor {
            Monitor::One(duty) => {
                duty.samples(&x[..1], &mut |message| hear(collector.take(message)));
                if let Some(before) = pulse {
                    duty.pulse(before);
                }
            }
            Monitor::Two(pair) => {
                pair.sample([x[0], x[CHANNELS - 1]].map(Some), collector, hear);
                if let Some(before) = pulse {
                    pair.pulse(before);
                }
            }
        }
    }

    /// The control tells the speed of the spindle, Hz.
    ///
    /// # Errors
    /// Out of range.
    pub(super) fn tell_speed(&mut self, spindle_hz: f64) -> Result<(), Failure> {
        let told = match &mut self.monitor {
            Monitor::One(duty) => duty.tell_speed(spindle_hz as f32),
            Monitor::Two(pair) => pair.tell_speed(spindle_hz as f32),
        };
        told.map_err(|error| Failure::Usage(format!("setting out of range: {error:?}")))
    }

    /// So many samples of each channel are missing before the next one.
    pub(super) fn missing(&mut self, samples: u64, hear: &mut impl FnMut(News)) {
        if samples == 0 {
            return;
        }
        match &mut self.monitor {
            Monitor::One(duty) => duty.missing(u32::try_from(samples).unwrap_or(u32::MAX)),
            Monitor::Two(pair) => {
                for _ in 0..samples {
                    pair.sample([None; 2], &mut self.collector, hear);
                }
            }
        }
    }

    /// The closing record.
    ///
    /// # Errors
    /// None but a defect of this program.
    pub(super) fn finish(mut self) -> Result<Summary, Failure> {
        let (last, channels) = match self.monitor {
            Monitor::One(duty) => (duty.finished(0, 0, 0), None),
            Monitor::Two(pair) => (pair.finished(), Some(pair.records())),
        };
        self.collector.take(&last);
        let summary = self.collector.summary().ok_or_else(|| {
            Failure::System("the run has no end: a defect of this program".to_owned())
        })?;
        Ok(Summary {
            channels,
            ..summary
        })
    }

    /// Listens to all samples, and keeps all that is said.
    ///
    /// # Errors
    /// As [`finish`](Self::finish).
    pub(super) fn whole(
        mut self,
        samples: impl IntoIterator<Item = [f32; CHANNELS]>,
        pulses: &[Option<f32>],
        mut news: impl FnMut(&News),
    ) -> Result<Run, Failure> {
        let mut all = WholeRun::default();
        let mut hear = |said| {
            news(&said);
            all.keep(said);
        };
        for (n, x) in samples.into_iter().enumerate() {
            self.sample(x, pulses.get(n).copied().flatten(), &mut hear);
        }
        Ok(all.with(self.finish()?))
    }
}

/// Runs a pair of monitors over two channels in step, on the host. `news` is called
/// with what is said; `pulses` are those of a tacho, see
/// [`listen_with_tacho`](super::listen_with_tacho), or none.
///
/// # Errors
/// Settings out of range.
pub fn listen_pair(
    job: &MonitorJob,
    recordings: &[Recording; 2],
    pulses: &[Option<f32>],
    news: impl FnMut(&News),
) -> Result<Run, Failure> {
    let [first, second] = recordings;
    let channels = [first.channel, second.channel];
    let samples = first.samples.iter().zip(&second.samples);
    let ears = Ears::two(job, channels)?;
    ears.whole(samples.map(|(a, b)| [*a as f32, *b as f32]), pulses, news)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rarma_core::Order;
    use rarma_core::monitor::MonitorConfig;

    #[test]
    fn samples_that_are_missing_are_so_for_both_channels() {
        let monitor = MonitorConfig {
            order: Order::O21,
            ..MonitorConfig::new(8000.0)
        };
        let job = MonitorJob {
            monitor,
            channel: 0,
            every_s: 0.1,
        };
        let mut ears = Ears::two(&job, [0, 1]).expect("sound");
        let sound = |n: u32| 0.3 * (n as f32 * 0.7).sin();
        for n in 0..8000 {
            ears.sample([sound(n), -sound(n)], None, &mut |_| {});
        }
        ears.missing(4000, &mut |_| {});
        for n in 0..8000 {
            ears.sample([sound(n), -sound(n)], None, &mut |_| {});
        }
        let summary = ears.finish().expect("an end");
        assert_eq!(summary.samples, 20_000, "a second, half a one, a second");
        let channels = summary.channels.expect("two");
        for channel in channels {
            let missing = channel.faults.iter().find(|f| f.fault == "missing");
            let missing = missing.expect("told");
            // With the first report after it.
            assert!((1.0..1.6).contains(&missing.on), "{missing:?}");
        }
    }
}
