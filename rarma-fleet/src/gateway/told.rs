//! What a controller may tell through the gateway: its spindle's speed and the tool's teeth to a box, and
//! the tool's name to its records.
//!
//! This is the only way from the broker to a box. [`Told`] has no value for arming, pressures, currents,
//! excitation, keys or any other setting, and [`Told::commands`] is the only place in the gateway that
//! makes a command that changes anything. A broker in the wrong hands can make a box mask the wrong
//! lines; it cannot energise anything.

use super::value::Value;
use super::words::shortened;
use crate::record::Name;
use rarma_box::guard::Mode;
use rarma_box::settings::{MONITOR_SPINDLE, MONITOR_TEETH, SettingValue};
use rarma_box::wire::Command;
use std::fmt;

/// Fastest spindle that is believed, 1/min: what the box's setting takes.
pub const MOST_RPM: f64 = 300_000.0;
/// Most teeth that are believed: what the box's setting takes.
pub const MOST_TEETH: u32 = 1000;

/// One thing that a controller tells.
#[derive(Debug, Clone, PartialEq)]
pub enum Told {
    /// The spindle turns so fast, 1/min; 0: it is not known. It counts from the next sample on.
    Speed(f64),
    /// The tool has so many teeth; 0: not known. It counts when the monitor starts anew, which a box
    /// that monitors is told to do.
    Teeth(u32),
    /// This tool is in the spindle; none: it is not known. The box is not told: it stands in records.
    Tool(Option<Name>),
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Speed(rpm) => write!(f, "the speed {rpm} 1/min"),
            Self::Teeth(teeth) => write!(f, "{teeth} teeth"),
            Self::Tool(Some(tool)) => write!(f, "the tool {tool}"),
            Self::Tool(None) => f.write_str("no tool"),
        }
    }
}

/// Why a value is not passed on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotTold {
    /// No such metric may be written; its name, shortened.
    #[error(
        "the metric {0:?} cannot be written (`Spindle/Speed`, `Spindle/Teeth` and `Spindle/Tool` can)"
    )]
    Metric(String),
    /// Of another type, or out of range.
    #[error("{metric}: {value} is not in {range}")]
    Value {
        /// Which metric.
        metric: &'static str,
        /// What was said, shortened.
        value: String,
        /// What goes.
        range: &'static str,
    },
}

impl Told {
    /// Name of the metric that tells the speed.
    pub const SPEED: &'static str = "Spindle/Speed";
    /// Name of the metric that tells the teeth.
    pub const TEETH: &'static str = "Spindle/Teeth";
    /// Name of the metric that tells the tool.
    pub const TOOL: &'static str = "Spindle/Tool";
    /// So many kinds there are.
    pub(super) const KINDS: usize = 3;

    /// Which of the kinds it is, from 0.
    pub(super) fn kind(&self) -> usize {
        match self {
            Self::Speed(_) => 0,
            Self::Teeth(_) => 1,
            Self::Tool(_) => 2,
        }
    }

