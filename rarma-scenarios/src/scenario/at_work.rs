//! Scenarios of the box at work: what it hears, what the host says, what breaks.

use super::file;
use super::reader::{Allowed, Refusal, Section};
use super::{Loaded, load};
use crate::error::ScenarioError;
use crate::speech;
use hal_sim::rig::{FaultEvent, FaultKind, Noise};
use rarma_box::settings::SettingValue;
use rarma_box::wire::Command;
use serde_json::{Value, json};
use toml::de::DeTable;

/// The shipped scenarios: name and text.
pub const BOX_SHIPPED: [(&str, &str); 4] = [
    (
        "box-cers-steps",
        include_str!("../../scenarios/box-cers-steps.toml"),
    ),
    (
        "box-cers-fault",
        include_str!("../../scenarios/box-cers-fault.toml"),
    ),
    (
        "box-ldbb-leak",
        include_str!("../../scenarios/box-ldbb-leak.toml"),
    ),
    (
        "box-bad-link",
        include_str!("../../scenarios/box-bad-link.toml"),
    ),
];

/// The box at work.
#[derive(Debug, Clone, PartialEq)]
pub struct AtWork {
    /// Name of the scenario.
    pub name: String,
    /// What it shows, in a line.
    pub about: String,
    /// How long, s.
    pub duration_s: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Spindle frequency, Hz.
    pub spindle_hz: f64,
    /// The cut that is heard; quiet noise if none.
    pub cut: Option<Loaded>,
    /// What happens to bytes on the link.
    pub noise: Noise,
    /// Part of the frames to the host that is lost.
    pub frame_loss: f64,
    /// What breaks.
    pub faults: Vec<FaultEvent>,
    /// Magnets and a spindle behind the coils, calibrated; what is heard is the accelerometer
    /// then.
    pub magnets: bool,
    /// What the host says, and when, s.
    pub host: Vec<(f64, Command)>,
}

/// A scenario from a file or a shipped one; a cut of the virtual machine tool becomes a box
/// that listens to it.
///
/// # Errors
/// One line: file, line, field, what is allowed.
pub fn load_box(name: &str, seed: Option<u64>) -> Result<AtWork, ScenarioError> {
    let shipped: Vec<_> = BOX_SHIPPED.into_iter().chain(super::SHIPPED).collect();
    let text = file::text(name, &shipped)?;
    // What is no TOML at all is told by either reader alike.
    let is_cut = DeTable::parse(&text).is_ok_and(|table| {
        let has = |key: &str| table.get_ref().iter().any(|(k, _)| k.get_ref() == key);
        has("milling") || has("turning")
    });
    if is_cut {
        listening(name, super::parse(name, &text, seed)?)
    } else {
        parse_box(name, &text, seed)
    }
}

fn listening(file: &str, cut: Loaded) -> Result<AtWork, ScenarioError> {
    let scenario = &cut.scenario;
    if scenario.microphone.sample_rate_hz != 48_000.0 {
        let rate_hz = scenario.microphone.sample_rate_hz;
        let what = format!("microphone.sample_rate_hz is {rate_hz} (allowed: 48000, the box's)");
        return Err(ScenarioError::new(file, "whole file", what));
    }
    let spindle_hz = scenario.process.spindle_hz();
    let set = |name: &str, value| match speech::setting(name) {
        Ok(setting) => Command::Set {
            setting: setting.number,
            value,
        },
        Err(_) => Command::Status,
    };
    let band = cut.band();
    let host = vec![
        (
            0.0,
            set("monitor.band-low", SettingValue::Real(band.low_hz as f32)),
        ),
        (
            0.0,
            set("monitor.band-high", SettingValue::Real(band.high_hz as f32)),
        ),
        (
            0.0,
            set("monitor.spindle", SettingValue::Real(spindle_hz as f32)),
        ),
        (0.001, Command::Start(rarma_box::guard::Mode::Monitor)),
    ];
    Ok(AtWork {
        name: scenario.name.clone(),
        about: cut.about.clone(),
        duration_s: scenario.duration_s,
        seed: scenario.microphone.seed,
        spindle_hz,
        noise: Noise::default(),
        frame_loss: 0.0,
        faults: Vec::new(),
        magnets: false,
        host,
        cut: Some(cut),
    })
}

