//! The live screen of a terminal: what `monitor`, `listen` and `connect` show where somebody looks
//! on.
//!
//! * [`model`]: what is known, a plain value that readings and messages change.
//! * [`view`]: a model, drawn; no terminal in it.
//! * [`input_line`], [`keys`]: what is typed.
//! * [`terminal`]: the terminal itself, left as it was found however the program ends.
//! * [`live`]: the thread that draws. It looks at a copy of the model: whoever listens never waits
//!   for the terminal.
//!
//! It needs the feature `screen`; a browser has no terminal.

#[cfg(all(feature = "screen", not(target_family = "wasm")))]
mod input_line;
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
mod keys;
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
mod live;
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
mod model;
#[cfg(not(all(feature = "screen", not(target_family = "wasm"))))]
mod none;
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
mod spectrum;
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
mod terminal;
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
mod view;

#[cfg(all(feature = "screen", not(target_family = "wasm")))]
pub(crate) use live::{Leave, Screen, Sound, wanted};
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
pub(crate) use model::settings;
#[cfg(not(all(feature = "screen", not(target_family = "wasm"))))]
pub(crate) use none::{Leave, Screen, Sound, end_at_once, settings, wanted};
#[cfg(all(feature = "screen", not(target_family = "wasm")))]
pub(crate) use terminal::end_at_once;
