//! What a controller may tell a box through the gateway: its spindle's speed and the tool's teeth.
//!
//! This is the only way from the broker to a box. [`Told`] has no value for arming, pressures, currents,
//! excitation, keys or any other setting, and [`Told::commands`] is the only place in the gateway that
//! makes a command that changes anything. A broker in the wrong hands can make a box mask the wrong
//! lines; it cannot energise anything.

use rarma_box::guard::Mode;
use rarma_box::settings::{MONITOR_SPINDLE, MONITOR_TEETH, SettingValue};
use rarma_box::wire::Command;

/// Fastest spindle that is believed, 1/min: what the box's setting takes.
pub const MOST_RPM: f64 = 300_000.0;
/// Most teeth that are believed: what the box's setting takes.
pub const MOST_TEETH: u32 = 1000;

/// See the module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Told {
    /// The spindle turns so fast, 1/min; 0: it is not known. It counts from the next sample on.
    Speed(f64),
    /// The tool has so many teeth; 0: not known. It counts when the monitor starts anew, which a box
    /// that monitors is told to do.
    Teeth(u32),
}

/// Why a value is not passed on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotTold {
    /// No such metric may be written.
    #[error("the metric {0:?} cannot be written (`Spindle/Speed` and `Spindle/Teeth` can)")]
    Metric(String),
    /// Not a number, or out of range.
    #[error("{metric}: {value} is not in {range}")]
    Value {
        /// Which metric.
        metric: &'static str,
        /// What was said.
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

    /// What a metric says.
    ///
    /// # Errors
    /// [`NotTold`]: it is not one of the two, or its value is none.
    pub fn of(metric: &str, value: f64) -> Result<Self, NotTold> {
        match metric {
            Self::SPEED if (0.0..=MOST_RPM).contains(&value) => Ok(Self::Speed(value)),
            Self::SPEED => Err(NotTold::Value {
                metric: Self::SPEED,
                value: value.to_string(),
                range: "0 to 300000 1/min",
            }),
            Self::TEETH
                if value.fract() == 0.0 && (0.0..=f64::from(MOST_TEETH)).contains(&value) =>
            {
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "checked"
                )]
                Ok(Self::Teeth(value as u32))
            }
            Self::TEETH => Err(NotTold::Value {
                metric: Self::TEETH,
                value: value.to_string(),
                range: "0 to 1000, whole",
            }),
            other => Err(NotTold::Metric(other.to_owned())),
        }
    }

    /// The commands that say it to a box. `mode` is what the box does now, as far as it has told:
    /// only a box that monitors is started anew.
    #[must_use]
    pub fn commands(self, mode: Option<Mode>) -> Vec<Command> {
        match self {
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
            name in prop_oneof![Just(Told::SPEED.to_owned()), Just(Told::TEETH.to_owned()), "\\PC{0,20}"],
            value in any::<f64>(),
            mode in proptest::option::of(proptest::sample::select(Mode::ALL.to_vec())),
        ) {
            if let Ok(told) = Told::of(&name, value) {
                let commands = told.commands(mode);
                prop_assert!(!commands.is_empty());
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
            assert_eq!(Told::of(name, 1.0), Err(NotTold::Metric(name.to_owned())));
        }
        for value in [f64::NAN, f64::INFINITY, -1.0, 300_001.0] {
            assert!(
                matches!(Told::of(Told::SPEED, value), Err(NotTold::Value { .. })),
                "{value}"
            );
        }
        assert!(Told::of(Told::TEETH, 2.5).is_err());
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
