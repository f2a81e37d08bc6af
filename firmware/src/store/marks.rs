//! A set of settings, by their places in the table.

use rarma_box::settings::{COUNT, SETTINGS, Setting};

const BITS: usize = 32;

/// A set of settings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Marks([u32; COUNT.div_ceil(BITS)]);

impl Marks {
    /// Adds the setting at a place of the table.
    pub fn add(&mut self, place: usize) {
        if let Some(word) = self.0.get_mut(place / BITS) {
            *word |= 1 << (place % BITS);
        }
    }

    /// Whether the setting at a place is in it.
    pub fn has(&self, place: usize) -> bool {
        let word = self.0.get(place / BITS).copied().unwrap_or(0);
        word >> (place % BITS) & 1 == 1
    }

    /// The settings in it, with their places.
    pub fn settings(&self) -> impl Iterator<Item = (usize, &'static Setting)> + '_ {
        SETTINGS
            .iter()
            .enumerate()
            .filter(|(place, _)| self.has(*place))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.settings().count()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|word| *word == 0)
    }
}
