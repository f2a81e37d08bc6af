//! The numbers of the verdict, each with its meaning and its unit.

use core::fmt;

/// A number of the verdict: what it usually is, and where it may lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// Its name, a field of [`VerdictConfig`].
    pub name: &'static str,
    /// Its usual value.
    pub usual: f64,
    /// Its least value.
    pub least: f64,
    /// Its largest value.
    pub most: f64,
}

macro_rules! numbers {
    ($($(#[doc = $doc:literal])* $name:ident: $usual:literal, $least:literal ..= $most:literal;)*) => {
        /// Every number of the verdict that is not given by physics. Evidence is a
        /// log-odds, natural logarithm; what each number does to the curve of detection
        /// against false alarms stands in docs/bench.md.
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct VerdictConfig {
            $(
                $(#[doc = $doc])*
                #[doc = concat!("Usually ", stringify!($usual), "; from ", stringify!($least), " to ", stringify!($most), ".")]
                pub $name: f64,
            )*
        }

        impl Default for VerdictConfig {
            fn default() -> Self {
                Self { $($name: $usual,)* }
            }
        }

        /// Each number as a constant, for a table of settings.
        #[allow(non_upper_case_globals)]
        pub mod number {
            use super::Number;
            $(
                $(#[doc = $doc])*
                pub const $name: Number =
                    Number { name: stringify!($name), usual: $usual, least: $least, most: $most };
            )*
        }

        impl VerdictConfig {
            /// All numbers.
            pub const NUMBERS: &'static [Number] = &[$(number::$name),*];

            /// The numbers in the order of [`Self::NUMBERS`], brought into their ranges; the
            /// usual one for a NaN, and for one that is not there.
            pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
                let mut values = values.into_iter();
                let mut next = |n: Number| match values.next() {
                    Some(x) if !x.is_nan() => x.clamp(n.least, n.most),
                    _ => n.usual,
                };
                Self { $($name: next(number::$name),)* }
            }

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
    /// Evidence from which on chatter is called.
    call: -1.0, -3.0..=3.0;
    /// Evidence, below the call, under which an alarm ends.
    hysteresis: 2.1, 0.1..=5.0;
    /// Time in which evidence of 1 moves the sum by 1, s.
    memory_s: 0.36, 0.1..=5.0;
    /// The sum starts at this and never falls below it.
    doubt: -3.0, -6.0..=0.0;
    /// Evidence of a line that nothing speaks against.
    belief: 0.6, 0.0..=10.0;
    /// Weight of the log-odds that the rotation does not make the line.
    free_weight: 1.25, 0.0..=4.0;
    /// Largest log-odds that count for the line.
    free_most: 1.8, 0.0..=6.0;
    /// Log-odds of the family's part of what the rotation leaves, below which it speaks
    /// against chatter.
    part_of_rest: 0.0, -5.0..=5.0;
    /// The same for its part of all power.
    part_of_all: -0.85, -6.0..=3.0;
    /// Level over idle, dB, below which it speaks against.
    over_idle_db: 23.0, 0.0..=40.0;
    /// Level over an idle that was never heard, dB.
    unheard_idle_db: 15.0, 0.0..=40.0;
    /// ln of the fluctuation S of the line's power within the window, above which it
    /// speaks against.
    fluctuation: -0.67, -5.0..=2.0;
    /// lg of the level over the loudest heard of late, below which it speaks against.
    level: -0.17, -3.0..=0.0;
    /// Standard deviation of a told speed, as a part of it.
    told_sd: 0.01, 0.001..=0.03;
    /// Part of the forced lines that lie on multiples of the teeth, not only of the turn.
    on_teeth: 0.7, 0.3..=1.0;
    /// Multiple of the tooth frequency from which on forced lines become rare.
    rare_multiple: 10.0, 2.0..=100.0;
    /// Part of the prior chance to be forced that is left to a line that stands alone: no
    /// other line tells of a rotation.
    alone: 0.3, 0.01..=1.0;
    /// Lines this near, as a part of the frequency, are one vibration.
    breadth: 0.05, 0.001..=0.1;
    /// A line that moves faster is bound to no structure, a part of its frequency a second.
    glide: 0.05, 0.001..=10.0;
}

/// Why a verdict cannot be made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
                for number in VerdictConfig::NUMBERS {
                    write!(f, " {}", number.name)?;
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
        assert!(VerdictConfig::NUMBERS.len() <= 20);
        let mut config = VerdictConfig::default();
        config.check().expect("the usual ones are in range");
        let usual = VerdictConfig::NUMBERS.iter().map(|n| n.usual);
        assert_eq!(VerdictConfig::of(usual), config);
        assert_eq!(VerdictConfig::of([]), config);
        assert_eq!(VerdictConfig::of([f64::NAN; 30]), config);
        for (far, end) in [(-1e9, -3.0), (1e9, 3.0)] {
            let brought = VerdictConfig::of([far; 30]);
            assert_eq!((brought.check(), brought.call), (Ok(()), end));
        }
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