/// A scenario from its text; `file` is what messages call it.
///
/// # Errors
/// As [`load_box`].
pub fn parse_box(file: &str, text: &str, seed: Option<u64>) -> Result<AtWork, ScenarioError> {
    let (mut at_work, cut) = file::parse(file, text, &box_schema(), |root| read(root, seed))?;
    if cut != QUIET {
        let heard = load(&cut, seed)
            .and_then(|loaded| listening(&cut, loaded))
            .map_err(|why| why.within(format_args!("{file}: hears")))?;
        at_work.spindle_hz = heard.spindle_hz;
        at_work.cut = heard.cut;
        at_work.host.splice(0..0, heard.host);
    }
    Ok(at_work)
}

/// The word for no cut.
const QUIET: &str = "quiet";

fn read(root: &mut Section<'_>, seed: Option<u64>) -> Result<(AtWork, String), Refusal> {
    let name = root.words("name", "Name of the scenario")?;
    let about = root.words("about", "What it shows, in a line")?;
    let duration_s = root.number(
        "duration_s",
        Allowed::within(0.1, 86_400.0),
        None,
        "How long, s",
    )?;
    let own = root.whole("seed", (0, i64::MAX), Some(1), "Seed of everything random")?;
    let cut = root.words(
        "hears",
        "A cut of the virtual machine tool (a file or a shipped name), or \"quiet\"",
    )?;
    let speed_rpm = root.number(
        "speed_rpm",
        Allowed::within(0.0, 120_000.0),
        Some(3000.0),
        "Spindle speed without a cut, 1/min",
    )?;
    let magnets = root.flag(
        "magnets",
        false,
        "Magnets and a spindle with the modes of the thesis' table 3 behind the coils, calibrated on a bench; the microphone is the accelerometer at the front bearing, 100 m/s² full scale",
    )?;
    let part = Allowed::within(0.0, 1.0);
    let link = root.table("link", "What happens on the link", |s| {
        Ok((
            Noise {
                drop: s.number("drop", part, Some(0.0), "Part of the bytes that is dropped")?,
                double: s.number("double", part, Some(0.0), "Part that is doubled")?,
                change: s.number("change", part, Some(0.0), "Part that is changed")?,
            },
            s.number(
                "frame_loss",
                part,
                Some(0.0),
                "Part of the box's frames that is lost whole",
            )?,
        ))
    })?;
    let (noise, frame_loss) = link.unwrap_or_default();
    let kinds: Vec<&str> = FaultKind::ALL.iter().map(|kind| kind.name()).collect();
    let time = Allowed::within(0.0, 86_400.0);
    let faults = root.tables("fault", "Something that breaks", |s| {
        let kind = FaultKind::ALL[s.choice("kind", &kinds, true, "What")?];
        let at_s = s.number("at_s", time, None, "From, s")?;
        let for_s = s.number("for_s", time, Some(86_400.0), "For so long, s")?;
        let place = s.whole("place", (0, 3), Some(0), "Coil (0 to 3) or axis (0 or 1)")?;
        Ok(FaultEvent {
            kind,
            place: place as usize,
            from_us: (1e6 * at_s) as u64,
            to_us: (1e6 * (at_s + for_s)) as u64,
        })
    })?;
    let host = root.tables("host", "Something the host says", |s| {
        let at_s = s.number("at_s", time, None, "When, s")?;
        let words = s.words("say", "A command, as typed in `rarma connect`")?;
        if s.describes() {
            return Ok((at_s, Command::Status));
        }
        let command = speech::command(&words).map_err(|why| {
            s.refuse(
                "say",
                format!("is \"{words}\": {why} (allowed: {})", speech::WORDS),
            )
        })?;
        Ok((at_s, command))
    })?;
    let at_work = AtWork {
        name,
        about,
        duration_s,
        seed: seed.unwrap_or(own as u64),
        spindle_hz: speed_rpm / 60.0,
        cut: None,
        noise,
        frame_loss,
        faults,
        magnets,
        host,
    };
    Ok((at_work, cut))
}

/// JSON schema of a scenario file, from the same calls that read it.
pub fn box_schema() -> Value {
    let mut root = Section::description();
    // A description answers every question: there is nothing to refuse.
    let _ = read(&mut root, None);
    let mut schema = root.schema();
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("Scenario of the box at work");
    schema
}
