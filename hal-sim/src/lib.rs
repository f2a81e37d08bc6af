//! Simulated hardware behind the firmware's board verbs. The machines that it is
//! connected to are a crate of their own, `rarma-plants`.
//!
//! * [`board`] a board that only listens, to a [`microphone`] that fails on demand;
//! * [`parts`] parts that speak embedded-hal;
//! * [`rig`] the whole box and its host, over a plant, with faults on demand;
//! * [`exciter`] the magnetic exciter calibrated and measured with, without the box.

pub mod board;
pub mod exciter;
pub mod microphone;
pub mod parts;
pub mod rig;

pub use board::{SimBoard, SimLink};
pub use microphone::{Microphone, MicrophoneFault};
pub use rig::{SimBox, SimHost, SimRig};
