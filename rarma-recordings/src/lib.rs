//! Recordings in and out: sound, tables and measurements as files, each read whole or refused, each
//! written whole or not at all, with one line that says what, where, why and what to do.
//!
//! * [`input`]: WAV, CSV, raw floats, universal files, records of a box and what phones write
//!   (feature `codecs`) become samples; tables of speeds, loads, structures, receptances and ball bars
//!   become what they say.
//! * [`output`]: files that take their names when they are whole, recordings in the making.
//! * [`export`]: signals and spectra as CSV, universal file or MATLAB file.
//! * [`FrameReader`], [`raw_streams`]: the frames of a box, and the sound in them.
//! * [`one_line`]: a message stays one line, whatever it quotes.
//!
//! Nothing here knows a command line: an error is a value ([`input::InputError`],
//! [`output::WriteError`]), and what is only odd is handed to the caller.
//!
//! ```
//! use rarma_recordings::export::{self, Along, Column, Table};
//! use rarma_recordings::input::{self, ReadOptions};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("tone.csv");
//! let tone: Vec<f64> = (0..4800).map(|k| (0.2 * f64::from(k)).sin()).collect();
//! let table = Table {
//!     title: "a tone".into(),
//!     along: Along::Time { fs: 48_000.0 },
//!     columns: vec![Column {
//!         name: "microphone".into(),
//!         channel: 0,
//!         unit: "Pa".into(),
//!         values: tone.clone(),
//!     }],
//! };
//! export::write(&path, &table)?.keep()?;
//!
//! let read = input::read(&path, &ReadOptions::default())?;
//! assert_eq!((read.fs, read.samples), (48_000.0, tone));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod export;
mod frame_reader;
pub mod input;
pub mod one_line;
pub mod output;
pub mod raw_streams;
mod system;

pub use frame_reader::FrameReader;
pub use system::system_words;
