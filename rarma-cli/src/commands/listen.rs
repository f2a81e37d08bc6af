//! `rarma listen`: a sound card in, a verdict out, as long as it is wanted.

use super::monitor::{self, Manner};
use super::source::Source;
use super::watched::Watched;
use crate::args::{ListenArgs, MonitorArgs};
use crate::failure::Failure;
use crate::output;
use crate::screen;
use crate::sound_card::{self, Card, Ended, Input, Level, Live, Offer, Wish, dbfs, rates};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::Ordering;

pub(super) fn main(args: &ListenArgs) -> Result<u8, Failure> {
    if args.list {
        list(&sound_card::inputs()?, args.monitor.json);
        return Ok(0);
    }
    if let Some(path) = &args.record {
        output::must_be_new(path)?;
    }
    // What cannot be shown is said before the card is opened.
    screen::wanted(args.monitor.screen, args.monitor.json, false)?;
    let live = sound_card::open(&Wish {
        device: args.device.clone(),
        rate_hz: args.monitor.input.fs,
        channels: channels(&args.monitor),
    })?;
    listen(args, live)
}

/// Checks the level, then listens to its end.
fn listen(args: &ListenArgs, mut live: Live) -> Result<u8, Failure> {
    let levels = live.measure(args.check)?;
    begin(args, &live, &levels)?;
    if let Some(path) = &args.record {
        live.record(path, channels(&args.monitor).len())?;
    }
    if let Some(seconds) = args.seconds {
        live.end_after(seconds);
    }
    let signals = live.signals();
    let leave = move || signals.stop.store(true, Ordering::Relaxed);
    let watched = Watched::of_live(&args.monitor, Box::new(leave))?;
    let manner = Manner {
        watched,
        ..Manner::default()
    };
    let (name, live) = (live.name(), Rc::new(RefCell::new(live)));
    let source = Source::live(&args.monitor, Live::stream(&live));
    let heard = source.and_then(|source| monitor::hear(&args.monitor, source, manner));
    // The recording is whole whatever became of the verdict.
    let ended = live.borrow_mut().close()?;
    match (heard, ended) {
        (_, Ended::Gone(why)) => Err(Failure::Gone(format!(
            "{name}: end: {why} (connect it again, and start again; what was heard until then counts)"
        ))),
        (heard, Ended::Told) => Ok(heard?.code),
    }
}

/// Channels of the card that are needed, in the order in which they are heard and recorded.
fn channels(args: &MonitorArgs) -> Vec<usize> {
    let first = [args.input.channel].into_iter();
    first.chain(args.second).chain(args.tacho).collect()
}

/// Says what is listened to and how loud it is.
///
/// # Errors
/// Nothing is to be heard.
fn begin(args: &ListenArgs, live: &Live, levels: &[Level]) -> Result<(), Failure> {
    let (name, choice) = (live.name(), live.card.choice);
    let ears: Vec<usize> = [args.monitor.input.channel]
        .into_iter()
        .chain(args.monitor.second)
        .collect();
    let of = |channel: &usize| Some((*channel, levels.get(*channel)?));
    let heard: Vec<(usize, &Level)> = ears.iter().filter_map(of).collect();
    if args.monitor.json {
        say!("{}", json!({ "listening": facts(&live.card, &heard) }));
    }
    eprintln!(
        "{name}: {} Hz, {} channels of {}",
        choice.rate_hz, choice.channels, choice.form
    );
    if let Some(warning) = sound_card::rate_warning(live.fs()) {
        eprintln!(
            "{name}: Warning: {warning}; choose an input that is no headset's, or --fs 48000"
        );
    }
    for (channel, level) in &heard {
        eprintln!("{name}: channel {channel}: {level}, over {} s", args.check);
        for warning in level.warnings() {
            eprintln!("{name}: channel {channel}: Warning: {warning}");
        }
    }
    let is_silent = |(_, level): &&(usize, &Level)| level.is_silent();
    let silent: Vec<String> = heard
        .iter()
        .filter(is_silent)
        .map(|(c, _)| c.to_string())
        .collect();
    if silent.is_empty() {
        return Ok(());
    }
    if silent.len() < heard.len() {
        eprintln!("{name}: Warning: channel {} is silent", silent.join(", "));
        return Ok(());
    }
    Err(Failure::NoSound(format!(
        "{name}: channel {}: silence: rms {:.1} dBFS over {} s (unmute the input and turn its gain up in the system's mixer, check cable, --device and --channel; --check 0 listens all the same)",
        silent.join(" and "),
        heard.first().map_or(f64::NAN, |(_, level)| dbfs(level.rms)),
        args.check
    )))
}

