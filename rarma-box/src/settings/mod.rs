//! Settings of the box: typed, with unit, range, default and effect, from one table.
//!
//! Slow path: read when a mode starts or the outputs are armed, never in a sample.

mod page;
mod stored;
mod table;
mod value;

use crate::key::LinkKey;
pub use page::{markdown, write_schema};
use rarma_core::verdict::VerdictConfig;
pub use stored::{RECORD_BYTES, RecordError, from_record, to_record};
pub use table::*;
pub use value::{Key, Kind, Real, Secret, Setting, SettingError, SettingValue, Takes, Whole};

/// Version of the table as a whole, told by `identify`.
pub const SCHEMA_VERSION: u8 = 1;
/// How many settings there are.
pub const COUNT: usize = SETTINGS.len();

/// The values in force.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Bits of each value in the order of the table; its kind is the table's.
    values: [u32; COUNT],
    key: Option<LinkKey>,
}

impl Default for Settings {
    fn default() -> Self {
        let mut values = [0; COUNT];
        for (value, setting) in values.iter_mut().zip(&SETTINGS) {
            *value = match setting.kind {
                Kind::Real { default, .. } => default.to_bits(),
                Kind::Whole { default, .. } => default,
                Kind::Key => 0,
            };
        }
        Self { values, key: None }
    }
}

/// The row of a number.
pub fn find(number: u16) -> Option<(usize, &'static Setting)> {
    let place = NUMBERS.binary_search(&number).ok()?;
    SETTINGS.get(place).map(|setting| (place, setting))
}

impl Settings {
    /// A quantity.
    pub fn real(&self, key: Key<Real>) -> f32 {
        f32::from_bits(self.bits(key.place()))
    }

    /// A count or a choice.
    pub fn whole(&self, key: Key<Whole>) -> u32 {
        self.bits(key.place())
    }

    /// The numbers of the verdict: `verdict.call` and those after it, in their order.
    pub fn verdict(&self) -> VerdictConfig {
        let first = VERDICT_CALL.place();
        VerdictConfig::of(
            (first..)
                .zip(VerdictConfig::NUMBERS)
                .map(|(place, number)| {
                    let value = f32::from_bits(self.bits(place));
                    if value == number.usual as f32 {
                        // Not set: the usual one, with all its digits.
                        number.usual
                    } else {
                        f64::from(value)
                    }
                }),
        )
    }

    /// The key of the link, for the box itself.
    pub fn link_key(&self) -> Option<&LinkKey> {
        self.key.as_ref()
    }

    fn bits(&self, place: usize) -> u32 {
        // A key of the table stands in the table.
        self.values.get(place).copied().unwrap_or(0)
    }

    /// The value of a number, as it may be shown.
    pub fn get(&self, number: u16) -> Option<SettingValue> {
        let (place, setting) = find(number)?;
        Some(match setting.kind {
            Kind::Real { .. } => SettingValue::Real(f32::from_bits(self.bits(place))),
            Kind::Whole { .. } => SettingValue::Whole(self.bits(place)),
            Kind::Key => SettingValue::Hidden(self.key.is_some()),
        })
    }

    /// The value of a number, as it is stored; none for a key that is not set.
    pub fn to_store(&self, number: u16) -> Option<SettingValue> {
        match self.get(number)? {
            SettingValue::Hidden(_) => self.key.map(SettingValue::Key),
            shown => Some(shown),
        }
    }

    /// Sets one value; in force until the next reset, unless it is saved.
    ///
    /// # Errors
    /// Unknown, of the other kind, or out of range: nothing has changed.
    pub fn set(&mut self, number: u16, value: SettingValue) -> Result<(), SettingError> {
        let (place, setting) = find(number).ok_or(SettingError::Unknown)?;
        setting.check(value)?;
        let bits = match value {
            SettingValue::Real(x) => x.to_bits(),
            SettingValue::Whole(n) => n,
            SettingValue::Key(key) => {
                self.key = Some(key);
                return Ok(());
            }
            SettingValue::Hidden(_) => {
                self.key = None;
                return Ok(());
            }
        };
        if let Some(there) = self.values.get_mut(place) {
            *there = bits;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_the_verdict_stand_in_their_order() {
        // One number is another: a box is switched on beside a machine that idles.
        let of_a_box = VerdictConfig {
            unheard_idle_db: 10.0,
            ..VerdictConfig::default()
        };
        assert_eq!(Settings::default().verdict(), of_a_box);
        for (nth, number) in VerdictConfig::NUMBERS.iter().enumerate() {
            let row = &SETTINGS[VERDICT_CALL.place() + nth];
            let name = row.name.strip_prefix("verdict.").expect("a number's row");
            let name = name.chars().map(|c| if c == '-' { '_' } else { c });
            assert!(name.eq(number.name.chars()), "{}", row.name);
        }
    }
}
