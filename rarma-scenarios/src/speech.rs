//! Commands to the box in words: typed by people, and written in scenarios.

use rarma_box::guard::Mode;
use rarma_box::settings::{Kind, SETTINGS, Setting, SettingValue};
use rarma_box::wire::{CircleJob, Command, JOB_PRESSURES, StandJob};
use rarma_recordings::one_line::OneLine;
use rarma_rigs::cers::{Direction, ExcitationJob, Signal};

/// What can be said.
pub const WORDS: &str = "identify | status | take | release | start safe|monitor|cers|ldbb | stop | arm | clear | stream SECONDS | pressure PA | current A | circle MM_PER_MIN BAR,BAR,… [both] [down] | static DIRECTIONS BAR,BAR,… | go | excite noise|prbs|sweep|steps x|y|both RMS_A LOW:HIGH SECONDS [LINES] | quiet | read NAME | set NAME VALUE | save NAME | reset NAME";

/// A line to a command.
///
/// # Errors
/// What is wrong with it, and what can be said: one line.
pub fn command(line: &str) -> Result<Command, String> {
    read(line).map_err(|why| {
        let why = OneLine(&why).to_string();
        match form(line) {
            Some(form) if !why.ends_with(')') => format!("{why} (say {form})"),
            _ => why,
        }
    })
}

/// Whether a line says that whoever types goes.
pub fn goes(line: &str) -> bool {
    matches!(line.trim(), "quit" | "exit" | "q")
}

/// The form of the command that a line begins, such as `set NAME VALUE`.
pub fn form(line: &str) -> Option<&'static str> {
    let word = line.split_whitespace().next()?;
    let mut forms = WORDS.split(" | ");
    forms.find(|form| form.split_whitespace().next() == Some(word))
}

/// The words that may stand at the end of a line that is being typed, as far as they are known:
/// its last word is what has been typed of them. In the order of [`WORDS`] and of the settings.
pub fn completions(line: &str) -> Vec<&'static str> {
    let mut words: Vec<&str> = line.split_whitespace().collect();
    let begun = if line.ends_with(char::is_whitespace) {
        ""
    } else {
        words.pop().unwrap_or_default()
    };
    let mut all: Vec<&'static str> = match words.first() {
        None => WORDS.split(" | ").map(first_word).collect(),
        Some(first) => match form(first).map(|form| form.split_whitespace().collect::<Vec<_>>()) {
            Some(form) => match form.get(words.len()) {
                Some(&"NAME") => SETTINGS.iter().map(|setting| setting.name).collect(),
                Some(place) => place.trim_matches(['[', ']']).split('|').collect(),
                None => Vec::new(),
            },
            None => Vec::new(),
        },
    };
    // What stands for something else is written in capitals.
    all.retain(|word| word.starts_with(begun) && !word.starts_with(char::is_uppercase));
    all
}

fn first_word(form: &'static str) -> &'static str {
    form.split_whitespace().next().unwrap_or_default()
}

fn read(line: &str) -> Result<Command, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let number = |text: &str| {
        text.parse::<f32>()
            .ok()
            .filter(|x| x.is_finite())
            .ok_or_else(|| format!("`{text}` is not a number"))
    };
    Ok(match words[..] {
        ["identify"] => Command::Identify,
        ["status"] => Command::Status,
        ["stop"] => Command::Stop,
        ["arm"] => Command::Arm,
        ["clear"] => Command::Clear,
        // The turn that is under way is filled in when it is sent.
        ["take"] => Command::Take { turn: 0 },
        ["release"] => Command::Release,
        ["heartbeat"] => Command::Heartbeat,
        ["start", name] => Command::Start(
            Mode::ALL
                .into_iter()
                .find(|mode| mode.name() == name)
                .ok_or_else(|| format!("`{name}` is no mode (safe, monitor, cers, ldbb)"))?,
        ),
        ["stream", seconds] => Command::Stream {
            seconds: number(seconds)?,
        },
        ["pressure", pa] => Command::Pressure { pa: number(pa)? },
        ["current", a] => Command::Current { a: number(a)? },
        ["circle", feed, bars, ref ways @ ..] => circle(number(feed)?, bars, ways)?,
        ["static", directions, bars] => stand(directions, bars)?,
        ["go"] => Command::Go,
        ["excite", signal, direction, rms_a, band, seconds] => excite(
            signal,
            direction,
            number(rms_a)?,
            band,
            number(seconds)?,
            None,
        )?,
        ["excite", signal, direction, rms_a, band, seconds, lines] => excite(
            signal,
            direction,
            number(rms_a)?,
            band,
            number(seconds)?,
            Some(lines),
        )?,
        ["quiet"] => Command::Quiet,
        ["read", name] => Command::Read {
            setting: setting(name)?.number,
        },
        ["save", name] => Command::Save {
            setting: setting(name)?.number,
        },
        ["reset", name] => Command::Reset {
            setting: setting(name)?.number,
        },
        ["set", name, value] => {
            let setting = setting(name)?;
            Command::Set {
                setting: setting.number,
                value: self::value(setting, value)?,
            }
        }
        _ if form(line).is_some() => {
            return Err(format!("`{}` has too few or too many words", line.trim()));
        }
        _ => {
            let all: Vec<&str> = WORDS.split(" | ").map(first_word).collect();
            let line = line.trim();
            return Err(format!(
                "`{line}` is no command (say one of {})",
                all.join(", ")
            ));
        }
    })
}

