//! The sound card itself, by way of `cpal`.

use super::live::{Card, Live, Signals};
use super::offer::{Choice, Form, Offer, choose};
use super::ring::{Tap, ring};
use super::{Input, Wish};
use crate::failure::Failure;
use crate::screen;
use crate::signals::{self, INTERRUPTED};
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{BufferSize, Device, ErrorKind, FromSample, I24, SampleFormat, SizedSample};
use cpal::{Stream, StreamConfig, SupportedStreamConfigRange};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Between the audio thread and the monitor there is room for so much sound, s: a disk that
/// hesitates does not lose any.
const ROOM_S: f64 = 8.0;

/// The library for sound of Linux writes what it looks for and does not find to standard error, line
/// by line: what counts of it is in our own messages.
fn hush() {
    #[cfg(target_os = "linux")]
    let _ = alsa::Output::local_error_handler();
}

/// The inputs there are.
///
/// # Errors
/// The system's sound cannot be reached.
pub fn inputs() -> Result<Vec<Input>, Failure> {
    hush();
    let host = cpal::default_host();
    let usual = host.default_input_device();
    let devices = host.input_devices();
    let devices = devices.map_err(|why| refused("sound cards", &why))?;
    let mut all: Vec<Device> = devices.collect();
    if let Some(usual) = &usual
        && !all.contains(usual)
    {
        all.insert(0, usual.clone());
    }
    Ok(all
        .iter()
        .map(|device| Input {
            name: name(device),
            description: device.to_string(),
            usual: usual.as_ref() == Some(device),
            offers: offers(device).map_err(|why| why.to_string()),
        })
        .collect())
}

/// Opens an input, from which samples come at once. An interruption (Ctrl-C) or a request to end
/// stops it; a second one ends the program.
///
/// # Errors
/// It is not there, is in use, or does not offer what is wished.
pub fn open(wish: &Wish) -> Result<Live, Failure> {
    hush();
    let device = find(wish.device.as_deref())?;
    let called = format!("sound card {}", name(&device));
    let offers = offers(&device).map_err(|why| refused(&called, &why))?;
    let channels = wish
        .channels
        .iter()
        .max()
        .map_or(1, |c| c.saturating_add(1));
    let choice = choose(&offers, wish.rate_hz, channels)
        .map_err(|why| Failure::Input(format!("{called}: open: {why}")))?;
    let signals = Arc::new(Signals::default());
    let told = Arc::clone(&signals.told);
    let (tap, drain) = ring(choice.channels, f64::from(choice.rate_hz), ROOM_S, told);
    let stream = stream(&device, choice, tap, &signals).and_then(|stream| {
        stream.play()?;
        Ok(stream)
    });
    let stream = stream.map_err(|why| refused(&called, &why))?;
    let ending = Arc::clone(&signals);
    // One that cannot be set leaves the system's own: the program ends at once.
    let _ = signals::on_interrupt(move || {
        if ending.stop.swap(true, Ordering::Relaxed) {
            screen::end_at_once(INTERRUPTED);
        }
    });
    let card = Card {
        name: name(&device),
        choice,
    };
    Ok(Live::new(card, drain, signals, Some(Box::new(stream))))
}

/// The name by which a device is asked for.
fn name(device: &Device) -> String {
    let id = device.id().map(|id| id.id().to_owned());
    id.unwrap_or_else(|_| device.to_string())
}

/// The device of that name, or the usual one.
fn find(wanted: Option<&str>) -> Result<Device, Failure> {
    let host = cpal::default_host();
    let Some(wanted) = wanted else {
        return host.default_input_device().ok_or_else(|| {
            Failure::System(
                "sound card: open: this computer has no input for sound (connect a microphone or an interface, then `rarma listen --list`)"
                    .to_owned(),
            )
        });
    };
    let devices = host.input_devices();
    let devices = devices.map_err(|why| refused("sound cards", &why))?;
    let all: Vec<Device> = devices.chain(host.default_input_device()).collect();
    let called = |device: &&Device| name(device) == wanted;
    let described = |device: &&Device| device.to_string() == wanted;
    let found = all.iter().find(called);
    let found = found.or_else(|| all.iter().find(described));
    found.cloned().ok_or_else(|| {
        Failure::Input(format!(
            "sound card {wanted}: open: there is no such input (`rarma listen --list` names those there are)"
        ))
    })
}

