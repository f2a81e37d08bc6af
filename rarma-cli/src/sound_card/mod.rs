//! A sound card as the source of a recording that has no end.
//!
//! * [`Tap`], [`Drain`]: from the audio thread to the monitor's, in bounded memory.
//! * [`Level`]: whether there is anything to be heard.
//! * [`choose`]: rate, channels and format out of what a card offers.
//! * [`Live`]: waits for samples, notices what goes wrong, records.
//! * [`open`], [`inputs`]: the card itself. They need the feature `sound-card`, all else does not.

#[cfg(feature = "sound-card")]
mod card;
mod level;
mod live;
mod offer;
mod ring;
mod watch;

pub use level::{FLOAT_BITS, Level, dbfs};
pub use live::{Card, Ended, Live, Signals};
pub use offer::{Choice, Form, Offer, choose, rate_warning, rates};
pub use ring::{Drain, Piece, Tap, Told, ring};

#[cfg(feature = "sound-card")]
pub use card::{inputs, open};

#[cfg(not(feature = "sound-card"))]
use crate::failure::Failure;

/// What is asked of a card.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Wish {
    /// Its name; none: the system's usual input.
    pub device: Option<String>,
    /// Sampling rate, Hz; none: 48 kHz or the nearest.
    pub rate_hz: Option<f64>,
    /// Channels that are listened to, counted from 0.
    pub channels: Vec<usize>,
}

/// An input there is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// The name by which it is asked for.
    pub name: String,
    /// What it is, for people.
    pub description: String,
    /// The system's usual one.
    pub usual: bool,
    /// What it offers, or why it cannot be opened now.
    pub offers: Result<Vec<Offer>, String>,
}

/// What a program without the feature says.
#[cfg(not(feature = "sound-card"))]
fn not_built() -> Failure {
    Failure::System(
        "listen: this program was built without sound cards (install libasound2-dev and pkg-config on Linux, then build it with `cargo build --release -p rarma-cli --features sound-card`)"
            .to_owned(),
    )
}

/// Opens an input.
///
/// # Errors
/// This program was built without sound cards.
#[cfg(not(feature = "sound-card"))]
pub fn open(_: &Wish) -> Result<Live, Failure> {
    Err(not_built())
}

/// The inputs there are.
///
/// # Errors
/// This program was built without sound cards.
#[cfg(not(feature = "sound-card"))]
pub fn inputs() -> Result<Vec<Input>, Failure> {
    Err(not_built())
}
