//! `rarma monitor`: a recording in, a verdict out, on the host.

use super::{band, pair, process, show, tacho};
use crate::args::{InputArgs, MonitorArgs};
use crate::collect::{Collector, News};
use crate::failure::Failure;
use crate::input::{self, ReadOptions, Recording};
use crate::raw_streams::Gap;
use crate::record::Run;
use firmware::monitor::MonitorDuty;
use rarma_core::Order;
use rarma_core::monitor::{LEAST_MEMORY, MonitorConfig, MonitorError};
use rarma_core::wire::MonitorJob;

/// Seconds of signal between two updates of the progress bar.
const BAR_STEP_S: f64 = 0.5;

pub(super) fn main(args: &MonitorArgs) -> Result<u8, Failure> {
    let structure = process::structure(args.structure.as_deref())?;
    let input = match args.second {
        None => Input::One(read(&args.input)?),
        Some(second) => Input::Two(pair::read(args, second)?),
    };
    let pulses = match args.tacho {
        None => Vec::new(),
        Some(channel) => tacho::read(args, channel)?,
    };
    let recording = input.pictured();
    let job = job(args, recording)?;
    let bar = show::progress(recording.samples.len() as u64, "listening");
    let step = ((recording.fs * BAR_STEP_S) as u64).max(1);
    let mut done = 0;
    let news = |news: News<'_>| {
        if !args.json {
            show::alarm(&news, &bar);
        }
        done += 1;
        if done % step == 0 {
            bar.set_position(done);
        }
    };
    let mut run = match &input {
        Input::One(one) => {
            let samples = one.samples.iter().map(|&x| x as f32);
            heard(&job, samples, &one.gaps, &pulses, news)?
        }
        Input::Two(both) => pair::listen(&job, both, &pulses, news)?,
    };
    bar.finish_and_clear();
    let band = job.monitor.band();
    show::finish(
        args,
        recording,
        &mut run,
        (band.low_hz, band.high_hz),
        structure.as_ref(),
    )
}

/// What is listened to.
enum Input {
    One(Recording),
    Two([Recording; 2]),
}

impl Input {
    /// The channel that settings are checked against and pictures made of: the first
    /// that is well.
    fn pictured(&self) -> &Recording {
        match self {
            Self::One(one) => one,
            Self::Two(both) => both
                .iter()
                .find(|r| input::check(r).is_ok())
                .unwrap_or(&both[0]),
        }
    }
}

/// Reads the recording and passes on what is odd about it.
///
/// # Errors
/// Bad input, in one line.
pub fn read(args: &InputArgs) -> Result<Recording, Failure> {
    let recording = input::read(
        &args.input,
        &ReadOptions {
            channel: args.channel,
            fs: args.fs,
            stream: args.stream,
            check: true,
        },
    )?;
    for notice in &recording.notices {
        eprintln!("{}: {notice}", args.input.display());
    }
    Ok(recording)
}

/// The job that the box is given for a recording.
///
/// # Errors
/// A setting that does not fit the recording, in one line.
pub fn job(args: &MonitorArgs, recording: &Recording) -> Result<MonitorJob, Failure> {
    let (p, q) = args.order;
    let order = Order::new(p, q).ok_or_else(|| {
        let have: Vec<String> = Order::ALL
            .iter()
            .map(|o| format!("{},{}", o.p(), o.q()))
            .collect();
        Failure::Input(format!(
            "{}: --order: the box does not have order {p},{q} (it has {})",
            recording.path.display(),
            have.join(" ")
        ))
    })?;
    let monitor = MonitorConfig {
        full_scale: recording.full_scale,
        band: args.band,
        order,
        spindle_hz: args.rpm.map(|rpm| rpm / 60.0),
        teeth: args.teeth,
        tacho_pulses: args.tacho.map(|_| args.pulses),
        threshold: args.threshold,
        idle_s: args.idle,
        ..MonitorConfig::new(recording.fs)
    };
    let file = recording.path.display();
    monitor.check().map_err(|error| match error {
        MonitorError::Band(why) => {
            band::refused(why, monitor.band(), &recording.path, recording.fs)
        }
        MonitorError::Spindle => {
            Failure::Usage("--rpm: must lie between 0.06 and 300000 1/min".to_owned())
        }
        other => Failure::Usage(format!("setting out of range: {other:?}")),
    })?;
    let needed = LEAST_MEMORY * 2.0 / recording.fs.min(2.4 * monitor.band().high_hz);
    if recording.seconds < needed {
        return Err(Failure::Input(format!(
            "{file}: end of file: {:.3} s of signal is too short: the model needs {needed:.2} s to start (record longer, or choose a band with a higher upper edge)",
            recording.seconds
        )));
    }
    Ok(MonitorJob {
        monitor,
        channel: 0,
        every_s: args.every,
    })
}

/// Runs the monitor duty of the firmware over samples, on the host. `news` is
/// called once per sample with what has just been said, if anything.
///
/// # Errors
/// Settings out of range (see [`job`], which says which).
pub fn listen(
    job: &MonitorJob,
    samples: impl IntoIterator<Item = f32>,
    news: impl FnMut(News<'_>),
) -> Result<Run, Failure> {
    listen_with_tacho(job, samples, &[], news)
}

/// [`listen`] with the pulses of a tacho: for every sample, where one has begun since the
/// sample before, how long ago, samples.
///
/// # Errors
/// See [`listen`].
pub fn listen_with_tacho(
    job: &MonitorJob,
    samples: impl IntoIterator<Item = f32>,
    pulses: &[Option<f32>],
    news: impl FnMut(News<'_>),
) -> Result<Run, Failure> {
    heard(job, samples, &[], pulses, news)
}

/// [`listen_with_tacho`]; where samples are missing the monitor is told so, and does not hear
/// the zeros in their place.
fn heard(
    job: &MonitorJob,
    samples: impl IntoIterator<Item = f32>,
    gaps: &[Gap],
    pulses: &[Option<f32>],
    mut news: impl FnMut(News<'_>),
) -> Result<Run, Failure> {
    let mut gaps = gaps.iter().peekable();
    let mut missing_to = 0;
    let refused = |error| Failure::Usage(format!("setting out of range: {error:?}"));
    let mut duty = MonitorDuty::new(job).map_err(refused)?;
    let mut collector = Collector::default();
    collector.take(&duty.started());
    for (n, x) in samples.into_iter().enumerate() {
        if let Some(gap) = gaps.next_if(|gap| gap.at == n as u64) {
            missing_to = gap.at + gap.samples;
            duty.missing(u32::try_from(gap.samples).unwrap_or(u32::MAX));
        }
        if (n as u64) < missing_to {
            news(News::None);
            continue;
        }
        let mut said = false;
        duty.sample(x, &mut |message| {
            said = true;
            news(collector.take(message));
        });
        if !said {
            news(News::None);
        }
        if let Some(before) = pulses.get(n).copied().flatten() {
            duty.pulse(before);
        }
    }
    collector.take(&duty.finished(0, 0, 0));
    collector
        .run()
        .ok_or_else(|| Failure::System("the run has no end: a defect of this program".to_owned()))
}