fn offers(device: &Device) -> Result<Vec<Offer>, cpal::Error> {
    let offer = |range: SupportedStreamConfigRange| {
        Some(Offer {
            channels: usize::from(range.channels()),
            rates_hz: (range.min_sample_rate(), range.max_sample_rate()),
            form: form(range.sample_format())?,
        })
    };
    Ok(device
        .supported_input_configs()?
        .filter_map(offer)
        .collect())
}

/// The form of those formats that are read.
fn form(format: SampleFormat) -> Option<Form> {
    match format {
        SampleFormat::U8 => Some(Form::Integer(8)),
        SampleFormat::I16 => Some(Form::Integer(16)),
        SampleFormat::I24 => Some(Form::Integer(24)),
        SampleFormat::I32 => Some(Form::Integer(32)),
        SampleFormat::F32 => Some(Form::Float),
        _ => None,
    }
}

fn stream(
    device: &Device,
    choice: Choice,
    tap: Tap,
    signals: &Arc<Signals>,
) -> Result<Stream, cpal::Error> {
    match choice.form {
        Form::Integer(8) => stream_of::<u8>(device, choice, tap, signals),
        Form::Integer(16) => stream_of::<i16>(device, choice, tap, signals),
        Form::Integer(24) => stream_of::<I24>(device, choice, tap, signals),
        Form::Integer(_) => stream_of::<i32>(device, choice, tap, signals),
        Form::Float => stream_of::<f32>(device, choice, tap, signals),
    }
}

fn stream_of<T>(
    device: &Device,
    choice: Choice,
    mut tap: Tap,
    signals: &Arc<Signals>,
) -> Result<Stream, cpal::Error>
where
    T: SizedSample,
    f32: FromSample<T>,
{
    let config = StreamConfig {
        channels: choice.channels as u16,
        sample_rate: choice.rate_hz,
        buffer_size: BufferSize::Default,
    };
    let signals = Arc::clone(signals);
    device.build_input_stream::<T, _, _>(
        config,
        move |block, _| tap.take(block, Instant::now(), |x| x.to_sample()),
        move |why| trouble(&why, &signals),
        None,
    )
}

/// What the card's driver reports while it runs.
fn trouble(why: &cpal::Error, signals: &Signals) {
    match why.kind() {
        ErrorKind::Xrun => signals.told.lost.store(true, Ordering::Release),
        ErrorKind::DeviceNotAvailable | ErrorKind::HostUnavailable => {
            signals.gone("it has gone away (was it unplugged?)".to_owned());
        }
        ErrorKind::StreamInvalidated => {
            signals.gone("its rate or format was changed elsewhere".to_owned());
        }
        ErrorKind::DeviceChanged => {
            signals.say("the system has changed to another input".to_owned());
        }
        ErrorKind::RealtimeDenied => {}
        _ => signals.say(format!("the driver says: {why}")),
    }
}

/// A card that cannot be used, in one line.
fn refused(called: &str, why: &cpal::Error) -> Failure {
    let (what, remedy) = match why.kind() {
        ErrorKind::DeviceBusy => (
            "another program uses it".to_owned(),
            "end that one, or name a device that shares: default, pulse, pipewire",
        ),
        ErrorKind::PermissionDenied => (
            "this user may not listen to it".to_owned(),
            "Linux: join the group audio; macOS, Windows: allow the terminal the microphone in the privacy settings",
        ),
        ErrorKind::DeviceNotAvailable => (
            "it is not there".to_owned(),
            "connect it; `rarma listen --list` names the inputs there are",
        ),
        _ => (
            why.to_string(),
            "`rarma listen --list` names the inputs there are",
        ),
    };
    Failure::System(format!("{called}: open: {what} ({remedy})"))
}
