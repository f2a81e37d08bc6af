//! `rarma monitor`: a recording in, a verdict out, on the host. Memory does not depend on
//! the length: samples, lines and pictures pass through.

use super::listening::Ears;
use super::show::{Audience, Finished};
use super::source::{About, Block, Source};
use super::watched::{self, Pace, Watched};
use super::{band, process, show};
use crate::advice::Reach;
use crate::args::{MonitorArgs, notes_by_key};
use crate::collect::News;
use crate::controller::ActRecord;
use crate::failure::Failure;
use crate::output::stdout;
use crate::progress::ProgressBar;
use crate::record::{Run, Summary};
use rarma_box::wire::MonitorJob;
use rarma_core::Order;
use rarma_core::monitor::{LEAST_MEMORY, MonitorConfig, MonitorError};
use rarma_recordings::input::{InputError, Speeds};
use std::path::Path;

pub(super) fn main(args: &MonitorArgs) -> Result<u8, Failure> {
    let watched = Watched::of(args)?;
    Ok(heard(
        args,
        Manner {
            watched,
            ..Manner::default()
        },
    )?
    .code)
}

/// How a run is heard, beside its options.
#[derive(Default)]
pub(super) struct Manner<'a> {
    /// What may be turned.
    pub(super) reach: Reach,
    /// Nothing is said on standard output.
    pub(super) quiet: bool,
    /// What goes on beside.
    pub(super) beside: Option<&'a mut dyn Beside>,
    /// It is shown on a screen.
    pub(super) watched: Option<Watched>,
}

/// What goes on beside the listening.
pub(super) trait Beside {
    /// It begins, `live` or with a recording.
    ///
    /// # Errors
    /// It must not.
    fn begins(&mut self, live: bool) -> Result<(), Failure>;
    /// The speed that turns at this time of the sound, s, where it is known, 1/min.
    fn speed_rpm(&mut self, t_s: f64) -> Option<f64>;
    /// Hears what the monitor says.
    fn take(&mut self, news: &News);
    /// What it has to say itself, one after the other.
    fn said(&mut self) -> Option<ActRecord>;
    /// It has failed, and there is no use in listening on.
    fn failed(&self) -> bool;
}

/// All of a run.
///
/// # Errors
/// As those of the command.
pub(super) fn heard(args: &MonitorArgs, manner: Manner<'_>) -> Result<Finished, Failure> {
    let both = Some(Path::new("-"));
    let piped = Some(args.input.input.as_path()) == both;
    if args.speed_from.as_deref() == both && piped {
        return Err(Failure::Usage(
            "--speed-from -: standard input is the sound already; give a file or a named pipe"
                .to_owned(),
        ));
    }
    // Beside a controller an interrupt is first of all to give back.
    let source = if piped && manner.beside.is_none() {
        let input = watched::standard_input(&args.input, manner.watched.as_ref())?;
        Source::live(args, input)?
    } else {
        Source::open(args)?
    };
    hear(args, source, manner)
}

/// [`heard`], of a source that is open.
///
/// # Errors
/// As those of the command.
pub(super) fn hear(
    args: &MonitorArgs,
    mut source: Source,
    manner: Manner<'_>,
) -> Result<Finished, Failure> {
    let Manner {
        reach,
        quiet,
        mut beside,
        watched,
    } = manner;
    let structure = process::structure(args.structure.as_deref())?;
    let live = source.about.samples.is_none();
    if let Some(beside) = &mut beside {
        beside.begins(live)?;
    }
    let open = |path| Speeds::open(path, live);
    let mut speeds = args.speed_from.as_deref().map(open).transpose()?;
    let args = &MonitorArgs {
        rpm: args
            .rpm
            .or(speeds.as_ref().map(Speeds::first))
            .or_else(|| beside.as_mut()?.speed_rpm(0.0)),
        ..args.clone()
    };
    let job = job(args, &source.about)?;
    let bar = match source.about.samples {
        _ if watched.is_some() => ProgressBar::hidden(),
        Some(samples) => show::progress(samples, "listening"),
        None => show::waiting("listening".to_owned()),
    };
    let mut audience = Audience::new(args, &source.about, &job, structure, reach, bar);
    // What is shown of a file goes by the clock.
    let mut pace = watched.as_ref().filter(|_| !live).map(Watched::pace);
    if let Some(watched) = watched {
        audience = audience.on(watched.screen(&source.about, &job)?);
    }
    if quiet {
        audience = audience.quiet();
    }
    if beside.is_some() {
        audience = audience.told_live();
    }
    let speeds = &mut speeds;
    let beside_it = beside.as_mut().map(|b| &mut **b as &mut dyn Beside);
    let summary = match source.channels[..] {
        [a, b] => {
            let ears = Ears::two(&job, [a, b])?;
            through(
                &mut source,
                &mut audience,
                ears,
                (speeds, beside_it),
                &mut pace,
            )?
        }
        _ => {
            let ears = Ears::one(&job)?;
            through(
                &mut source,
                &mut audience,
                ears,
                (speeds, beside_it),
                &mut pace,
            )?
        }
    };
    let finished = audience.finish(summary)?;
    // A verdict that could not be passed on goes before what is wrong with the samples.
    stdout::check()?;
    if beside.is_some_and(|b| b.failed()) {
        // It says so itself; it was left in the middle of the samples.
        return Ok(finished);
    }
    source.end()?;
    long_enough(&job, &source.about)?;
    Ok(finished)
}

