//! What a setting is, and a value of one.

use crate::key::LinkKey;
use core::marker::PhantomData;
use serde::{Deserialize, Serialize};

/// A value of a setting.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum SettingValue {
    /// A quantity.
    Real(f32),
    /// A count or a choice.
    Whole(u32),
    /// A key, on its way to the box or into its flash.
    Key(LinkKey),
    /// All that is ever said of a key: whether there is one. Set to false, it removes it.
    Hidden(bool),
}

impl SettingValue {
    /// What may be shown of it: of a key, that there is one.
    pub fn shown(self) -> Self {
        match self {
            Self::Key(_) => Self::Hidden(true),
            other => other,
        }
    }
}

/// Kind, range and default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A quantity; never NaN.
    Real {
        /// Least.
        low: f32,
        /// Greatest.
        high: f32,
        /// What it is until it is set.
        default: f32,
    },
    /// A count or a choice.
    Whole {
        /// Least.
        low: u32,
        /// Greatest.
        high: u32,
        /// What it is until it is set.
        default: u32,
    },
    /// A key; none until it is set.
    Key,
}

/// When a new value takes effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Takes {
    /// At once.
    AtOnce,
    /// When the mode is started next.
    NextMode,
    /// When the outputs are armed next.
    NextArm,
    /// At the next reset; save it before.
    AtStart,
}

impl Takes {
    /// For people.
    pub const fn words(self) -> &'static str {
        match self {
            Self::AtOnce => "at once",
            Self::NextMode => "when a mode is started",
            Self::NextArm => "when outputs are armed",
            Self::AtStart => "after save and reset",
        }
    }
}

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Number on the wire and in flash.
    pub number: u16,
    /// Version of its meaning; a stored record of another one is not read.
    pub version: u8,
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Kind, range, default.
    pub kind: Kind,
    /// When it takes effect.
    pub takes: Takes,
    /// What it does.
    pub effect: &'static str,
}

/// Why a value is not taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum SettingError {
    /// There is no such setting.
    Unknown,
    /// It is of the other kind.
    Kind,
    /// Outside this range, or not a number.
    Range {
        /// Least.
        low: f32,
        /// Greatest.
        high: f32,
    },
}

impl Setting {
    /// The value it has until it is set.
    pub const fn default_value(&self) -> SettingValue {
        match self.kind {
            Kind::Real { default, .. } => SettingValue::Real(default),
            Kind::Whole { default, .. } => SettingValue::Whole(default),
            Kind::Key => SettingValue::Hidden(false),
        }
    }

    /// Checks a value.
    ///
    /// # Errors
    /// Wrong kind, out of range, NaN.
    pub fn check(&self, value: SettingValue) -> Result<(), SettingError> {
        match (self.kind, value) {
            (Kind::Real { low, high, .. }, SettingValue::Real(x)) => {
                if x >= low && x <= high {
                    Ok(())
                } else {
                    Err(SettingError::Range { low, high })
                }
            }
            (Kind::Whole { low, high, .. }, SettingValue::Whole(n)) => {
                if (low..=high).contains(&n) {
                    Ok(())
                } else {
                    Err(SettingError::Range {
                        low: low as f32,
                        high: high as f32,
                    })
                }
            }
            (Kind::Key, SettingValue::Key(_) | SettingValue::Hidden(false)) => Ok(()),
            _ => Err(SettingError::Kind),
        }
    }
}

/// Marks a key to a [`SettingValue::Real`].
#[derive(Debug, Clone, Copy)]
pub struct Real;
/// Marks a key to a [`SettingValue::Whole`].
#[derive(Debug, Clone, Copy)]
pub struct Whole;

/// Marks the row of a key.
#[derive(Debug, Clone, Copy)]
pub struct Secret;

/// Where a setting of a known kind stands in the table.
#[derive(Debug)]
pub struct Key<K> {
    place: usize,
    kind: PhantomData<K>,
}

impl<K> Clone for Key<K> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<K> Copy for Key<K> {}

impl<K> Key<K> {
    pub(super) const fn at(place: usize) -> Self {
        Self {
            place,
            kind: PhantomData,
        }
    }

    /// Its number.
    pub fn number(self) -> u16 {
        // The table made both.
        super::SETTINGS.get(self.place).map_or(0, |s| s.number)
    }

    /// Its place in [`super::SETTINGS`].
    pub const fn place(self) -> usize {
        self.place
    }
}
