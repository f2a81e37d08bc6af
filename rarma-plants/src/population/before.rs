//! What a box has heard before a cut begins: it listens for weeks, a recording of a cut begins where it begins.
//!
//! Everything is heard by the cut's own sensor, with its gain and its converter (what is too loud clips there, too), in the
//! cut's own room, while the spindle turns and nothing is cut.

use super::heard::Heard;
use super::room::Knock;
use super::{Cut, ranges as r};
use crate::PlantError;
use crate::converter::{Converter, ConverterConfig};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What was heard before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// The room.
    Air,
    /// The room, and something that is hit: a clamp, a door, a tool changer.
    Knock,
    /// The room, and compressed air.
    Jet,
    /// A dark hall, then the machine is switched on: its fans, pumps and drives.
    Night,
    /// The same cut, and the room after it.
    Cut,
}

/// The room is heard alone for so long, s: at first, and at the end.
const ROOM_S: (f64, f64) = (1.0, 2.0);
/// What is between them takes so long, s: a knock, a jet of compressed air, the night.
const KNOCK_S: f64 = 1.0;
const JET_S: f64 = 3.0;
const NIGHT_S: f64 = 5.0;

impl Before {
    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Air => "the room",
            Self::Knock => "a loud knock",
            Self::Jet => "compressed air",
            Self::Night => "a dark hall",
            Self::Cut => "the same cut",
        }
    }

    /// For how long before the cut's first sample nothing is cut, nor was a moment before, s.
    #[must_use]
    pub fn alone_s(self) -> f64 {
        match self {
            Self::Cut => ROOM_S.1 - super::SLACK_S,
            Self::Air | Self::Knock | Self::Jet | Self::Night => f64::INFINITY,
        }
    }

    /// Its samples at the cut's sensor, parts of full scale.
    ///
    /// # Errors
    /// What the plant refuses: a defect of the ranges.
    pub fn samples(self, cut: &Cut, heard: &Heard) -> Result<Vec<f32>, PlantError> {
        let mut rng = ChaCha8Rng::seed_from_u64(!cut.seed);
        let first_s = match self {
            Self::Air | Self::Knock => ROOM_S.0 + KNOCK_S,
            Self::Jet => ROOM_S.0 + JET_S,
            Self::Night => NIGHT_S,
            Self::Cut => 0.0,
        };
        let inner_hz = cut.sensor.inner_hz();
        let count = |s: f64| (s * inner_hz).round() as usize;
        let mut room = cut.room.before();
        match self {
            Self::Knock => room.knocks.push(Knock {
                at_s: ROOM_S.0,
                f_hz: r::KNOCKS.2.draw(&mut rng),
                zeta: r::KNOCKS.3.draw(&mut rng),
                peak_db: r::LOUD_KNOCK_DB,
            }),
            Self::Jet => room.jet = Some((ROOM_S.0, first_s, r::LOUD_JET_DB)),
            Self::Air | Self::Night | Self::Cut => {}
        }
        let reference = heard.reference;
        let mut sound = vec![0.0; count(first_s + ROOM_S.1)];
        if self == Self::Night {
            // A box's own noise is what is left of the room.
            let quiet = reference * 10f64.powf(r::NIGHT_DB / 20.0);
            let (night, day) = sound.split_at_mut(count(first_s));
            room.add_to(night, inner_hz, quiet);
            room.add_to(day, inner_hz, reference);
        } else {
            room.add_to(&mut sound, inner_hz, reference);
        }
        let config = ConverterConfig {
            full_scale: 1.0,
            bits: cut.sensor.bits,
            dither: true,
        };
        let mut converter = Converter::new(config, !cut.seed)?;
        let room = sound.into_iter().step_by(cut.sensor.folds);
        let room = room.map(|x| converter.convert(x).value);
        let first = match self {
            Self::Cut => heard.samples.clone(),
            _ => Vec::new(),
        };
        Ok(first.into_iter().chain(room).collect())
    }
}