/// A new speed is looked for this often, s.
const ASK_S: f64 = 0.005;

/// Everything there is to hear, block by block.
fn through<const CHANNELS: usize>(
    source: &mut Source,
    audience: &mut Audience<'_>,
    mut ears: Ears<CHANNELS>,
    (speeds, mut beside): (&mut Option<Speeds>, Option<&mut dyn Beside>),
    pace: &mut Option<Pace>,
) -> Result<Summary, Failure> {
    let (pictured, fs) = (source.pictured, source.about.fs);
    let ask_every = ((ASK_S * fs) as u64).max(1);
    let mut heard = 0;
    'all: while let Some(Block {
        rows,
        missing,
        pulses,
    }) = source.next()?
    {
        ears.missing(missing, &mut |news| audience.take(news));
        heard += missing;
        // Samples of this block that the pictures have.
        let mut shown = 0;
        for n in missing as usize..rows[0].len() {
            let x = std::array::from_fn(|c| rows[c][n] as f32);
            let pulse = pulses.get(n).copied().flatten();
            ears.sample(x, pulse, &mut |news| {
                if let Some(beside) = &mut beside {
                    beside.take(&news);
                }
                audience.take(news);
            });
            heard += 1;
            if heard % ask_every != 0 {
                continue;
            }
            audience.hear(&rows[pictured][shown..=n]);
            shown = n + 1;
            let t_s = heard as f64 / fs;
            let told = speeds.as_mut().and_then(|s| s.due(t_s, odd_speed));
            let turns = beside.as_mut().and_then(|b| b.speed_rpm(t_s));
            let told = told.or(turns);
            if let Some(rpm) = told {
                ears.tell_speed(rpm / 60.0)?;
            }
            while let Some(record) = beside.as_mut().and_then(|b| b.said()) {
                audience.beside(&record);
            }
            if pace.as_ref().is_some_and(|pace| !pace.keep(t_s)) {
                break 'all;
            }
        }
        audience.hear(&rows[pictured][shown..]);
        let failed = beside.as_ref().is_some_and(|b| b.failed());
        if failed || !audience.listens() {
            break;
        }
    }
    ears.finish()
}

/// Of a pipe: what is wrong with a line.
fn odd_speed(why: InputError) {
    eprintln!("Warning: {why}; the speed before it stands");
}

/// The job that the box is given for a recording.
///
/// # Errors
/// A setting that does not fit the recording, in one line.
pub fn job(args: &MonitorArgs, recording: &About) -> Result<MonitorJob, Failure> {
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
        aliased: args.aliased,
        verdict: args.numbers.numbers()?,
        ..MonitorConfig::new(recording.fs)
    };
    monitor.check().map_err(|error| match error {
        MonitorError::Band(why) => {
            band::refused(why, monitor.band(), &recording.path, recording.fs)
        }
        MonitorError::Spindle => {
            Failure::Usage("--rpm: must lie between 0.06 and 300000 1/min".to_owned())
        }
        other => Failure::Usage(format!("setting out of range: {other:?}")),
    })?;
    let job = MonitorJob {
        monitor,
        channel: 0,
        every_s: args.every,
    };
    long_enough(&job, recording)?;
    notes_by_key(&args.notes).map_err(Failure::Usage)?;
    if let (Some((from, _)), Some(samples)) = (args.window, recording.samples) {
        let end_s = samples as f64 / recording.fs;
        if from >= end_s {
            return Err(Failure::Usage(format!(
                "--window: begins at {from} s and the recording ends at {end_s:.3} s (choose a stretch inside it)"
            )));
        }
    }
    Ok(job)
}

/// That the model can start, as far as the length is known.
fn long_enough(job: &MonitorJob, recording: &About) -> Result<(), Failure> {
    let Some(samples) = recording.samples else {
        return Ok(());
    };
    let needed = LEAST_MEMORY * 2.0 / recording.fs.min(2.4 * job.monitor.band().high_hz);
    let seconds = samples as f64 / recording.fs;
    if seconds < needed {
        return Err(Failure::Input(format!(
            "{}: end of file: {seconds:.3} s of signal is too short: the model needs {needed:.2} s to start (record longer, or choose a band with a higher upper edge)",
            recording.path.display()
        )));
    }
    Ok(())
}

/// Runs the monitor duty of the firmware over samples, on the host, and keeps all that
/// is said: for minutes, not for days. `news` is called with what is said.
///
/// # Errors
/// Settings out of range (see [`job`], which says which).
pub fn listen(
    job: &MonitorJob,
    samples: impl IntoIterator<Item = f32>,
    news: impl FnMut(&News),
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
    news: impl FnMut(&News),
) -> Result<Run, Failure> {
    Ears::one(job)?.whole(samples.into_iter().map(|x| [x]), pulses, news)
}