/// `circle FEED BARS [both] [down]`: feed in mm/min, pressures in bar.
fn circle(feed_mm_min: f32, bars: &str, ways: &[&str]) -> Result<Command, String> {
    let pressures_pa = pressures(bars)?;
    if let Some(word) = ways.iter().find(|w| !["both", "down"].contains(w)) {
        return Err(format!("`{word}` is neither both nor down"));
    }
    let job = CircleJob {
        pressures_pa,
        feed_m_s: feed_mm_min / 6e4,
        radius_m: 0.15,
        both: ways.contains(&"both"),
        down: ways.contains(&"down"),
    };
    if job.procedure().is_none() {
        return Err("the pressures must rise and the feed be above 0".to_owned());
    }
    Ok(Command::Circle(job))
}

/// `excite SIGNAL DIRECTION RMS_A LOW:HIGH SECONDS [LINES]`; what is within reach is the
/// box's to say.
fn excite(
    signal: &str,
    direction: &str,
    rms_a: f32,
    band: &str,
    seconds: f32,
    lines: Option<&str>,
) -> Result<Command, String> {
    let signal = Signal::ALL
        .into_iter()
        .find(|s| s.name() == signal)
        .ok_or_else(|| format!("`{signal}` is no signal (noise, prbs, sweep, steps)"))?;
    let direction = Direction::ALL
        .into_iter()
        .find(|d| d.name() == direction)
        .ok_or_else(|| format!("`{direction}` is no direction (x, y, both)"))?;
    let edges = band.split_once(':').and_then(|(low, high)| {
        let edge = |text: &str| text.parse::<f32>().ok().filter(|x| x.is_finite());
        Some((edge(low)?, edge(high)?))
    });
    let (low_hz, high_hz) = edges.ok_or_else(|| format!("`{band}` is no band LOW:HIGH in Hz"))?;
    let lines = match (lines, signal) {
        (Some(text), _) => text
            .parse()
            .map_err(|_| format!("`{text}` is not a number of lines"))?,
        (None, Signal::Steps) => return Err("steps need a number of lines".to_owned()),
        (None, _) => 0,
    };
    Ok(Command::Excite(ExcitationJob {
        signal,
        direction,
        rms_a,
        low_hz,
        high_hz,
        seconds,
        lines,
    }))
}

/// `static DIRECTIONS BARS`: pressures in bar, up and down in each direction.
fn stand(directions: &str, bars: &str) -> Result<Command, String> {
    let job = StandJob {
        pressures_pa: pressures(bars)?,
        directions: directions
            .parse()
            .map_err(|_| format!("`{directions}` is not a number of directions"))?,
    };
    if job.schedule().is_none() {
        return Err("the pressures must rise, and there must be a direction".to_owned());
    }
    Ok(Command::Stand(job))
}

/// Pressures in bar, Pa.
fn pressures(bars: &str) -> Result<[f32; JOB_PRESSURES], String> {
    let mut pressures_pa = [0.0; JOB_PRESSURES];
    let given: Vec<&str> = bars.split(',').collect();
    if given.len() > JOB_PRESSURES {
        return Err(format!(
            "{} pressures, there is room for {JOB_PRESSURES}",
            given.len()
        ));
    }
    for (place, bar) in pressures_pa.iter_mut().zip(given) {
        let bar: f32 = bar
            .parse()
            .map_err(|_| format!("`{bar}` is not a number"))?;
        *place = 1e5 * bar;
    }
    Ok(pressures_pa)
}

