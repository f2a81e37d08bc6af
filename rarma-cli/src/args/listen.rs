//! Options of `listen`.

use super::{MonitorArgs, within};
use clap::{Arg, Args};
use std::path::PathBuf;

/// What stands where other commands have the name of a recording.
const SOUND_CARD: &str = "sound card";

/// Options of `listen`: those of the card, and those of `monitor`.
#[derive(Debug, Clone, Args)]
pub struct ListenArgs {
    /// List the inputs there are, with their rates, channels and formats, and end.
    #[arg(long)]
    pub list: bool,
    /// Input, by a name that --list says [default: the system's usual one].
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// Seconds over which the level is measured before it starts, 0 to 60; 0: it is not.
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0, value_parser = |text: &str| within(text, 0.0, 60.0))]
    pub check: f64,
    /// Seconds that are listened to [default: until Ctrl-C].
    #[arg(long, value_name = "SECONDS", value_parser = |text: &str| within(text, 1e-3, 1e9))]
    pub seconds: Option<f64>,
    /// Record what is heard into this WAV, which must not be there yet: the channels that
    /// are listened to, then the tacho's.
    #[arg(long, value_name = "FILE.wav")]
    pub record: Option<PathBuf>,
    /// How it listens.
    #[command(flatten)]
    pub monitor: MonitorArgs,
}

/// A card takes the place of the recording.
pub(super) fn sound_card(option: Arg) -> Arg {
    match option.get_id().as_str() {
        "input" => option
            .required(false)
            .hide(true)
            .default_value(SOUND_CARD)
            .value_parser(|text: &str| match text {
                SOUND_CARD => Ok(PathBuf::from(text)),
                _ => Err("a sound card has no place here: name it with --device"),
            }),
        "fs" => option.help("Sampling rate in Hz [default: 48000, or the card's nearest]"),
        "channel" => option.help("Channel of the card, counted from 0"),
        "second" => option.help("Second channel of the same card, counted from 0: two sensors, one verdict"),
        "tacho" => option.help("Channel of the same card, counted from 0, that holds the pulses of a tacho: its speed goes before --rpm"),
        "more" => option.hide(true).value_parser(|_: &str| {
            Err::<PathBuf, _>("a sound card has no place here: name it with --device")
        }),
        "stream" | "raw" => option
            .hide(true)
            .value_parser(|_: &str| Err::<String, _>("a sound card has none")),
        _ => option,
    }
}