/// The first line of JSON.
fn facts(card: &Card, heard: &[(usize, &Level)]) -> Value {
    let level = |(channel, level): &(usize, &Level)| {
        json!({
            "channel": channel, "rms_dbfs": tenth(dbfs(level.rms)), "peak_dbfs": tenth(dbfs(level.peak)),
            "dc": level.dc, "clipped": level.clipped, "samples": level.samples,
        })
    };
    let levels: Vec<Value> = heard.iter().map(level).collect();
    json!({
        "device": card.name, "fs": card.choice.rate_hz, "channels": card.choice.channels,
        "format": card.choice.form.to_string(), "level": levels,
    })
}

fn tenth(x: f64) -> f64 {
    (x * 10.0).round() / 10.0
}

fn list(inputs: &[Input], as_json: bool) {
    if as_json {
        let all: Vec<Value> = inputs.iter().map(described).collect();
        say!("{}", json!({ "inputs": all }));
        return;
    }
    if inputs.is_empty() {
        say!("No input for sound on this computer.");
    }
    for input in inputs {
        let usual = if input.usual { "  (usual)" } else { "" };
        say!("{}{usual}", input.name);
        if input.description != input.name {
            say!("    {}", input.description);
        }
        match &input.offers {
            Ok(offers) if offers.is_empty() => say!("    no format that is read here"),
            Ok(offers) => say!(
                "    {}; channels {}; {}",
                rates(offers),
                channel_words(offers),
                forms(offers).join(", ")
            ),
            Err(why) => say!("    cannot be opened: {why}"),
        }
    }
}

fn described(input: &Input) -> Value {
    let offers = input.offers.as_deref().unwrap_or_default();
    let mut rates: Vec<(u32, u32)> = offers.iter().map(|o| o.rates_hz).collect();
    rates.sort_unstable();
    rates.dedup();
    json!({
        "name": input.name, "description": input.description, "usual": input.usual,
        "rates": rates, "channels": counts(offers), "formats": forms(offers),
        "error": input.offers.as_ref().err(),
    })
}

