//! `rarma identify --channels`: modes and mode shapes from several sensors at once.

#[cfg(feature = "channels")]
mod fit;
mod page;
mod record;

pub use record::{ChannelModeRecord, ChannelModel, ChannelPole, Channels, ShapeRecord};

use super::band::Part;
use super::psd;
use super::show;
use crate::args::{ChannelSet, IdentifyArgs};
use crate::failure::Failure;
use crate::report::sheet_told;
#[cfg(feature = "channels")]
use fit::fit;
use rarma_recordings::input::{self, ReadOptions, Recording};

/// What is fitted.
struct Job {
    /// States.
    order: usize,
    /// Places of the references in the list of channels.
    references: Vec<usize>,
    rows: usize,
    stretches: usize,
}

impl Job {
    /// # Errors
    /// What is asked for does not go together, by the option.
    fn of(args: &IdentifyArgs, channels: &[usize]) -> Result<Self, Failure> {
        let (order, q) = args.order;
        if q > 0 || order == 0 {
            return Err(Failure::Usage(format!(
                "--channels: --order must be N,0 with N states, two for each mode (is {order},{q})"
            )));
        }
        let references = match &args.several.references {
            None | Some(ChannelSet::All) => (0..channels.len()).collect(),
            Some(ChannelSet::These(these)) => these
                .iter()
                .map(|c| {
                    channels.iter().position(|x| x == c).ok_or_else(|| {
                        Failure::Usage(format!(
                            "--references: {c} is none of the channels that are fitted"
                        ))
                    })
                })
                .collect::<Result<_, _>>()?,
        };
        Ok(Self {
            order,
            references,
            rows: args.several.rows.into(),
            stretches: args.several.stretches.into(),
        })
    }
}

pub(super) fn main(args: &IdentifyArgs) -> Result<u8, Failure> {
    let input = &args.input;
    let options = ReadOptions {
        channel: 0,
        fs: input.fs,
        stream: input.stream,
        check: true,
    };
    let wanted = match &args.several.channels {
        Some(ChannelSet::These(these)) => Some(&these[..]),
        _ => None,
    };
    let recordings = input::read_channels(&input.input, &options, input.raw(), wanted)?;
    for recording in &recordings {
        for notice in &recording.notices {
            eprintln!("{}: {notice}", recording.path.display());
        }
    }
    let bar = show::waiting(format!("fitting {} channels", recordings.len()));
    let found = identify_channels(&recordings, args);
    bar.finish_and_clear();
    let found = found?;
    if let (Some(dir), Some(first)) = (&args.report, recordings.first()) {
        let part = Part::of(first, args.band, args.detrend)?;
        let title = input.input.display().to_string();
        let html = page::html(&found, &psd::estimate(&part), part.edges(), &title);
        sheet_told(dir, html, args.json)?;
    }
    if args.json {
        let text = serde_json::to_string(&found).map_err(std::io::Error::from)?;
        say!("{text}");
    } else {
        tell(&found);
    }
    Ok(0)
}

/// What `rarma identify --channels` says of channels that have been read; `args.input` does not
/// count.
///
/// # Errors
/// As those of the command.
pub fn identify_channels(
    recordings: &[Recording],
    args: &IdentifyArgs,
) -> Result<Channels, Failure> {
    let channels: Vec<usize> = recordings.iter().map(|r| r.channel).collect();
    let job = Job::of(args, &channels)?;
    let parts: Vec<Part> = recordings
        .iter()
        .map(|r| Part::of(r, args.band, args.detrend))
        .collect::<Result<_, _>>()?;
    let file = recordings
        .first()
        .map(|r| r.path.display().to_string())
        .unwrap_or_default();
    for (part, recording) in parts.iter().zip(recordings) {
        part.variance().map_err(|why| {
            Failure::Input(format!("{file}: channel {}: {why}", recording.channel))
        })?;
    }
    fit(&parts, &channels, &job).map_err(|why| {
        Failure::whole(
            &file,
            why,
            "choose another --order, --rows or --stretches, or record longer",
        )
    })
}

/// What a program without the decompositions says.
#[cfg(not(feature = "channels"))]
fn fit(_parts: &[Part], _channels: &[usize], job: &Job) -> Result<Channels, String> {
    let Job {
        order,
        references,
        rows,
        stretches,
    } = job;
    Err(format!(
        "{order} states of {} references in {rows} rows and {stretches} stretches are not fitted by this program, which was built without channels (build it without --no-default-features)",
        references.len()
    ))
}

fn tell(found: &Channels) {
    let names = |list: &[usize]| -> String {
        let words: Vec<String> = list.iter().map(usize::to_string).collect();
        words.join(", ")
    };
    say!(
        "{} states by {} of channels {} over {} samples at {} Hz{}",
        found.order,
        found.method,
        names(&found.channels),
        found.n,
        found.fs,
        found
            .band
            .map(|[low, high]| format!(", band {low}:{high} Hz"))
            .unwrap_or_default(),
    );
    say!(
        "  references {}, {} block rows, {} stretches",
        names(&found.references),
        found.rows,
        found.stretches
    );
    for mode in &found.modes {
        let mark = match (mode.pole.stable, mode.pole.stable_f) {
            (true, _) => " **",
            (_, true) => " *",
            _ => "",
        };
        say!(
            "  {:11.3} Hz ± {:.3}   damping {:.3} % ± {:.3}{mark}",
            mode.pole.f,
            mode.pole.f_sd,
            100.0 * mode.pole.zeta,
            100.0 * mode.pole.zeta_sd
        );
        for part in &mode.shape {
            say!(
                "      channel {:<3} {} ± {}  {:7.1}° ± {:.1}",
                part.channel,
                part_of_one(part.magnitude),
                part_of_one(part.magnitude_sd),
                part.phase_deg,
                part.phase_deg_sd
            );
        }
    }
    say!(
        "  ** stable: within 1 % in f, 5 % in damping and MAC 0.95 of a mode with two states less; * in f alone"
    );
}

/// A number up to 1; one that four decimals do not show, with its power of ten.
fn part_of_one(x: f64) -> String {
    match x {
        x if x == 0.0 || x >= 0.001 => format!("{x:.4}"),
        x => format!("{x:.1e}"),
    }
}
