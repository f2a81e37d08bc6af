//! `rarma monitor --second`: two channels of one recording, one verdict.

use super::channel;
use crate::args::MonitorArgs;
use crate::collect::{Collector, News};
use crate::failure::Failure;
use crate::input::{self, Recording};
use crate::record::{ChannelRecord, FaultRecord, Run};
use firmware::monitor::Telling;
use rarma_core::condition::{Fault, HealthCounts};
use rarma_core::decide::ChannelFault;
use rarma_core::monitor::{PairConfig, PairMonitor, PairReport};
use rarma_core::wire::{MonitorJob, Telemetry};

/// Both channels of a recording. One that is sick goes in as it is, with a notice: the
/// monitor leaves it out. The first of the two is the one that pictures are made of.
///
/// # Errors
/// The same channel twice, a channel that is not there, or two that are both sick.
pub fn read(args: &MonitorArgs, second: usize) -> Result<[Recording; 2], Failure> {
    let path = &args.input.input;
    if args.input.channel == second {
        return Err(Failure::Usage(format!(
            "--second: must be another channel than --channel (both are {second})"
        )));
    }
    let first = channel::open(args, args.input.channel)?;
    let remedy = "record both sensors into one file";
    channel::require(args, "--second", second, first.channels, remedy)?;
    let both = [first, channel::open(args, second)?];
    for notice in &both[0].notices {
        eprintln!("{}: {notice}", path.display());
    }
    let checked = both.each_ref().map(input::check);
    if let [Err(why), Err(_)] = checked {
        return Err(why.into());
    }
    for (recording, checked) in both.iter().zip(checked) {
        if let Err(why) = checked {
            eprintln!(
                "{why}; channel {}: left out while it is so",
                recording.channel
            );
        }
    }
    Ok(both)
}

/// Runs a pair of monitors over two channels in step, on the host. `news` is called
/// once per sample with what has just been said, if anything; `pulses` are those of a
/// tacho, see [`listen_with_tacho`](super::listen_with_tacho), or none.
///
/// # Errors
/// Settings out of range.
pub fn listen(
    job: &MonitorJob,
    recordings: &[Recording; 2],
    pulses: &[Option<f32>],
    mut news: impl FnMut(News<'_>),
) -> Result<Run, Failure> {
    let refused = |error| Failure::Usage(format!("setting out of range: {error:?}"));
    let mut pair = PairMonitor::new(&PairConfig::new(job.monitor)).map_err(refused)?;
    let mut telling = Telling::new(job);
    let mut collector = Collector::default();
    collector.take(&telling.started());
    let mut channels = recordings.each_ref().map(|r| Log::new(r.channel));
    let fs = job.monitor.fs_hz;
    let [first, second] = recordings;
    for (n, (a, b)) in first.samples.iter().zip(&second.samples).enumerate() {
        let mut said = false;
        if let Some(report) = pair.push([*a as f32, *b as f32]) {
            let mut line = false;
            telling.report(&report.report, || pair.histogram(), &mut |message| {
                said = true;
                line |= matches!(message, Telemetry::Verdict(_));
                news(collector.take(message));
            });
            if line {
                collector.agreed(report.agreement);
            }
            for (i, log) in channels.iter_mut().enumerate() {
                log.take(i, &report, fs);
            }
        }
        if !said {
            news(News::None);
        }
        if let Some(before) = pulses.get(n).copied().flatten() {
            pair.pulse(before);
        }
    }
    let health = [0, 1].map(|i| pair.health(i).unwrap_or_default());
    let finished = telling.finished(pair.samples(), total(health));
    collector.take(&Telemetry::Finished(finished));
    let mut run = collector.run().ok_or_else(|| {
        Failure::System("the run has no end: a defect of this program".to_owned())
    })?;
    let end_s = pair.samples() as f64 / fs;
    run.summary.channels = Some(channels.map(|log| log.record(end_s)).into());
    Ok(run)
}

/// What befell each channel, in words.
pub fn words(channels: &[ChannelRecord]) {
    for channel in channels {
        let stretch = |f: &FaultRecord| match f.off {
            Some(off) => format!("{} from {:.3} to {off:.3} s", f.fault, f.on),
            None => format!("{} from {:.3} s to the end", f.fault, f.on),
        };
        if !channel.faults.is_empty() {
            let why: Vec<String> = channel.faults.iter().map(stretch).collect();
            say!(
                "Channel {} was left out for {:.2} s: {}.",
                channel.channel,
                channel.dropped_s,
                why.join(", ")
            );
        }
    }
}

/// The word for what is wrong with a channel.
pub fn fault_word(fault: ChannelFault) -> &'static str {
    match fault {
        ChannelFault::Samples(Fault::NotFinite) => "not-finite",
        ChannelFault::Samples(Fault::Missing) => "missing",
        ChannelFault::Samples(Fault::Stuck) => "stuck",
        ChannelFault::Samples(Fault::Clipped) => "clipped",
        ChannelFault::Silent => "silent",
        ChannelFault::Contradicts => "contradicts",
    }
}

fn total([a, b]: [HealthCounts; 2]) -> HealthCounts {
    HealthCounts {
        not_finite: a.not_finite.saturating_add(b.not_finite),
        clipped: a.clipped.saturating_add(b.clipped),
        stuck: a.stuck.saturating_add(b.stuck),
        missing: a.missing.saturating_add(b.missing),
    }
}

/// The stretches for which one channel was left out.
struct Log {
    channel: usize,
    faults: Vec<FaultRecord>,
    now: Option<ChannelFault>,
}

impl Log {
    fn new(channel: usize) -> Self {
        Self {
            channel,
            faults: Vec::new(),
            now: None,
        }
    }

    fn take(&mut self, i: usize, report: &PairReport<f32>, fs: f64) {
        let fault = report.dropped[i].map(|d| d.fault);
        if fault == self.now {
            return;
        }
        let t = report.report.sample as f64 / fs;
        if let (Some(_), Some(last)) = (self.now, self.faults.last_mut()) {
            last.off = Some(t);
        }
        if let Some(fault) = fault {
            self.faults.push(FaultRecord {
                fault: fault_word(fault).to_owned(),
                on: t,
                off: None,
            });
        }
        self.now = fault;
    }

    fn record(self, end_s: f64) -> ChannelRecord {
        let length = |f: &FaultRecord| f.off.unwrap_or(end_s) - f.on;
        ChannelRecord {
            channel: self.channel,
            // An empty sum of floats is −0.
            dropped_s: self.faults.iter().map(length).fold(0.0, |a, b| a + b),
            faults: self.faults,
        }
    }
}