/// The setting of a name.
///
/// # Errors
/// There is none; the nearest group is listed.
pub fn setting(name: &str) -> Result<&'static Setting, String> {
    SETTINGS.iter().find(|s| s.name == name).ok_or_else(|| {
        let group = name.split('.').next().unwrap_or_default();
        let like: Vec<&str> = SETTINGS
            .iter()
            .map(|s| s.name)
            .filter(|n| n.split('.').next() == Some(group))
            .collect();
        if like.is_empty() {
            format!("`{name}` is no setting (see docs/box.md)")
        } else {
            format!("`{name}` is no setting (there are {})", like.join(", "))
        }
    })
}

/// A value of a setting in words.
///
/// # Errors
/// Not a number of its kind. Its range is the box's to check.
pub fn value(setting: &Setting, text: &str) -> Result<SettingValue, String> {
    match setting.kind {
        Kind::Real { .. } => text.parse().map(SettingValue::Real).ok(),
        Kind::Whole { .. } => text.parse().map(SettingValue::Whole).ok(),
        Kind::Key => {
            return Err(format!(
                "{} is not typed (give it in a file: `rarma connect PORT --set-key FILE`)",
                setting.name
            ));
        }
    }
    .ok_or_else(|| {
        let (name, text) = (setting.name, OneLine(text));
        format!("`{text}` is not a number that {name} takes (`rarma box --settings` lists what it takes)")
    })
}

/// A value as it is typed.
pub fn shown(value: SettingValue) -> String {
    match value {
        SettingValue::Real(x) => format!("{x}"),
        SettingValue::Whole(n) => format!("{n}"),
        SettingValue::Hidden(false) => "not set".to_owned(),
        SettingValue::Hidden(true) | SettingValue::Key(_) => "set".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_is_completed_is_what_can_be_said() {
        assert_eq!(
            completions("st"),
            ["status", "start", "stop", "stream", "static"]
        );
        assert_eq!(completions("start "), ["safe", "monitor", "cers", "ldbb"]);
        assert_eq!(completions("excite noise "), ["x", "y", "both"]);
        assert_eq!(completions("circle 1000 1,2 "), ["both"]);
        assert_eq!(completions("read link.h"), ["link.heartbeat"]);
        assert_eq!(completions("set ").len(), SETTINGS.len());
        for line in ["pressure ", "nothing ", "stop ", "stop now", "set a b "] {
            assert!(completions(line).is_empty(), "{line}");
        }
        // Every command there is, by the parser that reads what is typed.
        for word in completions("") {
            let said = command(word).err().unwrap_or_default();
            assert!(!said.contains("is no command"), "{word}: {said}");
        }
    }

    #[test]
    fn words_become_commands_and_the_rest_is_refused_with_help() {
        assert_eq!(command("start cers"), Ok(Command::Start(Mode::Cers)));
        assert_eq!(
            command(" stream  2.5 "),
            Ok(Command::Stream { seconds: 2.5 })
        );
        assert_eq!(
            command("set monitor.threshold 0.02"),
            Ok(Command::Set {
                setting: 13,
                value: SettingValue::Real(0.02)
            })
        );
        let steps = Command::Excite(ExcitationJob {
            signal: Signal::Steps,
            direction: Direction::Both,
            rms_a: 0.1,
            low_hz: 300.0,
            high_hz: 2500.0,
            seconds: 60.0,
            lines: 150,
        });
        assert_eq!(command("excite steps both 0.1 300:2500 60 150"), Ok(steps));
        for (line, says) in [
            ("fly", "is no command"),
            ("start up", "is no mode"),
            ("set monitor.nothing 1", "monitor.threshold"),
            ("set tacho.pulses 1.5", "tacho.pulses"),
            ("set link.key 00", "--set-key"),
            ("stream inf", "not a number"),
            ("", "is no command"),
            ("excite hum x 0.1 100:1000 5", "is no signal"),
            ("excite noise z 0.1 100:1000 5", "is no direction"),
            ("excite noise x 0.1 100-1000 5", "is no band"),
            ("excite steps x 0.1 100:1000 5", "number of lines"),
            ("stream x", "(say stream SECONDS)"),
            ("start", "(say start safe|monitor|cers|ldbb)"),
            ("pressure \u{1b}[2J", "\\u{1b}"),
        ] {
            let why = command(line).expect_err(line);
            assert!(why.contains(says), "{line}: {why}");
            assert!(why.ends_with(')') && why.contains(" ("), "{line}: {why}");
        }
    }
}
