//! The whole box on simulated hardware: every verb of a [`BoxBoard`](firmware::BoxBoard)
//! over a plant, with faults on demand.
//!
//! Time goes on in periods of the current loop, 25 µs, and only in
//! [`wait`](firmware::BoxBoard::wait): what a pass of the main loop does takes none.

mod bar;
mod board;
mod bridge;
mod fault;
mod flash;
mod host;
mod link;
mod plant;
mod run;

pub use board::{RigSetUp, SimRig, Unreadable};
pub use bridge::SimBridge;
pub use fault::{FaultEvent, FaultKind};
pub use flash::{FlashError, SECTOR, SECTORS, SimFlash, WORD, WORD_BITS};
pub use host::{Heard, SimHost};
pub use link::{Noise, RigLink};
pub use plant::{Plant, RigConfig, Spoilt};
pub use run::SimBox;
