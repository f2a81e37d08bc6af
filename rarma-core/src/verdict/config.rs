//! The numbers of the verdict, each with its meaning and its unit.

use core::fmt;
use serde::{Deserialize, Serialize};

/// A number of the verdict.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// Its unit; 1: none.
    pub unit: &'static str,
    /// What it is until it is set.
    pub usual: f64,
    /// Least value.
    pub least: f64,
    /// Largest value.
    pub most: f64,
    /// What it does.
    pub meaning: &'static str,
}

impl Number {
    /// A value that came as `f32`, whose range may have been rounded outwards.
    pub fn held(&self, value: f32) -> f64 {
        f64::from(value).clamp(self.least, self.most)
    }
}

macro_rules! numbers {
    ($($name:ident: $unit:literal, $usual:literal, $least:literal ..= $most:literal, $meaning:literal;)*) => {
        /// Each number of [`VerdictConfig`], by its name: unit, usual value, range, meaning.
        #[allow(non_upper_case_globals)]
        pub mod number {
            use super::Number;
            $(
                #[doc = concat!("`", stringify!($name), "`: ", $meaning, ".")]
                pub const $name: Number = Number {
                    unit: $unit,
                    usual: $usual,
                    least: $least,
                    most: $most,
                    meaning: $meaning,
                };
            )*
        }

        /// Every number of the verdict that is not given by physics. Evidence is a
        /// log-odds, natural logarithm; what each number does to the curve of detection
        /// against false alarms stands in docs/bench.md.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        pub struct VerdictConfig {
            $(
                #[doc = concat!($meaning, "; ", $unit, ". Usually ", stringify!($usual), ", from ", stringify!($least), " to ", stringify!($most), ".")]
                pub $name: f64,
            )*
        }

        impl Default for VerdictConfig {
            fn default() -> Self {
                Self { $($name: $usual,)* }
            }
        }

        impl VerdictConfig {
            /// Names of the numbers.
            pub const NAMES: &'static [&'static str] = &[$(stringify!($name)),*];

            /// Sets one number by its name.
            ///
            /// # Errors
            /// No such name, or out of range; nothing is changed then.
            pub fn set(&mut self, name: &str, value: f64) -> Result<(), VerdictError> {
                match name {
                    $(stringify!($name) => {
                        if !($least..=$most).contains(&value) {
                            return Err(VerdictError::Range { name: stringify!($name), least: $least, most: $most });
                        }
                        self.$name = value;
                    })*
                    _ => return Err(VerdictError::Name),
                }
                Ok(())
            }

            /// A number by its name.
            pub fn get(&self, name: &str) -> Option<f64> {
                match name {
                    $(stringify!($name) => Some(self.$name),)*
                    _ => None,
                }
            }

            /// Least and largest value of a number.
            pub fn range(name: &str) -> Option<(f64, f64)> {
                match name {
                    $(stringify!($name) => Some(($least, $most)),)*
                    _ => None,
                }
            }

            /// Checks every number.
            ///
            /// # Errors
            /// The first that is out of range.
            pub fn check(&self) -> Result<(), VerdictError> {
                let mut copy = *self;
                $(copy.set(stringify!($name), self.$name)?;)*
                Ok(())
            }
        }
    };
}

numbers! {
    call: "1", -1.0, -3.0..=3.0, "evidence from which on chatter is called";
    hysteresis: "1", 2.1, 0.1..=5.0, "evidence, below the call, under which an alarm ends";
    memory_s: "s", 0.36, 0.1..=5.0, "time in which evidence of 1 moves the sum by 1";
    doubt: "1", -3.0, -6.0..=0.0, "the sum starts at this and never falls below it";
    belief: "1", 0.6, 0.0..=10.0, "evidence of a line that nothing speaks against";
    free_weight: "1", 1.25, 0.0..=4.0, "weight of the log-odds that the rotation does not make the line";
    free_most: "1", 1.8, 0.0..=6.0, "largest log-odds that count for the line";
    part_of_rest: "1", 0.0, -5.0..=5.0, "log-odds of the family's part of what the rotation leaves, below which it speaks against chatter";
    part_of_all: "1", -0.85, -6.0..=3.0, "the same for its part of all power";
    over_idle_db: "dB", 23.0, 0.0..=40.0, "level over idle below which it speaks against";
    unheard_idle_db: "dB", 15.0, 0.0..=40.0, "level over an idle that was never heard";
    fluctuation: "1", -0.65, -5.0..=2.0, "ln of the fluctuation S of the line's power within the window, above which it speaks against";
    level: "1", -0.17, -3.0..=0.0, "lg of the level over the loudest heard, below which it speaks against";
    told_sd: "1", 0.01, 0.001..=0.03, "standard deviation of a told speed, as a part of it";
    on_teeth: "1", 0.7, 0.3..=1.0, "part of the forced lines that lie on multiples of the teeth, not only of the turn";
    rare_multiple: "1", 20.0, 2.0..=100.0, "multiple of the tooth frequency from which on forced lines become rare";
    alone: "1", 0.3, 0.01..=1.0, "part of the prior chance to be forced that is left to a line that stands alone: no other line tells of a rotation";
    breadth: "1", 0.05, 0.001..=0.1, "lines this near, as a part of the frequency, are one vibration";
    glide: "1/s", 0.05, 0.001..=10.0, "a line that moves faster is bound to no structure, a part of its frequency a second";
}

/// Why a verdict cannot be made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VerdictError {
    /// No number of this name.
    Name,
    /// A number is out of range.
    Range {
        /// Which.
        name: &'static str,
        /// Its least value.
        least: f64,
        /// Its largest value.
        most: f64,
    },
    /// The rate must lie in 100..=20000 Hz.
    Rate,
    /// The speed must lie in 0.1..=5000 Hz.
    Speed,
    /// Teeth must be 1..=1000.
    Teeth,
}

impl fmt::Display for VerdictError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name => {
                f.write_str("no such number; there are")?;
                for name in VerdictConfig::NAMES {
                    write!(f, " {name}")?;
                }
                Ok(())
            }
            Self::Range { name, least, most } => write!(f, "{name} must lie in {least}..={most}"),
            Self::Rate => f.write_str("the rate must lie in 100..=20000 Hz"),
            Self::Speed => f.write_str("the speed must lie in 0.1..=5000 turns a second"),
            Self::Teeth => f.write_str("teeth must be 1..=1000"),
        }
    }
}

impl core::error::Error for VerdictError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_few_and_set_by_name() {
        assert!(VerdictConfig::NAMES.len() <= 20);
        let mut config = VerdictConfig::default();
        config.check().expect("the usual ones are in range");
        config.set("memory_s", 0.25).expect("in range");
        assert_eq!(config.memory_s, 0.25);
        assert_eq!(config.set("memory", 0.25), Err(VerdictError::Name));
        let before = config;
        let refused = config.set("memory_s", f64::NAN);
        assert!(matches!(
            refused,
            Err(VerdictError::Range {
                name: "memory_s",
                ..
            })
        ));
        assert_eq!(config, before);
        config.alone = 2.0;
        assert!(matches!(
            config.check(),
            Err(VerdictError::Range { name: "alone", .. })
        ));
    }
}