    /// What a metric says. A text without a character is no tool.
    ///
    /// # Errors
    /// [`NotTold`]: it is not one of the three, or its value is none.
    pub fn of(metric: &str, value: &Value) -> Result<Self, NotTold> {
        let (metric, range) = match (metric, value) {
            (Self::SPEED, Value::Number(rpm)) if (0.0..=MOST_RPM).contains(rpm) => {
                return Ok(Self::Speed(*rpm));
            }
            (Self::SPEED, _) => (Self::SPEED, "0 to 300000 1/min"),
            (Self::TEETH, Value::Number(teeth))
                if teeth.fract() == 0.0 && (0.0..=f64::from(MOST_TEETH)).contains(teeth) =>
            {
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "checked"
                )]
                return Ok(Self::Teeth(*teeth as u32));
            }
            (Self::TEETH, _) => (Self::TEETH, "0 to 1000, whole"),
            (Self::TOOL, Value::Text(text)) if text.is_empty() => return Ok(Self::Tool(None)),
            (Self::TOOL, value) => {
                if let Value::Text(text) = value
                    && let Ok(tool) = Name::new(text)
                {
                    return Ok(Self::Tool(Some(tool)));
                }
                (
                    Self::TOOL,
                    "texts of 64 characters at most without `/`, `+`, `#`",
                )
            }
            (other, _) => return Err(NotTold::Metric(shortened(other))),
        };
        let value = match value {
            Value::Text(text) => format!("{:?}", shortened(text)),
            Value::Number(number) => number.to_string(),
            Value::Count(count) => count.to_string(),
            Value::Flag(flag) => flag.to_string(),
        };
        Err(NotTold::Value {
            metric,
            value,
            range,
        })
    }

    /// The commands that say it to a box. `mode` is what the box does now, as far as it has told:
    /// only a box that monitors is started anew. None of a tool.
    #[must_use]
    pub fn commands(&self, mode: Option<Mode>) -> Vec<Command> {
        match *self {
            Self::Tool(_) => Vec::new(),
            #[allow(clippy::cast_possible_truncation, reason = "the box holds singles")]
            Self::Speed(rpm) => vec![Command::Set {
                setting: MONITOR_SPINDLE.number(),
                value: SettingValue::Real((rpm / 60.0) as f32),
            }],
            Self::Teeth(teeth) => {
                let mut commands = vec![Command::Set {
                    setting: MONITOR_TEETH.number(),
                    value: SettingValue::Whole(teeth),
                }];
                if mode == Some(Mode::Monitor) {
                    commands.push(Command::Start(Mode::Monitor));
                }
                commands
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rarma_box::settings::SETTINGS;

    /// The two settings, and the mode that owns no output.
    fn energises_nothing(command: &Command) -> bool {
        match command {
            Command::Set { setting, .. } => {
                let row = SETTINGS.iter().find(|row| row.number == *setting).unwrap();
                matches!(row.name, "monitor.spindle" | "monitor.teeth")
            }
            Command::Start(mode) => !mode.owns_outputs(),
            _ => false,
        }
    }

    proptest! {
        #[test]
        fn whatever_is_said_makes_only_commands_that_energise_nothing(
            name in prop_oneof![
                Just(Told::SPEED.to_owned()),
                Just(Told::TEETH.to_owned()),
                Just(Told::TOOL.to_owned()),
                "\\PC{0,20}",
            ],
            value in prop_oneof![
                any::<f64>().prop_map(Value::Number),
                (0.0..2000.0_f64).prop_map(|x| Value::Number(x.round())),
                "\\PC{0,80}".prop_map(Value::Text),
                any::<bool>().prop_map(Value::Flag),
            ],
            mode in proptest::option::of(proptest::sample::select(Mode::ALL.to_vec())),
        ) {
            if let Ok(told) = Told::of(&name, &value) {
                let commands = told.commands(mode);
                prop_assert_eq!(commands.is_empty(), name == Told::TOOL);
                prop_assert!(commands.iter().all(energises_nothing), "{commands:?}");
            }
        }
    }

    #[test]
    fn the_names_of_commands_are_no_metrics() {
        for name in [
            "arm",
            "Arm",
            "Box/Arm",
            "ldbb.most",
            "link.key",
            "Node Control/Reboot",
            "Spindle/speed",
        ] {
            let told = Told::of(name, &Value::Number(1.0));
            assert_eq!(told, Err(NotTold::Metric(name.to_owned())));
        }
        for value in [f64::NAN, f64::INFINITY, -1.0, 300_001.0] {
            assert!(
                matches!(
                    Told::of(Told::SPEED, &Value::Number(value)),
                    Err(NotTold::Value { .. })
                ),
                "{value}"
            );
        }
        assert!(Told::of(Told::TEETH, &Value::Number(2.5)).is_err());
        assert!(Told::of(Told::TEETH, &Value::Text("4".to_owned())).is_err());
    }

    #[test]
    fn a_tool_is_a_name_and_goes_to_no_box() {
        let tool = |text: &str| Told::of(Told::TOOL, &Value::Text(text.to_owned()));
        let named = tool("T12 finisher").unwrap();
        assert_eq!(named, Told::Tool(Some(Name::new("T12 finisher").unwrap())));
        assert_eq!(tool(""), Ok(Told::Tool(None)));
        for wrong in ["a/b", "+", " T1", "T1\n", &"x".repeat(65)] {
            let why = tool(wrong).unwrap_err().to_string();
            assert!(why.starts_with("Spindle/Tool: "), "{why}");
        }
        assert!(Told::of(Told::TOOL, &Value::Number(12.0)).is_err());
        assert!(named.commands(Some(Mode::Monitor)).is_empty());
    }

    /// Names and texts come from outside: what is said of them stays a line.
    #[test]
    fn what_is_said_of_long_names_and_texts_is_short() {
        let long = "x\n".repeat(100_000);
        for (metric, value) in [
            (long.as_str(), Value::Number(1.0)),
            (Told::SPEED, Value::Text(long.clone())),
            (Told::TOOL, Value::Text(long.clone())),
        ] {
            let why = Told::of(metric, &value).unwrap_err().to_string();
            assert!(why.len() < 250 && !why.contains('\n'), "{why}");
        }
    }

    #[test]
    fn only_a_box_that_monitors_is_started_anew() {
        let set = Command::Set {
            setting: 16,
            value: SettingValue::Whole(4),
        };
        assert_eq!(
            Told::Teeth(4).commands(Some(Mode::Monitor)),
            [set, Command::Start(Mode::Monitor)]
        );
        for mode in [None, Some(Mode::Safe), Some(Mode::Cers), Some(Mode::Ldbb)] {
            assert_eq!(Told::Teeth(4).commands(mode), [set]);
        }
        let hz = Command::Set {
            setting: 15,
            value: SettingValue::Real(100.0),
        };
        assert_eq!(Told::Speed(6000.0).commands(Some(Mode::Monitor)), [hz]);
    }
}
