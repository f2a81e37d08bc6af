//! Where could an undamped vibration come from, if not from the cut itself?

/// What else explains a mode's vibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Origin {
    /// Nothing: without damping it is self-excited.
    #[default]
    Free,
    /// A multiple of the rotation; its number stands beside it.
    Rotation,
    /// The harmonic of a stronger line at a half or a third of its frequency. Nothing says so any
    /// more; frames and records of before have it.
    Overtone,
    /// A tone that was there at idle and has not grown since.
    Background,
    /// The speed is not known, or an odd multiple of half the tooth frequency is also
    /// one of the spindle's: a line there may be forced or self-excited. It counts as
    /// self-excited only if it has lost its damping while it was watched.
    Unknown,
}

impl Origin {
    /// Something else explains the vibration.
    pub fn explains(self) -> bool {
        matches!(self, Self::Rotation | Self::Overtone | Self::Background)
    }
}
