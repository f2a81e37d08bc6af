//! The sensor box: an application that is generic over a board.
//!
//! `board` names the verbs, `sensor_box` and its duties use them, `boards` supplies them
//! for one board each and is the only place with registers and unsafe code. `parts`
//! makes verbs of embedded-hal's traits. `job` is listening alone, to a recording.
#![cfg_attr(not(test), no_std)]
#![deny(unsafe_code)]

pub mod bar;
pub mod bits;
pub mod board;
pub mod boards;
mod commands;
mod control;
pub mod current_loop;
pub mod exciting;
pub mod job;
pub mod last_words;
pub mod listen;
pub mod listening_box;
pub mod microphones;
pub mod monitor;
pub mod notices;
pub mod parts;
pub mod rig;
pub mod sensor_box;
pub mod stand;
pub mod store;
pub mod tell;
mod visit;

pub use board::{Block, Board, BoardError, BoardErrorKind, BoxBoard, Clock};
pub use current_loop::CurrentLoop;
pub use job::{Job, Outcome};
pub use last_words::last_words;
pub use listening_box::ListeningBox;
pub use sensor_box::SensorBox;
