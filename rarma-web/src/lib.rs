//! The monitor behind the page in a browser (`page/`, docs/web.md).
//!
//! The same core, words, records and report as `rarma listen` and `rarma monitor`, compiled to
//! WebAssembly and called with numbers and places in memory ([`exports`]). One program, loaded
//! twice:
//!
//! * in the audio thread (AudioWorklet), a [`Session`] without pictures: the verdict at once,
//!   whatever the page does;
//! * in a worker, a [`Session`] with pictures and the report on the same samples, of the
//!   microphone or of a file.
//!
//! What a browser hides of its sound is found here: silence put in for what was lost
//! ([`Filler`]), and sound that never came ([`Clock`]).

mod clock;
mod ear;
pub mod exports;
mod file;
mod filler;
mod pictures;
mod session;
mod settings;
mod spectrum;
mod view;

pub use clock::Clock;
pub use ear::{Ear, Said};
pub use file::Opened;
pub use filler::{Filler, Piece};
pub use session::Session;
pub use settings::Settings;
pub use spectrum::Spectrum;
pub use view::{Gaps, Heard, InWords, LevelView, Point, Scale};
