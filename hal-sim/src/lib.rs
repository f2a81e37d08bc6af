//! Simulated hardware behind the firmware's board verbs, and the plants it is
//! connected to. The plants know nothing of the firmware and can be used alone.

pub mod board;
pub mod exciter;
pub mod microphone;
pub mod parts;
pub mod plant;
pub mod population;
pub mod rig;

pub use board::{SimBoard, SimLink};
pub use microphone::{Microphone, MicrophoneFault};
pub use rig::{SimBox, SimHost, SimRig};
