//! What the monitor believes has one name for each value: that of records and reports.
//!
//! With the feature `serde` a field is written by its name with `#[serde(with = "rarma_core::named")]`.
//! The types themselves are written as serde derives them: by number on a wire, by their Rust names in
//! the JSON of frames.

use crate::condition::{Fault, TachoFault};
use crate::decide::{Amplitude, ChannelFault, Label, Origin, Reason, State};
use crate::monitor::SpeedSource;

/// A value out of a fixed list, each with a name.
pub trait Named: Copy + PartialEq + 'static {
    /// All of them, in the order in which they are declared.
    const ALL: &'static [Self];
    /// Their names, in the same order.
    const NAMES: &'static [&'static str];

    /// The name in records.
    fn name(self) -> &'static str;

    /// The value of that name.
    fn of_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|one| one.name() == name)
    }
}

/// Gives the values of a type their names.
macro_rules! names {
    ($type:ident { $($one:ident $(($of:path))? = $name:literal),+ $(,)? }) => {
        impl Named for $type {
            const ALL: &'static [Self] = &[$(Self::$one $(($of))?),+];
            const NAMES: &'static [&'static str] = &[$($name),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$one $(($of))? => $name),+
                }
            }
        }
    };
}

names! { State {
    Starting = "starting",
    Idle = "idle",
    Stable = "stable",
    Warning = "warning",
    Chatter = "chatter",
    Invalid = "invalid",
} }

names! { Reason {
    None = "none",
    EstimatorStarting = "estimator-starting",
    RootsLost = "roots-lost",
    LevelAtIdle = "level-at-idle",
    Undamped = "undamped",
    LosingDamping = "losing-damping",
    ForcedOnly = "forced-only",
    OriginUnknown = "origin-unknown",
    Entering = "entering",
    Samples(Fault::NotFinite) = "samples-not-finite",
    Samples(Fault::Missing) = "samples-missing",
    Samples(Fault::Stuck) = "samples-stuck",
    Samples(Fault::Clipped) = "samples-clipped",
    BlindAtMultiple = "blind-at-multiple",
    Excited = "excited",
} }

names! { Label {
    SelfExcited = "self-excited",
    Structural = "structural",
    Forced = "forced",
} }

names! { Origin {
    Free = "free",
    Rotation = "rotation",
    Overtone = "overtone",
    Background = "background",
    Unknown = "unknown",
} }

names! { Amplitude {
    TooShort = "too-short",
    Forced = "forced",
    Suspicious = "suspicious",
    SelfExcited = "self-excited",
    NotStationary = "not-stationary",
} }

names! { SpeedSource {
    Unknown = "unknown",
    Told = "told",
    Sound = "sound",
    Tacho = "tacho",
} }

names! { TachoFault {
    Silent = "silent",
    Missing = "missing",
    Doubled = "doubled",
    Noisy = "noisy",
} }

names! { ChannelFault {
    Samples(Fault::NotFinite) = "not-finite",
    Samples(Fault::Missing) = "missing",
    Samples(Fault::Stuck) = "stuck",
    Samples(Fault::Clipped) = "clipped",
    Silent = "silent",
    Contradicts = "contradicts",
} }

#[cfg(feature = "serde")]
pub use by_name::{ByName, deserialize, serialize};

#[cfg(feature = "serde")]
mod by_name {
    use super::Named;
    use core::fmt;
    use core::marker::PhantomData;
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    /// Writes the name.
    ///
    /// # Errors
    /// Those of the writer.
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
    pub fn serialize<T: Named, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(value.name())
    }

    /// Reads a name.
    ///
    /// # Errors
    /// Those of the reader; a name that no value has.
    pub fn deserialize<'de, T: Named, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
        from.deserialize_str(Reader(PhantomData))
    }

    struct Reader<T>(PhantomData<T>);

    impl<T: Named> de::Visitor<'_> for Reader<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a name")
        }

        fn visit_str<E: de::Error>(self, name: &str) -> Result<T, E> {
            T::of_name(name).ok_or_else(|| E::unknown_variant(name, T::NAMES))
        }
    }

    /// Written by its name: for keys of maps and what else is no field.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub struct ByName<T>(pub T);

    impl<T: Named> Serialize for ByName<T> {
        fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
            serialize(&self.0, to)
        }
    }

    impl<'de, T: Named> Deserialize<'de> for ByName<T> {
        fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
            deserialize(from).map(Self)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn each_by_its_own<T: Named + core::fmt::Debug>(number: impl Fn(T) -> Option<usize>) {
        assert_eq!(T::ALL.len(), T::NAMES.len());
        for (n, (one, name)) in T::ALL.iter().zip(T::NAMES).enumerate() {
            assert_eq!((one.name(), T::of_name(name)), (*name, Some(*one)));
            assert!(number(*one).is_none_or(|number| number == n), "{one:?}");
        }
    }

    #[test]
    fn every_name_is_that_of_one_value_and_they_stand_in_order() {
        each_by_its_own(|one: State| Some(one as usize));
        each_by_its_own(|one: Label| Some(one as usize));
        each_by_its_own(|one: Origin| Some(one as usize));
        each_by_its_own(|one: Amplitude| Some(one as usize));
        each_by_its_own(|one: SpeedSource| Some(one as usize));
        each_by_its_own(|one: TachoFault| Some(one as usize));
        each_by_its_own(|_: Reason| None);
        each_by_its_own(|_: ChannelFault| None);
    }
}
