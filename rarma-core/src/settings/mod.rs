//! Settings of the box: typed, with unit, range, default and effect, from one table.
//!
//! Slow path: read when a mode starts or the outputs are armed, never in a sample.

mod page;
mod stored;
mod table;
mod value;

pub use page::{markdown, write_schema};
pub use stored::{RECORD_BYTES, RecordError, from_record, to_record};
pub use table::*;
pub use value::{Key, Kind, Real, Setting, SettingError, SettingValue, Takes, Whole};

/// Version of the table as a whole, told by `identify`.
pub const SCHEMA_VERSION: u8 = 1;
/// How many settings there are.
pub const COUNT: usize = SETTINGS.len();

/// The values in force.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    values: [SettingValue; COUNT],
}

impl Default for Settings {
    fn default() -> Self {
        let mut values = [SettingValue::Whole(0); COUNT];
        for (value, setting) in values.iter_mut().zip(&SETTINGS) {
            *value = setting.default_value();
        }
        Self { values }
    }
}

/// The row of a number.
pub fn find(number: u16) -> Option<(usize, &'static Setting)> {
    SETTINGS
        .iter()
        .enumerate()
        .find(|(_, s)| s.number == number)
}

impl Settings {
    /// A quantity.
    pub fn real(&self, key: Key<Real>) -> f32 {
        match self.values.get(key.place()) {
            Some(SettingValue::Real(x)) => *x,
            // A key of this kind stands at a value of this kind: the table made both.
            _ => 0.0,
        }
    }

    /// A count or a choice.
    pub fn whole(&self, key: Key<Whole>) -> u32 {
        match self.values.get(key.place()) {
            Some(SettingValue::Whole(n)) => *n,
            _ => 0,
        }
    }

    /// The value of a number.
    pub fn get(&self, number: u16) -> Option<SettingValue> {
        find(number).and_then(|(place, _)| self.values.get(place).copied())
    }

    /// Sets one value; in force until the next reset, unless it is saved.
    ///
    /// # Errors
    /// Unknown, of the other kind, or out of range: nothing has changed.
    pub fn set(&mut self, number: u16, value: SettingValue) -> Result<(), SettingError> {
        let (place, setting) = find(number).ok_or(SettingError::Unknown)?;
        setting.check(value)?;
        if let Some(there) = self.values.get_mut(place) {
            *there = value;
        }
        Ok(())
    }
}