fn counts(offers: &[Offer]) -> Vec<usize> {
    let mut all: Vec<usize> = offers.iter().map(|o| o.channels).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn channel_words(offers: &[Offer]) -> String {
    let all = counts(offers);
    match all[..] {
        [first, .., last] if last - first + 1 == all.len() => format!("{first} to {last}"),
        _ => {
            let words: Vec<String> = all.iter().map(usize::to_string).collect();
            words.join(", ")
        }
    }
}

fn forms(offers: &[Offer]) -> Vec<String> {
    let mut all: Vec<_> = offers.iter().map(|o| o.form).collect();
    all.sort_unstable();
    all.dedup();
    all.iter().map(ToString::to_string).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use crate::sound_card::{Choice, Form, Signals, Tap, ring};
    use clap::Parser;
    use std::path::Path;
    use std::sync::Arc;
    use std::sync::atomic::Ordering;
    use std::time::{Duration, Instant};

    const FS: usize = 8000;

    fn args(words: &[&str]) -> ListenArgs {
        let cli = Cli::try_parse_from([&["rarma", "listen"][..], words].concat());
        match cli.expect("sound").command {
            Command::Listen(args) => args,
            _ => panic!("another command"),
        }
    }

    /// A card of 16 bits and two channels, without hardware.
    fn card() -> (Live, Tap, Arc<Signals>) {
        let signals = Arc::new(Signals::default());
        let told = Arc::clone(&signals.told);
        let (tap, drain) = ring(2, FS as f64, 8.0, told);
        let choice = Choice {
            channels: 2,
            rate_hz: FS as u32,
            form: Form::Integer(16),
        };
        let card = Card {
            name: "test".to_owned(),
            choice,
        };
        let live = Live::new(card, drain, Arc::clone(&signals), None);
        (live, tap, signals)
    }

    /// So many samples of both channels: noise that is never 0.
    fn noise(samples: usize) -> Vec<i16> {
        let mut state = 1_u32;
        let next = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 20) as i16 * 2 - 4095
        };
        (0..2 * samples).map(next).collect()
    }

    fn value(code: i16) -> f32 {
        f32::from(code) / 32_768.0
    }

    fn codes_of(wav: &Path) -> Vec<i16> {
        let reader = hound::WavReader::open(wav).expect("a WAV");
        let samples = reader.into_samples::<i16>();
        samples.map(|x| x.expect("a sample")).collect()
    }

    #[test]
    fn a_card_that_goes_away_leaves_what_was_heard_and_its_own_code() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("kept.wav");
        let (live, mut tap, signals) = card();
        let codes = noise(3 * FS);
        tap.take(&codes, Instant::now(), value);
        signals.gone("it has gone away".to_owned());
        let record = path.display().to_string();
        let failure = listen(&args(&["--record", &record, "--channel", "1"]), live);
        let failure = failure.expect_err("it went away");
        assert_eq!(failure.code(), 6, "{failure}");
        assert!(failure.to_string().contains("sound card test: end: it has"));
        let second: Vec<i16> = codes.iter().skip(1).step_by(2).copied().collect();
        assert_eq!(codes_of(&path), second);
    }

    #[test]
    fn a_card_that_never_gives_anything_and_a_silent_one_are_refused() {
        let (live, tap, signals) = card();
        signals.gone("it has gone away".to_owned());
        let failure = listen(&args(&[]), live).expect_err("nothing came");
        assert_eq!(failure.code(), 5, "{failure}");
        drop(tap);
        let (live, mut tap, _) = card();
        tap.take(&[0_i16; 2 * FS], Instant::now(), value);
        let failure = listen(&args(&[]), live).expect_err("silent");
        assert_eq!(failure.code(), 5, "{failure}");
        // One of two that is silent is left out by the monitor.
        let (live, mut tap, _) = card();
        let mut one = noise(3 * FS);
        one.iter_mut().skip(1).step_by(2).for_each(|x| *x = 0);
        tap.take(&one, Instant::now(), value);
        let ended = listen(&args(&["--second", "1", "--seconds", "2.5"]), live);
        assert!(matches!(ended, Ok(0 | 1)), "{ended:?}");
    }

    #[test]
    fn what_is_missing_is_so_in_the_recording_and_for_both_channels() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("gap.wav");
        let (live, mut tap, signals) = card();
        let (before, after) = (noise(2 * FS), noise(FS));
        let begin = Instant::now();
        tap.take(&before, begin, value);
        signals.told.lost.store(true, Ordering::Release);
        // A second after the first block, of which this one is a half.
        let second = begin + Duration::from_millis(1000);
        tap.take(&after[..FS], second, value);
        let record = path.display().to_string();
        let words = ["--second", "1", "--seconds", "3", "--record", &record];
        let ended = listen(&args(&words), live);
        assert!(matches!(ended, Ok(0 | 1)), "{ended:?}");
        let gap = vec![0; FS];
        let expected = [&before[..], &gap, &after[..FS]].concat();
        assert_eq!(codes_of(&path), expected);
    }

    #[test]
    fn what_a_card_does_not_have_is_refused() {
        let parse = |words: &[&str]| {
            let all = [&["rarma", "listen"][..], words].concat();
            Cli::try_parse_from(all).map_err(|why| why.to_string())
        };
        for words in [
            &["my.wav"][..],
            &["--raw", "s16", "--fs", "8000"],
            &["--stream", "1"],
        ] {
            assert!(parse(words).is_err(), "{words:?}");
        }
        let why = parse(&["my.wav"]).err().unwrap_or_default();
        assert!(why.contains("--device"), "{why}");
        let (live, mut tap, _) = card();
        tap.take(&noise(2 * FS), Instant::now(), value);
        let failure = listen(&args(&["--second", "0"]), live);
        assert_eq!(failure.expect_err("one channel twice").code(), 2);
    }
}
